use std::borrow::Cow;
use std::sync::Arc;

use super::{Alone, Ranks, Wire, all_to_all, from_bytes, gather_all, max, sum, to_bytes};

/// How values are divided among ranks, and the plan of the messages that this takes.
///
/// Each rank owns a consecutive range of global numbers, which may be empty. In its vectors the own values come first, then its
/// ghosts: copies of values of other ranks that it needs, in the order of their numbers.
#[derive(Debug, Clone)]
pub struct Halo {
    ranks: Arc<dyn Ranks>,
    kind: Kind,
    /// Values of this rank.
    own: usize,
    /// Global number of the first of them.
    first: u64,
    /// Global numbers of the ghosts, ascending.
    ghosts: Vec<u64>,
    /// Own values that other ranks have as ghosts, by rank.
    send: Vec<(usize, Vec<u32>)>,
    /// Places of the ghosts, by the rank that owns them.
    receive: Vec<(usize, Vec<u32>)>,
}

/// Another rank, and places here of values that are exchanged with it.
pub(crate) type Shared = (usize, Vec<u32>);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// All values are here and nowhere else, or each rank computes all of them by itself.
    Alone,
    /// Own values and ghosts.
    Divided,
}

impl Halo {
    /// All of so many values on one rank, or on each by itself.
    pub fn alone(own: usize) -> Halo {
        Halo::with(Arc::new(Alone), Kind::Alone, own)
    }

    fn with(ranks: Arc<dyn Ranks>, kind: Kind, own: usize) -> Halo {
        Halo { ranks, kind, own, first: 0, ghosts: Vec::new(), send: Vec::new(), receive: Vec::new() }
    }

    /// Of a rank that owns `own` values; `ghosts` are given by the numbers that `first` of the owners begin with.
    ///
    /// # Panics
    /// If a ghost is an own value or beyond the last one, or they do not ascend.
    pub fn divided(ranks: &Arc<dyn Ranks>, own: usize, ghosts: Vec<u64>) -> Halo {
        if ranks.size() == 1 {
            return Halo::alone(own);
        }
        let starts = starts(&**ranks, own);
        let (rank, size) = (ranks.rank(), ranks.size());
        assert!(ghosts.is_sorted_by(|a, b| a < b), "ghosts ascend");
        let mut receive = Vec::new();
        let mut wanted = vec![Vec::new(); size];
        for other in 0..size {
            let place = |bound: u64| ghosts.partition_point(|&g| g < bound);
            let range = place(starts[other])..place(starts[other + 1]);
            if !range.is_empty() {
                assert!(other != rank, "an own value is no ghost");
                wanted[other] = to_bytes(&ghosts[range.clone()]);
                receive.push((other, range.map(|k| (own + k) as u32).collect()));
            }
        }
        let asked = all_to_all(&**ranks, wanted);
        let first = starts[rank];
        let places = |message: &Vec<u8>| from_bytes::<u64>(message).iter().map(|g| (g - first) as u32).collect();
        let send = asked.iter().enumerate().filter(|(_, m)| !m.is_empty()).map(|(other, m)| (other, places(m)));
        Halo { send: send.collect(), first, ghosts, receive, ..Halo::with(Arc::clone(ranks), Kind::Divided, own) }
    }

    /// The ranks.
    pub fn ranks(&self) -> &Arc<dyn Ranks> {
        &self.ranks
    }

    /// Whether no message is ever sent.
    pub fn is_alone(&self) -> bool {
        self.kind == Kind::Alone
    }

    /// Whether the values are divided among several ranks.
    pub fn is_divided(&self) -> bool {
        self.kind == Kind::Divided
    }

    /// The same values with other ghosts, by their global numbers in any order; own values are left out.
    #[must_use]
    pub fn with_other_ghosts(&self, numbers: impl Iterator<Item = u64>) -> Halo {
        let own = self.first..self.first + self.own as u64;
        let mut ghosts: Vec<u64> = numbers.filter(|g| !own.contains(g)).collect();
        ghosts.sort_unstable();
        ghosts.dedup();
        Halo::divided(&self.ranks, self.own, ghosts)
    }

