//! What every solver of contact takes, tells on its way and returns.

use super::PointState;
use crate::certificate::Certificate;

/// Settings of a solve; the defaults need no tuning.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Every entry of the certificate is to be at most this; useful from 1e-3 to about 1e-12.
    pub tolerance: f64,
    /// Newton steps.
    pub max_iterations: usize,
    /// Multipliers to start from, length `3m`, newton; zero if `None`. For methods on the multipliers.
    pub start: Option<Vec<f64>>,
    /// Displacements to start from, length `n`; zero if `None`. For methods on the displacements.
    pub start_displacement: Option<Vec<f64>>,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { tolerance: 1e-8, max_iterations: 200, start: None, start_displacement: None }
    }
}

/// How the iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The certificate passes.
    Solved,
    MaxIterations,
    /// No method gains on the residual any more.
    Stalled,
    /// No contact forces balance the loads on a body that floats: it moves away
    /// ([`no_equilibrium`](crate::contact::equilibrium::no_equilibrium) tells how). What is returned is no rest.
    NoEquilibrium,
    /// The method has converged by its own rule, but the certificate does not pass.
    Uncertified,
    /// The observer asked to stop.
    Interrupted,
}

/// What the solver is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Newton's method on the law itself.
    Newton,
    /// Projected gradients with frozen bounds: after a stall, or as a method of its own.
    Gradient,
    /// Newton's method with the bounds of friction frozen (one step of the fixed point), after repeated stalls; or a
    /// step of one of the methods that are fixed points.
    FixedPoint,
    /// The proximal method of multipliers on a convex problem, after repeated stalls.
    Proximal,
    /// Uzawa's method on the copies of the multipliers, one a square.
    Uzawa,
    /// Multigrid cycles on the displacements.
    Multigrid,
}

/// Told to the observer at every iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    pub phase: Phase,
    pub iteration: usize,
    /// Norm of the residual over the norm of the multipliers; with multigrid over that of the load.
    pub residual: f64,
    /// Products with `Q` so far; with multigrid, products with `K`.
    pub products: usize,
    pub open: usize,
    pub stick: usize,
    pub slip: usize,
}

/// What the solve cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Newton steps, those of the fixed point included.
    pub newton_steps: usize,
    /// Times a stall was answered by gradient steps.
    pub restarts: usize,
    /// Outer steps of the fixed point.
    pub fixed_point_steps: usize,
    /// Products with `Q`.
    pub products: usize,
    /// Solves with the whole of `K`.
    pub solves: usize,
    /// Multigrid cycles.
    pub cycles: usize,
}

/// A solution with its certificate.
#[derive(Debug, Clone)]
pub struct Solution {
    pub status: Status,
    /// Displacements, length `n`.
    pub u: Vec<f64>,
    /// Multipliers `[lambda_n; lambda_t1; lambda_t2]`, newton, `3m`; admissible to the last digit.
    pub lambda: Vec<f64>,
    pub states: Vec<PointState>,
    pub certificate: Certificate,
    pub counts: Counts,
    pub history: Vec<Progress>,
}
