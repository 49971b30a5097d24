use std::ops::ControlFlow;

use super::newton_system::{Linearized, NewtonSystem};
use crate::contact::Friction;
use crate::dual::Dual;
use crate::friction::PointState;
use crate::friction::law::{residual, states};
use crate::linalg::norm;

/// The point the iteration has reached: multipliers, rigid motions of bodies that float, and
/// `v = Q lambda - G alpha - h = [gap - N u; -slip]`.
#[derive(Debug, Clone)]
pub(super) struct Iterate {
    pub lambda: Vec<f64>,
    pub v: Vec<f64>,
    pub alpha: Vec<f64>,
}

/// How a run of Newton steps ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Converged,
    Stalled,
    Limit,
    Interrupted,
}

/// What a run of Newton steps works on.
pub(super) struct Newton<'a> {
    pub dual: &'a Dual,
    pub friction: &'a [Friction],
    /// False for an empty row of `B`, length `3m`.
    pub live: &'a [bool],
    /// Local stiffness of each row, `3m`.
    pub stiffness: &'a [f64],
    /// The parameter of the residual, one a point, force per length.
    pub r: &'a [f64],
    /// `Rᵀ f` on the rigid motions of bodies that float, newton.
    pub resultant: &'a [f64],
    /// Smaller multipliers are taken to be so large, newton.
    pub loose: f64,
    /// Stop when the residual's norm is at most this share of the multipliers'.
    pub tolerance: f64,
}

/// Told the norm of the residual, that of the multipliers and the states at every iteration; may stop the run.
pub(super) type Observe<'a> = dyn FnMut(f64, f64, &[PointState]) -> ControlFlow<()> + 'a;

/// Backtracking ends here: a smaller step means that the direction is no descent.
const SMALLEST_STEP: f64 = 1.0 / 64.0;
/// A step may raise the residual as long as it stays below the largest of so many before it.
const MEMORY: usize = 4;
/// Steps without a tenth gained on the best residual that count as a stall.
const PATIENCE: usize = 4;
/// Relative residual below which friction follows the normal force whatever the coefficient.
const NEAR: f64 = 0.1;
/// Coefficients up to this are harmless from the start (measured: 0.1 to 20 on four loads).
pub(super) const TAME_SLOPE: f64 = 2.5;
/// Relative accuracy of a step while points change their state.
const LOOSE: f64 = 1e-2;
/// The same where bodies float: one that is soft and thin bends far under small differences of the forces on its two
/// sides, and an inaccurate step turns points at its edges open and closed in circles (measured on a gasket: 1e-3
/// cycles, and 1e-4 takes fewer products in all even where 1e-2 converges).
const LOOSE_FLOATING: f64 = 1e-4;
/// Products one linear system may take.
const INNER_LIMIT: usize = 300;

/// Semismooth Newton (Alart & Curnier 1991) with inexact steps and non-monotone backtracking (Grippo, Lampariello &
/// Lucidi 1986) on the norm of the residual, which contains what forces on floating bodies lack of balance. `steps` counts down to the limit of the whole solve.
pub(super) fn newton(on: &Newton<'_>, at: &mut Iterate, steps: &mut usize, observe: &mut Observe<'_>) -> End {
    let mut recent: Vec<f64> = Vec::new();
    let (mut best, mut since_best) = (f64::INFINITY, 0);
    let mut previous: Vec<PointState> = Vec::new();
    let imbalance = |at: &Iterate| on.dual.floating.imbalance(on.resultant, &at.lambda);
    let merit = |at: &Iterate| norm(&residual(on.friction, &at.lambda, &at.v, on.r)).hypot(norm(&imbalance(at)));
    let jumps = &on.dual.floating.jumps[..on.resultant.len()];
    let loosest = if jumps.is_empty() { LOOSE } else { LOOSE_FLOATING };
    loop {
        let theta = merit(at);
        let now = states(on.friction, &at.lambda, &at.v, on.r);
        let scale = norm(&at.lambda);
        if observe(theta, scale, &now).is_break() {
            return End::Interrupted;
        }
        let target = on.tolerance * scale.max(on.loose);
        if theta <= target {
            return End::Converged;
        }
        if *steps == 0 {
            return End::Limit;
        }
        since_best = if theta < 0.9 * best { 0 } else { since_best + 1 };
        best = best.min(theta);
        if since_best > PATIENCE || !theta.is_finite() {
            return End::Stalled;
        }
        *steps -= 1;
        // While points still change their state the linear model is only as good as that; once they rest, the step
        // is worth solving as far as its quadratic error allows.
        let settled = now == previous;
        let relative = theta / scale.max(f64::MIN_POSITIVE);
        let forcing = if settled { (0.3 * target / theta).max(0.1 * relative).min(loosest) } else { loosest };
        // Far from the solution a large coefficient makes the step of a slipping point run away through its normal
        // force (the reduced matrix loses its definiteness); near it the coupling is what makes the method fast.
        let largest_slope = if theta < NEAR * scale { f64::INFINITY } else { TAME_SLOPE };
        let system = NewtonSystem::new(&Linearized {
            friction: on.friction,
            largest_slope,
            live: on.live,
            stiffness: on.stiffness,
            lambda: &at.lambda,
            v: &at.v,
            r: on.r,
            centre: None,
        });
        let step = system.solve(on.dual, jumps, &imbalance(at), forcing, INNER_LIMIT);
        // Such a motion would be as long as rounding makes it.
        if !step.resisted {
            return End::Stalled;
        }
        recent.push(theta);
        let highest = recent.iter().rev().take(MEMORY).fold(0.0, |a: f64, &b| a.max(b));
        let mut t = 1.0;
        let next = loop {
            let trial = Iterate {
                lambda: along(&at.lambda, t, &step.d),
                v: along(&at.v, t, &step.dv),
                alpha: if jumps.is_empty() { at.alpha.clone() } else { along(&at.alpha, t, &step.d_alpha) },
            };
            let theta = merit(&trial);
            if theta <= (1.0 - 1e-4 * t) * highest {
                break Some(trial);
            }
            t *= 0.5;
            if t < SMALLEST_STEP {
                break None;
            }
        };
        let Some(next) = next else { return End::Stalled };
        *at = next;
        previous = now;
    }
}

fn along(x: &[f64], t: f64, d: &[f64]) -> Vec<f64> {
    x.iter().zip(d).map(|(x, d)| x + t * d).collect()
}
