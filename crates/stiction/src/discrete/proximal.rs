use super::V3;
use super::admm::{Alternating, PENALTY};
use super::course::Course;
use super::gradient::gradients;
use super::law::residual_norm;
use super::newton::Regular;
use super::settings::Status;
use super::system::System;

/// First proximal parameter over the local flexibility (the scaled diagonal blocks have the trace 3).
const FIRST: f64 = 0.1;
const LARGEST: f64 = 10.0;
/// After a success the parameter falls by this factor, after a failure it grows by it.
const FACTOR: f64 = 10.0;
/// Below this the Newton systems lose more digits than the proximal term costs steps.
const SMALLEST: f64 = 1e-9;
/// The residual of an inner problem over that of the problem itself, and over the proximal parameter.
const INNER: f64 = 0.1;
/// A failed inner solve is kept if it lowered the residual of the problem itself to this part.
const KEPT: f64 = 0.9;
/// Inner problems are not solved below this residual, scaled: rounding.
const ROUNDING: f64 = 1e-15;
/// Successes at one parameter before it falls: doubled by each failure up to this, since a parameter that has just been
/// too small is rarely right one step later.
const MOST_PATIENCE: usize = 16;
/// If the best residual has not halved in so many proximal steps, another start is chosen.
const STALL: usize = 30;
/// Steps of the rung at the first stall; twice as many at each further one, at most 256 times.
const STEPS: usize = 25;
const DOUBLINGS: usize = 8;

/// Gradient steps before the first proximal step: each costs one product with `W`, and they halve the Newton steps of
/// problems that lie open.
const FIRST_STEPS: usize = 10;

/// The proximal point algorithm (Rockafellar 1976; on frictional contact Siconos' `fc3d_proximal`) around a semismooth
/// Newton method: `W + alpha` and `q - alpha r_k`. The parameter falls tenfold as long as Newton's method converges and
/// rises where it does not.
///
/// With a `ladder`, gradients choose the first start where none was given, and sweeps, gradients and alternating
/// directions in turn another one where the residual no longer falls.
pub fn proximal(system: &dyn System, mut r: Vec<V3>, ladder: bool, course: &mut Course) -> Status {
    let mu = system.mu();
    if ladder && course.settings.start.is_none() {
        course.counts.gradients += gradients(system, &mut r, &mut 1.0, FIRST_STEPS);
    }
    let mut alpha = FIRST;
    let (mut patience, mut successes, mut stalls) = (1, 0, 0);
    // Best residual and step at which it was last halved.
    let mut mark = (f64::INFINITY, 0);
    loop {
        if let Some(status) = course.ends(&r, alpha) {
            return status;
        }
        let own = residual_norm(mu, &r, &system.velocity(&r));
        let target = (INNER * own.min(alpha)).max(ROUNDING);
        let end = Regular { system, alpha, centre: &r }.newton(r.clone(), target);
        course.counts.iterations += 1;
        course.counts.newton_steps += end.steps;
        if end.converged {
            r = end.r;
            successes += 1;
            if successes >= patience {
                (alpha, successes) = ((alpha / FACTOR).max(SMALLEST), 0);
            }
        } else {
            if residual_norm(mu, &end.r, &system.velocity(&end.r)) < KEPT * own {
                r = end.r;
            }
            (alpha, successes, patience) = (alpha * FACTOR, 0, (2 * patience).min(MOST_PATIENCE));
        }
        let (residual, step) = (course.residual(), course.counts.iterations);
        if residual < 0.5 * mark.0 {
            mark = (residual, step);
        }
        if alpha > LARGEST || step > mark.1 + STALL {
            if ladder {
                another_start(system, &mut r, stalls, course);
            }
            (alpha, successes, patience, stalls) = (FIRST, 0, 1, stalls + 1);
            mark = (f64::INFINITY, step);
        }
    }
}

/// The rung after so many stalls.
fn another_start(system: &dyn System, r: &mut Vec<V3>, stalls: usize, course: &mut Course) {
    let steps = STEPS << stalls.min(DOUBLINGS);
    match stalls % 3 {
        0 if system.sweep(r, steps) => course.counts.sweeps += steps,
        0 | 1 => course.counts.gradients += gradients(system, r, &mut 1.0, steps),
        _ => {
            if let Some(mut directions) = Alternating::new(system, r, PENALTY) {
                (0..steps).for_each(|_| directions.step());
                *r = directions.z;
                course.counts.alternations += steps;
            }
        }
    }
}
