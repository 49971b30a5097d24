//! From a posed problem to a certified answer.

use std::ops::ControlFlow;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::clearance;
use super::nested;
use super::record::StepRecord;
use crate::Error;
use crate::contact::equilibrium::no_equilibrium;
use crate::contact::sliding::{Sliding, least_resisted};
use crate::dual::{Dual, DualSettings, Form, choose};
use crate::friction::{
    self, Answer, CoulombFacts, Method, MethodReport, MethodSettings, Primal, Progress, Solution, Status,
    coulomb_facts, solve_primal, solve_with,
};
use crate::io::case::{SolverPath, SolverSpec};
use crate::io::machine;
use crate::run::pose::{Prepared, Seconds, place, stopwatch};

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

/// What a run is about to do; given to the observer, whose `Break` stops the iteration (nothing else).
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
    /// A load step begins that leads to time `t`.
    Step {
        number: usize,
        t: f64,
        dt: f64,
    },
    /// The step could not be solved and is halved; so long is it now.
    Halved {
        t: f64,
        dt: f64,
    },
    /// A load step is finished and kept.
    Finished(StepLine),
}

/// A finished load step in one line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepLine {
    pub number: usize,
    pub t: f64,
    pub iterations: usize,
    pub open: usize,
    pub stick: usize,
    pub slip: usize,
    /// Sum of `lambda_n`, newton.
    pub normal_force: f64,
    /// Size of the resultant of friction, newton.
    pub tangential_force: f64,
    /// Dissipated by friction since the start, energy.
    pub dissipation: f64,
}

/// The way the solution was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
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
    /// Where nothing was found and friction, at the normal forces of the last step that was solved (without one, at those
    /// the iteration came to), takes up no more than nearly all of the loads: along which motion of floating bodies.
    pub sliding: Option<Sliding>,
    /// Where some friction is Coulomb's and the iteration was not interrupted.
    pub coulomb: Option<CoulombFacts>,
    /// The path that was taken.
    pub path: Path,
    /// Seconds from the start of the iteration to each entry of the solution's history.
    pub times: Vec<f64>,
    pub seconds: Seconds,
    /// Largest memory of the process so far, bytes, where the system reports it.
    pub peak_memory: Option<u64>,
    /// One for each load step; empty without load steps.
    pub steps: Vec<StepRecord>,
}

impl Outcome {
    /// A solution of which nothing else is known.
    pub(crate) fn new(solution: Solution, settings: &Settings, path: Path) -> Self {
        let (method_name, settings) = (settings.method_name.clone(), settings.method.clone());
        let (method, sliding, coulomb, times, seconds, steps) = Default::default();
        let peak_memory = machine::peak_memory();
        Outcome { solution, method_name, settings, method, sliding, coulomb, path, times, seconds, peak_memory, steps }
    }
}

/// Bytes an unknown takes at most during the set-up of the hierarchy, beyond the problem itself (measured: 1500).
const MULTIGRID_BYTES: u64 = 2000;
/// Cycles allowed for each iteration: a Newton step on the other path costs about as much.
const CYCLES_PER_ITERATION: usize = 5;

/// What is worth keeping while the stiffness and `B` stand: a factor or a multigrid hierarchy.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    operator: Option<Operator>,
    /// Multigrid has failed and the direct path has taken over.
    direct: bool,
}

#[derive(Debug)]
enum Operator {
    Factor(Box<Dual>, Path),
    Multigrid(Box<Primal>),
}

impl Kept {
    /// Nothing yet, and on the direct path from the start if `direct`.
    pub(crate) fn none(direct: bool) -> Self {
        Kept { operator: None, direct }
    }
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
    if let Some(bolt) = prepared.loading.bolts.iter().find(|bolt| bolt.is_by_force()) {
        let what = format!("bolt \"{}\" is tightened by force, which takes load steps", bolt.name);
        return Err(bolt.spot.error(what, "solve the steps of the case (`solve_steps`), or give its shortening"));
    }
    let mut kept = Kept::default();
    let mut outcome = solve_again(prepared, settings, &mut kept, observer)?;
    let [mesh, assembly, contact] = prepared.seconds;
    outcome.seconds = Seconds { mesh, assembly, contact, ..outcome.seconds };
    outcome.sliding = sliding(prepared, outcome.solution.status, &outcome.solution.lambda);
    uniqueness_facts(prepared, &kept, &mut outcome, observer);
    Ok(outcome)
}

