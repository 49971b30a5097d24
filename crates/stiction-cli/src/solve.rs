//! `stiction solve`.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use stiction::Error;
use stiction::friction::Status;
use stiction::io::case::{self, Case};
use stiction::io::deck::{self, DeckLabels};
use stiction::io::folder;
use stiction::io::text::command_line;
use stiction::linalg::Stop;
use stiction::run::{self, Origin, Outcome, Plan, Prepared, Stage};

use crate::frd::Frd;
use crate::progress::{Mode, Progress};
use crate::{code, hold, interrupt, memory, output, threads};

/// Solve a case and write a folder of results
#[derive(clap::Args)]
pub struct Arguments {
    /// The case file, or a complete deck of CalculiX or Abaqus (.inp)
    case: PathBuf,
    /// Folder of the results; by default the name of the case file with -results, in the current folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Threads; by default one a core. Results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    threads: Option<u16>,
    /// Change a value of the case, as in --set contact.0.friction.coulomb=0.2
    #[arg(long, value_name = "KEY=VALUE", value_parser = key_and_value)]
    set: Vec<(String, String)>,
    /// The method, short for --set solver.method=NAME: newton, alg1, alg2, smalbe, discs, msa1, msa2, cfs1, cfs2
    #[arg(long, value_name = "NAME")]
    method: Option<String>,
    /// Look for further solutions from so many starts, short for --set solver.starts=N
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=10_000))]
    starts: Option<u16>,
    /// Refine the mesh until the error in the energy norm is below this, short for --set accuracy.energy=P%
    #[arg(long, value_name = "P%", allow_hyphen_values = true)]
    accuracy: Option<String>,
    /// A folder outside that of a mesh file from which an .inp may include files; may be given several times
    #[arg(long, value_name = "DIR")]
    include: Vec<PathBuf>,
    /// Go on after the last finished load step, or mesh of a refining run, that the folder holds of the same case
    #[arg(long)]
    resume: bool,
    /// Leave out report.html; `stiction report DIR` writes it later
    #[arg(long)]
    no_report: bool,
    /// Leave out the pictures (PNG)
    #[arg(long)]
    no_pictures: bool,
    /// Also write displacements, stresses, strains, reactions and contact as an .frd file of CalculiX
    #[arg(long, value_name = "FILE")]
    frd: Option<PathBuf>,
    /// How progress is shown, on standard error
    #[arg(long, value_enum, default_value = "auto")]
    progress: Mode,
    /// Print the summary as JSON to standard output, everything else to standard error
    #[arg(long)]
    json: bool,
}

fn key_and_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("write KEY=VALUE, as in solver.tolerance=1e-6")?;
    Ok((key.trim().to_string(), value.to_string()))
}

/// Solves, writes, reports.
pub fn run(arguments: &Arguments) -> Result<u8, Error> {
    threads::start(arguments.threads)?;
    interrupt::watch()?;
    // On a thread of the pool: from any other one every loop would wake the pool and wait for it.
    rayon::scope(|_| solve(arguments))
}

