//! From a mesh with materials, loads and supports to `K u = f`.
//!
//! Rows are summed by ranges of nodes, so that no two threads write to one row and the order of addition, and with it
//! every bit, does not depend on their number.

use rayon::prelude::*;

use super::elements::Law;
use super::incidence::{Entries, Incidence, Needed, NodeRange};
use super::rotated::turn_block;
use super::row_assembly::RowAssembly;
use super::{DofMap, FeModel, Fix, Load, Solid, dof_map, external_forces};
use crate::Error;
use crate::linalg::memory::ensure;
use crate::linalg::{Csr, SymmetricCsr, in_huge_pages, piece};
use crate::mesh::v3::V3;

/// Poses `K u = f` at time `t`: stiffness, loads and prescribed displacements, split into unknown and prescribed.
///
/// Threads own ranges of node rows and add the cells in ascending order, so the result is the same to the bit for
/// any number of threads, and `K` is symmetric to the bit. An error where mesh, materials, loads or prescribed
/// displacements cannot be used; a body left floating is none, see [`unconstrained_motions`](super::unconstrained_motions).
///
/// # Errors
/// If mesh, materials, loads or prescribed displacements cannot be used.
pub fn assemble(solid: &Solid, loads: &[Load], fixes: &[Fix], t: f64) -> Result<FeModel, Error> {
    assemble_part(solid, loads, fixes, t, Entries::All)
}

/// The same with no more of `K` than is asked for.
pub(crate) fn assemble_part(
    solid: &Solid,
    loads: &[Load],
    fixes: &[Fix],
    t: f64,
    entries: Entries,
) -> Result<FeModel, Error> {
    solid.validate()?;
    let cells = solid.cells();
    let acting = || -> Result<_, Error> {
        let dofs = dof_map(solid.mesh, fixes, t)?;
        let mut force = external_forces(solid, loads, t)?;
        dofs.to_components(&mut force);
        Ok((dofs, force))
    };
    let (incidence, acting) = rayon::join(|| Incidence::new(solid.mesh), acting);
    let (incidence, (dofs, force)) = (incidence?, acting?);
    let constrained = dofs.unknown.as_chunks::<3>().0.iter().map(|dofs| dofs.contains(&u32::MAX)).collect();
    let needed = Needed { constrained, entries };
    let ranges = NodeRange::all(&incidence, &cells, &needed);
    let laws: Vec<Law> = solid.materials.iter().map(Law::new).collect();

    let mut model = with_pattern(dofs, &ranges, entries)?;
    let FeModel { dofs, stiffness, load, support_stiffness, support_support, support_load, .. } = &mut model;
    *load = dofs.free.iter().map(|&dof| force[dof as usize]).collect();
    *support_load = dofs.prescribed.iter().map(|&dof| force[dof as usize]).collect();

    let number = number_in_its_set(dofs);
    let rotated = rotated_of_node(dofs);
    let free_rows = rows_of_ranges(&dofs.free, &ranges);
    let support_rows = rows_of_ranges(&dofs.prescribed, &ranges);
    let rows = split_lower(stiffness, &free_rows)
        .into_iter()
        .zip(split_rows(support_stiffness, &support_rows))
        .zip(split_rows(support_support, &support_rows))
        .zip(split(load, &free_rows));
    ranges
        .par_iter()
        .with_max_len(piece(ranges.len()))
        .zip(rows.collect::<Vec<_>>())
        .map_init(
            || RowAssembly::new(solid, &laws, &cells, &incidence, &needed),
            |sums, (range, (((free_free, support_free), support_support), load))| {
                let (number, rotated) = (&number, &rotated);
                Rows { dofs, number, rotated, entries, free_free, support_free, support_support, load }
                    .fill(range, sums)
            },
        )
        .collect::<Vec<Result<(), Error>>>()
        .into_iter()
        .collect::<Result<(), Error>>()?;
    Ok(model)
}

/// The rows of a range of nodes in the matrices of the model; filled from the first row on.
struct Rows<'a> {
    dofs: &'a DofMap,
    /// For each degree of freedom its number among the unknown or among the prescribed.
    number: &'a [u32],
    /// For each node its place in `dofs.rotated`, or `u32::MAX`; empty if none is rotated.
    rotated: &'a [u32],
    /// Which of `K` there are.
    entries: Entries,
    free_free: LowerEntries<'a>,
    support_free: FullEntries<'a>,
    support_support: FullEntries<'a>,
    load: &'a mut [f64],
}

