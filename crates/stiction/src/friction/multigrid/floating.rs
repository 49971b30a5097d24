use super::directions::Vector;
use super::iteration::{Iterate, Subproblem};
use super::transform::Transformed;
use crate::contact::ContactProblem;
use crate::contact::rigid::RigidMotions;
use crate::contact::sliding::least_resisted;
use crate::friction::direct::rigid_start::{Foundation, balanced};

/// Floating bodies, which contact alone supports, with the data of their rigid motions.
pub(super) struct FloatingBodies<'a> {
    problem: &'a ContactProblem,
    motions: &'a RigidMotions,
    /// Jumps of the motions at the points, length `3m` each.
    jumps: Vec<Vec<f64>>,
    /// Work of the loads on the motions, newton.
    resultant: Vec<f64>,
}

impl<'a> FloatingBodies<'a> {
    /// `None` where no body floats.
    pub(super) fn new(problem: &'a ContactProblem, transformed: &'a Transformed) -> Option<FloatingBodies<'a>> {
        transformed.points.iter().any(|p| p.floats).then(|| {
            let motions = &transformed.motions;
            let jumps = motions.jumps(&problem.isotropic_rows());
            FloatingBodies { problem, motions, jumps, resultant: balanced(motions, &problem.elastic.f) }
        })
    }

    /// Moves the bodies as rigid ones to where the admissible augmented multipliers balance their loads: the points then in
    /// contact support the bodies, and the sticking ones keep them from sliding. Once the active constraints do not support a
    /// body, cycles do not find these motions, because no level resists them.
    pub(super) fn balance(&self, problem: &Subproblem<'_>, at: &mut Iterate) {
        // Rigid motions take no forces: `ku` stays.
        let motion = self.motion(problem, at);
        at.u.iter_mut().flatten().zip(motion.iter().flatten()).for_each(|(u, d)| *u += d);
    }

    /// Whether the loads move some body along the surfaces that press against one another with these normal forces (newton, `m`)
    /// by more than the friction that is given by them resists. The energy then falls without bound along this motion.
    pub(super) fn slide_off(&self, normals: &[f64]) -> bool {
        let mut lambda = normals.to_vec();
        lambda.resize(3 * normals.len(), 0.0);
        least_resisted(self.problem, self.motions, &lambda).is_some_and(|found| found.load > found.friction)
    }

    /// That motion, in the frames.
    pub(super) fn motion(&self, problem: &Subproblem<'_>, at: &Iterate) -> Vector {
        let m = problem.laws.len();
        let mut gap = vec![0.0; 3 * m];
        for (j, (p, law)) in problem.points().enumerate() {
            let lambda = at.force(problem.transformed, p.node);
            for c in (0..3).filter(|&c| p.has_row[c]) {
                gap[c * m + j] = law.target[c] - at.u[p.node][c] - lambda[c] / law.parameter;
            }
        }
        let friction: Vec<_> = problem.laws.iter().map(|law| law.friction).collect();
        let stiffness: Vec<_> = problem.laws.iter().map(|law| law.parameter).collect();
        let (jumps, resultant) = (&self.jumps[..], &self.resultant[..]);
        let (friction, gap, stiffness) = (&friction[..], &gap[..], &stiffness[..]);
        let equilibrium = Foundation { friction, jumps, resultant, gap, stiffness }.equilibrium();
        let mut u = vec![0.0; problem.transformed.nodes.of.len()];
        self.motions.add(&equilibrium.alpha, &mut u);
        problem.transformed.to_frames(&u)
    }
}
