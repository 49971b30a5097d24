use super::V3;
use super::monitor::Monitor;
use super::settings::Status;
use super::system::Discrete;
use crate::friction::law::nearest_in_cone;
use crate::friction::system::{Descent, accelerated_gradients};
use crate::linalg::Stop;

/// Steps between two judgements.
pub(super) const ROUND: usize = 10;
/// Most steps at one value of the term of De Saxcé.
const INNER: usize = 50;
/// The inner residual over the one at the begin of the inner iteration.
const REDUCTION: f64 = 0.1;
/// Fixed point on the term `mu |u_t|` of De Saxcé (Acary, Cadoux, Lemaréchal & Malick 2011): at a fixed one the problem
/// is a quadratic program over the cones, which accelerated projected gradients solve.
pub(super) fn fixed_point(system: &Discrete<'_>, mut r: Vec<V3>, monitor: &mut Monitor) -> Status {
    let mut step = 1.0;
    loop {
        if let Some(status) = monitor.ends(&r, step) {
            return status;
        }
        monitor.counts.gradients += gradients(system, &mut r, &mut step, ROUND);
        monitor.counts.iterations += 1;
    }
}

/// At least `steps` steps of [`fixed_point`]; how many were made.
pub(super) fn gradients(system: &Discrete<'_>, r: &mut Vec<V3>, step: &mut f64, steps: usize) -> usize {
    let mut made = 0;
    while made < steps {
        made += inner(system, r, step);
    }
    made
}

/// `mu |u_t|` at every point.
pub(super) fn de_saxce(mu: &[f64], u: &[V3]) -> Vec<f64> {
    mu.iter().zip(u).map(|(mu, u)| mu * u[1].hypot(u[2])).collect()
}

/// At a fixed term of De Saxcé: `min 1/2 r' W r + (q + s)' r` over the cones; the steps made.
fn inner(system: &Discrete<'_>, r: &mut Vec<V3>, step: &mut f64) -> usize {
    let mu = system.mu;
    let shift = de_saxce(mu, &system.velocity(r));
    let v = |r: &[V3]| {
        let mut u = system.velocity(r);
        u.iter_mut().zip(&shift).for_each(|(u, s)| u[0] += s);
        u
    };
    let nearest = |a: usize, x: V3| nearest_in_cone(mu[a], x);
    let (weight, stop) = (vec![1.0; mu.len()], Stop::never());
    let on = Descent { v: &v, nearest: &nearest, weight: &weight, reduction: REDUCTION, stop: &stop };
    let mut u = v(r);
    accelerated_gradients(&on, r, &mut u, step, INNER)
}
