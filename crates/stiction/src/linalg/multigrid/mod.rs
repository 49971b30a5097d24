//! Smoothed-aggregation multigrid for elasticity (Vanek, Mandel & Brezina 1996): blocks by nodes, six rigid motions a
//! coarse node, set up in double and cycled in single precision.

// Small dense blocks are told by their indices.
#![allow(clippy::needless_range_loop)]

mod aggregate;
mod blocks;
mod bottom;
mod coarsen;
mod coupling;
mod dense;
mod distance;
mod following;
mod nested;
mod packed;
mod smoother;
#[cfg(test)]
mod tests;
mod truncate;

pub use blocks::{Block, Blocks, Nodes};
pub use coarsen::Kernel;
pub use coupling::Coupling;
pub use dense::inverse;
pub use nested::Nested;
pub use truncate::Condition;

use bottom::Bottom;
use coarsen::{coarsen, copied};
use following::Following;
use packed::{Packed, scaled, unit};
use smoother::Level;
use truncate::Local;

/// A hierarchy of matrices, used as a preconditioner: one V-cycle with a forward Gauss-Seidel sweep before and a
/// backward one after the coarse correction, which is symmetric and positive definite.
#[derive(Debug, Clone)]
pub struct Multigrid {
    fine: Level<3, 4>,
    /// From the first coarse level to the fine one.
    first: Packed<3, 6>,
    coarse: Vec<Level<6, 8>>,
    /// Cycles on each coarse level for one on the level before it.
    repeats: Vec<usize>,
    /// From each further level to the one before it.
    further: Vec<Packed<6, 6>>,
    bottom: Bottom,
    /// Nodes with held components.
    held: Vec<(u32, [bool; 3])>,
    /// Nodes whose second and third rows lose so much of their first.
    follows: Vec<(u32, [f32; 2])>,
    /// The same on the coarse levels, as of their last change.
    following: Following,
    local: Local,
}

/// Couplings weaker than this do not join nodes into aggregates on the finest level.
const STRONG: f64 = 0.05;
/// The same on coarse levels, where couplings within a body are weaker; those of materials with a contrast of ten
/// thousand are 0.01 at most.
const STRONG_COARSE: f64 = 0.025;
/// Nodes of the coarsest level at most, where that can be had.
const BOTTOM: usize = 50;
/// More than so many make the dense factor of the coarsest matrix, renewed with every change, dearer than it is worth.
const BOTTOM_MOST: usize = 300;
/// Coarsening ends here at the latest.
const LEVELS: usize = 12;

/// Cycles on a coarse level for one on the level before it, where they cost little. Functions truncated at held components
/// leave matrices that the further levels, made without them, know badly: with one cycle on each level the second alone
/// slows the rate on a face in contact from 0.19 to 0.28, and where friction follows the normal force from 0.30 to 0.41.
const REPEATS: usize = 3;
/// What the numbers read on all visits of a coarse level may be of those of the finest matrix: cells flat along one side
/// coarsen along lines, and three visits of each level would cost more on every coarser one.
const SHARE: f64 = 0.25;

impl Multigrid {
    /// Sets up the hierarchy of a symmetric positive definite matrix with its near-kernel, three rows a node (the
    /// rigid motions for elasticity). Only `constrained` nodes can be constrained later. `None` if the matrix does
    /// not get coarse by aggregation.
    ///
    /// With a coupling the hierarchy is that of the matrix of relative displacements, which `a` is made
    /// ([`Coupling::make_relative`]); its coarse spaces are those of `a` as it was given, so that bodies which only contact
    /// holds together stay apart.
    pub fn new(
        a: &mut Blocks<3, 3>,
        kernel: &[Kernel<3>],
        constrained: &[u32],
        coupling: Option<&Coupling>,
    ) -> Option<Multigrid> {
        let small = || (a.rows <= BOTTOM_MOST).then(|| copied(a, kernel, constrained)).flatten();
        let mut step = coarsen(a, kernel, STRONG, constrained).or_else(small)?;
        if let Some(coupling) = coupling {
            coupling.make_relative(a);
            step = coupling.relative(step, a);
        }
        let mut local = Local::new(a, &step, constrained);
        let first = Packed::new(&step.prolongation);
        // What is used up makes room for the next: memory touched for the first time is a good part of a set-up.
        drop(step.prolongation);
        let fine = Level::new(a);
        let (mut matrix, mut kernel) = (step.matrix, step.kernel);
        let (mut coarse, mut further) = (Vec::new(), Vec::new());
        while matrix.rows > BOTTOM && coarse.len() < LEVELS {
            let Some(step) = coarsen(&matrix, &kernel, STRONG_COARSE, &[]) else { break };
            let (level, prolongation) = (Level::new(&matrix), Packed::new(&step.prolongation));
            local.add_level(&matrix, &prolongation);
            coarse.push(level);
            further.push(prolongation);
            (matrix, kernel) = (step.matrix, step.kernel);
        }
        if matrix.rows > BOTTOM_MOST {
            return None;
        }
        let bottom = Bottom::new(&matrix);
        local.set_bottom(matrix);
        let (repeats, held, follows, following) = Default::default();
        let mut all = Multigrid { fine, first, coarse, repeats, further, bottom, held, follows, following, local };
        all.repeats = repeats_within_share(&all.numbers());
        Some(all)
    }

