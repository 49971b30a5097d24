//! From a posed problem to a certified answer.

use std::ops::ControlFlow;
use std::time::Instant;

use super::clearance;
use super::discretisation::add_estimate;
use super::free_motions::move_back;
use super::levels::AccuracyRecord;
use super::nested;
use super::passing;
use super::quantities::Smallness;
use super::record::StepRecord;
use crate::Error;
use crate::accuracy::{Bound, Estimate, NoBound};
use crate::contact::sliding::{Sliding, least_resisted};
use crate::contact::{ContactProblem, Overlap};
use crate::friction::{
    self, Answer, CoulombFacts, Method, MethodReport, MethodSettings, Progress, Solution, SolverPath, SoughtForce,
    Status, Tightened, coulomb_facts, coulomb_facts_by_multigrid, solve_with,
};
use crate::io::case::SolverSpec;
use crate::io::machine;
use crate::linalg::Watch;
use crate::run::pose::loads::TIME;
use crate::run::pose::memory::is_of_memory;
use crate::run::pose::{MemoryLimit, Prepared, Seconds, Span, place, stopwatch};
use crate::solve::{Kept, Observer, Solutions, SolveEvent, solve_from_starts, solve_validated, tighten};

/// Settings of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Tolerance, limits, path and start.
    pub solver: friction::Settings,
    /// What `solver.memory_limit` was taken from, for messages.
    pub memory: MemoryLimit,
    /// From how many starts solutions are looked for; `None` is the default one alone.
    pub starts: Option<usize>,
    /// Whether the result gets pictures.
    pub pictures: bool,
    /// What the summary calls the method.
    pub method_name: String,
    /// The method and its settings.
    pub method: MethodSettings,
}

impl Settings {
    /// What a case asks for; without a limit of its own, nine tenths of the memory that is available now.
    pub fn of(spec: &SolverSpec) -> Self {
        let (tolerance, max_iterations, path) = (spec.tolerance, spec.max_iterations, spec.path);
        let memory = MemoryLimit::of(spec);
        let memory_limit = memory.bytes;
        Settings {
            solver: friction::Settings { tolerance, max_iterations, path, memory_limit, ..Default::default() },
            memory,
            starts: spec.starts,
            pictures: true,
            method_name: spec.method_name.clone(),
            method: spec.method.clone(),
        }
    }
}

/// What a run is about to do; given to the observer, whose `Break` ends the run as that of [`SolveEvent`] ends a solve,
/// and load steps with the last finished one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// What the solver does.
    Solver(SolveEvent),
    /// Estimates of contraction and uniqueness.
    Coulomb,
    /// Further solutions are looked for.
    OtherStarts,
    /// A load step begins that leads to time `t`.
    Step {
        /// From 1.
        number: usize,
        /// Time at its end.
        t: f64,
        /// Its length in time.
        dt: f64,
    },
    /// The step could not be solved and is halved; so long is it now.
    Halved {
        /// Time at its start.
        t: f64,
        /// Its new length in time.
        dt: f64,
    },
    /// A load step is finished and kept.
    Finished(StepLine),
}

/// A finished load step in one line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepLine {
    /// From 1.
    pub number: usize,
    /// Time at its end.
    pub t: f64,
    /// Iterations it took.
    pub iterations: usize,
    /// Points that are open.
    pub open: usize,
    /// Points that stick.
    pub stick: usize,
    /// Points that slip.
    pub slip: usize,
    /// Sum of `lambda_n`, newton.
    pub normal_force: f64,
    /// Size of the resultant of friction, newton.
    pub tangential_force: f64,
    /// Dissipated by friction since the start, energy.
    pub dissipation: f64,
}

