//! Changes numbers in result folders, or swaps files between load steps, and counts what `check` does not notice.
//!
//! Usage: `cargo run --release -p stiction-bench --bin tampering -- [--seed S] [--count N]`, 5000 changes if absent, half of
//! them in a folder with load steps. The exit code is 1 if a change was not noticed. The same seed makes the same changes.

use std::error::Error;
use std::process::ExitCode;

use stiction_fixtures::campaign::seed_and_count;
use stiction_fixtures::case_run::CASE;
use stiction_fixtures::folder::Folder;
use stiction_fixtures::tamper;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let (seed, count) = seed_and_count(5000)?;
    let mut unnoticed = 0;
    for (what, text, count) in
        [("static", CASE.to_string(), count / 2), ("stepped", tamper::stepped_case(), count - count / 2)]
    {
        let folder = Folder::new("tampering");
        tamper::solve_into(&text, &folder.path);
        let report = tamper::campaign(&folder.path, seed, count);
        println!("{what}: {count} changes, {} not noticed", report.unnoticed.len());
        report.changes.iter().for_each(|(kind, number)| println!("  {number:5} {kind}"));
        report.unnoticed.iter().for_each(|change| println!("  NOT NOTICED: {change}"));
        unnoticed += report.unnoticed.len();
    }
    Ok(if unnoticed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