    /// The same values between the ranks that own some: the others have no ghosts.
    #[must_use]
    pub fn among_owners(&self) -> Halo {
        self.with_other_ghosts(self.ghosts.iter().copied().filter(|_| self.own > 0))
    }

    /// Number of own values.
    pub fn own(&self) -> usize {
        self.own
    }

    /// Number of all values here.
    pub fn len(&self) -> usize {
        self.own + self.ghosts.len()
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The global number of the first own value, or of the next rank's where there is none.
    pub fn first(&self) -> u64 {
        self.first
    }

    /// The global number of a value here.
    pub fn global(&self, place: usize) -> u64 {
        if place < self.own { self.first + place as u64 } else { self.ghosts[place - self.own] }
    }

    /// The place here of a global number; `None` if it is not here.
    pub fn place(&self, global: u64) -> Option<usize> {
        match global.checked_sub(self.first) {
            Some(place) if place < self.own as u64 => Some(place as usize),
            _ => self.ghosts.binary_search(&global).ok().map(|k| self.own + k),
        }
    }

    /// The ranks that own ghosts, with their places here, and those that have own values as ghosts, with their places.
    pub(crate) fn neighbours(&self) -> (&[Shared], &[Shared]) {
        (&self.receive, &self.send)
    }

    /// The same values in the same places, of which no other ghosts are exchanged than those among the places `needed`.
    #[must_use]
    pub fn only(&self, needed: impl Iterator<Item = u32>) -> Halo {
        let mut part = self.clone();
        if self.kind == Kind::Alone {
            return part;
        }
        let mut is_needed = vec![false; self.len()];
        needed.for_each(|k| is_needed[k as usize] = true);
        part.receive.iter_mut().for_each(|(_, places)| places.retain(|&k| is_needed[k as usize]));
        let kept = |(rank, places): &Shared| {
            (*rank, to_bytes(&places.iter().map(|&k| self.global(k as usize)).collect::<Vec<u64>>()))
        };
        let from: Vec<usize> = self.send.iter().map(|(rank, _)| *rank).collect();
        let asked = self.ranks.exchange(part.receive.iter().map(kept).collect(), &from);
        for ((_, places), message) in part.send.iter_mut().zip(asked) {
            *places = from_bytes::<u64>(&message).iter().map(|g| (g - self.first) as u32).collect();
        }
        part.receive.retain(|(_, places)| !places.is_empty());
        part.send.retain(|(_, places)| !places.is_empty());
        part
    }

    /// The exchange of these own values of each rank; all ranks make it together.
    pub(crate) fn of_flagged(&self, own: &[u32]) -> Halo {
        let mut flags = vec![0u8; self.own()];
        own.iter().for_each(|&i| flags[i as usize] = 1);
        self.update(&mut flags);
        self.only((0..flags.len() as u32).filter(|&k| flags[k as usize] == 1))
    }

    /// Sets the ghosts, which are appended where there are own values alone; those that are not exchanged are zero.
    pub fn update<T: Wire>(&self, x: &mut Vec<T>) {
        if self.kind == Kind::Alone {
            return;
        }
        let out = self.send.iter().map(|shared| message(x, shared)).collect();
        let received = self.exchange(out, self.receive.iter().map(|(rank, _)| *rank).collect());
        x.truncate(self.own);
        x.resize(self.len(), T::read(&vec![0; T::SIZE]));
        for ((_, places), bytes) in self.receive.iter().zip(&received) {
            places.iter().zip(bytes.chunks_exact(T::SIZE)).for_each(|(&k, value)| x[k as usize] = T::read(value));
        }
    }

    /// The own values with the ghosts behind them.
    pub fn extended<'a, T: Wire>(&self, own: &'a [T]) -> Cow<'a, [T]> {
        if self.kind == Kind::Alone {
            return Cow::Borrowed(own);
        }
        let mut all = own.to_vec();
        self.update(&mut all);
        Cow::Owned(all)
    }

    /// Adds what ranks have found for values of others, in the order of the ranks, and leaves the own values.
    pub fn add<T: Wire>(&self, x: &mut Vec<T>, add: impl Fn(&mut T, &T)) {
        if self.kind == Kind::Alone {
            return;
        }
        let out = self.receive.iter().map(|shared| message(x, shared)).collect();
        let received = self.exchange(out, self.send.iter().map(|(rank, _)| *rank).collect());
        x.truncate(self.own);
        for ((_, places), bytes) in self.send.iter().zip(&received) {
            let values = bytes.chunks_exact(T::SIZE).map(T::read);
            places.iter().zip(values).for_each(|(&k, value)| add(&mut x[k as usize], &value));
        }
    }

    /// An exchange of values, which is none where nobody has anything to do with this rank.
    fn exchange(&self, out: Vec<(usize, Vec<u8>)>, from: Vec<usize>) -> Vec<Vec<u8>> {
        if out.is_empty() && from.is_empty() {
            return Vec::new();
        }
        self.ranks.count_halo(out.iter().map(|(_, bytes)| bytes.len()).sum());
        self.ranks.exchange(out, &from)
    }

    /// Adds the numbers of all ranks, where the values are divided.
    pub fn sum(&self, values: &mut [f64]) {
        if self.kind == Kind::Divided {
            sum(&*self.ranks, values);
        }
    }

    /// The largest of the numbers of all ranks, where the values are divided.
    pub fn max(&self, values: &mut [f64]) {
        if self.kind == Kind::Divided {
            max(&*self.ranks, values);
        }
    }

    /// Whether it is so on some rank.
    pub fn any(&self, here: bool) -> bool {
        let mut values = [f64::from(u8::from(here))];
        self.max(&mut values);
        values[0] > 0.0
    }

    /// Number of own values of all ranks together.
    pub fn total(&self) -> usize {
        let mut total = [self.own as f64];
        self.sum(&mut total);
        total[0] as usize
    }
}

