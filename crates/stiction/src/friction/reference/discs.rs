use std::ops::ControlFlow;

use super::fixed_point::SlipBounds;
use super::given::{Record, relative};
use super::method::{MethodSettings, MethodStep};
use super::minimize::verdict;
use super::quadratic::Quadratic;
use crate::contact::Friction;
use crate::friction::End;
use crate::linalg::norm;
use crate::qp::{PointSet, Program, QpStatus, SetSettings, minimize_in_sets};

/// Given friction with the discs as they are: one quadratic program over half-lines and discs from `lambda`, until its
/// reduced gradient is at most the tolerance times `|h|`.
///
/// # Errors
/// How the method ended if not by its rule; `lambda` is where it came to.
pub(super) fn discs(
    q: &Quadratic<'_>,
    lambda: &mut Vec<f64>,
    slip_bounds: &SlipBounds<'_>,
    settings: &MethodSettings,
    record: &mut Record<'_, '_>,
) -> Result<(), End> {
    let (size, sets) = (norm(&q.h), sets(slip_bounds));
    let (before, earlier) = (record.counts, q.products());
    let most = settings.max_cg_steps.saturating_sub(before.steps());
    let mut interrupted = false;
    let mut stop = |x: &[f64], reduced: f64| {
        record.counts.iterations += 1;
        record.counts.products = before.products + q.products() - earlier;
        interrupted = note(x, slip_bounds, relative(reduced, size), record);
        interrupted || record.counts.iterations >= settings.max_iterations
    };
    let problem = Program {
        operator: &mut |x| q.times(x),
        b: &q.h,
        largest_eigenvalue: Some(q.largest_bound()),
        preconditioner: None,
    };
    let target = settings.tolerance * size;
    let found = minimize_in_sets(problem, &sets, lambda, &SetSettings::default(), target, most, &mut stop);
    lambda.clone_from(&found.x);
    let counts = &mut record.counts;
    counts.products = before.products + q.products() - earlier;
    counts.qp_problems += 1;
    counts.short_problems += usize::from(found.status == QpStatus::Stalled);
    counts.cg_steps += found.counts.cg_steps;
    counts.expansions += found.counts.expansions;
    counts.proportionings += found.counts.gradient_steps;
    counts.flops += found.counts.flops + 2.0 * (found.counts.products * lambda.len() * lambda.len()) as f64;
    match found.status {
        QpStatus::Interrupted if interrupted => Err(End::Interrupted),
        QpStatus::Interrupted => Err(End::Limit),
        QpStatus::Stalled => Err(End::Stalled),
        status => verdict(status),
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

/// Reports one iteration; whether the observer wants to stop.
fn note(lambda: &[f64], slip_bounds: &SlipBounds<'_>, change: f64, record: &mut Record<'_, '_>) -> bool {
    /// Friction this close to its bound counts as being there.
    const AT_BOUND: f64 = 1e-12;
    let m = slip_bounds.value.len();
    let loose = |j: &usize| slip_bounds.friction[*j] != Friction::Bonded;
    let slips = |j: &usize| {
        let friction = lambda[m + j].hypot(lambda[2 * m + j]);
        lambda[*j] > 0.0 && friction >= slip_bounds.value[*j] * (1.0 - AT_BOUND)
    };
    let open = (0..m).filter(loose).filter(|&j| lambda[j] <= 0.0).count();
    let slip = (0..m).filter(loose).filter(slips).count();
    let step = MethodStep {
        iteration: record.counts.iterations,
        fixed_point_step: record.counts.fixed_point_steps,
        change,
        disagreement: 0.0,
        steps: record.counts.iterations,
        products: record.counts.products,
        open,
        stick: m - open - slip,
        slip,
    };
    record.history.push(step);
    (record.observe)(&step) == ControlFlow::Break(())
}
