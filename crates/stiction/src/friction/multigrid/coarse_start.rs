use super::active_set::{ContactCondition, PointLaw, closed_condition, contact_condition};
use super::directions::Vector;
use super::transform::Transformed;
use crate::friction::PointState;
use crate::linalg::multigrid::{Block, CoarseProblem, Hierarchy};
use crate::ranks::Halo;

/// Violation of the balance, over the larger of load and contact forces, at which the coarse problem counts as solved: a
/// better solution saves no fine cycle.
const ROUGH: f64 = 0.03;
/// Most cycles on the coarse problem; ten to fifteen are usual.
const CYCLES: usize = 60;

/// Displacements to start from, by nested iteration without a coarser mesh: contact in the space of the second coarse
/// level of the hierarchy, whose cycles are cheap. From zero a front of opening moves by an aggregate a cycle, which is a
/// few elements on the finest level and many there.
///
/// That space does not resolve single points, so springs constrain them: the law with its parameter and without multipliers,
/// which is stiff compared with a whole aggregate. `None` without such a level, or if the active sets do not settle.
pub(super) fn start(transformed: &Transformed, laws: &[PointLaw], hierarchy: &mut Hierarchy) -> Option<Vector> {
    let mut coarse = CoarseProblem::new(hierarchy)?;
    let f = coarse.restrict(&transformed.f);
    let mut x = vec![[0.0; 6]; f.len()];
    for cycle in 0..CYCLES {
        let u = coarse.to_nodes(&x);
        let forces: Vec<SpringForce> = (laws.iter().zip(&transformed.points).zip(&u))
            .map(|((law, p), &u)| {
                let closed = cycle == 0 && law.target[0] <= 0.0;
                spring_force(
                    law,
                    u,
                    &if closed { closed_condition(law, p) } else { contact_condition(law, p, [0.0; 3], u) },
                )
            })
            .collect();
        let contact = coarse.restrict_from_nodes(&forces.iter().map(|p| p.force).collect::<Vec<_>>());
        let mut r = coarse.times(&x);
        let loads = f.iter().flatten().zip(contact.iter().flatten());
        r.iter_mut().flatten().zip(loads).for_each(|(r, (f, contact))| *r = f - contact - *r);
        let [left, load, contact] = norms(coarse.halo(), [&r, &f, &contact]);
        if left <= ROUGH * load.max(contact) {
            return Some(coarse.prolong(&x));
        }
        coarse.set_springs(&forces.iter().map(|p| p.spring).collect::<Vec<_>>());
        let z = coarse.cycle(&r);
        x.iter_mut().flatten().zip(z.iter().flatten()).for_each(|(x, z)| *x += z);
    }
    None
}

/// The contact force on a point, newton, and its derivative by the displacement.
struct SpringForce {
    force: [f64; 3],
    spring: Block<3, 3>,
}

fn spring_force(law: &PointLaw, u: [f64; 3], condition: &ContactCondition) -> SpringForce {
    let (mut force, mut spring) = ([0.0; 3], condition.constraint.spring);
    for c in 0..3 {
        if condition.constraint.constrained[c] {
            force[c] = law.parameter * (u[c] - law.target[c]);
            spring[c][c] += law.parameter;
        } else if c > 0 && condition.state == PointState::Slip {
            force[c] = condition.friction[c - 1];
        }
    }
    SpringForce { force, spring }
}

/// Of what all ranks have.
fn norms(halo: &Halo, of: [&[[f64; 6]]; 3]) -> [f64; 3] {
    let mut squares = of.map(|x| x.iter().flatten().map(|v| v * v).sum::<f64>());
    halo.sum(&mut squares);
    squares.map(f64::sqrt)
}
