use std::cmp::Ordering;

use crate::friction::End;
use crate::friction::law::{V3, augmented, projection};
use crate::friction::system::{Iterate, Newton, Observe, ProximalTerm, Step, moved};
use crate::linalg::dot;

/// Thresholds of [`proximal`], held against the random cases, in which it is the stage that given friction ends with.
struct Threshold;

impl Threshold {
    /// The parameter over that of the residual. It grows by `Self::FACTOR` with every change of the multipliers, and falls where
    /// `Self::PATIENCE` steps did not arrive: the larger it is, the fewer changes, and the sharper the bends of the energy.
    const FIRST: f64 = 1e-3;
    const FACTOR: f64 = 10.0;
    const PATIENCE: usize = 12;
    const SMALLEST: f64 = 1e-6;
    /// Beyond this the proximal term is lost in rounding.
    const LARGEST: f64 = 1e8;
    /// The energy of a set of multipliers is minimised until the multipliers it gives differ from their images by this part
    /// of what the step changed.
    const INNER: f64 = 0.1;
    /// Relative accuracies of a Newton step, the next one where a step is no descent. Less accurate ones are short: where
    /// compliances differ by 1e8 (a thin blade) those of 1e-2 do not arrive.
    const ACCURACIES: [f64; 2] = [1e-5, 1e-9];
    const BISECTIONS: usize = 60;
}

/// The proximal method of multipliers (Rockafellar 1976) for given friction, a convex problem: but for rounding it arrives from
/// any start. Coulomb friction takes it with bounds that are frozen.
///
/// With the multipliers `c` held, `E(u) = 1/2 u'Ku - f'u + sup over mu in C of (-mu . v(u) - |mu - c|^2 / 2r)` is convex and
/// once differentiable. Semismooth Newton steps with an exact line search minimise it (Li, Sun & Toh 2018), each from
/// `u = K^-1 (f - B'lambda)` along `-K^-1 B'd`, so that lambda and `v = Q lambda - h` say all of it; then `c` becomes the
/// projection of `c - r v`. `steps` counts down to the limit of the whole solve.
pub(super) fn proximal(on: &Newton<'_>, at: &mut Iterate, steps: &mut usize, observe: &mut Observe<'_>) -> End {
    let mut centre = at.lambda.clone();
    let (mut factor, mut inner) = (Threshold::FIRST, 0);
    loop {
        let (theta, scale) = (on.merit(at), on.weighed(&at.lambda));
        if observe(at, theta, scale, &on.states(at)).is_break() {
            return End::Interrupted;
        }
        if theta <= on.target(scale) {
            return End::Converged;
        }
        if *steps == 0 {
            return End::Limit;
        }
        // With this compliance the augmented multiplier is `centre - r v`.
        let r: Vec<f64> = on.r.iter().map(|r| factor * r).collect();
        let compliance: Vec<f64> = r.iter().map(|r| 1.0 / r).collect();
        let term = ProximalTerm { centre: &centre, compliance: &compliance };
        let regular = Newton { r: &r, proximal: Some(term), ..*on };
        let image = image(&regular, &centre, at);
        if regular.merit(at) <= Threshold::INNER * on.weighed(&moved(&centre, -1.0, &image)) {
            centre = image;
            (factor, inner) = (factor * Threshold::FACTOR, 0);
            if factor > Threshold::LARGEST {
                return End::Stalled;
            }
            continue;
        }
        if inner == Threshold::PATIENCE {
            (factor, inner) = ((factor / Threshold::FACTOR).max(Threshold::SMALLEST), 0);
            continue;
        }
        (*steps, inner) = (*steps - 1, inner + 1);
        let laws = regular.linearised(at, 0.0);
        let attempt = |accuracy: &f64| {
            let step = on.system.step(at, &laws, *accuracy)?;
            least_energy(&regular, &centre, at, &step)
        };
        let Some(next) = Threshold::ACCURACIES.iter().find_map(attempt) else { return End::Stalled };
        *at = next;
    }
}

/// The multipliers that the law gives for `centre - r v`.
fn image(on: &Newton<'_>, centre: &[V3], at: &Iterate) -> Vec<V3> {
    (0..centre.len()).map(|j| projection(on.friction[j], augmented(centre[j], at.v[j], on.r[j]))).collect()
}

/// The point at which the slope `(lambda - image) . dv - imbalance . d_alpha` of the energy along the step vanishes;
/// `None` if the step is no descent.
fn least_energy(on: &Newton<'_>, centre: &[V3], at: &Iterate, step: &Step) -> Option<Iterate> {
    let slope = |t: f64| {
        let next = on.system.advance(at, t, step);
        let off = moved(&next.lambda, -1.0, &image(on, centre, &next));
        dot(off.as_flattened(), step.v.as_flattened()) - dot(&on.system.imbalance(&next.lambda), &step.alpha)
    };
    if slope(0.0).partial_cmp(&0.0) != Some(Ordering::Less) {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while slope(high) < 0.0 && high < 1e6 {
        (low, high) = (high, 2.0 * high);
    }
    // The energy is quadratic up to where the next point changes its state: mostly the whole step is right.
    for _ in 0..Threshold::BISECTIONS {
        let middle = 0.5 * (low + high);
        *(if slope(middle) < 0.0 { &mut low } else { &mut high }) = middle;
    }
    Some(on.system.advance(at, high, step))
}
