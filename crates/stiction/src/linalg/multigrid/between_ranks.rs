//! Rows of blocks between ranks: those of ghosts, and contributions to the rows of others.

use std::sync::Arc;

use super::blocks::{Block, Blocks};
use super::coarsen::{Coarser, Kernel};
use crate::ranks::{Halo, Ranks, Wire, from_bytes, gather_all, to_bytes};

/// A row with global columns.
pub(super) type Entries<const R: usize, const C: usize> = Vec<(u64, Block<R, C>)>;

/// Appends a row to a message.
fn pack<'a, const R: usize, const C: usize>(row: impl Iterator<Item = (u64, &'a Block<R, C>)>, to: &mut Vec<u8>) {
    let head = to.len();
    0u32.write(to);
    let mut count = 0u32;
    for (column, block) in row {
        column.write(to);
        block.write(to);
        count += 1;
    }
    to[head..head + 4].copy_from_slice(&count.to_le_bytes());
}

/// The rows of a message.
fn unpack<const R: usize, const C: usize>(mut bytes: &[u8]) -> Vec<Entries<R, C>> {
    let mut rows = Vec::new();
    let entry = 8 + Block::<R, C>::SIZE;
    while !bytes.is_empty() {
        let (row, rest) = bytes[4..].split_at(u32::read(bytes) as usize * entry);
        rows.push(row.chunks_exact(entry).map(|e| (u64::read(e), Block::read(&e[8..]))).collect());
        bytes = rest;
    }
    rows
}

/// The rows at the ghosts of `halo` of a matrix whose columns have the global numbers `global`.
pub(super) fn ghost_rows<const R: usize, const C: usize>(
    halo: &Halo,
    a: &Blocks<R, C>,
    global: impl Fn(u32) -> u64,
) -> Vec<Entries<R, C>> {
    let (receive, send) = halo.neighbours();
    let message = |places: &[u32]| {
        let mut bytes = Vec::new();
        places.iter().for_each(|&i| pack(a.entries_of(i as usize).map(|(j, b)| (global(j), b)), &mut bytes));
        bytes
    };
    let out = send.iter().map(|(rank, places)| (*rank, message(places))).collect();
    let from: Vec<usize> = receive.iter().map(|(rank, _)| *rank).collect();
    halo.ranks().exchange(out, &from).iter().flat_map(|bytes| unpack(bytes)).collect()
}

/// What other ranks have found for own rows: `a` has rows for the ghosts of `halo` as well, which are sent to their owners.
/// In the order of the ranks, with the place of each row.
pub(super) fn returned_rows<const R: usize, const C: usize>(
    halo: &Halo,
    a: &Blocks<R, C>,
    global: impl Fn(u32) -> u64,
) -> Vec<(u32, Entries<R, C>)> {
    let (receive, send) = halo.neighbours();
    let message = |rows: std::ops::Range<usize>| {
        let mut bytes = Vec::new();
        rows.for_each(|i| pack(a.entries_of(i).map(|(j, b)| (global(j), b)), &mut bytes));
        bytes
    };
    let out = receive.iter().map(|(rank, rows)| (*rank, message(rows.clone()))).collect();
    let from: Vec<usize> = send.iter().map(|(rank, _)| *rank).collect();
    let received = halo.ranks().exchange(out, &from);
    let rows = send.iter().zip(&received);
    rows.flat_map(|((_, places), bytes)| places.iter().copied().zip(unpack(bytes))).collect()
}

/// The same matrix with its columns numbered anew.
pub(super) fn renumbered<const R: usize, const C: usize>(
    a: &Blocks<R, C>,
    cols: usize,
    place: impl Fn(u32) -> u32,
) -> Blocks<R, C> {
    let mut new = Blocks { rows: a.rows, cols, start: a.start.clone(), column: Vec::new(), value: Vec::new() };
    for i in 0..a.rows {
        let mut row: Vec<(u32, &Block<R, C>)> = a.entries_of(i).map(|(j, block)| (place(j), block)).collect();
        row.sort_unstable_by_key(|entry| entry.0);
        new.column.extend(row.iter().map(|entry| entry.0));
        new.value.extend(row.iter().map(|entry| *entry.1));
    }
    new
}

