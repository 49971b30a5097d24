//! Coarse levels of nodes that are divided among ranks.

use super::between_ranks::{added, ghost_rows, renumbered, returned_rows, summed};
use super::blocks::{Block, Blocks};
use super::coarsen::{Coarser, fill_idle, products};
use crate::ranks::Halo;

/// The aggregates of own nodes and ghosts, by their places among the own `count` ones and those of the ghosts.
pub(super) fn aggregates_of_ghosts(halo: &Halo, of: Vec<u32>, count: usize) -> (Vec<u32>, Halo) {
    if halo.is_alone() {
        return (of, Halo::alone(count));
    }
    let first = Halo::divided(halo.ranks(), count, Vec::new()).first();
    let mut global: Vec<u64> = of.iter().map(|&g| first + u64::from(g)).collect();
    halo.update(&mut global);
    let mut ghosts = global[halo.own()..].to_vec();
    ghosts.sort_unstable();
    ghosts.dedup();
    let coarse = Halo::divided(halo.ranks(), count, ghosts);
    (global.iter().map(|&g| place(&coarse, g)).collect(), coarse)
}

/// The place of a number that is here.
fn place(halo: &Halo, global: u64) -> u32 {
    halo.place(global).expect("an aggregate of this rank or one of its ghosts") as u32
}

/// The halo with more ghosts, given by their global numbers.
fn with_ghosts(halo: &Halo, more: impl Iterator<Item = u64>) -> Halo {
    halo.with_other_ghosts((halo.own()..halo.len()).map(|k| halo.global(k)).chain(more))
}

/// A prolongation with the coarse matrix, the wanted rows of `A P` and the division of the coarse level.
pub(super) type Product<const R: usize, const C: usize> = (Blocks<R, C>, Blocks<C, C>, Blocks<R, C>, Halo);

/// [`galerkin`] where the nodes are divided: with the rows of the prolongation at ghosts, and with what ranks find for the
/// coarse rows of others. The columns of the prolongation `p` have the places of `coarse`.
pub(super) fn divided_galerkin<const R: usize, const C: usize>(
    a: &Blocks<R, R>,
    halo: &Halo,
    p: Blocks<R, C>,
    coarse: Halo,
    wanted: &[u32],
) -> Option<Product<R, C>> {
    let own_row = |i: u32| p.entries_of(i as usize).map(|(j, b)| (coarse.global(j as usize), *b)).collect();
    let ghosts = ghost_rows(halo, own_row);
    let wider = with_ghosts(&coarse, ghosts.iter().flatten().map(|entry| entry.0));
    let mut p = renumbered(p, wider.len(), |j| place(&wider, coarse.global(j as usize)));
    let more = ghosts.iter().map(Vec::len).sum();
    p.column.reserve_exact(more);
    p.value.reserve_exact(more);
    for row in ghosts {
        let mut row: Vec<(u32, Block<R, C>)> = row.into_iter().map(|(j, block)| (place(&wider, j), block)).collect();
        row.sort_unstable_by_key(|entry| entry.0);
        p.column.extend(row.iter().map(|entry| entry.0));
        p.value.extend(row.iter().map(|entry| entry.1));
        p.start.push(p.column.len());
        p.rows += 1;
    }
    let (found, kept) = products(a, halo, &p, wanted)?;
    let returned = returned_rows(&wider, &found, |j| wider.global(j as usize));
    let last = with_ghosts(&wider, returned.iter().flat_map(|(_, row)| row).map(|entry| entry.0));
    let to_last = |j: u32| place(&last, wider.global(j as usize));
    // The largest matrices of the set-up beside the one above: no copy is made of them.
    let matrix = renumbered(found.truncated(wider.own(), wider.len()), last.len(), to_last);
    let mut matrix = added(matrix, returned, |j| place(&last, j));
    fill_idle(&mut matrix);
    Some((renumbered(p, last.len(), to_last), matrix, renumbered(kept, last.len(), to_last), last))
}

/// Extends the pattern of the coarse matrix of a step by `more` columns of each row, ghosts included: what ranks find for rows of
/// others is sent to them.
pub(super) fn widened<const R: usize, const C: usize>(step: Coarser<R, C>, more: &[Vec<u32>]) -> Coarser<R, C> {
    let Coarser { prolongation, a_times_p, matrix, kernel, halo } = step;
    let named = |k: usize, name: &mut dyn FnMut(u32)| more[k].iter().for_each(|&j| name(j));
    let found: Blocks<1, 1> = Blocks::from_rows(more.len(), halo.len(), named, |_, _| {});
    let returned = returned_rows(&halo, &found, |j| halo.global(j as usize));
    let last = with_ghosts(&halo, returned.iter().flat_map(|(_, row)| row).map(|entry| entry.0));
    let to_last = |j: u32| place(&last, halo.global(j as usize));
    let mut of_row: Vec<Vec<u32>> =
        more[..halo.own()].iter().map(|row| row.iter().map(|&j| to_last(j)).collect()).collect();
    for (k, row) in returned {
        of_row[k as usize].extend(row.iter().map(|entry| place(&last, entry.0)));
    }
    let own = renumbered(matrix, last.len(), to_last);
    let named = |k: usize, name: &mut dyn FnMut(u32)| own.row(k).0.iter().chain(&of_row[k]).for_each(|&j| name(j));
    let matrix = Blocks::from_rows(own.rows, last.len(), named, |k, row| {
        own.entries_of(k).for_each(|(j, block)| *row.at(j) = *block);
    });
    Coarser {
        prolongation: renumbered(prolongation, last.len(), to_last),
        a_times_p: renumbered(a_times_p, last.len(), to_last),
        matrix,
        kernel,
        halo: last,
    }
}

/// A step whose rows of `A P` at contact nodes get what others of them are measured by: `moved` are the parts that the rows of
/// this rank add to those of contact nodes, the own ones and then the ghosts of `contact`. They are sent to their owners.
pub(super) fn moved<const C: usize>(step: Coarser<3, C>, contact: &Halo, moved: &Blocks<3, C>) -> Coarser<3, C> {
    let Coarser { prolongation, a_times_p, matrix, kernel, halo } = step;
    let returned = returned_rows(contact, moved, |j| halo.global(j as usize));
    let last = with_ghosts(&halo, returned.iter().flat_map(|(_, row)| row).map(|entry| entry.0));
    let to_last = |j: u32| place(&last, halo.global(j as usize));
    let (mut parts, mut of_row) = (Vec::new(), vec![Vec::new(); a_times_p.rows]);
    let mut take = |t: usize, row: Vec<(u32, Block<3, C>)>| {
        of_row[t].push(parts.len() as u32);
        parts.push(row);
    };
    for t in 0..a_times_p.rows {
        let rows = a_times_p.entries_of(t).chain(moved.entries_of(t));
        take(t, rows.map(|(j, block)| (to_last(j), *block)).collect());
    }
    for (t, row) in returned {
        take(t as usize, row.into_iter().map(|(j, block)| (place(&last, j), block)).collect());
    }
    let a_times_p = summed(a_times_p.rows, last.len(), &parts, &of_row);
    Coarser {
        prolongation: renumbered(prolongation, last.len(), to_last),
        a_times_p,
        matrix: renumbered(matrix, last.len(), to_last),
        kernel,
        halo: last,
    }
}
