use std::ops::Range;

use pulp::Arch;
use rayon::prelude::*;

use super::blocks::Blocks;
use super::dense::inverse;
use super::packed::{Packed, Single, add, single, subtract};

/// One level of a hierarchy: its matrix and the inverses of its diagonal blocks, for Gauss-Seidel sweeps by nodes.
///
/// The sweeps take chunks of consecutive nodes by colours: chunks of one colour are not coupled and are swept at the
/// same time. That is Gauss-Seidel in one fixed order, for any number of threads (sweeping chunks as in Jacobi's method
/// instead loses definiteness on hexahedra).
#[derive(Debug, Clone)]
pub struct Level<const R: usize> {
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

impl<const R: usize> Level<R> {
    pub fn new(a: &Blocks<R, R>) -> Self {
        let inverse = (0..a.rows).into_par_iter().map(|i| single(&inverse(&a.diagonal(i)))).collect();
        let colour = colours(a);
        let count = colour.iter().map(|&c| c as usize + 1).max().unwrap_or(0);
        let mut by_colour = vec![Vec::new(); count];
        colour.iter().enumerate().for_each(|(chunk, &c)| by_colour[c as usize].push(chunk as u32));
        Level { matrix: Packed::new(a), inverse, colour, by_colour }
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
    pub fn forward(&self, b: &[[f32; R]]) -> (Vec<[f32; R]>, Vec<[f32; R]>) {
        let mut x = vec![[0.0; R]; b.len()];
        for (c, colour) in self.by_colour.iter().enumerate() {
            self.sweep(colour, &mut x, |nodes, before| {
                let first = nodes.start;
                let mut own = vec![[0.0; R]; nodes.len()];
                Arch::new().dispatch(|| {
                    for i in nodes.clone() {
                        let mut rest = b[i];
                        let (columns, blocks) = self.matrix.row(i);
                        for (&j, a) in columns.iter().zip(blocks) {
                            let j = j as usize;
                            if nodes.contains(&j) {
                                if j < i {
                                    subtract(a, &own[j - first], &mut rest);
                                }
                            } else if c > 0 {
                                subtract(a, &before[j], &mut rest);
                            }
                        }
                        add(&self.inverse[i], &rest, &mut own[i - first]);
                    }
                });
                own
            });
        }
        // A row is exact up to its own node: what is left comes from the nodes swept later.
        let mut residual = vec![[0.0; R]; b.len()];
        residual.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, residual)| {
            let nodes = self.nodes(chunk);
            Arch::new().dispatch(|| {
                for (i, r) in nodes.clone().zip(residual.iter_mut()) {
                    let (columns, blocks) = self.matrix.row(i);
                    for (&j, a) in columns.iter().zip(blocks) {
                        let j = j as usize;
                        let later =
                            if nodes.contains(&j) { j > i } else { self.colour[chunk_of(j)] > self.colour[chunk] };
                        if later {
                            subtract(a, &x[j], r);
                        }
                    }
                }
            });
        });
        (x, residual)
    }

    /// One backward sweep for `A x = b` from `x`.
    pub fn backward(&self, b: &[[f32; R]], x: &mut [[f32; R]]) {
        for colour in self.by_colour.iter().rev() {
            self.sweep(colour, x, |nodes, before| {
                let first = nodes.start;
                let mut own = before[nodes.clone()].to_vec();
                Arch::new().dispatch(|| {
                    for i in nodes.clone().rev() {
                        let mut rest = b[i];
                        let (columns, blocks) = self.matrix.row(i);
                        for (&j, a) in columns.iter().zip(blocks) {
                            let j = j as usize;
                            if j != i {
                                let value = if nodes.contains(&j) { &own[j - first] } else { &before[j] };
                                subtract(a, value, &mut rest);
                            }
                        }
                        own[i - first] = [0.0; R];
                        add(&self.inverse[i], &rest, &mut own[i - first]);
                    }
                });
                own
            });
        }
    }
}

/// The least colour for each chunk that none of the chunks before it which it is coupled to has.
fn colours<const R: usize>(a: &Blocks<R, R>) -> Vec<u32> {
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
