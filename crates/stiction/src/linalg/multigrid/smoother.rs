use std::ops::Range;

use rayon::prelude::*;

use super::blocks::{Block, Blocks};
use super::dense::{add_product, inverse_beside, largest_diagonal};
use super::packed::{Packed, Single, Sum, add, double, single, subtract};
use crate::linalg::vectorised;
use crate::ranks::Halo;

/// One level of a hierarchy: its matrix and the inverses of its diagonal blocks, for Gauss-Seidel sweeps by nodes. Sums take
/// `W >= R` lanes.
///
/// The sweeps take chunks of consecutive nodes by colours: chunks of one colour are not coupled and are swept at the
/// same time. That is Gauss-Seidel in one fixed order, for any number of threads (sweeping chunks as in Jacobi's method
/// instead loses definiteness on hexahedra).
///
/// Between ranks the sweeps are Jacobi's: values at ghosts are those of the last exchange. What is lost is made good by
/// damping ([`Level::damp`]).
#[derive(Debug, Clone)]
pub(super) struct Level<const R: usize, const W: usize> {
    pub matrix: Packed<R, R>,
    pub inverse: Vec<Single<R, R>>,
    /// The largest diagonal entry of the matrix without constraints, on all ranks.
    pub largest: f64,
    /// Colour of each chunk.
    colour: Vec<u32>,
    /// Chunks by colour.
    by_colour: Vec<Vec<u32>>,
    /// How the nodes are divided; the matrix has the rows of this rank.
    pub halo: Halo,
    /// The nodes coupled to ghosts, and where the ghosts begin in each row; none where there are no ghosts.
    interface: Vec<u32>,
    ghosts: Vec<usize>,
    /// What a step of each node is multiplied with; none where there are no ghosts.
    damping: Vec<f32>,
    /// What the couplings with ghosts amount to, over the sum of their norms.
    share: f64,
    /// The inverses at ghosts, and the exchange of those that may change.
    ghost_inverse: Vec<Single<R, R>>,
    changing: Halo,
}

/// Steps of the power iteration for [`Level::damp_less`], and what its result, which is too small, is multiplied with.
const POWER_STEPS: usize = 12;
const SAFETY: f64 = 1.1;

/// Nodes of a chunk.
const CHUNK: usize = 2048;

fn chunk_of(node: usize) -> usize {
    node / CHUNK
}

impl<const R: usize, const W: usize> Level<R, W> {
    pub(super) fn new(a: &Blocks<R, R>, halo: Halo) -> Self {
        Self::of(Packed::new(a), halo, |i| a.diagonal(i))
    }

    /// Of a matrix, and its diagonal blocks in double precision.
    pub(super) fn of(matrix: Packed<R, R>, halo: Halo, diagonal: impl Fn(usize) -> Block<R, R> + Sync) -> Self {
        let largest = largest_diagonal(&diagonal, &halo);
        let inverse: Vec<Single<R, R>> =
            (0..matrix.rows).into_par_iter().map(|i| single(&inverse_beside(&diagonal(i), largest))).collect();
        let colour = colours(&matrix);
        let count = colour.iter().map(|&c| c as usize + 1).max().unwrap_or(0);
        let mut by_colour = vec![Vec::new(); count];
        colour.iter().enumerate().for_each(|(chunk, &c)| by_colour[c as usize].push(chunk as u32));
        let (mut interface, mut ghosts) = (Vec::new(), Vec::new());
        if !halo.is_alone() {
            let begin = |i: usize| matrix.start[i] + matrix.row(i).0.partition_point(|&j| (j as usize) < halo.own());
            ghosts = (0..matrix.rows).map(begin).collect();
            interface =
                (0..matrix.rows as u32).filter(|&i| ghosts[i as usize] < matrix.start[i as usize + 1]).collect();
        }
        let damping = vec![1.0; ghosts.len()];
        let (ghost_inverse, changing) =
            (halo.extended(&inverse)[matrix.rows..].to_vec(), halo.only(std::iter::empty()));
        let mut level = Level {
            matrix,
            inverse,
            largest,
            colour,
            by_colour,
            halo,
            interface,
            ghosts,
            damping,
            share: 1.0,
            ghost_inverse,
            changing,
        };
        level.damp();
        level
    }

    /// Makes known which own rows may change: their inverses are sent to other ranks each time.
    pub(super) fn expect_changes(&mut self, rows: &[u32]) {
        self.changing = self.halo.of_flagged(rows);
    }

