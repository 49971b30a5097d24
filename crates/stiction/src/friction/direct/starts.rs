//! What Newton's method starts from where no multipliers are given.

use super::rigid_start::{Equilibrium, Foundation, keep_apart};
use super::solve::Solver;
use crate::friction::law::{V3, projection};
use crate::friction::system::{by_component, by_point};

impl Solver<'_> {
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
