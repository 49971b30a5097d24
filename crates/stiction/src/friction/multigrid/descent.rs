use super::active_set::{ContactCondition, PointLaw, across};
use super::directions::{Vector, dot};
use super::iteration::{Iterate, Observe, State, Subproblem, Survey, judged, residual};
use super::points::Point;
use crate::contact::Friction;
use crate::friction::End;
use crate::friction::PointState;
use crate::linalg::multigrid::{AllRows, Block, Hierarchy, NodeConstraint, inverse};
use crate::ranks::{Halo, from_bytes, gather_all, to_bytes};

/// Cycles of a descent after which it is asked whether there is anything to arrive at. Those of problems whose loads are a
/// little more than friction resists reach a low accuracy earlier, and better bounds follow from them.
const CYCLES_UNASKED: usize = 20;

/// Springs of friction are at most this many times as stiff as the bodies at a point: what coarse levels keep of a spring's rounding once it
/// is gone stays below 1e-9 of them.
const STIFFEST: f64 = 1e6;

/// Minimises the energy of contact with given friction, `1/2 u'Ku - f'u + sum of g |s|` with `u_n <= gap`, by the
/// truncated nonsmooth Newton multigrid method (Graeser & Kornhuber 2009; Graeser & Sander 2019): a nonlinear
/// Gauss-Seidel sweep, one cycle for the components that are neither at their bound nor at a kink, projection, and an
/// exact line search. The energy falls in every step and the sweep alone converges, so the iteration cannot cycle. It has no
/// Krylov directions and takes more cycles than the active-set iteration. The rigid motion of floating bodies is one more
/// direction with an exact line search. Where `is_unbounded` the energy has no least value: it is asked once, of a descent
/// that has not converged in some cycles, which ends as [`End::Stalled`] then.
///
/// Where nodes are divided, ranks sweep one colour after the other, with the values of those before at their ghosts: in some order
/// of all nodes that is the same sweep.
pub(super) fn descend(
    problem: &Subproblem<'_>,
    hierarchy: &mut Hierarchy,
    state: &mut State,
    is_unbounded: &dyn Fn() -> bool,
    observe: &mut Observe<'_>,
) -> End {
    let (k, nodes) = (&problem.transformed.k, problem.transformed.f.len());
    let mut point_of = vec![u32::MAX; nodes];
    problem.points().enumerate().for_each(|(j, (p, _))| point_of[p.node] = j as u32);
    let rows = k.all_rows();
    let inverses: Vec<Block<3, 3>> = (0..nodes).map(|i| inverse(&rows.diagonal(i))).collect();
    let (halo, turns) = (&k.halo, turns(&k.halo));
    make_feasible(problem, &mut state.iterate.u);
    state.restart();
    let asked_at = state.cycles + CYCLES_UNASKED;
    loop {
        state.iterate.ku = k.times(&state.iterate.u);
        state.iterate.conditions = judged(problem, &state.iterate);
        let Survey { violated, states, stops, .. } = state.survey(problem);
        if state.is_stopped(problem, stops, observe(state.cycles, violated, states)) {
            return End::Interrupted;
        }
        match violated {
            _ if violated <= problem.tolerance => return End::Converged,
            _ if !violated.is_finite() => return End::Stalled,
            _ if state.cycles >= problem.max_cycles => return End::Limit,
            _ if state.cycles == asked_at && is_unbounded() => return End::Stalled,
            _ => {}
        }
        if let Some(floating) = problem.floating {
            let mut v = floating.motion(problem, &state.iterate);
            go_along(problem, &mut state.iterate, &mut v);
        }
        for mine in &turns {
            halo.update(&mut state.iterate.u);
            if *mine {
                sweep(problem, &rows, &point_of, &inverses, &mut state.iterate.u);
            }
        }
        state.iterate.u.truncate(nodes);
        state.iterate.ku = k.times(&state.iterate.u);
        let u = &state.iterate.u;
        state.iterate.conditions = problem.points().map(|(p, law)| smooth_part(law, p, u[p.node])).collect();
        let [_, coarse] = state.coarse_levels(problem);
        state.constrain(hierarchy, coarse, true);
        let mut v = hierarchy.cycle(&residual(problem, &state.iterate));
        go_along(problem, &mut state.iterate, &mut v);
        state.cycles += 1;
    }
}

/// Moves to the least energy along `v`, projected on the admissible displacements.
fn go_along(problem: &Subproblem<'_>, at: &mut Iterate, v: &mut Vector) {
    project(problem, &at.u, v);
    let step = line_search(problem, at, v);
    at.u.iter_mut().flatten().zip(v.iter().flatten()).for_each(|(u, v)| *u += step * v);
    // Rounding of u + step v must not leave a bound or a kink that v does not leave.
    make_feasible(problem, &mut at.u);
}

