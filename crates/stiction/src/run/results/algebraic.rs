//! Discrete problems given as matrices: from a file to a judged answer.

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use serde_json::{Map, Value, json};

use crate::Error;
use crate::discrete::DiscreteProblem;
use crate::discrete::Measures;
use crate::discrete::{Form, Method, Prepared, Progress, Recovered, Settings, Solution, Status, prepare, rank};
use crate::io::fclib::Contents;
use crate::io::fclib_write::{self, State};
use crate::io::{arrays, fclib, folder};

/// A judged answer, or as far as the iteration came.
#[derive(Debug, Clone)]
pub struct Answer {
    pub solution: Solution,
    /// Velocities and bilateral impulses.
    pub recovered: Recovered,
    /// Measures of the answer at the recovered velocities.
    pub measures: Measures,
    pub tolerance: f64,
    /// Measures of what the file calls a solution.
    pub claimed: Option<Measures>,
    pub method: Method,
    /// Order of `W`.
    pub order: usize,
    /// Stored entries of `W`; `None` where it was not formed.
    pub entries: Option<usize>,
    pub rank: Option<usize>,
    /// Bilateral constraints that follow from others and were left out.
    pub dropped: usize,
    /// The guesses of the file, if it has any.
    pub guess: Option<Guess>,
    pub seconds: Seconds,
}

/// What became of the guesses in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess {
    pub guesses: usize,
    /// Number of the best, from one, and its largest residual; `None` if none is nearer than no impulse at all.
    pub chosen: Option<(usize, f64)>,
    /// Whether the iteration from it ended short, so that it was begun again from rest.
    pub abandoned: bool,
}

/// Wall time by phase.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seconds {
    /// Condensing to the contact points, or factorising.
    pub condensation: f64,
    pub iteration: f64,
}

impl Seconds {
    pub fn total(&self) -> f64 {
        self.condensation + self.iteration
    }
}

impl Answer {
    /// Whether the three residuals and the balance of the bodies are at most the tolerance.
    pub fn passed(&self) -> bool {
        self.measures.passed(self.tolerance) && self.recovered.equilibrium <= self.tolerance
    }

    /// `solved`, `max_iterations`, `interrupted`, or `inaccurate` where the residuals pass without the bodies' balance.
    pub fn status(&self) -> &'static str {
        match (self.solution.status, self.passed()) {
            (_, true) => "solved",
            (Status::Solved, false) => "inaccurate",
            (Status::MaxIterations, false) => "max_iterations",
            (Status::Stalled, false) => "stalled",
            (Status::Rounding, false) => "rounding",
            (Status::Interrupted, false) => "interrupted",
        }
    }
}

/// Reads a problem: a file of FCLib (`.hdf5`, `.h5`), a NumPy file (`.npz`) or a folder of Matrix Market files.
///
/// # Errors
/// What is wrong with it, and where.
pub fn read(path: &Path) -> Result<Contents, Error> {
    if path.is_dir() {
        return arrays::read_folder(path);
    }
    match path.extension().and_then(|e| e.to_str()) {
        Some("npz") => arrays::read_npz(path),
        Some("mtx") => {
            let what = "one Matrix Market file is no problem";
            Err(Error::new(path.display().to_string(), what, "name the folder that holds W.mtx, q.mtx, mu.mtx"))
        }
        _ => fclib::read(path),
    }
}

