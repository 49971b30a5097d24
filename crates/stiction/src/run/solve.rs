//! From a posed problem to a certified answer.

use std::ops::ControlFlow;
use std::time::Instant;

use super::nested;
use super::place;
use super::prepare::Prepared;
use crate::Error;
use crate::dual::{Dual, DualSettings, Form, choose};
use crate::friction::{
    self, Answer, CoulombFacts, Method, MethodReport, MethodSettings, Primal, Progress, Solution, Status,
    coulomb_facts, solve_primal, solve_with,
};
use crate::io::case::{SolverPath, SolverSpec};
use crate::io::machine;

/// Part of the memory that is free which a solve takes for its matrices at most.
const SHARE_OF_MEMORY: f64 = 0.9;

/// Settings of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub solver: friction::Settings,
    /// What the summary calls the method.
    pub method_name: String,
    pub method: MethodSettings,
    pub dual: DualSettings,
    pub path: SolverPath,
}

impl Settings {
    /// What a case asks for; without a limit of its own, nine tenths of the memory that is free now.
    pub fn of(spec: &SolverSpec) -> Self {
        let own = spec.memory.map(|gigabytes| (gigabytes * 1e9) as u64);
        let free = || machine::available_memory().map(|bytes| (SHARE_OF_MEMORY * bytes as f64) as u64);
        let form = match spec.path {
            SolverPath::Auto | SolverPath::Multigrid => Form::Auto,
            SolverPath::Dense => Form::Dense,
            SolverPath::Solves => Form::Solves,
        };
        let (tolerance, max_iterations) = (spec.tolerance, spec.max_iterations);
        Settings {
            solver: friction::Settings { tolerance, max_iterations, ..friction::Settings::default() },
            method_name: spec.method_name.clone(),
            method: spec.method.clone(),
            dual: DualSettings { form, memory_limit: own.or_else(free) },
            path: spec.path,
        }
    }
}

/// What a run is about to do; told to the observer, whose `Break` stops the iteration (nothing else).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// Set-up of the multigrid hierarchy.
    SettingUp {
        unknowns: usize,
    },
    Ordering,
    /// Elimination of `unknowns`, predicted to take so many bytes.
    Factorising {
        unknowns: usize,
        bytes: u64,
    },
    /// The factor stands, the iteration begins.
    Solving,
    /// An iteration has been done.
    Iteration(Progress),
    /// Estimates of contraction and uniqueness.
    Coulomb,
}

/// Wall time by phase.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seconds {
    pub mesh: f64,
    pub assembly: f64,
    pub contact: f64,
    /// The multigrid hierarchy.
    pub setup: f64,
    pub ordering: f64,
    pub factorisation: f64,
    pub iteration: f64,
    pub coulomb: f64,
    pub output: f64,
}

impl Seconds {
    /// All phases with their names.
    pub fn phases(&self) -> [(&'static str, f64); 9] {
        [
            ("mesh", self.mesh),
            ("assembly", self.assembly),
            ("contact", self.contact),
            ("setup", self.setup),
            ("ordering", self.ordering),
            ("factorisation", self.factorisation),
            ("iteration", self.iteration),
            ("coulomb", self.coulomb),
            ("output", self.output),
        ]
    }

    pub fn total(&self) -> f64 {
        self.phases().iter().map(|(_, seconds)| seconds).sum()
    }
}

/// The way the solution was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Path {
    /// `B K⁻¹ Bᵀ` by a factor of `K` and the dense Schur complement.
    Dense,
    /// `B K⁻¹ Bᵀ` by solves with the factor.
    Solves,
    /// The displacements by multigrid.
    Multigrid,
}

/// A certified answer, or as far as the iteration came.
#[derive(Debug, Clone)]
pub struct Outcome {
    pub solution: Solution,
    /// The name and the settings of the method, and its own account if it is not Newton's.
    pub method_name: String,
    pub settings: MethodSettings,
    pub method: Option<MethodReport>,
    /// Where some friction is Coulomb's and the iteration was not interrupted.
    pub coulomb: Option<CoulombFacts>,
    /// The path that was taken.
    pub path: Path,
    /// Seconds from the start of the iteration to each entry of the solution's history.
    pub times: Vec<f64>,
    pub seconds: Seconds,
    /// Largest memory of the process so far, bytes, where the system tells it.
    pub peak_memory: Option<u64>,
}

/// Unknowns from which multigrid is the cheaper path (measured on bricks of tetrahedra and of hexahedra).
const LARGE: usize = 20_000;
/// Bytes an unknown takes at most during the set-up of the hierarchy, beyond the problem itself (measured: 1500).
const MULTIGRID_BYTES: u64 = 2000;
/// Cycles allowed for each iteration: a Newton step on the other path costs about as much.
const CYCLES_PER_ITERATION: usize = 10;

/// Whether a case with so many unknowns is solved by multigrid before anything else.
pub(super) fn may_take_multigrid(spec: &SolverSpec, unknowns: usize) -> bool {
    let path = spec.path == SolverPath::Multigrid || spec.path == SolverPath::Auto && unknowns >= LARGE;
    spec.method.method == Method::Newton && path
}

