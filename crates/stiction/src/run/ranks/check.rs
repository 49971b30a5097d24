//! The folder of several ranks, judged anew: their pieces are joined, and judged by what judges one file.

use std::collections::BTreeSet;
use std::path::Path;

use super::record::{RankedStep, RankedSummary};
use super::write::SUMMARY;
use crate::Error;
use crate::certificate::certify;
use crate::io::folder;
use crate::io::pieces::{is_piece, problem_name, read_pieces, solution_name};
use crate::run::pose::memory::check_of_pieces_fits;
use crate::run::results::check::{Checked, Stored, check as check_one, compare, differs, unsolved, with_files};
use crate::run::results::check_steps::{StoredStep, check_steps};
use crate::run::results::overlap_text::{is_refused, sentence};
use crate::run::results::step_file::STATE;
use crate::run::results::summary;
use crate::run::results::sums::{self, SUMS};

/// Compares the files of the result in `folder` with their checksums, recomputes its certificate from its problem and
/// solution, and compares that with its summary. Those of several ranks are joined before.
///
/// # Errors
/// If a file is missing, damaged, or does not fit the others.
pub fn check(folder: &Path) -> Result<Checked, Error> {
    let names = folder::names(folder).unwrap_or_default();
    let pieces: Vec<String> = names.iter().filter(|name| is_piece(name)).cloned().collect();
    if pieces.is_empty() || folder.join("problem.npz").exists() {
        return check_one(folder);
    }
    if !folder.join(SUMMARY).exists() {
        let (what, remedy) = match folder.join(STATE).exists() {
            true => (
                "it holds the finished load steps of a run on several ranks that has not ended",
                "let it end, or go on with `stiction-mpi solve CASE -o DIR --resume`",
            ),
            false => {
                ("it is what a run on several ranks has left that has not ended", "let it end, or solve the case again")
            }
        };
        return Err(Error::new(folder.display().to_string(), what, remedy));
    }
    check_of_pieces_fits(folder, &pieces)?;
    let files = differing(folder, &names)?;
    with_files(judge(folder), files)
}

/// Files that are missing, changed, or unknown to the list of checksums.
fn differing(folder: &Path, names: &[String]) -> Result<Vec<(String, String)>, Error> {
    let Some(sums) = sums::read(folder)? else {
        let what = format!("there is no {SUMS} in it: it is not complete");
        return Err(Error::new(folder.display().to_string(), what, "solve the case again"));
    };
    let mut wrong: BTreeSet<(String, String)> = sums::differing(folder, &sums).into_iter().collect();
    let ranks = summary::read::<RankedSummary>(&folder.join(SUMMARY)).map_or(0, |summary| summary.ranks.len());
    let needed = (0..ranks).flat_map(|rank| [problem_name(rank), solution_name(rank)]).chain([SUMMARY.to_string()]);
    let others = names.iter().filter(|name| is_piece(name)).cloned();
    let unlisted = needed.chain(others).filter(|name| !sums.contains_key(name));
    wrong.extend(unlisted.map(|name| (name, format!("not listed in {SUMS}"))));
    Ok(wrong.into_iter().collect())
}

/// The same without the checksums.
fn judge(folder: &Path) -> Result<Checked, Error> {
    let whole = read_pieces(folder)?;
    let (u, lambda) = whole.solution(folder)?;
    let summary: RankedSummary = summary::read(&folder.join(SUMMARY))?;
    let certificate = certify(&whole.problem, &u, &lambda, whole.tolerance);
    let normal_force: f64 = lambda.iter().zip(&whole.problem.labels.unity_sum).map(|(l, share)| share * l).sum();
    let RankedSummary { certificate: said, bodies, contact, .. } = &summary;
    let stored = Stored { certificate: said, bodies, normal_force: contact.normal_force };
    let mut differences = compare(&stored, &certificate, normal_force)?;
    for (number, other) in (1..).zip(summary.solutions.iter().flat_map(|found| &found.distinct)).skip(1) {
        let (u, lambda) = whole.other_solution(folder, number)?;
        let worst = certify(&whole.problem, &u, &lambda, whole.tolerance).worst;
        differences.extend(differs(&format!("solution {number}"), other.worst, worst, whole.tolerance));
    }
    let stored: Vec<StoredStep> = summary.steps.iter().map(stored_step).collect();
    let (mut problem, tolerance) = (whole.problem.clone(), whole.tolerance);
    let read = |number: usize| whole.step(folder, number);
    let steps = check_steps(&stored, &read, &mut problem, tolerance)?;
    let passes_through = summary.overlaps.iter().filter(|overlap| is_refused(overlap)).map(sentence).collect();
    Ok(Checked {
        certificate,
        differences,
        files: Vec::new(),
        passes_through,
        unsolved: unsolved(summary.status),
        bound: None,
        steps,
    })
}

fn stored_step(step: &RankedStep) -> StoredStep<'_> {
    let RankedStep { certificate, bodies, contact, t, .. } = step;
    let stored = Stored { certificate, bodies, normal_force: contact.normal_force };
    // Ranks do not count energies.
    StoredStep { t: *t, stored, balance: None }
}