    /// Damps the steps at the border so that the sweeps stay definite however the nodes are divided.
    ///
    /// With `s_i` the sum of `|D_i^-1/2 A_ij D_j^-1/2|` over the ghosts `j`, a step of node `i` is that with the diagonal block
    /// `(1 + s_i) / 2 D_i` where `s_i > 1`. Then the forward sweep `M` has `M + Mᵀ - A >= 0`: l1-Gauss-Seidel (Baker, Falgout,
    /// Kolev & Yang 2011) in norms of blocks. Without it hexahedra lose definiteness.
    pub(super) fn damp(&mut self) {
        if self.halo.is_alone() {
            return;
        }
        let inverses = self.changing.extended(&self.inverse);
        for &k in self.changing.neighbours().0.iter().flat_map(|(_, places)| places) {
            self.ghost_inverse[k as usize - self.matrix.rows] = inverses[k as usize];
        }
        let sums = self.border_sums();
        for (&i, sum) in self.interface.iter().zip(&sums) {
            let sum = self.share * sum;
            self.damping[i as usize] = if sum > 1.0 { (2.0 / (1.0 + sum)) as f32 } else { 1.0 };
        }
    }

    /// `s_i` of the nodes coupled to ghosts.
    fn border_sums(&self) -> Vec<f64> {
        let coupling = |i: usize, place: usize| {
            let j = self.matrix.column[place] as usize;
            let other = &self.ghost_inverse[j - self.matrix.rows];
            let [own, other, a] = [&self.inverse[i], other, &self.matrix.value[place]].map(double);
            let transposed: Block<R, R> = std::array::from_fn(|r| std::array::from_fn(|c| a[c][r]));
            let product = |a: &Block<R, R>, b: &Block<R, R>| {
                let mut c = [[0.0; R]; R];
                add_product(a, b, &mut c);
                c
            };
            // Its eigenvalues are the squares of the singular values that are asked for. The largest is at most the fourth
            // root of the trace of its fourth power, and hardly less.
            let square = product(&product(&own, &a), &product(&other, &transposed));
            let fourth = product(&square, &square);
            let trace: f64 =
                (0..R).flat_map(|r| (0..R).map(move |c| (r, c))).map(|(r, c)| fourth[r][c] * fourth[c][r]).sum();
            trace.max(0.0).powf(0.125)
        };
        let places = |i: usize| self.ghosts[i]..self.matrix.start[i + 1];
        self.interface.iter().map(|&i| places(i as usize).map(|place| coupling(i as usize, place)).sum()).collect()
    }

    /// Damps less, as far as the couplings between ranks cancel: with `theta` the largest eigenvalue of `A_off x = theta S D x`,
    /// `A_off` the blocks of ghosts and `S` the sums of their norms, steps with `(1 + theta s_i) / 2 D_i` suffice. Of cells with many
    /// nodes `theta` is a fraction of its bound one. It stays right where components are constrained or diagonal blocks grow. Where Coulomb
    /// coupling lengthens steps there is no margin left: linear cells, which gain nothing, take 26 cycles in place of 20 then.
    pub(super) fn damp_less(&mut self) {
        if self.halo.is_alone() {
            return;
        }
        let sums = self.border_sums();
        let mut x: Vec<[f64; R]> = vec![[0.0; R]; self.halo.own()];
        for &i in &self.interface {
            // Different on every node of every rank.
            let seed = self.halo.global(i as usize) as f64;
            x[i as usize] = std::array::from_fn(|c| ((seed * R as f64 + c as f64) * 1.618).fract() - 0.5);
        }
        let mut share: f64 = 0.0;
        for step in 0..=POWER_STEPS {
            self.halo.update(&mut x);
            let mut next = vec![[0.0; R]; self.halo.own()];
            let mut energy = [0.0];
            for (&i, sum) in self.interface.iter().zip(&sums) {
                let i = i as usize;
                let mut forces = [0.0; R];
                for place in self.ghosts[i]..self.matrix.start[i + 1] {
                    let (a, x) = (double(&self.matrix.value[place]), &x[self.matrix.column[place] as usize]);
                    (0..R).for_each(|r| forces[r] += (0..R).map(|c| a[r][c] * x[c]).sum::<f64>());
                }
                let inverse = double(&self.inverse[i]);
                let scale = 1.0 / sum.max(f64::MIN_POSITIVE);
                next[i] = std::array::from_fn(|r| scale * (0..R).map(|c| inverse[r][c] * forces[c]).sum::<f64>());
                energy[0] += (0..R).map(|r| next[i][r] * forces[r]).sum::<f64>();
            }
            self.halo.sum(&mut energy);
            // In the norm of `S D`, in which the iterate before has unit length.
            let length = energy[0].sqrt();
            if step > 0 {
                share = f64::max(share, length);
            }
            let scale = length.max(f64::MIN_POSITIVE).recip();
            next.iter_mut().flatten().for_each(|x| *x *= scale);
            x = next;
        }
        self.share = (SAFETY * share).min(1.0);
        self.damp();
    }

