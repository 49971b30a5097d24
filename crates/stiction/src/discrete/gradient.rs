use super::V3;
use super::blocks::length;
use super::course::Course;
use super::law::project;
use super::settings::Status;
use super::system::System;

/// Steps between two judgements.
pub const ROUND: usize = 10;
/// Most steps at one value of the term of De Saxcé.
const INNER: usize = 50;
/// The inner residual over the one at the begin of the inner iteration.
const REDUCTION: f64 = 0.1;
/// The step grows by this factor after each that was short enough.
const GROWTH: f64 = 1.1;
const SHORTER: f64 = 0.5;
const SHORTEST: f64 = 1e-12;
/// Where `W` has no curvature, steps grow no further: without a solution impulses would otherwise run away.
const LONGEST: f64 = 100.0;

/// Fixed point on the term `mu |u_t|` of De Saxcé (Acary, Cadoux, Lemaréchal & Malick 2011): at a fixed one the problem
/// is a quadratic program over the cones, which accelerated projected gradients solve.
pub fn fixed_point(system: &dyn System, mut r: Vec<V3>, course: &mut Course) -> Status {
    let mut step = 1.0;
    loop {
        if let Some(status) = course.ends(&r, step) {
            return status;
        }
        course.counts.gradients += gradients(system, &mut r, &mut step, ROUND);
        course.counts.iterations += 1;
    }
}

/// At least `steps` steps of [`fixed_point`]; how many were made.
pub fn gradients(system: &dyn System, r: &mut Vec<V3>, step: &mut f64, steps: usize) -> usize {
    let mut made = 0;
    while made < steps {
        made += inner(system, r, step);
    }
    made
}

/// `mu |u_t|` at every point.
pub fn de_saxce(mu: &[f64], u: &[V3]) -> Vec<f64> {
    mu.iter().zip(u).map(|(mu, u)| mu * u[1].hypot(u[2])).collect()
}

/// Accelerated projected gradients (Nesterov 1983; for contact Mazhar, Heyn, Negrut & Tasora 2015) on
/// `1/2 r' W r + (q + s)' r` over the cones, with a line search on the step and the restart of O'Donoghue & Candès
/// (2015); the steps made.
fn inner(system: &dyn System, r: &mut Vec<V3>, step: &mut f64) -> usize {
    let mu = system.mu();
    let mut u = system.velocity(r);
    let shift = de_saxce(mu, &u);
    let projected = |y: &[V3], u: &[V3], step: f64| -> Vec<V3> {
        let forward =
            |a: usize| std::array::from_fn(|i| y[a][i] - step * (u[a][i] + if i == 0 { shift[a] } else { 0.0 }));
        (0..y.len()).map(|a| project(mu[a], forward(a))).collect()
    };
    let (mut y, mut u_y, mut theta) = (r.clone(), u.clone(), 1.0f64);
    let mut first = None;
    for made in 1..=INNER {
        let (mut next, mut u_next);
        loop {
            next = projected(&y, &u_y, *step);
            u_next = system.velocity(&next);
            let (moved, bent) = (minus(&next, &y), minus(&u_next, &u_y));
            let short = inner_product(&moved, &bent) * *step <= inner_product(&moved, &moved);
            if short || *step < SHORTEST {
                break;
            }
            *step *= SHORTER;
        }
        let change = length(&minus(&next, &y)) / *step;
        let back = inner_product(&minus(&y, &next), &minus(&next, r)) > 0.0;
        if back {
            theta = 1.0;
        }
        let larger = 0.5 * (1.0 + (1.0 + 4.0 * theta * theta).sqrt());
        let momentum = if back { 0.0 } else { (theta - 1.0) / larger };
        theta = larger;
        y = extrapolated(&next, r, momentum);
        u_y = extrapolated(&u_next, &u, momentum);
        (*r, u) = (next, u_next);
        *step = (*step * GROWTH).min(LONGEST);
        let start = *first.get_or_insert(change);
        if change <= REDUCTION * start && made > 1 || change == 0.0 {
            return made;
        }
    }
    INNER
}

fn minus(x: &[V3], y: &[V3]) -> Vec<V3> {
    x.iter().zip(y).map(|(x, y)| std::array::from_fn(|i| x[i] - y[i])).collect()
}

/// `x + momentum (x - before)`.
fn extrapolated(x: &[V3], before: &[V3], momentum: f64) -> Vec<V3> {
    x.iter().zip(before).map(|(x, b)| std::array::from_fn(|i| x[i] + momentum * (x[i] - b[i]))).collect()
}

fn inner_product(x: &[V3], y: &[V3]) -> f64 {
    crate::linalg::dot(x.as_flattened(), y.as_flattened())
}
