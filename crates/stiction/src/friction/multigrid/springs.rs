//! Contact by springs, which finds active sets where the active-set iteration cycles.

use super::active_set::{ContactCondition, PointLaw, across};
use super::directions::{Direction, MOST_DIRECTIONS, dot, minimise};
use super::equations::Projection;
use super::iteration::{Iterate, Observe, State, Subproblem, Survey, judge, load_squares, residual, run};
use super::points::Point;
use super::step_length::least_along;
use super::transform::Transformed;
use crate::contact::Friction;
use crate::friction::{End, PointState};
use crate::linalg::multigrid::{CoarseLevels, Hierarchy, NodeConstraint};

/// Thresholds of [`by_springs`].
struct Threshold;

impl Threshold {
    /// Stiffness of the springs over the parameter of the law. 24 plates of 4 900 to 25 000 unknowns, 1:50, that bend onto a plane take 1 788
    /// cycles with 0.1 and 1 779 with 0.3 where springs settle at 0.03.
    const STIFFNESS: f64 = 0.1;
    /// Residual over the load at which the springs have found their sets. With 0.03 the plates take 1 788 cycles, with 0.1 1 677; 0.2 is too
    /// much for some (246 and 258 cycles instead of 77).
    const SETTLED: f64 = 0.1;
    /// Cycles for the springs; the plates take 15 to 30.
    const CYCLES: usize = 120;
    /// Violation of the law, over the load, from which the active-set iteration goes on. With 0.3 the plates take as many cycles.
    const NEAR: f64 = 0.1;
    /// Violation of the law over that before the forces were taken up, above which that does not help any more. With 0.2 and
    /// 0.8 the plates take 0.6 % more cycles.
    const FALLS: f64 = 0.5;
    /// Slope of the energy at the ends of the interval of a step over that where the step begins.
    const SLOPE: f64 = 1e-6;
}

/// The active-set iteration from the solution with springs in place of contact.
///
/// A plate that bends lies on its obstacle with a few points, while the law at a first iterate closes hundreds, of which the
/// active sets then release one row of nodes a step. With springs the energy is smooth and convex, and a step is as long as
/// makes it least, so that the sets cannot cycle: from the open side two to five Newton steps find them, where the active-set
/// iteration with exact linear solves takes thirty. The friction of a step is bounded by the springs' forces before it.
///
/// The overlap of the springs times the parameter of the law is ten times their force. Taken from there at once, normal forces swing and
/// sweep points along by their friction: 11 of 72 plates with friction of 0.3 and 0.8 are not solved in 1 000 cycles, 8 take more
/// than 200. So the springs keep their forces and are measured anew from where they give these without overlap (the method of
/// multipliers; Hestenes 1969, Powell 1969), until the law is nearly met: a plate that bends under forces which hardly change
/// follows at once, and one round leaves a tenth of the overlap. Nothing of the springs is left in the answer: from their
/// displacements the active-set iteration solves the law itself.
pub(super) fn by_springs(
    problem: &Subproblem<'_>,
    hierarchy: &mut Hierarchy,
    state: &mut State,
    observe: &mut Observe<'_>,
) -> End {
    let max_cycles = problem.max_cycles.min(state.cycles + Threshold::CYCLES);
    let mut laws = problem.laws.to_vec();
    let mut last = f64::INFINITY;
    loop {
        let springs = Subproblem { laws: &laws, max_cycles, ..*problem };
        if let Some(end) = settle(&springs, hierarchy, state, observe) {
            return end;
        }
        let left = judge(problem, &mut state.iterate);
        if left <= Threshold::NEAR || left > Threshold::FALLS * last {
            break;
        }
        last = left;
        for (law, (p, given)) in laws.iter_mut().zip(problem.points()) {
            take_up(law, p, state.iterate.u[p.node], given.target);
        }
    }
    state.restart();
    run(problem, hierarchy, state, observe)
}

/// Minimises the energy with springs; `None` when their sets are found.
fn settle(
    problem: &Subproblem<'_>,
    hierarchy: &mut Hierarchy,
    state: &mut State,
    observe: &mut Observe<'_>,
) -> Option<End> {
    state.restart();
    let mut directions: Vec<Direction> = Vec::new();
    loop {
        let at = &mut state.iterate;
        at.conditions =
            problem.points().map(|(p, law)| spring_condition(law, p, at.u[p.node], stiffness(law))).collect();
        state.apply_targets(problem);
        if let Some(equations) = problem.equations {
            equations.balance(problem, &Projection::default(), &mut state.iterate);
        }
        let r = residual(problem, &state.iterate);
        let [load, contact] = load_squares(problem, &state.iterate);
        let Survey { violated, states, stops, .. } = state.survey_with(problem, [dot(&r, &r), load, contact]);
        if state.is_stopped(problem, stops, observe(state.cycles, violated, states)) {
            return Some(End::Interrupted);
        }
        if violated <= Threshold::SETTLED {
            return None;
        }
        if state.cycles >= problem.max_cycles || !violated.is_finite() {
            return Some(End::Stalled);
        }
        let constraints: Vec<NodeConstraint> = state.iterate.conditions.iter().map(|c| c.constraint).collect();
        // Springs are soft beside the parameter of the law, by which `constrain` decides whether coarse levels change.
        hierarchy.constrain(&constraints, CoarseLevels::Change, true);
        let mut p = hierarchy.cycle(&r);
        if let Some(equations) = problem.equations {
            equations.project(problem.transformed.halo(), &Projection::default(), &mut p);
        }
        let kp = problem.transformed.k.times(&p);
        directions.insert(0, Direction { p, kp, shortening: Vec::new() });
        let Transformed { points, .. } = problem.transformed;
        minimise(problem.transformed.halo(), &mut directions, &r, points, None, &mut state.iterate);
        lengthen(problem, &directions[0], &mut state.iterate);
        directions.truncate(MOST_DIRECTIONS - 1);
        state.cycles += 1;
    }
}

