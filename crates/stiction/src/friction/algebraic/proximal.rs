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
/// Sweeps at the first stall; twice as many at each further one, up to [`MOST_SWEEPS`].
const SWEEPS: usize = 25;
const MOST_SWEEPS: usize = 400;

/// What chooses another start for Newton's method where the residual no longer falls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Restart {
    /// Nothing: the proximal parameter is set back.
    None,
    /// Sweeps where `W` is stored, otherwise alternating directions.
    Sweeps,
    Gradients,
    Alternations,
}

/// The proximal point algorithm (Rockafellar 1976; on frictional contact Siconos' `fc3d_proximal`) around a semismooth
/// Newton method: `W + alpha` and `q - alpha r_k`. The parameter falls tenfold as long as Newton's method converges and
/// rises where it does not; where the residual no longer falls, `restart` chooses another start.
pub fn proximal(system: &dyn System, mut r: Vec<V3>, restart: Restart, course: &mut Course) -> Status {
    let mu = system.mu();
    let mut alpha = FIRST;
    let (mut patience, mut successes, mut sweeps) = (1, 0, SWEEPS);
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
            another_start(system, &mut r, restart, sweeps, course);
            (alpha, successes, patience, sweeps) = (FIRST, 0, 1, (2 * sweeps).min(MOST_SWEEPS));
            mark = (f64::INFINITY, step);
        }
    }
}

fn another_start(system: &dyn System, r: &mut Vec<V3>, restart: Restart, steps: usize, course: &mut Course) {
    match restart {
        Restart::None => {}
        Restart::Sweeps if system.sweep(r, steps) => course.counts.sweeps += steps,
        Restart::Sweeps | Restart::Alternations => {
            if let Some(mut directions) = Alternating::new(system, r, PENALTY) {
                (0..steps).for_each(|_| directions.step());
                *r = directions.z;
                course.counts.alternations += steps;
            }
        }
        Restart::Gradients => course.counts.gradients += gradients(system, r, &mut 1.0, steps),
    }
}