/// Solves and judges; `form` says whether velocities of bodies are eliminated first.
///
/// # Errors
/// If the problem cannot be posed: a singular mass, constraints that contradict each other. An iteration that ends
/// short of its tolerance is no error.
pub fn answer(
    contents: &Contents,
    settings: &Settings,
    form: Form,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Answer, Error> {
    let start = Instant::now();
    let prepared = prepare(&contents.problem, form, settings.method)?;
    let condensation = start.elapsed().as_secs_f64();
    let (solution, guess) = from_guesses(&prepared, contents, settings, observer);
    let recovered = prepared.recover(&solution.r);
    let measures = prepared.measures(&solution.r, &recovered.u);
    let seconds = Seconds { condensation, iteration: start.elapsed().as_secs_f64() - condensation };
    let local = prepared.condensed().map(|c| &c.local);
    Ok(Answer {
        recovered,
        measures,
        tolerance: settings.tolerance,
        claimed: contents.solution.as_ref().map(|r| judge(&prepared, r)),
        method: settings.method,
        order: solution.r.len(),
        entries: local.map(|l| l.W.value.len()),
        rank: local.and_then(rank),
        dropped: prepared.dropped(),
        guess,
        seconds,
        solution,
    })
}

fn judge(prepared: &Prepared, r: &[f64]) -> Measures {
    prepared.measures(r, &prepared.recover(r).u)
}

/// Starts from the guess with the smallest residual if it is nearer than rest, and from rest where that ends short.
fn from_guesses(
    prepared: &Prepared,
    contents: &Contents,
    settings: &Settings,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> (Solution, Option<Guess>) {
    if contents.guesses.is_empty() || settings.start.is_some() {
        return (prepared.solve(settings, observer), None);
    }
    let at_rest = judge(prepared, &vec![0.0; contents.guesses[0].len()]).worst();
    let chosen = contents
        .guesses
        .iter()
        .enumerate()
        .map(|(k, r)| (k + 1, judge(prepared, r).worst()))
        .filter(|(_, residual)| *residual < at_rest)
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let mut guess = Guess { guesses: contents.guesses.len(), chosen, abandoned: false };
    let Some((number, _)) = chosen else { return (prepared.solve(settings, observer), Some(guess)) };
    let near = Settings { start: Some(contents.guesses[number - 1].clone()), ..settings.clone() };
    let found = prepared.solve(&near, observer);
    if !matches!(found.status, Status::MaxIterations | Status::Stalled) {
        return (found, Some(guess));
    }
    guess.abandoned = true;
    let again = prepared.solve(settings, observer);
    (if again.measures.worst() < found.measures.worst() { again } else { found }, Some(guess))
}

/// The problem, how the iteration went and how the answer is judged.
pub fn report(name: &str, contents: &Contents, answer: &Answer) -> String {
    let (problem, solution) = (&contents.problem, &answer.solution);
    let kind = match problem {
        DiscreteProblem::Local(_) => "local",
        DiscreteProblem::Global(_) => "global",
    };
    let mut text = format!("{name}\n  problem      {kind}, {} contacts", problem.points());
    let _ = write!(text, " in {} dimensions, W of order {}", problem.dimension(), answer.order);
    let rank = answer.rank.map_or("not computed".to_string(), |r| r.to_string());
    let _ = match answer.entries {
        Some(entries) => writeln!(text, " with {entries} entries, rank {rank}"),
        None => writeln!(text, ", not formed"),
    };
    let counts = solution.counts;
    let _ = write!(text, "  method       {}:", method(answer));
    for (count, name) in [
        (counts.iterations, if counts.newton_steps > 0 { "proximal steps" } else { "rounds" }),
        (counts.newton_steps, "Newton steps"),
        (counts.sweeps, "sweeps"),
        (counts.gradients, "gradient steps"),
        (counts.alternations, "alternations"),
    ] {
        if count > 0 {
            let _ = write!(text, " {count} {name},");
        }
    }
    let _ = writeln!(text, " {:.4} s", answer.seconds.total());
    if let Some(guess) = &answer.guess {
        let _ = write!(text, "  guesses      {}: ", guess.guesses);
        let _ = match guess.chosen {
            Some((number, residual)) => write!(text, "started from number {number}, worst residual {residual:.1e}"),
            None => write!(text, "none is nearer than no impulse at all"),
        };
        text += if guess.abandoned { "; it led nowhere, begun again from rest\n" } else { "\n" };
    }
    if answer.dropped > 0 {
        let _ = writeln!(text, "  bilateral    {} constraints follow from others and were left out", answer.dropped);
    }
    let _ = writeln!(text, "  status       {}", answer.status().replace('_', " "));
    let balance = [("equilibrium", answer.recovered.equilibrium)];
    for (number, (name, value)) in answer.measures.all().into_iter().chain(balance).enumerate() {
        let decides = number < 3 || number == 7;
        let verdict = if decides && value > answer.tolerance { "  exceeds the tolerance" } else { "" };
        let _ = writeln!(text, "  {:<17} {value:.1e}{verdict}", name.replace('_', " "));
    }
    if solution.status == Status::Rounding {
        text += "  note         the residual by velocity is the rounding of impulses that are much larger than velocities: ";
        text += "choose a larger unit of impulse or a smaller one of velocity\n";
    }
    if let Some(claimed) = &answer.claimed {
        let verdict = if claimed.passed(answer.tolerance) { "is one" } else { "is none" };
        let _ = writeln!(
            text,
            "  note         what the file calls a solution {verdict} (worst residual {:.1e}); it was not used",
            claimed.worst()
        );
    }
    text
}

/// The method that gave the answer.
fn method(answer: &Answer) -> &'static str {
    let counts = answer.solution.counts;
    match answer.method {
        Method::Auto if counts.sweeps + counts.alternations > 0 => "ladder+newton",
        Method::Auto | Method::Newton => "proximal newton",
        other => other.name(),
    }
}

/// The head of the table of many problems.
pub fn table_head() -> String {
    format!(
        "{:<44} {:>8} {:>6} {:<15} {:>10} {:>9} {:>11} {:>10} {:>9}  {}\n",
        "problem",
        "contacts",
        "rank",
        "method",
        "iterations",
        "seconds",
        "by velocity",
        "by largest",
        "invariant",
        "verdict"
    )
}

/// A line of the table of many problems.
pub fn table_row(name: &str, contents: &Contents, answer: &Answer) -> String {
    let m = &answer.measures;
    format!(
        "{name:<44} {:>8} {:>6} {:<15} {:>10} {:>9.4} {:>11.1e} {:>10.1e} {:>9.1e}  {}\n",
        contents.problem.points(),
        answer.rank.map_or("-".to_string(), |r| r.to_string()),
        method(answer),
        if answer.solution.counts.newton_steps > 0 {
            answer.solution.counts.newton_steps
        } else {
            answer.solution.counts.iterations
        },
        answer.seconds.total(),
        m.by_velocity,
        m.by_largest,
        m.invariant,
        answer.status().replace('_', " "),
    )
}

/// The answer as JSON, for scripts.
pub fn summary(name: &str, contents: &Contents, answer: &Answer) -> Value {
    let measures = |m: &Measures| -> Map<String, Value> {
        m.all().into_iter().map(|(name, value)| (name.to_string(), json!(value))).collect()
    };
    let mut judged = measures(&answer.measures);
    judged.insert("equilibrium".into(), json!(answer.recovered.equilibrium));
    judged.insert("worst".into(), json!(answer.measures.worst()));
    judged.insert("tolerance".into(), json!(answer.tolerance));
    judged.insert("passed".into(), json!(answer.passed()));
    let counts = answer.solution.counts;
    json!({
        "problem": name,
        "status": answer.status(),
        "certificate": judged,
        "contacts": contents.problem.points(),
        "dimension": contents.problem.dimension(),
        "order": answer.order,
        "entries": answer.entries,
        "rank": answer.rank,
        "method": method(answer),
        "form": if answer.entries.is_some() { "condensed" } else { "sparse" },
        "dropped_constraints": answer.dropped,
        "guess": answer.guess.map(|g| json!({
            "guesses": g.guesses,
            "chosen": g.chosen.map(|c| c.0),
            "residual": g.chosen.map(|c| c.1),
            "abandoned": g.abandoned,
        })),
        "counts": {
            "iterations": counts.newton_steps,
            "proximal_steps": counts.iterations,
            "sweeps": counts.sweeps,
            "gradients": counts.gradients,
            "alternations": counts.alternations,
        },
        "seconds": {
            "condensation": answer.seconds.condensation,
            "iteration": answer.seconds.iteration,
            "total": answer.seconds.total(),
        },
        "claimed_solution": answer.claimed.as_ref().map(measures),
        "versions": { "stiction": env!("CARGO_PKG_VERSION"), "summary": 1 },
    })
}

/// Writes the problem with the answer as its solution, and the summary, into `directory`; the names of the files.
///
/// # Errors
/// If a file cannot be written.
pub fn write(name: &str, contents: &Contents, answer: &Answer, directory: &Path) -> Result<Vec<String>, Error> {
    folder::create(directory)?;
    let files = vec![format!("{name}.solution.hdf5"), format!("{name}.summary.json")];
    folder::remove(&directory.join(&files[1]))?;
    let Recovered { u, v, l, .. } = answer.recovered.clone();
    let state = State { r: answer.solution.r.clone(), u, v, l };
    fclib_write::write(&directory.join(&files[0]), &contents.problem, Some(&state), &[])?;
    folder::write_text(&directory.join(&files[1]), &format!("{:#}\n", summary(name, contents, answer)))?;
    Ok(files)
}
