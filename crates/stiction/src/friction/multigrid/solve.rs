use std::ops::ControlFlow;

use super::bounds::follow_bounds;
use super::descent::descend;
use super::directions::norm;
use super::floating::Floating;
use super::frames::{Point, Turned};
use super::iteration::{Cycles, End, RESETS, State, judge, run};
use super::nested;
use super::sets::Law;
use crate::Error;
use crate::certificate::certify;
use crate::contact::rigid::RigidMotions;
use crate::contact::{ContactProblem, Friction};
use crate::friction::direct::make_admissible;
use crate::friction::rigid_rest;
use crate::friction::{Counts, Phase, PointState, Progress, Settings, Solution, SolverPath, Status};
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
    /// an orthonormal frame, points between bodies on one some hundred times stiffer than the other, nodes with more than
    /// three unknowns, or a matrix that does not get coarser by aggregation.
    pub fn new(problem: &ContactProblem) -> Result<Primal, Error> {
        let (turned, multigrid) = Turned::new(problem)?;
        Ok(Primal { turned, multigrid })
    }

    /// Rigid motions of the bodies that contact alone holds.
    pub fn motions(&self) -> &RigidMotions {
        &self.turned.motions
    }
}

/// Share of a point's stiffness that turns displacements into forces; from 0.4 to 0.8 the counts hardly change. It has to be
/// local, and to know that flat cells give way as a whole: with the stiffness of single nodes blocks of cells thirty times
/// flatter than wide take three times as many cycles, or do not settle.
const PARAMETER: f64 = 0.6;

/// Solves contact with friction on the displacements; `primal` is that of `problem`, or of another problem with the
/// same `K` and `B`. `settings.max_iterations` bounds the cycles; `settings.start` is not used,
/// `settings.start_displacement` is; without it bodies that float start at rest where gaps are wide, and problems in which
/// none floats from their solution on the second coarse level.
///
/// Where the sets go round in circles bodies that float are moved as a whole before each cycle, so that what touches can
/// hold them. Where that is not it, and no friction depends on a normal force, the energy is minimised by a descent that
/// cannot go round ([`descend_primal`]), with as many cycles again; Coulomb friction is solved as given friction with bounds
/// that follow the normal forces.
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
    convex(&problem.contact.friction).then(|| iterate(problem, primal, settings, true, observer))
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

impl Way {
    fn next(self, end: End, floats: bool, convex: bool) -> Option<Way> {
        match (self, end) {
            (Way::Sets, End::Failed) if floats => Some(Way::Settled),
            (Way::Sets | Way::Settled, End::Failed) => Some(Way::Bounds),
            (Way::Sets | Way::Settled, End::Limit) if convex => Some(Way::Bounds),
            _ => None,
        }
    }
}

/// Resets of the second way. Bodies that nothing holds at all are told so no sooner by more of them.
const SETTLED_RESETS: usize = 2;
/// Cycles of the fixed point on the bounds of friction; nine in ten of the cases it solves take fewer.
const BOUNDS_CYCLES: usize = 120;

/// The certificate measures with other scales than the residual. It is asked first where that reaches the tolerance, and
/// passes nineteen times of twenty; where it does not, the residual is to fall as far as the certificate has to, and by a
/// share between these.
const LOWERED: [f64; 2] = [0.03, 0.3];
/// Where it has not passed with residuals down to this share of the tolerance, the numbers are what they are.
const LEAST: f64 = 1e-6;