/// A matrix with so many rows, each the sum of those given for it, in their order.
pub(super) fn summed<const R: usize, const C: usize>(
    rows: usize,
    cols: usize,
    parts: &[Vec<(u32, Block<R, C>)>],
    of_row: &[Vec<u32>],
) -> Blocks<R, C> {
    let named = |i: usize, name: &mut dyn FnMut(u32)| {
        of_row[i].iter().for_each(|&part| parts[part as usize].iter().for_each(|(j, _)| name(*j)));
    };
    Blocks::from_rows(rows, cols, named, |i, row| {
        for &part in &of_row[i] {
            for (j, block) in &parts[part as usize] {
                let target = row.at(*j).iter_mut().flatten();
                target.zip(block.iter().flatten()).for_each(|(a, b)| *a += b);
            }
        }
    })
}

/// The coarse level of a step that is divided among ranks, complete on each of them.
pub(super) fn joined<const R: usize>(step: Coarser<R>, ranks: &Arc<dyn Ranks>) -> Coarser<R> {
    let Coarser { prolongation, a_times_p, matrix, kernel, halo } = step;
    let mut message = Vec::new();
    (0..matrix.rows).for_each(|i| pack(matrix.entries_of(i).map(|(j, b)| (halo.global(j as usize), b)), &mut message));
    let rows: Vec<Entries<6, 6>> = gather_all(&**ranks, message).iter().flat_map(|bytes| unpack(bytes)).collect();
    let kernel: Vec<Kernel<6>> =
        gather_all(&**ranks, to_bytes(&kernel)).iter().flat_map(|bytes| from_bytes::<Kernel<6>>(bytes)).collect();
    let total = rows.len();
    let local = |row: Entries<6, 6>| row.into_iter().map(|(j, block)| (j as u32, block)).collect();
    let parts: Vec<Vec<(u32, Block<6, 6>)>> = rows.into_iter().map(local).collect();
    let own: Vec<Vec<u32>> = (0..total as u32).map(|i| vec![i]).collect();
    let global = |j: u32| halo.global(j as usize) as u32;
    Coarser {
        prolongation: renumbered(&prolongation, total, global),
        a_times_p: renumbered(&a_times_p, total, global),
        matrix: summed(total, total, &parts, &own),
        kernel,
        halo: Halo::joined(ranks, total),
    }
}

/// Rows of a level that change, by the ranks that find what they change by: `touched` are the own ones that some rank adds
/// to, on a level that is joined those of all ranks, and `reach` the same with the ghosts that this rank adds to. Both ascend.
#[derive(Debug, Clone)]
pub(super) struct Reach {
    pub reach: Vec<u32>,
    pub touched: Vec<u32>,
    halo: Halo,
    /// For each rank this one adds to, places in `reach`; none on a level that is joined.
    send: Vec<Vec<u32>>,
    /// For each rank that adds to own values, places in `touched`; on a level that is joined for all of them.
    receive: Vec<Vec<u32>>,
    /// Own values in `reach`, and their places in `touched`.
    own: Vec<(u32, u32)>,
}

impl Default for Reach {
    fn default() -> Self {
        Reach::new(&Halo::alone(0), Vec::new())
    }
}

fn ascending(mut list: Vec<u32>) -> Vec<u32> {
    list.sort_unstable();
    list.dedup();
    list
}

