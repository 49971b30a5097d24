//! From a posed problem to a certified answer.

use std::ops::ControlFlow;
use std::time::Instant;

use super::place;
use super::prepare::Prepared;
use crate::Error;
use crate::dual::{Dual, DualSettings, Form, choose};
use crate::friction::{
    self, Answer, CoulombFacts, MethodReport, MethodSettings, Progress, Solution, Status, coulomb_facts, solve_with,
};
use crate::io::case::{DualPath, SolverSpec};
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
}

impl Settings {
    /// What a case asks for; without a limit of its own, nine tenths of the memory that is free now.
    pub fn of(spec: &SolverSpec) -> Self {
        let own = spec.memory.map(|gigabytes| (gigabytes * 1e9) as u64);
        let free = || machine::available_memory().map(|bytes| (SHARE_OF_MEMORY * bytes as f64) as u64);
        let form = match spec.path {
            DualPath::Auto => Form::Auto,
            DualPath::Dense => Form::Dense,
            DualPath::Solves => Form::Solves,
        };
        let (tolerance, max_iterations) = (spec.tolerance, spec.max_iterations);
        Settings {
            solver: friction::Settings { tolerance, max_iterations, start: None },
            method_name: spec.method_name.clone(),
            method: spec.method.clone(),
            dual: DualSettings { form, memory_limit: own.or_else(free) },
        }
    }
}

/// What a run is about to do; told to the observer, whose `Break` stops the iteration (nothing else).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
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
    pub ordering: f64,
    pub factorisation: f64,
    pub iteration: f64,
    pub coulomb: f64,
    pub output: f64,
}

impl Seconds {
    /// All phases with their names.
    pub fn phases(&self) -> [(&'static str, f64); 8] {
        [
            ("mesh", self.mesh),
            ("assembly", self.assembly),
            ("contact", self.contact),
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
    /// The form of the dual operator that was taken.
    pub form: Form,
    /// Seconds from the start of the iteration to each entry of the solution's history.
    pub times: Vec<f64>,
    pub seconds: Seconds,
    /// Largest memory of the process so far, bytes, where the system tells it.
    pub peak_memory: Option<u64>,
}

/// Solves a prepared case; a case without contact as well.
///
/// # Errors
/// If the factor does not fit the memory, the stiffness matrix is not positive definite, or the method is not for the
/// friction of the case. An iteration that ends
/// short of its tolerance is no error but a status of the solution.
pub fn solve(
    prepared: &Prepared,
    settings: &Settings,
    observer: &mut dyn FnMut(&Event) -> ControlFlow<()>,
) -> Result<Outcome, Error> {
    let problem = &prepared.problem;
    let [mesh, assembly, contact] = prepared.seconds;
    let mut seconds = Seconds { mesh, assembly, contact, ..Seconds::default() };
    let mut clock = Instant::now();
    let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();

    let _ = observer(&Event::Ordering);
    let choice = choose(problem, &settings.dual).map_err(|error| place::at(&prepared.mesh_spot, error))?;
    seconds.ordering = lap();
    let form = choice.form;
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
        form,
        times,
        seconds,
        peak_memory: machine::peak_memory(),
    })
}