/// A message of the values at shared places.
fn message<T: Wire>(x: &[T], (rank, places): &Shared) -> (usize, Vec<u8>) {
    let mut bytes = Vec::with_capacity(places.len() * T::SIZE);
    places.iter().for_each(|&k| x[k as usize].write(&mut bytes));
    (*rank, bytes)
}

/// The first number of each rank that owns `own` values, and the end.
fn starts(ranks: &dyn Ranks, own: usize) -> Vec<u64> {
    let counts = gather_all(ranks, to_bytes(&[own as u64]));
    let mut starts = vec![0];
    counts.iter().for_each(|count| starts.push(starts[starts.len() - 1] + u64::read(count)));
    starts
}

#[cfg(test)]
mod tests {
    use super::super::{Counted, agree, broadcast, threads};
    use super::*;
    use crate::Error;

    /// A ring of numbers, each coupled to both of its neighbours.
    #[test]
    fn ghosts_are_the_values_of_their_owners_and_contributions_reach_them() {
        for size in [2, 3, 5] {
            let total = 4 * size as u64;
            let found = threads(size, |ranks| {
                let counted = Arc::new(Counted::new(ranks));
                let ranks: Arc<dyn Ranks> = counted.clone();
                let first = 4 * ranks.rank() as u64;
                let mut ghosts = vec![(first + total - 1) % total, (first + 4) % total];
                ghosts.sort_unstable();
                let halo = Halo::divided(&ranks, 4, ghosts);
                let mut x: Vec<f64> = (0..4).map(|k| (first + k) as f64).collect();
                halo.update(&mut x);
                let right = (4..6).all(|k| x[k] == halo.global(k) as f64);
                let mut ones = vec![1.0; 6];
                halo.add(&mut ones, |a, b| *a += b);
                // Two exchanges of two numbers each.
                (right, ones, halo.total(), counted.traffic().halo_bytes)
            });
            for (right, ones, all, bytes) in found {
                assert!(right && ones == [2.0, 1.0, 1.0, 2.0] && all == 4 * size && bytes == 32, "{ones:?} {bytes}");
            }
        }
    }

