//! The program `stiction-mpi`: a case on the ranks of MPI.

mod memory;
mod mpi;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use clap::{Parser, Subcommand, ValueEnum};
use mpi::Mpi;
use stiction::friction::Status;
use stiction::io::case::{self, Case};
use stiction::io::folder::read_text;
use stiction::io::lock::Lock;
use stiction::io::text::{command_line, plain};
use stiction::ranks::{Ranks, agree};
use stiction::run::{
    ForPeople, Keep, Origin, REPORT, Stage, case_of_deck, level_line, solve_steps_on_ranks, write_on_ranks,
};
use stiction::{Error, Progress};

/// Certified elastic contact with friction in 3D, on several machines: mpirun -n N stiction-mpi solve CASE.toml
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Solve a case and write a folder of results, which all ranks have to see
    Solve(Solve),
}

#[derive(clap::Args)]
struct Solve {
    /// The case file, which all ranks have to see, or a complete deck of CalculiX or Abaqus (.inp), which rank 0 reads
    case: PathBuf,
    /// Folder of the results; by default the name of the case file with -results, in the current folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Threads of each rank; by default one for each core it is bound to, and one where ranks are not bound
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    threads: Option<u16>,
    /// Change a value of the case, as in --set contact.0.friction.coulomb=0.2
    #[arg(long, value_name = "KEY=VALUE", value_parser = key_and_value)]
    set: Vec<(String, String)>,
    /// Refine the mesh until the error in the energy norm is below this, short for --set accuracy.energy=P%
    #[arg(long, value_name = "P%")]
    accuracy: Option<String>,
    /// A folder outside that of a mesh file from which an .inp may include files; may be given several times
    #[arg(long, value_name = "DIR")]
    include: Vec<PathBuf>,
    /// Go on after the last finished load step, or mesh of a refining run, that the folder of results holds, on any number of ranks
    #[arg(long)]
    resume: bool,
    /// Leave out report.html; `stiction report DIR` writes it later
    #[arg(long)]
    no_report: bool,
    /// Leave out the pictures (PNG)
    #[arg(long)]
    no_pictures: bool,
    /// How progress is shown, on standard error
    #[arg(long, value_enum, default_value = "auto")]
    progress: Mode,
    /// Print the summary as JSON to standard output, everything else to standard error
    #[arg(long)]
    json: bool,
}

/// How progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Mode {
    /// As plain
    Auto,
    /// One line a cycle
    Plain,
    None,
}

fn key_and_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("write KEY=VALUE, as in solver.tolerance=1e-6")?;
    Ok((key.trim().to_string(), value.to_string()))
}

/// Exit codes, those of `stiction`.
const SHORT: u8 = 1;
const REFUSED: u8 = 2;

fn main() -> ExitCode {
    let mpi = match Mpi::start() {
        Ok(mpi) => Arc::new(mpi),
        Err(what) => {
            eprintln!("error: {what}");
            return REFUSED.into();
        }
    };
    memory::end_without_memory();
    let code = run(&mpi);
    mpi.finish();
    code.into()
}

fn run(mpi: &Arc<Mpi>) -> u8 {
    let first = mpi.rank() == 0;
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // All ranks have the same arguments: one of them says what is wrong with them.
            if first {
                // Nothing can be done about a terminal that is gone.
                let _ = error.print();
            }
            return if error.use_stderr() { REFUSED } else { 0 };
        }
    };
    let Command::Solve(arguments) = arguments.command;
    let ranks: Arc<dyn Ranks> = mpi.clone();
    match solve(&arguments, &ranks) {
        Ok(code) => code,
        Err(error) => {
            if first {
                eprintln!("error: {error}");
            }
            REFUSED
        }
    }
}

