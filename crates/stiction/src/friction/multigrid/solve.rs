use super::active_set::{ContactCondition, PointLaw};
use super::coarse_start;
use super::directions::norm;
use super::divided::Divided;
use super::equations::Equations;
use super::floating::FloatingBodies;
use super::iteration::{Iterate, State, Subproblem, judge, judged as judged_by_law, squares};
use super::part::{Part, SetUp};
use super::points::Point;
use super::strategy::{STAGES, Traits};
use super::transform::Transformed;
use crate::Error;
use crate::certificate::{Certificate, certify};
use crate::contact::rigid::RigidMotions;
use crate::contact::{ContactProblem, Division, Friction};
use crate::friction::direct::make_admissible;
use crate::friction::rigid_equilibrium;
use crate::friction::strength::until_certified;
use crate::friction::{Counts, End, Phase, PointState, Progress, Settings, Solution, SolverPath};
use crate::linalg::multigrid::Hierarchy;
use crate::linalg::{Stop, Watch};

/// A problem transformed to the frames of its contact points, with the multigrid hierarchy of its stiffness: what can be
/// kept as long as `K` and `B` do not change.
#[derive(Debug)]
pub struct Multigrid {
    pub(super) transformed: Transformed,
    pub(super) hierarchy: Hierarchy,
    /// Of a problem that is divided among ranks.
    pub(super) divided: Option<Divided>,
    /// Equations over many nodes of an earlier solve.
    pub(super) equations: Option<Equations>,
}

impl Multigrid {
    /// Transforms the problem and sets up the hierarchy.
    ///
    /// # Errors
    /// If multigrid is not for the problem: a contact point without a node of its own on which its rows of `B` are an
    /// orthonormal frame (points have none where `node_of` is missing), points between bodies on one some hundred times
    /// stiffer than the other, nodes with more than three unknowns, or a matrix that aggregation does not make coarser.
    pub fn new(problem: &ContactProblem) -> Result<Multigrid, Error> {
        Self::until(problem, &Stop::never())
    }

    /// The same, which ends when `stop` asks to.
    ///
    /// # Errors
    /// As [`Multigrid::new`]; if it is stopped [`Error::interrupted`].
    pub fn until(problem: &ContactProblem, stop: &Stop) -> Result<Multigrid, Error> {
        let (transformed, hierarchy) = Transformed::new(problem, stop)?;
        Ok(Multigrid { transformed, hierarchy, divided: None, equations: None })
    }

    /// The same on each of several ranks, whose problems are parts of one; returns the problem of the points of this rank too,
    /// which is the one to solve.
    ///
    /// # Errors
    /// As [`Multigrid::new`], at all ranks; if no contact resists a motion of a body.
    pub(crate) fn divided(
        whole: &ContactProblem,
        division: &Division,
        stop: &Stop,
    ) -> Result<(Multigrid, ContactProblem), Error> {
        let (transformed, hierarchy, divided) = Transformed::divided(whole, division, stop)?;
        let own = divided.own();
        Ok((Multigrid { transformed, hierarchy, divided: Some(divided), equations: None }, own))
    }

    /// The problem of the points of this rank of `whole`, which differs from that of the set-up in loads, gaps, slip references and
    /// laws alone. `None` where the problem is not divided.
    pub fn renewed(&mut self, whole: &ContactProblem) -> Option<ContactProblem> {
        let divided = self.divided.as_mut()?;
        divided.renew(whole);
        Some(divided.own())
    }