impl Rows<'_> {
    fn fill(mut self, range: &NodeRange, sums: &mut RowAssembly) -> Result<(), Error> {
        let blocks = sums.of(range)?;
        let mut free_row = 0;
        for i in range.nodes.clone() {
            let neighbours = range.neighbours(i);
            let row = &mut blocks[range.row(i)];
            if !self.rotated.is_empty() {
                let turn = |(block, &j): (&mut [V3; 3], &u32)| *block = self.turn(block, i as u32, j);
                row.iter_mut().zip(neighbours).for_each(turn);
            }
            self.store(i, neighbours, row, &mut free_row);
        }
        Ok(())
    }

    /// Stores the row of node `i`, whose first free component has the row `free_row` of the range.
    fn store(&mut self, i: usize, neighbours: &[u32], row: &[[V3; 3]], free_row: &mut usize) {
        self.store_columns(i, neighbours);
        // Nearly everywhere all but the last: all three components of a node before this one are unknown.
        let is_plain = |&&j: &&u32| (j as usize) < i && (0..3).all(|b| self.is_free(3 * j as usize + b));
        let all = self.entries == Entries::All;
        let plain = if all { neighbours.iter().take_while(is_plain).count() } else { 0 };
        for a in 0..3 {
            let free = self.is_free(3 * i + a);
            let stored = if free { plain } else { 0 };
            row[..stored].iter().for_each(|block| self.free_free.push_three(block[a]));
            for (&j, block) in neighbours.iter().zip(row).skip(stored) {
                let first = 3 * j as usize;
                for (b, &value) in block[a].iter().enumerate() {
                    let column = self.number[first + b];
                    match (free, self.is_free(first + b)) {
                        // The lower triangle alone, or its last entry.
                        (true, true) if first + b == 3 * i + a || all && first + b < 3 * i + a => {
                            self.free_free.push(value);
                        }
                        (true, true) => {}
                        (true, false) => self.load[*free_row] -= value * self.dofs.value[column as usize],
                        (false, true) => self.support_free.push(column, value),
                        (false, false) => self.support_support.push(column, value),
                    }
                }
            }
            *free_row += free as usize;
        }
    }

    /// The columns that the unknowns of node `i` share: those of the nodes before it, then its own.
    fn store_columns(&mut self, i: usize, neighbours: &[u32]) {
        if !(0..3).any(|a| self.is_free(3 * i + a)) {
            return;
        }
        if self.entries == Entries::Diagonal {
            let own = self.dofs.unknown[3 * i..3 * i + 3].iter();
            own.filter(|&&unknown| unknown != u32::MAX).for_each(|&unknown| self.free_free.share(unknown));
            return;
        }
        for &j in neighbours.iter().take_while(|&&j| j as usize <= i) {
            let unknowns = &self.dofs.unknown[3 * j as usize..3 * j as usize + 3];
            unknowns.iter().filter(|&&unknown| unknown != u32::MAX).for_each(|&unknown| self.free_free.share(unknown));
        }
    }

    /// The block in the axes of its nodes.
    fn turn(&self, block: &[V3; 3], i: u32, j: u32) -> [V3; 3] {
        let axes = |node: u32| {
            let place = *self.rotated.get(node as usize)?;
            self.dofs.rotated.get(place as usize).map(|rotated| &rotated.axes)
        };
        turn_block(block, [i, j], axes(i), axes(j))
    }

    fn is_free(&self, dof: usize) -> bool {
        self.dofs.unknown[dof] != u32::MAX
    }
}

/// Consecutive entries of a matrix, written in order.
struct FullEntries<'a> {
    column: &'a mut [u32],
    value: &'a mut [f64],
    filled: usize,
}

impl FullEntries<'_> {
    fn push(&mut self, column: u32, value: f64) {
        self.column[self.filled] = column;
        self.value[self.filled] = value;
        self.filled += 1;
    }
}

/// Consecutive rows of a lower triangle, written in order.
struct LowerEntries<'a> {
    column: &'a mut [u32],
    value: &'a mut [f64],
    columns: usize,
    values: usize,
}

impl LowerEntries<'_> {
    /// The next of the columns that rows share.
    fn share(&mut self, column: u32) {
        self.column[self.columns] = column;
        self.columns += 1;
    }

    fn push(&mut self, value: f64) {
        self.value[self.values] = value;
        self.values += 1;
    }

    fn push_three(&mut self, values: V3) {
        self.value[self.values..self.values + 3].copy_from_slice(&values);
        self.values += 3;
    }
}