/// For each colour of the ranks whether it is that of this one. Ranks of one colour are not coupled.
fn turns(halo: &Halo) -> Vec<bool> {
    if !halo.is_divided() {
        return vec![true];
    }
    let (receive, send) = halo.neighbours();
    let coupled: Vec<u32> = receive.iter().map(|r| r.0).chain(send.iter().map(|s| s.0)).map(|r| r as u32).collect();
    let lists = gather_all(&**halo.ranks(), to_bytes(&coupled));
    let mut colours: Vec<usize> = Vec::new();
    for list in &lists {
        let before = from_bytes::<u32>(list).into_iter().filter_map(|other| colours.get(other as usize).copied());
        let taken: Vec<usize> = before.collect();
        colours.push((0..).find(|colour| !taken.contains(colour)).unwrap_or(0));
    }
    let count = colours.iter().max().map_or(1, |most| most + 1);
    (0..count).map(|colour| colours[halo.ranks().rank()] == colour).collect()
}

fn is_bonded(law: &PointLaw) -> bool {
    law.friction == Friction::Bonded
}

/// Bonded components take their values, normal displacements are cut at the gap.
fn make_feasible(problem: &Subproblem<'_>, u: &mut Vector) {
    for (p, law) in problem.points() {
        let u = &mut u[p.node];
        for c in (0..3).filter(|&c| p.has_row[c]) {
            if is_bonded(law) {
                u[c] = law.target[c];
            } else if c == 0 {
                u[0] = u[0].min(law.target[0]);
            }
        }
    }
}

/// One nonlinear Gauss-Seidel sweep: each block of components is set to the minimum of the energy over it. The normal
/// component of a point and its tangential ones are blocks of their own, for which the energy's kinks are separable.
/// `u` has the values at ghosts too.
fn sweep(problem: &Subproblem<'_>, rows: &AllRows<'_>, point_of: &[u32], inverses: &[Block<3, 3>], u: &mut Vector) {
    let transformed = problem.transformed;
    for i in 0..inverses.len() {
        let mut r = transformed.f[i];
        for (j, a) in rows.entries_of(i) {
            let x = u[j as usize];
            (0..3).for_each(|c| r[c] -= a[c][0] * x[0] + a[c][1] * x[1] + a[c][2] * x[2]);
        }
        if point_of[i] == u32::MAX {
            (0..3).for_each(|c| u[i][c] += (0..3).map(|s| inverses[i][c][s] * r[s]).sum::<f64>());
            continue;
        }
        let j = point_of[i] as usize;
        let (p, law, d) = (&transformed.points[j], &problem.laws[j], rows.diagonal(i));
        let fixed = [0, 1, 2].map(|c| is_bonded(law) && p.has_row[c]);
        if !fixed[0] && d[0][0] > 0.0 {
            let wanted = u[i][0] + r[0] / d[0][0];
            let new = if p.has_row[0] { wanted.min(law.target[0]) } else { wanted };
            let change = new - std::mem::replace(&mut u[i][0], new);
            (0..3).for_each(|c| r[c] -= d[c][0] * change);
        }
        let slip = [u[i][1] - law.target[1], u[i][2] - law.target[2]];
        let g = if p.has_row[1] || p.has_row[2] { law.friction.bound(0.0) } else { 0.0 };
        let new = match (fixed[1], fixed[2]) {
            (true, true) => slip,
            (true, false) => [slip[0], slip[1] + r[2] / d[2][2]],
            (false, true) => [slip[0] + r[1] / d[1][1], slip[1]],
            (false, false) => tangential(&d, &r, slip, g, [p.has_row[1], p.has_row[2]]),
        };
        u[i][1] = law.target[1] + new[0];
        u[i][2] = law.target[2] + new[1];
    }
}

