use std::cmp::Ordering;

use super::newton::{End, Iterate, Newton, Observe};
use super::newton_system::{Linearized, NewtonSystem, Step};
use crate::friction::law::{projection, residual, states};
use crate::linalg::{axpy, dot, norm};

/// The parameter over that of the residual. It grows by `FACTOR` with every change of the multipliers, and falls where
/// `PATIENCE` steps did not arrive: the larger it is, the fewer changes, and the sharper the bends of the energy.
const FIRST: f64 = 10.0;
const FACTOR: f64 = 10.0;
const PATIENCE: usize = 12;
const SMALLEST: f64 = 1e-2;
/// Beyond this the proximal term is lost in rounding.
const LARGEST: f64 = 1e8;
/// The energy of a set of multipliers is minimised until the multipliers it gives differ from their images by this share of
/// what the step changed.
const INNER: f64 = 0.1;
/// Relative accuracies of a Newton step, the next one where a step is no descent; and the products it may take. Less
/// accurate ones are short: where compliances differ by 1e8 (a thin blade) those of 1e-2 do not arrive.
const ACCURACIES: [f64; 2] = [1e-5, 1e-9];
const INNER_LIMIT: usize = 300;
const BISECTIONS: usize = 60;

/// The proximal method of multipliers (Rockafellar 1976) for given friction, a convex problem: but for rounding it arrives from
/// any start. Coulomb friction takes it with bounds that are frozen.
///
/// With the multipliers `c` held, `E(u) = 1/2 u'Ku - f'u + sup over mu in C of (-mu . v(u) - |mu - c|^2 / 2r)` is convex and
/// once differentiable. Semismooth Newton steps with an exact line search minimise it (Li, Sun & Toh 2018), each from
/// `u = K^-1 (f - B'lambda)` along `-K^-1 B'd`, so that lambda and `v = Q lambda - h` say all of it; then `c` becomes the
/// projection of `c - r v`. `steps` counts down to the limit of the whole solve.
pub(super) fn proximal(on: &Newton<'_>, at: &mut Iterate, steps: &mut usize, observe: &mut Observe<'_>) -> End {
    let jumps = &on.dual.floating.jumps[..on.resultant.len()];
    let imbalance = |at: &Iterate| on.dual.floating.imbalance(on.resultant, &at.lambda);
    let merit = |at: &Iterate| norm(&residual(on.friction, &at.lambda, &at.v, on.r)).hypot(norm(&imbalance(at)));
    let mut centre = at.lambda.clone();
    let (mut factor, mut inner) = (FIRST, 0);
    loop {
        let (theta, scale) = (merit(at), norm(&at.lambda));
        if observe(theta, scale, &states(on.friction, &at.lambda, &at.v, on.r)).is_break() {
            return End::Interrupted;
        }
        if theta <= on.tolerance * scale.max(on.loose) {
            return End::Converged;
        }
        if *steps == 0 {
            return End::Limit;
        }
        let r: Vec<f64> = on.r.iter().map(|r| factor * r).collect();
        let image = projection(on.friction, &centre, &at.v, &r);
        let off = distance(&at.lambda, &image).hypot(norm(&imbalance(at)));
        if off <= INNER * distance(&centre, &image) {
            centre = image;
            (factor, inner) = (factor * FACTOR, 0);
            if factor > LARGEST {
                return End::Stalled;
            }
            continue;
        }
        if inner == PATIENCE {
            (factor, inner) = ((factor / FACTOR).max(SMALLEST), 0);
            continue;
        }
        (*steps, inner) = (*steps - 1, inner + 1);
        let system = NewtonSystem::new(&Linearized {
            friction: on.friction,
            largest_slope: 0.0,
            live: on.live,
            stiffness: on.stiffness,
            lambda: &at.lambda,
            v: &at.v,
            r: &r,
            centre: Some(&centre),
        });
        let attempt = |accuracy: &f64| {
            let step = system.solve(on.dual, jumps, &imbalance(at), *accuracy, INNER_LIMIT);
            least_energy(on, at, &step, &centre, &r).map(|t| (t, step))
        };
        let Some((t, step)) = ACCURACIES.iter().find_map(attempt) else { return End::Stalled };
        axpy(t, &step.d, &mut at.lambda);
        axpy(t, &step.dv, &mut at.v);
        if !jumps.is_empty() {
            axpy(t, &step.d_alpha, &mut at.alpha);
        }
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    norm(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>())
}

/// The length at which the slope `(lambda - image) . dv - imbalance . d_alpha` of the energy along the step vanishes; `None`
/// if the step is no descent.
fn least_energy(on: &Newton<'_>, at: &Iterate, step: &Step, centre: &[f64], r: &[f64]) -> Option<f64> {
    let along = |x: &[f64], t: f64, d: &[f64]| -> Vec<f64> { x.iter().zip(d).map(|(x, d)| x + t * d).collect() };
    let slope = |t: f64| {
        let (lambda, v) = (along(&at.lambda, t, &step.d), along(&at.v, t, &step.dv));
        let image = projection(on.friction, centre, &v, r);
        let off: Vec<f64> = lambda.iter().zip(image).map(|(x, p)| x - p).collect();
        dot(&off, &step.dv) - dot(&on.dual.floating.imbalance(on.resultant, &lambda), &step.d_alpha)
    };
    if slope(0.0).partial_cmp(&0.0) != Some(Ordering::Less) {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while slope(high) < 0.0 && high < 1e6 {
        (low, high) = (high, 2.0 * high);
    }
    // The energy is quadratic up to where the next point changes its state: mostly the whole step is right.
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        *(if slope(middle) < 0.0 { &mut low } else { &mut high }) = middle;
    }
    Some(high)
}