/// The model with its row pointers; columns and values are still zero. An error where there is no memory for them.
fn with_pattern(dofs: DofMap, ranges: &[NodeRange], entries: Entries) -> Result<FeModel, Error> {
    let (n, p) = (dofs.free.len(), dofs.prescribed.len());
    let free_of_node: Vec<u8> = dofs
        .unknown
        .as_chunks::<3>()
        .0
        .iter()
        .map(|dofs| dofs.iter().filter(|&&u| u != u32::MAX).count() as u8)
        .collect();
    let counts: Vec<Vec<[usize; 2]>> = ranges.par_iter().map(|range| unknowns_around(range, &free_of_node)).collect();
    let [mut support_stiffness, mut support_support] = [n, p].map(|cols| Csr::zero(p, cols));
    matrices_fit(&dofs, ranges, &free_of_node, &counts)?;
    let mut support_row = 0;
    for (range, counts) in ranges.iter().zip(&counts) {
        for (i, &[_, free]) in range.nodes.clone().zip(counts) {
            for _ in free_of_node[i]..3 {
                let entries = [free, 3 * range.neighbours(i).len() - free];
                for (matrix, entries) in [&mut support_stiffness, &mut support_support].into_iter().zip(entries) {
                    matrix.start[support_row + 1] = matrix.start[support_row] + entries;
                }
                support_row += 1;
            }
        }
    }
    for matrix in [&mut support_stiffness, &mut support_support] {
        let entries = matrix.start[matrix.rows];
        matrix.column = in_huge_pages(vec![0; entries]);
        matrix.value = in_huge_pages(vec![0.0; entries]);
    }
    let stiffness = match entries {
        Entries::All => lower_pattern(&dofs, ranges, &free_of_node, &counts),
        Entries::Diagonal => diagonal_pattern(n),
    };
    let (load, support_load) = (Vec::new(), Vec::new());
    Ok(FeModel { stiffness, load, support_stiffness, support_support, support_load, springs: None, dofs })
}

/// Refuses matrices for which there is no memory, by the counts of [`unknowns_around`].
fn matrices_fit(
    dofs: &DofMap,
    ranges: &[NodeRange],
    free_of_node: &[u8],
    counts: &[Vec<[usize; 2]>],
) -> Result<(), Error> {
    let bytes = |range: &NodeRange, counts: &Vec<[usize; 2]>| -> f64 {
        let of_node = |(i, &[before, all]): (usize, &[usize; 2])| {
            let free = f64::from(free_of_node[i]);
            // The lower triangle with shared columns, and full rows of what is prescribed.
            let own = free * (before as f64 + (free + 1.0) / 2.0);
            8.0 * own
                + 4.0 * (before as f64 + free)
                + 12.0 * (3.0 - free) * 3.0 * range.neighbours(i).len().max(all) as f64
        };
        range.nodes.clone().zip(counts).map(of_node).sum()
    };
    let entries: f64 = ranges.iter().zip(counts).map(|(range, counts)| bytes(range, counts)).sum();
    let rows = 24.0 * (dofs.free.len() + dofs.prescribed.len()) as f64;
    ensure(&format!("the stiffness matrix of {} unknowns", dofs.free.len()), entries + rows, None)
}

/// For each node of the range the unknowns of the neighbours before it, and of all of them.
fn unknowns_around(range: &NodeRange, free_of_node: &[u8]) -> Vec<[usize; 2]> {
    let count = |neighbours: &[u32]| neighbours.iter().map(|&j| free_of_node[j as usize] as usize).sum::<usize>();
    let of_node = |i: usize| {
        let neighbours = range.neighbours(i);
        let before = neighbours.partition_point(|&j| (j as usize) < i);
        [count(&neighbours[..before]), count(neighbours)]
    };
    range.nodes.clone().map(of_node).collect()
}

