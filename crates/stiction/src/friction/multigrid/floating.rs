use super::directions::Vector;
use super::frames::Turned;
use super::iteration::State;
use super::sets::Law;
use crate::contact::ContactProblem;
use crate::contact::rigid::RigidMotions;
use crate::friction::direct::rigid_start::{Foundation, balanced};

/// Bodies that contact alone holds: what it takes to move each of them as a whole.
pub(super) struct Floating<'a> {
    motions: &'a RigidMotions,
    /// Jumps of the motions at the points, length `3m` each.
    jumps: Vec<Vec<f64>>,
    /// Work of the loads on the motions, newton.
    resultant: Vec<f64>,
}

impl<'a> Floating<'a> {
    /// `None` where no body floats.
    pub fn new(problem: &ContactProblem, turned: &'a Turned) -> Option<Floating<'a>> {
        turned.points.iter().any(|p| p.floats).then(|| {
            let motions = &turned.motions;
            let jumps = motions.jumps(&problem.isotropic_rows());
            Floating { motions, jumps, resultant: balanced(motions, &problem.elastic.f) }
        })
    }

    /// Moves the bodies to where the augmented multipliers that the law admits balance the loads: the points that are then
    /// in contact can hold the bodies, and those that stick keep them from sliding. No cycle finds these motions by itself
    /// once the sets hold a body no more: nothing resists them on any level.
    pub fn settle(&self, turned: &Turned, laws: &[Law], at: &mut State) {
        // Rigid motions take no forces: `ku` stays.
        let moved = self.motion(turned, laws, at);
        at.u.iter_mut().flatten().zip(moved.iter().flatten()).for_each(|(u, d)| *u += d);
    }

    /// That motion, in the frames.
    pub fn motion(&self, turned: &Turned, laws: &[Law], at: &State) -> Vector {
        let m = laws.len();
        let mut opening = vec![0.0; 3 * m];
        for (j, (p, law)) in turned.points.iter().zip(laws).enumerate() {
            for c in (0..3).filter(|&c| p.live[c]) {
                let lambda = turned.f[p.node][c] - at.ku[p.node][c];
                opening[c * m + j] = law.rest[c] - at.u[p.node][c] - lambda / law.parameter;
            }
        }
        let friction: Vec<_> = laws.iter().map(|law| law.friction).collect();
        let stiffness: Vec<_> = laws.iter().map(|law| law.parameter).collect();
        let (jumps, resultant) = (&self.jumps[..], &self.resultant[..]);
        let (friction, opening, stiffness) = (&friction[..], &opening[..], &stiffness[..]);
        let rest = Foundation { friction, jumps, resultant, opening, stiffness }.rest();
        let mut u = vec![0.0; turned.nodes.of.len()];
        self.motions.add(&rest.alpha, &mut u);
        turned.to_frames(&u)
    }
}
