use super::active_set::{PointLaw, closed_condition};
use super::directions::Vector;
use super::points::Point;
use super::springs::{spring_condition, spring_force};
use super::step_length::least_along;
use super::tightening::share;
use super::transform::Transformed;
use crate::contact::Friction;
use crate::friction::law::frozen;
use crate::linalg::multigrid::{Block, CoarseProblem, Hierarchy};
use crate::ranks::Halo;

/// Thresholds of [`start`].
struct Threshold;

impl Threshold {
    /// Violation of the balance, over the larger of load and contact forces, at which the coarse problem counts as solved: a
    /// better solution saves no fine cycle.
    const ROUGH: f64 = 0.03;
    /// Most cycles on the coarse problem; ten to fifteen are usual.
    const CYCLES: usize = 60;
    /// First and least relaxation of the normal forces that bound friction. It is halved while the violation does not fall
    /// below [`Self::FALLS`] times the last one: in a body that is wedged a bound that falls raises the next one by more.
    const RELAXATION: [f64; 2] = [0.5, 0.06];
    const FALLS: f64 = 0.8;
    /// Slope of the energy at the ends of the interval of a step over that where the step begins.
    const SLOPE: f64 = 0.2;
}

/// Displacements to start from, by nested iteration without a coarser mesh: contact in the space of the second coarse
/// level of the hierarchy, whose cycles are cheap. From zero a front of opening moves by an aggregate a cycle, which is a
/// few elements on the finest level and many there. `rigid` are displacements of floating bodies to begin with.
///
/// That space does not resolve single points, so springs constrain them: the law with its parameter and without multipliers,
/// which is stiff compared with a whole aggregate. The friction of a cycle is bounded by normal forces before it, so that
/// the springs have an energy, and a step is as long as makes it least. `None` without such a level, or if the active sets do
/// not settle.
pub(super) fn start(
    transformed: &Transformed,
    laws: &[PointLaw],
    hierarchy: &mut Hierarchy,
    rigid: Option<&Vector>,
) -> Option<Vector> {
    let mut coarse = CoarseProblem::new(hierarchy)?;
    let points = &transformed.points;
    let f = coarse.restrict(&transformed.f);
    let mut x = vec![[0.0; 6]; f.len()];
    // Displacements of the points.
    let mut u: Vector = points.iter().map(|p| rigid.map_or([0.0; 3], |rigid| rigid[p.node])).collect();
    let mut normals: Vec<f64> = Vec::new();
    // Where each rank has all of the coarse space, the first one counts it.
    let part = if coarse.halo().is_divided() { 1.0 } else { share(transformed.halo()) };
    let ([mut relaxation, least], mut last) = (Threshold::RELAXATION, f64::INFINITY);
    for cycle in 0..Threshold::CYCLES {
        // From zero the points that touch are tied first: nothing is known of their forces.
        let ties = cycle == 0 && rigid.is_none();
        let now = normal_forces(laws, points, &u);
        if cycle < 2 {
            normals = now;
        } else {
            normals.iter_mut().zip(now).for_each(|(normal, now)| *normal += relaxation * (now - *normal));
        }
        let given: Vec<PointLaw> = (laws.iter().zip(&normals))
            .map(|(law, &normal)| PointLaw { friction: frozen(law.friction, normal), ..*law })
            .collect();
        let is_tied = |law: &PointLaw| ties && law.target[0] <= 0.0;
        let springs: Vec<Spring> = (given.iter().zip(points).zip(&u))
            .map(|((law, p), &u)| if is_tied(law) { Spring::tied(law, p, u) } else { Spring::of(law, p, u) })
            .collect();
        let contact = coarse.restrict_from_nodes(&springs.iter().map(|p| p.force).collect::<Vec<_>>());
        let ax = coarse.times(&x);
        let mut r = f.clone();
        let taken = contact.iter().flatten().zip(ax.iter().flatten());
        r.iter_mut().flatten().zip(taken).for_each(|(r, (contact, ax))| *r -= contact + ax);
        let [left, load, contact] = norms(coarse.halo(), [&r, &f, &contact]);
        let left = left / load.max(contact).max(f64::MIN_POSITIVE);
        if left <= Threshold::ROUGH {
            let mut start = coarse.prolong(&x);
            let rigid = rigid.iter().flat_map(|rigid| rigid.iter().flatten());
            start.iter_mut().flatten().zip(rigid).for_each(|(u, rigid)| *u += rigid);
            return Some(start);
        }
        if left > Threshold::FALLS * last {
            relaxation = least.max(0.5 * relaxation);
        }
        last = left;
        coarse.set_springs(&springs.iter().map(|p| p.stiffness).collect::<Vec<_>>());
        let z = coarse.cycle(&r);
        let d = coarse.to_nodes(&z);
        let step = if ties {
            1.0
        } else {
            // Elastic and load forces along the step, at its start and their change.
            let elastic = [dot(&z, &ax) - dot(&z, &f), dot(&z, &coarse.times(&z))].map(|work| part * work);
            let slope = |t: f64| elastic[0] + t * elastic[1] + work_along(&given, points, [&u, &d], t);
            least_along(transformed.halo(), slope, Threshold::SLOPE)
        };
        x.iter_mut().flatten().zip(z.iter().flatten()).for_each(|(x, z)| *x += step * z);
        u.iter_mut().flatten().zip(d.iter().flatten()).for_each(|(u, d)| *u += step * d);
    }
    None
}

