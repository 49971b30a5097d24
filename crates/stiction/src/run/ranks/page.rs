//! `report.html` of a result folder, whoever wrote it: one machine, or several ranks their pieces.

use std::path::Path;

use super::record::{RankedStep, RankedSummary};
use crate::Error;
use crate::friction::SolverPath;
use crate::io::pvtu::named_pieces;
use crate::io::units::Units;
use crate::mesh::many;
use crate::run::pose::memory::report_of_pieces_fits;
use crate::run::results::page::{summary_in, write_page, write_report_on};
use crate::run::results::view::view_of_pieces;
use crate::run::results::write::PVTU;
use crate::run::results::{Summary, summary};
use crate::run::solve::{AnswerRecord, BalanceRecord, CountsRecord, Named, StepRecord, Totals};

/// Writes the report of a result folder anew from its other files and returns its size in bytes. Of several ranks it joins the pieces,
/// which takes the memory of one machine for the whole, and shows the last increment.
///
/// # Errors
/// If a file is missing or damaged, or the report cannot be written.
pub fn write_report(folder: &Path) -> Result<usize, Error> {
    let collections = PVTU.map(|name| folder.join(name));
    if !collections[0].exists() {
        return write_report_on(folder, None);
    }
    let path = summary_in(folder)?;
    let pieces = [named_pieces(&collections[0])?, named_pieces(&collections[1])?];
    report_of_pieces_fits(&pieces[0])?;
    let summary: RankedSummary = summary::read(&path)?;
    let view = view_of_pieces(&pieces, summary.nodes, Units::of(summary.units.as_deref()));
    let view = view.map_err(|error| error.at(&folder.display().to_string()))?;
    // Ranks write no case: a file of that name is of an earlier run.
    write_page(folder, &summary.into(), "", &view)
}

/// What the report of one machine shows; numbers that ranks do not take are not finite.
impl From<RankedSummary> for Summary {
    fn from(of: RankedSummary) -> Summary {
        let method = format!("multigrid on {}", many(of.ranks.len(), "rank"));
        let answer = |status, certificate, counts| AnswerRecord {
            status,
            escape_mode: None,
            sliding: None,
            overlaps: Vec::new(),
            certificate,
            contact: Totals::default(),
            pairs: Vec::new(),
            bodies: Vec::new(),
            bolts: Vec::new(),
            couplings: Vec::new(),
            displacement_max: f64::NAN,
            discretisation_error: None,
            smallness: None,
            unheld: Vec::new(),
            adrift: None,
            held_by_facets: None,
            energy: f64::NAN,
            reaction: [f64::NAN; 3],
            load: [f64::NAN; 3],
            dofs: of.dofs,
            dual_dofs: of.dual_dofs,
            method: method.clone(),
            method_details: None,
            counts,
            path: SolverPath::Multigrid,
            path_reason: None,
            seconds: Named(Vec::new()),
            cpu_seconds: Named(Vec::new()),
            peak_memory_bytes: None,
            coulomb: None,
            solutions: None,
        };
        let mut begin = 0.0;
        let step = |(step, of): (usize, RankedStep)| {
            let dt = of.t - std::mem::replace(&mut begin, of.t);
            let counts = CountsRecord { iterations: of.iterations, ..CountsRecord::default() };
            let (contact, pairs) = (of.contact, of.pairs);
            let answer = AnswerRecord { contact, pairs, ..answer(of.status, of.certificate, counts) };
            let balance = BalanceRecord { work: f64::NAN, elastic: f64::NAN, dissipation: f64::NAN, drift: f64::NAN };
            StepRecord { step, name: of.name, t: of.t, dt, attempts: 0, answer, balance }
        };
        let steps = (1..).zip(of.steps).map(step).collect();
        Summary {
            title: of.title,
            units: of.units,
            answer: AnswerRecord {
                escape_mode: of.escape_mode,
                overlaps: of.overlaps,
                contact: of.contact,
                pairs: of.pairs,
                bodies: of.bodies,
                displacement_max: of.displacement_max,
                discretisation_error: of.discretisation_error,
                solutions: of.solutions,
                smallness: of.smallness,
                seconds: of.seconds,
                peak_memory_bytes: of.peak_memory_bytes,
                ..answer(of.status, of.certificate, of.counts)
            },
            overrides: Vec::new(),
            versions: of.versions,
            balance: None,
            steps,
            fretting: Vec::new(),
            accuracy: of.accuracy,
            bound: None,
            command: None,
            problem: of.problem,
            report: of.report,
            pictures: of.pictures,
        }
    }
}
