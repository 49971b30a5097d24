//! Which path is tried first.

use crate::contact::ContactProblem;
use crate::dual::estimate;
use crate::friction::Method;
use crate::io::case::{SolverPath, SolverSpec};

/// Below so many unknowns either path takes about a tenth of a second, and the direct one tells more about uniqueness.
const SMALL: usize = 10_000;
/// Above so many unknowns multigrid is the faster path whatever the shape (bars, plates and cubes were measured).
const LARGE: usize = 100_000;
/// Seconds of set-up and cycles an unknown on one core of 2020 or later: 30 cycles; only ratios are meant.
const MULTIGRID_SECONDS: f64 = 1e-5;

/// Whether a problem is solved by multigrid before anything else: because the case says so, or because that is
/// predicted to be faster than the direct path.
pub(crate) fn multigrid_first(spec: &SolverSpec, problem: &ContactProblem) -> bool {
    let faster = || match problem.unknowns() {
        n if n < SMALL => false,
        n if n > LARGE => true,
        n => MULTIGRID_SECONDS * (n as f64) < estimate(problem).seconds,
    };
    let path = spec.path == SolverPath::Multigrid || spec.path == SolverPath::Auto && faster();
    spec.method.method == Method::Newton && path
}
