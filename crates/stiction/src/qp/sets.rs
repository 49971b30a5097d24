use std::ops::ControlFlow;

use super::iterate::{Iterate, Stop};
use super::kprgp::{Kprgp, kprgp, reduced_gradient};
use super::program::{Program, QpCounts, QpSolution};
use super::{PointSet, Preconditioner, project};
use crate::linalg::norm;

/// Parameters of [`minimize_in_sets`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetSettings {
    /// Length of the projected gradient step times the largest eigenvalue, in `(0, 2)`.
    pub step: f64,
    /// Least part of the squared reduced gradient that must lie on the face for the face to be kept. (The sources
    /// compare scalar products with the gradient; those drown in rounding long before the reduced gradient does.)
    pub least_part: f64,
    /// Where a pair moves along a curved boundary: the gradient of the model on the face is reduced by this factor before
    /// the face is left, in `(0, 1)`.
    pub forcing: f64,
}

impl Default for SetSettings {
    fn default() -> Self {
        SetSettings { step: 1.9, least_part: 0.5, forcing: 0.01 }
    }
}

/// Minimises from the projection of `start` until `|(x - P(x - a g)) / a| <= tolerance`, in the unit of `b`, with
/// `a = step / largest_eigenvalue` and the projection `P`; or until `stop` returns true, or `max_products` products
/// with `A` are spent. The measure is the norm of the gradient where nothing holds, and zero at the solution only.
///
/// Three entries of `b` and `start` belong to each set. `stop` is asked at every iteration with the iterate and the
/// measure.
pub fn minimize_in_sets(
    problem: Program,
    sets: &[PointSet],
    start: &[f64],
    settings: &SetSettings,
    tolerance: f64,
    max_products: usize,
    stop: &mut Stop,
) -> QpSolution {
    assert_eq!(start.len(), 3 * sets.len(), "three entries of start a set");
    let method = |it: &mut Iterate, norm_of_a: Option<f64>, preconditioner: Option<&Preconditioner>| {
        let counts = QpCounts::default();
        let mut run = Kprgp { sets, settings, preconditioner, a: f64::NAN, measure: f64::NAN, counts };
        let ControlFlow::Break(status) = kprgp(it, &mut run, norm_of_a);
        (status, norm(&reduced_gradient(sets, &it.x, &it.g, run.a)), run.counts)
    };
    let possible = sets.iter().all(PointSet::is_valid);
    problem.run(start, possible, |x| project(sets, x), (tolerance, max_products), stop, method)
}
