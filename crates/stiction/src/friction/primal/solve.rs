use std::ops::ControlFlow;

use super::descent::descend;
use super::bounds::follow_bounds;
use super::directions::norm;
use super::floating::Floating;
use super::frames::{Point, Turned};
use super::iteration::{End, Manner, RESETS, State, run};
use super::sets::Law;
use crate::Error;
use crate::certificate::certify;
use crate::contact::rigid::rigid_motions;
use crate::contact::{ContactProblem, Friction};
use crate::friction::rigid_rest;
use crate::friction::solve::make_admissible;
use crate::friction::{Counts, Phase, PointState, Progress, Settings, Solution, Status};
use crate::linalg::multigrid::Multigrid;

/// A problem turned into the frames of its contact points, with the multigrid hierarchy of its stiffness: what is
/// worth keeping while the stiffness stands.
#[derive(Debug)]
pub struct Primal {
    turned: Turned,
    multigrid: Multigrid,
}

impl Primal {
    /// Turns the problem and sets up the hierarchy.
    ///
    /// # Errors
    /// If the problem is not one for this path: a contact point without a node of its own on which its rows of `B` are
    /// an orthonormal frame, nodes with more than three unknowns, or a matrix that does not get coarser by aggregation.
    pub fn new(problem: &ContactProblem) -> Result<Primal, Error> {
        let (turned, multigrid) =
            Turned::new(problem).map_err(|what| Error::new("", what, "set path = \"auto\" under [solver]"))?;
        Ok(Primal { turned, multigrid })
    }
}

/// Share of the diagonal of `K` at a node that turns displacements into forces; from 0.2 to 0.7 the counts hardly
/// change, a value that is not local fails.
const PARAMETER: f64 = 0.4;