/// Solves a prepared case; a case without contact as well.
///
/// Unless the case asks for a path, large problems go by multigrid; where that does not end with a certified answer
/// the direct path takes over.
///
/// # Errors
/// If the matrices do not fit the memory, the stiffness matrix is not positive definite, or the method or the path is
/// not for the case. An iteration that ends short of its tolerance is no error but a status of the solution.
pub fn solve(
    prepared: &Prepared,
    settings: &Settings,
    observer: &mut dyn FnMut(&Event) -> ControlFlow<()>,
) -> Result<Outcome, Error> {
    let asked = settings.path == SolverPath::Multigrid;
    let may = settings.path == SolverPath::Auto && prepared.problem.unknowns() >= LARGE;
    if settings.method.method != Method::Newton || !(asked || may) {
        return by_factor(prepared, settings, observer);
    }
    match by_multigrid(prepared, settings, observer) {
        Ok(outcome) if asked || matches!(outcome.solution.status, Status::Solved | Status::Interrupted) => Ok(outcome),
        Err(error) if asked => Err(error),
        // The direct path may still not fit the memory: then what multigrid has found is the better answer.
        Ok(outcome) => by_factor(prepared, settings, observer).or(Ok(outcome)),
        Err(_) => by_factor(prepared, settings, observer),
    }
}

/// Seconds since the last call.
fn stopwatch() -> impl FnMut() -> f64 {
    let mut clock = Instant::now();
    move || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64()
}

fn by_multigrid(
    prepared: &Prepared,
    settings: &Settings,
    observer: &mut dyn FnMut(&Event) -> ControlFlow<()>,
) -> Result<Outcome, Error> {
    let problem = &prepared.problem;
    let needed = MULTIGRID_BYTES * problem.unknowns() as u64;
    if let Some(limit) = settings.dual.memory_limit.filter(|&limit| needed > limit) {
        let gb = |bytes: u64| bytes as f64 / 1e9;
        let what = format!("multigrid needs {:.2} GB and {:.2} GB may be used", gb(needed), gb(limit));
        let remedy = "coarsen the mesh, raise `memory` under [solver], or use a machine with more memory";
        return Err(place::at(&prepared.mesh_spot, Error::new("", what, remedy)));
    }
    let [mesh, assembly, contact] = prepared.seconds;
    let mut seconds = Seconds { mesh, assembly, contact, ..Seconds::default() };
    let mut lap = stopwatch();
    let _ = observer(&Event::SettingUp { unknowns: problem.unknowns() });
    let mut primal = Primal::new(problem)?;
    let start = prepared.coarser.as_ref().and_then(|coarser| nested::start(coarser, prepared));
    seconds.setup = lap();
    let _ = observer(&Event::Solving);
    let (begin, mut times) = (Instant::now(), Vec::new());
    let solver = friction::Settings {
        max_iterations: CYCLES_PER_ITERATION.saturating_mul(settings.solver.max_iterations),
        start_displacement: start,
        ..settings.solver.clone()
    };
    let solution = solve_primal(problem, &mut primal, &solver, &mut |progress| {
        times.push(begin.elapsed().as_secs_f64());
        observer(&Event::Iteration(*progress))
    });
    seconds.iteration = lap();
    Ok(Outcome {
        solution,
        method_name: settings.method_name.clone(),
        settings: settings.method.clone(),
        method: None,
        coulomb: None,
        path: Path::Multigrid,
        times,
        seconds,
        peak_memory: machine::peak_memory(),
    })
}

fn by_factor(
    prepared: &Prepared,
    settings: &Settings,
    observer: &mut dyn FnMut(&Event) -> ControlFlow<()>,
) -> Result<Outcome, Error> {
    let problem = &prepared.problem;
    let [mesh, assembly, contact] = prepared.seconds;
    let mut seconds = Seconds { mesh, assembly, contact, ..Seconds::default() };
    let mut lap = stopwatch();

    let _ = observer(&Event::Ordering);
    let choice = choose(problem, &settings.dual).map_err(|error| place::at(&prepared.mesh_spot, error))?;
    seconds.ordering = lap();
    let path = if choice.form == Form::Dense { Path::Dense } else { Path::Solves };
    let _ = observer(&Event::Factorising { unknowns: problem.unknowns(), bytes: choice.bytes });
    let dual = Dual::new(problem, choice)?;
    seconds.factorisation = lap();

    let _ = observer(&Event::Solving);
    let (start, mut times) = (Instant::now(), Vec::new());
    let answer = solve_with(problem, &dual, &settings.solver, &settings.method, &mut |progress| {
        times.push(start.elapsed().as_secs_f64());
        observer(&Event::Iteration(*progress))
    })?;
    let Answer { solution, method } = answer;
    seconds.iteration = lap();
    let coulomb = if solution.status == Status::Interrupted {
        None
    } else {
        let _ = observer(&Event::Coulomb);
        coulomb_facts(problem, &dual, &solution)
    };
    seconds.coulomb = lap();
    let (method_name, settings) = (settings.method_name.clone(), settings.method.clone());
    Ok(Outcome {
        solution,
        method_name,
        settings,
        method,
        coulomb,
        path,
        times,
        seconds,
        peak_memory: machine::peak_memory(),
    })
}
