//! `stiction solve`.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use stiction::Error;
use stiction::friction::Status;
use stiction::io::case::{self, AccuracySpec, Case};
use stiction::io::folder;
use stiction::linalg::Stop;
use stiction::run::{
    self, Ahead, Event, Indicators, Level, LevelRecord, Origin, Outcome, Prepared, Restart, Settings, SolvedLevel, Step,
};

use crate::progress::{Mode, Progress};
use crate::{code, hold, interrupt, memory, output, threads};

/// Solve a case and write a folder of results
#[derive(clap::Args)]
pub struct Arguments {
    /// The case file
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
    #[arg(long, value_name = "P%")]
    accuracy: Option<String>,
    /// A folder outside that of a mesh file from which an .inp may include files; may be given several times
    #[arg(long, value_name = "DIR")]
    include: Vec<PathBuf>,
    /// Go on after the last finished load step that the folder holds of the same case
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
    let mut case = case::read(&arguments.case, &overrides)?;
    case.mesh.include_from(&arguments.include);
    let origin = Origin {
        path: Some(arguments.case.clone()),
        case_text: std::fs::read_to_string(&arguments.case).unwrap_or_default(),
        overrides,
        command: Some(command_line()),
    };
    if arguments.resume && case.steps.is_empty() {
        let what = "this case has no load steps to resume";
        return Err(Error::new("--resume", what, "solve it without --resume, or add [[step]] to the case"));
    }
    if arguments.resume && case.accuracy.is_some() {
        let what = "refinement begins with the first mesh, and a run that refines cannot be resumed";
        return Err(Error::new("--resume", what, "solve it without --resume"));
    }
    let folder = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.case));
    hold::folder(&folder)?;
    run::writable(&folder)?;
    if arguments.resume {
        case = run::widened_before(&case, &folder)?;
    }
    let solved = match case.accuracy {
        Some(accuracy) => refined(arguments, &case, &accuracy, &folder, say),
        None => solved(arguments, &case, None, &folder, say),
    };
    let (prepared, mut outcome, ahead) = match solved {
        Err(error) if error.interrupted => {
            output::note("interrupted: nothing has been found yet, nothing is written\n");
            return Ok(code::INTERRUPTED);
        }
        solved => solved?,
    };
    let mut files = run::write_with(&prepared, &mut outcome, &origin, &folder, ahead)?;
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
            let motion = run::escape_mode(&prepared.problem, outcome.solution.status).unwrap_or_default();
            let [when, files] = match outcome.steps.last().map(|step| step.t) {
                Some(t) => [format!(" at t = {t}"), "the files of that step hold".into()],
                None => [String::new(), "the files hold".into()],
            };
            output::note(&format!(
                "warning: there is no equilibrium{when}, the loads carry away {motion}; {files} no result\n"
            ));
            code::SHORT
        }
        Status::PassesThrough => {
            let what = run::passes_through(&prepared, &outcome).unwrap_or_default();
            output::note(&format!("warning: {what}; the files hold bodies that pass through each other\n"));
            code::SHORT
        }
        Status::MaxIterations | Status::Stalled | Status::Uncertified => {
            let why = run::limit_load(&prepared, &outcome).map_or(String::new(), |why| format!("{why}; "));
            output::note(&format!(
                "warning: the tolerance was not reached; {why}the files hold the last step and a certificate that says so\n",
            ));
            code::SHORT
        }
    };
    unlisted.map_or(Ok(code), Err)
}

/// Solves the case on ever finer meshes.
fn refined(
    arguments: &Arguments,
    case: &Case,
    accuracy: &AccuracySpec,
    folder: &Path,
    say: fn(&str),
) -> Result<(Prepared, Outcome, Ahead), Error> {
    let mut solve = |level: &Level| {
        let mut indicators = Indicators::default();
        // Until a level is solved the folder holds the steps of the level before.
        let steps = folder.join("level");
        let solved = solved(arguments, &level.case, Some((level, &mut indicators)), &steps, say);
        let (prepared, outcome, _) = solved.inspect_err(|_| run::discard_steps(&steps))?;
        if !case.steps.is_empty() {
            match outcome.solution.status == Status::Solved || level.number == 0 {
                true => run::adopt_steps(&steps, folder)?,
                false => run::discard_steps(&steps),
            }
        }
        Ok(SolvedLevel { prepared, outcome, indicators })
    };
    let settings = Settings { pictures: !arguments.no_pictures, ..Settings::of(&case.solver) };
    let mut tell = |level: &LevelRecord| say(&format!("{}\n", run::level_line(level)));
    let (prepared, outcome) = run::solve_to_accuracy(case, accuracy, &mut solve, &mut tell)?;
    Ok((prepared, outcome, Ahead::of(&settings)))
}