    /// As a set-up of `own`, the problem of the points of this rank that a set-up or [`Multigrid::renewed`] has returned: on each rank with
    /// the part beside equations over many nodes if some rank has these.
    pub(crate) fn set_up(&mut self, own: &ContactProblem) -> SetUp<'_> {
        let part = self.part(own);
        SetUp { multigrid: self, part }
    }

    /// That part.
    pub(crate) fn part(&self, own: &ContactProblem) -> Option<Part> {
        let equations = self.divided.as_ref()?.equations()?;
        let points = (0..own.points() as u32).filter(|j| equations.binary_search(j).is_err()).collect();
        Some(Part::new(own, points, equations.to_vec()))
    }

    /// Whether points of this rank or, where `problem` is divided, of another one have a tensile strength.
    pub(super) fn has_strength(&self, problem: &ContactProblem) -> bool {
        self.transformed.halo().any(problem.contact.friction.iter().any(|law| law.tension() != 0.0))
    }

    /// What `find` finds of the problem without strengths. At the border of a rank it needs those of points of other ranks as well,
    /// which press on own nodes.
    pub(super) fn with_strength_off<T>(
        &mut self,
        problem: &ContactProblem,
        find: impl FnOnce(&ContactProblem, &mut Multigrid) -> T,
    ) -> T {
        let Some(divided) = &mut self.divided else {
            return find(&problem.without_strength().unwrap_or_else(|| problem.clone()), self);
        };
        let whole = divided.take_strengths_off();
        let found = find(&divided.own(), self);
        self.divided.iter_mut().for_each(|divided| divided.renew(&whole));
        found
    }

    /// The contact points of this rank among those that its whole problem has; of all of a problem on one rank none are named.
    pub fn own_points(&self) -> &[u32] {
        self.divided.as_ref().map_or(&[], |divided| divided.points())
    }

    /// Nodes and matrix entries of each level, the finest first, of all ranks together.
    pub fn level_sizes(&self) -> Vec<(usize, usize)> {
        self.hierarchy.level_sizes()
    }

    /// Nodes of this rank, and nodes of others that they are coupled to.
    pub fn nodes_here(&self) -> [usize; 2] {
        let halo = self.transformed.halo();
        [halo.own(), halo.len() - halo.own()]
    }

    /// The rigid motions of floating bodies, which contact alone supports.
    pub fn motions(&self) -> &RigidMotions {
        &self.transformed.motions
    }
}

/// The parameter of the augmented multipliers times the compliance of the point. From 0.4 to 0.8 the counts hardly change. The
/// compliance has to be local and contain that of the coarse levels: with that of single nodes blocks of cells thirty times
/// flatter than wide take three times as many cycles, or do not converge.
const PARAMETER: f64 = 0.6;

/// Where the certificate does not pass, the residual is reduced further by the factor that the certificate misses, within
/// these bounds. The certificate scales its measures differently from the residual; on the random cases it passes nineteen
/// times of twenty as soon as the residual reaches the tolerance.
const REDUCTION: [f64; 2] = [0.03, 0.3];
/// Targets of the residual.
struct Target;

impl Target {
    /// The certificate is asked here before the residual is reduced farther. Forces of bodies that nothing loads are below what the
    /// certificate takes for none then; where they are reduced farther, what rounding leaves of their loads carries them off.
    const ROUNDING: f64 = 5e-13;
    /// The least, over the tolerance. A certificate that does not pass there fails by rounding.
    const LEAST: f64 = 1e-6;

    /// The one after `target`, whose certificate has not passed.
    fn after(target: f64, certificate: &Certificate) -> f64 {
        let next = target * reduction(certificate);
        if target > Self::ROUNDING { next.max(Self::ROUNDING) } else { next }
    }
}

