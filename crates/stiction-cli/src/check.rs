//! `stiction check`.

use std::path::PathBuf;

use stiction::Error;
use stiction::run;

use crate::{code, output};

/// Recompute the certificate of a result folder from its files alone
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
        text += &format!("  {:<17} {value:.1e}{verdict}\n", name.replace('_', " "));
    }
    for (name, old, new) in &checked.differences {
        text += &format!("  summary.json says {} = {old:e}, recomputed {new:e}\n", name.replace('_', " "));
    }
    text += match (certificate.passed, checked.differences.is_empty()) {
        (true, true) => "passed: the result solves its problem to the tolerance, as its summary says\n",
        (true, false) => "failed: the result solves its problem, but its summary says something else\n",
        (false, true) => "failed: the result does not solve its problem to the tolerance, as its summary says\n",
        (false, false) => "failed: the result does not solve its problem to the tolerance\n",
    };
    output::out(&text);
    Ok(if checked.passed() { 0 } else { code::SHORT })
}
