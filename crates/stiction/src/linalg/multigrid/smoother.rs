use rayon::prelude::*;

use super::blocks::Blocks;
use super::dense::inverse;
use super::packed::{Packed, Single, add, single, subtract};

/// One level of a hierarchy: its matrix and the inverses of its diagonal blocks, for Gauss-Seidel sweeps by nodes.
///
/// Sweeps run over chunks of consecutive nodes, within a chunk one node after the other, between chunks with the
/// values from before the sweep: the same result for any number of threads.
#[derive(Debug, Clone)]
pub struct Level<const R: usize> {
    pub matrix: Packed<R, R>,
    pub inverse: Vec<Single<R, R>>,
}

/// Nodes of a chunk.
const CHUNK: usize = 8192;

impl<const R: usize> Level<R> {
    pub fn new(a: &Blocks<R, R>) -> Self {
        let inverse = (0..a.rows).into_par_iter().map(|i| single(&inverse(&a.diagonal(i)))).collect();
        Level { matrix: Packed::new(a), inverse }
    }

    /// One forward sweep for `A x = b` from zero, with the residual it leaves.
    pub fn forward(&self, b: &[[f32; R]]) -> (Vec<[f32; R]>, Vec<[f32; R]>) {
        let mut x = vec![[0.0; R]; b.len()];
        x.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, x)| {
            let first = chunk * CHUNK;
            for i in 0..x.len() {
                let mut rest = b[first + i];
                let (columns, blocks) = self.matrix.row(first + i);
                for (&j, a) in columns.iter().zip(blocks) {
                    let j = j as usize;
                    if j >= first + i {
                        break;
                    }
                    if j >= first {
                        subtract(a, &x[j - first], &mut rest);
                    }
                }
                add(&self.inverse[first + i], &rest, &mut x[i]);
            }
        });
        // Within its chunk a row is exact up to its own node: what is left comes from later nodes and other chunks.
        let mut residual = vec![[0.0; R]; b.len()];
        residual.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, residual)| {
            let first = chunk * CHUNK;
            for (i, r) in residual.iter_mut().enumerate() {
                let (columns, blocks) = self.matrix.row(first + i);
                for (&j, a) in columns.iter().zip(blocks) {
                    let j = j as usize;
                    if j > first + i || j < first {
                        subtract(a, &x[j], r);
                    }
                }
            }
        });
        (x, residual)
    }

    /// One backward sweep for `A x = b` from `x`.
    pub fn backward(&self, b: &[[f32; R]], x: &mut [[f32; R]]) {
        let chunks = x.len().div_ceil(CHUNK);
        let before = if chunks > 1 { x.to_vec() } else { Vec::new() };
        x.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, x)| {
            let first = chunk * CHUNK;
            let own = first..first + x.len();
            for i in (0..x.len()).rev() {
                let mut rest = b[first + i];
                let (columns, blocks) = self.matrix.row(first + i);
                for (&j, a) in columns.iter().zip(blocks) {
                    let j = j as usize;
                    if j == first + i {
                        continue;
                    }
                    let value = if own.contains(&j) { &x[j - first] } else { &before[j] };
                    subtract(a, value, &mut rest);
                }
                x[i] = [0.0; R];
                add(&self.inverse[first + i], &rest, &mut x[i]);
            }
        });
    }
}
