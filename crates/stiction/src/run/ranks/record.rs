//! What is kept of an answer of several ranks: the records of one machine, filled with sums over the ranks.

use super::bolts::states;
use super::energy::{energy, load, reaction};
use super::local::Local;
use super::remarks::{Remarks, largest_displacement};
use super::solve::unknowns;
use super::ties::coupling_states;
use super::tighten::Found;
use super::totals::totals;
use super::tractions::RankTractions;
use crate::friction::{Multigrid, SolverPath};
use crate::io::case::Case;
use crate::io::machine;
use crate::ranks::{Ranks, broadcast, from_bytes, max, sum, to_bytes};
use crate::run::pose::{Seconds, Span};
use crate::run::solve::{AnswerRecord, BodyRecord, CertificateRecord, CountsRecord, Named, seconds};

/// The record of an answer at time `t`, the same on every rank, without its times and the memory.
pub(super) fn answer(
    case: &Case,
    (local, multigrid): (&Local, &Multigrid),
    found: &Found,
    remarks: &Remarks,
    tractions: &RankTractions,
    t: f64,
) -> AnswerRecord {
    let Found { solution, everywhere, shortening } = found;
    let (contact, pairs) = totals(local, multigrid, solution, tractions);
    let mut points = [multigrid.own_points().len() as f64];
    sum(&*local.division.ranks, &mut points);
    AnswerRecord {
        status: solution.status,
        escape_mode: None,
        sliding: None,
        overlaps: remarks.overlaps.clone(),
        certificate: CertificateRecord::of(&solution.certificate),
        contact,
        pairs: remarks.pairs(pairs),
        bodies: solution.certificate.bodies.iter().map(BodyRecord::of).collect(),
        bolts: states(local, &everywhere.u, shortening),
        couplings: coupling_states(local, everywhere, t),
        displacement_max: largest_displacement(local, found).0,
        discretisation_error: None,
        smallness: remarks.smallness.clone(),
        unheld: remarks.unheld.clone(),
        adrift: remarks.adrift.clone(),
        held_by_facets: remarks.held_by_facets.clone(),
        energy: energy(local, &everywhere.free),
        reaction: reaction(local, everywhere, t),
        load: load(local),
        dofs: unknowns(local),
        dual_dofs: 3 * points[0] as usize,
        method: case.solver.method_name.clone(),
        method_details: None,
        counts: CountsRecord::of_newton(&solution.counts),
        path: SolverPath::Multigrid,
        path_reason: None,
        seconds: Named::default(),
        cpu_seconds: Named::default(),
        peak_memory_bytes: None,
        coulomb: None,
        solutions: None,
    }
}

/// Puts what is known of the way to an answer in place of what the ranks know, where rank 0 has found it alone.
pub(super) fn take_way(answer: &mut AnswerRecord, of_first: AnswerRecord) {
    let AnswerRecord { method, method_details, counts, path, path_reason, coulomb, solutions, .. } = of_first;
    (answer.method, answer.method_details, answer.counts) = (method, method_details, counts);
    (answer.path, answer.path_reason) = (path, path_reason);
    (answer.coulomb, answer.solutions) = (coulomb, solutions);
}

/// Puts times, those of [`of_all`], and the largest memory of a rank into a record.
pub(super) fn take_cost(answer: &mut AnswerRecord, of_all: &Seconds, ranks: &dyn Ranks) {
    answer.seconds = seconds(of_all, |span| span.wall);
    answer.cpu_seconds = seconds(of_all, |span| span.cpu);
    let mut peak = [machine::peak_memory().map_or(-1.0, |bytes| bytes as f64)];
    max(ranks, &mut peak);
    answer.peak_memory_bytes = (peak[0] >= 0.0).then_some(peak[0] as u64);
}

/// Times of all ranks, the same on every one: on the clock those of rank 0, of processors the sum. Ranks that are threads of one process count
/// that of the process each.
pub(super) fn of_all(here: &Seconds, ranks: &dyn Ranks) -> Seconds {
    let mut cpu: Vec<f64> = here.phases().iter().map(|(_, span)| span.cpu).collect();
    sum(ranks, &mut cpu);
    let wall: Vec<f64> = here.phases().iter().map(|(_, span)| span.wall).collect();
    let wall = from_bytes::<f64>(&broadcast(ranks, to_bytes(&wall)));
    Seconds::of(wall.into_iter().zip(cpu).map(|(wall, cpu)| Span { wall, cpu }))
}