/// `K` with its row pointers; `counts` are those of [`unknowns_around`].
fn lower_pattern(dofs: &DofMap, ranges: &[NodeRange], free_of_node: &[u8], counts: &[Vec<[usize; 2]>]) -> SymmetricCsr {
    // Entries of the rows of a node with so many unknowns, of which its own block has a triangle.
    let entries = |own: usize, before: usize| own * before + own * (own + 1) / 2;
    let columns = |own: usize, before: usize| if own > 0 { before + own } else { 0 };
    let nodes =
        |k: usize| ranges[k].nodes.clone().map(|i| free_of_node[i] as usize).zip(counts[k].iter().map(|c| c[0]));
    let sizes: Vec<[usize; 2]> = (0..ranges.len())
        .into_par_iter()
        .map(|k| {
            nodes(k).fold([0; 2], |sum, (own, before)| [sum[0] + entries(own, before), sum[1] + columns(own, before)])
        })
        .collect();
    let n = dofs.free.len();
    let mut start = in_huge_pages(vec![0; n + 1]);
    let mut first = in_huge_pages(vec![0; n]);
    let rows = rows_of_ranges(&dofs.free, ranges);
    let (mut filled, mut tasks) = ([0; 2], Vec::new());
    for (k, (ends, firsts)) in split(&mut start[1..], &rows).into_iter().zip(split(&mut first, &rows)).enumerate() {
        tasks.push((k, filled, ends, firsts));
        filled = [filled[0] + sizes[k][0], filled[1] + sizes[k][1]];
    }
    tasks.into_par_iter().for_each(|(k, [mut entry, mut column], ends, firsts)| {
        let mut rows = ends.iter_mut().zip(firsts);
        for (own, before) in nodes(k) {
            for (a, (end, first)) in rows.by_ref().take(own).enumerate() {
                entry += before + a + 1;
                (*end, *first) = (entry, column);
            }
            column += columns(own, before);
        }
    });
    let (column, value) = (in_huge_pages(vec![0; filled[1]]), in_huge_pages(vec![0.0; filled[0]]));
    SymmetricCsr { rows: n, start, first, column, value }
}

/// `K` with an entry for each row.
fn diagonal_pattern(n: usize) -> SymmetricCsr {
    let rows = |count: usize| in_huge_pages((0..count).collect());
    let (column, value) = (in_huge_pages(vec![0; n]), in_huge_pages(vec![0.0; n]));
    SymmetricCsr { rows: n, start: rows(n + 1), first: rows(n), column, value }
}

/// For each degree of freedom its number among the unknown, or among the prescribed where it is prescribed.
fn number_in_its_set(dofs: &DofMap) -> Vec<u32> {
    let mut number = dofs.unknown.clone();
    dofs.prescribed.iter().enumerate().for_each(|(k, &dof)| number[dof as usize] = k as u32);
    number
}

/// For each node its place among the rotated ones, or `u32::MAX`; empty if there are none.
fn rotated_of_node(dofs: &DofMap) -> Vec<u32> {
    if dofs.rotated.is_empty() {
        return Vec::new();
    }
    let mut place = vec![u32::MAX; dofs.unknown.len() / 3];
    dofs.rotated.iter().enumerate().for_each(|(k, rotated)| place[rotated.node as usize] = k as u32);
    place
}

/// For each range the first row after its rows, where `dofs` (ascending) are the rows.
fn rows_of_ranges(dofs: &[u32], ranges: &[NodeRange]) -> Vec<usize> {
    ranges.iter().map(|range| dofs.partition_point(|&dof| (dof as usize) < 3 * range.nodes.end)).collect()
}

/// The entries of `matrix`, cut after the rows `ends`.
fn split_rows<'a>(matrix: &'a mut Csr, ends: &[usize]) -> Vec<FullEntries<'a>> {
    let ends: Vec<usize> = ends.iter().map(|&row| matrix.start[row]).collect();
    let columns = split(&mut matrix.column, &ends).into_iter();
    columns
        .zip(split(&mut matrix.value, &ends))
        .map(|(column, value)| FullEntries { column, value, filled: 0 })
        .collect()
}

/// The same of a lower triangle.
fn split_lower<'a>(matrix: &'a mut SymmetricCsr, ends: &[usize]) -> Vec<LowerEntries<'a>> {
    let columns: Vec<usize> =
        ends.iter().map(|&row| matrix.first.get(row).copied().unwrap_or(matrix.column.len())).collect();
    let values: Vec<usize> = ends.iter().map(|&row| matrix.start[row]).collect();
    let columns = split(&mut matrix.column, &columns).into_iter();
    let both = columns.zip(split(&mut matrix.value, &values));
    both.map(|(column, value)| LowerEntries { column, value, columns: 0, values: 0 }).collect()
}

/// `whole`, cut at the ascending positions `ends`.
fn split<'a, T>(mut whole: &'a mut [T], ends: &[usize]) -> Vec<&'a mut [T]> {
    let mut start = 0;
    let mut parts = Vec::with_capacity(ends.len());
    for &end in ends {
        let (part, rest) = whole.split_at_mut(end - start);
        parts.push(part);
        (whole, start) = (rest, end);
    }
    parts
}