/// Moves what the spring of a point is measured from, `target` without force, so that its force stays where the overlap and the slip
/// that it needs now vanish.
fn take_up(law: &mut PointLaw, point: &Point, u: [f64; 3], target: [f64; 3]) {
    if law.friction == Friction::Bonded {
        return;
    }
    let spring = stiffness(law);
    let [normal, ..] = spring_force(law, point, u, spring, 0.0);
    let force = spring_force(law, point, u, spring, law.friction.bound(normal));
    law.target = std::array::from_fn(|c| target[c] - force[c] / spring);
}

/// Moves the iterate, which has gone along `step`, to the least energy along it. The bounds of friction are those where the
/// step began.
fn lengthen(problem: &Subproblem<'_>, step: &Direction, at: &mut Iterate) {
    let f = &problem.transformed.f;
    let curvature = dot(&step.p, &step.kp);
    let elastic = dot(&step.p, &at.ku) - dot(&step.p, f);
    let points: Vec<_> = (problem.points())
        .filter(|(_, law)| law.friction != Friction::Bonded)
        .map(|(p, law)| {
            let (u, d) = (at.u[p.node], step.p[p.node]);
            let began: [f64; 3] = std::array::from_fn(|c| u[c] - d[c]);
            let normal = spring_force(law, p, began, stiffness(law), 0.0)[0];
            (p, law, law.friction.bound(normal), u, d)
        })
        .collect();
    // Of the energy along the step, at `t` times the step from where it began.
    let slope = |t: f64| {
        let of_point = |&(p, law, bound, u, d): &(&Point, &PointLaw, f64, [f64; 3], [f64; 3])| {
            let force = spring_force(law, p, std::array::from_fn(|c| u[c] + (t - 1.0) * d[c]), stiffness(law), bound);
            (0..3).map(|c| force[c] * d[c]).sum::<f64>()
        };
        elastic + (t - 1.0) * curvature + points.iter().map(of_point).sum::<f64>()
    };
    let change = least_along(problem.transformed.halo(), slope, Threshold::SLOPE) - 1.0;
    let pairs = at.u.iter_mut().flatten().zip(step.p.iter().flatten());
    pairs.for_each(|(u, p)| *u += change * p);
    let pairs = at.ku.iter_mut().flatten().zip(step.kp.iter().flatten());
    pairs.for_each(|(ku, kp)| *ku += change * kp);
}

/// The stiffness of the spring of a point, force per length.
fn stiffness(law: &PointLaw) -> f64 {
    Threshold::STIFFNESS * law.parameter
}

/// The contact condition of a point on a spring of this stiffness: what its spring adds to the stiffness, and the friction of
/// a slipping point.
pub(super) fn spring_condition(law: &PointLaw, point: &Point, u: [f64; 3], spring: f64) -> ContactCondition {
    if law.friction == Friction::Bonded {
        let constraint = NodeConstraint { constrained: point.has_row, ..NodeConstraint::default() };
        return ContactCondition { state: PointState::Stick, constraint, friction: [0.0; 2] };
    }
    let (overlap, slip) = moved(law, point, u);
    let bound = law.friction.bound(spring * overlap);
    let length = slip[0].hypot(slip[1]);
    let slips = spring * length > bound;
    let mut condition = ContactCondition {
        state: match (overlap > 0.0 || bound > 0.0, slips || bound == 0.0) {
            (false, _) => PointState::Open,
            (true, false) => PointState::Stick,
            (true, true) => PointState::Slip,
        },
        constraint: NodeConstraint::default(),
        friction: [0.0; 2],
    };
    let constraint = &mut condition.constraint;
    if slips && bound > 0.0 {
        let d = slip.map(|s| s / length);
        condition.friction = d.map(|d| bound * d);
        if point.has_row[1] && point.has_row[2] {
            constraint.spring = across(d, bound / length);
        }
    } else if bound > 0.0 {
        (1..3).filter(|&c| point.has_row[c]).for_each(|c| constraint.spring[c][c] = spring);
    }
    if overlap > 0.0 {
        constraint.spring[0][0] = spring;
    }
    condition
}

/// How far a point has gone beyond its gap, and its slip; length.
fn moved(law: &PointLaw, point: &Point, u: [f64; 3]) -> (f64, [f64; 2]) {
    let [normal, slip @ ..] = [0, 1, 2].map(|c| if point.has_row[c] { u[c] - law.target[c] } else { 0.0 });
    (normal.max(0.0), slip)
}

/// The force of a spring of this stiffness on the counterpart, friction up to `bound`; newton.
pub(super) fn spring_force(law: &PointLaw, point: &Point, u: [f64; 3], spring: f64, bound: f64) -> [f64; 3] {
    let (overlap, slip) = moved(law, point, u);
    let length = slip[0].hypot(slip[1]);
    let tangential = if spring * length > bound { bound / length } else { spring };
    [spring * overlap, tangential * slip[0], tangential * slip[1]]
}