    /// What a step of a node is multiplied with.
    #[inline(always)]
    fn damping(&self, i: usize) -> f32 {
        if self.damping.is_empty() { 1.0 } else { self.damping[i] }
    }

    /// The blocks of row `i` without those of ghosts.
    #[inline(always)]
    fn own_places(&self, i: usize) -> Range<usize> {
        self.matrix.start[i]..if self.ghosts.is_empty() { self.matrix.start[i + 1] } else { self.ghosts[i] }
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

    /// One forward sweep for `A x = b` from zero, with the residual it leaves; `b` and the residual at own nodes, `x` at ghosts
    /// as well.
    pub(super) fn forward(&self, b: &[[f32; R]]) -> (Vec<[f32; R]>, Vec<[f32; R]>) {
        let (entries, inverses) = self.entries();
        let mut x = vec![[0.0; R]; self.halo.len()];
        for (c, colour) in self.by_colour.iter().enumerate() {
            self.sweep(colour, &mut x, |nodes, before| {
                let first = nodes.start;
                let mut own = vec![[0.0; R]; nodes.len()];
                vectorised(
                    #[inline(always)]
                    || {
                        for i in nodes.clone() {
                            let mut sum = Sum::<R, R, W>::zero();
                            for place in self.own_places(i) {
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
                            if self.damping(i) < 1.0 {
                                own[i - first] = own[i - first].map(|x| self.damping(i) * x);
                            }
                        }
                    },
                );
                own
            });
        }
        self.halo.update(&mut x);
        // The sweep satisfies a row up to its own node: its residual comes from the nodes swept later.
        let mut residual = vec![[0.0; R]; b.len()];
        residual.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, residual)| {
            let nodes = self.nodes(chunk);
            vectorised(
                #[inline(always)]
                || {
                    for (i, r) in nodes.clone().zip(residual.iter_mut()) {
                        let mut sum = Sum::<R, R, W>::zero();
                        for place in self.own_places(i) {
                            let j = self.matrix.column[place] as usize;
                            if self.is_later(j, i) {
                                sum.add(entries, place, &x[j]);
                            }
                        }
                        *r = sum.total().map(|sum| -sum);
                    }
                },
            );
        });
        for &i in &self.interface {
            self.add_border(i as usize, &b[i as usize], &x, &mut residual[i as usize]);
        }
        (x, residual)
    }

    /// Whether a node is swept after another one of this rank.
    #[inline(always)]
    fn is_later(&self, j: usize, i: usize) -> bool {
        let (other, own) = (chunk_of(j), chunk_of(i));
        if other == own { j > i } else { self.colour[other] > self.colour[own] }
    }

    /// Takes the products of the matrix with values at ghosts off a residual.
    pub(super) fn subtract_ghosts(&self, x: &[[f32; R]], residual: &mut [[f32; R]]) {
        for &i in &self.interface {
            for place in self.ghosts[i as usize]..self.matrix.start[i as usize + 1] {
                subtract(&self.matrix.value[place], &x[self.matrix.column[place] as usize], &mut residual[i as usize]);
            }
        }
    }

    /// What ghosts, and a step that was damped, leave in the residual of a row after a forward sweep to `x`.
    fn add_border(&self, i: usize, b: &[f32; R], x: &[[f32; R]], residual: &mut [f32; R]) {
        for place in self.ghosts[i]..self.matrix.start[i + 1] {
            subtract(&self.matrix.value[place], &x[self.matrix.column[place] as usize], residual);
        }
        let left = 1.0 - self.damping[i];
        if left > 0.0 {
            let mut before = [0.0; R];
            for place in self.own_places(i) {
                let j = self.matrix.column[place] as usize;
                if j != i && !self.is_later(j, i) {
                    add(&self.matrix.value[place], &x[j], &mut before);
                }
            }
            (0..R).for_each(|r| residual[r] += left * (b[r] - before[r]));
        }
    }

    /// One backward sweep for `A x = b` from `x`, whose ghosts are set before and not after.
    pub(super) fn backward(&self, b: &[[f32; R]], x: &mut Vec<[f32; R]>) {
        self.halo.update(x);
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
                            let old = std::mem::replace(&mut own[i - first], [0.0; R]);
                            // Backwards as well: what comes next in memory is fetched ahead of its use.
                            for place in (self.matrix.start[i]..self.matrix.start[i + 1]).rev() {
                                let j = self.matrix.column[place] as usize;
                                let x = if nodes.contains(&j) { &own[j - first] } else { &before[j] };
                                sum.add(entries, place, x);
                            }
                            own[i - first] = step(inverses, i, &b[i], &sum);
                            let damping = self.damping(i);
                            if damping < 1.0 {
                                let new = own[i - first];
                                own[i - first] = std::array::from_fn(|r| old[r] + damping * (new[r] - old[r]));
                            }
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
