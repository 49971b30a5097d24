use std::ops::ControlFlow;

use super::fixed_point::SlipBounds;
use super::given::Record;
use super::method::{MethodEnd, MethodSettings, MethodStep};
use super::quadratic::Quadratic;
use crate::contact::Friction;
use crate::linalg::norm;
use crate::qp::{PointSet, accelerated_gradient, project};

/// Steps between two looks at the residual.
const ROUND: usize = 20;

/// Given friction with the discs as they are: accelerated projected gradients from `lambda` until the reduced
/// gradient `(lambda - P(lambda - a v)) / a`, `a = 1 / |Q|`, is at most the tolerance times `|h|`.
///
/// # Errors
/// How the method ended if not by its rule; `lambda` is where it came to.
pub(super) fn discs(
    q: &Quadratic<'_>,
    lambda: &mut Vec<f64>,
    slip_bounds: &SlipBounds<'_>,
    settings: &MethodSettings,
    record: &mut Record<'_, '_>,
) -> Result<(), MethodEnd> {
    let sets = sets(slip_bounds);
    project(&sets, lambda);
    let (target, weight) = (settings.tolerance * norm(&q.h), vec![1.0; q.points()]);
    let products = q.products();
    let mut image = q.times(lambda);
    loop {
        let reduced = reduced_gradient(q, &sets, lambda, &image);
        record.counts.products = q.products() - products;
        let ratio = if reduced == 0.0 { 0.0 } else { reduced / norm(&q.h) };
        note(lambda, slip_bounds, ratio, record)?;
        if reduced <= target {
            return Ok(());
        }
        if record.counts.iterations >= settings.max_iterations {
            return Err(MethodEnd::Limit);
        }
        let found = accelerated_gradient(|x| q.times(x), &q.h, &sets, &weight, lambda, &image, ROUND);
        record.counts.iterations += ROUND;
        (*lambda, image) = (found.x, found.a_times_x);
    }
}

/// What the multipliers of each point may be.
fn sets(slip_bounds: &SlipBounds<'_>) -> Vec<PointSet> {
    let set = |(law, &radius): (&Friction, &f64)| match law {
        Friction::Bonded => PointSet::Free,
        _ => PointSet::HalfLineAndDisc { radius },
    };
    slip_bounds.friction.iter().zip(&slip_bounds.value).map(set).collect()
}

fn reduced_gradient(q: &Quadratic<'_>, sets: &[PointSet], lambda: &[f64], image: &[f64]) -> f64 {
    let a = 1.0 / q.largest;
    let mut moved: Vec<f64> = (0..lambda.len()).map(|i| lambda[i] - a * (image[i] - q.h[i])).collect();
    project(sets, &mut moved);
    norm(&moved.iter().zip(lambda).map(|(p, l)| (l - p) / a).collect::<Vec<_>>())
}

fn note(
    lambda: &[f64],
    slip_bounds: &SlipBounds<'_>,
    change: f64,
    record: &mut Record<'_, '_>,
) -> Result<(), MethodEnd> {
    let m = slip_bounds.value.len();
    let is_open = |j: usize| lambda[j] <= 0.0 && slip_bounds.friction[j] != Friction::Bonded;
    let at_bound = |j: usize| lambda[m + j].hypot(lambda[2 * m + j]) >= slip_bounds.value[j] * (1.0 - 1e-12);
    let open = (0..m).filter(|&j| is_open(j)).count();
    let slip = (0..m).filter(|&j| !is_open(j) && slip_bounds.friction[j] != Friction::Bonded && at_bound(j)).count();
    let step = MethodStep {
        iteration: record.counts.iterations,
        fixed_point_step: record.counts.fixed_point_steps,
        change,
        disagreement: 0.0,
        steps: record.counts.steps(),
        products: record.counts.products,
        open,
        stick: m - open - slip,
        slip,
    };
    record.history.push(step);
    match (record.observe)(&step) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(MethodEnd::Interrupted),
    }
}