/// A certified answer, or as far as the iteration came.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The solution with its certificate.
    pub solution: Solution,
    /// The name and the settings of the method, and its own account if it is not Newton's.
    pub method_name: String,
    /// The settings of the method.
    pub settings: MethodSettings,
    /// The method's own report; `None` for Newton's method.
    pub method: Option<MethodReport>,
    /// Why the direct path was taken, where the settings left the choice.
    pub path_reason: Option<String>,
    /// Where nothing was found and friction, at the normal forces of the last step that was solved (without one, at
    /// those the iteration came to), takes up no more than nearly all of the loads: along which motion of floating
    /// bodies.
    pub sliding: Option<Sliding>,
    /// Where surfaces lie in each other.
    pub overlaps: Vec<Overlap>,
    /// Where some friction is Coulomb's and the iteration was not interrupted.
    pub coulomb: Option<CoulombFacts>,
    /// What other starts have found, if the settings ask for some; `solution` is the first of the distinct ones.
    pub solutions: Option<Solutions>,
    /// How good the mesh is for it; `None` where loads carry a body away.
    pub estimate: Option<Estimate>,
    /// How small rotations, strains and slips are; `None` where loads carry a body away.
    pub smallness: Option<Smallness>,
    /// A bound of the same error, or why there is none, where one was asked for.
    pub bound: Option<Result<Bound, NoBound>>,
    /// Seconds from the start of the iteration to each entry of the solution's history.
    pub times: Vec<f64>,
    /// Time by phase.
    pub seconds: Seconds,
    /// Largest memory of the process so far, bytes, where the system reports it.
    pub peak_memory: Option<u64>,
    /// One for each load step; empty without load steps.
    pub steps: Vec<StepRecord>,
    /// How accurate it is, where the mesh was refined for it.
    pub accuracy: Option<AccuracyRecord>,
    /// `1/2 u'Ku - f'u` over all degrees of freedom, where others have solved it and hold `K`.
    pub(crate) energy: Option<f64>,
}

impl Outcome {
    /// A solution of which nothing else is known.
    pub(crate) fn new(solution: Solution, settings: &Settings) -> Self {
        let (method_name, settings) = (settings.method_name.clone(), settings.method.clone());
        let (method, path_reason, sliding, overlaps, coulomb, solutions, estimate, times, seconds, steps) =
            Default::default();
        let peak_memory = machine::peak_memory();
        Outcome {
            solution,
            method_name,
            settings,
            method,
            path_reason,
            sliding,
            overlaps,
            coulomb,
            solutions,
            estimate,
            smallness: None,
            bound: None,
            times,
            seconds,
            peak_memory,
            steps,
            accuracy: None,
            energy: None,
        }
    }
}

/// Solves a prepared case; a case without contact as well.
///
/// Unless the case asks for a path, large problems go by multigrid; where that does not end with a certified answer
/// the direct path takes over. Where surfaces of a pair meet beyond its `search` the answer
/// [passes through](Status::PassesThrough); [`widened`](super::widened) then has the case to be solved instead.
///
/// # Errors
/// If the matrices do not fit the memory, the stiffness matrix is not positive definite, or the method or the path is
/// not for the case. An iteration that ends short of its tolerance is no error but a status of the solution; what is
/// stopped before its first iteration ends with [`Error::interrupted`].
pub fn solve(prepared: &Prepared, settings: &Settings, observer: &mut Watch<Event>) -> Result<Outcome, Error> {
    if let Some(bolt) = prepared.loading.bolts.iter().find(|bolt| bolt.is_by_force()) {
        let what = format!("bolt \"{}\" is tightened by force, which takes load steps", bolt.name);
        return Err(bolt.spot.error(what, "solve the steps of the case (`solve_steps`), or give its shortening"));
    }
    let mut kept = Kept::deciding(prepared.multigrid_first);
    let mut outcome = solve_again(prepared, settings, &mut kept, observer)?;
    let [mesh, assembly, contact] = prepared.seconds;
    outcome.seconds = Seconds { mesh, assembly, contact, ..outcome.seconds };
    other_starts(prepared, settings, &mut kept, &mut outcome, observer);
    if prepared.loading.travel == [0.0; 3] {
        move_back(&prepared.problem, &prepared.motions, None, settings.solver.tolerance, &mut outcome.solution);
    }
    outcome.sliding = sliding(prepared, outcome.solution.status, &outcome.solution.lambda);
    let now = passing::moved(prepared, &outcome.solution.u, TIME)?;
    passing::look(prepared, &passing::at_rest(prepared), &now, &mut outcome);
    uniqueness_facts(prepared, settings, &mut kept, &mut outcome, observer);
    add_estimate(prepared, &mut outcome);
    Ok(outcome)
}

