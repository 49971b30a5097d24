//! What is printed of an answer of several ranks: the rows of one machine, in their order.

use super::record::RankedSummary;
use crate::certificate::Certificate;
use crate::contact::escape::Escape;
use crate::friction::Status;
use crate::io::case::Case;
use crate::mesh::many;
use crate::run::pose::bolts::Target;
use crate::run::results::overlap_text::{Sentences, of_records};
use crate::run::results::report::{
    adrift_row, bolt_rows, certificate_rows, contact_rows, couple_rows, coupling_rows, displacement_row, escape_rows,
    faceted_row, limit_row, short_of, solutions, status, steps_solved, unheld_rows,
};
use crate::run::results::{Row, Rows, smallness_text};
use crate::run::solve::quantities::Couple;

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
    pub restarts: usize,
}

pub(super) fn rows(case: &Case, summary: &RankedSummary, known: Known) -> Vec<Row> {
    let mut rows = Rows::default();
    let cycles = cycles(summary);
    rows.add("status", status(summary.status, cycles));
    limit_row(&mut rows, summary.status);
    if summary.found_by_first {
        rows.more("by rank 0 alone, which takes other ways too: the ranks have judged its answer".into());
    }
    if let Some(last) = summary.steps.last() {
        rows.add("steps", steps_solved(summary.steps.len(), last.t, ""));
    }
    let Sentences { refused, warnings } = overlaps(summary);
    refused.into_iter().for_each(|what| rows.more(what));
    known.escape.iter().for_each(|escape| escape_rows(&mut rows, escape));
    if !case.steps.is_empty() && matches!(summary.status, Status::Stalled | Status::MaxIterations) {
        short_of(summary.bolts.clone(), known.targets).into_iter().for_each(|what| rows.more(what));
    }
    certificate_rows(&mut rows, known.certificate);
    if summary.contact.points > 0 {
        contact_rows(&mut rows, summary.pairs.iter().map(|pair| (&pair.name[..], &pair.totals)), &summary.contact);
    }
    bolt_rows(&mut rows, &summary.bolts);
    coupling_rows(&mut rows, &summary.couplings);
    warnings.into_iter().for_each(|warning| rows.add("warning", warning));
    let of_steps = summary.steps.iter().map(|step| (step.smallness.as_ref(), step.t));
    let left = smallness_text::warnings(summary.smallness.as_ref(), of_steps);
    left.into_iter().for_each(|warning| rows.add("warning", warning));
    let of_steps = summary.steps.iter().map(|step| (&step.unheld[..], step.t));
    unheld_rows(&mut rows, &summary.unheld, of_steps);
    let of_steps = summary.steps.iter().map(|step| (step.adrift.as_ref(), step.t));
    adrift_row(&mut rows, || summary.adrift.clone(), of_steps);
    let of_steps = summary.steps.iter().map(|step| (step.held_by_facets.as_ref(), step.t));
    faceted_row(&mut rows, || summary.held_by_facets.clone(), of_steps);
    couple_rows(&mut rows, known.couples);
    displacement_row(&mut rows, known.displacement);
    summary.smallness.iter().for_each(|of| rows.add("deformation", smallness_text::line(of)));
    match &summary.solutions {
        Some(found) => solutions(&mut rows, found),
        None if case.solver.starts.is_some() => {
            rows.add("solutions", "not looked for: rank 0, which does this alone, has found no answer".into());
        }
        None => {}
    }
    let ranks = many(summary.ranks.len(), "rank");
    let restarts = many(known.restarts, "restart");
    let work = if summary.found_by_first { many(cycles, "iteration") } else { many(cycles, "cycle") + " of multigrid" };
    rows.add(WORK, format!("{work}, {restarts}, on {ranks}"));
    rows.0
}

/// The row before which others are put that are known later.
pub(super) const WORK: &str = "work";

/// Cycles of all load steps, or of the only answer.
pub(super) fn cycles(summary: &RankedSummary) -> usize {
    match summary.steps.is_empty() {
        true => summary.counts.iterations,
        false => summary.steps.iter().map(|step| step.iterations).sum(),
    }
}

/// What is to be said of surfaces that lie in each other.
pub(super) fn overlaps(summary: &RankedSummary) -> Sentences {
    let steps: Vec<_> = (1..).zip(&summary.steps).map(|(number, step)| (number, step.t, &step.overlaps[..])).collect();
    of_records(summary.overlaps.clone(), steps.into_iter())
}
