//! Kills runs of the command, tells them to stop, fills and breaks their disk, and looks at what stands afterwards and what
//! comes of going on from it.
//!
//! Usage: `bench/campaigns/faults [--seed S] [--count N]`, 2000 disturbed runs if absent. The exit code is 1 if something
//! did not hold. Faults at a call are the same for the same seed, those at a time are not.

use std::error::Error;
use std::process::ExitCode;

use stiction_fixtures::campaign::{command, seed_and_count};
use stiction_fixtures::faults;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let (seed, count) = seed_and_count(2000)?;
    let report = faults::campaign(&command()?, seed, count);
    println!("{} disturbed runs", report.runs.values().sum::<usize>());
    report.runs.iter().for_each(|(kind, number)| println!("  {number:5} {kind}"));
    report.findings.iter().for_each(|finding| println!("  FOUND: {finding}"));
    println!("{} findings", report.findings.len());
    Ok(if report.findings.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
