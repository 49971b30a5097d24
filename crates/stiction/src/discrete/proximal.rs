use std::ops::ControlFlow;

use super::V3;
use super::gradient::gradients;
use super::monitor::Monitor;
use super::settings::Status;
use super::sweeps::sweep;
use super::system::Discrete;
use crate::contact::Friction;
use crate::friction::system::{Iterate, Newton, ProximalTerm, Rules, newton};

/// Thresholds of Newton's method on a regularised problem.
const RULES: Rules = Rules {
    patience: usize::MAX,
    shortest: 1.0 / 128.0,
    leaps: 3,
    largest_slope: f64::INFINITY,
    // Factors are exact.
    accuracy: 0.0,
};
/// Thresholds of [`proximal`]. Together they solve the 18 files of FCLib at 1e-8 and all of 108 random piles, these in 31 447
/// Newton steps; with alternating directions as a third fallback it is 37 137. Lowering the parameter as soon as the residual
/// rises, or fallbacks from the best impulses, solved 51 of 54 piles instead of 53.
struct Threshold;

impl Threshold {
    /// Newton steps on one regularised problem.
    const MAX_STEPS: usize = 30;
    /// First proximal parameter over the local compliance (the scaled diagonal blocks have the trace 3).
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
    /// Steps of the fallback at the first stall; twice as many at each further one, at most 256 times.
    const STEPS: usize = 25;
    const DOUBLINGS: usize = 8;
    /// Stalls before starts are scattered. Of singular problems of two points, drawn as in `agreement::discrete`, one in a
    /// hundred thousand is not solved; one in ten thousand without scattered starts, and one in sixteen thousand with
    /// alternating directions as a third fallback instead.
    const LATE: usize = 4;
    /// Gradient steps before the first proximal step: each costs one product with `W`, and they halve the Newton steps of
    /// problems that lie open.
    const FIRST_STEPS: usize = 10;
}

/// The proximal point algorithm (Rockafellar 1976; on frictional contact Siconos' `fc3d_proximal`) around a semismooth
/// Newton method: `W + alpha` and `q - alpha r_k`. The parameter falls tenfold as long as Newton's method converges and
/// rises where it does not.
///
/// With `fallbacks`, gradients choose the first start where none was given, and sweeps and gradients in turn another one
/// where the residual no longer falls.
pub(super) fn proximal(system: &Discrete<'_>, mut r: Vec<V3>, fallbacks: bool, monitor: &mut Monitor) -> Status {
    let laws: Vec<Friction> = system.mu.iter().map(|&coefficient| Friction::Coulomb { coefficient }).collect();
    let ones = vec![1.0; laws.len()];
    let plain = Newton {
        system,
        friction: &laws,
        r: &ones,
        weight: &ones,
        proximal: None,
        tolerance: 0.0,
        absolute: 0.0,
        rules: RULES,
    };
    if fallbacks && monitor.settings.start.is_none() {
        monitor.counts.gradients += gradients(system, &mut r, &mut 1.0, Threshold::FIRST_STEPS);
    }
    let mut at = Iterate { v: system.velocity(&r), lambda: r, alpha: Vec::new() };
    let mut alpha = Threshold::FIRST;
    let (mut patience, mut successes, mut stalls) = (1, 0, 0);
    // Best residual and step at which it was last halved.
    let mut mark = (f64::INFINITY, 0);
    loop {
        if let Some(status) = monitor.ends(&at.lambda, alpha) {
            return status;
        }
        let own = plain.merit(&at);
        let target = (Threshold::INNER * own.min(alpha)).max(Threshold::ROUNDING);
        let (centre, compliance) = (at.lambda.clone(), vec![alpha; laws.len()]);
        let term = ProximalTerm { centre: &centre, compliance: &compliance };
        let regular = Newton { proximal: Some(term), absolute: target, ..plain };
        let (mut next, mut best, mut steps) = (at.clone(), (f64::INFINITY, at.clone()), Threshold::MAX_STEPS);
        newton(&regular, &mut next, &mut steps, &mut |next, residual, _, _| {
            if residual < best.0 {
                best = (residual, next.clone());
            }
            ControlFlow::Continue(())
        });
        monitor.counts.iterations += 1;
        monitor.counts.newton_steps += Threshold::MAX_STEPS - steps;
        if best.0 <= target {
            at = best.1;
            successes += 1;
            if successes >= patience {
                (alpha, successes) = ((alpha / Threshold::FACTOR).max(Threshold::SMALLEST), 0);
            }
        } else {
            if plain.merit(&best.1) < Threshold::KEPT * own {
                at = best.1;
            }
            (alpha, successes, patience) = (alpha * Threshold::FACTOR, 0, (2 * patience).min(Threshold::MOST_PATIENCE));
        }
        let (residual, step) = (monitor.residual(), monitor.counts.iterations);
        if residual < 0.5 * mark.0 {
            mark = (residual, step);
        }
        if alpha > Threshold::LARGEST || step > mark.1 + Threshold::STALL {
            if fallbacks {
                another_start(system, &mut at.lambda, stalls, monitor);
                at.v = system.velocity(&at.lambda);
            }
            (alpha, successes, patience, stalls) = (Threshold::FIRST, 0, 1, stalls + 1);
            mark = (f64::INFINITY, step);
        }
    }
}

/// Moves the iteration to another start after so many stalls: by sweeps, the cheapest where `W` is stored, and by gradients
/// in turn, with `STEPS` steps that double from stall to stall. Where these have been tried twice, from scattered impulses:
/// all starts before lead to where the iteration circles.
fn another_start(system: &Discrete<'_>, r: &mut Vec<V3>, stalls: usize, monitor: &mut Monitor) {
    if stalls >= Threshold::LATE {
        scatter(system, r, stalls);
    }
    let steps = Threshold::STEPS << stalls.min(Threshold::DOUBLINGS);
    if stalls.is_multiple_of(2) && sweep(system, r, steps) {
        monitor.counts.sweeps += steps;
    } else {
        monitor.counts.gradients += gradients(system, r, &mut 1.0, steps);
    }
}

/// Impulses in the cones, as large as the largest, without order: the same for the same number.
fn scatter(system: &Discrete<'_>, r: &mut [V3], number: usize) {
    let largest = r.iter().flatten().fold(0.0, |a: f64, x| a.max(x.abs()));
    for (a, (r, mu)) in r.iter_mut().zip(system.mu).enumerate() {
        let part = |c: usize| ((3 * a + c + 1) as f64 * (number as f64 + 0.618_033_988_749_895).sqrt()).fract();
        let normal = largest * part(0);
        let (sin, cos) = (std::f64::consts::TAU * part(1)).sin_cos();
        let tangential = mu * normal * part(2);
        *r = [normal, tangential * cos, tangential * sin];
    }
}