impl Reach {
    pub(super) fn new(halo: &Halo, reach: Vec<u32>) -> Reach {
        let place = |touched: &[u32], k: u32| touched.partition_point(|&t| t < k) as u32;
        if halo.is_alone() {
            let (halo, touched) = (halo.clone(), reach.clone());
            return Reach { reach, touched, halo, send: Vec::new(), receive: Vec::new(), own: Vec::new() };
        }
        if halo.is_joined() {
            let lists = gather_all(&**halo.ranks(), to_bytes(&reach));
            let touched = ascending(lists.iter().flat_map(|bytes| from_bytes::<u32>(bytes)).collect());
            let all: Vec<u32> = (0..touched.len() as u32).collect();
            let (send, receive) = (Vec::new(), vec![all; halo.ranks().size()]);
            return Reach { reach: touched.clone(), touched, halo: halo.clone(), send, receive, own: Vec::new() };
        }
        let (owners, askers) = halo.neighbours();
        let of = |reach: &[u32], range: &std::ops::Range<usize>| -> Vec<u32> {
            (0..reach.len() as u32).filter(|&t| range.contains(&(reach[t as usize] as usize))).collect()
        };
        let global =
            |list: Vec<u32>| -> Vec<u64> { list.iter().map(|&t| halo.global(reach[t as usize] as usize)).collect() };
        let out = owners.iter().map(|(rank, range)| (*rank, to_bytes(&global(of(&reach, range))))).collect();
        let from: Vec<usize> = askers.iter().map(|(rank, _)| *rank).collect();
        let own_place = |g: u64| halo.place(g).expect("an own value of this rank") as u32;
        let lists: Vec<Vec<u32>> = (halo.ranks().exchange(out, &from).iter())
            .map(|bytes| from_bytes::<u64>(bytes).into_iter().map(own_place).collect())
            .collect();
        let inside = reach.iter().copied().filter(|&k| (k as usize) < halo.own());
        let touched = ascending(inside.chain(lists.concat()).collect());
        // What the owner alone knows of a row it adds even where it finds nothing else.
        let reach = ascending([reach, touched.clone()].concat());
        let send = owners.iter().map(|(_, range)| of(&reach, range)).collect();
        let receive = lists.iter().map(|list| list.iter().map(|&k| place(&touched, k)).collect()).collect();
        // Own values come before ghosts.
        let own = (0..touched.len() as u32).map(|t| (t, t)).collect();
        Reach { reach, touched, halo: halo.clone(), send, receive, own }
    }

    /// The same level with other places that this rank adds to, all of them among those that were touched, and what is added divided
    /// by `halo`.
    pub(super) fn within(&self, halo: &Halo, reach: Vec<u32>) -> Reach {
        let mut other = Reach::new(halo, reach);
        let touched = std::mem::take(&mut other.touched);
        let moved = |t: &mut u32| *t = self.touched.partition_point(|&k| k < touched[*t as usize]) as u32;
        other.receive.iter_mut().flatten().for_each(moved);
        other.own.iter_mut().for_each(|(_, t)| moved(t));
        other.touched.clone_from(&self.touched);
        other
    }

    /// The place in `touched` of the row at place `t` of `reach`, if what is known of it once is known on this rank: on the
    /// owner of the row, and on rank 0 of a level that is joined.
    pub(super) fn owned(&self, t: usize) -> Option<usize> {
        let halo = &self.halo;
        if halo.is_alone() {
            return Some(t);
        }
        if halo.is_joined() {
            return (halo.ranks().rank() == 0).then(|| self.receive[0][t] as usize);
        }
        self.own.binary_search_by_key(&(t as u32), |own| own.0).ok().map(|k| self.own[k].1 as usize)
    }

