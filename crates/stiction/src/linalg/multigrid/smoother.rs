use std::ops::Range;

use rayon::prelude::*;

use super::blocks::{Block, Blocks};
use super::dense::inverse;
use super::packed::{Packed, Single, Sum, single};
use crate::linalg::vectorised;

/// One level of a hierarchy: its matrix and the inverses of its diagonal blocks, for Gauss-Seidel sweeps by nodes. Sums take
/// `W >= R` lanes.
///
/// The sweeps take chunks of consecutive nodes by colours: chunks of one colour are not coupled and are swept at the
/// same time. That is Gauss-Seidel in one fixed order, for any number of threads (sweeping chunks as in Jacobi's method
/// instead loses definiteness on hexahedra).
#[derive(Debug, Clone)]
pub(super) struct Level<const R: usize, const W: usize> {
    pub matrix: Packed<R, R>,
    pub inverse: Vec<Single<R, R>>,
    /// Colour of each chunk.
    colour: Vec<u32>,
    /// Chunks by colour.
    by_colour: Vec<Vec<u32>>,
}

/// Nodes of a chunk.
const CHUNK: usize = 2048;

fn chunk_of(node: usize) -> usize {
    node / CHUNK
}

impl<const R: usize, const W: usize> Level<R, W> {
    pub(super) fn new(a: &Blocks<R, R>) -> Self {
        Self::of(Packed::new(a), |i| a.diagonal(i))
    }

    /// Of a matrix, and its diagonal blocks in double precision.
    pub(super) fn of(matrix: Packed<R, R>, diagonal: impl Fn(usize) -> Block<R, R> + Sync) -> Self {
        let inverse = (0..matrix.rows).into_par_iter().map(|i| single(&inverse(&diagonal(i)))).collect();
        let colour = colours(&matrix);
        let count = colour.iter().map(|&c| c as usize + 1).max().unwrap_or(0);
        let mut by_colour = vec![Vec::new(); count];
        colour.iter().enumerate().for_each(|(chunk, &c)| by_colour[c as usize].push(chunk as u32));
        Level { matrix, inverse, colour, by_colour }
    }

    fn nodes(&self, chunk: usize) -> Range<usize> {
        chunk * CHUNK..self.matrix.rows.min((chunk + 1) * CHUNK)
    }

    /// New values of the chunks of one colour, written after all of them are known.
    fn sweep(
        &self,
        colour: &[u32],
        x: &mut [[f32; R]],
        new: impl Fn(Range<usize>, &[[f32; R]]) -> Vec<[f32; R]> + Sync,
    ) {
        let swept = |&chunk: &u32| new(self.nodes(chunk as usize), x);
        let parts: Vec<Vec<[f32; R]>> = colour.par_iter().map(swept).collect();
        for (&chunk, part) in colour.iter().zip(parts) {
            x[self.nodes(chunk as usize)].copy_from_slice(&part);
        }
    }

    /// One forward sweep for `A x = b` from zero, with the residual it leaves.
    pub(super) fn forward(&self, b: &[[f32; R]]) -> (Vec<[f32; R]>, Vec<[f32; R]>) {
        let (entries, inverses) = self.entries();
        let mut x = vec![[0.0; R]; b.len()];
        for (c, colour) in self.by_colour.iter().enumerate() {
            self.sweep(colour, &mut x, |nodes, before| {
                let first = nodes.start;
                let mut own = vec![[0.0; R]; nodes.len()];
                vectorised(
                    #[inline(always)]
                    || {
                        for i in nodes.clone() {
                            let mut sum = Sum::<R, R, W>::zero();
                            for place in self.matrix.start[i]..self.matrix.start[i + 1] {
                                let j = self.matrix.column[place] as usize;
                                if nodes.contains(&j) {
                                    if j < i {
                                        sum.add(entries, place, &own[j - first]);
                                    }
                                } else if c > 0 {
                                    sum.add(entries, place, &before[j]);
                                }
                            }
                            own[i - first] = step(inverses, i, &b[i], &sum);
                        }
                    },
                );
                own
            });
        }
        // The sweep satisfies a row up to its own node: its residual comes from the nodes swept later.
        let mut residual = vec![[0.0; R]; b.len()];
        residual.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, residual)| {
            let nodes = self.nodes(chunk);
            vectorised(
                #[inline(always)]
                || {
                    for (i, r) in nodes.clone().zip(residual.iter_mut()) {
                        let mut sum = Sum::<R, R, W>::zero();
                        for place in self.matrix.start[i]..self.matrix.start[i + 1] {
                            let j = self.matrix.column[place] as usize;
                            let later =
                                if nodes.contains(&j) { j > i } else { self.colour[chunk_of(j)] > self.colour[chunk] };
                            if later {
                                sum.add(entries, place, &x[j]);
                            }
                        }
                        *r = sum.total().map(|sum| -sum);
                    }
                },
            );
        });
        (x, residual)
    }

    /// One backward sweep for `A x = b` from `x`.
    pub(super) fn backward(&self, b: &[[f32; R]], x: &mut [[f32; R]]) {
        let (entries, inverses) = self.entries();
        for colour in self.by_colour.iter().rev() {
            self.sweep(colour, x, |nodes, before| {
                let first = nodes.start;
                let mut own = before[nodes.clone()].to_vec();
                vectorised(
                    #[inline(always)]
                    || {
                        for i in nodes.clone().rev() {
                            let mut sum = Sum::<R, R, W>::zero();
                            // The sum is over the other nodes of the row.
                            own[i - first] = [0.0; R];
                            // Backwards as well: what comes next in memory is fetched ahead of its use.
                            for place in (self.matrix.start[i]..self.matrix.start[i + 1]).rev() {
                                let j = self.matrix.column[place] as usize;
                                let x = if nodes.contains(&j) { &own[j - first] } else { &before[j] };
                                sum.add(entries, place, x);
                            }
                            own[i - first] = step(inverses, i, &b[i], &sum);
                        }
                    },
                );
                own
            });
        }
    }

    /// All numbers of the matrix, and of the inverses.
    fn entries(&self) -> (&[f32], &[f32]) {
        (self.matrix.value.as_flattened().as_flattened(), self.inverse.as_flattened().as_flattened())
    }
}

/// The value of a node that satisfies its row, where the other nodes contribute `sum`.
#[inline(always)]
fn step<const R: usize, const W: usize>(inverses: &[f32], node: usize, b: &[f32; R], sum: &Sum<R, R, W>) -> [f32; R] {
    let sum = sum.total();
    let mut x = Sum::<R, R, W>::zero();
    x.add(inverses, node, &std::array::from_fn(|r| b[r] - sum[r]));
    x.total()
}

/// The least colour for each chunk that none of the chunks before it which it is coupled to has.
fn colours<const R: usize>(a: &Packed<R, R>) -> Vec<u32> {
    let chunks = a.rows.div_ceil(CHUNK);
    let mut colour = vec![0u32; chunks];
    for chunk in 0..chunks {
        let nodes = chunk * CHUNK..a.rows.min((chunk + 1) * CHUNK);
        let mut taken = vec![false; chunk + 1];
        for i in nodes {
            let before = a.row(i).0.iter().map(|&j| chunk_of(j as usize)).take_while(|&other| other < chunk);
            before.for_each(|other| taken[colour[other] as usize] = true);
        }
        colour[chunk] = taken.iter().position(|&t| !t).unwrap_or(chunk) as u32;
    }
    colour
}
