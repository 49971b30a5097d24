//! Discrete problems given as matrices: from a file to a judged answer.

use std::path::Path;
use std::time::Instant;

use crate::Error;
use crate::discrete::{
    Form, LocalProblem, Measures, Method, Prepared, Progress, Recovered, Settings, Solution, Status, prepare, rank,
};
use crate::io::{Contents, arrays};
use crate::linalg::Watch;

/// A judged answer, or as far as the iteration came.
#[derive(Debug, Clone)]
pub struct Answer {
    /// The solution.
    pub solution: Solution,
    /// Velocities and bilateral impulses.
    pub recovered: Recovered,
    /// Measures of the answer at the recovered velocities.
    pub measures: Measures,
    /// What its measures are held against.
    pub tolerance: f64,
    /// Measures of what the file calls a solution.
    pub claimed: Option<Measures>,
    /// The method that was asked for.
    pub method: Method,
    /// Order of `W`.
    pub order: usize,
    /// Stored entries of `W`; `None` where it was not formed.
    pub entries: Option<usize>,
    /// Rank of `W`, where it was asked for.
    pub rank: Option<usize>,
    /// Bilateral constraints that follow from others and were left out.
    pub dropped: usize,
    /// The guesses of the file, if it has any.
    pub guess: Option<Guess>,
    /// Time by phase.
    pub seconds: Seconds,
}

/// What became of the guesses in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess {
    /// Number of guesses in the file.
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
    /// Of the iteration.
    pub iteration: f64,
}

impl Seconds {
    /// All phases together.
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
        _ => read_fclib(path),
    }
}

#[cfg(feature = "fclib")]
fn read_fclib(path: &Path) -> Result<Contents, Error> {
    crate::io::fclib::read(path)
}

#[cfg(not(feature = "fclib"))]
fn read_fclib(path: &Path) -> Result<Contents, Error> {
    let what = "files of FCLib are not built into this program";
    let remedy = "build it with the feature \"fclib\", or give the problem as .npz or in Matrix Market files";
    Err(Error::new(path.display().to_string(), what, remedy))
}

/// Solves and judges; `form` says whether velocities of bodies are eliminated first.
///
/// # Errors
/// If the problem cannot be posed: a singular mass, constraints that contradict each other, a start that does not fit. An
/// iteration that ends short of its tolerance is no error.
pub fn answer(
    contents: &Contents,
    settings: &Settings,
    form: Form,
    observer: &mut Watch<Progress>,
) -> Result<Answer, Error> {
    judged(contents, settings, form, observer, |_| None)
}

/// The same with the rank of `W`, where that is formed and not too large: a dense factorisation, which can take longer than the
/// solve.
///
/// # Errors
/// As [`answer`].
pub fn answer_with_rank(
    contents: &Contents,
    settings: &Settings,
    form: Form,
    observer: &mut Watch<Progress>,
) -> Result<Answer, Error> {
    judged(contents, settings, form, observer, rank)
}

fn judged(
    contents: &Contents,
    settings: &Settings,
    form: Form,
    observer: &mut Watch<Progress>,
    rank: fn(&LocalProblem) -> Option<usize>,
) -> Result<Answer, Error> {
    let start = Instant::now();
    let prepared = prepare(&contents.problem, form, settings.method)?;
    let condensation = start.elapsed().as_secs_f64();
    let (solution, guess) = from_guesses(&prepared, contents, settings, observer)?;
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
    observer: &mut Watch<Progress>,
) -> Result<(Solution, Option<Guess>), Error> {
    if contents.guesses.is_empty() || settings.start.is_some() {
        return Ok((prepared.solve(settings, observer)?, None));
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
    let Some((number, _)) = chosen else { return Ok((prepared.solve(settings, observer)?, Some(guess))) };
    let near = Settings { start: Some(contents.guesses[number - 1].clone()), ..settings.clone() };
    let found = prepared.solve(&near, observer)?;
    if !matches!(found.status, Status::MaxIterations | Status::Stalled) {
        return Ok((found, Some(guess)));
    }
    guess.abandoned = true;
    let again = prepared.solve(settings, observer)?;
    Ok((if again.measures.worst() < found.measures.worst() { again } else { found }, Some(guess)))
}
