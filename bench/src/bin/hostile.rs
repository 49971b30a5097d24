//! Solves cases with hostile titles and names, and looks at messages, reports, and reports in a browser.
//!
//! Usage: `bench/campaigns/hostile [--seed S] [--count N]`, 500 cases if absent; `STICTION_BROWSER` names the browser,
//! `chromium` if it is not set. The exit code is 1 if something did not hold. The same seed makes the same cases.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use stiction_fixtures::campaign::{command, seed_and_count};
use stiction_fixtures::hostile;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let (seed, count) = seed_and_count(500)?;
    let browser = std::env::var_os("STICTION_BROWSER").map_or_else(|| PathBuf::from("chromium"), PathBuf::from);
    let report = hostile::campaign(&command()?, Some(&browser), seed, count);
    let hostile::Report { cases, solved, browsed, findings } = report;
    findings.iter().for_each(|finding| println!("  FOUND: {finding}"));
    println!("{cases} cases, {solved} solved, {browsed} opened in a browser, {} findings", findings.len());
    Ok(if findings.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
