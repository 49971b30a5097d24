//! Rows of blocks between ranks: those of ghosts, and contributions to the rows of others.

use std::collections::BTreeMap;

use super::blocks::{Block, Blocks, grow};
use super::coarsen::{Coarser, Kernel};
use crate::ranks::{Halo, Wire, from_bytes, to_bytes};

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

/// The rows at the ghosts of `halo` of a matrix, by its own rows.
pub(super) fn ghost_rows<const R: usize, const C: usize>(
    halo: &Halo,
    row: impl Fn(u32) -> Entries<R, C>,
) -> Vec<Entries<R, C>> {
    let (receive, send) = halo.neighbours();
    let message = |places: &[u32]| {
        let mut bytes = Vec::new();
        places.iter().for_each(|&i| pack(row(i).iter().map(|(j, block)| (*j, block)), &mut bytes));
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
    let message = |rows: &[u32]| {
        let mut bytes = Vec::new();
        rows.iter().for_each(|&i| pack(a.entries_of(i as usize).map(|(j, b)| (global(j), b)), &mut bytes));
        bytes
    };
    let out = receive.iter().map(|(rank, rows)| (*rank, message(rows))).collect();
    let from: Vec<usize> = send.iter().map(|(rank, _)| *rank).collect();
    let received = halo.ranks().exchange(out, &from);
    let rows = send.iter().zip(&received);
    rows.flat_map(|((_, places), bytes)| places.iter().copied().zip(unpack(bytes))).collect()
}

/// The same matrix with its columns numbered anew, in the memory it has.
pub(super) fn renumbered<const R: usize, const C: usize>(
    mut a: Blocks<R, C>,
    cols: usize,
    place: impl Fn(u32) -> u32,
) -> Blocks<R, C> {
    a.cols = cols;
    a.column.iter_mut().for_each(|j| *j = place(*j));
    let mut row: Vec<(u32, Block<R, C>)> = Vec::new();
    for own in a.start.windows(2).map(|ends| ends[0]..ends[1]) {
        let (column, value) = (&mut a.column[own.clone()], &mut a.value[own]);
        if !column.is_sorted() {
            row.clear();
            row.extend(column.iter().copied().zip(value.iter().copied()));
            row.sort_unstable_by_key(|entry| entry.0);
            column.iter_mut().zip(value).zip(&row).for_each(|((j, block), entry)| (*j, *block) = *entry);
        }
    }
    a
}

/// The matrix with further parts of its rows added, in their order and in the memory it has: `place` are the places of their columns.
pub(super) fn added<const R: usize, const C: usize>(
    mut a: Blocks<R, C>,
    parts: Vec<(u32, Entries<R, C>)>,
    place: impl Fn(u64) -> u32,
) -> Blocks<R, C> {
    let mut sums: BTreeMap<u32, Vec<(u32, Block<R, C>)>> = BTreeMap::new();
    for (i, part) in parts {
        let own = || a.entries_of(i as usize).map(|(j, block)| (j, *block)).collect();
        let row = sums.entry(i).or_insert_with(own);
        for (column, block) in part {
            let column = place(column);
            match row.binary_search_by_key(&column, |entry| entry.0) {
                Ok(k) => row[k].1.iter_mut().flatten().zip(block.iter().flatten()).for_each(|(a, b)| *a += b),
                Err(k) => row.insert(k, (column, block)),
            }
        }
    }
    let longer: usize = sums.iter().map(|(&i, row)| row.len() - a.row(i as usize).0.len()).sum();
    let mut end = a.column.len() + longer;
    grow(&mut a.column, longer, 0);
    grow(&mut a.value, longer, [[0.0; C]; R]);
    // From the last row on each moves to the end of what is left.
    for i in (0..a.rows).rev() {
        let own = a.start[i]..a.start[i + 1];
        a.start[i + 1] = end;
        match sums.get(&(i as u32)) {
            Some(row) => {
                end -= row.len();
                for (k, (column, block)) in row.iter().enumerate() {
                    (a.column[end + k], a.value[end + k]) = (*column, *block);
                }
            }
            None => {
                end -= own.len();
                a.column.copy_within(own.clone(), end);
                a.value.copy_within(own, end);
            }
        }
    }
    a
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

/// The coarse level of a step on fewer ranks: in each `group` of consecutive ones that at `place` (the last one of a group that has
/// no such rank) takes the nodes of the others. These keep their rows of the prolongation and of `A P`, with all columns as ghosts.
pub(super) fn gathered<const R: usize>(step: Coarser<R>, group: usize, place: usize) -> Coarser<R> {
    let Coarser { prolongation, a_times_p, matrix, kernel, halo } = step;
    let (ranks, rank) = (halo.ranks(), halo.ranks().rank());
    let first = rank - rank % group;
    let members = first..ranks.size().min(first + group);
    let taker = (first + place).min(members.end - 1);
    let others: Vec<usize> = if rank == taker { members.filter(|&other| other != taker).collect() } else { vec![] };
    let before = others.iter().filter(|&&other| other < taker).count();
    // What all of a group have, in the order of the ranks, where it is taken.
    let gather = |own: Vec<u8>| -> Vec<Vec<u8>> {
        if rank != taker {
            return ranks.exchange(vec![(taker, own)], &[]);
        }
        let mut all = ranks.exchange(vec![], &others);
        all.insert(before, own);
        all
    };
    let mut message = Vec::new();
    let row = |i: usize| matrix.entries_of(i).map(|(j, block)| (halo.global(j as usize), block));
    (0..matrix.rows).for_each(|i| pack(row(i), &mut message));
    let rows: Vec<Entries<6, 6>> = gather(message).iter().flat_map(|bytes| unpack(bytes)).collect();
    let kernels: Vec<Vec<Kernel<6>>> = gather(to_bytes(&kernel)).iter().map(|bytes| from_bytes(bytes)).collect();
    let begin = halo.first() - kernels.iter().take(before).map(Vec::len).sum::<usize>() as u64;
    let kernel = kernels.concat();
    // The nodes of a group are consecutive.
    let own = rows.len();
    let global = |j: &u32| halo.global(*j as usize);
    let columns = prolongation.column.iter().chain(&a_times_p.column).map(global);
    let needed = columns.chain(rows.iter().flatten().map(|entry| entry.0));
    let mut ghosts: Vec<u64> = needed.filter(|g| !(begin..begin + own as u64).contains(g)).collect();
    ghosts.sort_unstable();
    ghosts.dedup();
    let last = Halo::divided(ranks, own, ghosts);
    let place = |g: u64| last.place(g).expect("a node of this rank or one of its ghosts") as u32;
    let local = |row: Entries<6, 6>| row.into_iter().map(|(j, block)| (place(j), block)).collect();
    let parts: Vec<Vec<(u32, Block<6, 6>)>> = rows.into_iter().map(local).collect();
    let of_row: Vec<Vec<u32>> = (0..own as u32).map(|i| vec![i]).collect();
    Coarser {
        prolongation: renumbered(prolongation, last.len(), |j| place(global(&j))),
        a_times_p: renumbered(a_times_p, last.len(), |j| place(global(&j))),
        matrix: summed(own, last.len(), &parts, &of_row),
        kernel,
        halo: last,
    }
}

/// Rows of a level that change, by the ranks that find what they change by: `touched` are the own ones that some rank adds
/// to, and `reach` the same with the ghosts that this rank adds to. Both ascend.
#[derive(Debug, Clone)]
pub(super) struct Reach {
    pub reach: Vec<u32>,
    pub touched: Vec<u32>,
    /// How the level is divided.
    level: Halo,
    /// The same with the ghosts that this rank adds to, in whose places `reach` is.
    halo: Halo,
    /// For each rank this one adds to, places in `reach`.
    send: Vec<Vec<u32>>,
    /// For each rank that adds to own values, places in `touched`.
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
        let (level, halo) = (halo.clone(), halo.clone());
        if halo.is_alone() {
            let touched = reach.clone();
            return Reach { reach, touched, level, halo, send: Vec::new(), receive: Vec::new(), own: Vec::new() };
        }
        let (owners, askers) = halo.neighbours();
        let of = |reach: &[u32], ghosts: &[u32]| -> Vec<u32> {
            (0..reach.len() as u32).filter(|&t| ghosts.binary_search(&reach[t as usize]).is_ok()).collect()
        };
        let global =
            |list: Vec<u32>| -> Vec<u64> { list.iter().map(|&t| halo.global(reach[t as usize] as usize)).collect() };
        let out = owners.iter().map(|(rank, ghosts)| (*rank, to_bytes(&global(of(&reach, ghosts))))).collect();
        let from: Vec<usize> = askers.iter().map(|(rank, _)| *rank).collect();
        let own_place = |g: u64| halo.place(g).expect("an own value of this rank") as u32;
        let lists: Vec<Vec<u32>> = (halo.ranks().exchange(out, &from).iter())
            .map(|bytes| from_bytes::<u64>(bytes).into_iter().map(own_place).collect())
            .collect();
        let inside = reach.iter().copied().filter(|&k| (k as usize) < halo.own());
        let touched = ascending(inside.chain(lists.concat()).collect());
        // What the owner alone knows of a row it adds even where it finds nothing else.
        let reach = ascending([reach, touched.clone()].concat());
        let send = owners.iter().map(|(_, ghosts)| of(&reach, ghosts)).collect();
        let receive = lists.iter().map(|list| list.iter().map(|&k| place(&touched, k)).collect()).collect();
        // Own values come before ghosts.
        let own = (0..touched.len() as u32).map(|t| (t, t)).collect();
        Reach { reach, touched, level, halo, send, receive, own }
    }

    /// The same level with other places that this rank adds to, all of them among those that were touched, by the ghosts of
    /// `halo`.
    pub(super) fn within(&self, halo: &Halo, reach: Vec<u32>) -> Reach {
        let mut other = Reach::new(halo, reach);
        let touched = std::mem::take(&mut other.touched);
        let moved = |t: &mut u32| *t = self.touched.partition_point(|&k| k < touched[*t as usize]) as u32;
        other.receive.iter_mut().flatten().for_each(moved);
        other.own.iter_mut().for_each(|(_, t)| moved(t));
        other.touched.clone_from(&self.touched);
        other.level.clone_from(&self.level);
        other
    }

    /// The place in `touched` of the row at place `t` of `reach`, if it is an own row.
    pub(super) fn owned(&self, t: usize) -> Option<usize> {
        if self.halo.is_alone() {
            return Some(t);
        }
        self.own.binary_search_by_key(&(t as u32), |own| own.0).ok().map(|k| self.own[k].1 as usize)
    }

    /// Rows for `touched` from rows for `reach`, those of other ranks added.
    pub(super) fn rows<const C: usize>(&self, rows: Blocks<C, C>) -> Blocks<C, C> {
        let (level, halo) = (&self.level, &self.halo);
        if halo.is_alone() {
            return rows;
        }
        let mut parts: Vec<Vec<(u32, Block<C, C>)>> = Vec::new();
        let mut of_row = vec![Vec::new(); self.touched.len()];
        let row = |t: u32| rows.entries_of(t as usize).map(|(j, block)| (halo.global(j as usize), block));
        // The change lies within the pattern of the matrix, whose columns are all here.
        let mut take = |t: u32, row: &mut dyn Iterator<Item = (u64, Block<C, C>)>| {
            of_row[t as usize].push(parts.len() as u32);
            parts.push(row.filter_map(|(j, block)| Some((level.place(j)? as u32, block))).collect());
        };
        self.own.iter().for_each(|&(t, to)| take(to, &mut row(t).map(|(j, block)| (j, *block))));
        let message = |list: &[u32]| {
            let mut bytes = Vec::new();
            list.iter().for_each(|&t| pack(row(t), &mut bytes));
            bytes
        };
        let (owners, askers) = halo.neighbours();
        let out = owners.iter().zip(&self.send).map(|((rank, _), list)| (*rank, message(list))).collect();
        let from: Vec<usize> = askers.iter().map(|(rank, _)| *rank).collect();
        for (places, bytes) in self.receive.iter().zip(&halo.ranks().exchange(out, &from)) {
            places.iter().zip(unpack::<C, C>(bytes)).for_each(|(&t, row)| take(t, &mut row.into_iter()));
        }
        summed(self.touched.len(), level.len(), &parts, &of_row)
    }

    /// The same for one value a row.
    pub(super) fn values<T: Wire>(&self, values: Vec<T>, zero: T, add: impl Fn(&mut T, &T)) -> Vec<T> {
        let halo = &self.halo;
        if halo.is_alone() {
            return values;
        }
        let mut sums = vec![zero; self.touched.len()];
        self.own.iter().for_each(|&(t, to)| add(&mut sums[to as usize], &values[t as usize]));
        let (owners, askers) = halo.neighbours();
        let message = |list: &[u32]| to_bytes(&list.iter().map(|&t| values[t as usize]).collect::<Vec<T>>());
        let out = owners.iter().zip(&self.send).map(|((rank, _), list)| (*rank, message(list))).collect();
        let from: Vec<usize> = askers.iter().map(|(rank, _)| *rank).collect();
        for (places, bytes) in self.receive.iter().zip(&halo.ranks().exchange(out, &from)) {
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

#[cfg(test)]
mod tests {
    use super::super::coarsen::coarsen;
    use super::super::tests::lattice;
    use super::*;
    use crate::ranks::threads;

    #[test]
    fn parts_of_rows_are_added_in_place_as_in_a_new_matrix() {
        let named = |i: usize, name: &mut dyn FnMut(u32)| (0..i as u32 % 3).for_each(|k| name(2 * k + 1));
        let value = |i: usize, j: u32| [[(i * 10) as f64 + f64::from(j), 1.0]];
        let a: Blocks<1, 2> = Blocks::from_rows(7, 9, named, |i, row| {
            (0..i as u32 % 3).for_each(|k| *row.at(2 * k + 1) = value(i, 2 * k + 1));
        });
        let parts: Vec<(u32, Entries<1, 2>)> = vec![
            (1, vec![(100, [[1.0, 2.0]]), (101, [[3.0, 4.0]])]),
            (6, vec![(104, [[5.0, 6.0]])]),
            (1, vec![(108, [[7.0, 8.0]]), (101, [[0.5, 0.5]])]),
        ];
        let place = |g: u64| (g - 100) as u32;
        let own = |i: usize| a.entries_of(i).map(|(j, block)| (j, *block)).collect::<Vec<_>>();
        let local = |row: &Entries<1, 2>| row.iter().map(|(g, block)| (place(*g), *block)).collect::<Vec<_>>();
        let all: Vec<_> = (0..7).map(own).chain(parts.iter().map(|(_, row)| local(row))).collect();
        let mut of_row: Vec<Vec<u32>> = (0..7).map(|i| vec![i]).collect();
        parts.iter().zip(7..).for_each(|((i, _), part)| of_row[*i as usize].push(part));
        let expected = summed(7, 9, &all, &of_row);
        let found = added(a.clone(), parts, place);
        assert_eq!((found.start, found.column, found.value), (expected.start, expected.column, expected.value));
        let same = added(a.clone(), Vec::new(), place);
        assert_eq!((same.start, same.column, same.value), (a.start, a.column, a.value));
    }

    /// Each rank has a slab of the lattice.
    #[test]
    fn an_agglomerated_level_is_the_same_matrix_and_the_same_space_in_the_hands_of_fewer_ranks() {
        let size = 5;
        let (a, kernel) = lattice([30, 5, 5], [1.0; 3]);
        for (group, taker) in [(2, 0), (2, 1), (4, 0), (4, 2), (8, 4), (8, 7)] {
            let found = threads(size, |ranks| {
                let rank = ranks.rank();
                let own = a.rows * rank / size..a.rows * (rank + 1) / size;
                let columns = own.clone().flat_map(|i| a.row(i).0).map(|&j| u64::from(j));
                let halo = Halo::divided(&ranks, own.len(), Vec::new()).with_other_ghosts(columns);
                let place = |j: u32| halo.place(j.into()).unwrap() as u32;
                let named =
                    |i: usize, name: &mut dyn FnMut(u32)| a.row(own.start + i).0.iter().for_each(|&j| name(place(j)));
                let slab = Blocks::from_rows(own.len(), halo.len(), named, |i, row| {
                    a.entries_of(own.start + i).for_each(|(j, block)| *row.at(place(j)) = *block);
                });
                let step = coarsen(&slab, &halo, &kernel[own.clone()], 0.05, &[], None, &[0]).unwrap().unwrap();
                let value = |g: u64| std::array::from_fn(|c| ((6 * g + c as u64) as f64 * 0.618).fract() - 0.5);
                let products = |step: &Coarser<3>| {
                    let mut x: Vec<[f64; 6]> = (0..step.halo.own()).map(|k| value(step.halo.global(k))).collect();
                    step.halo.update(&mut x);
                    (step.prolongation.times(&x), step.a_times_p.times(&x), step.matrix.times(&x))
                };
                let before = products(&step);
                let fewer = gathered(step.clone(), group, taker);
                let takes = rank == (rank - rank % group + taker).min(size - 1);
                assert_eq!(fewer.halo.own() > 0, takes, "{rank} of {group}");
                (before, products(&fewer), step.kernel, fewer.kernel)
            });
            let close = |a: &[f64], b: &[f64]| {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-12 * a.abs().max(1.0))
            };
            for (before, after, ..) in &found {
                assert!(close(before.0.as_flattened(), after.0.as_flattened()));
                assert!(close(before.1.as_flattened(), after.1.as_flattened()));
            }
            let all = |of: &dyn Fn(usize) -> Vec<[f64; 6]>| (0..size).flat_map(of).collect::<Vec<_>>();
            let (before, after) = (all(&|r| found[r].0.2.clone()), all(&|r| found[r].1.2.clone()));
            assert!(before.len() > 8 && close(before.as_flattened(), after.as_flattened()));
            let kernels = [all(&|r| found[r].2.concat()), all(&|r| found[r].3.concat())];
            assert_eq!(kernels[0], kernels[1]);
        }
    }
}
