//! A result folder judged anew.

use std::path::Path;

use super::check_steps::{CheckedStep, check_steps};
use super::overlap_text::{is_refused, sentence};
use super::step_file::step_file;
use super::write::{BOUND, other_solution};
use super::{Summary, summary, sums};
use crate::Error;
use crate::certificate::{BOUND_TOLERANCE, Certificate, JudgedBound, certify, judge_bound, judge_tie};
use crate::contact::ContactProblem;
use crate::friction::Status;
use crate::io::bound::read_bound;
use crate::io::problem;
use crate::io::step::read_step;
use crate::run::pose::memory::check_fits;
use crate::run::solve::{AnswerRecord, BodyRecord, BoundRecord, CertificateRecord, word};

/// What a folder's files amount to.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// Recomputed from `problem.npz` and `solution.npz`.
    pub certificate: Certificate,
    /// Where `summary.json` says something else: name, what it says, what was recomputed.
    pub differences: Vec<(String, f64, f64)>,
    /// Files that are not as they were written: name, and whether it is missing, changed or unknown.
    pub files: Vec<(String, String)>,
    /// Where surfaces between which contact is named pass through each other, as the summary says; what judges anew knows
    /// contact points alone.
    pub passes_through: Vec<String>,
    /// How the run ended, as the summary says, if it has found no answer: what was asked of bolts the certificate does not know.
    pub unsolved: Option<String>,
    /// What the file of a bound of the discretisation error proves, if there is one.
    pub bound: Option<JudgedBound>,
    /// The load steps, if it is a stepped run; the last is what the rest speaks of.
    pub steps: Vec<CheckedStep>,
}

impl Checked {
    /// Whether the certificate passes, the summary says the same and has an answer, all files are as they were written, no surfaces pass through
    /// each other, and the bound of the discretisation error is proven by its file.
    pub fn passed(&self) -> bool {
        let steps = self.steps.iter().all(|step| step.certificate.passed && step.differences.is_empty());
        self.certificate.passed
            && self.differences.is_empty()
            && self.files.is_empty()
            && self.passes_through.is_empty()
            && self.unsolved.is_none()
            && self.bound.as_ref().is_none_or(JudgedBound::passed)
            && steps
    }
}

/// Two values of a measure agree if they differ by no more than this part of the larger or of the tolerance: what
/// the order of additions can change, and far less than would matter.
const SAME: f64 = 1e-3;

/// Compares the files of the result in `folder` with their checksums, recomputes its certificate from its problem and
/// solution, and compares that with its summary.
///
/// # Errors
/// If a file is missing, damaged, or does not fit the others.
pub(crate) fn check(folder: &Path) -> Result<Checked, Error> {
    let file = folder.join("problem.npz");
    if folder.join("steps.json").exists() && !folder.join("summary.json").exists() {
        let what = "it holds the finished load steps of a run that has not ended";
        let remedy = "let it end, or go on with `stiction solve CASE -o DIR --resume`";
        return Err(Error::new(folder.display().to_string(), what, remedy));
    }
    if !file.exists() {
        let what = "there is no problem.npz in it";
        let remedy = "name a folder that `stiction solve` has filled";
        return Err(Error::new(folder.display().to_string(), what, remedy));
    }
    check_fits(folder)?;
    let summary = summary::read::<Summary>(&folder.join("summary.json"));
    let pictures = summary.map_or(Vec::new(), |summary| summary.pictures);
    let files = sums::verify(folder, &pictures)?;
    with_files(judge(folder), files)
}

/// What was judged, with the files that are not what the list of checksums says; an error names them too.
pub(crate) fn with_files(judged: Result<Checked, Error>, files: Vec<(String, String)>) -> Result<Checked, Error> {
    match judged {
        Ok(judged) => Ok(Checked { files, ..judged }),
        Err(mut error) => {
            if !files.is_empty() {
                let list: Vec<String> = files.iter().map(|(name, what)| format!("{name} is {what}")).collect();
                error.what += &format!("; of the files of the folder {}", list.join(", "));
            }
            Err(error)
        }
    }
}

/// The same without the checksums.
fn judge(folder: &Path) -> Result<Checked, Error> {
    let (mut problem, tolerance) = problem::read_problem(&folder.join("problem.npz"))?;
    let (u, lambda) = problem::read_solution(&folder.join("solution.npz"), &problem)?;
    let certificate = certify(&problem, &u, &lambda, tolerance);
    let summary: Summary = summary::read(&folder.join("summary.json"))?;
    let normal_force: f64 = lambda.iter().zip(&problem.labels.unity_sum).map(|(force, share)| share * force).sum();
    let mut differences = compare(&Stored::of(&summary.answer), &certificate, normal_force)?;
    for (number, other) in (1..).zip(summary.answer.solutions.iter().flat_map(|found| &found.distinct)).skip(1) {
        let name = other_solution(number);
        let (u, lambda) = problem::read_solution(&folder.join(&name), &problem)?;
        let worst = certify(&problem, &u, &lambda, tolerance).worst;
        differences.extend(differs(&name, other.worst, worst, tolerance));
    }
    let bound = check_bound(folder, summary.bound.as_ref(), &problem, &u, &mut differences)?;
    let [n, p, m] =
        [problem.unknowns(), problem.labels.supports.as_ref().map_or(0, |s| s.load.len()), problem.points()];
    let read = |number: usize| read_step(&step_file(folder, number), n, p, m);
    let steps = check_steps(&summary.steps, &read, &mut problem, tolerance)?;
    let refused = summary.answer.overlaps.iter().filter(|overlap| is_refused(overlap));
    let passes_through = refused.map(sentence).collect();
    let unsolved = unsolved(summary.answer.status);
    Ok(Checked { certificate, differences, files: Vec::new(), passes_through, unsolved, bound, steps })
}

