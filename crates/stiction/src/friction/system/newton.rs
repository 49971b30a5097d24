use std::ops::ControlFlow;

use super::{Iterate, Step, System, length};
use crate::contact::Friction;
use crate::friction::law::{Linearisation, V3, augmented, residual, state};
use crate::friction::{End, PointState};
use crate::linalg::norm;

/// Thresholds of [`newton`] in which its users differ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rules {
    /// Steps without a tenth gained on the best residual that count as a stall.
    pub patience: usize,
    /// Backtracking ends here: a smaller step means that the direction is no descent.
    pub shortest: f64,
    /// Full steps taken although the line search found none: they leave cycles that no short step leaves.
    pub leaps: usize,
    /// Slopes of the bound of friction by the normal force that are used while the residual is above `Threshold::NEAR`. Far from the
    /// solution a large coefficient makes the step of a slipping point run away through its normal force (the reduced
    /// matrix loses its definiteness); near it the coupling is what makes the method fast.
    pub largest_slope: f64,
    /// Relative accuracy of a step while points change their state.
    pub accuracy: f64,
}

/// Thresholds of [`newton`] that all its users share, held against the random cases and the files of FCLib.
struct Threshold;

impl Threshold {
    /// A step may raise the residual as long as it stays below the largest of so many before it.
    const MEMORY: usize = 4;
    /// Part of the residual by which a full step has to lower it.
    const DECREASE: f64 = 1e-4;
    /// Relative accuracy of a step that is taken again where one of less was no descent: a thin strip bends far under small
    /// differences of forces, and its residual rises by what the inner iteration left (a belt around a cylinder is not solved
    /// without).
    const FINE: f64 = 1e-9;
    /// Relative residual below which friction follows the normal force whatever the coefficient.
    const NEAR: f64 = 0.1;
}

/// `v` is to be `v + compliance (lambda - centre)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ProximalTerm<'a> {
    pub centre: &'a [V3],
    /// Length per force, one number a point.
    pub compliance: &'a [f64],
}

/// What a run of Newton steps works on.
pub(crate) struct Newton<'a> {
    pub system: &'a dyn System,
    pub friction: &'a [Friction],
    /// The parameter of the law, one a point, force per length.
    pub r: &'a [f64],
    /// What forces at each point are multiplied with before norms are taken; one unless small forces are to count.
    pub weight: &'a [f64],
    pub proximal: Option<ProximalTerm<'a>>,
    /// Stop when the residual's norm is at most `tolerance` times that of the multipliers, or at most `absolute`.
    pub tolerance: f64,
    pub absolute: f64,
    pub rules: Rules,
}

/// Receives the iterate, the norms of its residual and multipliers and the states of its points at every step; may stop.
pub(crate) type Observe<'a> = dyn FnMut(&Iterate, f64, f64, &[PointState]) -> ControlFlow<()> + 'a;

impl Newton<'_> {
    /// `v` with the proximal term.
    fn v(&self, at: &Iterate, j: usize) -> V3 {
        let v = at.v[j];
        self.proximal.map_or(v, |term| {
            std::array::from_fn(|i| v[i] + term.compliance[j] * (at.lambda[j][i] - term.centre[j][i]))
        })
    }

    /// Norm of the residual and of what forces on floating bodies lack of balance.
    pub(crate) fn merit(&self, at: &Iterate) -> f64 {
        let residual = |j: usize| residual(self.friction[j], at.lambda[j], self.v(at, j), self.r[j]);
        let residual: Vec<V3> = (0..self.r.len()).map(residual).collect();
        self.weighed(&residual).hypot(norm(&self.system.imbalance(&at.lambda)))
    }

    /// Weighted norm of a force at each point.
    pub(crate) fn weighed(&self, forces: &[V3]) -> f64 {
        let weighed: Vec<V3> = forces.iter().zip(self.weight).map(|(x, w)| x.map(|x| w * x)).collect();
        length(&weighed)
    }

    pub(crate) fn states(&self, at: &Iterate) -> Vec<PointState> {
        let state = |j: usize| state(self.friction[j], augmented(at.lambda[j], self.v(at, j), self.r[j]));
        (0..self.r.len()).map(state).collect()
    }

    /// The residual at which a run ends whose multipliers have this norm.
    pub(crate) fn target(&self, scale: f64) -> f64 {
        (self.tolerance * scale).max(self.absolute)
    }

    pub(crate) fn linearised(&self, at: &Iterate, largest_slope: f64) -> Vec<Linearisation> {
        let point = |j: usize| {
            let has_row = self.system.has_row(j);
            let law =
                Linearisation::new(self.friction[j], self.r[j], has_row, largest_slope, at.lambda[j], self.v(at, j));
            self.proximal.map_or(law, |term| law.with_compliance(term.compliance[j]))
        };
        (0..self.r.len()).map(point).collect()
    }
}

