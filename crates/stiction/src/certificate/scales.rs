//! What the measures are counted in: the one place that says what is large and what is rounding.
//!
//! A measure is `(error - rounding)+ / scale`. Each scale is the largest of all that the data and the answer hold of
//! its kind, so that no measure is divided by what rounding has left of a quantity that vanishes in the exact answer:
//! a node that sticks has no displacement, but a force and a compliance. Resultants of a body are counted in the sums
//! of magnitudes they add up from, which `balance` knows.

use super::point::Point;
use super::stiffness::LocalStiffness;
use crate::contact::ContactProblem;
use crate::linalg::max_abs;

/// What rounding makes of a sum, over the sum of the magnitudes of its terms: the sums of a certificate have some
/// tens of terms, whose errors grow like the root of their number.
pub(super) const ROUNDING: f64 = 10.0 * f64::EPSILON;

/// Friction is judged by its largest bound, but not by less than this part of the largest contact force. Below it,
/// and where there is no friction at all, the tangential part of a normal force in another frame is no error.
const LEAST_FRICTION: f64 = 1e-6;

/// The scales of one answer; each is zero only where data and answer hold nothing of its kind.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales {
    /// Length: the largest displacement, prescribed ones included; the largest overlap that contact has to close; the
    /// largest contact force times the compliance of its row of `B`.
    pub length: f64,
    /// Force: the largest contact force, normal or tangential.
    pub force: f64,
    /// Force: the largest bound of friction, [`LEAST_FRICTION`] of `force` at least.
    pub friction: f64,
    /// Force: the Euclidean norm of all contact forces, for measures that are norms over the points.
    pub contact: f64,
    /// Force: the Euclidean norm of the loads or of what contact does to the unknowns, whichever is larger: a body may
    /// be loaded by its overlap alone.
    pub load: f64,
    /// Work: the forces of all points, or their bounds of friction if these are larger, along `length`.
    pub work: f64,
}

impl Scales {
    /// `contact_force` is `Bᵀ lambda`.
    pub(super) fn new(
        problem: &ContactProblem,
        stiffness: &LocalStiffness,
        points: &[Point],
        u: &[f64],
        lambda: &[f64],
        contact_force: &[f64],
    ) -> Scales {
        let prescribed = problem.labels.supports.as_ref().map_or(0.0, |s| max_abs(&s.displacement));
        let overlap = points.iter().map(Point::overlap).fold(0.0, f64::max);
        let deflections = lambda.iter().zip(&stiffness.of_row).filter_map(|(l, k)| k.map(|k| l.abs() / k));
        let deflection = deflections.filter(|d| d.is_finite()).fold(0.0, f64::max);
        let length = max_abs(u).max(prescribed).max(overlap).max(deflection);
        let force = max_abs(lambda);
        let bound = points.iter().map(|p| p.bound).fold(0.0, f64::max);
        Scales {
            length,
            force,
            friction: bound.max(LEAST_FRICTION * force),
            contact: norm(lambda.iter().copied()),
            load: norm(problem.elastic.f.iter().copied()).max(norm(contact_force.iter().copied())),
            work: length * points.iter().map(|p| p.normal.abs().max(p.bound)).sum::<f64>(),
        }
    }
}

/// `(error - rounding)+ / scale`. Always a number: an error where there is nothing to count it in, and what is not a
/// number itself, is the largest one.
pub(super) fn measure(error: f64, rounding: f64, scale: f64) -> f64 {
    let value = error - rounding;
    if value <= 0.0 {
        0.0
    } else {
        // `min` takes the number where the other is none.
        (value / scale).min(f64::MAX)
    }
}

/// The Euclidean norm.
pub(super) fn norm(x: impl Iterator<Item = f64>) -> f64 {
    x.map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measure_is_always_a_number() {
        assert_eq!(measure(0.0, 0.0, 0.0), 0.0);
        assert_eq!(measure(1.0, 2.0, 0.0), 0.0);
        assert_eq!(measure(1.0, 0.0, 0.0), f64::MAX);
        assert_eq!(measure(1e3, 0.0, f64::MIN_POSITIVE), f64::MAX);
        let nowhere = [f64::NAN, f64::INFINITY];
        for x in nowhere {
            assert_eq!(measure(x, 0.0, 1.0), f64::MAX);
            assert_eq!(measure(1.0, f64::NAN, 1.0), f64::MAX);
        }
        assert_eq!(measure(f64::INFINITY, f64::INFINITY, 1.0), f64::MAX);
        assert_eq!(measure(1.0, 0.0, f64::NAN), f64::MAX);
        assert_eq!(measure(3.0, 1.0, 4.0), 0.5);
    }
}
