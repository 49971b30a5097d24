//! Memory of the multigrid path, predicted before the hierarchy is set up.

use crate::Error;
use crate::contact::ContactProblem;
use crate::linalg::memory::ensure;

struct Threshold;

impl Threshold {
    /// Bytes that set-up, cycles and the first solution take at a time for each stored entry of `K` and for each unknown,
    /// beyond the problem itself; `tests/memory/predictions.rs` has what was measured.
    const BYTES_PER_ENTRY: f64 = 28.0;
    const BYTES_PER_UNKNOWN: f64 = 1550.0;
    /// Bytes an entry of `B` takes in its copies.
    const BYTES_PER_CONTACT_ENTRY: f64 = 80.0;
    /// The dense matrices of the coarsest level, whose size is bounded.
    const BYTES: f64 = 60e6;
}

/// Refuses a problem whose hierarchy does not fit.
///
/// # Errors
/// If it is predicted to need more than `limit`, or than the system gives.
pub(crate) fn multigrid_fits(problem: &ContactProblem, limit: Option<u64>) -> Result<(), Error> {
    let n = problem.unknowns();
    let bytes = Threshold::BYTES_PER_ENTRY * problem.elastic.K.value.len() as f64
        + Threshold::BYTES_PER_UNKNOWN * n as f64
        + Threshold::BYTES_PER_CONTACT_ENTRY * problem.contact.B.value.len() as f64
        + Threshold::BYTES;
    ensure(&format!("multigrid for {n} unknowns"), bytes, limit)
}
