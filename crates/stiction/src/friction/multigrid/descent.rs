use super::directions::{Vector, dot};
use super::frames::{Point, Turned};
use super::iteration::{Cycles, End, Observe, State, constrain, judge, residual};
use super::sets::{Law, Set};
use crate::contact::Friction;
use crate::friction::PointState;
use crate::friction::law::bound;
use crate::linalg::multigrid::{Block, Condition, Multigrid, inverse};

/// Minimises the energy of contact with given friction, `1/2 u'Ku - f'u + sum of g |s|` with `u_n <= gap`, by the
/// truncated nonsmooth Newton multigrid method (Graeser & Kornhuber 2009; Graeser & Sander 2019): a nonlinear
/// Gauss-Seidel sweep, one cycle for the components that are neither at their bound nor at a kink, projection, and an
/// exact line search. The energy falls in every step and the sweep alone converges, so the iteration cannot go round
/// in circles; it gives up the Krylov directions and takes more cycles than the sets' own iteration. Bodies that float are
/// moved as a whole first, which is one more direction with an exact line search.
pub(super) fn descend(
    on: &Cycles<'_>,
    laws: &[Law],
    multigrid: &mut Multigrid,
    at: &mut State,
    observe: &mut Observe<'_>,
) -> End {
    let Cycles { turned, tolerance, most, floating } = *on;
    let (k, f, points) = (&turned.k, &turned.f, &turned.points);
    let mut point_of = vec![u32::MAX; f.len()];
    points.iter().enumerate().for_each(|(j, p)| point_of[p.node] = j as u32);
    let inverses: Vec<Block<3, 3>> = (0..f.len()).map(|i| inverse(&k.diagonal(i))).collect();
    make_feasible(points, laws, &mut at.u);
    at.begin_anew();
    loop {
        at.ku = k.times(&at.u);
        let eps = judge(turned, laws, at);
        if observe(at.cycles, eps, &at.sets).is_break() {
            return End::Interrupted;
        }
        match eps {
            eps if eps <= tolerance => return End::Converged,
            eps if !eps.is_finite() => return End::Failed,
            _ if at.cycles >= most => return End::Limit,
            _ => {}
        }
        if let Some(floating) = floating {
            let mut v = floating.motion(turned, laws, at);
            go_along(turned, laws, at, &mut v);
        }
        sweep(turned, laws, &point_of, &inverses, &mut at.u);
        at.ku = k.times(&at.u);
        at.sets = points.iter().zip(laws).map(|(p, law)| smooth_part(law, p, at.u[p.node])).collect();
        constrain(multigrid, laws, at);
        let mut v = multigrid.cycle(&residual(turned, laws, at));
        go_along(turned, laws, at, &mut v);
        at.cycles += 1;
    }
}

/// Moves to the least energy along `v`, cut where it would leave the admissible displacements.
fn go_along(turned: &Turned, laws: &[Law], at: &mut State, v: &mut Vector) {
    let points = &turned.points;
    project(points, laws, &at.u, v);
    let step = line_search(turned, laws, at, v);
    at.u.iter_mut().flatten().zip(v.iter().flatten()).for_each(|(u, v)| *u += step * v);
    // Rounding of u + step v must not leave a bound or a kink that v does not leave.
    make_feasible(points, laws, &mut at.u);
}

fn tied(law: &Law) -> bool {
    law.friction == Friction::Bonded
}

/// Bonded components take their values, normal displacements are cut at the gap.
fn make_feasible(points: &[Point], laws: &[Law], u: &mut Vector) {
    for (p, law) in points.iter().zip(laws) {
        let u = &mut u[p.node];
        for c in (0..3).filter(|&c| p.live[c]) {
            if tied(law) {
                u[c] = law.rest[c];
            } else if c == 0 {
                u[0] = u[0].min(law.rest[0]);
            }
        }
    }
}

/// One nonlinear Gauss-Seidel sweep: each block of components is set to the minimum of the energy over it. The normal
/// component of a point and its tangential ones are blocks of their own, for which the energy's kinks are separable.
fn sweep(turned: &Turned, laws: &[Law], point_of: &[u32], inverses: &[Block<3, 3>], u: &mut Vector) {
    for i in 0..u.len() {
        let mut r = turned.f[i];
        let (columns, blocks) = turned.k.row(i);
        for (&j, a) in columns.iter().zip(blocks) {
            let x = u[j as usize];
            (0..3).for_each(|c| r[c] -= a[c][0] * x[0] + a[c][1] * x[1] + a[c][2] * x[2]);
        }
        if point_of[i] == u32::MAX {
            (0..3).for_each(|c| u[i][c] += (0..3).map(|s| inverses[i][c][s] * r[s]).sum::<f64>());
            continue;
        }
        let j = point_of[i] as usize;
        let (p, law, d) = (&turned.points[j], &laws[j], turned.k.diagonal(i));
        let fixed = [0, 1, 2].map(|c| tied(law) && p.live[c]);
        if !fixed[0] && d[0][0] > 0.0 {
            let wanted = u[i][0] + r[0] / d[0][0];
            let new = if p.live[0] { wanted.min(law.rest[0]) } else { wanted };
            let change = new - std::mem::replace(&mut u[i][0], new);
            (0..3).for_each(|c| r[c] -= d[c][0] * change);
        }
        let slip = [u[i][1] - law.rest[1], u[i][2] - law.rest[2]];
        let g = if p.live[1] || p.live[2] { bound(law.friction, 0.0) } else { 0.0 };
        let new = match (fixed[1], fixed[2]) {
            (true, true) => slip,
            (true, false) => [slip[0], slip[1] + r[2] / d[2][2]],
            (false, true) => [slip[0] + r[1] / d[1][1], slip[1]],
            (false, false) => tangential(&d, &r, slip, g, [p.live[1], p.live[2]]),
        };
        u[i][1] = law.rest[1] + new[0];
        u[i][2] = law.rest[2] + new[1];
    }
}