fn solve(arguments: &Arguments) -> Result<u8, Error> {
    let say = if arguments.json { output::note } else { output::out };
    let mut overrides = arguments.set.clone();
    overrides.extend(arguments.method.iter().map(|name| ("solver.method".to_string(), name.clone())));
    overrides.extend(arguments.starts.iter().map(|starts| ("solver.starts".to_string(), starts.to_string())));
    overrides.extend(arguments.accuracy.iter().map(|goal| ("accuracy.energy".to_string(), goal.clone())));
    let (case, path, case_text, labels) = read(arguments, &overrides).map_err(|error| as_typed(arguments, error))?;
    let typed = crate::TYPED.get().into_iter().flatten().skip(1).map(|word| word.to_string_lossy().into_owned());
    let origin = Origin { path, case_text, overrides, command: Some(command_line("stiction", typed)) };
    let folder = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.case));
    hold::folder(&folder)?;
    run::writable(&folder)?;
    let plan = Plan { folder: Some(&folder), resume: arguments.resume, pictures: !arguments.no_pictures };
    let mut showing = Showing { mode: arguments.progress, say, progress: None };
    let mut frd = arguments.frd.as_ref().map(|path| Results::begin(path, labels)).transpose()?;
    let solved = run::solve_case(&case, &plan, &Stop::when(interrupt::asked), None, &mut |stage| {
        if let Some(frd) = &mut frd {
            frd.hear(&stage);
        }
        showing.show(&stage)
    });
    showing.end();
    memory::give_back();
    let (prepared, mut outcome, ahead) = match solved {
        Err(error) if error.interrupted => {
            output::note("interrupted: nothing has been found yet, nothing is written\n");
            return Ok(code::INTERRUPTED);
        }
        solved => solved?,
    };
    let mut files = run::write_with(&prepared, &mut outcome, &origin, &folder, ahead)?;
    if let Some(frd) = frd {
        frd.end(&prepared, &outcome)?;
    }
    let unlisted = if arguments.no_report { None } else { report(&folder, &prepared, &mut files) };
    if cfg!(not(feature = "plots")) {
        output::note("no pictures: they are not built into this program (feature \"plots\")\n");
    }
    say(&format!("\n{}", run::report(&prepared, &outcome)));
    say(&format!("  files        {} in {}\n", files.join(", "), folder.display()));
    if arguments.json {
        output::data(&folder::read_text(&folder.join("summary.json"))?);
    }
    let code = match outcome.solution.status {
        Status::Solved => match outcome.accuracy.as_ref().filter(|accuracy| !accuracy.reached) {
            None => 0,
            Some(accuracy) => {
                let why = accuracy.ended.as_deref().unwrap_or_default();
                output::note(&format!("warning: the accuracy was not reached: {why}; the files hold the last mesh\n"));
                if interrupt::asked() { code::INTERRUPTED } else { code::SHORT }
            }
        },
        Status::Interrupted => code::INTERRUPTED,
        Status::NoEquilibrium => {
            ended_short(&outcome, run::escape_of(&prepared, Status::NoEquilibrium).map(|escape| escape.sentence()))
        }
        Status::PassesThrough => ended_short(&outcome, run::passes_through(&prepared, &outcome)),
        Status::MaxIterations | Status::Stalled | Status::Uncertified => {
            ended_short(&outcome, run::limit_load(&prepared, &outcome))
        }
    };
    unlisted.map_or(Ok(code), Err)
}

/// Says why there is no answer, and returns the exit code.
fn ended_short(outcome: &Outcome, why: Option<String>) -> u8 {
    let t = outcome.steps.last().map(|step| step.t);
    let said = run::ended_short(outcome.solution.status, t, &why.unwrap_or_default());
    said.iter().for_each(|what| output::note(&format!("warning: {what}\n")));
    code::SHORT
}

/// Whether a file is a deck by the ending of its name.
pub(crate) fn is_deck(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("inp"))
}

/// The same error at the option that stands for `--set`.
fn as_typed(arguments: &Arguments, error: Error) -> Error {
    let starts = arguments.starts.map(|starts| starts.to_string());
    let options = [
        ("method", "solver.method", arguments.method.as_ref()),
        ("starts", "solver.starts", starts.as_ref()),
        ("accuracy", "accuracy.energy", arguments.accuracy.as_ref()),
    ];
    let typed = options.into_iter().find_map(|(option, key, value)| {
        let value = value?;
        (error.place == format!("--set {key}={value}")).then(|| format!("--{option} {value}"))
    });
    Error { place: typed.unwrap_or(error.place), ..error }
}

/// The case, its file if it is a case file, its text, and the numbers that a deck gives its nodes and cells.
type CaseRead = (Case, Option<PathBuf>, String, DeckLabels);

/// The .frd file that `--frd` asks for.
struct Results {
    path: PathBuf,
    frd: Frd,
    /// The first error, if there was one.
    failed: Option<Error>,
}

