use std::ops::ControlFlow;

use super::V3;
use super::blocks::Blocks;
use super::law::residual_norm;
use super::newton::Regular;
use super::sweeps::{project, sweep};
use crate::certificate::{Measures, measure};
use crate::contact::LocalProblem;
use crate::linalg::norm;

/// Settings of a solve; the defaults need no tuning.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Each of the three residuals of [`Measures`] is to be at most this; useful from 1e-3 to about 1e-12.
    pub tolerance: f64,
    /// Proximal steps.
    pub max_iterations: usize,
    /// Impulses to start from, `dm`; zero if `None`.
    pub start: Option<Vec<f64>>,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { tolerance: 1e-8, max_iterations: 1000, start: None }
    }
}

/// How the iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// All three residuals are at most the tolerance.
    Solved,
    MaxIterations,
    /// Only a residual that depends on the units exceeds the tolerance, and it is rounding: impulses are so much larger
    /// than velocities that their last digit counts. Other units help.
    Rounding,
    /// The observer asked to stop.
    Interrupted,
}

/// Told to the observer at every proximal step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    pub iteration: usize,
    /// The largest of the three residuals.
    pub residual: f64,
    /// The proximal parameter over the local flexibility.
    pub alpha: f64,
    pub newton_steps: usize,
}

/// What the solve cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    pub proximal_steps: usize,
    pub newton_steps: usize,
    /// Sweeps over the points.
    pub sweeps: usize,
}

/// The best impulses found, with their measures.
#[derive(Debug, Clone)]
pub struct Solution {
    pub status: Status,
    /// Impulses, `dm`.
    pub r: Vec<f64>,
    /// Velocities `W r + q`, `dm`.
    pub u: Vec<f64>,
    pub measures: Measures,
    pub counts: Counts,
    pub history: Vec<Progress>,
}

/// First proximal parameter over the local flexibility (the scaled diagonal blocks have the trace 3).
const FIRST: f64 = 0.1;
const LARGEST: f64 = 10.0;
/// After a success the parameter falls by this factor, after a failure it grows by it.
const FACTOR: f64 = 10.0;
/// Below this the Newton systems lose more digits than the proximal term costs steps.
const SMALLEST: f64 = 1e-9;
/// The residual of an inner problem over that of the problem itself, and over the proximal parameter.
const INNER: f64 = 0.1;
/// A failed inner solve is kept if it lowered the residual of the problem itself to this part.
const KEPT: f64 = 0.9;
/// Inner problems are not solved below this residual, scaled: rounding.
const ROUNDING: f64 = 1e-15;
/// Successes at one parameter before it falls: doubled by each failure up to this, since a parameter that has just been
/// too small is rarely right one step later.
const MOST_PATIENCE: usize = 16;
/// If the best residual has not halved in so many proximal steps, sweeps choose another start.
const STALL: usize = 30;
/// Sweeps at the first stall; twice as many at each further one, up to [`MOST_SWEEPS`].
const SWEEPS: usize = 25;
/// `r - P(r - û)` is not computed more accurately than to so many last digits of `r`.
const LAST_DIGITS: f64 = 16.0;
/// Steps that may still gain on rounding.
const PATIENCE_AT_ROUNDING: usize = 5;
const MOST_SWEEPS: usize = 400;

