//! Points with a tensile strength: solved as the problem without it, and judged as what it is.

use super::{Settings, Solution, Status};
use crate::certificate::certify;
use crate::contact::ContactProblem;

/// Solves before an answer that the certificate of the problem without strengths passes, but not that of the problem
/// itself, counts as stalled. Both count errors in the largest force of their own; a strength far above the loads makes
/// the first one coarse, and a tolerance smaller by the factor that is missed makes up for it.
const ATTEMPTS: usize = 3;
/// By which part the factor is overshot, and the least factor of one attempt.
const MARGIN: f64 = 0.3;
const LEAST_FACTOR: f64 = 1e-4;

/// The solution by `solve`, which knows no strengths; `None` where no point has any, and `problem` can be solved itself.
pub(super) fn solve_with_strength(
    problem: &ContactProblem,
    settings: &Settings,
    solve: &mut dyn FnMut(&ContactProblem, &Settings) -> Solution,
) -> Option<Solution> {
    let (shifted, tolerance) = (problem.without_strength()?, settings.tolerance);
    Some(until_certified(problem, settings, &mut |settings| {
        let mut found = solve(&shifted, settings);
        problem.take_strength_off(&mut found.lambda);
        found.certificate = certify(problem, &found.u, &found.lambda, tolerance);
        found
    }))
}

/// The solution of the problem without strengths that `solve` finds, with multipliers and certificate of `problem`, for tolerances that
/// decrease until the certificate passes.
pub(super) fn until_certified(
    problem: &ContactProblem,
    settings: &Settings,
    solve: &mut dyn FnMut(&Settings) -> Solution,
) -> Solution {
    let mut own = settings.clone();
    own.start.iter_mut().for_each(|start| problem.add_strength(start));
    let mut attempt = 1;
    loop {
        let found = solve(&own);
        let certificate = &found.certificate;
        let solved = found.status == Status::Solved;
        if !solved || certificate.is_as_good_as_the_data() || attempt == ATTEMPTS {
            let status = match (found.status, certificate.passed) {
                (Status::Solved, false) => Status::Stalled,
                (Status::Stalled | Status::MaxIterations, true) => Status::Solved,
                (status, _) => status,
            };
            return Solution { status, ..found };
        }
        attempt += 1;
        own.tolerance *= (MARGIN / certificate.missed()).max(LEAST_FACTOR);
        let mut start = found.lambda;
        problem.add_strength(&mut start);
        (own.start, own.start_displacement) = (Some(start), Some(found.u));
    }
}
