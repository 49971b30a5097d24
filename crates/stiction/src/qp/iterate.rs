use std::ops::ControlFlow;

use super::QpStatus;
use crate::linalg::{axpy, largest_eigenvalue, norm};

/// A part of an iteration: its value, or the status with which the iteration ends.
pub(super) type Step<T> = ControlFlow<QpStatus, T>;

/// The caller's test, asked at every iteration with the iterate and its measure of optimality.
pub type Stop<'a> = dyn FnMut(&[f64], f64) -> bool + 'a;

/// Thresholds of the end of an iteration at what rounding allows, by the dense problems of this room's tests with tolerances of
/// zero and penalties up to a million times the rest.
struct Threshold;

impl Threshold {
    /// Iterations without halving the measure after which rounding is suspected.
    const PATIENCE: usize = 200;
    /// Multiple of the rounding level of the gradient below which no further progress is expected.
    const ROUNDING_MARGIN: f64 = 1.0;
    /// Fraction of the bound on its drift below which a recurrence is replaced: the bound exceeds the drift by orders.
    const RELIABLE: f64 = 1e-8;
    /// Relative accuracy of the Lanczos estimate of the largest eigenvalue: a step length needs no more.
    const EIGENVALUE_ACCURACY: f64 = 0.05;
    /// Products that estimate may cost; where it fails for want of them, step lengths are halved as needed.
    const EIGENVALUE_PRODUCTS: usize = 30;
    /// Claims of optimality that may be refuted without the measure being halved in between.
    const REFUTATIONS: usize = 3;
}

/// An iterate with its gradient, and the account of what they cost and how far the gradient can be trusted.
pub(super) struct Iterate<'a> {
    operator: &'a mut dyn FnMut(&[f64]) -> Vec<f64>,
    b: &'a [f64],
    tolerance: f64,
    stop: &'a mut Stop<'a>,
    pub x: Vec<f64>,
    /// `A x - b`, by recurrence since the last product with `x` itself.
    pub g: Vec<f64>,
    pub products: usize,
    max_products: usize,
    /// See [`super::QpCounts::flops`].
    pub flops: f64,
    /// Largest `|A p| / |p|` met: a lower bound of the norm of `A` that costs nothing.
    norm_met: f64,
    /// Bound on what the recurrence has lost since the last product with `x`.
    drift: f64,
    /// Least measure so far and the iterations since it was last halved.
    best: (f64, usize),
    /// Whether the gradient was just replaced to check a claim of optimality.
    checking: bool,
    /// Least measure at a refuted claim, and the claims refuted since it was last halved.
    refuted: (f64, usize),
}

impl<'a> Iterate<'a> {
    pub(super) fn new(
        operator: &'a mut dyn FnMut(&[f64]) -> Vec<f64>,
        b: &'a [f64],
        x: Vec<f64>,
        tolerance: f64,
        max_products: usize,
        stop: &'a mut Stop<'a>,
    ) -> Self {
        let g = vec![f64::NAN; x.len()];
        Iterate {
            operator,
            b,
            tolerance,
            stop,
            x,
            g,
            products: 0,
            max_products,
            flops: 0.0,
            norm_met: 0.0,
            drift: 0.0,
            best: (f64::INFINITY, 0),
            checking: false,
            refuted: (f64::INFINITY, 0),
        }
    }

    /// `A p`, counted.
    pub(super) fn times(&mut self, p: &[f64]) -> Step<Vec<f64>> {
        if self.products >= self.max_products {
            return ControlFlow::Break(QpStatus::Limit);
        }
        self.products += 1;
        let ap = (self.operator)(p);
        let (length, image) = (norm(p), norm(&ap));
        self.count(2);
        if !image.is_finite() || ap.len() != p.len() {
            return ControlFlow::Break(QpStatus::NotFinite);
        }
        if length > 0.0 {
            self.norm_met = self.norm_met.max(image / length);
        }
        ControlFlow::Continue(ap)
    }

    /// The gradient at `x` by a product instead of a recurrence.
    pub(super) fn refresh(&mut self) -> Step<()> {
        let x = std::mem::take(&mut self.x);
        let g = self.gradient_at(&x);
        self.x = x;
        self.g = g?;
        self.drift = 0.0;
        ControlFlow::Continue(())
    }