/// Solves contact with friction on the displacements; `multigrid` is that of `problem`, or of another problem with the
/// same `K` and `B`. `settings.max_iterations` bounds the cycles. `settings.start` is not used, `settings.start_displacement`
/// is; without it floating bodies with wide gaps start from their rigid equilibrium, and from there, as problems with overlaps or without
/// floating bodies from zero, from the solution in the space of the second coarse level.
///
/// Floating bodies are balanced as rigid ones before each cycle as long as the residual is large. If the active sets cycle, further stages
/// follow ([`Status::Stalled`](crate::friction::Status::Stalled) if all fail): springs in place of contact find the sets of bodies
/// that are held, then Coulomb friction is solved by the fixed point on the slip bounds, where a monotone descent minimises the energy of
/// each problem with given friction.
///
/// `Solved` is only reported if the certificate passes; a residual that was small enough but did not certify is reduced
/// further.
///
/// # Panics
/// If `multigrid` is of a problem with another number of unknowns or points, or the start has another length.
pub fn solve_multigrid(
    problem: &ContactProblem,
    multigrid: &mut Multigrid,
    settings: &Settings,
    observer: &mut Watch<Progress>,
) -> Solution {
    if multigrid.has_strength(problem) {
        return solve_without_strength(problem, multigrid, settings, observer);
    }
    solve_with(problem, multigrid, None, settings, observer)
}

/// The same of a problem by a part of its points.
///
/// # Errors
/// If equations depend on one another.
///
/// # Panics
/// As [`solve_multigrid`].
pub(crate) fn solve_part(
    (whole, part): (&ContactProblem, &Part),
    multigrid: &mut Multigrid,
    settings: &Settings,
    observer: &mut Watch<Progress>,
) -> Result<Solution, Error> {
    if multigrid.has_strength(whole) {
        return Ok(part.whole(whole, solve_multigrid(&part.problem, multigrid, settings, observer)));
    }
    let equations = Equations::of_part(whole, part, multigrid)?;
    let of_whole = OfWhole { whole, part, equations: equations.as_ref() };
    let found = solve_with(&part.problem, multigrid, Some(&of_whole), settings, observer);
    multigrid.equations = equations;
    Ok(found)
}

/// The problem that one is a part of, and its equations over many nodes.
struct OfWhole<'a> {
    whole: &'a ContactProblem,
    part: &'a Part,
    equations: Option<&'a Equations>,
}

/// The solution of `problem`, or of the whole problem that it is a part of.
fn solve_with(
    problem: &ContactProblem,
    multigrid: &mut Multigrid,
    of_whole: Option<&OfWhole>,
    settings: &Settings,
    observer: &mut Watch<Progress>,
) -> Solution {
    let moved = of_whole.and_then(|of| start_of_equations(of, multigrid));
    let Multigrid { transformed, hierarchy, divided, .. } = multigrid;
    let divided = divided.as_ref();
    let equations = of_whole.and_then(|of| of.equations);
    let sizes = (transformed.nodes.of.len(), transformed.points.len());
    assert_eq!(sizes, (problem.unknowns(), problem.points()), "unknowns and points of the set-up and of the problem");
    if let Some(u) = &settings.start_displacement {
        assert_eq!(u.len(), sizes.0, "displacements to start from");
    }
    transformed.set_load(&problem.elastic.f);
    let transformed = &*transformed;
    let laws = point_laws(problem, transformed);
    let motions = equations.map_or(&transformed.motions, |equations| &equations.motions);
    let floats = floats(transformed, equations);
    let convex = !transformed.halo().any(!convex(&problem.contact.friction));
    let max_iterations = settings.max_iterations;
    let asked = settings.path == SolverPath::Multigrid;
    let traits = Traits { floats, convex, has_equations: equations.is_some(), asked, max_iterations };
    let begin = start(problem, (transformed, &laws, equations), (hierarchy, moved), settings);
    let begin = if settings.start_displacement.is_some() { begin.given() } else { begin };
    let mut history = Vec::new();
    let mut observe = |cycle: usize, residual: f64, states: [usize; 3]| {
        let progress = progress(cycle, residual, states);
        history.push(progress);
        observer(&progress)
    };
    let (mut state, mut end, mut target) = (State::default(), End::Stalled, settings.tolerance);
    let floating = FloatingBodies::new(problem, transformed, motions);
    let (mut certified, mut best): (_, Option<(f64, Iterate)>) = (None, None);
    for stage in &STAGES {
        if !(stage.entry)(end, &traits) {
            continue;
        }
        let first = match &best {
            Some((violated, at)) if *violated <= stage.near => State::at(at.u.clone(), &transformed.k),
            _ => begin.clone(),
        };
        state = first.after(&state);
        let subproblem = Subproblem {
            transformed,
            laws: &laws,
            tolerance: target,
            max_cycles: (stage.budget)(state.cycles, &traits),
            max_resets: (stage.max_resets)(&traits),
            max_violation: (stage.max_violation)(&traits),
            floating: floating.as_ref(),
            tightening: None,
            equations,
        };
        loop {
            let subproblem = Subproblem { tolerance: target, ..subproblem };
            end = (stage.run)(&subproblem, hierarchy, &mut state, &mut observe);
            state.resets += std::mem::take(&mut state.monitor.resets);
            if end != End::Converged {
                break;
            }
            let converged = solution(problem, transformed, (divided, of_whole), &state, end, settings.tolerance);
            target = Target::after(target, &converged.certificate);
            if converged.certificate.is_as_good_as_the_data() || target < Target::LEAST * settings.tolerance {
                certified = Some(converged);
                break;
            }
        }
        if end == End::Stalled {
            state.go_back();
        }
        if matches!(end, End::Stalled | End::Limit) {
            keep_best(&mut best, &subproblem, &state.iterate);
        }
    }
    let solution = certified.unwrap_or_else(|| {
        if let Some((_, iterate)) = best.filter(|_| end != End::Interrupted) {
            state.iterate = iterate;
        }
        // A stage that ends by its own budget has failed; the user's leaves something to raise.
        let own_budget = end == End::Limit && state.cycles < settings.max_iterations;
        let end = if own_budget { End::Stalled } else { end };
        solution(problem, transformed, (divided, of_whole), &state, end, settings.tolerance)
    });
    Solution { history, ..solution }
}

