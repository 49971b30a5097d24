//! What is printed of an answer of several ranks: the rows of one machine, in their order.

use std::fmt;

use crate::certificate::Certificate;
use crate::contact::escape::Escape;
use crate::friction::Status;
use crate::io::case::Case;
use crate::mesh::many;
use crate::run::pose::bolts::Target;
use crate::run::results::overlap_text::{Sentences, of_records};
use crate::run::results::report::{
    Laws, adrift_row, bolt_rows, certificate_rows, contact_rows, couple_rows, coupling_rows, displacement_row,
    escape_rows, faceted_row, limit_load_of, limit_row, mesh_row, short_of, solutions, status, step_rows, unheld_rows,
    uniqueness_row,
};
use crate::run::results::{Row, Rows, Summary, accuracy_rows, ended_short, print, smallness_text};
use crate::run::solve::quantities::Couple;
use crate::run::solve::{AccuracyRecord, AnswerRecord, StepRecord};

/// What is known of an answer beside its summary.
pub(super) struct Known<'a> {
    pub certificate: &'a Certificate,
    pub couples: &'a [Couple],
    /// The largest displacement, and where it is.
    pub displacement: (f64, [f64; 3]),
    /// How a body is carried away.
    pub escape: Option<&'a Escape>,
    /// What is asked of each bolt.
    pub targets: Vec<Target>,
    /// Of the points of all ranks.
    pub laws: Laws,
}

pub(super) fn rows(case: &Case, summary: &Summary, known: Known) -> Vec<Row> {
    let mut rows = Rows::default();
    let (answer, steps) = (&summary.answer, &summary.steps);
    let found_by_first = summary.found_by_first();
    let all = iterations(answer, steps);
    rows.add("status", status(answer.status, all));
    limit_row(&mut rows, answer.status);
    if found_by_first {
        rows.more("by rank 0 alone, which takes other ways too: the ranks have judged its answer".into());
    }
    step_rows(&mut rows, steps);
    let Sentences { refused, warnings } = overlaps(summary);
    refused.into_iter().for_each(|what| rows.more(what));
    known.escape.iter().for_each(|escape| escape_rows(&mut rows, escape));
    answer.sliding.iter().for_each(|sliding| rows.more(limit_load_of(sliding, steps)));
    if !steps.is_empty() && matches!(answer.status, Status::Stalled | Status::MaxIterations) {
        short_of(answer.bolts.clone(), known.targets).into_iter().for_each(|what| rows.more(what));
    }
    certificate_rows(&mut rows, known.certificate);
    if answer.contact.points > 0 {
        contact_rows(&mut rows, answer.pairs.iter().map(|pair| (&pair.name[..], &pair.totals)), &answer.contact);
    }
    bolt_rows(&mut rows, &answer.bolts);
    coupling_rows(&mut rows, &answer.couplings);
    warnings.into_iter().for_each(|warning| rows.add("warning", warning));
    let of_steps = steps.iter().map(|step| (step.answer.smallness.as_ref(), step.t));
    let left = smallness_text::warnings(answer.smallness.as_ref(), of_steps);
    left.into_iter().for_each(|warning| rows.add("warning", warning));
    let of_steps = steps.iter().map(|step| (&step.answer.unheld[..], step.t));
    unheld_rows(&mut rows, &answer.unheld, of_steps);
    let of_steps = steps.iter().map(|step| (step.answer.adrift.as_ref(), step.t));
    adrift_row(&mut rows, || answer.adrift.clone(), of_steps);
    let of_steps = steps.iter().map(|step| (step.answer.held_by_facets.as_ref(), step.t));
    faceted_row(&mut rows, || answer.held_by_facets.clone(), of_steps);
    couple_rows(&mut rows, known.couples);
    displacement_row(&mut rows, known.displacement);
    answer.smallness.iter().for_each(|of| rows.add("deformation", smallness_text::line(of)));
    if answer.status == Status::Solved {
        uniqueness_row(&mut rows, answer.coulomb.as_ref(), answer.path, known.laws);
    }
    match &answer.solutions {
        Some(found) => solutions(&mut rows, found),
        None if case.solver.starts.is_some() => {
            rows.add("solutions", "not looked for: rank 0, which does this alone, has found no answer".into());
        }
        None => {}
    }
    let ranks = many(summary.ranks.as_ref().map_or(1, |of| of.ranks.len()), "rank");
    let restarts = many(answer.counts.restarts.unwrap_or(0), "restart");
    let work =
        if found_by_first { many(all, "iteration") } else { many(answer.counts.cycles, "cycle") + " of multigrid" };
    rows.add("work", format!("{work}, {restarts}, on {ranks}"));
    rows.0
}