    /// The norm of the operator: `given`, or by Lanczos steps, with the products they cost.
    pub(super) fn operator_norm(&mut self, given: Option<f64>) -> Step<(f64, usize)> {
        if let Some(norm) = given.filter(|n| *n > 0.0 && n.is_finite()) {
            return ControlFlow::Continue((norm, 0));
        }
        let (n, mut failure) = (self.x.len(), None);
        let limit = Threshold::EIGENVALUE_PRODUCTS.min(self.max_products - self.products);
        let operator = |v: &[f64]| match self.times(v) {
            ControlFlow::Continue(av) => av,
            ControlFlow::Break(status) => {
                failure = Some(status);
                vec![f64::NAN; n]
            }
        };
        let ritz = largest_eigenvalue(n, operator, Threshold::EIGENVALUE_ACCURACY, limit);
        match failure {
            Some(status) => ControlFlow::Break(status),
            None if ritz.value > 0.0 => ControlFlow::Continue((ritz.value + ritz.residual, ritz.products)),
            None => ControlFlow::Continue((1.0, ritz.products)),
        }
    }

    pub(super) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// `A y - b`, by a product.
    pub(super) fn gradient_at(&mut self, y: &[f64]) -> Step<Vec<f64>> {
        let mut g = self.times(y)?;
        axpy(-1.0, self.b, &mut g);
        self.count(1);
        ControlFlow::Continue(g)
    }

    /// Goes to `y`, whose gradient `g` comes from a product.
    pub(super) fn move_to(&mut self, y: Vec<f64>, g: Vec<f64>) {
        (self.x, self.g, self.drift) = (y, g, 0.0);
    }

    /// `x - step p` with the gradient by recurrence from `ap = A p`.
    pub(super) fn advance(&mut self, step: f64, p: &[f64], ap: &[f64]) {
        axpy(-step, p, &mut self.x);
        axpy(-step, ap, &mut self.g);
        // van der Vorst & Ye 2000, SIAM J. Sci. Comput. 22: what one step of the recurrence can lose.
        self.drift += f64::EPSILON * (self.norm_met * norm(&self.x) + norm(&self.g));
        self.count(4);
    }

    /// `f(y) - f(x)` from both gradients, without the cancellation of two objectives.
    pub(super) fn rise(&mut self, y: &[f64], gradient: &[f64]) -> f64 {
        self.count(3);
        let terms = y.iter().zip(&self.x).zip(gradient.iter().zip(&self.g));
        terms.map(|((y, x), (gy, gx))| 0.5 * (y - x) * (gx + gy)).sum()
    }

    /// The level below which a gradient at `x` is rounding.
    pub(super) fn rounding(&self) -> f64 {
        f64::EPSILON * (self.norm_met * norm(&self.x) + norm(self.b))
    }

    /// Adds `operations` vector operations of two flops an entry to the account.
    pub(super) fn count(&mut self, operations: usize) {
        self.flops += 2.0 * (operations * self.x.len()) as f64;
    }

    /// Decides whether the iteration ends with the measure of optimality `measure`. Where that rests on a recurrence
    /// that may have drifted, replaces the gradient instead and says so with `true`: the caller computes its measure
    /// and direction anew.
    pub(super) fn judge(&mut self, measure: f64) -> Step<bool> {
        if !measure.is_finite() {
            return ControlFlow::Break(QpStatus::NotFinite);
        }
        let solved = measure <= self.tolerance;
        let claim = if solved {
            Some((QpStatus::Solved, measure + self.drift <= self.tolerance))
        } else if (self.stop)(&self.x, measure) {
            Some((QpStatus::Interrupted, self.drift <= 0.1 * measure))
        } else if measure < Threshold::RELIABLE * self.drift {
            Some((QpStatus::Stalled, false))
        } else {
            None
        };
        match claim {
            Some((status, trusted)) if trusted || self.drift == 0.0 => return ControlFlow::Break(status),
            Some(_) => {
                self.refresh()?;
                self.checking = true;
                return ControlFlow::Continue(true);
            }
            None => {}
        }
        if self.stalled(measure) { ControlFlow::Break(QpStatus::Stalled) } else { ControlFlow::Continue(false) }
    }

    fn stalled(&mut self, measure: f64) -> bool {
        // A claim the product just refuted: what the operator loses itself, which no estimate of ours knows.
        if std::mem::take(&mut self.checking) {
            self.refuted =
                if measure <= 0.5 * self.refuted.0 { (measure, 0) } else { (self.refuted.0, self.refuted.1 + 1) };
        }
        if measure <= 0.5 * self.best.0 {
            self.best = (measure, 0);
        }
        self.best.1 += 1;
        self.refuted.1 >= Threshold::REFUTATIONS
            || (self.best.1 > Threshold::PATIENCE && self.best.0 <= Threshold::ROUNDING_MARGIN * self.rounding())
    }
}