/// The same with what an earlier solve has kept, which must have been of the same stiffness and the same `B`; loads,
/// gaps, slip references and friction may differ. Estimates of uniqueness are left out, and counts and seconds are
/// those of this solve alone.
pub(crate) fn solve_again(
    prepared: &Prepared,
    settings: &Settings,
    kept: &mut Kept,
    observer: &mut dyn FnMut(&Event) -> ControlFlow<()>,
) -> Result<Outcome, Error> {
    let asked = settings.path == SolverPath::Multigrid;
    let may = settings.path == SolverPath::Auto && prepared.multigrid_first && !kept.direct;
    if settings.method.method != Method::Newton || !(asked || may) {
        return by_factor(prepared, settings, kept, observer);
    }
    match by_multigrid(prepared, settings, kept, observer) {
        Ok(outcome) if asked || is_final(outcome.solution.status) => Ok(outcome),
        Err(error) if asked => Err(error),
        by_multigrid => {
            let direct = by_factor(prepared, settings, kept, observer);
            kept.direct = direct.is_ok();
            // The direct path may not fit the memory: then what multigrid has found is the better answer.
            if direct.is_err() && by_multigrid.is_ok() { by_multigrid } else { direct }
        }
    }
}

/// Loads that use up this part of friction are worth a word: a joint that slides is last solved just before.
const NEARLY: f64 = 0.95;

/// How friction at the normal forces of `lambda` (length `3m`) is overcome, where that may be why nothing was found.
pub(crate) fn sliding(prepared: &Prepared, status: Status, lambda: &[f64]) -> Option<Sliding> {
    if !matches!(status, Status::Stalled | Status::MaxIterations) {
        return None;
    }
    let found = least_resisted(&prepared.problem, &prepared.motions, lambda)?;
    (found.load >= NEARLY * found.friction).then_some(found)
}

/// Whether another path could not do better.
fn is_final(status: Status) -> bool {
    matches!(status, Status::Solved | Status::Interrupted | Status::NoEquilibrium)
}

/// Adds the estimates of contraction and uniqueness, which need the direct path, to an answer it has found.
pub(crate) fn uniqueness_facts(
    prepared: &Prepared,
    kept: &Kept,
    outcome: &mut Outcome,
    observer: &mut dyn FnMut(&Event) -> ControlFlow<()>,
) {
    let Some(Operator::Factor(dual, _)) = &kept.operator else { return };
    if outcome.path == Path::Multigrid || matches!(outcome.solution.status, Status::Interrupted | Status::NoEquilibrium)
    {
        return;
    }
    let mut lap = stopwatch();
    let _ = observer(&Event::Coulomb);
    outcome.coulomb = coulomb_facts(&prepared.problem, dual, &outcome.solution);
    outcome.seconds.coulomb = lap();
}

