use super::iterate::{Iterate, Stop};
use super::{Preconditioner, QpStatus};
use crate::linalg::norm;

/// `min 1/2 x'Ax - b'x` over a simple set, `A` symmetric positive definite.
pub struct Program<'a> {
    /// `x -> A x`.
    pub operator: &'a mut dyn FnMut(&[f64]) -> Vec<f64>,
    /// The linear term.
    pub b: &'a [f64],
    /// The norm of `A`, or a number not much above it; estimated by Lanczos steps, which count as products, if a
    /// method needs it and it is not given.
    pub largest_eigenvalue: Option<f64>,
    /// Approximate inverse of `A` on the entries marked free. Where a penalty dwarfs the rest of `A`, the inverse of the
    /// blocks it couples makes the difference between hundreds and tens of thousands of products. A pair that moves along
    /// the boundary of its disc has both its entries marked; the result is restricted to the tangent.
    pub preconditioner: Option<&'a Preconditioner<'a>>,
}

/// What a minimisation cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct QpCounts {
    /// Products with `A`, those of `estimation` included.
    pub products: usize,
    /// Products spent on the largest eigenvalue.
    pub estimation: usize,
    /// Steps of conjugate gradients within a face.
    pub cg_steps: usize,
    /// Steps out of a face, taken or not: it shrinks.
    pub expansions: usize,
    /// Steps along the chopped gradient (bounds), or projected ones of fixed length (sets): the face grows.
    pub gradient_steps: usize,
    /// Floating point operations on vectors, without the operator and the preconditioner: two an entry for each
    /// scalar product, scaled sum, projection and splitting of a gradient.
    pub flops: f64,
}

/// Where a minimisation ended; `x` is in the set whatever the status except `Empty` and `NotFinite`.
#[derive(Debug, Clone, PartialEq)]
pub struct QpSolution {
    /// The minimiser, or the last iterate.
    pub x: Vec<f64>,
    /// `A x - b`.
    pub gradient: Vec<f64>,
    /// The measure of optimality: the norm of the projected gradient (bounds), of the reduced gradient (sets).
    pub measure: f64,
    /// What it cost.
    pub counts: QpCounts,
    /// How the iteration ended.
    pub status: QpStatus,
}

impl Program<'_> {
    /// Runs `method` from the projection of `start`; it receives the norm of `A` and the preconditioner, and returns how it
    /// ended, its measure there and its steps. The set is empty unless `possible`.
    pub(super) fn run(
        self,
        start: &[f64],
        possible: bool,
        project: impl Fn(&mut [f64]),
        (tolerance, max_products): (f64, usize),
        stop: &mut Stop,
        method: impl FnOnce(&mut Iterate, Option<f64>, Option<&Preconditioner>) -> (QpStatus, f64, QpCounts),
    ) -> QpSolution {
        let Program { operator, b, largest_eigenvalue, preconditioner } = self;
        assert_eq!(b.len(), start.len(), "one length for b and start");
        let mut x = start.to_vec();
        if !possible {
            let (gradient, counts) = (vec![f64::NAN; x.len()], QpCounts::default());
            return QpSolution { x, gradient, measure: f64::NAN, counts, status: QpStatus::Empty };
        }
        let finite = norm(start).is_finite() && norm(b).is_finite();
        project(&mut x);
        let limit = if finite { max_products } else { 0 };
        let mut it = Iterate::new(operator, b, x, tolerance, limit, stop);
        let (status, measure, counts) = method(&mut it, largest_eigenvalue, preconditioner);
        let status = if finite { status } else { QpStatus::NotFinite };
        let counts = QpCounts { products: it.products, flops: it.flops, ..counts };
        QpSolution { x: it.x, gradient: it.g, measure, counts, status }
    }
}
