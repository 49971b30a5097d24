//! Displacements that are linear in the cells: their stiffness, and what of forces they see.

use rayon::prelude::*;

use super::NoBound;
use super::tets::{CELLS_PER_TASK, Shape, Tets, traction};
use crate::fem::{DofMap, Voigt};
use crate::linalg::{Csr, SymmetricCsr};
use crate::mesh::v3::{V3, dot};

/// Chunks of cells whose blocks are held at a time.
const CHUNK: usize = 64 * CELLS_PER_TASK;

/// The elastic bodies with the displacements of corners as unknowns, between which they are linear; contact holds nothing.
#[derive(Debug, Clone)]
pub struct LinearSystem {
    /// Stiffness, `n x n`, force/length.
    pub stiffness: SymmetricCsr,
    /// For each of the `n` unknowns its place in `dofs.free`, ascending.
    pub unknowns: Vec<u32>,
}

impl LinearSystem {
    pub(super) fn new(tets: &Tets, shapes: &[Shape], dofs: &DofMap) -> Result<Self, NoBound> {
        let nodes = tets.mesh().nodes.len();
        // Of each node itself and those before it that share a cell with it, ascending.
        let pairs = |cell: &[u32; 4]| {
            let cell = *cell;
            (0..4).flat_map(move |b| (0..=b).map(move |a| [cell[b], cell[a]])).collect::<Vec<_>>()
        };
        let mut rows: Vec<[u32; 2]> = tets.corners.par_iter().flat_map_iter(pairs).collect();
        rows.par_sort_unstable();
        rows.dedup();
        let mut start = vec![0; nodes + 1];
        rows.iter().for_each(|row| start[row[0] as usize + 1] += 1);
        (0..nodes).for_each(|node| start[node + 1] += start[node]);
        let mut blocks = vec![[[0.0; 3]; 3]; rows.len()];
        for first in (0..shapes.len()).step_by(CHUNK) {
            let end = shapes.len().min(first + CHUNK);
            let of_cell = |cell: usize| block_rows(tets, cell, &shapes[cell]);
            let parts: Vec<_> = (first..end).into_par_iter().with_min_len(CELLS_PER_TASK).map(of_cell).collect();
            for (corners, part) in tets.corners[first..end].iter().zip(parts) {
                for ([b, a], own) in pairs(corners).into_iter().zip(part) {
                    let row = &rows[start[b as usize]..start[b as usize + 1]];
                    let Ok(at) = row.binary_search(&[b, a]) else { continue };
                    let block = &mut blocks[start[b as usize] + at];
                    (0..3).for_each(|i| (0..3).for_each(|j| block[i][j] += own[i][j]));
                }
            }
        }
        let mut number = vec![u32::MAX; 3 * nodes];
        let (mut unknowns, mut own) = (Vec::new(), Vec::new());
        for (i, &dof) in dofs.free.iter().enumerate() {
            let node = dof as usize / 3;
            if start.get(node).is_some_and(|&first| first < start[node + 1]) {
                number[dof as usize] = own.len() as u32;
                unknowns.push(i as u32);
                own.push(dof);
            }
        }
        let mut lower = Csr { rows: own.len(), cols: own.len(), start: vec![0], column: Vec::new(), value: Vec::new() };
        for (i, &dof) in own.iter().enumerate() {
            let along = dofs.direction(dof);
            let node = dof as usize / 3;
            for at in start[node]..start[node + 1] {
                let forces: V3 = std::array::from_fn(|j| (0..3).map(|k| along[k] * blocks[at][k][j]).sum());
                for other in 3 * rows[at][1]..3 * rows[at][1] + 3 {
                    let j = number[other as usize];
                    if j <= i as u32 {
                        lower.column.push(j);
                        lower.value.push(dot(forces, dofs.direction(other)));
                    }
                }
            }
            lower.start.push(lower.column.len());
        }
        let stiffness = SymmetricCsr::from_lower(&lower, "stiffness").map_err(NoBound::Unsolved)?;
        Ok(LinearSystem { stiffness, unknowns })
    }
}

/// Blocks of corners `b` and `a <= b` of a cell, in their order: forces at `b` from displacements of `a`.
fn block_rows(tets: &Tets, cell: usize, shape: &Shape) -> [[V3; 3]; 10] {
    let law = tets.law(cell);
    let mut blocks = [[[0.0; 3]; 3]; 10];
    for a in 0..4 {
        for c in 0..3 {
            let g = shape.gradient[a];
            let mut strain: Voigt = [0.0; 6];
            strain[c] = g[c];
            // Places of xy, yz and zx, and what stands in them.
            for (place, [i, j]) in [(3, [0, 1]), (4, [1, 2]), (5, [0, 2])] {
                if c == i {
                    strain[place] = g[j];
                } else if c == j {
                    strain[place] = g[i];
                }
            }
            let stress = law.stress(&strain);
            for b in a..4 {
                let force = traction(&stress, shape.gradient[b]);
                (0..3).for_each(|k| blocks[b * (b + 1) / 2 + a][k][c] = shape.volume * force[k]);
            }
        }
    }
    blocks
}

/// Gives forces at the middles of edges to both ends, half each, as displacements between them are their mean; values `3 i + c` of node `i`.
pub(super) fn to_corners(tets: &Tets, forces: &mut [f64]) {
    for [middle, ends @ ..] in middles(tets) {
        for c in 0..3 {
            let half = 0.5 * std::mem::take(&mut forces[3 * middle as usize + c]);
            ends.iter().for_each(|&end| forces[3 * end as usize + c] += half);
        }
    }
}

/// Gives middles of edges the mean of both ends.
pub(super) fn to_middles(tets: &Tets, displacement: &mut [f64]) {
    for [middle, ends @ ..] in middles(tets) {
        for c in 0..3 {
            let [a, b] = ends.map(|end| displacement[3 * end as usize + c]);
            displacement[3 * middle as usize + c] = 0.5 * (a + b);
        }
    }
}

/// The middles of edges with both ends, as often as cells have them.
fn middles<'t>(tets: &'t Tets) -> impl Iterator<Item = [u32; 3]> + 't {
    let of_cell = |(corners, middles): (&'t [u32; 4], &'t [u32; 6])| {
        let ends = super::tets::EDGES.into_iter().zip(middles);
        ends.map(|([a, b], &middle)| [middle, corners[a], corners[b]])
    };
    tets.corners.iter().zip(&tets.middles).flat_map(of_cell)
}