    /// Every other rank waits; all have the values of everybody else as ghosts.
    #[test]
    fn ranks_without_values_have_ghosts_of_those_with_some_and_only_what_is_needed_is_sent() {
        let size = 5;
        let found = threads(size, |ranks| {
            let counted = Arc::new(Counted::new(ranks));
            let ranks: Arc<dyn Ranks> = counted.clone();
            let rank = ranks.rank() as u64;
            let own = if rank.is_multiple_of(2) { 0..0 } else { 2 * (rank - 1)..2 * (rank + 1) };
            let ghosts = (0..8).filter(|g| !own.contains(g)).collect();
            let halo = Halo::divided(&ranks, own.clone().count(), ghosts);
            let mut x: Vec<u64> = own.clone().map(|g| g + 1).collect();
            halo.update(&mut x);
            let right = (0..8).all(|k| x[k] == halo.global(k) + 1 && halo.place(halo.global(k)) == Some(k));
            let mut ones = vec![1u64; 8];
            halo.add(&mut ones, |a, b| *a += b);
            // Everybody gives one, the owner as well.
            let added = ones.len() == own.clone().count() && ones.iter().all(|&x| x == size as u64);
            let part = halo.only((0..8).filter(|&k| halo.global(k as usize).is_multiple_of(4)));
            let before = counted.traffic().halo_bytes;
            part.update(&mut x);
            let needed = |k: usize| k < part.own() || part.global(k).is_multiple_of(4);
            let some = (0..8).all(|k| x[k] == if needed(k) { part.global(k) + 1 } else { 0 });
            let sent = counted.traffic().halo_bytes - before;
            let owners = halo.among_owners();
            let between = if own.is_empty() { owners.is_empty() } else { owners.len() == 8 };
            owners.update(&mut x);
            (right && added && some && between && x.len() == owners.len(), sent, halo.total())
        });
        for (rank, (right, sent, total)) in found.into_iter().enumerate() {
            // One of the four values of an owner is needed by each of the four others.
            let bytes = if rank % 2 == 0 { 0 } else { 4 * 8 };
            assert!(right && sent == bytes && total == 8, "{rank}: {sent} {total}");
        }
    }

    #[test]
    fn sums_have_the_same_bits_on_every_rank_and_in_every_run() {
        let value = |rank: usize| [1e16, 1.0, -1e16, 3.0, 0.1, 0.7, 1e-3][rank];
        for size in 1..8 {
            let run = || {
                threads(size, |ranks| {
                    let mut x = [value(ranks.rank()), -value(ranks.rank())];
                    sum(&*ranks, &mut x);
                    let mut largest = [value(ranks.rank())];
                    max(&*ranks, &mut largest);
                    (x.map(f64::to_bits), largest[0])
                })
            };
            let (first, again) = (run(), run());
            assert!(first == again && first.iter().all(|x| *x == first[0]), "{first:?}");
            assert_eq!(first[0].1, 1e16);
        }
    }

    #[test]
    fn everybody_hears_the_error_of_the_least_rank_and_what_rank_0_says() {
        let found = threads(4, |ranks| {
            assert_eq!(broadcast(&*ranks, vec![ranks.rank() as u8; 5]), [0; 5]);
            let fails = ranks.rank() % 2 == 1;
            let found = if fails { Err(Error::new("here", ranks.rank().to_string(), "none")) } else { Ok(()) };
            (agree(&*ranks, Ok(7)), agree(&*ranks, found))
        });
        for (right, wrong) in found {
            assert_eq!(right, Ok(7));
            assert_eq!(wrong, Err(Error::new("here", "1", "none")));
        }
    }
}
