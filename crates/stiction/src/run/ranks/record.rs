//! `summary.json` of a run on several ranks: the names of the other one where they mean the same.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::remarks::Remarks;
use super::report::{WORK, overlaps};
use crate::friction::{Solution, Status};
use crate::io::case::Case;
use crate::ranks::Wire;
use crate::run::pose::Seconds;
use crate::run::results::{ESTIMATED, FORMAT, Row, Rows, Versions, accuracy_rows, ended_short, percent, print};
use crate::run::solve::quantities::{AdriftRecord, FacetedRecord, Smallness};
use crate::run::solve::{
    AccuracyRecord, BodyRecord, BoltState, CertificateRecord, CountsRecord, CouplingState, Named, OverlapRecord,
    PairRecord, SolutionsRecord, Totals,
};

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

/// An increment of a load step, solved on several ranks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RankedStep {
    /// Name of the step in the case, of which this is an increment.
    pub name: String,
    /// The time at its end.
    pub t: f64,
    /// How the iteration ended.
    pub status: Status,
    /// Cycles it took.
    pub iterations: usize,
    /// The certificate, measured by all ranks.
    pub certificate: CertificateRecord,
    /// Over all contacts.
    pub contact: Totals,
    /// Totals of each pair.
    #[serde(default)]
    pub pairs: Vec<PairRecord>,
    /// Where surfaces lie in each other.
    #[serde(default)]
    pub overlaps: Vec<OverlapRecord>,
    /// How small rotations, strains and slips are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smallness: Option<Smallness>,
    /// Bodies that nothing holds: their places say nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unheld: Vec<String>,
    /// Motions that nothing resists: places along them say nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adrift: Option<AdriftRecord>,
    /// A motion that hardly more than the facets of curved surfaces resists.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_by_facets: Option<FacetedRecord>,
    /// Balance of each body.
    #[serde(default)]
    pub bodies: Vec<BodyRecord>,
    /// Force and shortening of each bolt.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bolts: Vec<BoltState>,
    /// Motion of each reference point, and what acts there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub couplings: Vec<CouplingState>,
}

impl RankedStep {
    pub(super) fn new(
        (name, t): (String, f64),
        solution: &Solution,
        (contact, pairs): (Totals, Vec<(String, Totals)>),
        remarks: &Remarks,
    ) -> Self {
        RankedStep {
            name,
            t,
            status: solution.status,
            iterations: solution.counts.cycles,
            certificate: CertificateRecord::of(&solution.certificate),
            contact,
            pairs: remarks.pairs(pairs),
            overlaps: remarks.overlaps.clone(),
            smallness: remarks.smallness.clone(),
            unheld: remarks.unheld.clone(),
            adrift: remarks.adrift.clone(),
            held_by_facets: remarks.held_by_facets.clone(),
            bodies: bodies(solution),
            bolts: Vec::new(),
            couplings: Vec::new(),
        }
    }

    pub(super) fn with_bolts(self, bolts: Vec<BoltState>) -> Self {
        RankedStep { bolts, ..self }
    }

    pub(super) fn with_couplings(self, couplings: Vec<CouplingState>) -> Self {
        RankedStep { couplings, ..self }
    }
}

fn bodies(solution: &Solution) -> Vec<BodyRecord> {
    solution.certificate.bodies.iter().map(BodyRecord::of).collect()
}

/// An answer found on several ranks; lengths, forces and energies in the units of the case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RankedSummary {
    /// Heading of the case.
    pub title: String,
    /// Names of the units, a label only.
    pub units: Option<String>,
    /// How the iteration ended.
    pub status: Status,
    /// The certificate, measured by all ranks.
    pub certificate: CertificateRecord,
    /// Where nothing balances the loads: the motion along which they carry a body away.
    #[serde(default)]
    pub escape_mode: Option<String>,
    /// Over all contacts.
    pub contact: Totals,
    /// Totals of each pair.
    #[serde(default)]
    pub pairs: Vec<PairRecord>,
    /// Where surfaces lie in each other.
    #[serde(default)]
    pub overlaps: Vec<OverlapRecord>,
    /// How small rotations, strains and slips are; none where loads carry a body away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smallness: Option<Smallness>,
    /// Bodies that nothing holds: their places say nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unheld: Vec<String>,
    /// Motions that nothing resists: places along them say nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adrift: Option<AdriftRecord>,
    /// A motion that hardly more than the facets of curved surfaces resists.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_by_facets: Option<FacetedRecord>,
    /// Balance of each body.
    #[serde(default)]
    pub bodies: Vec<BodyRecord>,
    /// Force and shortening of each bolt.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bolts: Vec<BoltState>,
    /// Motion of each reference point, and what acts there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub couplings: Vec<CouplingState>,
    /// The largest displacement of a node.
    pub displacement_max: f64,
    /// Unknown displacements.
    pub dofs: usize,
    /// Multipliers.
    pub dual_dofs: usize,
    /// Nodes of the mesh.
    pub nodes: u64,
    /// Cells of the mesh.
    pub cells: u64,
    /// Whether rank 0 has found the answer alone, as `stiction solve` does: after all ranks together had not, or on a small mesh of those
    /// that are refined.
    #[serde(default)]
    pub found_by_first: bool,
    /// What several starts have found; number `k` from 2 on is in the pieces `solution-000k-*.npz`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solutions: Option<SolutionsRecord>,
    /// Estimated error of the stresses in the mean, relative (energy norm), of the last increment; none where loads
    /// carry a body away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub discretisation_error: Option<f64>,
    /// How accurate it is, where the mesh was refined for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracyRecord>,
    /// The increments of load steps; the last of them is the answer above.
    #[serde(default)]
    pub steps: Vec<RankedStep>,
    /// What it cost.
    pub counts: CountsRecord,
    /// Nodes of each level, the finest first, and entries of its matrix.
    pub levels: Vec<(usize, usize)>,
    /// Wall time by phase of rank 0, and the total.
    pub seconds: Named,
    /// The largest memory of any rank, bytes.
    pub peak_memory_bytes: Option<u64>,
    /// What each rank has had.
    pub ranks: Vec<RankRecord>,
    /// The case as the program understood it.
    #[serde(default)]
    pub problem: Vec<Row>,
    /// What it printed of the answer.
    #[serde(default)]
    pub report: Vec<Row>,
    /// Versions of program and format.
    pub versions: Versions,
    /// Names of the pictures.
    #[serde(default)]
    pub pictures: Vec<String>,
}

