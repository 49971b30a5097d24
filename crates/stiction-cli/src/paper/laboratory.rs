//! Runs experiments, each once.

use std::ops::ControlFlow;

use super::choices::{
    ALG1_RHO, ALG2_LIMIT, INNER_COULOMB, INNER_GIVEN, LONGEST, OUTER, SHARP, STEP_LIMIT, SWEEP, Setting,
};
use super::experiment::{Experiment, Method};
use super::model::{Brick, Law, brick};
use stiction::Error;
use stiction::contact::{ContactProblem, Friction};
use stiction::dual::{Dual, DualSettings, choose};
use stiction::friction::{
    self, Coupling, End, Given, MethodSettings, Penalty, PointState, Quadratic, Splitting, Start, Sweeps,
    fixed_point_defect, run_method,
};
use stiction::linalg::norm;

/// A posed brick with its factor.
#[derive(Debug)]
struct Bench {
    brick: Brick,
    problem: ContactProblem,
    dual: Dual,
    /// The laws of all points, given and Coulomb.
    laws: [Vec<Friction>; 2],
}

/// Bricks on which experiments can be run.
#[derive(Debug)]
pub struct Benches(Vec<Bench>);

impl Benches {
    /// Poses and factorises the bricks.
    ///
    /// # Errors
    /// If there is no memory for the factors.
    pub fn new(bricks: &[Brick]) -> Result<Self, Error> {
        let bench = |&of: &Brick| {
            let [given, coulomb] = [brick(of, Law::Given)?.problem, brick(of, Law::Coulomb)?.problem];
            let dual = Dual::new(&given, choose(&given, &DualSettings::default())?)?;
            let laws = [given.contact.friction.clone(), coulomb.contact.friction];
            Ok(Bench { brick: of, problem: given, dual, laws })
        };
        Ok(Benches(bricks.iter().map(bench).collect::<Result<_, Error>>()?))
    }
}

/// What a run depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Parameters {
    experiment: Experiment,
    brick: Brick,
    coupling: Coupling,
    /// Length per newton.
    rho: f64,
    preconditioned: bool,
    /// Start of the fixed point, newton; zero for given friction.
    start: f64,
}

/// What one run gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Executions of Step 2.
    pub iterations: usize,
    pub qp_problems: usize,
    /// Steps of conjugate gradients within their face.
    pub cg_steps: usize,
    pub expansions: usize,
    pub proportionings: usize,
    pub flops: f64,
    /// Mean of the copies, newton, 3m.
    pub lambda: Vec<f64>,
    /// Bounds of friction, newton, m.
    pub slip_bound: Vec<f64>,
    pub end: End,
    /// Whether no point slips.
    pub stuck: bool,
    /// Whether the limit of steps was met: the run says nothing.
    pub given_up: bool,
    /// Quadratic programs that ended short of their tolerance at the level of rounding.
    pub short_problems: usize,
}

/// Runs experiments and remembers them.
pub struct Laboratory<'a> {
    benches: &'a Benches,
    quadratics: Vec<Option<Quadratic<'a>>>,
    done: Vec<(Parameters, Measured)>,
    references: Vec<(Brick, Vec<f64>)>,
    /// Told before each run what it is; may stop it.
    observe: &'a mut dyn FnMut(&str) -> ControlFlow<()>,
}

impl<'a> Laboratory<'a> {
    pub fn new(benches: &'a Benches, observe: &'a mut dyn FnMut(&str) -> ControlFlow<()>) -> Self {
        let quadratics = benches.0.iter().map(|_| None).collect();
        Laboratory { benches, quadratics, done: Vec::new(), references: Vec::new(), observe }
    }

    /// One experiment in one setting; from memory if it was run before.
    ///
    /// # Errors
    /// If the observer asked to stop.
    pub fn run(&mut self, experiment: Experiment, setting: Setting) -> Result<Measured, Error> {
        let parameters = parameters(experiment, setting);
        if let Some((_, measured)) = self.done.iter().find(|(p, _)| *p == parameters) {
            return Ok(measured.clone());
        }
        let words = experiment.words();
        if (self.observe)(&format!("{words} ({})", setting.name)).is_break() {
            return Err(interrupted());
        }
        let bench = self.bench(parameters.brick)?;
        let laws = &self.benches.0[bench].laws[usize::from(experiment.method.is_coulomb())];
        let settings = settings(&parameters);
        let settings = MethodSettings {
            start: Start { slip_bound: Some(vec![parameters.start; laws.len()]), ..Start::default() },
            ..settings
        };
        let observe = &mut *self.observe;
        let report =
            run_method(quadratic(&mut self.quadratics, self.benches, bench), laws, &settings, &mut |_| observe(""))?;
        if report.end == End::Interrupted {
            return Err(interrupted());
        }
        let measured = Measured {
            iterations: report.counts.iterations,
            qp_problems: report.counts.qp_problems,
            cg_steps: report.counts.cg_steps,
            expansions: report.counts.expansions,
            proportionings: report.counts.proportionings,
            stuck: !report.states.contains(&PointState::Slip),
            flops: report.counts.flops,
            lambda: report.lambda,
            slip_bound: report.slip_bound,
            given_up: report.end == End::Limit && report.counts.iterations < settings.max_iterations,
            end: report.end,
            short_problems: report.counts.short_problems,
        };
        self.done.push((parameters, measured.clone()));
        Ok(measured)
    }

