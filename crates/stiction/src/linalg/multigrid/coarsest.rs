use crate::linalg::{kernels, vectorised};

use super::blocks::Blocks;
use super::dense::NO_STIFFNESS;

/// The dense Cholesky factor of the coarsest matrix, or of that of a few nodes; singular directions are left out.
#[derive(Debug, Clone, Default)]
pub(super) struct CoarsestFactor {
    size: usize,
    /// By columns.
    lower: Vec<f64>,
    /// Number of singular directions.
    pub singular: usize,
}

/// A pivot below this multiple of its diagonal entry counts as zero.
const SINGULAR: f64 = 1e-10;

impl CoarsestFactor {
    pub(super) fn new(a: &Blocks<6, 6>) -> Self {
        let n = 6 * a.rows;
        let mut lower = vec![0.0; n * n];
        for i in 0..a.rows {
            for (j, block) in a.entries_of(i) {
                for (r, row) in block.iter().enumerate() {
                    for (c, &v) in row.iter().enumerate() {
                        lower[(6 * j as usize + c) * n + 6 * i + r] = v;
                    }
                }
            }
        }
        CoarsestFactor::of(n, lower)
    }

    /// Of a matrix of `n` rows, by columns, of which what is below the diagonal counts.
    pub(super) fn of(n: usize, mut lower: Vec<f64>) -> Self {
        let least = NO_STIFFNESS * (0..n).map(|k| lower[k * n + k]).fold(0.0, f64::max);
        let mut singular = 0;
        for k in 0..n {
            let (done, rest) = lower.split_at_mut(k * n);
            let column = &mut rest[..n];
            let diagonal = column[k];
            vectorised(
                #[inline(always)]
                || {
                    for j in 0..k {
                        let factor = done[j * n + k];
                        if factor != 0.0 {
                            for (c, l) in column[k..].iter_mut().zip(&done[j * n + k..(j + 1) * n]) {
                                *c -= factor * l;
                            }
                        }
                    }
                },
            );
            let pivot = column[k];
            if pivot > (SINGULAR * diagonal).max(least) {
                let scale = 1.0 / pivot.sqrt();
                column[k..].iter_mut().for_each(|c| *c *= scale);
            } else {
                column[k..].fill(0.0);
                column[k] = f64::INFINITY;
                singular += 1;
            }
        }
        CoarsestFactor { size: n, lower, singular }
    }

    /// `A⁻¹ b`.
    pub(super) fn solve(&self, b: &[[f32; 6]]) -> Vec<[f32; 6]> {
        let mut x: Vec<f64> = b.iter().flatten().map(|&v| f64::from(v)).collect();
        self.solve_in_place(&mut x);
        x.as_chunks().0.iter().map(|c: &[f64; 6]| c.map(|v| v as f32)).collect()
    }

    /// The same for as many numbers as the matrix has rows.
    pub(super) fn solve_in_place(&self, x: &mut [f64]) {
        kernels::forward(&self.lower, self.size, self.size, x);
        kernels::backward(&self.lower, self.size, self.size, x);
    }
}
