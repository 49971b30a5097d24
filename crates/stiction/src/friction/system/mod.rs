//! Points under the law of friction whose `v = [gap; -slip]` is an affine function of their multipliers: the dual of an
//! elastic problem, `v = Q lambda - G alpha - h`, and a discrete problem, `u = W r + q`, are the same problem.
//!
//! [`newton`] solves it, with or without a proximal term; [`accelerated_gradients`] approach a solution of the convex
//! problem that frozen bounds of friction leave. Everything is kept point by point.

mod gradient;
mod newton;

pub(crate) use gradient::{Descent, accelerated_gradients};
pub(crate) use newton::{Newton, Observe, ProximalTerm, Rules, newton};

use super::law::{Linearisation, V3};
use crate::linalg::norm;

/// A point the iteration has reached.
#[derive(Debug, Clone)]
pub(crate) struct Iterate {
    /// Multipliers.
    pub lambda: Vec<V3>,
    /// Their `v`, proximal terms left out.
    pub v: Vec<V3>,
    /// Rigid motions of bodies that float; empty where there are none.
    pub alpha: Vec<f64>,
}

/// A direction of the iteration.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    /// Change of the multipliers.
    pub lambda: Vec<V3>,
    /// Change of `v`; empty where [`System::advance`] computes `v` anew.
    pub v: Vec<V3>,
    /// Change of the rigid motions.
    pub alpha: Vec<f64>,
    /// False if bodies float and nothing resists any of their motions.
    pub resisted: bool,
}

/// What the methods need to know of a problem.
pub(crate) trait System {
    /// False for a component of point `j` that has no row of `B`; its multiplier is zero.
    fn has_row(&self, _j: usize) -> [bool; 3] {
        [true; 3]
    }

    /// What the forces on floating bodies lack of balance, newton, one number a rigid motion.
    fn imbalance(&self, _lambda: &[V3]) -> Vec<f64> {
        Vec::new()
    }

    /// The change that solves the linearised laws of all points (to a relative accuracy, where that is iterative);
    /// `None` where they are singular to working precision.
    fn step(&self, at: &Iterate, points: &[Linearisation], accuracy: f64) -> Option<Step>;

    /// Whether steps are solved as well as they can be whatever accuracy is asked for.
    fn is_exact(&self) -> bool {
        false
    }

    /// The point at `t` times a step.
    fn advance(&self, at: &Iterate, t: f64, step: &Step) -> Iterate;
}

/// `x + t d`.
pub(crate) fn moved(x: &[V3], t: f64, d: &[V3]) -> Vec<V3> {
    x.iter().zip(d).map(|(x, d)| std::array::from_fn(|i| x[i] + t * d[i])).collect()
}

/// Euclidean norm.
pub(crate) fn length(x: &[V3]) -> f64 {
    norm(x.as_flattened())
}

/// Point by point from `[all x_0; all x_1; all x_2]`.
pub(crate) fn by_point(x: &[f64]) -> Vec<V3> {
    let m = x.len() / 3;
    (0..m).map(|j| [x[j], x[m + j], x[2 * m + j]]).collect()
}

/// `[all x_0; all x_1; all x_2]` from what is stored point by point.
pub(crate) fn by_component(x: &[V3]) -> Vec<f64> {
    (0..3).flat_map(|i| x.iter().map(move |x| x[i])).collect()
}