/// Solves a local problem without bilateral part: the proximal point algorithm (Rockafellar 1976; on frictional contact
/// Siconos' `fc3d_proximal`) around a semismooth Newton method. The parameter falls tenfold as long as Newton's method
/// converges and rises where it does not; where the residual no longer falls, sweeps over the points choose another
/// start.
///
/// The answer is judged on the problem as it was given; `Solved` is only reported if all three residuals pass.
pub fn solve(
    problem: &LocalProblem,
    settings: &Settings,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Solution {
    let blocks = Blocks::new(problem);
    let judge = |r: &[V3]| judge(problem, &blocks, r);
    let mut r = match settings.start.as_ref().filter(|s| s.len() == problem.q.len()) {
        Some(start) if start.iter().all(|x| x.is_finite()) => blocks.scaled(start),
        _ => vec![[0.0; 3]; problem.mu.len()],
    };
    let mut alpha = FIRST;
    let (mut patience, mut successes, mut sweeps) = (1, 0, SWEEPS);
    // Best residual and step at which it was last halved.
    let mut mark = (f64::INFINITY, 0);
    let (mut best, mut at_rounding): (Option<Solution>, usize) = (None, 0);
    let (mut counts, mut history) = (Counts::default(), Vec::new());
    let status = loop {
        let seen = judge(&admissible(&blocks, &r));
        let residual = seen.measures.worst();
        if best.as_ref().is_none_or(|b| residual < b.measures.worst()) {
            best = Some(seen);
        }
        let progress =
            Progress { iteration: counts.proximal_steps, residual, alpha, newton_steps: counts.newton_steps };
        history.push(progress);
        if residual <= settings.tolerance {
            break Status::Solved;
        }
        if best.as_ref().is_some_and(|b| is_rounding(&b.measures, problem, &b.r, settings.tolerance)) {
            at_rounding += 1;
            if at_rounding > PATIENCE_AT_ROUNDING {
                break Status::Rounding;
            }
        }
        if counts.proximal_steps == settings.max_iterations {
            break Status::MaxIterations;
        }
        if observer(&progress).is_break() {
            break Status::Interrupted;
        }

        let own = residual_norm(&blocks.mu, &r, &blocks.velocity(&r));
        let target = (INNER * own.min(alpha)).max(ROUNDING);
        let end = Regular { blocks: &blocks, alpha, centre: &r }.newton(r.clone(), target);
        counts.proximal_steps += 1;
        counts.newton_steps += end.steps;
        if end.converged {
            r = end.r;
            successes += 1;
            if successes >= patience {
                (alpha, successes) = ((alpha / FACTOR).max(SMALLEST), 0);
            }
        } else {
            if residual_norm(&blocks.mu, &end.r, &blocks.velocity(&end.r)) < KEPT * own {
                r = end.r;
            }
            (alpha, successes, patience) = (alpha * FACTOR, 0, (2 * patience).min(MOST_PATIENCE));
        }
        if residual < 0.5 * mark.0 {
            mark = (residual, counts.proximal_steps);
        }
        if alpha > LARGEST || counts.proximal_steps > mark.1 + STALL {
            sweep(&blocks, &mut r, sweeps);
            counts.sweeps += sweeps;
            (alpha, successes, patience, sweeps) = (FIRST, 0, 1, (2 * sweeps).min(MOST_SWEEPS));
            mark = (f64::INFINITY, counts.proximal_steps);
        }
    };
    let best = best.unwrap_or_else(|| judge(&r));
    Solution { status, counts, history, ..best }
}

/// Whether only `|F(1)| / |q|` exceeds the tolerance, by no more than the last digits of `r`.
fn is_rounding(measures: &Measures, problem: &LocalProblem, r: &[f64], tolerance: f64) -> bool {
    let others = measures.by_largest.max(measures.invariant) <= tolerance;
    others && measures.by_velocity * norm(&problem.q) <= LAST_DIGITS * f64::EPSILON * norm(r)
}

/// The nearest impulses within the cones.
fn admissible(blocks: &Blocks, r: &[V3]) -> Vec<V3> {
    r.iter().zip(&blocks.mu).map(|(r, &mu)| project(mu, *r)).collect()
}

fn judge(problem: &LocalProblem, blocks: &Blocks, r: &[V3]) -> Solution {
    let d = problem.dimension;
    let r = blocks.unscaled(r);
    let mut u = problem.W.times(&r);
    u.iter_mut().zip(&problem.q).for_each(|(u, q)| *u += q);
    let trace: Vec<f64> =
        (0..problem.mu.len()).map(|a| (d * a..d * (a + 1)).map(|i| problem.W.entry(i, i)).sum()).collect();
    let measures = measure(d, &problem.mu, &trace, &problem.q, &r, &u);
    let (counts, history) = (Counts::default(), Vec::new());
    Solution { status: Status::MaxIterations, r, u, measures, counts, history }
}
