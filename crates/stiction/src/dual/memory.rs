//! Memory of the direct path, predicted before it is taken.

use super::Form;
use super::estimate::{least_entries_of_graph, neighbours};
use crate::Error;
use crate::contact::ContactProblem;
use crate::linalg::memory::{ensure, too_large};
use crate::linalg::{NodeGraph, Plan, ordering_bytes};

struct Threshold;

impl Threshold {
    /// Merged supernodes store about a tenth more than the factor has entries.
    const MERGED: f64 = 1.1;
    /// Bytes of the vectors of GMRES and of its products for each row of `B`: three of a number for each of some 200 products.
    const BYTES_PER_ROW: f64 = 24.0 * 200.0;
    /// Bytes an entry of `B` takes in its copies.
    const BYTES_PER_ENTRY: f64 = 80.0;
    /// Vectors of all unknowns that are there at a time while a solution is found and certified, bytes for each unknown.
    const BYTES_PER_UNKNOWN: f64 = 200.0;
    /// Memory that does not grow with the problem, bytes.
    const BYTES: f64 = 1e6;
}

/// What a problem takes on the direct path whatever the order of its unknowns, bytes, for `stored` entries of `K` and a factor
/// of `factor` entries: the full rows of `K` and what they are permuted to, then the factor beside the latter.
pub(crate) fn least_bytes(unknowns: f64, stored: f64, factor: f64) -> f64 {
    let full = 2.0 * stored - unknowns;
    let before = 28.0 * full + Threshold::BYTES_PER_UNKNOWN * unknowns;
    before.max(before - 12.0 * stored + 8.0 * factor)
}

fn least(problem: &ContactProblem, factor: f64) -> f64 {
    least_bytes(problem.unknowns() as f64, problem.elastic.K.value.len() as f64, factor)
}

/// Refuses what cannot fit before the graph of `K` is made.
///
/// # Errors
/// If the copies of `K` alone do not fit.
pub(super) fn before_the_graph(problem: &ContactProblem, limit: Option<u64>) -> Result<(), Error> {
    ensure(&format!("the Cholesky factor of {} unknowns", problem.unknowns()), least(problem, 0.0), limit)
}

/// Refuses what cannot fit before METIS orders the graph, which takes half a minute for two million nodes.
///
/// # Errors
/// If the least a factor takes does not fit.
pub(super) fn before_the_ordering(
    problem: &ContactProblem,
    graph: &NodeGraph,
    limit: Option<u64>,
) -> Result<(), Error> {
    let blocks = (problem.unknowns() as f64 / (3.0 * graph.len().max(1) as f64)).powi(2);
    let bytes = least(problem, blocks * least_entries_of_graph(graph.len(), &neighbours(graph)));
    let what = format!("the Cholesky factor of {} unknowns", problem.unknowns());
    if let Some(limit) = limit.filter(|&limit| bytes > limit as f64) {
        return Err(coarser(problem, too_large(&format!("{what} at least"), bytes, limit), bytes, limit));
    }
    ensure("the ordering of the unknowns", ordering_bytes(graph), limit)?;
    ensure(&what, bytes, None)
}

/// The most that factorising in the order of `plan` and solving takes at a time, bytes.
pub(super) fn predicted(problem: &ContactProblem, graph: &NodeGraph, plan: &Plan, form: Form) -> f64 {
    let (n, full) = (problem.unknowns() as f64, 2.0 * problem.elastic.K.value.len() as f64 - problem.unknowns() as f64);
    let entries = graph.entries() as f64;
    let factor = 8.0 * Threshold::MERGED * plan.entries();
    // Rows and values in the order of the plan, and the full rows they are made of before the factor comes.
    let permuted = 16.0 * entries;
    let copy = 12.0 * full;
    let front = 8.0 * plan.largest_front();
    let dense = if form == Form::Dense { 8.0 * (plan.trailing as f64).powi(2) } else { 0.0 };
    let b = &problem.contact.B;
    let solving = Threshold::BYTES_PER_ROW * b.rows as f64 + Threshold::BYTES_PER_ENTRY * b.value.len() as f64;
    let making = permuted + (factor + front).max(copy);
    making.max(factor + dense + solving) + Threshold::BYTES_PER_UNKNOWN * n + Threshold::BYTES
}

/// The error with the size of a mesh that would fit.
pub(super) fn coarser(problem: &ContactProblem, error: Error, needed: f64, limit: u64) -> Error {
    // The factor of a 3D mesh grows like n^(4/3).
    let unknowns = problem.unknowns() as f64 * (limit as f64 / needed).powf(0.75);
    let remedy = error.remedy.replace("coarsen the mesh", &format!("coarsen the mesh to about {unknowns:.0} unknowns"));
    Error { remedy, ..error }
}
