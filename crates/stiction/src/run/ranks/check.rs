//! The folder of several ranks, judged anew: their pieces are joined, and judged by what judges one file.

use std::collections::BTreeSet;
use std::path::Path;

use super::write::SUMMARY;
use crate::Error;
use crate::certificate::certify;
use crate::io::folder;
use crate::io::pieces::{is_piece, problem_name, read_pieces, solution_name};
use crate::run::pose::memory::check_of_pieces_fits;
use crate::run::results::check::{Checked, Stored, check as check_one, compare, differs, unsolved, with_files};
use crate::run::results::check_steps::check_steps;
use crate::run::results::overlap_text::{is_refused, sentence};
use crate::run::results::step_file::STATE;
use crate::run::results::sums::{self, SUMS};
use crate::run::results::{Summary, summary};

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
    let of_ranks = summary::read::<Summary>(&folder.join(SUMMARY)).ok().and_then(|summary| summary.ranks);
    let ranks = of_ranks.map_or(0, |of| of.ranks.len());
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
    let Summary { answer, steps, .. } = summary::read(&folder.join(SUMMARY))?;
    let certificate = certify(&whole.problem, &u, &lambda, whole.tolerance);
    let normal_force: f64 = lambda.iter().zip(&whole.problem.labels.unity_sum).map(|(l, share)| share * l).sum();
    let mut differences = compare(&Stored::of(&answer), &certificate, normal_force)?;
    for (number, other) in (1..).zip(answer.solutions.iter().flat_map(|found| &found.distinct)).skip(1) {
        let (u, lambda) = whole.other_solution(folder, number)?;
        let worst = certify(&whole.problem, &u, &lambda, whole.tolerance).worst;
        differences.extend(differs(&format!("solution {number}"), other.worst, worst, whole.tolerance));
    }
    let (mut problem, tolerance) = (whole.problem.clone(), whole.tolerance);
    let read = |number: usize| whole.step(folder, number);
    let steps = check_steps(&steps, &read, &mut problem, tolerance)?;
    let passes_through = answer.overlaps.iter().filter(|overlap| is_refused(overlap)).map(sentence).collect();
    Ok(Checked {
        certificate,
        differences,
        files: Vec::new(),
        passes_through,
        unsolved: unsolved(answer.status),
        bound: None,
        steps,
    })
}
