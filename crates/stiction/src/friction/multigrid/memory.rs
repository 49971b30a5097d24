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

/// Bytes of the multigrid path for so many unknowns and stored entries of `K` and of `B`.
pub(crate) fn multigrid_bytes(unknowns: f64, entries: f64, contact_entries: f64) -> f64 {
    Threshold::BYTES_PER_ENTRY * entries
        + Threshold::BYTES_PER_UNKNOWN * unknowns
        + Threshold::BYTES_PER_CONTACT_ENTRY * contact_entries
        + Threshold::BYTES
}

/// Refuses a problem whose hierarchy does not fit.
///
/// # Errors
/// If it is predicted to need more than `limit`, or than the system gives.
pub(crate) fn multigrid_fits(problem: &ContactProblem, limit: Option<u64>) -> Result<(), Error> {
    let n = problem.unknowns();
    let [entries, of_contact] = [problem.elastic.K.value.len(), problem.contact.B.value.len()].map(|c| c as f64);
    ensure(&format!("multigrid for {n} unknowns"), multigrid_bytes(n as f64, entries, of_contact), limit)
}