/// The solution where points of this rank or of others have a tensile strength, by that of the problem without.
fn solve_without_strength(
    problem: &ContactProblem,
    multigrid: &mut Multigrid,
    settings: &Settings,
    observer: &mut Watch<Progress>,
) -> Solution {
    let tolerance = settings.tolerance;
    until_certified(problem, settings, &mut |settings| {
        let mut found = multigrid
            .with_strength_off(problem, |shifted, multigrid| solve_multigrid(shifted, multigrid, settings, observer));
        problem.take_strength_off(&mut found.lambda);
        let divided = multigrid.divided.as_ref();
        found.certificate = judged(problem, divided, (&found.u, &found.lambda), tolerance);
        if let Some(divided) = divided {
            // Another attempt starts from there.
            found.u = divided.everywhere(&found.u);
        }
        found
    })
}

/// Whether contact alone supports some body beside the equations; the same on all ranks.
pub(super) fn floats(transformed: &Transformed, equations: Option<&Equations>) -> bool {
    match equations {
        Some(equations) => !equations.motions.is_empty(),
        None => transformed.floats(),
    }
}

/// The equilibrium of floating bodies that equations move as rigid ones: fields would strain them.
fn start_of_equations(of: &OfWhole, multigrid: &Multigrid) -> Option<Vec<f64>> {
    let moves = multigrid.transformed.floats() && of.equations.is_some_and(Equations::move_something);
    let at_rest = || vec![0.0; of.whole.unknowns()];
    moves.then(|| multigrid.rigid_equilibrium((of.whole, Some(of.part)), &[], &[], at_rest()).0)
}