/// The same with what an earlier solve has kept, which must have been of the same stiffness and the same `B`; loads,
/// gaps, slip references and friction may differ. Estimates of uniqueness are left out, and counts and seconds are
/// those of this solve alone.
pub(crate) fn solve_again(
    prepared: &Prepared,
    settings: &Settings,
    kept: &mut Kept,
    observer: &mut Watch<Event>,
) -> Result<Outcome, Error> {
    let problem = &prepared.problem;
    settings.solver.validate(problem)?;
    let mut clock = Clock::new();
    let mut solver = settings.solver.clone();
    let newton = settings.method.method == Method::Newton;
    if newton && solver.start_displacement.is_none() && kept.begins_with_multigrid(problem, &solver) {
        // A coarser problem takes less than this one, for which there may be no memory.
        let coarser = prepared.coarser.as_ref().filter(|_| kept.fits(problem, &solver).is_ok());
        let nested = coarser.and_then(|coarser| nested::start(coarser, prepared, &solver.stop));
        let known = nested.or_else(|| prepared.start.clone());
        solver.start_displacement = known.or_else(|| clearance::start(prepared));
    }
    let mut watch = |event: &SolveEvent| {
        clock.event(event);
        let flow = observer(&Event::Solver(*event));
        if settings.solver.stop.asked() { ControlFlow::Break(()) } else { flow }
    };
    let answer = if newton {
        let solution = solve_validated(problem, &solver, kept, &mut watch);
        solution.map(|solution| Answer { solution, method: None })
    } else {
        by_method(problem, &solver, &settings.method, kept, &mut watch)
    };
    let answer = answer.map_err(|error| placed(prepared, settings, error))?;
    let Clock { seconds, times, .. } = clock.stopped();
    let chosen = newton && solver.path == SolverPath::Auto && answer.solution.path != SolverPath::Multigrid;
    let path_reason = chosen.then(|| kept.why_direct(problem));
    Ok(Outcome { method: answer.method, path_reason, times, seconds, ..Outcome::new(answer.solution, settings) })
}

/// Shortenings of bolts whose force is given together with the contact forces, where the next solve goes by multigrid;
/// `None` where it does not.
///
/// # Errors
/// As [`solve_again`].
pub(crate) fn tightened_by_multigrid(
    prepared: &Prepared,
    settings: &Settings,
    (sought, direct_has_failed): (&[SoughtForce], bool),
    kept: &mut Kept,
    observer: &mut Watch<Event>,
) -> Result<Option<(Tightened, Seconds)>, Error> {
    let (problem, mut solver) = (&prepared.problem, settings.solver.clone());
    if sought.is_empty() || settings.method.method != Method::Newton {
        return Ok(None);
    }
    if !direct_has_failed && !kept.begins_with_multigrid(problem, &solver) {
        return Ok(None);
    }
    let mut clock = Clock::new();
    let mut watch = |event: &SolveEvent| {
        clock.event(event);
        let flow = observer(&Event::Solver(*event));
        if settings.solver.stop.asked() { ControlFlow::Break(()) } else { flow }
    };
    solver.start_displacement = solver.start_displacement.or_else(|| clearance::start(prepared));
    let found =
        tighten(problem, sought, &solver, kept, &mut watch).map_err(|error| placed(prepared, settings, error))?;
    Ok(found.map(|found| (found, clock.stopped().seconds)))
}

/// One of the methods of the source paper and their kin, on the factor.
fn by_method(
    problem: &ContactProblem,
    solver: &friction::Settings,
    method: &MethodSettings,
    kept: &mut Kept,
    observer: &mut Observer,
) -> Result<Answer, Error> {
    if solver.start_displacement.is_some() {
        let what = "`start_displacement` is for multigrid, and this method starts from multipliers";
        return Err(Error::new("settings", what, "give `start` instead"));
    }
    let dual = kept.factorised(problem, solver, observer)?;
    let _ = observer(&SolveEvent::Solving);
    let solves = dual.solves();
    let mut report = |progress: &Progress| observer(&SolveEvent::Iteration(*progress));
    let mut answer = solve_with(problem, dual, solver, method, &mut report)?;
    answer.solution.counts.solves -= solves;
    Ok(answer)
}

/// What does not fit the memory is a matter of the mesh; arguments get the names of their keys.
fn placed(prepared: &Prepared, settings: &Settings, error: Error) -> Error {
    let of_memory = is_of_memory(&error);
    let error = settings.memory.named(error);
    if of_memory { place::at(&prepared.mesh_spot, error) } else { error }
}

/// Seconds by phase, distinguished by what the solver says it begins, and the times of its iterations.
struct Clock {
    lap: Box<dyn FnMut() -> Span>,
    phase: fn(&mut Seconds) -> &mut Span,
    seconds: Seconds,
    /// Seconds from the start of the iteration.
    times: Vec<f64>,
    begin: Instant,
}

impl Clock {
    fn new() -> Self {
        Clock {
            lap: Box::new(stopwatch()),
            phase: |seconds| &mut seconds.setup,
            seconds: Seconds::default(),
            times: Vec::new(),
            begin: Instant::now(),
        }
    }

