//! What the measures are counted in: the one place that says what is large and what is rounding.
//!
//! A measure is `(error - rounding)+ / scale`. Each scale is the largest of all that the data and the answer hold of
//! its kind, so that no measure is divided by what rounding has left of a quantity that vanishes in the exact answer:
//! a node that sticks has no displacement, but a force and a compliance. Resultants of a body are counted in the sums
//! of magnitudes they add up from, which `balance` knows.

use super::point::Point;
use super::share::Share;
use super::stiffness::LocalStiffness;
use crate::contact::ContactProblem;

/// What rounding makes of a sum, over the sum of the magnitudes of its terms: the sums of a certificate have some
/// tens of terms, whose errors grow like the root of their number.
pub(super) const ROUNDING: f64 = 10.0 * f64::EPSILON;

/// Friction is judged by its largest bound, but not by less than this part of the largest contact force. Below it,
/// and where there is no friction at all, the tangential part of a normal force in another frame is no error.
const LEAST_FRICTION: f64 = 1e-6;

/// Displacements over the radius of the largest body from which they may hide a load, and the part of it that is hidden then. A joint pulled
/// beyond friction goes 1e13 times as far, where rounding of its rows of `B` closes gaps and makes normal forces to any load.
const FAR: f64 = 1e6;
const HIDDEN: f64 = 0.01;

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
        share: &Share,
        stiffness: &LocalStiffness,
        points: &[Point],
        u: &[f64],
        lambda: &[f64],
        contact_force: &[f64],
    ) -> Scales {
        let m = problem.points();
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |most, v| f64::max(most, v.abs()));
        let supports = problem.labels.supports.as_ref();
        let held = supports.iter().flat_map(|s| s.displacement.iter().enumerate());
        let prescribed = largest(&mut held.filter(|(p, _)| share.has_support(*p)).map(|(_, v)| *v));
        let overlap = share.points(points).map(Point::overlap).fold(0.0, f64::max);
        let forces = || lambda.iter().enumerate().filter(|(i, _)| share.has_point(i % m.max(1)));
        let deflections = forces().filter_map(|(i, l)| stiffness.of_row[i].map(|k| l.abs() / k));
        let deflection = deflections.filter(|d| d.is_finite()).fold(0.0, f64::max);
        let displaced = largest(&mut share.unknowns(u).copied());
        let bound = share.points(points).map(|p| p.bound).fold(0.0, f64::max);
        let mut most =
            [displaced.max(prescribed).max(overlap).max(deflection), largest(&mut forces().map(|(_, l)| *l)), bound];
        share.max(&mut most);
        let [length, force, bound] = most;
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
        let mut sums = [
            square(&mut forces().map(|(_, l)| *l)),
            square(&mut share.unknowns(&problem.elastic.f).copied()),
            square(&mut share.unknowns(contact_force).copied()),
            share.points(points).map(|p| p.normal.abs().max(p.bound)).sum::<f64>(),
        ];
        share.sum(&mut sums);
        let [contact, load, by_contact, work] = sums;
        Scales {
            length,
            force,
            friction: bound.max(LEAST_FRICTION * force),
            contact: contact.sqrt(),
            load: load.sqrt().max(by_contact.sqrt()),
            work: length * work,
        }
    }

    /// Whether bodies have moved so far that rounding of their internal forces, newton, hides what loads them.
    pub(super) fn is_beyond_sight(&self, problem: &ContactProblem, rounding: f64) -> bool {
        let radii = problem.labels.bodies.iter().flat_map(|bodies| &bodies.list).map(|body| body.radius);
        let radius = radii.fold(0.0, f64::max);
        radius > 0.0 && self.length > FAR * radius && rounding > HIDDEN * self.load
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