    /// Rows for `touched` from rows for `reach`, those of other ranks added.
    pub(super) fn rows<const C: usize>(&self, rows: Blocks<C, C>) -> Blocks<C, C> {
        let halo = &self.halo;
        if halo.is_alone() {
            return rows;
        }
        let mut parts: Vec<Vec<(u32, Block<C, C>)>> = Vec::new();
        let mut of_row = vec![Vec::new(); self.touched.len()];
        let mut take = |t: u32, row: Vec<(u32, Block<C, C>)>| {
            of_row[t as usize].push(parts.len() as u32);
            parts.push(row);
        };
        let global = |j: u32| halo.global(j as usize);
        let message = |list: &mut dyn Iterator<Item = u32>| {
            let mut bytes = Vec::new();
            list.for_each(|t| pack(rows.entries_of(t as usize).map(|(j, b)| (global(j), b)), &mut bytes));
            bytes
        };
        let received = if halo.is_joined() {
            gather_all(&**halo.ranks(), message(&mut (0..self.reach.len() as u32)))
        } else {
            for &(t, to) in &self.own {
                take(to, rows.entries_of(t as usize).map(|(j, block)| (j, *block)).collect());
            }
            let (owners, askers) = halo.neighbours();
            let lists = owners.iter().zip(&self.send);
            let out = lists.map(|((rank, _), list)| (*rank, message(&mut list.iter().copied()))).collect();
            let from: Vec<usize> = askers.iter().map(|(rank, _)| *rank).collect();
            halo.ranks().exchange(out, &from)
        };
        for (places, bytes) in self.receive.iter().zip(&received) {
            for (&t, row) in places.iter().zip(unpack::<C, C>(bytes)) {
                // The change lies within the pattern of the matrix, whose columns are all here.
                take(t, row.into_iter().filter_map(|(j, b)| Some((halo.place(j)? as u32, b))).collect());
            }
        }
        summed(self.touched.len(), halo.len(), &parts, &of_row)
    }

    /// The same for one value a row.
    pub(super) fn values<T: Wire>(&self, values: Vec<T>, zero: T, add: impl Fn(&mut T, &T)) -> Vec<T> {
        let halo = &self.halo;
        if halo.is_alone() {
            return values;
        }
        let mut sums = vec![zero; self.touched.len()];
        let received = if halo.is_joined() {
            gather_all(&**halo.ranks(), to_bytes(&values))
        } else {
            self.own.iter().for_each(|&(t, to)| add(&mut sums[to as usize], &values[t as usize]));
            let (owners, askers) = halo.neighbours();
            let message = |list: &[u32]| to_bytes(&list.iter().map(|&t| values[t as usize]).collect::<Vec<T>>());
            let out = owners.iter().zip(&self.send).map(|((rank, _), list)| (*rank, message(list))).collect();
            let from: Vec<usize> = askers.iter().map(|(rank, _)| *rank).collect();
            halo.ranks().exchange(out, &from)
        };
        for (places, bytes) in self.receive.iter().zip(&received) {
            places.iter().zip(from_bytes::<T>(bytes)).for_each(|(&t, value)| add(&mut sums[t as usize], &value));
        }
        sums
    }

    /// Values for `reach` from those for `touched`, which their owners have.
    pub(super) fn back<T: Wire>(&self, values: &[T], zero: T) -> Vec<T> {
        let halo = &self.halo;
        if halo.is_alone() {
            return values.to_vec();
        }
        let mut found = vec![zero; self.reach.len()];
        if halo.is_joined() {
            let own = &self.receive[halo.ranks().rank()];
            found.iter_mut().zip(own).for_each(|(found, &t)| *found = values[t as usize]);
            return found;
        }
        self.own.iter().for_each(|&(t, from)| found[t as usize] = values[from as usize]);
        let (owners, askers) = halo.neighbours();
        let message = |list: &[u32]| to_bytes(&list.iter().map(|&t| values[t as usize]).collect::<Vec<T>>());
        let out = askers.iter().zip(&self.receive).map(|((rank, _), list)| (*rank, message(list))).collect();
        let from: Vec<usize> = owners.iter().map(|(rank, _)| *rank).collect();
        for (list, bytes) in self.send.iter().zip(halo.ranks().exchange(out, &from)) {
            list.iter().zip(from_bytes::<T>(&bytes)).for_each(|(&t, value)| found[t as usize] = value);
        }
        found
    }
}