    /// Whether some motion costs no energy under the present conditions, as far as the coarsest level can tell: the
    /// near-kernel is represented there exactly.
    pub fn is_singular(&self) -> bool {
        self.bottom.singular > 0
    }

    /// Nodes of each level, the finest first, and how many numbers its matrix stores.
    pub fn numbers(&self) -> Vec<(usize, usize)> {
        let fine = (self.fine.matrix.rows, 9 * self.fine.matrix.value.len());
        let coarse = self.coarse.iter().map(|l| (l.matrix.rows, 36 * l.matrix.value.len()));
        let bottom = self.bottom.nodes();
        [fine].into_iter().chain(coarse).chain([(bottom, 36 * bottom * bottom)]).collect()
    }

    /// One V-cycle for `A x = b` from zero; `b` is zero on held components. Where components follow the force that holds
    /// another the finest level solves the unsymmetric system, and the coarse ones know of it by what they are handed.
    pub fn cycle(&self, b: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let (scale, b) = unit(b);
        if !scale.is_finite() {
            return vec![[0.0; 3]; b.len()];
        }
        let (mut x, residual) = self.fine.forward(&b);
        let coarse = self.hand_down(&x, residual);
        self.first.add_times(&self.cycles_from(0, &coarse), &mut x);
        self.hold(&mut x);
        self.fine.backward(&b, &mut x);
        scaled(scale, &x)
    }

    /// Zeroes held components.
    fn hold(&self, x: &mut [[f32; 3]]) {
        for &(v, held) in &self.held {
            (0..3).filter(|&c| held[c]).for_each(|c| x[v as usize][c] = 0.0);
        }
    }

    fn first_coarse(&self) -> usize {
        self.coarse.first().map_or(self.bottom.nodes(), |l| l.matrix.rows)
    }

    fn cycle_from(&self, level: usize, b: &[[f32; 6]]) -> Vec<[f32; 6]> {
        let Some(here) = self.coarse.get(level) else { return self.bottom.solve(b) };
        let (mut x, residual) = here.forward(b);
        let coarser = self.coarse.get(level + 1).map_or(self.bottom.nodes(), |l| l.matrix.rows);
        let coarse = self.further[level].transpose_times(&residual, coarser);
        self.further[level].add_times(&self.cycles_from(level + 1, &coarse), &mut x);
        here.backward(b, &mut x);
        x
    }

    /// So many cycles from this level as it is worth, each on the residual of those before: as symmetric and definite as one.
    fn cycles_from(&self, level: usize, b: &[[f32; 6]]) -> Vec<[f32; 6]> {
        let mut x = self.cycle_from(level, b);
        let Some(here) = self.coarse.get(level) else { return x };
        for _ in 1..self.repeats[level] {
            let mut rest = vec![[0.0; 6]; b.len()];
            here.matrix.add_times(&x, &mut rest);
            rest.iter_mut().flatten().zip(b.iter().flatten()).for_each(|(r, b)| *r = b - *r);
            self.subtract_following(level, &x, &mut rest);
            let more = self.cycle_from(level, &rest);
            x.iter_mut().flatten().zip(more.iter().flatten()).for_each(|(x, m)| *x += m);
        }
        x
    }
}

/// Cycles on the coarse levels, [`REPEATS`] where all visits of a level together stay within [`SHARE`]; `numbers` are those
/// of [`Multigrid::numbers`].
fn repeats_within_share(numbers: &[(usize, usize)]) -> Vec<usize> {
    let within = SHARE * numbers[0].1 as f64;
    let mut visits = 1;
    let coarse = numbers.windows(2).enumerate().skip(1).map(|(level, pair)| {
        let bottom = if level + 2 == numbers.len() { pair[1].1 } else { 0 };
        let most = within / (visits * (pair[0].1 + bottom).max(1)) as f64;
        let repeats = (most as usize).clamp(1, REPEATS);
        visits *= repeats;
        repeats
    });
    coarse.collect()
}
