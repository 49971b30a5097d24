//! The figures about other solutions ([`CoulombFacts`]) without a factor: each linear problem by multigrid.

use super::active_set::{ContactCondition, PointLaw, contact_condition};
use super::directions::{Direction, MOST_DIRECTIONS, minimise, norm};
use super::iteration::{Iterate, Subproblem, residual};
use super::solve::{Multigrid, point_laws};
use super::transform::Transformed;
use crate::contact::ContactProblem;
use crate::friction::law::slope;
use crate::friction::uniqueness::{CoulombFacts, Threshold, bound, growth, largest_coefficient};
use crate::friction::{PointState, Solution};
use crate::linalg::largest_eigenvalue;
use crate::linalg::multigrid::{CoarseLevels, Hierarchy, NodeConstraint};

/// The same as [`coulomb_facts`](crate::friction::coulomb_facts) by multigrid cycles, which `products` counts; `multigrid`
/// is that of `problem`, or of one with the same `K` and `B`. No bound is known where bodies float or touch each other.
pub fn coulomb_facts_by_multigrid(
    problem: &ContactProblem,
    multigrid: &mut Multigrid,
    solution: &Solution,
) -> Option<CoulombFacts> {
    let largest_coefficient = largest_coefficient(problem)?;
    let Multigrid { transformed, hierarchy, .. } = multigrid;
    transformed.set_load(&problem.elastic.f);
    let laws = point_laws(problem, transformed);
    let u = transformed.to_frames(&solution.u);
    let at = Iterate { ku: transformed.k.times(&u), u, ..Iterate::default() };
    let frozen = |(p, law)| {
        let mut condition = contact_condition(law, p, at.force(transformed, p.node), at.u[p.node]);
        condition.constraint.coulomb = [0.0; 2];
        condition
    };
    let conditions: Vec<ContactCondition> = transformed.points.iter().zip(&laws).map(frozen).collect();
    let normals: Vec<f64> = transformed.points.iter().map(|p| at.force(transformed, p.node)[0]).collect();
    // What follows are changes of the displacements under changes of the friction alone.
    transformed.f.fill([0.0; 3]);
    let laws: Vec<PointLaw> = laws.into_iter().map(|law| PointLaw { target: [0.0; 3], ..law }).collect();
    let mut linear = Linear { transformed, laws: &laws, hierarchy, cycles: 0 };
    let contraction = contraction(&mut linear, conditions, &normals);
    let uniqueness_bound = uniqueness_bound(&mut linear);
    Some(CoulombFacts { contraction, uniqueness_bound, largest_coefficient, products: linear.cycles })
}

/// Linear problems with constraints and forces at the contact points.
struct Linear<'a> {
    transformed: &'a Transformed,
    laws: &'a [PointLaw],
    hierarchy: &'a mut Hierarchy,
    cycles: usize,
}

impl Linear<'_> {
    /// Improves `at` until it balances the friction forces of its conditions.
    fn solve(&mut self, at: &mut Iterate) {
        let Linear { transformed, laws, .. } = *self;
        let problem = Subproblem {
            transformed,
            laws,
            tolerance: Threshold::ACCURACY,
            max_cycles: 0,
            max_resets: 0,
            max_violation: f64::INFINITY,
            floating: None,
            tightening: None,
            equations: None,
        };
        let load = at.conditions.iter().flat_map(|c| c.friction).map(|x| x * x).sum::<f64>().sqrt();
        let mut directions: Vec<Direction> = Vec::new();
        for _ in 0..Threshold::INNER_LIMIT {
            let r = residual(&problem, at);
            let left = norm(transformed.halo(), &r);
            if left <= Threshold::ACCURACY * load || left.is_nan() {
                break;
            }
            let p = self.hierarchy.cycle(&r);
            let kp = transformed.k.times(&p);
            directions.insert(0, Direction { p, kp, shortening: Vec::new() });
            minimise(transformed.halo(), &mut directions, &r, &transformed.points, None, at);
            directions.truncate(MOST_DIRECTIONS - 1);
            self.cycles += 1;
        }
    }

    /// Nothing moves, under these conditions.
    fn at_rest(&mut self, conditions: Vec<ContactCondition>) -> Iterate {
        let constraints: Vec<NodeConstraint> = conditions.iter().map(|c| c.constraint).collect();
        let couples = self.transformed.halo().any(constraints.iter().any(|c| c.coulomb != [0.0; 2]));
        self.hierarchy.constrain(&constraints, CoarseLevels::of(true, couples), true);
        let zero = vec![[0.0; 3]; self.transformed.f.len()];
        Iterate { u: zero.clone(), ku: zero, conditions, ..Iterate::default() }
    }
}