/// The slip `s` that minimises `1/2 (s - s0)'A(s - s0) - r'(s - s0) + g |s|` over the two tangential components;
/// friction acts on the components with a row of `B`.
fn tangential(d: &Block<3, 3>, r: &[f64; 3], slip: [f64; 2], g: f64, has_row: [bool; 2]) -> [f64; 2] {
    let (a, b, c) = (d[1][1], d[1][2], d[2][2]);
    // Minimum of 1/2 s'As - q's + g |s|.
    let q = [r[1] + a * slip[0] + b * slip[1], r[2] + b * slip[0] + c * slip[1]];
    // (A + t) s = q, where t = g / |s| on the components with friction.
    let at = |t: f64| {
        let (a, c) = (a + if has_row[0] { t } else { 0.0 }, c + if has_row[1] { t } else { 0.0 });
        let determinant = a * c - b * b;
        [(c * q[0] - b * q[1]) / determinant, (a * q[1] - b * q[0]) / determinant]
    };
    let length =
        |s: [f64; 2]| (if has_row[0] { s[0] * s[0] } else { 0.0 } + if has_row[1] { s[1] * s[1] } else { 0.0 }).sqrt();
    if g <= 0.0 {
        return at(0.0);
    }
    match has_row {
        [true, true] if q[0].hypot(q[1]) <= g => return [0.0; 2],
        [true, false] if (q[0] - b / c * q[1]).abs() <= g => return [0.0, q[1] / c],
        [false, true] if (q[1] - b / a * q[0]).abs() <= g => return [q[0] / a, 0.0],
        _ => {}
    }
    // t |s(t)| grows from 0 to the sticking force: bisection on log t between bounds that rounding cannot reach.
    let stiff = a + c;
    let (mut low, mut high) = (1e-16 * stiff, 1e16 * stiff);
    for _ in 0..BISECTIONS {
        let t = (low * high).sqrt();
        if t * length(at(t)) < g { low = t } else { high = t }
    }
    at((low * high).sqrt())
}

/// Halvings that reduce the logarithm of an interval of 32 decades to rounding.
const BISECTIONS: usize = 60;

/// The condition for the smooth part of the energy near `u`: components at a bound or at a kink are constrained.
fn smooth_part(law: &PointLaw, point: &Point, u: [f64; 3]) -> ContactCondition {
    let limit = law.friction.bound(0.0);
    let slip = [1, 2].map(|c| if point.has_row[c] { u[c] - law.target[c] } else { 0.0 });
    let length = slip[0].hypot(slip[1]);
    let at_bound = point.has_row[0] && (is_bonded(law) || u[0] >= law.target[0]);
    let kink = limit > 0.0 && length == 0.0;
    let sticks = kink || is_bonded(law);
    let mut condition = ContactCondition {
        state: if kink { PointState::Stick } else { PointState::Slip },
        constraint: NodeConstraint {
            constrained: [at_bound, sticks && point.has_row[1], sticks && point.has_row[2]],
            ..NodeConstraint::default()
        },
        friction: [0.0; 2],
    };
    if limit > 0.0 && length > 0.0 {
        let d = slip.map(|s| s / length);
        condition.friction = d.map(|d| limit * d);
        if point.has_row[1] && point.has_row[2] {
            condition.constraint.spring = across(d, (limit / length).min(STIFFEST / point.compliance));
        }
    }
    condition
}

/// Cuts the correction where it would leave the admissible displacements.
fn project(problem: &Subproblem<'_>, u: &Vector, v: &mut Vector) {
    for (p, law) in problem.points().filter(|(p, law)| p.has_row[0] && !is_bonded(law)) {
        v[p.node][0] = v[p.node][0].min(law.target[0] - u[p.node][0]);
    }
}

/// The step in `[0, 1]` with the least energy along `v`; the energy is convex there.
fn line_search(problem: &Subproblem<'_>, at: &Iterate, v: &Vector) -> f64 {
    let transformed = problem.transformed;
    let balance: Vector =
        (transformed.f.iter().zip(&at.ku)).map(|(f, k)| std::array::from_fn(|c| f[c] - k[c])).collect();
    let mut products = [dot(&balance, v), dot(v, &transformed.k.times(v))];
    transformed.halo().sum(&mut products);
    let [linear, quadratic] = products;
    let kinks: Vec<(f64, [f64; 2], [f64; 2])> = (problem.points())
        .filter_map(|(p, law)| {
            let g = law.friction.bound(0.0);
            let part = |x: [f64; 2]| [0, 1].map(|c| if p.has_row[c + 1] { x[c] } else { 0.0 });
            let (u, v) = (at.u[p.node], v[p.node]);
            (g > 0.0 && !is_bonded(law))
                .then(|| (g, part([u[1] - law.target[1], u[2] - law.target[2]]), part([v[1], v[2]])))
        })
        .collect();
    let slope = |t: f64| {
        let kink = |(g, s, v): &(f64, [f64; 2], [f64; 2])| {
            let x = [s[0] + t * v[0], s[1] + t * v[1]];
            let length = x[0].hypot(x[1]);
            if length > 0.0 { g * (x[0] * v[0] + x[1] * v[1]) / length } else { g * v[0].hypot(v[1]) }
        };
        let mut of_kinks = [kinks.iter().map(kink).sum::<f64>()];
        transformed.halo().sum(&mut of_kinks);
        t * quadratic - linear + of_kinks[0]
    };
    if slope(1.0) <= 0.0 {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let t = 0.5 * (low + high);
        if slope(t) <= 0.0 { low = t } else { high = t }
    }
    low
}