/// The rows before the first of which the accuracy stands, which is known later.
const BELOW: [&str; 3] = ["uniqueness", "solutions", "work"];

/// Takes what is known of the accuracy of the last mesh into a summary and its report.
pub(super) fn take_accuracy(summary: &mut Summary, error: Option<f64>, accuracy: Option<AccuracyRecord>) {
    let mut rows = Rows::default();
    error.iter().for_each(|error| mesh_row(&mut rows, *error, &summary.steps));
    accuracy.iter().for_each(|accuracy| accuracy_rows(&mut rows, accuracy));
    let below = summary.report.iter().position(|row| BELOW.contains(&&row.label[..]));
    let end = below.unwrap_or(summary.report.len());
    summary.report.splice(end..end, rows.0);
    (summary.answer.discretisation_error, summary.accuracy) = (error, accuracy);
}

/// Cycles or iterations of all load steps, or of the only answer.
pub(super) fn iterations(answer: &AnswerRecord, steps: &[StepRecord]) -> usize {
    if steps.is_empty() { answer.counts.steps() } else { steps.iter().map(|step| step.answer.counts.steps()).sum() }
}

/// What is to be said of surfaces that lie in each other.
pub(super) fn overlaps(summary: &Summary) -> Sentences {
    let steps = (1..).zip(&summary.steps);
    let steps: Vec<_> = steps.map(|(number, step)| (number, step.t, &step.answer.overlaps[..])).collect();
    of_records(summary.answer.overlaps.clone(), steps.into_iter())
}

impl Summary {
    /// Why there is no answer; none if there is one.
    pub fn ended_short(&self) -> Option<String> {
        let AnswerRecord { status, escape_mode, sliding, .. } = &self.answer;
        let why = match (status, escape_mode, sliding) {
            (Status::NoEquilibrium, Some(motion), _) => format!("the loads carry away {motion}"),
            (Status::PassesThrough, ..) => self.passes_through(),
            (Status::Stalled | Status::MaxIterations, _, Some(sliding)) => limit_load_of(sliding, &self.steps),
            _ => String::new(),
        };
        ended_short(*status, self.steps.last().map(|step| step.t), &why)
    }

    /// Whether rank 0 of several has found the answer alone.
    pub fn found_by_first(&self) -> bool {
        self.ranks.as_ref().is_some_and(|ranks| ranks.found_by_first)
    }

    /// Where surfaces between which contact is named pass through each other, and the remedy.
    pub(super) fn passes_through(&self) -> String {
        overlaps(self).refused.join("; ")
    }
}

/// What is printed: the report, and below what the run took.
impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print(f, &self.report, LABELS)?;
        let mut rows = Rows::default();
        if let Some(of) = &self.ranks {
            let nodes = of.ranks.iter().map(|rank| rank.nodes);
            let (least, most) = (nodes.clone().min().unwrap_or(0), nodes.max().unwrap_or(0));
            rows.add("size", format!("{} unknowns, {least} to {most} nodes a rank", self.answer.dofs));
        }
        rows.add("time", format!("{:.2} s", self.answer.seconds.get("total").unwrap_or(f64::NAN)));
        if let Some(peak) = self.answer.peak_memory_bytes {
            rows.add("memory", format!("{:.2} GB a rank at most", peak as f64 / 1e9));
        }
        print(f, &rows.0, LABELS)
    }
}

/// Width of the labels.
const LABELS: usize = 12;