/// The slip `s` that minimises `1/2 (s - s0)'A(s - s0) - r'(s - s0) + g |s|` over the two tangential components;
/// friction acts on the live ones.
fn tangential(d: &Block<3, 3>, r: &[f64; 3], slip: [f64; 2], g: f64, live: [bool; 2]) -> [f64; 2] {
    let (a, b, c) = (d[1][1], d[1][2], d[2][2]);
    // Minimum of 1/2 s'As - q's + g |s|.
    let q = [r[1] + a * slip[0] + b * slip[1], r[2] + b * slip[0] + c * slip[1]];
    // (A + t) s = q, where t = g / |s| on the live components.
    let at = |t: f64| {
        let (a, c) = (a + if live[0] { t } else { 0.0 }, c + if live[1] { t } else { 0.0 });
        let determinant = a * c - b * b;
        [(c * q[0] - b * q[1]) / determinant, (a * q[1] - b * q[0]) / determinant]
    };
    let length =
        |s: [f64; 2]| (if live[0] { s[0] * s[0] } else { 0.0 } + if live[1] { s[1] * s[1] } else { 0.0 }).sqrt();
    if g <= 0.0 {
        return at(0.0);
    }
    match live {
        [true, true] if q[0].hypot(q[1]) <= g => return [0.0; 2],
        [true, false] if (q[0] - b / c * q[1]).abs() <= g => return [0.0, q[1] / c],
        [false, true] if (q[1] - b / a * q[0]).abs() <= g => return [q[0] / a, 0.0],
        _ => {}
    }
    // t |s(t)| grows from 0 to the force that does not slip: bisection on log t between what it can be at all.
    let stiff = a + c;
    let (mut low, mut high) = (1e-16 * stiff, 1e16 * stiff);
    for _ in 0..BISECTIONS {
        let t = (low * high).sqrt();
        if t * length(at(t)) < g { low = t } else { high = t }
    }
    at((low * high).sqrt())
}

/// Halvings of the logarithm of an interval of 32 decades down to rounding.
const BISECTIONS: usize = 60;

/// What the energy's smooth part near `u` is: components at a bound or at a kink are held.
fn smooth_part(law: &Law, point: &Point, u: [f64; 3]) -> Set {
    let limit = bound(law.friction, 0.0);
    let slip = [1, 2].map(|c| if point.live[c] { u[c] - law.rest[c] } else { 0.0 });
    let length = slip[0].hypot(slip[1]);
    let at_bound = point.live[0] && (tied(law) || u[0] >= law.rest[0]);
    let kink = limit > 0.0 && length == 0.0;
    let held = [at_bound, (kink || tied(law)) && point.live[1], (kink || tied(law)) && point.live[2]];
    let mut set = Set {
        state: if kink { PointState::Stick } else { PointState::Slip },
        condition: Condition { held, spring: [[0.0; 3]; 3], follows: [0.0; 2] },
        friction: [0.0; 2],
    };
    if limit > 0.0 && length > 0.0 {
        let d = slip.map(|s| s / length);
        set.friction = d.map(|d| limit * d);
        let across = [-d[1], d[0]];
        if point.live[1] && point.live[2] {
            for r in 0..2 {
                for s in 0..2 {
                    set.condition.spring[r + 1][s + 1] = limit / length * across[r] * across[s];
                }
            }
        }
    }
    set
}

/// Cuts the correction where it would leave the admissible displacements.
fn project(points: &[Point], laws: &[Law], u: &Vector, v: &mut Vector) {
    for (p, law) in points.iter().zip(laws).filter(|(p, law)| p.live[0] && !tied(law)) {
        v[p.node][0] = v[p.node][0].min(law.rest[0] - u[p.node][0]);
    }
}

/// The step in `[0, 1]` with the least energy along `v`; the energy is convex there.
fn line_search(turned: &Turned, laws: &[Law], at: &State, v: &Vector) -> f64 {
    let balance: Vector = (turned.f.iter().zip(&at.ku)).map(|(f, k)| std::array::from_fn(|c| f[c] - k[c])).collect();
    let (linear, quadratic) = (dot(&balance, v), dot(v, &turned.k.times(v)));
    let kinks: Vec<(f64, [f64; 2], [f64; 2])> = (turned.points.iter().zip(laws))
        .filter_map(|(p, law)| {
            let g = bound(law.friction, 0.0);
            let part = |x: [f64; 2]| [0, 1].map(|c| if p.live[c + 1] { x[c] } else { 0.0 });
            let (u, v) = (at.u[p.node], v[p.node]);
            (g > 0.0 && !tied(law)).then(|| (g, part([u[1] - law.rest[1], u[2] - law.rest[2]]), part([v[1], v[2]])))
        })
        .collect();
    let slope = |t: f64| {
        let kink = |(g, s, v): &(f64, [f64; 2], [f64; 2])| {
            let x = [s[0] + t * v[0], s[1] + t * v[1]];
            let length = x[0].hypot(x[1]);
            if length > 0.0 { g * (x[0] * v[0] + x[1] * v[1]) / length } else { g * v[0].hypot(v[1]) }
        };
        t * quadratic - linear + kinks.iter().map(kink).sum::<f64>()
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