    fn event(&mut self, event: &SolveEvent) {
        let next: fn(&mut Seconds) -> &mut Span = match event {
            SolveEvent::Iteration(_) => {
                self.times.push(self.begin.elapsed().as_secs_f64());
                return;
            }
            SolveEvent::SettingUp { .. } => |seconds| &mut seconds.setup,
            SolveEvent::Ordering => |seconds| &mut seconds.ordering,
            SolveEvent::Factorising { .. } => |seconds| &mut seconds.factorisation,
            SolveEvent::Solving => |seconds| &mut seconds.iteration,
        };
        self.close();
        self.phase = next;
        self.begin = Instant::now();
        self.times.clear();
    }

    fn close(&mut self) {
        let span = (self.phase)(&mut self.seconds);
        *span = *span + (self.lap)();
    }

    fn stopped(mut self) -> Self {
        self.close();
        self
    }
}

/// Loads that use up this part of friction are worth a word: a joint that slides is last solved just before.
const NEARLY: f64 = 0.95;

/// How friction at the normal forces of `lambda` (length `3m`) is overcome, where that may be why nothing was found.
pub(crate) fn sliding(prepared: &Prepared, status: Status, lambda: &[f64]) -> Option<Sliding> {
    if !matches!(status, Status::Stalled | Status::MaxIterations) {
        return None;
    }
    least_resisted(&prepared.problem, &prepared.motions, lambda).filter(is_worth_a_word)
}

/// Whether the loads come near to what friction takes up.
pub(crate) fn is_worth_a_word(found: &Sliding) -> bool {
    found.load >= NEARLY * found.friction
}

/// Looks for further solutions, if the settings ask for it. Where the first start has found none, that of another one is
/// the answer.
pub(crate) fn other_starts(
    prepared: &Prepared,
    settings: &Settings,
    kept: &mut Kept,
    outcome: &mut Outcome,
    observer: &mut Watch<Event>,
) {
    let final_status = matches!(outcome.solution.status, Status::Interrupted | Status::NoEquilibrium);
    let Some(starts) = settings.starts.filter(|_| !final_status && outcome.method.is_none()) else { return };
    let mut lap = stopwatch();
    if observer(&Event::OtherStarts).is_break() {
        return;
    }
    let mut watch = |event: &SolveEvent| {
        let flow = observer(&Event::Solver(*event));
        if settings.solver.stop.asked() { ControlFlow::Break(()) } else { flow }
    };
    let found = solve_from_starts(&prepared.problem, &settings.solver, &outcome.solution, starts, kept, &mut watch);
    if let Some(first) = found.distinct.first().filter(|_| outcome.solution.status != Status::Solved) {
        // History and times stay those of the first start.
        let history = std::mem::take(&mut outcome.solution.history);
        outcome.solution = Solution { history, ..first.clone() };
    }
    outcome.solutions = Some(found);
    outcome.seconds.coulomb = lap();
}

/// Adds the estimates of contraction and uniqueness to an answer: by the factor that has found it, or, if further starts are
/// asked for, by multigrid, where they take as long as several solves.
pub(crate) fn uniqueness_facts(
    prepared: &Prepared,
    settings: &Settings,
    kept: &mut Kept,
    outcome: &mut Outcome,
    observer: &mut Watch<Event>,
) {
    let (problem, solution) = (&prepared.problem, &outcome.solution);
    let unsettled = matches!(solution.status, Status::Interrupted | Status::NoEquilibrium);
    let is_coulomb = problem.contact.friction.iter().any(|law| law.coefficient().is_some());
    let by_multigrid = solution.path == SolverPath::Multigrid;
    if unsettled || !is_coulomb || settings.solver.stop.asked() || (by_multigrid && settings.starts.is_none()) {
        return;
    }
    let mut lap = stopwatch();
    if observer(&Event::Coulomb).is_break() {
        return;
    }
    // Factor or hierarchy stand already, unless the answer was found by an earlier run that this one resumes.
    let quiet = &mut |_: &SolveEvent| ControlFlow::Continue(());
    outcome.coulomb = if by_multigrid {
        kept.set_up(problem, &settings.solver, quiet).ok().and_then(|set_up| match set_up.part {
            None => coulomb_facts_by_multigrid(problem, set_up.multigrid, solution),
            // Cycles alone do not keep what they prescribe.
            Some(part) if !part.equations.is_empty() => None,
            Some(part) => coulomb_facts_by_multigrid(&part.problem, set_up.multigrid, &part.narrowed(solution)),
        })
    } else {
        let dual = kept.factorised(problem, &settings.solver, quiet).ok();
        dual.and_then(|dual| coulomb_facts(problem, dual, solution))
    };
    outcome.seconds.coulomb = outcome.seconds.coulomb + lap();
}
