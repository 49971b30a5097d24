//! `stiction ccx`: solves a deck as `ccx` is called, with the files that programs around CalculiX read.
//!
//! FreeCAD calls `ccx -i JOB`, PrePoMax `ccx JOB`; both read `JOB.frd` and `JOB.dat` and take what stands on standard error for a
//! failure. `ccx -v` tells a version, and `ccx` alone has to name CalculiX.

mod files;
mod tables;

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use stiction::Error;
use stiction::friction::Status;
use stiction::io::deck;
use stiction::linalg::Stop;
use stiction::run::{self, Plan, Stage};

use self::files::Files;
use crate::{interrupt, output, threads};

/// Solve the deck JOB.inp as ccx does: writes JOB.frd, JOB.dat, JOB.sta and JOB.cvg
///
/// Called through a link named ccx, the program behaves as this command. Exit code 0 where the answer is certified, 201 otherwise.
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub struct Arguments {
    /// -i JOB, or JOB: the deck without its ending; -v: the version of ccx whose interface this is
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "[-i] JOB")]
    words: Vec<String>,
}

/// What `ccx` ends with where a deck is not solved.
const FAILED: u8 = 201;
/// The version of CalculiX whose decks and files these are.
const VERSION: &str = "2.20";

const USAGE: &str = "Usage: ccx -i JOB, for a deck JOB.inp of CalculiX (solved by stiction)\n";
const HELP: &str = "
Writes JOB.frd, JOB.dat, JOB.sta and JOB.cvg beside the deck. `stiction ccx -i JOB` does the same as the program called
through a link named ccx.

  -i JOB, JOB      the deck without its ending
  -v, --version    the version of CalculiX whose decks and files these are
  -h, --help       this text

OMP_NUM_THREADS sets the threads. The exit code is 0 where the answer is certified, 201 otherwise.
";

/// What the words ask for.
enum Asked {
    Job(PathBuf),
    Version,
    Usage,
    Help,
}

fn asked(words: &[String]) -> Result<Asked, Error> {
    // FreeCAD gives "-i " with a blank.
    let words: Vec<&str> = words.iter().map(|word| word.trim()).collect();
    match words[..] {
        [] => Ok(Asked::Usage),
        ["-h" | "--help"] => Ok(Asked::Help),
        ["-v" | "--version"] => Ok(Asked::Version),
        ["-i", job] => Ok(Asked::Job(job.into())),
        [job] if !job.starts_with('-') => Ok(Asked::Job(job.into())),
        [word, ..] => Err(Error::new("", format!("{word:?} is not understood"), "write ccx -i JOB, or ccx JOB")),
    }
}

/// Whether the program is called through a link named `ccx`.
pub fn is_meant(program: Option<&std::ffi::OsStr>) -> bool {
    let stem = program.and_then(|program| std::path::Path::new(program).file_stem());
    stem.is_some_and(|stem| stem.eq_ignore_ascii_case("ccx"))
}

/// Goes the way from the words behind `ccx` to an exit code.
pub fn called(words: Vec<String>) -> u8 {
    run(&Arguments { words })
}

/// Solves the deck. What fails is said on standard output, as `ccx` does.
pub fn run(arguments: &Arguments) -> u8 {
    match asked(&arguments.words) {
        Ok(Asked::Usage) => {
            output::out(USAGE);
            FAILED
        }
        Ok(Asked::Help) => {
            output::out(&format!("{USAGE}{HELP}"));
            0
        }
        Ok(Asked::Version) => {
            let version = env!("CARGO_PKG_VERSION");
            output::out(&format!(
                "\nThis is Version {VERSION} of the interface of CalculiX, solved by stiction {version}\n\n"
            ));
            0
        }
        Ok(Asked::Job(job)) => solved(&job).unwrap_or_else(|error| failed(&error)),
        Err(error) => failed(&error),
    }
}

