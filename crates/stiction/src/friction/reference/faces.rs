use std::cell::RefCell;

use super::lagrangian::{Block, Lagrangian};
use crate::linalg::SmallLu;

/// Preconditioner of the faces of a block: the matrix `A + rho CᵀC` among the multipliers of each point, all copies
/// together, with the fixed entries taken out. The coupling acts within points only, so that a large `rho` costs no
/// steps: what is left is the conditioning of `Q`.
#[derive(Debug)]
pub(super) struct PointBlocks {
    size: usize,
    points: Vec<PointBlock>,
}

#[derive(Debug)]
struct PointBlock {
    /// Entries of the block's vector.
    entries: Vec<usize>,
    /// Among them, row by row.
    matrix: Vec<f64>,
    /// The last set of free entries with the factor of its part of the matrix.
    factor: RefCell<(Vec<usize>, SmallLu)>,
}

impl PointBlocks {
    pub(super) fn new(lagrangian: &Lagrangian<'_>, block: &Block) -> Self {
        let points = (0..lagrangian.q.points()).map(|j| PointBlock::new(lagrangian, block, j)).collect();
        PointBlocks { size: block.copies.len() * block.rows.len(), points }
    }

    /// The inverse on the free entries, zero elsewhere.
    pub(super) fn solve(&self, r: &[f64], free: &[bool]) -> Vec<f64> {
        let mut z = vec![0.0; self.size];
        self.points.iter().for_each(|point| point.solve(r, free, &mut z));
        z
    }
}

impl PointBlock {
    fn new(lagrangian: &Lagrangian<'_>, block: &Block, j: usize) -> Self {
        let m = lagrangian.q.points();
        // (copy, place among the three multipliers of the point, entry of the block's vector)
        let mut unknowns = Vec::new();
        for i in block.copies.clone() {
            let rows = [j, m + j, 2 * m + j].into_iter().enumerate().filter(|(_, row)| block.rows.contains(row));
            let first = (i - block.copies.start) * block.rows.len();
            unknowns.extend(rows.map(|(place, row)| (i, place, first + row - block.rows.start)));
        }
        let (local, count) = (lagrangian.q.local(j), lagrangian.squares.count);
        let coupling = |a: usize, b: usize| lagrangian.penalty * lagrangian.coupling.entry(count, a, b);
        let entry = |&(a, p, _): &(usize, usize, usize), &(b, q, _): &(usize, usize, usize)| {
            let (turn_a, turn_b) = (lagrangian.squares.rotation(a, j), lagrangian.squares.rotation(b, j));
            let between = (0..3).map(|k| turn_a[p][k] * turn_b[q][k]).sum::<f64>() * coupling(a, b);
            let own = |k: usize| (0..3).map(|l| turn_a[p][k] * local[k][l] * turn_b[q][l]).sum::<f64>();
            between + if a == b { (0..3).map(own).sum::<f64>() / count as f64 } else { 0.0 }
        };
        let matrix = unknowns.iter().flat_map(|a| unknowns.iter().map(move |b| entry(a, b))).collect();
        let factor = RefCell::new((Vec::new(), SmallLu::new(Vec::new())));
        PointBlock { entries: unknowns.iter().map(|u| u.2).collect(), matrix, factor }
    }

    fn solve(&self, r: &[f64], free: &[bool], z: &mut [f64]) {
        let chosen: Vec<usize> = (0..self.entries.len()).filter(|&k| free[self.entries[k]]).collect();
        let mut factor = self.factor.borrow_mut();
        if factor.0 != chosen {
            let row = |&i: &usize| chosen.iter().map(|&j| self.matrix[i * self.entries.len() + j]).collect();
            factor.1 = SmallLu::new(chosen.iter().map(row).collect());
            factor.0 = chosen;
        }
        let (chosen, lu) = &*factor;
        let x = lu.solve(&chosen.iter().map(|&k| r[self.entries[k]]).collect::<Vec<f64>>());
        chosen.iter().zip(x).for_each(|(&k, x)| z[self.entries[k]] = x);
    }
}