fn by_multigrid(
    prepared: &Prepared,
    settings: &Settings,
    kept: &mut Kept,
    observer: &mut dyn FnMut(&Event) -> ControlFlow<()>,
) -> Result<Outcome, Error> {
    let problem = &prepared.problem;
    let mut seconds = Seconds::default();
    let mut lap = stopwatch();
    let mut primal = match kept.operator.take() {
        Some(Operator::Multigrid(primal)) => primal,
        _ => Box::new(set_up_multigrid(prepared, settings, observer)?),
    };
    let start = settings.solver.start_displacement.clone();
    let start = start.or_else(|| prepared.coarser.as_ref().and_then(|coarser| nested::start(coarser, prepared)));
    let start = start.or_else(|| clearance::start(prepared));
    seconds.setup = lap();
    let _ = observer(&Event::Solving);
    let (begin, mut times) = (Instant::now(), Vec::new());
    let departs = no_equilibrium(problem, &prepared.motions).is_some();
    let cycles = CYCLES_PER_ITERATION.saturating_mul(settings.solver.max_iterations);
    let solver = friction::Settings {
        max_iterations: if departs { 0 } else { cycles },
        start_displacement: start,
        ..settings.solver.clone()
    };
    let solution = solve_primal(problem, &mut primal, &solver, &mut |progress| {
        times.push(begin.elapsed().as_secs_f64());
        observer(&Event::Iteration(*progress))
    });
    let status = if departs { Status::NoEquilibrium } else { solution.status };
    seconds.iteration = lap();
    let solution = Solution { status, ..solution };
    kept.operator = Some(Operator::Multigrid(primal));
    Ok(outcome(settings, Answer { solution, method: None }, Path::Multigrid, times, seconds))
}

fn set_up_multigrid(
    prepared: &Prepared,
    settings: &Settings,
    observer: &mut dyn FnMut(&Event) -> ControlFlow<()>,
) -> Result<Primal, Error> {
    let problem = &prepared.problem;
    let needed = MULTIGRID_BYTES * problem.unknowns() as u64;
    if let Some(limit) = settings.dual.memory_limit.filter(|&limit| needed > limit) {
        let gb = |bytes: u64| bytes as f64 / 1e9;
        let what = format!("multigrid needs {:.2} GB and {:.2} GB may be used", gb(needed), gb(limit));
        let remedy = "coarsen the mesh, raise `memory` under [solver], or use a machine with more memory";
        return Err(place::at(&prepared.mesh_spot, Error::new("", what, remedy)));
    }
    let _ = observer(&Event::SettingUp { unknowns: problem.unknowns() });
    Primal::new(problem)
}

fn by_factor(
    prepared: &Prepared,
    settings: &Settings,
    kept: &mut Kept,
    observer: &mut dyn FnMut(&Event) -> ControlFlow<()>,
) -> Result<Outcome, Error> {
    let problem = &prepared.problem;
    let mut seconds = Seconds::default();
    let mut lap = stopwatch();
    let (dual, path) = match kept.operator.take() {
        Some(Operator::Factor(dual, path)) => (dual, path),
        // The hierarchy goes before the factor comes: both together may not fit the memory.
        hierarchy => {
            drop(hierarchy);
            let _ = observer(&Event::Ordering);
            let choice = choose(problem, &settings.dual).map_err(|error| place::at(&prepared.mesh_spot, error))?;
            seconds.ordering = lap();
            let path = if choice.form == Form::Dense { Path::Dense } else { Path::Solves };
            let _ = observer(&Event::Factorising { unknowns: problem.unknowns(), bytes: choice.bytes });
            (Box::new(Dual::new(problem, choice)?), path)
        }
    };
    seconds.factorisation = lap();

    let _ = observer(&Event::Solving);
    let (start, mut times) = (Instant::now(), Vec::new());
    // The operator counts on from solve to solve.
    let (products, solves) = (dual.products(), dual.solves());
    let products = if settings.method.method == Method::Newton { products } else { 0 };
    let own = |progress: &Progress| Progress { products: progress.products - products, ..*progress };
    let answer = solve_with(problem, &dual, &settings.solver, &settings.method, &mut |progress| {
        times.push(start.elapsed().as_secs_f64());
        observer(&Event::Iteration(own(progress)))
    });
    seconds.iteration = lap();
    kept.operator = Some(Operator::Factor(dual, path));
    let mut answer = answer?;
    let solution = &mut answer.solution;
    solution.counts.products -= products;
    solution.counts.solves -= solves;
    solution.history.iter_mut().for_each(|progress| *progress = own(progress));
    Ok(outcome(settings, answer, path, times, seconds))
}

fn outcome(settings: &Settings, answer: Answer, path: Path, times: Vec<f64>, seconds: Seconds) -> Outcome {
    Outcome { method: answer.method, times, seconds, ..Outcome::new(answer.solution, settings, path) }
}