/// Solves contact with friction on the displacements; `primal` is that of `problem`, or of another problem with the
/// same `K` and `B`. `settings.max_iterations` bounds the cycles; `settings.start` is not used,
/// `settings.start_displacement` is.
///
/// Where the sets go round in circles and no friction depends on a normal force, the energy is minimised by a descent
/// that cannot ([`descend_primal`]), with as many cycles again.
///
/// `Solved` is only reported if the certificate passes; a residual that was small enough but did not certify is
/// reduced further.
///
/// # Panics
/// If `primal` is of a problem with another number of unknowns or points, or the start has another length.
pub fn solve_primal(
    problem: &ContactProblem,
    primal: &mut Primal,
    settings: &Settings,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Solution {
    iterate(problem, primal, settings, false, observer)
}

/// Contact with given friction, without friction or bonded by monotone descent on the energy: what [`solve_primal`]
/// falls back to. `None` if some friction is Coulomb's: there is no energy then.
///
/// # Panics
/// As [`solve_primal`].
pub fn descend_primal(
    problem: &ContactProblem,
    primal: &mut Primal,
    settings: &Settings,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Option<Solution> {
    convex(&problem.friction).then(|| iterate(problem, primal, settings, true, observer))
}

/// How a problem is solved; what comes later is taken where what comes earlier fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// The sets' own iteration.
    Sets,
    /// The same, floating bodies moved as a whole before each cycle.
    Settled,
    /// Given friction, with bounds that follow the normal forces.
    Bounds,
    /// The energy is minimised.
    Descent,
}

/// By the sets' own iteration, from where that fails by descent if there is an energy; or by descent alone.
fn iterate(
    problem: &ContactProblem,
    primal: &mut Primal,
    settings: &Settings,
    descending: bool,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Solution {
    let Primal { turned, multigrid } = primal;
    let sizes = (turned.nodes.of.len(), turned.points.len());
    assert_eq!(sizes, (problem.unknowns(), problem.points()), "unknowns and points of the set-up and of the problem");
    if let Some(u) = &settings.start_displacement {
        assert_eq!(u.len(), sizes.0, "displacements to start from");
    }
    turned.set_load(&problem.f);
    let m = problem.points();
    let reference = problem.isotropic_slip_reference();
    let law = |j: usize| {
        let rest = [problem.gap[j], reference[j], reference[m + j]];
        // The mean over both tangents: across, displacements are counted in multiples below one.
        let parameter = PARAMETER / (turned.points[j].flexibility * turned.points[j].scale[2]);
        Law { friction: problem.friction[j], rest, parameter }
    };
    let laws: Vec<Law> = (0..m).map(law).collect();
    let start = settings.start_displacement.clone().or_else(|| rest(problem, turned));
    let begin = |cycles: usize| {
        let mut at = match &start {
            Some(u) => State::at(turned.to_frames(u), &turned.k),
            None => State::zero(turned.f.len()),
        };
        at.cycles = cycles;
        at
    };
    let floating = Floating::new(problem, &turned.points);
    let mut way = if descending { Way::Descent } else { Way::Sets };
    let (mut at, mut most) = (begin(0), settings.max_iterations);
    let mut history = Vec::new();
    // The certificate measures with other scales than the residual: the first target is a guess, then it is lowered.
    let mut tolerance = 0.03 * settings.tolerance;
    loop {
        let mut observe = |cycle: usize, residual: f64, sets: &[super::sets::Set]| {
            let count = |s| sets.iter().filter(|x| x.state == s).count();
            let progress = Progress {
                phase: Phase::Multigrid,
                iteration: cycle,
                residual,
                products: cycle,
                open: count(PointState::Open),
                stick: count(PointState::Stick),
                slip: count(PointState::Slip),
            };
            history.push(progress);
            observer(&progress)
        };
        let end = match way {
            Way::Sets => {
                let manner = Manner { settle: None, resets: if floating.is_some() { if std::env::var("R0").is_ok() { 0 } else {RESETS} } else { RESETS } };
                run(turned, &laws, multigrid, &mut at, tolerance, most, manner, &mut observe)
            }
            Way::Settled => {
                let manner = Manner { settle: floating.as_ref(), resets: RESETS };
                run(turned, &laws, multigrid, &mut at, tolerance, most, manner, &mut observe)
            }
            Way::Bounds => {
                follow_bounds(turned, &laws, multigrid, &mut at, tolerance, most, floating.as_ref(), &mut observe)
            }
            Way::Descent => {
                descend(turned, &laws, multigrid, &mut at, tolerance, most, floating.as_ref(), &mut observe)
            }
        };
        if matches!(end, End::Failed | End::Limit) {
            let next = match way {
                Way::Sets if floating.is_some() => Some(Way::Settled),
                Way::Sets | Way::Settled if convex(&problem.friction) => Some(Way::Descent),
                Way::Sets | Way::Settled => Some(Way::Bounds),
                Way::Bounds | Way::Descent => None,
            };
            if let Some(next) = next {
                way = next;
                most = at.cycles + settings.max_iterations;
                at = begin(at.cycles);
                continue;
            }
        }
        // A descent ends lower than wherever it began.
        if end == End::Failed && way != Way::Descent {
            at.go_back();
        }
        let solution = solution(problem, turned, &at, end, settings.tolerance);
        tolerance *= 0.1;
        if end != End::Converged || solution.certificate.passed || tolerance < 1e-6 * settings.tolerance {
            return Solution { history, ..solution };
        }
    }
}

/// Where floating bodies rest as rigid ones on elastic ground, which tells the points that hold them. `None` where no body
/// floats, or where the load would close all gaps: with all points closed a body at the limit of friction does not slide off.
fn rest(problem: &ContactProblem, turned: &Turned) -> Option<Vec<f64>> {
    let load = norm(&turned.f);
    let wide = |(p, gap): (&Point, &f64)| p.floats && *gap > p.flexibility * load;
    let wide = turned.points.iter().zip(&problem.gap).any(wide);
    wide.then(|| rigid_rest(problem, &rigid_motions(problem), &[], &[], vec![0.0; problem.unknowns()]).0)
}

/// Whether a solution is the minimum of an energy: no bound of friction depends on a normal force.
fn convex(friction: &[Friction]) -> bool {
    friction.iter().all(|law| law.coefficient().is_none_or(|coefficient| coefficient == 0.0))
}

/// Multipliers from the balance at the contact nodes, made admissible, and what the certificate says.
fn solution(problem: &ContactProblem, turned: &Turned, at: &State, end: End, tolerance: f64) -> Solution {
    let m = problem.points();
    let mut lambda = vec![0.0; 3 * m];
    for (j, (p, s)) in turned.points.iter().zip(&at.sets).enumerate() {
        let force: [f64; 3] = std::array::from_fn(|c| turned.f[p.node][c] - at.ku[p.node][c]);
        let friction = if s.state == PointState::Slip { s.friction } else { [force[1], force[2]] };
        let values = [if s.condition.held[0] { force[0] } else { 0.0 }, friction[0], friction[1]];
        if s.state != PointState::Open {
            (0..3).filter(|&c| p.live[c]).for_each(|c| lambda[c * m + j] = values[c]);
        }
    }
    make_admissible(&problem.friction, &mut lambda);
    problem.out_of_isotropic(&mut lambda);
    let u = turned.out_of_frames(&at.u);
    let certificate = certify(problem, &u, &lambda, tolerance);
    let status = match end {
        End::Interrupted => Status::Interrupted,
        _ if certificate.passed => Status::Solved,
        End::Limit => Status::MaxIterations,
        End::Failed | End::Converged => Status::Stalled,
    };
    let states = at.sets.iter().map(|s| s.state).collect();
    let counts = Counts { cycles: at.cycles, restarts: at.resets, ..Counts::default() };
    Solution { status, u, lambda, states, certificate, counts, history: Vec::new() }
}