/// Normal forces of the springs at points with displacements `u`, newton.
fn normal_forces(laws: &[PointLaw], points: &[Point], u: &Vector) -> Vec<f64> {
    let all = laws.iter().zip(points).zip(u);
    all.map(|((law, p), &u)| spring_force(law, p, u, law.parameter, 0.0)[0]).collect()
}

/// Slope of the energy of the springs along `d` at `u + t d`, force times length.
fn work_along(laws: &[PointLaw], points: &[Point], [u, d]: [&Vector; 2], t: f64) -> f64 {
    let mut slope = 0.0;
    for (((law, p), u), d) in laws.iter().zip(points).zip(u).zip(d) {
        let force = force(law, p, std::array::from_fn(|c| u[c] + t * d[c]));
        slope += (0..3).map(|c| force[c] * d[c]).sum::<f64>();
    }
    slope
}

/// The contact force on a point, newton, and its derivative by the displacement.
struct Spring {
    force: [f64; 3],
    stiffness: Block<3, 3>,
}

impl Spring {
    /// Of a point that is in contact and, if it has friction, sticks.
    fn tied(law: &PointLaw, p: &Point, u: [f64; 3]) -> Spring {
        let constrained = closed_condition(law, p).constraint.constrained;
        let mut tie = Spring { force: [0.0; 3], stiffness: [[0.0; 3]; 3] };
        for c in (0..3).filter(|&c| constrained[c]) {
            tie.force[c] = law.parameter * (u[c] - law.target[c]);
            tie.stiffness[c][c] = law.parameter;
        }
        tie
    }

    /// By a law whose friction has a given bound.
    fn of(law: &PointLaw, p: &Point, u: [f64; 3]) -> Spring {
        if law.friction == Friction::Bonded {
            return Spring::tied(law, p, u);
        }
        let stiffness = spring_condition(law, p, u, law.parameter).constraint.spring;
        Spring { force: force(law, p, u), stiffness }
    }
}

/// The force of the spring of a law whose friction has a given bound, newton.
fn force(law: &PointLaw, p: &Point, u: [f64; 3]) -> [f64; 3] {
    match law.friction {
        Friction::Bonded => Spring::tied(law, p, u).force,
        friction => spring_force(law, p, u, law.parameter, friction.bound(0.0)),
    }
}

fn dot(x: &[[f64; 6]], y: &[[f64; 6]]) -> f64 {
    x.iter().flatten().zip(y.iter().flatten()).map(|(x, y)| x * y).sum()
}

/// Of what all ranks have.
fn norms(halo: &Halo, of: [&[[f64; 6]]; 3]) -> [f64; 3] {
    let mut squares = of.map(|x| dot(x, x));
    halo.sum(&mut squares);
    squares.map(f64::sqrt)
}