/// Where the worst measure of a further solution is not the stored one, or does not pass: what differs, that and the new one.
pub(crate) fn differs(name: &str, stored: f64, new: f64, tolerance: f64) -> Option<(String, f64, f64)> {
    let same = new <= tolerance && (new - stored).abs() <= SAME * tolerance;
    (!same).then(|| (format!("worst measure of {name}"), stored, new))
}

/// The word for a status that is none of an answer.
pub(crate) fn unsolved(status: Status) -> Option<String> {
    matches!(status, Status::Stalled | Status::MaxIterations | Status::NoEquilibrium).then(|| word(status))
}

/// Judges the bound that the summary names by the file that proves it, and holds that against the problem and its answer.
fn check_bound(
    folder: &Path,
    stored: Option<&BoundRecord>,
    problem: &ContactProblem,
    u: &[f64],
    differences: &mut Vec<(String, f64, f64)>,
) -> Result<Option<JudgedBound>, Error> {
    let Some(stored) = stored.filter(|stored| stored.energy.is_some()) else { return Ok(None) };
    let file = folder.join(BOUND);
    let (fields, claim) = read_bound(&file)?;
    let named = |error: Error| {
        let what = format!("{}: {}", error.place, error.what);
        Error::new(file.display().to_string(), what, "solve the case again")
    };
    let mut judged = judge_bound(&fields, &claim).map_err(named)?;
    judged.measures.extend(judge_tie(&fields, problem, u).map_err(named)?);
    // The summary has parts of the least norm the exact stress can have; nothing where it is too coarse to tell.
    let proven = &judged.proven;
    let least = proven.mean_norm - proven.mean_error;
    let mut differ = |name: &str, old: Option<f64>, new: f64| {
        let old = old.unwrap_or(f64::INFINITY);
        if old != new && (old - new).abs() > BOUND_TOLERANCE * (1.0 + new.abs()) {
            differences.push((name.to_string(), old, new));
        }
    };
    let part = |error: f64| if least > 0.0 { error / least } else { f64::INFINITY };
    differ("bound of the error", stored.error, part(proven.error));
    differ("bound of the error of the mean stress", stored.mean_error, part(proven.mean_error));
    let size = proven.energy.iter().fold(0.0, |most: f64, energy| most.max(energy.abs()));
    for (name, end) in [("least energy", 0), ("largest energy", 1)] {
        differ(name, stored.energy.map(|energy| energy[end] / size), proven.energy[end] / size);
    }
    Ok(Some(judged))
}

/// What a summary says of an answer.
pub(crate) struct Stored<'a> {
    pub certificate: &'a CertificateRecord,
    pub bodies: &'a [BodyRecord],
    pub normal_force: f64,
}

impl Stored<'_> {
    pub(crate) fn of(answer: &AnswerRecord) -> Stored<'_> {
        let AnswerRecord { certificate, bodies, contact, .. } = answer;
        Stored { certificate, bodies, normal_force: contact.normal_force }
    }
}

/// What differs between the record of an answer and what was recomputed.
///
/// # Errors
/// If the record lacks a measure of the certificate.
pub(crate) fn compare(stored: &Stored, new: &Certificate, normal_force: f64) -> Result<Vec<(String, f64, f64)>, Error> {
    let old = stored.certificate;
    let mut differences = Vec::new();
    let mut differ = |name: &str, old: f64, new: f64, scale: f64| {
        let same = old == new || (old - new).abs() <= SAME * scale.max(old.abs().max(new.abs()));
        if !same {
            differences.push((name.to_string(), old, new));
        }
    };
    let tolerance = new.tolerance;
    for (name, value) in new.measures() {
        let measure = old.measures.get(name).ok_or_else(|| {
            let what = format!("its certificate has no number `{name}`");
            Error::new("summary.json", what, "the file is damaged or incomplete; solve the case again")
        })?;
        differ(name, measure, value, tolerance);
    }
    differ("worst", old.worst, new.worst, tolerance);
    for (k, part) in new.parts.iter().enumerate() {
        let same = old.parts.get(k).filter(|old| old.part == part.part.name() && old.name == part.name);
        let name = format!("residual of {} {}", part.part.name(), part.name);
        differ(&name, same.map_or(f64::NAN, |old| old.residual), part.residual, new.part_tolerance());
    }
    differ("part_tolerance", old.part_tolerance, new.part_tolerance(), 0.0);
    differ("tolerance", old.tolerance, tolerance, 0.0);
    for (k, new) in new.bodies.iter().enumerate() {
        let old = stored.bodies.get(k);
        let mut differ = |name: &str, old: Option<f64>, new_value: f64, scale: f64| {
            differ(&format!("{name} of body {}", new.name), old.unwrap_or(f64::NAN), new_value, scale);
        };
        differ("force_balance", old.map(|body| body.force_balance), new.balance.force, tolerance);
        differ("moment_balance", old.map(|body| body.moment_balance), new.balance.moment, tolerance);
        let size = new.contact.iter().chain(&new.load).chain(&new.support).fold(0.0, |a: f64, v| a.max(v.abs()));
        for (c, name) in ["contact x", "contact y", "contact z"].into_iter().enumerate() {
            differ(name, old.map(|body| body.contact[c]), new.contact[c], size);
        }
    }
    differ("normal_force", stored.normal_force, normal_force, 0.0);
    differ("passed", f64::from(u8::from(old.passed)), f64::from(u8::from(new.passed)), 0.0);
    Ok(differences)
}
