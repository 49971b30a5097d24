use super::iterate::{Iterate, Stop};
use super::mprgp::{MprgpSettings, mprgp};
use super::{Preconditioner, QpStatus};
use crate::Error;
use crate::linalg::norm;

/// `lower <= x <= upper`, entry by entry; infinite entries mean no bound, equal ones a fixed entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    /// Lower bounds; minus infinity where there is none.
    pub lower: Vec<f64>,
    /// Upper bounds; infinity where there is none.
    pub upper: Vec<f64>,
}

impl Bounds {
    /// Fails unless both have the same length and each lower bound is a number not above its upper one.
    ///
    /// # Errors
    /// If the lengths differ, or a lower bound is no number or above its upper one.
    pub fn validate(&self) -> Result<(), Error> {
        if self.lower.len() != self.upper.len() {
            let what = format!("{} lower and {} upper bounds", self.lower.len(), self.upper.len());
            return Err(Error::new("bounds", what, "give one of each an entry"));
        }
        let holds_a_number = |(l, u): (&f64, &f64)| l <= u && *l < f64::INFINITY && *u > -f64::INFINITY;
        match self.lower.iter().zip(&self.upper).position(|pair| !holds_a_number(pair)) {
            Some(i) => {
                let what = format!("no number lies between {} and {}", self.lower[i], self.upper[i]);
                Err(Error::new(format!("bounds, entry {i}"), what, "the lower bound must not exceed the upper one"))
            }
            None => Ok(()),
        }
    }

    /// The nearest point within the bounds, in place.
    pub fn project(&self, x: &mut [f64]) {
        for (x, (l, u)) in x.iter_mut().zip(self.lower.iter().zip(&self.upper)) {
            *x = x.max(*l).min(*u);
        }
    }
}

/// `min 1/2 x'Ax - b'x` within bounds, `A` symmetric positive definite.
pub struct BoundProblem<'a> {
    /// `x -> A x`.
    pub operator: &'a mut dyn FnMut(&[f64]) -> Vec<f64>,
    /// The linear term.
    pub b: &'a [f64],
    /// The bounds.
    pub bounds: &'a Bounds,
    /// The norm of `A`, or a number not much above it; estimated by Lanczos steps, which count as products, if a
    /// method needs it and it is not given.
    pub largest_eigenvalue: Option<f64>,
    /// Approximate inverse of `A` on the free entries. Where a penalty dwarfs the rest of `A`, the inverse of the
    /// blocks it couples makes the difference between hundreds and tens of thousands of products.
    pub preconditioner: Option<&'a Preconditioner<'a>>,
}

/// What a minimisation cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BoundCounts {
    /// Products with `A`, those of `estimation` included.
    pub products: usize,
    /// Products spent on the largest eigenvalue.
    pub estimation: usize,
    /// Steps of conjugate gradients that stayed within the bounds.
    pub cg_steps: usize,
    /// Steps that met a bound: the face shrinks.
    pub expansions: usize,
    /// Steps along the chopped gradient: the face grows.
    pub proportionings: usize,
    /// Floating point operations on vectors, without the operator and the preconditioner: two an entry for each
    /// scalar product, scaled sum, projection and splitting of a gradient.
    pub flops: f64,
}

/// Where a minimisation ended; `x` is within the bounds whatever the status except `Empty` and `NotFinite`.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundSolution {
    /// The minimiser, or the last iterate.
    pub x: Vec<f64>,
    /// `A x - b`.
    pub gradient: Vec<f64>,
    /// Euclidean norm of the projected gradient: the free gradient and the chopped one together.
    pub projected_gradient: f64,
    /// What it cost.
    pub counts: BoundCounts,
    /// How the iteration ended.
    pub status: QpStatus,
}

/// Minimises from the projection of `start` until the norm of the projected gradient is at most `tolerance` (in the
/// unit of `b`), `stop` returns true, or `max_products` products with `A` are spent.
///
/// `stop` is asked at every iteration with the iterate and the norm of its projected gradient, so that an outer
/// iteration can end the inner one by its own rule. `b`, `start` and the bounds must have one length.
/// A tolerance of zero asks for what rounding allows and ends with [`QpStatus::Stalled`] (or `Solved`, if the
/// projected gradient vanishes exactly).
pub fn minimize_in_bounds(
    problem: BoundProblem,
    start: &[f64],
    settings: &MprgpSettings,
    tolerance: f64,
    max_products: usize,
    stop: &mut Stop,
) -> BoundSolution {
    let BoundProblem { operator, b, bounds, largest_eigenvalue, preconditioner } = problem;
    assert!(b.len() == start.len() && b.len() == bounds.lower.len(), "one length for b, start and bounds");
    let mut x = start.to_vec();
    let mut counts = BoundCounts::default();
    if bounds.validate().is_err() {
        let gradient = vec![f64::NAN; x.len()];
        return BoundSolution { x, gradient, projected_gradient: f64::NAN, counts, status: QpStatus::Empty };
    }
    let finite = norm(start).is_finite() && norm(b).is_finite();
    bounds.project(&mut x);
    let limit = if finite { max_products } else { 0 };
    let mut it = Iterate::new(operator, b, x, tolerance, limit, stop);
    let ended = mprgp(&mut it, bounds, settings, largest_eigenvalue, preconditioner, &mut counts);
    let std::ops::ControlFlow::Break(status) = ended;
    let status = if finite { status } else { QpStatus::NotFinite };
    let projected_gradient = super::face::Face::new(bounds, &it.x, &it.g, 1.0).projected;
    counts.products = it.products;
    counts.flops = it.flops;
    BoundSolution { x: it.x, gradient: it.g, projected_gradient, counts, status }
}
