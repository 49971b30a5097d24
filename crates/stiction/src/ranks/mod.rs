//! Ranks: the parts of a computation that share no memory, and the messages between them.
//!
//! A computation is the same code on every rank, with [`Ranks`] as its parameter. [`Alone`] is the serial case, [`threads`]
//! runs several ranks in one process; a binding to MPI implements the trait outside of this crate. Messages are bytes.
//! Everything else is built on [`Ranks::exchange`] here, so that sums are added in one order whatever carries them.

mod alone;
mod counted;
mod halo;
mod threads;
mod wire;

use std::fmt;

pub use alone::Alone;
pub use counted::{Counted, Traffic};
pub use halo::Halo;
pub use threads::threads;
pub use wire::{Wire, from_bytes, put, take, to_bytes};

use crate::Error;

/// One of several ranks that run the same program. All of them make the same calls in the same order.
pub trait Ranks: fmt::Debug + Send + Sync {
    /// The number of this rank, from zero.
    fn rank(&self) -> usize;

    /// How many ranks there are.
    fn size(&self) -> usize;

    /// Sends each message of `out` to its rank and returns one message from each rank of `from`, in their order. Whom a rank
    /// names in `out` names it in `from`; nobody names a rank twice or itself.
    fn exchange(&self, out: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>>;

    /// Counts an exchange of values at the border of a mesh, of so many bytes sent. Only [`Counted`] does.
    fn count_halo(&self, _bytes: usize) {}

    /// Counts numbers of all ranks added or compared, for which every rank waits. Only [`Counted`] does.
    fn count_sum(&self) {}
}

/// A message of every rank, in their order, at rank 0; `None` at the others.
pub fn gather(ranks: &dyn Ranks, own: Vec<u8>) -> Option<Vec<Vec<u8>>> {
    if ranks.rank() > 0 {
        ranks.exchange(vec![(0, own)], &[]);
        return None;
    }
    let others: Vec<usize> = (1..ranks.size()).collect();
    let mut all = vec![own];
    all.extend(ranks.exchange(Vec::new(), &others));
    Some(all)
}

/// The message of rank 0 at every rank, along a binomial tree; what others give is not read.
pub fn broadcast(ranks: &dyn Ranks, own: Vec<u8>) -> Vec<u8> {
    let (rank, size) = (ranks.rank(), ranks.size());
    let mut message = own;
    let mut step = 1;
    while step < size {
        if rank < step {
            if rank + step < size {
                ranks.exchange(vec![(rank + step, message.clone())], &[]);
            }
        } else if rank < 2 * step {
            message = ranks.exchange(Vec::new(), &[rank - step]).swap_remove(0);
        }
        step *= 2;
    }
    message
}

/// A message of every rank, in their order, at every rank.
pub fn gather_all(ranks: &dyn Ranks, own: Vec<u8>) -> Vec<Vec<u8>> {
    let joined = gather(ranks, own).map_or(Vec::new(), |all| {
        let sizes: Vec<u64> = all.iter().map(|message| message.len() as u64).collect();
        let mut joined = to_bytes(&sizes);
        all.iter().for_each(|message| joined.extend_from_slice(message));
        joined
    });
    let joined = broadcast(ranks, joined);
    let head = 8 * ranks.size();
    let mut rest = &joined[head..];
    let sizes: Vec<u64> = from_bytes(&joined[..head]);
    let take = |size: u64| {
        let (message, after) = rest.split_at(size as usize);
        rest = after;
        message.to_vec()
    };
    sizes.into_iter().map(take).collect()
}

/// A message from each rank to each rank; those to and from itself included.
///
/// # Panics
/// If there is not one for each rank.
pub fn all_to_all(ranks: &dyn Ranks, mut out: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
    let (rank, size) = (ranks.rank(), ranks.size());
    assert_eq!(out.len(), size, "a message for each rank");
    let own = std::mem::take(&mut out[rank]);
    let others: Vec<usize> = (0..size).filter(|&other| other != rank).collect();
    let messages = out.into_iter().enumerate().filter(|(other, _)| *other != rank).collect();
    let mut received = ranks.exchange(messages, &others);
    received.insert(rank, own);
    received
}

/// Adds the numbers of all ranks, the same at every rank: pairs of neighbours first, so that the order of the additions is
/// that of the ranks whatever carries the messages.
pub fn sum(ranks: &dyn Ranks, values: &mut [f64]) {
    combine(ranks, values, |a, b| a + b);
}

/// The largest of the numbers of all ranks, each for itself.
pub fn max(ranks: &dyn Ranks, values: &mut [f64]) {
    combine(ranks, values, f64::max);
}

fn combine(ranks: &dyn Ranks, values: &mut [f64], with: impl Fn(f64, f64) -> f64) {
    let (rank, size) = (ranks.rank(), ranks.size());
    ranks.count_sum();
    let mut step = 1;
    while step < size {
        if rank % (2 * step) == step {
            ranks.exchange(vec![(rank - step, to_bytes(values))], &[]);
            break;
        }
        if rank + step < size {
            let message = ranks.exchange(Vec::new(), &[rank + step]).swap_remove(0);
            let other: Vec<f64> = from_bytes(&message);
            values.iter_mut().zip(other).for_each(|(a, b)| *a = with(*a, b));
        }
        step *= 2;
    }
    let all: Vec<f64> = from_bytes(&broadcast(ranks, to_bytes(values)));
    values.copy_from_slice(&all);
}

/// What every rank has found, if none has failed; otherwise the error of the least rank that has, at all of them.
///
/// # Errors
/// If some rank has one.
pub fn agree<T>(ranks: &dyn Ranks, found: Result<T, Error>) -> Result<T, Error> {
    let own = found.as_ref().err().map_or(Vec::new(), |error| {
        let parts = [&error.place, &error.what, &error.remedy, &error.excerpt].map(|part| part.as_bytes().to_vec());
        let sizes: Vec<u64> = parts.iter().map(|part| part.len() as u64).collect();
        [vec![u8::from(error.interrupted)], to_bytes(&sizes), parts.concat()].concat()
    });
    let all = gather_all(ranks, own);
    let Some(message) = all.iter().find(|message| !message.is_empty()) else { return found };
    let (sizes, mut rest) = message[1..].split_at(32);
    let mut part = |size: u64| {
        let (own, after) = rest.split_at(size as usize);
        rest = after;
        String::from_utf8_lossy(own).into_owned()
    };
    let [place, what, remedy, excerpt] = std::array::from_fn(|k| part(from_bytes::<u64>(sizes)[k]));
    Err(Error { place, what, remedy, excerpt, interrupted: message[0] == 1 })
}