impl Results {
    fn begin(path: &Path, labels: DeckLabels) -> Result<Results, Error> {
        Ok(Results { path: path.to_path_buf(), frd: Frd::whole(path, labels)?, failed: None })
    }

    /// Adds the answer of an increment; a finer mesh begins the file again.
    fn hear(&mut self, stage: &Stage) {
        let done = match stage {
            Stage::Posed(_, level) if *level > 0 => {
                Frd::whole(&self.path, DeckLabels::default()).map(|frd| self.frd = frd)
            }
            Stage::Step(prepared, step) => self.frd.add(prepared, step.outcome, step.records.last()),
            _ => Ok(()),
        };
        self.failed = self.failed.take().or(done.err());
    }

    fn end(mut self, prepared: &Prepared, outcome: &Outcome) -> Result<(), Error> {
        if let Some(error) = self.failed {
            return Err(error);
        }
        if outcome.steps.is_empty() {
            self.frd.add(prepared, outcome, None)?;
        }
        self.frd.end()
    }
}

/// The case with what is known of where it comes from.
fn read(arguments: &Arguments, overrides: &[(String, String)]) -> Result<CaseRead, Error> {
    let path = &arguments.case;
    if is_deck(path) {
        let deck = deck::read(path, &arguments.include)?;
        return Ok((deck.case(overrides)?, None, deck.text, deck.labels));
    }
    let mut case = case::read(path, overrides)?;
    case.mesh.include_from(&arguments.include);
    Ok((case, Some(path.clone()), std::fs::read_to_string(path).unwrap_or_default(), DeckLabels::default()))
}

/// What is said while a case is solved.
struct Showing {
    mode: Mode,
    say: fn(&str),
    progress: Option<Progress>,
}

impl Showing {
    fn show(&mut self, stage: &Stage) -> ControlFlow<()> {
        match stage {
            Stage::Posing => self.running().say("reading and assembling".into()),
            Stage::Posed(facts, level) => {
                self.end();
                if *level == 0 {
                    (self.say)(&facts.to_string());
                }
                interrupt::heard();
            }
            Stage::Event(event) => self.running().show(event),
            Stage::Step(..) => {}
            Stage::Level(level) => {
                self.line(&run::level_line(level));
                memory::give_back();
            }
            Stage::Note(text) => self.line(text),
            Stage::Warning(text) => {
                self.end();
                output::note(&format!("warning: {text}\n"));
            }
        }
        ControlFlow::Continue(())
    }

    fn running(&mut self) -> &Progress {
        self.progress.get_or_insert_with(|| Progress::new(self.mode))
    }

    fn line(&mut self, text: &str) {
        self.end();
        (self.say)(&format!("{text}\n"));
    }

    /// Takes a moving line away.
    fn end(&mut self) {
        self.progress.take().iter().for_each(Progress::finish);
    }
}

#[cfg(feature = "report")]
fn report(folder: &Path, prepared: &Prepared, files: &mut Vec<String>) -> Option<Error> {
    let error = match run::write_report_on(folder, Some(&prepared.mesh)) {
        Ok(_) => {
            files.push(run::REPORT.into());
            return None;
        }
        Err(error) => error,
    };
    // The results are whole without it, and not with one that could neither be listed nor removed.
    let unlisted = folder.join(run::REPORT).exists();
    if !unlisted {
        output::note(&format!("warning: {} was not written: {error}\n", run::REPORT));
    }
    unlisted.then_some(error)
}

#[cfg(not(feature = "report"))]
fn report(_: &Path, _: &Prepared, _: &mut [String]) -> Option<Error> {
    output::note("no report.html: it is not built into this program (feature \"report\")\n");
    None
}

fn default_folder(case: &Path) -> PathBuf {
    let stem = case.file_stem().map_or("case".into(), |stem| stem.to_string_lossy().into_owned());
    PathBuf::from(stem + "-results")
}