/// Semismooth Newton (Alart & Curnier 1991) with inexact steps and non-monotone backtracking (Grippo, Lampariello &
/// Lucidi 1986) on the norm of the residual. `steps` counts down to the limit of the whole solve.
pub(crate) fn newton(on: &Newton<'_>, at: &mut Iterate, steps: &mut usize, observe: &mut Observe<'_>) -> End {
    let mut recent: Vec<f64> = Vec::new();
    let (mut best, mut since_best, mut leaps) = (f64::INFINITY, 0, 0);
    let mut previous: Vec<PointState> = Vec::new();
    let mut theta = on.merit(at);
    loop {
        let now = on.states(at);
        let scale = on.weighed(&at.lambda);
        if observe(at, theta, scale, &now).is_break() {
            return End::Interrupted;
        }
        let target = on.target(scale);
        if theta <= target {
            return End::Converged;
        }
        if *steps == 0 {
            return End::Limit;
        }
        since_best = if theta < 0.9 * best { 0 } else { since_best + 1 };
        best = best.min(theta);
        if since_best > on.rules.patience || !theta.is_finite() {
            return End::Stalled;
        }
        *steps -= 1;
        // While points still change their state the linear model is only as good as that; once they rest, the step
        // is worth solving as far as its quadratic error allows.
        let relative = theta / scale.max(f64::MIN_POSITIVE);
        let quadratic = (0.3 * target / theta).max(0.1 * relative).min(on.rules.accuracy);
        let accuracy = if now == previous { quadratic } else { on.rules.accuracy };
        let largest_slope = if theta < Threshold::NEAR * scale { f64::INFINITY } else { on.rules.largest_slope };
        let laws = on.linearised(at, largest_slope);
        // A motion that nothing resists would be as long as rounding makes it.
        let step = |accuracy: f64| on.system.step(at, &laws, accuracy).filter(|step| step.resisted);
        let Some(first) = step(accuracy) else { return End::Stalled };
        recent.push(theta);
        let highest = recent.iter().rev().take(Threshold::MEMORY).fold(0.0, |a: f64, &b| a.max(b));
        let trial = |step: &Step, t: f64| {
            let next = on.system.advance(at, t, step);
            let theta = on.merit(&next);
            (next, theta)
        };
        let search = |step: &Step| {
            let mut lengths =
                std::iter::successors(Some(1.0), |t| Some(0.5 * t)).take_while(|t| *t >= on.rules.shortest);
            let falls = |(_, theta): &(Iterate, f64), t: f64| *theta <= (1.0 - Threshold::DECREASE * t) * highest;
            lengths.find_map(|t| Some(trial(step, t)).filter(|next| falls(next, t)))
        };
        let fine = || if on.system.is_exact() || accuracy <= Threshold::FINE { None } else { step(Threshold::FINE) };
        let next = search(&first).or_else(|| search(&fine()?));
        let next = match next {
            Some(next) => next,
            None if leaps < on.rules.leaps => {
                leaps += 1;
                recent.clear();
                trial(&first, 1.0)
            }
            None => return End::Stalled,
        };
        (*at, theta) = next;
        previous = now;
    }
}
