use std::ops::ControlFlow;

use super::Preconditioner;
use super::face::Face;
use super::iterate::{Iterate, Stop};
use super::mprgp::{MprgpSettings, mprgp};
use super::program::{Program, QpCounts, QpSolution};
use crate::Error;

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

/// Minimises from the projection of `start` until the norm of the projected gradient is at most `tolerance` (in the
/// unit of `b`), `stop` returns true, or `max_products` products with `A` are spent.
///
/// `stop` is asked at every iteration with the iterate and the norm of its projected gradient, so that an outer
/// iteration can end the inner one by its own rule. `b`, `start` and the bounds must have one length.
/// A tolerance of zero asks for what rounding allows and ends with `Stalled` (or `Solved`, if the
/// projected gradient vanishes exactly).
pub fn minimize_in_bounds(
    problem: Program,
    bounds: &Bounds,
    start: &[f64],
    settings: &MprgpSettings,
    tolerance: f64,
    max_products: usize,
    stop: &mut Stop,
) -> QpSolution {
    assert_eq!(start.len(), bounds.lower.len(), "one length for start and bounds");
    let method = |it: &mut Iterate, norm: Option<f64>, preconditioner: Option<&Preconditioner>| {
        let mut counts = QpCounts::default();
        let ControlFlow::Break(status) = mprgp(it, bounds, settings, norm, preconditioner, &mut counts);
        (status, Face::new(bounds, &it.x, &it.g, 1.0).projected, counts)
    };
    let possible = bounds.validate().is_ok();
    problem.run(start, possible, |x| bounds.project(x), (tolerance, max_products), stop, method)
}