impl RankedSummary {
    pub(super) fn new(
        case: &Case,
        [nodes, cells]: [u64; 2],
        solution: &Solution,
        contact: Totals,
        (dofs, displacement_max): (usize, f64),
        ranks: Vec<RankRecord>,
        seconds: &Seconds,
    ) -> Self {
        let (iterations, restarts) = (solution.counts.cycles, Some(solution.counts.restarts));
        RankedSummary {
            title: case.title.clone(),
            units: case.units.clone(),
            status: solution.status,
            certificate: CertificateRecord::of(&solution.certificate),
            dual_dofs: 3 * ranks.iter().map(|rank| rank.points).sum::<usize>(),
            escape_mode: None,
            contact,
            pairs: Vec::new(),
            overlaps: Vec::new(),
            smallness: None,
            unheld: Vec::new(),
            adrift: None,
            held_by_facets: None,
            bodies: bodies(solution),
            bolts: Vec::new(),
            couplings: Vec::new(),
            displacement_max,
            dofs,
            nodes,
            cells,
            counts: CountsRecord { iterations, restarts, ..CountsRecord::default() },
            levels: Vec::new(),
            steps: Vec::new(),
            found_by_first: false,
            solutions: None,
            discretisation_error: None,
            accuracy: None,
            seconds: times(seconds),
            peak_memory_bytes: ranks.iter().filter_map(|rank| rank.peak_memory_bytes).max(),
            ranks,
            problem: Vec::new(),
            report: Vec::new(),
            versions: Versions { stiction: env!("CARGO_PKG_VERSION").into(), summary: FORMAT },
            pictures: Vec::new(),
        }
    }

    pub(super) fn with_steps(self, steps: Vec<RankedStep>) -> Self {
        RankedSummary { steps, ..self }
    }

    pub(super) fn with_bolts(self, bolts: Vec<BoltState>) -> Self {
        RankedSummary { bolts, ..self }
    }

    pub(super) fn with_couplings(self, couplings: Vec<CouplingState>) -> Self {
        RankedSummary { couplings, ..self }
    }

    pub(super) fn found_by_first(self, found_by_first: bool) -> Self {
        RankedSummary { found_by_first, ..self }
    }

    /// Takes the times of all meshes.
    pub(super) fn take_seconds(&mut self, seconds: &Seconds) {
        self.seconds = times(seconds);
    }

    /// Takes what is known of the accuracy of the last mesh.
    pub(super) fn take_accuracy(&mut self, error: Option<f64>, accuracy: Option<AccuracyRecord>) {
        let mut rows = Rows::default();
        error.iter().for_each(|error| rows.add("mesh", format!("{ESTIMATED} {} (energy norm)", percent(*error))));
        accuracy.iter().for_each(|accuracy| accuracy_rows(&mut rows, accuracy));
        let end = self.report.iter().position(|row| row.label == WORK).unwrap_or(self.report.len());
        self.report.splice(end..end, rows.0);
        (self.discretisation_error, self.accuracy) = (error, accuracy);
    }

    /// Why there is no answer; none if there is one.
    pub fn ended_short(&self) -> Option<String> {
        let why = match (&self.escape_mode, self.status) {
            (Some(motion), Status::NoEquilibrium) => format!("the loads carry away {motion}"),
            (_, Status::PassesThrough) => self.passes_through(),
            _ => String::new(),
        };
        ended_short(self.status, self.steps.last().map(|step| step.t), &why)
    }

    /// Where surfaces between which contact is named pass through each other, and the remedy.
    pub(super) fn passes_through(&self) -> String {
        overlaps(self).refused.join("; ")
    }

    pub(super) fn with_levels(self, levels: Vec<(usize, usize)>) -> Self {
        RankedSummary { levels, ..self }
    }
}

/// Wall time by phase, and the total.
fn times(seconds: &Seconds) -> Named {
    let mut times: Vec<(String, f64)> =
        seconds.phases().iter().map(|(name, span)| (name.to_string(), span.wall)).collect();
    times.retain(|(_, wall)| *wall > 0.0);
    times.push(("total".into(), seconds.total().wall));
    Named(times)
}

impl fmt::Display for RankedSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print(f, &self.report, LABELS)?;
        let mut rows = Rows::default();
        let nodes = self.ranks.iter().map(|rank| rank.nodes);
        let (least, most) = (nodes.clone().min().unwrap_or(0), nodes.max().unwrap_or(0));
        rows.add("size", format!("{} unknowns, {least} to {most} nodes a rank", self.dofs));
        rows.add("time", format!("{:.2} s", self.seconds.get("total").unwrap_or(f64::NAN)));
        if let Some(peak) = self.peak_memory_bytes {
            rows.add("memory", format!("{:.2} GB a rank at most", peak as f64 / 1e9));
        }
        print(f, &rows.0, LABELS)
    }
}

/// Width of the labels.
const LABELS: usize = 12;
