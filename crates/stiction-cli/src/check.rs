//! `stiction check`.

use std::path::PathBuf;

use stiction::Error;
use stiction::certificate::JudgedBound;
use stiction::io::text::measure;
use stiction::run;

use crate::{code, output};

/// Recompute the certificate of a result folder from its files alone, and compare all files with their checksums
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder that `stiction solve` wrote
    folder: PathBuf,
}

/// Judges anew and compares with the summary.
pub fn run(arguments: &Arguments) -> Result<u8, Error> {
    let checked = run::check(&arguments.folder)?;
    let certificate = &checked.certificate;
    let tolerance = certificate.tolerance;
    let mut text = format!("certificate of {}, tolerance {tolerance:e}\n", arguments.folder.display());
    for (name, value) in certificate.measures() {
        let verdict = if value <= tolerance { "" } else { "  exceeds the tolerance" };
        text += &format!("  {:<17} {}{verdict}\n", name.replace('_', " "), measure(value));
    }
    for (name, old, new) in &checked.differences {
        text += &format!("  summary.json says {} = {old:e}, recomputed {new:e}\n", name.replace('_', " "));
    }
    for step in &checked.steps {
        let passed = if step.certificate.passed { "" } else { ", which exceeds the tolerance" };
        let (t, worst) = (step.t, step.certificate.worst);
        text += &format!("  step {:<4} t = {t:<10} worst measure {}{passed}\n", step.number, measure(worst));
        for (name, old, new) in &step.differences {
            text += &format!("    {}: recorded {old:e}, recomputed {new:e}\n", name.replace('_', " "));
        }
    }
    for (name, what) in &checked.files {
        text += &format!("  {name} is {what}\n");
    }
    let steps_agree = checked.steps.iter().all(|step| step.differences.is_empty());
    let all_pass = certificate.passed && checked.steps.iter().all(|step| step.certificate.passed);
    for what in &checked.passes_through {
        text += &format!("  {what}\n");
    }
    if let Some(status) = &checked.unsolved {
        text += &format!("  the run ended with the status {status}\n");
    }
    for missed in checked.bound.iter().flat_map(|bound| &bound.measures).filter(|measure| !measure.is_met()) {
        text += &format!("  bound.npz: {} missed by {:.1e}, {}\n", missed.name, missed.value, missed.place);
    }
    let is_proven = checked.bound.as_ref().is_none_or(JudgedBound::passed);
    if let (Some(bound), true) = (&checked.bound, is_proven) {
        text += &format!(
            "  the bound of the discretisation error is proven: {:.4e} of a norm of the mean stress of {:.4e}\n",
            bound.proven.error, bound.proven.mean_norm
        );
    }
    let as_written = checked.files.is_empty();
    text += match (all_pass, checked.differences.is_empty() && steps_agree) {
        (true, true) if !checked.passes_through.is_empty() => {
            "failed: the result solves its problem, but surfaces pass through each other, as its summary says\n"
        }
        (true, true) if !is_proven => {
            "failed: the result solves its problem, but bound.npz does not prove the bound of the discretisation error\n"
        }
        (true, true) if !as_written => {
            "failed: the result solves its problem, but files of the folder are not as they were written; solve the case \
             again, or write report.html again with `stiction report` if it is the only one\n"
        }
        (true, true) if checked.unsolved.is_some() => {
            "failed: the measures are met, but the run has found no answer, as its summary says\n"
        }
        (true, true) => "passed: the result solves its problem to the tolerance, as its summary says\n",
        (true, false) => "failed: the result solves its problem, but its summary says something else\n",
        (false, true) => "failed: the result does not solve its problem to the tolerance, as its summary says\n",
        (false, false) => "failed: the result does not solve its problem to the tolerance\n",
    };
    output::out(&text);
    Ok(if checked.passed() { 0 } else { code::SHORT })
}