/// Solves the case, again where contact was found beyond where it was looked for.
fn solved(
    arguments: &Arguments,
    case: &Case,
    mut level: Option<(&Level, &mut Indicators)>,
    folder: &Path,
    say: fn(&str),
) -> Result<(Prepared, Outcome, Ahead), Error> {
    let mut resume = arguments.resume;
    let (mut case, mut widenings) = (case.clone(), 0);
    loop {
        let level = level.as_mut().map(|(level, indicators)| {
            **indicators = Indicators::default();
            (*level, &mut **indicators)
        });
        let (prepared, solved) = attempt(arguments, &case, level, folder, resume, say)?;
        let (outcome, ahead) = solved?;
        memory::give_back();
        match run::widened(&case, &prepared, &outcome) {
            Some(wider) if widenings < MOST_WIDENINGS => {
                let what = run::passes_through(&prepared, &outcome).unwrap_or_default();
                say(&format!("\n{what}\nsolved again with contact there\n\n"));
                (case, resume, widenings) = (wider, false, widenings + 1);
            }
            _ => return Ok((prepared, outcome, ahead)),
        }
    }
}

/// Contact where none was looked for moves bodies elsewhere, where they may meet again; so often at most.
const MOST_WIDENINGS: usize = 5;

/// What was found, with the files begun beside it.
type Solved = Result<(Outcome, Ahead), Error>;

/// Prepares and solves the case once.
fn attempt(
    arguments: &Arguments,
    case: &Case,
    level: Option<(&Level, &mut Indicators)>,
    folder: &Path,
    resume: bool,
    say: fn(&str),
) -> Result<(Prepared, Solved), Error> {
    let progress = Progress::new(arguments.progress);
    progress.say("reading and assembling".into());
    let mut prepared = run::prepare(case).inspect_err(|_| progress.finish())?;
    progress.finish();
    if level.as_ref().is_none_or(|(level, _)| level.number == 0) {
        say(&format!("{}", prepared.facts));
    }
    if let Some(start) = level.as_ref().and_then(|(level, _)| level.start.clone()) {
        prepared.start_from(start);
    }
    let mut settings = Settings::of(&case.solver);
    settings.solver.stop = Stop::when(interrupt::asked);
    settings.pictures = !arguments.no_pictures;
    interrupt::heard();
    let mut steps = None;
    if !case.steps.is_empty() {
        let (files, restart) = run::begin_steps(&prepared, folder, resume)?;
        if resume {
            if let Some(damage) = files.damage() {
                let from = match &restart {
                    Some(restart) => format!("going back to the end of step {}", restart.records.len()),
                    None => "no step before it is whole".into(),
                };
                output::note(&format!("warning: {damage}; {from}\n"));
            }
            match &restart {
                Some(restart) => say(&resumed(restart, folder)),
                None => say(&format!("nothing to resume in {}: solving from the beginning\n", folder.display())),
            }
        }
        steps = Some((files, restart));
    }
    let progress = Progress::new(arguments.progress);
    let mut observe = |event: &Event| {
        progress.show(event);
        ControlFlow::Continue(())
    };
    let solved = match (steps, level) {
        (None, None) => run::solve_writing(&prepared, &settings, folder, &mut observe),
        (None, Some((_, indicators))) => {
            let outcome = run::solve(&prepared, &settings, &mut observe);
            outcome.map(|outcome| {
                indicators.add(&outcome);
                (outcome, Ahead::of(&settings))
            })
        }
        (Some((mut files, restart)), mut level) => {
            let mut keep = |prepared: &Prepared, step: &Step| {
                level.iter_mut().for_each(|(_, indicators)| indicators.add(step.outcome));
                run::keep_step(&mut files, prepared, step)
            };
            let outcome = run::solve_steps(&mut prepared, &settings, restart, &mut keep, &mut observe);
            outcome.map(|outcome| (outcome, Ahead::of(&settings)))
        }
    };
    progress.finish();
    Ok((prepared, solved))
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

fn resumed(restart: &Restart, folder: &Path) -> String {
    let steps = restart.records.len();
    format!("resuming after step {steps} at t = {}, found in {}\n", restart.last.t, folder.display())
}

/// What was typed, with quotes where a shell needs them.
fn command_line() -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:@%+".contains(c);
    let quoted = |word: String| match word.chars().all(plain) && !word.is_empty() {
        true => word,
        false => format!("'{}'", word.replace('\'', "'\\''")),
    };
    let words = std::env::args_os().skip(1).map(|word| quoted(word.to_string_lossy().into_owned()));
    std::iter::once("stiction".to_string()).chain(words).collect::<Vec<_>>().join(" ")
}

fn default_folder(case: &Path) -> PathBuf {
    let stem = case.file_stem().map_or("case".into(), |stem| stem.to_string_lossy().into_owned());
    PathBuf::from(stem + "-results")
}