/// Where the iteration begins: at the displacements given, or else where its start looks for them.
pub(super) fn start(
    problem: &ContactProblem,
    (transformed, laws, equations): (&Transformed, &[PointLaw], Option<&Equations>),
    (hierarchy, moved): (&mut Hierarchy, Option<Vec<f64>>),
    settings: &Settings,
) -> State {
    let given = settings.start_displacement.as_ref().map(|u| State::at(transformed.to_frames(u), &transformed.k));
    if equations.is_some() {
        // Coarse spaces know nothing of what equations prescribe.
        let moved = || moved.map(|u| State::at(transformed.to_frames(&u), &transformed.k));
        return given.or_else(moved).unwrap_or_else(|| State::zero(transformed.f.len()));
    }
    if let Some(given) = given.filter(|given| !none_is_nearer(transformed, laws, &given.iterate)) {
        return given;
    }
    let rigid = start_of_floating_bodies(problem, transformed, laws).map(|u| transformed.to_frames(&u));
    // Floating bodies that lie in others move at once. Pressed together by loads alone they are found from zero as fast.
    let overlaps = transformed.halo().any(laws.iter().any(|law| law.target[0] < 0.0));
    let found = if transformed.floats() && rigid.is_none() && !overlaps {
        None
    } else {
        coarse_start::start(transformed, laws, hierarchy, rigid.as_ref())
    };
    match found.or(rigid) {
        Some(u) => State::at(u, &transformed.k),
        None => State::zero(transformed.f.len()),
    }
}

/// Whether displacements leave far more out of balance than none do, as those of the step before one in which all loads vanish:
/// from there contact forces fall together with the residual, which never gets small beside them.
fn none_is_nearer(transformed: &Transformed, laws: &[PointLaw], given: &Iterate) -> bool {
    let problem = Subproblem {
        transformed,
        laws,
        tolerance: 0.0,
        max_cycles: 0,
        max_resets: 0,
        max_violation: f64::INFINITY,
        floating: None,
        tightening: None,
        equations: None,
    };
    let left = |mut at: Iterate| {
        at.conditions = judged_by_law(&problem, &at);
        squares(&problem, &at)[0]
    };
    let zero = State::zero(given.u.len()).iterate;
    let mut both = [left(zero), left(given.clone())];
    transformed.halo().sum(&mut both);
    both[0] < NEARER.powi(2) * both[1]
}

/// What no displacements leave out of balance, over what those given do, below which the iteration begins at none.
const NEARER: f64 = 1e-6;

/// The factor for the target after a certificate that does not pass.
fn reduction(certificate: &Certificate) -> f64 {
    let wanted = 0.5 / certificate.missed();
    if wanted.is_nan() { REDUCTION[0] } else { wanted.clamp(REDUCTION[0], REDUCTION[1]) }
}

pub(super) fn progress(cycle: usize, residual: f64, [open, stick, slip]: [usize; 3]) -> Progress {
    Progress { phase: Phase::Multigrid, iteration: cycle, residual, products: cycle, open, stick, slip }
}

/// The law at each point, in its frame.
pub(super) fn point_laws(problem: &ContactProblem, transformed: &Transformed) -> Vec<PointLaw> {
    let m = problem.points();
    let reference = problem.isotropic_slip_reference();
    let law = |j: usize| {
        let target = [problem.contact.gap[j], reference[j], reference[m + j]];
        // The mean over both tangents: scaled displacements are smaller by a factor below one across the first.
        let parameter = PARAMETER / (transformed.points[j].compliance * transformed.points[j].scale[2]);
        PointLaw { friction: problem.contact.friction[j], target, parameter }
    };
    (0..m).map(law).collect()
}

/// Keeps the iterate, with the contact conditions of the law there, if it violates the law less than the one kept.
fn keep_best(best: &mut Option<(f64, Iterate)>, problem: &Subproblem<'_>, at: &Iterate) {
    let mut at = at.clone();
    let violated = judge(problem, &mut at);
    if violated.is_finite() && best.as_ref().is_none_or(|(least, _)| violated < *least) {
        *best = Some((violated, at));
    }
}