fn failed(error: &Error) -> u8 {
    let place = if error.place.is_empty() { String::new() } else { format!("{}: ", error.place) };
    let excerpt: String = error.excerpt.lines().map(|line| format!("        {line}\n")).collect();
    let remedy = if error.remedy.is_empty() { String::new() } else { format!("        {}\n", error.remedy) };
    output::out(&format!(" *ERROR in stiction: {place}{}\n{excerpt}{remedy}", error.what));
    FAILED
}

/// Threads as `ccx` is told them.
fn threads_asked() -> Option<u16> {
    let count = std::env::var("OMP_NUM_THREADS").ok()?.trim().parse().ok()?;
    (1..=4096).contains(&count).then_some(count)
}

fn solved(job: &std::path::Path) -> Result<u8, Error> {
    let began = Instant::now();
    let job = match job.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("inp") => job.with_extension(""),
        _ => job.to_path_buf(),
    };
    threads::start(threads_asked())?;
    interrupt::watch()?;
    output::out("\n stiction solves this deck in place of CalculiX\n\n");
    let deck = deck::read(&files::beside(&job, "inp"), &[])?;
    deck.notes.iter().for_each(|note| output::out(&format!(" *INFO: {note}\n")));
    let case = deck.case(&[])?;
    let mut files = Files::begin(&job, &deck)?;
    files.unanswered().iter().for_each(|what| output::out(&format!(" *INFO: {what}\n")));
    let plan = Plan { folder: None, resume: false, pictures: false };
    let mut lost = None;
    let mut tell = |stage: Stage| {
        match stage {
            Stage::Step(prepared, step) => {
                output::out(&format!(
                    "\n increment {} at the time {}\n",
                    step.number,
                    step.records.last().map_or(0.0, |r| r.t)
                ));
                lost = lost.take().or(files.add(prepared, step.outcome, step.records.last()).err());
            }
            Stage::Posed(facts, _) => {
                output::out(&format!("\n{facts}\n Static analysis was selected\n"));
                interrupt::heard();
            }
            Stage::Note(text) => output::out(&format!(" *INFO: {text}\n")),
            Stage::Warning(text) => output::out(&format!(" *WARNING: {text}\n")),
            Stage::Posing | Stage::Event(_) | Stage::Level(_) => {}
        }
        ControlFlow::Continue(())
    };
    // On a thread of the pool: from any other one every loop would wake the pool and wait for it.
    let answer = rayon::scope(|_| run::solve_case(&case, &plan, &Stop::when(interrupt::asked), None, &mut tell));
    let (prepared, outcome, _) = answer?;
    if let Some(error) = lost {
        return Err(error);
    }
    if outcome.steps.is_empty() {
        files.add(&prepared, &outcome, None)?;
    }
    files.end()?;
    output::out(&format!("\n{}\n", run::report(&prepared, &outcome)));
    if outcome.solution.status == Status::Solved {
        output::out("\n Job finished\n\n");
    } else {
        output::out("\n *ERROR in stiction: the answer is not certified, see above\n\n");
    }
    output::out(&format!(
        "________________________________________\n\nTotal CalculiX Time: {:.6}\n________________________________________\n",
        began.elapsed().as_secs_f64()
    ));
    Ok(if outcome.solution.status == Status::Solved { 0 } else { FAILED })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(words: &[&str]) -> Result<Asked, Error> {
        asked(&words.iter().map(|word| word.to_string()).collect::<Vec<_>>())
    }

    #[test]
    fn programs_call_it_in_their_own_ways() {
        for call in [&["-i ", "box"][..], &["-i", "box"], &["box"]] {
            assert!(matches!(words(call), Ok(Asked::Job(job)) if job.as_os_str() == "box"), "{call:?}");
        }
        assert!(matches!(words(&["-v"]), Ok(Asked::Version)) && matches!(words(&[]), Ok(Asked::Usage)));
        assert!(words(&["-o", "exo", "box"]).is_err());
        assert!(is_meant(Some("/usr/bin/ccx".as_ref())) && is_meant(Some("CCX.exe".as_ref())));
        assert!(!is_meant(Some("stiction".as_ref())) && !is_meant(None));
    }
}
