//! What is kept of an answer of several ranks: the records of one machine, filled with sums over the ranks, and what ranks have beside
//! them.

use serde::{Deserialize, Serialize};

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
use crate::ranks::{Ranks, Wire, broadcast, from_bytes, max, sum, to_bytes};
use crate::run::pose::{Seconds, Span};
use crate::run::solve::{AnswerRecord, BodyRecord, CertificateRecord, CountsRecord, Named, seconds};

/// What one rank has had and sent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RankRecord {
    /// Nodes with unknown displacements that it owns.
    pub nodes: usize,
    /// Nodes of others that these are coupled to.
    pub ghosts: usize,
    /// Contact points that it owns.
    pub points: usize,
    /// Exchanges of values at the borders of all levels, a cycle.
    pub exchanges_per_cycle: f64,
    /// Bytes sent in these, a cycle.
    pub bytes_per_cycle: f64,
    /// Messages of all kinds sent, a cycle; those of the certificate are counted.
    pub messages_per_cycle: f64,
    /// Sums and maxima over all ranks, for which every rank waits, a cycle; those of the start and of the certificate are counted.
    pub sums_per_cycle: f64,
    /// Largest memory of its process, bytes. Ranks that are threads share one.
    pub peak_memory_bytes: Option<u64>,
}

impl RankRecord {
    pub(super) fn to_bytes(self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let peak = self.peak_memory_bytes.unwrap_or(u64::MAX);
        [self.nodes as u64, self.ghosts as u64, self.points as u64, peak].write(&mut bytes);
        [self.exchanges_per_cycle, self.bytes_per_cycle, self.messages_per_cycle, self.sums_per_cycle]
            .write(&mut bytes);
        bytes
    }

    pub(super) fn from_bytes(bytes: &[u8]) -> RankRecord {
        let [nodes, ghosts, points, peak] = <[u64; 4]>::read(bytes);
        let [exchanges_per_cycle, bytes_per_cycle, messages_per_cycle, sums_per_cycle] = <[f64; 4]>::read(&bytes[32..]);
        RankRecord {
            nodes: nodes as usize,
            ghosts: ghosts as usize,
            points: points as usize,
            exchanges_per_cycle,
            bytes_per_cycle,
            messages_per_cycle,
            sums_per_cycle,
            peak_memory_bytes: Some(peak).filter(|&peak| peak != u64::MAX),
        }
    }
}

/// What `summary.json` says of a run on several ranks beside what it says of one machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RanksRecord {
    /// Nodes of the mesh.
    pub nodes: u64,
    /// Cells of the mesh.
    pub cells: u64,
    /// Whether rank 0 has found the answer alone, as `stiction solve` does: after all ranks together had not, or on a small mesh of those
    /// that are refined.
    pub found_by_first: bool,
    /// Nodes of each level, the finest first, and entries of its matrix.
    pub levels: Vec<(usize, usize)>,
    /// What each rank has had.
    pub ranks: Vec<RankRecord>,
}

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
