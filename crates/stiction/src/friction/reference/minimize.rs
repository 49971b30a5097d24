use std::iter::once;
use std::ops::Range;

use super::faces::PointBlocks;
use super::lagrangian::{Block, Copies, Lagrangian};
use super::method::{CopiesAtOnce, MethodCounts, MethodSettings, Minimization, Splitting, Sweeps};
use crate::friction::End;
use crate::linalg::norm;
use crate::qp::{Bounds, Program, QpSolution, QpStatus, minimize_in_bounds};

/// Step 1 of Uzawa's method: minimises the augmented Lagrangian over the boxes of the copies.
pub(super) struct Minimizer<'a> {
    pub lagrangian: &'a Lagrangian<'a>,
    settings: &'a MethodSettings,
    blocks: Vec<Block>,
    /// Preconditioners of the blocks.
    faces: Vec<PointBlocks>,
    sweeps: Sweeps,
}

/// Passes over the blocks after which Step 1 counts as not getting anywhere.
const MOST_SWEEPS: usize = 10_000;

impl<'a> Minimizer<'a> {
    pub(super) fn new(lagrangian: &'a Lagrangian<'a>, how: Minimization, settings: &'a MethodSettings) -> Self {
        let blocks = blocks(how, lagrangian.squares.count, lagrangian.q.points());
        let faces = blocks.iter().filter(|_| settings.precondition).map(|b| PointBlocks::new(lagrangian, b)).collect();
        // One block is done after one pass.
        let sweeps = if blocks.len() == 1 { Sweeps::One } else { how.sweeps };
        Minimizer { lagrangian, settings, blocks, faces, sweeps }
    }

    /// Block Gauss-Seidel.
    ///
    /// # Errors
    /// How the method ends if this came to no end; the copies are where it came to.
    pub(super) fn minimize(&self, copies: &mut Copies, bounds: &Bounds, counts: &mut MethodCounts) -> Result<(), End> {
        let load = self.lagrangian.load(&copies.w);
        for _ in 0..MOST_SWEEPS {
            let before = copies.x.clone();
            for (number, block) in self.blocks.iter().enumerate() {
                let b = self.lagrangian.block_load(block, &load, &copies.x);
                counts.flops += self.lagrangian.flops_of_load(block);
                counts.qp_problems += usize::from(block.rows.start == 0);
                let target = self.settings.inner_tolerance * norm(&b);
                let found = self.program(number, &b, copies, bounds, target, &mut |_, _| false, counts);
                self.lagrangian.put(block, &found.x, &mut copies.x);
                verdict(found.status)?;
            }
            let change = norm_of_difference(&copies.x, &before);
            if self.sweeps == Sweeps::One || change <= self.settings.sweep_tolerance * norm(&copies.x) {
                return Ok(());
            }
        }
        Err(End::Limit)
    }

    /// One quadratic program within simple bounds, started from the present copies.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn program(
        &self,
        number: usize,
        b: &[f64],
        copies: &Copies,
        bounds: &Bounds,
        target: f64,
        stop: &mut dyn FnMut(&[f64], f64) -> bool,
        counts: &mut MethodCounts,
    ) -> QpSolution {
        let (l, block) = (self.lagrangian, &self.blocks[number]);
        let repeated = |of: &[f64]| block.copies.clone().flat_map(|_| of[block.rows.clone()].to_vec()).collect();
        let bounds = Bounds { lower: repeated(&bounds.lower), upper: repeated(&bounds.upper) };
        let precondition = self.faces.get(number).map(|face| |r: &[f64], free: &[bool]| face.solve(r, free));
        let problem = Program {
            operator: &mut |x| l.times(block, x),
            b,
            largest_eigenvalue: Some(l.largest()),
            preconditioner: precondition.as_ref().map(|p| p as &crate::qp::Preconditioner),
        };
        let most = self.settings.max_cg_steps.saturating_sub(counts.steps());
        let start = l.take(block, &copies.x);
        let products = l.q.products();
        let found = minimize_in_bounds(problem, &bounds, &start, &self.settings.bounds, target, most, stop);
        counts.cg_steps += found.counts.cg_steps;
        counts.expansions += found.counts.expansions;
        counts.proportionings += found.counts.gradient_steps;
        counts.products += l.q.products() - products;
        counts.flops += found.counts.flops + found.counts.products as f64 * l.flops_of_product(block);
        counts.short_problems += usize::from(found.status == QpStatus::Stalled);
        found
    }
}

/// Whether the outer iteration may go on with what a quadratic program ended with.
pub(super) fn verdict(status: QpStatus) -> Result<(), End> {
    match status {
        // Rounding may keep a program from its tolerance; the outer iteration tells whether that matters.
        QpStatus::Solved | QpStatus::Interrupted | QpStatus::Stalled => Ok(()),
        QpStatus::Limit => Err(End::Limit),
        QpStatus::Indefinite | QpStatus::NotFinite | QpStatus::Empty => Err(End::Stalled),
    }
}

/// The blocks of unknowns in the order of a sweep.
fn blocks(how: Minimization, count: usize, points: usize) -> Vec<Block> {
    let m = points;
    let rows: Vec<Range<usize>> = match how.splitting {
        Splitting::No => once(0..3 * m).collect(),
        Splitting::Partial => vec![0..m, m..3 * m],
        Splitting::Complete => vec![0..m, m..2 * m, 2 * m..3 * m],
    };
    let copies: Vec<Range<usize>> = match how.copies {
        CopiesAtOnce::One => (0..count).map(|i| i..i + 1).collect(),
        CopiesAtOnce::All => once(0..count).collect(),
    };
    let of = |copies: Range<usize>| {
        rows.iter().map(move |rows| Block { copies: copies.clone(), rows: rows.clone() }).collect::<Vec<_>>()
    };
    copies.into_iter().flat_map(of).collect()
}

pub(super) fn norm_of_difference(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}
