//! Motions of floating bodies that nothing resists under the present contact conditions.

use super::active_set::ContactCondition;
use super::directions::Vector;
use super::transform::Transformed;
use crate::contact::rigid::{RigidMotions, near_kernel_of};
use crate::linalg::{Csr, axpy, dot};

/// Such motions, which are taken off directions near the solution. No force acts along them but what rounding has left, and no energy
/// stops it: bodies that nothing loads go ever farther, twice as far with each cycle, and take the residual with them. Of five load
/// steps of two unloaded plates (954 unknowns, to 1e-10) one took 1000 cycles on four ranks.
#[derive(Debug, Clone, Default)]
pub(super) struct LooseMotions {
    /// Whether each row of the jumps is resisted.
    resisted: Vec<bool>,
    /// Orthonormal combinations of the motions of all bodies.
    combinations: Vec<Vec<f64>>,
}

/// The residual below which they are taken off. Above it a body that is loaded may have lost its contact for a while.
pub(super) const NEAR: f64 = 1e-9;
/// A combination of this length, over that of the best resisted one, is not resisted.
const UNSEEN: f64 = 1e-6;
/// What rounding leaves of the work of loads that cancel, over the sum of the sizes of its terms.
const ROUNDING: f64 = 1e-12;

/// Whether each row of a point is resisted: its component is constrained or has a spring, or friction acts along it.
pub(super) fn resisted(condition: &ContactCondition) -> [bool; 3] {
    let constraint = &condition.constraint;
    let has_friction = condition.friction != [0.0; 2];
    [0, 1, 2].map(|c| constraint.constrained[c] || constraint.spring[c] != [0.0; 3] || c > 0 && has_friction)
}

impl LooseMotions {
    /// Finds them anew where other rows are resisted: `jumps` has those of the points of all ranks, and the loads do the work
    /// `resultant` on each motion.
    pub(super) fn update(&mut self, resisted: Vec<bool>, jumps: &Csr, resultant: &[f64]) {
        if self.resisted == resisted {
            return;
        }
        let is_balanced = |combination: &Vec<f64>| {
            let size: f64 = combination.iter().zip(resultant).map(|(a, r)| (a * r).abs()).sum();
            dot(combination, resultant).abs() <= ROUNDING * size
        };
        self.combinations = unresisted(jumps, &resisted).into_iter().filter(is_balanced).collect();
        self.resisted = resisted;
    }

    /// Takes them off displacements in the frames.
    pub(super) fn take_off(&self, transformed: &Transformed, motions: &RigidMotions, p: &mut Vector) {
        if self.combinations.is_empty() {
            return;
        }
        let halo = transformed.halo();
        // Zero at nodes of other ranks.
        let mut along = motions.work(&transformed.out_of_frames(p));
        halo.sum(&mut along);
        let mut off = vec![0.0; along.len()];
        self.combinations.iter().for_each(|combination| axpy(-dot(combination, &along), combination, &mut off));
        let mut u = vec![0.0; transformed.nodes.of.len()];
        motions.add(&off, &mut u);
        let change = transformed.to_frames(&u);
        p.iter_mut().flatten().zip(change.as_flattened()).for_each(|(p, change)| *p += change);
    }
}

/// Orthonormal combinations of the motions with these `jumps` that move nothing along resisted rows.
fn unresisted(jumps: &Csr, resisted: &[bool]) -> Vec<Vec<f64>> {
    let k = jumps.cols;
    let mut gram = vec![vec![0.0; k]; k];
    let mut largest: f64 = 0.0;
    for (i, resisted) in resisted.iter().enumerate() {
        for (a, of_a) in jumps.entries_of(i) {
            largest = largest.max(of_a * of_a);
            for (b, of_b) in jumps.entries_of(i).filter(|_| *resisted) {
                gram[a as usize][b as usize] += of_a * of_b;
            }
        }
    }
    near_kernel_of(&gram, UNSEEN * UNSEEN * largest)
}