/// By the sets' own iteration, from where that fails by the other ways; or by descent alone.
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
    turned.set_load(&problem.elastic.f);
    let turned = &*turned;
    let laws = laws(problem, turned);
    let start = settings.start_displacement.clone().or_else(|| rest(problem, turned));
    let floats = turned.points.iter().any(|p| p.floats);
    let start = match start {
        Some(u) => Some(turned.to_frames(&u)),
        None if floats || descending => None,
        None => nested::start(turned, &laws, multigrid),
    };
    let begin = |cycles: usize| {
        let at = match &start {
            Some(u) => State::at(u.clone(), &turned.k),
            None => State::zero(turned.f.len()),
        };
        at.after(cycles)
    };
    let convex = convex(&problem.contact.friction);
    let mut way = if descending { Way::Descent } else { Way::Sets };
    let mut floating = descending.then(|| Floating::new(problem, turned)).flatten();
    let (mut at, mut most, mut resets) = (begin(0), settings.max_iterations, 0);
    let mut history = Vec::new();
    // What failed is told where it was nearest to a solution.
    let mut best: Option<(f64, State)> = None;
    let mut target = settings.tolerance;
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
        let on = Cycles { turned, tolerance: target, most, floating: floating.as_ref() };
        let own = if floats { 0 } else { RESETS };
        let mut end = match way {
            Way::Sets => run(&Cycles { floating: None, ..on }, &laws, multigrid, &mut at, own, &mut observe),
            Way::Settled => run(&on, &laws, multigrid, &mut at, SETTLED_RESETS, &mut observe),
            Way::Bounds => follow_bounds(&on, &laws, multigrid, &mut at, &mut observe),
            Way::Descent => descend(&on, &laws, multigrid, &mut at, &mut observe),
        };
        resets += std::mem::take(&mut at.resets);
        if let Some(next) = way.next(end, floats, convex) {
            at.go_back();
            keep_best(&mut best, turned, &laws, &at);
            way = next;
            most = match way {
                Way::Bounds if convex => at.cycles + settings.max_iterations,
                Way::Bounds => most.min(at.cycles + BOUNDS_CYCLES),
                _ => most,
            };
            at = begin(at.cycles);
            floating = floating.or_else(|| Floating::new(problem, turned));
            continue;
        }
        // A descent ends lower than wherever it began.
        if matches!(end, End::Failed | End::Limit) && way != Way::Descent {
            if end == End::Failed {
                at.go_back();
            }
            if way == Way::Bounds && at.cycles < settings.max_iterations {
                end = End::Failed;
            }
            keep_best(&mut best, turned, &laws, &at);
            if let Some((_, best)) = best.take() {
                at = best.after(at.cycles);
            }
        }
        at.resets = resets;
        let solution = solution(problem, turned, &at, end, settings.tolerance);
        let share = 0.5 * settings.tolerance / solution.certificate.worst;
        target *= if share.is_nan() { LOWERED[0] } else { share.clamp(LOWERED[0], LOWERED[1]) };
        if end != End::Converged || solution.certificate.passed || target < LEAST * settings.tolerance {
            return Solution { history, ..solution };
        }
    }
}

/// The law at each point, in its frame.
fn laws(problem: &ContactProblem, turned: &Turned) -> Vec<Law> {
    let m = problem.points();
    let reference = problem.isotropic_slip_reference();
    let law = |j: usize| {
        let rest = [problem.contact.gap[j], reference[j], reference[m + j]];
        // The mean over both tangents: across, displacements are counted in multiples below one.
        let parameter = PARAMETER / (turned.points[j].flexibility * turned.points[j].scale[2]);
        Law { friction: problem.contact.friction[j], rest, parameter }
    };
    (0..m).map(law).collect()
}

/// Keeps the state, with the sets of the law there, if it violates the law less than what is kept.
fn keep_best(best: &mut Option<(f64, State)>, turned: &Turned, laws: &[Law], at: &State) {
    let mut at = at.clone();
    let wrong = judge(turned, laws, &mut at);
    if wrong.is_finite() && best.as_ref().is_none_or(|(least, _)| wrong < *least) {
        *best = Some((wrong, at));
    }
}

/// Where floating bodies rest as rigid ones on elastic ground, which tells the points that hold them. `None` where no body
/// floats, or where the load would close all gaps: with all points closed a body at the limit of friction does not slide off.
fn rest(problem: &ContactProblem, turned: &Turned) -> Option<Vec<f64>> {
    let load = norm(&turned.f);
    let wide = |(p, gap): (&Point, &f64)| p.floats && *gap > p.flexibility * load;
    let wide = turned.points.iter().zip(&problem.contact.gap).any(wide);
    wide.then(|| rigid_rest(problem, &turned.motions, &[], &[], vec![0.0; problem.unknowns()]).0)
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
    make_admissible(&problem.contact.friction, &mut lambda);
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
    let path = SolverPath::Multigrid;
    Solution { status, path, u, lambda, states, certificate, counts, history: Vec::new() }
}