/// The equilibrium of floating bodies as rigid ones on an elastic foundation, which finds the points that support them. `None`
/// where no body floats, or where the load would close all gaps: with all points closed a body at the limit of friction does
/// not slide off.
fn start_of_floating_bodies(
    problem: &ContactProblem,
    transformed: &Transformed,
    laws: &[PointLaw],
) -> Option<Vec<f64>> {
    let load = norm(transformed.halo(), &transformed.f);
    let wide = |(p, gap): (&Point, &f64)| p.floats && *gap > p.compliance * load;
    let wide = transformed.points.iter().zip(&problem.contact.gap).any(wide);
    if !transformed.halo().is_alone() {
        let floating = if transformed.halo().any(wide) {
            FloatingBodies::new(problem, transformed, &transformed.motions)
        } else {
            None
        };
        return floating.map(|floating| floating.start(transformed, laws));
    }
    wide.then(|| rigid_equilibrium(problem, &transformed.motions, &[], &[], vec![0.0; problem.unknowns()]).0)
}

/// Whether the solution minimises an energy: no slip bound depends on a normal force.
fn convex(friction: &[Friction]) -> bool {
    let energy = |law: &Friction| match law {
        // No energy knows that an open point has lost its cohesion.
        Friction::Cohesive { .. } => false,
        _ => law.coefficient().is_none_or(|coefficient| coefficient == 0.0),
    };
    friction.iter().all(energy)
}

/// Multipliers from the balance at the contact nodes, made admissible.
pub(super) fn multipliers(problem: &ContactProblem, transformed: &Transformed, at: &Iterate) -> Vec<f64> {
    let m = problem.points();
    let mut lambda = vec![0.0; 3 * m];
    for (j, (p, condition)) in transformed.points.iter().zip(&at.conditions).enumerate() {
        let force = at.force(transformed, p.node);
        let friction = if condition.state == PointState::Slip { condition.friction } else { [force[1], force[2]] };
        let normal = if condition.constraint.constrained[0] { force[0] } else { 0.0 };
        let values = [normal, friction[0], friction[1]];
        if condition.state != PointState::Open {
            (0..3).filter(|&c| p.has_row[c]).for_each(|c| lambda[c * m + j] = values[c]);
        }
    }
    make_admissible(&problem.contact.friction, &mut lambda);
    problem.out_of_isotropic(&mut lambda);
    lambda
}

/// The state for users: with given friction the tangential conditions hold at points without pressure too, which are open.
fn state_of((condition, friction): (&ContactCondition, &Friction)) -> PointState {
    match condition.constraint.constrained[0] || *friction == Friction::Bonded {
        true => condition.state,
        false => PointState::Open,
    }
}

/// The certificate of displacements and multipliers, of all ranks together where the problem is divided.
fn judged(
    problem: &ContactProblem,
    divided: Option<&Divided>,
    (u, lambda): (&[f64], &[f64]),
    tolerance: f64,
) -> Certificate {
    match divided {
        Some(divided) => divided.certify(u, lambda, tolerance),
        None => certify(problem, u, lambda, tolerance),
    }
}

/// The iterate with its multipliers and their certificate.
fn solution(
    problem: &ContactProblem,
    transformed: &Transformed,
    (divided, of_whole): (Option<&Divided>, Option<&OfWhole>),
    state: &State,
    end: End,
    tolerance: f64,
) -> Solution {
    let lambda = multipliers(problem, transformed, &state.iterate);
    let u = transformed.out_of_frames(&state.iterate.u);
    let states: Vec<PointState> =
        state.iterate.conditions.iter().zip(&problem.contact.friction).map(state_of).collect();
    let (problem, lambda, states) = match of_whole {
        None => (problem, lambda, states),
        Some(OfWhole { whole, part, equations }) => {
            let multipliers = equations.map_or(&[][..], |equations| equations.own(&state.iterate.multipliers));
            (*whole, part.of_all(whole, &lambda, multipliers), part.states_of_all(whole, &states))
        }
    };
    let certificate = judged(problem, divided, (&u, &lambda), tolerance);
    let status = end.status(certificate.passed);
    let counts = Counts { cycles: state.cycles, restarts: state.resets, ..Counts::default() };
    let path = SolverPath::Multigrid;
    Solution { status, path, u, lambda, states, certificate, counts, history: Vec::new() }
}