    /// Relative error of the multipliers of a run with two squares and given friction.
    ///
    /// # Errors
    /// As [`Laboratory::run`].
    pub fn precision(&mut self, measured: &Measured, experiment: Experiment, setting: Setting) -> Result<f64, Error> {
        let brick = parameters(experiment, setting).brick;
        let bench = self.bench(brick)?;
        if !self.references.iter().any(|(b, _)| *b == brick) {
            let settings = MethodSettings {
                tolerance: SHARP,
                agreement: 0.0,
                inner_tolerance: SHARP,
                squares: experiment.squares,
                ..MethodSettings::new(friction::Method::Given(Given::AdaptiveUzawa))
            };
            let laws = &self.benches.0[bench].laws[0];
            let q = quadratic(&mut self.quadratics, self.benches, bench);
            let lambda = run_method(q, laws, &settings, &mut |_| ControlFlow::Continue(()))?.lambda;
            self.references.push((brick, lambda));
        }
        let reference = self.references.iter().find(|(b, _)| *b == brick).map_or(&[][..], |(_, lambda)| lambda);
        Ok(relative_change(reference, &measured.lambda))
    }

    /// `|Psi(g) - g| / |g|` of a run with Coulomb friction, `Psi` by ALG1, variant 1, no splitting (6.4).
    ///
    /// # Errors
    /// If the method refuses its settings.
    pub fn fixed_point(&mut self, measured: &Measured, experiment: Experiment, setting: Setting) -> Result<f64, Error> {
        let method = Method::Alg1 { variant: 1, splitting: Splitting::No };
        let given = parameters(Experiment { method, ..experiment }, setting);
        let bench = self.bench(given.brick)?;
        let laws = &self.benches.0[bench].laws[1];
        let q = quadratic(&mut self.quadratics, self.benches, bench);
        fixed_point_defect(q, laws, &measured.slip_bound, &settings(&given))
    }

    fn bench(&self, brick: Brick) -> Result<usize, Error> {
        let found = self.benches.0.iter().position(|b| b.brick == brick);
        found.ok_or_else(|| Error::new("paper", format!("the brick {brick:?} was not prepared"), ""))
    }
}

/// The dual energy of a brick, formed when it is first needed.
fn quadratic<'q, 'a>(all: &'q mut [Option<Quadratic<'a>>], benches: &'a Benches, number: usize) -> &'q Quadratic<'a> {
    let bench = &benches.0[number];
    all[number].get_or_insert_with(|| Quadratic::new(&bench.problem, &bench.dual))
}

/// What a setting makes of an experiment. ALG1 takes the copies one by one, which a star would not couple.
fn parameters(experiment: Experiment, setting: Setting) -> Parameters {
    let Experiment { partition, squares, method } = experiment;
    let family = method.family();
    let coupling = if squares > 2 && method.is_one_program() { setting.coupling } else { Coupling::Chain };
    let printed = match method {
        Method::Alg1 { .. } | Method::Cfs1 { .. } => ALG1_RHO,
        Method::Alg2 { log10_rho } | Method::Cfs2 { log10_rho } => 10f64.powi(log10_rho),
    };
    let rho = printed * setting.rho_factor(family, partition);
    let start = if method.is_coulomb() { setting.start } else { 0.0 };
    let brick = Brick { partition, parity: setting.parity, load: setting.load };
    Parameters { experiment, brick, coupling, rho, preconditioned: setting.preconditioned, start }
}

fn settings(parameters: &Parameters) -> MethodSettings {
    let Parameters { experiment, coupling, rho, preconditioned, .. } = *parameters;
    let (method, most) = match experiment.method {
        Method::Alg1 { variant, splitting } => {
            let sweeps = if variant == 1 { Sweeps::UntilConverged } else { Sweeps::One };
            (friction::Method::Given(Given::alg1(sweeps, splitting)), LONGEST)
        }
        Method::Alg2 { .. } => (friction::Method::Given(Given::alg2(Splitting::No)), ALG2_LIMIT),
        Method::Cfs1 { splitting } => (friction::Method::cfs1(splitting), LONGEST),
        Method::Cfs2 { .. } => (friction::Method::cfs2(), LONGEST),
    };
    MethodSettings {
        coupling,
        penalty: Penalty::Absolute(rho),
        tolerance: OUTER,
        inner_tolerance: if experiment.method.is_coulomb() { INNER_COULOMB } else { INNER_GIVEN },
        sweep_tolerance: SWEEP,
        precondition: preconditioned,
        max_iterations: most,
        max_cg_steps: if experiment.method.is_one_program() { STEP_LIMIT } else { usize::MAX },
        ..MethodSettings::published(method, experiment.squares, rho)
    }
}

/// `|a - b| / |a|`.
pub fn relative_change(a: &[f64], b: &[f64]) -> f64 {
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    norm(&difference) / norm(a)
}

pub(super) fn interrupted() -> Error {
    Error::new("paper", "interrupted", "nothing is written")
}
