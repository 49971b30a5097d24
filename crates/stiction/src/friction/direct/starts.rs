//! What Newton's method starts from where no multipliers are given.

use super::rigid_start::{Equilibrium, Foundation, keep_apart};
use super::solve::Solver;
use crate::contact::Friction;
use crate::friction::law::{Linearisation, V3, projection};
use crate::friction::solution::{End, Phase, Progress};
use crate::friction::system::{Iterate, Newton, Observe, Rules, System, by_component, by_point, newton};
use crate::linalg::{Watch, norm};

/// Thresholds of the start from closed points, found with belts around a cylinder (`tests/physics/slender.rs`): without it twelve of
/// them take 47 to over 200 steps, with it the ten thickest 4 to 13. 1500 random cases take 8 298 instead of 8 418.
struct Threshold;

impl Threshold {
    /// The residual without contact forces over the load above which bodies are so slender that their free shape does not say where they
    /// touch: belts have 100 to 1 400, the shipped cases 0.003 to 6.
    const SLENDER: f64 = 30.0;
    /// Relative accuracy of a step: with 1e-6 some belts take three times as many steps, with 1e-4 some are not solved.
    const ACCURACY: f64 = 1e-9;
    /// The residual over the contact forces at which friction comes in.
    const TARGET: f64 = 1e-3;
}

/// Newton's method without friction is one on active sets, and arrives with whole steps that raise the residual for a while. Where a step has
/// to lower it, three of the ten belts take over 200 steps again.
const WHOLE_STEPS: Rules =
    Rules { patience: 10, shortest: 1.0 / 64.0, leaps: 10, largest_slope: 0.0, accuracy: Threshold::ACCURACY };

fn whole_steps(on: &Newton<'_>, at: &mut Iterate, steps: &mut usize, observe: &mut Observe<'_>) -> End {
    newton(&Newton { rules: WHOLE_STEPS, ..*on }, at, steps, observe)
}

impl Solver<'_> {
    /// Slender bodies start from contact without friction, the first problem of the fixed point, and that from all points closed:
    /// a belt that nothing holds is bent by a thousand times what contact leaves of it. Nothing is changed where that does not arrive.
    ///
    /// Returns how the solve ended if it did.
    pub(super) fn slender_start(&mut self, observer: &mut Watch<Progress>) -> Option<End> {
        let without = |law: &Friction| if *law == Friction::Bonded { Friction::Bonded } else { Friction::None };
        let laws: Vec<Friction> = self.friction().iter().map(without).collect();
        let merit = self.newton(&laws, &self.r, Threshold::TARGET).merit(&self.at);
        let load = norm(&self.problem.elastic.f);
        if load == 0.0 || merit <= Threshold::SLENDER * load {
            return None;
        }
        let before = self.at.clone();
        self.close(&laws);
        match self.steps(whole_steps, &laws, Phase::FixedPoint, 1.0, Threshold::TARGET, observer) {
            End::Converged => None,
            End::Stalled => {
                self.at = before;
                None
            }
            end => Some(end),
        }
    }

    /// All points touch, as `laws` without friction allow, unless that fits worse.
    fn close(&mut self, laws: &[Friction]) {
        let closed = |j: usize| {
            let Iterate { lambda, v, .. } = &self.at;
            // Pressed so that the point counts as touching whatever its gap.
            let pressed = [2.0 * self.r[j] * v[j][0].abs() + f64::MIN_POSITIVE, lambda[j][1], lambda[j][2]];
            let from = if laws[j] == Friction::Bonded { lambda[j] } else { pressed };
            Linearisation::new(laws[j], self.r[j], self.system.has_row(j), 0.0, from, v[j])
        };
        let points: Vec<Linearisation> = (0..self.r.len()).map(closed).collect();
        let step = self.system.step(&self.at, &points, Threshold::ACCURACY).filter(|step| step.resisted);
        if let Some(step) = step {
            let closed = self.system.advance(&self.at, 1.0, &step);
            let newton = self.newton(laws, &self.r, Threshold::TARGET);
            if newton.merit(&closed) < newton.merit(&self.at) {
                self.at = closed;
            }
        }
    }

    /// Bodies that float start in their equilibrium as rigid bodies, with the forces of the foundation.
    pub(super) fn rigid_start(&mut self) {
        let floating = &self.dual().floating;
        if floating.is_empty() {
            return;
        }
        let mut u = self.dual().displacement(self.problem, &vec![0.0; self.v0.len()]);
        // The springs bend a body whose loads they have to balance; one that is tightened or heated keeps its shape.
        let mut first = 0;
        for body in &floating.motions.bodies {
            let own = first..first + body.motions.len();
            first = own.end;
            if self.system.resultant[own].iter().any(|&e| e != 0.0) {
                body.unknowns.iter().for_each(|&i| u[i as usize] = 0.0);
            }
        }
        let mut gap = self.problem.gap_and_slip(&u);
        let margin = keep_apart(self.friction(), &mut gap);
        let least = margin * self.r.iter().fold(0.0, |a: f64, r| a.max(*r));
        self.take_foundation(&gap);
        if self.at.lambda.as_flattened().iter().all(|x| x.abs() <= least) {
            self.at.lambda.fill([0.0; 3]);
            self.refresh();
        } else {
            self.align();
        }
    }

    /// Moves floating bodies until the augmented multipliers of the present deformation balance their loads, and takes these
    /// for the multipliers.
    pub(super) fn settle(&mut self) {
        if !self.dual().floating.is_empty() {
            self.take_foundation(&self.augmented_gap());
            self.align();
        }
    }

    /// Moves floating bodies, with the multipliers as they are, to where the augmented ones balance their loads: the points
    /// that are then in contact hold the bodies, and the next step finds them there.
    fn align(&mut self) {
        self.at.alpha = self.foundation(&self.augmented_gap()).alpha;
        self.refresh();
    }

    /// The gap at which a foundation exerts `lambda - r v`, where floating bodies have not moved.
    fn augmented_gap(&self) -> Vec<f64> {
        let still: Vec<f64> = self.at.alpha.iter().map(|a| -a).collect();
        let mut gap = by_component(&self.at.v);
        self.dual().floating.close(&still, &mut gap);
        let lambda = by_component(&self.at.lambda);
        gap.iter_mut().enumerate().for_each(|(i, v)| *v -= lambda[i] / self.r[i % self.r.len()]);
        gap
    }

    /// The equilibrium of rigid bodies on a foundation with this gap at zero motions.
    fn foundation(&self, gap: &[f64]) -> Equilibrium {
        let (friction, jumps) = (self.friction(), &self.dual().floating.jumps);
        let (resultant, stiffness) = (&self.system.resultant[..], &self.r[..]);
        Foundation { friction, jumps, resultant, gap, stiffness }.equilibrium()
    }

    /// Rigid motions and multipliers from that equilibrium.
    fn take_foundation(&mut self, gap: &[f64]) {
        let Equilibrium { alpha, lambda } = self.foundation(gap);
        let admitted = |(j, lambda): (usize, V3)| projection(self.friction()[j], self.system.masked(j, lambda));
        self.at.lambda = by_point(&lambda).into_iter().enumerate().map(admitted).collect();
        self.at.alpha = alpha;
        self.refresh();
    }
}