fn contraction(linear: &mut Linear<'_>, conditions: Vec<ContactCondition>, normals: &[f64]) -> f64 {
    let slopes: Vec<f64> = linear.laws.iter().zip(normals).map(|(law, &normal)| slope(law.friction, normal)).collect();
    let direction = |(j, condition): (usize, &ContactCondition)| {
        let length = condition.friction[0].hypot(condition.friction[1]);
        let slips = condition.state == PointState::Slip && length > 0.0;
        slips.then(|| (j, condition.friction.map(|x| x / length)))
    };
    let slips: Vec<(usize, [f64; 2])> = conditions.iter().enumerate().filter_map(direction).collect();
    let mut at = linear.at_rest(conditions);
    at.conditions.iter_mut().for_each(|condition| condition.friction = [0.0; 2]);
    growth(slips.iter().map(|&(j, _)| slopes[j] * normals[j]).collect(), |g| {
        slips.iter().zip(g).for_each(|(&(j, e), g)| at.conditions[j].friction = e.map(|e| g * e));
        // The answer to the bounds of the step before is a good start.
        linear.solve(&mut at);
        let normal = |j: usize| at.force(linear.transformed, linear.transformed.points[j].node)[0];
        slips.iter().map(|&(j, _)| slopes[j] * normal(j)).collect()
    })
}

fn uniqueness_bound(linear: &mut Linear<'_>) -> Option<f64> {
    let transformed = linear.transformed;
    if transformed.relates_points() || !transformed.motions.is_empty() {
        return None;
    }
    let points = &transformed.points;
    let free = ContactCondition { state: PointState::Slip, constraint: NodeConstraint::default(), friction: [0.0; 2] };
    let mut at = linear.at_rest(vec![free; points.len()]);
    let components: Vec<(usize, usize)> =
        (0..points.len()).flat_map(|j| [(j, 1), (j, 2)]).filter(|&(j, c)| points[j].has_row[c]).collect();
    // A force on the body is minus the friction it exerts; the sign does not matter to a square.
    let tangential = |x: &[f64]| {
        components.iter().zip(x).for_each(|(&(j, c), x)| at.conditions[j].friction[c - 1] = *x);
        at.u.iter_mut().chain(&mut at.ku).for_each(|x| *x = [0.0; 3]);
        linear.solve(&mut at);
        components.iter().map(|&(j, c)| -at.u[points[j].node][c]).collect()
    };
    let q = largest_eigenvalue(components.len(), tangential, Threshold::ROUGH, Threshold::TANGENTIAL_LIMIT);
    let mut place = vec![u32::MAX; transformed.f.len()];
    points.iter().enumerate().for_each(|(j, p)| place[p.node] = j as u32);
    let normal = |x: &[f64]| {
        let row = |j: usize| -> f64 {
            let entries = transformed.k.entries_of(points[j].node);
            entries.map(|(i, block)| x.get(place[i as usize] as usize).map_or(0.0, |x| block[0][0] * x)).sum()
        };
        (0..points.len()).map(|j| if points[j].has_row[0] { row(j) } else { 0.0 }).collect()
    };
    let s = largest_eigenvalue(points.len(), normal, Threshold::ROUGH, Threshold::NORMAL_LIMIT);
    bound(&q, &s)
}
