use std::ops::ControlFlow;

use super::iterate::{Iterate, Stop};
use super::kprgp::{Kprgp, kprgp, reduced_gradient};
use super::{PointSet, Preconditioner, QpStatus, project};
use crate::linalg::norm;

/// `min 1/2 x'Ax - b'x` over a product of [`PointSet`]s, `A` symmetric positive definite, in triples
/// `[all x_0; all x_1; all x_2]`.
pub struct SetProblem<'a> {
    /// `x -> A x`.
    pub operator: &'a mut dyn FnMut(&[f64]) -> Vec<f64>,
    /// The linear term.
    pub b: &'a [f64],
    /// The norm of `A`, or a number not much above it; estimated by Lanczos steps, which count, if not given.
    pub largest_eigenvalue: Option<f64>,
    /// Approximate inverse of `A` on the entries marked free. A pair that moves along its boundary has both its
    /// entries marked; the result is restricted to the tangent.
    pub preconditioner: Option<&'a Preconditioner<'a>>,
}

/// Parameters of [`minimize_in_sets`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetSettings {
    /// Length of the projected gradient step times the largest eigenvalue, in `(0, 2)`.
    pub step: f64,
    /// Least share of the squared reduced gradient that must lie on the face for the face to be kept. (The sources
    /// compare scalar products with the gradient; those drown in rounding long before the reduced gradient does.)
    pub share: f64,
    /// Where a pair moves along a curved boundary: the gradient of the model on the face is reduced by this factor before
    /// the face is left, in `(0, 1)`.
    pub forcing: f64,
}

impl Default for SetSettings {
    fn default() -> Self {
        SetSettings { step: 1.9, share: 0.5, forcing: 0.01 }
    }
}

/// What a minimisation over sets cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SetCounts {
    /// Products with `A`, those of `estimation` included.
    pub products: usize,
    /// Products spent on the largest eigenvalue.
    pub estimation: usize,
    /// Steps of conjugate gradients.
    pub cg_steps: usize,
    /// Projected steps out of a face, taken or not.
    pub expansions: usize,
    /// Projected gradient steps of fixed length.
    pub gradient_steps: usize,
    /// Operations on vectors, counted as for [`super::BoundCounts`].
    pub flops: f64,
}

/// Where a minimisation ended; `x` is in the sets whatever the status except `Empty` and `NotFinite`.
#[derive(Debug, Clone, PartialEq)]
pub struct SetSolution {
    /// The minimiser, or the last iterate.
    pub x: Vec<f64>,
    /// `A x - b`.
    pub gradient: Vec<f64>,
    /// Euclidean norm of the reduced gradient, see [`minimize_in_sets`].
    pub reduced_gradient: f64,
    /// What it cost.
    pub counts: SetCounts,
    /// How the iteration ended.
    pub status: QpStatus,
}

/// Minimises from the projection of `start` until `|(x - P(x - a g)) / a| <= tolerance`, in the unit of `b`, with
/// `a = step / largest_eigenvalue` and the projection `P`; or until `stop` returns true, or `max_products` products
/// with `A` are spent. The measure is the norm of the gradient where nothing holds, and zero at the solution only.
///
/// Three entries of `b` and `start` belong to each set. `stop` is asked at every iteration with the iterate and the
/// measure.
pub fn minimize_in_sets(
    problem: SetProblem,
    sets: &[PointSet],
    start: &[f64],
    settings: &SetSettings,
    tolerance: f64,
    max_products: usize,
    stop: &mut Stop,
) -> SetSolution {
    let SetProblem { operator, b, largest_eigenvalue, preconditioner } = problem;
    assert!(b.len() == start.len() && b.len() == 3 * sets.len(), "three entries of b and start a set");
    let mut x = start.to_vec();
    if !sets.iter().all(PointSet::is_valid) {
        let gradient = vec![f64::NAN; x.len()];
        let counts = SetCounts::default();
        return SetSolution { x, gradient, reduced_gradient: f64::NAN, counts, status: QpStatus::Empty };
    }
    let finite = norm(start).is_finite() && norm(b).is_finite();
    project(sets, &mut x);
    let limit = if finite { max_products } else { 0 };
    let mut it = Iterate::new(operator, b, x, tolerance, limit, stop);
    let mut run =
        Kprgp { sets, settings, preconditioner, a: f64::NAN, measure: f64::NAN, counts: SetCounts::default() };
    let ControlFlow::Break(status) = kprgp(&mut it, &mut run, largest_eigenvalue);
    let status = if finite { status } else { QpStatus::NotFinite };
    let reduced_gradient = norm(&reduced_gradient(sets, &it.x, &it.g, run.a));
    let counts = SetCounts { products: it.products, flops: it.flops, ..run.counts };
    SetSolution { x: it.x, gradient: it.g, reduced_gradient, counts, status }
}