fn solve(arguments: &Solve, ranks: &Arc<dyn Ranks>) -> Result<u8, Error> {
    let first = ranks.rank() == 0;
    agree(&**ranks, start_threads(arguments.threads, ranks.size()))?;
    let mut set = arguments.set.clone();
    set.extend(arguments.accuracy.iter().map(|goal| ("accuracy.energy".to_string(), goal.clone())));
    let (case, path, case_text) = read(arguments, &set, ranks).map_err(|error| as_typed(arguments, error))?;
    let origin = Origin { path, case_text, overrides: set, command: Some(command_line("stiction-mpi", typed())) };
    let folder = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.case));
    let lock = if first { Lock::take(&folder).map(Some) } else { Ok(None) };
    let lock = agree(&**ranks, lock)?;
    if let Some((_, Some(note))) = &lock {
        eprintln!("{note}");
    }
    let mut observer = |progress: &Progress| {
        if first && arguments.progress != Mode::None {
            let Progress { iteration, residual, open, stick, slip, .. } = progress;
            eprintln!("  cycle {iteration:>3}  residual {residual:.1e}  open {open}  stick {stick}  slip {slip}");
        }
        ControlFlow::Continue(())
    };
    let say: fn(&str) = if arguments.json { note } else { out };
    let tell: fn(&Stage) =
        if arguments.json { |stage: &Stage| show(stage, note) } else { |stage: &Stage| show(stage, out) };
    let keep = Keep { folder: folder.clone(), resume: arguments.resume, tell };
    let mut answer = solve_steps_on_ranks(&case, ranks, Some(&keep), &mut observer)?;
    let wanted = ForPeople { pictures: !arguments.no_pictures, report: !arguments.no_report };
    let written = write_on_ranks(&mut answer, &folder, &origin, wanted, &**ranks)?;
    if first {
        say(&format!("\n{}", answer.summary));
        if let Some(error) = &written.without_report {
            note(&format!("warning: {REPORT} was not written: {error}\n"));
        }
        say(&format!("  files        {} in {}\n", written.files.join(", "), folder.display()));
        if arguments.json {
            print(std::io::stdout(), &read_text(&folder.join("summary.json"))?);
        }
        answer.summary.ended_short().iter().for_each(|what| note(&format!("warning: {what}\n")));
    }
    let missed = answer.summary.accuracy.as_ref().filter(|accuracy| !accuracy.reached);
    if let Some(accuracy) = missed.filter(|_| first) {
        let why = accuracy.ended.as_deref().unwrap_or_default();
        eprintln!("warning: the accuracy was not reached: {why}; the files hold the last mesh");
    }
    Ok(if answer.summary.answer.status == Status::Solved && missed.is_none() { 0 } else { SHORT })
}

/// The case, with the same words at all ranks; the file, if it is one of a case, and its text.
fn read(
    arguments: &Solve,
    set: &[(String, String)],
    ranks: &Arc<dyn Ranks>,
) -> Result<(Case, Option<PathBuf>, String), Error> {
    let path = &arguments.case;
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("inp")) {
        let (case, text) = case_of_deck(path, &arguments.include, set, &**ranks)?;
        return Ok((case, None, text));
    }
    let mut case = agree(&**ranks, case::read(path, set))?;
    case.mesh.include_from(&arguments.include);
    Ok((case, Some(path.clone()), std::fs::read_to_string(path).unwrap_or_default()))
}

/// What was typed behind the name of the program.
fn typed() -> impl Iterator<Item = String> {
    std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned())
}

fn show(stage: &Stage, say: fn(&str)) {
    match stage {
        Stage::Level(level) => say(&format!("{}\n", level_line(level))),
        Stage::Posed(facts, _) => say(&facts.to_string()),
        Stage::Note(what) => say(&format!("{what}\n")),
        Stage::Warning(what) => note(&format!("warning: {what}\n")),
        _ => {}
    }
}

/// Prints to standard output; names in the text command no terminal.
fn out(text: &str) {
    print(std::io::stdout(), &plain(text));
}

/// Prints to standard error, likewise.
fn note(text: &str) {
    print(std::io::stderr(), &plain(text));
}

/// A reader that has gone away is no reason to fail: the results are in the folder.
fn print(mut to: impl std::io::Write, text: &str) {
    let _ = to.write_all(text.as_bytes()).and_then(|()| to.flush());
}

/// The same error at the option that stands for `--set`.
fn as_typed(arguments: &Solve, error: Error) -> Error {
    match &arguments.accuracy {
        Some(goal) if error.place == format!("--set accuracy.energy={goal}") => {
            Error { place: format!("--accuracy {goal}"), ..error }
        }
        _ => error,
    }
}

/// Starts the pool of this rank. Launchers bind a rank to its cores, and as many threads are its own; where they do
/// not, every rank sees all cores, and threads of several ranks would share them.
fn start_threads(asked: Option<u16>, ranks: usize) -> Result<(), Error> {
    let seen = std::thread::available_parallelism().map_or(1, usize::from);
    let shared = ranks > 1 && seen > 1 && seen == online();
    let count = asked.map_or(if shared { 1 } else { seen }, usize::from);
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build_global()
        .map_err(|error| Error::new("--threads", format!("{count} threads cannot be had ({error})"), "ask for fewer"))
}

/// The cores of this machine.
fn online() -> usize {
    // SAFETY: reads a number of the system.
    usize::try_from(unsafe { libc::sysconf(libc::_SC_NPROCESSORS_ONLN) }).unwrap_or(1)
}

fn default_folder(case: &Path) -> PathBuf {
    let stem = case.file_stem().map_or("case".into(), |stem| stem.to_string_lossy().into_owned());
    PathBuf::from(stem + "-results")
}
