use super::directions::Vector;
use super::frames::Turned;
use super::sets::{Law, Set, set, stuck};
use crate::friction::PointState;
use crate::linalg::multigrid::{Block, Multigrid, Nested};

/// Violation of the balance, over the larger of load and contact forces, at which the coarse problem is left: a better
/// solution saves no fine cycle.
const ROUGH: f64 = 0.03;
/// Cycles on the coarse problem; ten to fifteen are usual.
const CYCLES: usize = 60;

/// Displacements to start from, by nested iteration without a coarser mesh: contact in the space of the second coarse
/// level of the hierarchy, whose cycles are cheap. From zero a front of opening moves by an aggregate a cycle, which is a
/// few elements on the finest level and many there.
///
/// That space cannot follow single points, so they are held by springs: the law with the force per length it is tested with
/// and no multipliers, which is stiff beside a whole aggregate. `None` if there is no such level or the sets do not settle.
pub(super) fn start(turned: &Turned, laws: &[Law], multigrid: &mut Multigrid) -> Option<Vector> {
    let mut nested = Nested::new(multigrid)?;
    let f = nested.restrict(&turned.f);
    let mut x = vec![[0.0; 6]; f.len()];
    for cycle in 0..CYCLES {
        let u = nested.to_nodes(&x);
        let pulls: Vec<Pull> = (laws.iter().zip(&turned.points).zip(&u))
            .map(|((law, p), &u)| {
                let touches = cycle == 0 && law.rest[0] <= 0.0;
                pull(law, u, &if touches { stuck(law, p) } else { set(law, p, [0.0; 3], u) })
            })
            .collect();
        let contact = nested.from_nodes(&pulls.iter().map(|p| p.force).collect::<Vec<_>>());
        let mut r = nested.times(&x);
        let loads = f.iter().flatten().zip(contact.iter().flatten());
        r.iter_mut().flatten().zip(loads).for_each(|(r, (f, contact))| *r = f - contact - *r);
        if norm(&r) <= ROUGH * norm(&f).max(norm(&contact)) {
            return Some(nested.prolong(&x));
        }
        nested.set_springs(&pulls.iter().map(|p| p.spring).collect::<Vec<_>>());
        let z = nested.cycle(&r);
        x.iter_mut().flatten().zip(z.iter().flatten()).for_each(|(x, z)| *x += z);
    }
    None
}

/// What acts against the displacements of a point, newton, and by how much it grows with them.
struct Pull {
    force: [f64; 3],
    spring: Block<3, 3>,
}

fn pull(law: &Law, u: [f64; 3], set: &Set) -> Pull {
    let (mut force, mut spring) = ([0.0; 3], set.condition.spring);
    for c in 0..3 {
        if set.condition.held[c] {
            force[c] = law.parameter * (u[c] - law.rest[c]);
            spring[c][c] += law.parameter;
        } else if c > 0 && set.state == PointState::Slip {
            force[c] = set.friction[c - 1];
        }
    }
    Pull { force, spring }
}

fn norm(x: &[[f64; 6]]) -> f64 {
    x.iter().flatten().map(|v| v * v).sum::<f64>().sqrt()
}
