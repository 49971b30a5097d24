//! A result folder judged anew.

use std::path::Path;

use serde_json::Value;

use super::check_steps::{CheckedStep, check_steps};
use crate::Error;
use crate::certificate::{Certificate, certify};
use crate::io::{folder, problem};

/// What a folder's files amount to.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// Recomputed from `problem.npz` and `solution.npz`.
    pub certificate: Certificate,
    /// Where `summary.json` says something else: name, what it says, what was recomputed.
    pub differences: Vec<(String, f64, f64)>,
    /// The load steps, if it is a stepped run; the last is what the rest speaks of.
    pub steps: Vec<CheckedStep>,
}

impl Checked {
    /// Whether the certificate passes and the summary tells the same.
    pub fn passed(&self) -> bool {
        let steps = self.steps.iter().all(|step| step.certificate.passed && step.differences.is_empty());
        self.certificate.passed && self.differences.is_empty() && steps
    }
}

/// Two values of a measure agree if they differ by no more than this part of the larger or of the tolerance: what
/// the order of additions can change, and far less than would matter.
const SAME: f64 = 1e-3;

/// Recomputes the certificate of the result in `folder` from its problem and solution, and compares it with its
/// summary.
///
/// # Errors
/// If a file is missing, damaged, or does not fit the others.
pub fn check(folder: &Path) -> Result<Checked, Error> {
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
    let (mut problem, tolerance) = problem::read_problem(&file)?;
    let (u, lambda) = problem::read_solution(&folder.join("solution.npz"), &problem)?;
    let certificate = certify(&problem, &u, &lambda, tolerance);
    let path = folder.join("summary.json");
    let read = |text: String| serde_json::from_str(&text).map_err(|e| damaged(format!("this is not a summary ({e})")));
    let place = |error: Error| error.at(&path.display().to_string());
    let summary: Value = folder::read_text(&path).and_then(|text| read(text).map_err(place))?;
    let stored = stored_certificate(&summary).map_err(place)?;
    let normal_force: f64 = lambda.iter().zip(&problem.labels.share).map(|(force, share)| share * force).sum();
    let differences = compare(stored, &certificate, normal_force)?;
    let steps = match summary["steps"].as_array() {
        Some(entries) => check_steps(folder, entries, &mut problem, tolerance)?,
        None => Vec::new(),
    };
    Ok(Checked { certificate, differences, steps })
}

fn damaged(what: impl Into<String>) -> Error {
    Error::new("", what, "the file is damaged or incomplete; solve the case again")
}

/// The summary, or an entry of its steps, if there is a certificate in it.
pub(crate) fn stored_certificate(summary: &Value) -> Result<&Value, Error> {
    if !summary["certificate"].is_object() || !summary["contact"].is_object() {
        return Err(damaged("there is no certificate in it"));
    }
    Ok(summary)
}

pub(crate) fn compare(summary: &Value, new: &Certificate, normal_force: f64) -> Result<Vec<(String, f64, f64)>, Error> {
    // Infinities are written as null.
    let number = |value: &Value| if value.is_null() { Some(f64::INFINITY) } else { value.as_f64() };
    let stored = |name: &str| {
        let value = summary["certificate"].get(name).and_then(number);
        value.ok_or_else(|| damaged(format!("its certificate has no number `{name}`")).at("summary.json"))
    };
    let tolerance = new.tolerance;
    let mut differences = Vec::new();
    let mut differ = |name: &str, old: f64, new: f64, scale: f64| {
        let same = old == new || (old - new).abs() <= SAME * scale.max(old.abs().max(new.abs()));
        if !same {
            differences.push((name.to_string(), old, new));
        }
    };
    for (name, value) in new.measures().into_iter().chain([("worst", new.worst)]) {
        differ(name, stored(name)?, value, new.tolerance);
    }
    differ("tolerance", stored("tolerance")?, new.tolerance, 0.0);
    for (body, new) in new.bodies.iter().enumerate().map(|(k, b)| (&summary["bodies"][k], b)) {
        let told = |name: &str| body.get(name).and_then(number).unwrap_or(f64::NAN);
        let named = |name: &str| format!("{name} of body {}", new.name);
        differ(&named("force_balance"), told("force_balance"), new.balance.force, tolerance);
        differ(&named("moment_balance"), told("moment_balance"), new.balance.moment, tolerance);
        let size = new.contact.iter().chain(&new.load).chain(&new.support).fold(0.0, |a: f64, v| a.max(v.abs()));
        for c in 0..3 {
            let told = body["contact"][c].as_f64().unwrap_or(f64::NAN);
            differ(&named(["contact x", "contact y", "contact z"][c]), told, new.contact[c], size);
        }
    }
    let told = |name: &str| summary["contact"].get(name).and_then(number).unwrap_or(f64::NAN);
    differ("normal_force", told("normal_force"), normal_force, 0.0);
    let passed = summary["certificate"]["passed"].as_bool();
    differ("passed", passed.map_or(f64::NAN, |p| f64::from(u8::from(p))), f64::from(u8::from(new.passed)), 0.0);
    Ok(differences)
}
