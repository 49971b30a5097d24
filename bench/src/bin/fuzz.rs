//! Fuzzes the readers for a time each and writes what it finds.
//!
//! Usage: `cargo run --release -p stiction-bench --bin fuzz -- --seconds N [--seed S] [--only NAME] [FOLDER...]`. Files
//! in the folders with the ending of a reader, below 64 kB, join its seeds. Findings go to `fuzz-findings/`; the exit
//! code is 1 if there are any. The same seed and count of executions make the same files.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use cpu_time::ProcessTime;
use stiction_fixtures::counting::Counting;
use stiction_fixtures::fuzz;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const LARGEST_SEED: u64 = 1 << 16;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let (mut seconds, mut number, mut only, mut folders) = (60.0, 0u64, None, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--seconds" => seconds = value()?.parse()?,
            "--seed" => number = value()?.parse()?,
            "--only" => only = Some(value()?),
            _ => folders.push(PathBuf::from(argument)),
        }
    }
    // Panics are counted; their messages would bury the table.
    std::panic::set_hook(Box::new(|_| {}));
    println!("| reader | seeds | executions | still read | memory / file | slowest | findings |");
    println!("|---|---|---|---|---|---|---|");
    let mut found = 0;
    for target in fuzz::TARGETS.iter().filter(|t| only.as_ref().is_none_or(|name| name == t.name)) {
        let mut seeds = (target.seeds)();
        for folder in &folders {
            for entry in std::fs::read_dir(folder)? {
                let entry = entry?;
                let ending = entry.path().extension().is_some_and(|e| e == target.ending);
                if ending && entry.metadata()?.len() < LARGEST_SEED {
                    seeds.push(std::fs::read(entry.path())?);
                }
            }
        }
        let start = ProcessTime::now();
        let enough = |n: usize| n.is_multiple_of(64) && start.elapsed().as_secs_f64() > seconds;
        let report = fuzz::fuzz(target, &seeds, number, &enough);
        println!(
            "| {} | {} | {} | {:.1} % | {:.1} | {:.1?} | {} |",
            target.name,
            seeds.len(),
            report.executions,
            100.0 * report.read as f64 / report.executions as f64,
            report.memory,
            report.slowest,
            report.findings.len()
        );
        for (k, (what, file)) in report.findings.iter().take(20).enumerate() {
            std::fs::create_dir_all("fuzz-findings")?;
            let path = format!("fuzz-findings/{}-{number}-{k}.{}", target.name, target.ending);
            std::fs::write(&path, file)?;
            println!("  {path}: {what}");
        }
        found += report.findings.len();
    }
    Ok(if found == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
