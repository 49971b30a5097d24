//! Memory of the multigrid path, predicted before the hierarchy is set up.

use super::equations::fields;
use crate::Error;
use crate::contact::{ContactProblem, Division};
use crate::linalg::memory::ensure;

struct Threshold;

impl Threshold {
    /// Bytes that set-up, cycles and the first solution take at a time for each stored entry of `K` and for each unknown,
    /// beyond the problem itself; `tests/memory/predictions.rs` has what was measured.
    const BYTES_PER_ENTRY: f64 = 28.0;
    const BYTES_PER_UNKNOWN: f64 = 1550.0;
    /// Bytes an entry of `B` takes in its copies.
    const BYTES_PER_CONTACT_ENTRY: f64 = 80.0;
    /// Bytes an unknown of the fields of an equation over many nodes, which are there twice while they are made anew.
    const BYTES_PER_FIELD: f64 = 16.0;
    /// Bytes an entry of `K` in the problem without them.
    const BYTES_PER_COPIED_ENTRY: f64 = 12.0;
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

/// Refuses a problem, or a part of one that ranks share, whose hierarchy does not fit.
///
/// # Errors
/// If it is predicted to need more than `limit`, or than the system gives.
pub(crate) fn multigrid_fits(
    problem: &ContactProblem,
    division: Option<&Division>,
    limit: Option<u64>,
) -> Result<(), Error> {
    let n = problem.unknowns();
    let [entries, of_contact] = [problem.elastic.K.value.len(), problem.contact.B.value.len()].map(|c| c as f64);
    let fields = fields(problem, division) as f64;
    let copied = if fields > 0.0 { Threshold::BYTES_PER_COPIED_ENTRY * entries } else { 0.0 };
    let bytes =
        multigrid_bytes(n as f64, entries, of_contact) + Threshold::BYTES_PER_FIELD * fields * n as f64 + copied;
    ensure(&format!("multigrid for {n} unknowns"), bytes, limit)
}
