//! Load steps: one static problem after the other, each with the slip of the last one as its reference.
//!
//! Implicit Euler: the slip rate in Coulomb's law is the slip since the last step over the time between them, and the
//! time cancels. Stiffness and `B` stand, so that one factor or one multigrid hierarchy serves all steps.

use std::ops::ControlFlow;

use super::balance::{Balance, BodyState, Counted, balance};
use super::bolts::{BoltSearch, bolt_states};
use super::clearance::{close_clearance, escape_of_bolts};
use super::discretisation::add_estimate;
use super::extrapolation::{KEPT, extrapolated, weights};
use super::free_motions::move_back;
use super::passing;
use super::path::{other_starts, sliding, solve_again, tightened_by_multigrid, uniqueness_facts};
use super::record::StepRecord;
use super::strength;
use super::stretch::sought_forces;
use super::{Event, Outcome, Settings, StepLine};
use crate::Error;
use crate::certificate::certify;
use crate::contact::equilibrium::{no_equilibrium, no_equilibrium_with};
use crate::contact::escape::Escape;
use crate::contact::sliding::Sliding;
use crate::contact::{ContactProblem, Friction, Moved};
use crate::friction::{self, Counts, Method, PointState, Progress, Solution, SolverPath, Status};
use crate::io::case::StepSpec;
use crate::io::step::StepFile;
use crate::linalg::Watch;
use crate::run::pose::axis::Position;
use crate::run::pose::bolts::{Target, tightened};
use crate::run::pose::load_state::{LoadState, apply, load_state, note_where_it_stands, slid};
use crate::run::pose::memory::output_room;
use crate::run::pose::{Prepared, Seconds, place};
use crate::solve::Kept;

/// A load step, given to [`KeepStep`].
#[derive(Debug)]
pub struct Step<'a> {
    /// From 1.
    pub number: usize,
    /// Whether it is solved: a step that is not is the last one, and no run goes on from it.
    pub finished: bool,
    /// Its answer.
    pub outcome: &'a Outcome,
    /// What a later run needs to go on from here.
    pub file: StepFile,
    /// The records of all steps so far, this one the last.
    pub records: &'a [StepRecord],
}

/// The steps an earlier run of the same case has finished.
#[derive(Debug, Clone)]
pub struct Restart {
    /// Records of the finished steps.
    pub records: Vec<StepRecord>,
    /// The last of them.
    pub last: StepFile,
    /// Those before it, as far as they are needed, the latest one last.
    pub before: Vec<StepFile>,
    /// Iterations of the last step, as its log tells them; none where it does not.
    pub history: Vec<Progress>,
}

/// Keeps each step before the next one begins.
pub type KeepStep<'a> = dyn FnMut(&Prepared, &Step) -> Result<(), Error> + 'a;

/// Where the loop stands.
struct March {
    at: Position,
    body: BodyState,
    /// Sliding of each point since the start, length, `2m`.
    slid: Vec<f64>,
    /// The last answers with what acted, the latest one last.
    answers: Vec<Answer>,
    /// The last step with the slip reference it had.
    last: Option<(Outcome, Vec<f64>)>,
    records: Vec<StepRecord>,
    /// Solves of the present step, those that failed included.
    attempts: usize,
    /// Where everything has moved to by the end of the last step.
    moved: Moved,
    /// The laws with the strengths left by then.
    laws: Vec<Friction>,
    /// The points whose strength is lost by then.
    lost: Vec<bool>,
}

/// What acts at a time, and the answer.
struct Answer {
    t: f64,
    f: Vec<f64>,
    gap: Vec<f64>,
    u: Vec<f64>,
    lambda: Vec<f64>,
}

/// Solves all load steps of a prepared case, from the start or from where `restart` ends; the answer is that of the
/// last step, and `prepared` holds the problem it solves.
///
/// A step that does not end certified is tried again from zero, then halved up to six times; after that the run ends
/// with the status of the shortest. It also ends where a step [passes through](Status::PassesThrough) named surfaces. An interrupted run ends with its last finished step, or with [`Error::interrupted`].
///
/// # Errors
/// As [`solve`](super::solve()); expressions that are not finite; what `keep` returns.
pub fn solve_steps(
    prepared: &mut Prepared,
    settings: &Settings,
    restart: Option<Restart>,
    keep: &mut KeepStep,
    observer: &mut Watch<Event>,
) -> Result<Outcome, Error> {
    // What each step writes; the solver asks for its own.
    output_room(&prepared.mesh, settings.pictures, &settings.memory)
        .map_err(|error| place::at(&prepared.mesh_spot, error))?;
    let steps = prepared.loading.steps.clone();
    let [mesh, assembly, contact] = prepared.seconds;
    let mut seconds = Seconds { mesh, assembly, contact, ..Seconds::default() };
    let by_factor =
        restart.as_ref().and_then(|r| r.records.last()).is_some_and(|last| last.answer.path != SolverPath::Multigrid);
    let mut kept = Kept::deciding(prepared.multigrid_first && !by_factor);
    kept.why_direct = restart.as_ref().and_then(|r| r.records.last()?.answer.path_reason.clone());
    let mut march = start(prepared, settings, restart)?;
    let mut interrupted = false;
    while let Some([begin, t]) = march.at.span(&steps) {
        let number = march.records.len() + 1;
        if observer(&Event::Step { number, t, dt: t - begin }).is_break() {
            interrupted = true;
            break;
        }
        let (loads, mut outcome) = match tighten(prepared, settings, &mut march, &mut kept, t, observer) {
            Err(error) if error.interrupted => {
                interrupted = true;
                break;
            }
            tightened => tightened?,
        };
        if loads.travel == march.body.loads.travel {
            let (before, tolerance) = (Some(&march.body.u[..]), settings.solver.tolerance);
            move_back(&prepared.problem, &prepared.motions, before, tolerance, &mut outcome.solution);
        }
        let now = passing::moved(prepared, &outcome.solution.u, t)?;
        passing::look(prepared, &march.moved, &now, &mut outcome);
        add_estimate(prepared, &mut outcome);
        seconds.add(&outcome.seconds);
        let finished = match outcome.solution.status {
            Status::Solved | Status::Uncertified => true,
            Status::Interrupted => {
                interrupted = true;
                let reference = || prepared.problem.contact.slip_reference.clone();
                march.last.get_or_insert_with(|| (outcome, reference()));
                break;
            }
            // With contact where none was looked for the steps before may have other answers.
            Status::PassesThrough => false,
            Status::MaxIterations | Status::Stalled | Status::NoEquilibrium => {
                // What the numbers given cannot tell no shorter step finds out.
                if !outcome.solution.certificate.is_as_good_as_the_data() && halve(&mut march, &steps, observer) {
                    continue;
                }
                outcome.sliding = limit_load(prepared, &march, &outcome);
                false
            }
        };
        let line = finish(prepared, &mut march, loads, &outcome, [begin, t], finished);
        if finished {
            note_where_it_stands(prepared, &march.body.loads, &outcome.solution.u, t);
        }
        let file = file(prepared, &march, &outcome, t);
        keep(prepared, &Step { number, finished, outcome: &outcome, file, records: &march.records })?;
        march.moved = now;
        march.last = Some((outcome, prepared.problem.contact.slip_reference.clone()));
        if !finished {
            break;
        }
        let _ = observer(&Event::Finished(line));
    }
    end(prepared, settings, march, seconds, &mut kept, interrupted, observer)
}

/// Halves the increment; false where it is as short as it may be.
fn halve(march: &mut March, steps: &[StepSpec], observer: &mut Watch<Event>) -> bool {
    let Some(shorter) = march.at.halve() else { return false };
    march.at = shorter;
    if let Some([begin, t]) = shorter.span(steps) {
        let _ = observer(&Event::Halved { t: begin, dt: t - begin });
    }
    true
}

/// What friction resists at the normal forces of the last step that was solved, or without one at those of `outcome`.
fn limit_load(prepared: &Prepared, march: &March, outcome: &Outcome) -> Option<Sliding> {
    let solved = march.body.lambda.iter().any(|&force| force != 0.0);
    let lambda = if solved { &march.body.lambda } else { &outcome.solution.lambda };
    sliding(prepared, outcome.solution.status, lambda)
}

fn start(prepared: &mut Prepared, settings: &Settings, restart: Option<Restart>) -> Result<March, Error> {
    let (n, m) = (prepared.problem.unknowns(), prepared.problem.points());
    let nothing = LoadState::start(n, prepared.model.dofs.prescribed.len(), m);
    let body = BodyState { loads: nothing, u: vec![0.0; n], lambda: vec![0.0; 3 * m], balance: Balance::default() };
    let begin = March {
        at: Position::start(),
        body,
        slid: vec![0.0; 2 * m],
        answers: Vec::new(),
        last: None,
        records: Vec::new(),
        attempts: 0,
        moved: passing::at_rest(prepared),
        laws: prepared.problem.contact.friction.clone(),
        lost: Vec::new(),
    };
    let Some(Restart { records, last, before, history }) = restart else { return Ok(begin) };
    let at = Position::read(last.position, &prepared.loading.steps).ok_or_else(|| {
        Error::new("", "the last finished step lies beyond the steps of the case", "solve the case from its beginning")
    })?;
    if last.shortening.len() != prepared.loading.bolts.len() {
        let what = "the last finished step has other bolts than the case";
        return Err(Error::new("", what, "solve the case from its beginning"));
    }
    // What begins later than a step plays no part in it: the last list serves both.
    prepared.loading.stood.clone_from(&last.stood);
    let loads = tightened(prepared, load_state(prepared, last.t)?, &last.shortening);
    let unslid = vec![0.0; 2 * m];
    apply(prepared, &loads, &unslid);
    prepared.problem.contact.slip_reference.clone_from(&last.slip_reference);
    strength::restore(prepared, &last.strength);
    let (laws, lost) = (prepared.problem.contact.friction.clone(), prepared.loading.lost.clone());
    // As when the step was solved: what had been slid before it.
    if let Some(step) = before.last() {
        let loads = tightened(prepared, load_state(prepared, step.t)?, &step.shortening);
        prepared.loading.slid = slid(prepared, &loads, &step.u);
    }
    let slid = slid(prepared, &loads, &last.u);
    let moved = passing::moved(prepared, &last.u, last.t)?;
    let mut outcome = restored(prepared, settings, &last, records.last(), history);
    add_estimate(prepared, &mut outcome);
    let [work, elastic, dissipation] = last.energy;
    let balance = Balance { work, elastic, dissipation };
    let answer =
        |s: &StepFile| Answer { t: s.t, f: s.f.clone(), gap: s.gap.clone(), u: s.u.clone(), lambda: s.lambda.clone() };
    let needed = &before[before.len().saturating_sub(KEPT - 1)..];
    let answers = needed.iter().chain([&last]).map(answer).collect();
    let body = BodyState { loads, u: last.u, lambda: last.lambda, balance };
    let last = Some((outcome, last.slip_reference));
    Ok(March { at, body, slid, answers, last, records, moved, laws, lost, ..begin })
}

/// The answer of a step that an earlier run has found, judged anew.
fn restored(
    prepared: &Prepared,
    settings: &Settings,
    last: &StepFile,
    record: Option<&StepRecord>,
    history: Vec<Progress>,
) -> Outcome {
    let certificate = certify(&prepared.problem, &last.u, &last.lambda, settings.solver.tolerance);
    let status = if certificate.passed { Status::Solved } else { Status::Uncertified };
    let solution = Solution {
        status,
        path: record.map_or(SolverPath::Solves, |record| record.answer.path),
        u: last.u.clone(),
        lambda: last.lambda.clone(),
        states: last.states.iter().filter_map(|&code| PointState::of_code(code)).collect(),
        certificate,
        counts: record.map_or(Counts::default(), |record| record.answer.counts.counts()),
        history,
    };
    let path_reason = record.and_then(|record| record.answer.path_reason.clone());
    Outcome { path_reason, ..Outcome::new(solution, settings) }
}

/// Solves the step to time `t`. Bolts whose force is given are tightened until it is reached: multigrid finds their
/// shortenings beside the displacements. From there, or without it, Broyden's method (1965) goes on: the force through a
/// cut grows with the shortening, at most by the stiffness of its cells, and in proportion as long as no point changes
/// its state.
fn tighten(
    prepared: &mut Prepared,
    settings: &Settings,
    march: &mut March,
    kept: &mut Kept,
    t: f64,
    observer: &mut Watch<Event>,
) -> Result<(LoadState, Outcome), Error> {
    // An attempt that has failed leaves no trace.
    prepared.problem.contact.friction.clone_from(&march.laws);
    prepared.loading.lost.clone_from(&march.lost);
    let base = load_state(prepared, t)?;
    let targets = prepared.loading.targets(march.at.step, t)?;
    let before = march.body.loads.initial.shortening.clone();
    let stiffness: Vec<f64> = prepared.loading.bolts.iter().map(|bolt| bolt.cut.stiffness).collect();
    let tolerance = settings.solver.tolerance;
    let mut search = BoltSearch::new(&stiffness, &targets, &before, tolerance).among(&prepared.problem);
    let from_rest: Vec<bool> = (0..targets.len()).map(|number| before.get(number).is_none_or(|&s| s == 0.0)).collect();
    apply(prepared, &base, &march.slid);
    // What is carried away comes to rest nowhere: the first solve says so.
    let draws = |target: &Target| matches!(target, Target::Force(_));
    search.loads = prepared.problem.elastic.f.iter().map(|f| f.abs()).sum();
    prepared.loading.of_bolts = None;
    if targets.iter().any(draws) && no_equilibrium(&prepared.problem, &prepared.motions).is_none() {
        if let Some(escape) = escape_of_bolts(prepared, &targets) {
            return end_of_bolts(prepared, settings, march, (kept, &base, &targets, escape), observer);
        }
        if targets.iter().zip(&from_rest).any(|(target, from_rest)| *from_rest && draws(target)) {
            close_clearance(prepared, &targets, &from_rest, &mut search.shortening);
        }
    }
    let (mut spent, mut counts) = (Seconds::default(), Counts::default());
    let mut from = None;
    // From rest the shortenings are far from the final ones, and a flange finds its sets only from a solve with fixed ones.
    let mut tries_together = if search.may_be_found_together() { 2 } else { 0 };
    // Where the search by the factor fails multigrid is tried, as it is for a solve without bolts.
    let mut changes_over = settings.solver.path == SolverPath::Auto
        && settings.method.method == Method::Newton
        && search.may_be_found_together()
        && !kept.begins_with_multigrid(&prepared.problem, &settings.solver);
    let mut failed: Option<(LoadState, Outcome)> = None;
    let first = search.clone();
    loop {
        let mut loads = tightened(prepared, base.clone(), &search.shortening);
        apply(prepared, &loads, &march.slid);
        let mut start = from.take().unwrap_or_else(|| predicted(prepared, march, t));
        if tries_together > 0 {
            tries_together -= 1;
            let start_displacement = start.0.iter().any(|&x| x != 0.0).then(|| start.1.clone());
            let solver = friction::Settings { start_displacement, ..settings.solver.clone() };
            let with_start = Settings { solver, ..settings.clone() };
            let sought = sought_forces(prepared, search.sought());
            let together = tightened_by_multigrid(prepared, &with_start, (&sought, failed.is_some()), kept, observer)?;
            // Where it is solved, or multigrid is not for the problem, there is nothing to try again.
            if together.as_ref().is_none_or(|(found, _)| found.solved) {
                tries_together = 0;
            }
            let solved = together.as_ref().is_some_and(|(found, _)| found.solved);
            if let Some((found, seconds)) = together {
                spent.add(&seconds);
                counts.add(&found.counts);
                if found.solved {
                    search.lengthen(&found.shortening);
                    loads = tightened(prepared, base.clone(), &search.shortening);
                    apply(prepared, &loads, &march.slid);
                    start = (found.lambda, found.u);
                }
            }
            if let Some((loads, mut outcome)) = failed.take().filter(|_| !solved) {
                apply(prepared, &loads, &march.slid);
                (outcome.seconds, outcome.solution.counts) = (spent, counts);
                return Ok((loads, outcome));
            }
        }
        let mut outcome = attempt(prepared, settings, march, &start, kept, observer)?;
        spent.add(&outcome.seconds);
        counts.add(&outcome.solution.counts);
        let solved = matches!(outcome.solution.status, Status::Solved | Status::Uncertified);
        // Each solve takes the strength of some points, so that this ends.
        if solved && strength::lose(prepared, &outcome.solution.states) {
            from = Some((outcome.solution.lambda, outcome.solution.u));
            march.attempts -= 1;
            continue;
        }
        let forces = bolt_states(prepared, &outcome).iter().map(|bolt| bolt.force).collect::<Vec<f64>>();
        let found = search.next(&forces);
        let stalls = matches!(outcome.solution.status, Status::MaxIterations | Status::Stalled);
        if changes_over && (stalls || solved && found == ControlFlow::Break(false)) {
            (changes_over, tries_together) = (false, 1);
            if solved {
                outcome.solution.status = Status::Stalled;
            }
            failed = Some((loads, outcome));
            search.clone_from(&first);
            prepared.problem.contact.friction.clone_from(&march.laws);
            prepared.loading.lost.clone_from(&march.lost);
            continue;
        }
        if !solved || found.is_break() {
            if solved && found == ControlFlow::Break(false) {
                outcome.solution.status = Status::Stalled;
            }
            (outcome.seconds, outcome.solution.counts) = (spent, counts);
            return Ok((loads, outcome));
        }
        let grown = |x: Vec<f64>| x.into_iter().map(|x| search.growth() * x).collect();
        from = Some((grown(outcome.solution.lambda), grown(outcome.solution.u)));
        // Only solves that fail make a step take more than one attempt.
        march.attempts -= 1;
    }
}

/// The answer where the loads carry away what bolts hold: with the shortenings of the step before.
fn end_of_bolts(
    prepared: &mut Prepared,
    settings: &Settings,
    march: &mut March,
    (kept, base, targets, escape): (&mut Kept, &LoadState, &[Target], Escape),
    observer: &mut Watch<Event>,
) -> Result<(LoadState, Outcome), Error> {
    let before = &march.body.loads.initial.shortening;
    let shortening = |(number, target): (usize, &Target)| match target {
        Target::Shortening(s) => *s,
        Target::Force(_) | Target::Locked => before.get(number).copied().unwrap_or(0.0),
    };
    let shortenings: Vec<f64> = targets.iter().enumerate().map(shortening).collect();
    let loads = tightened(prepared, base.clone(), &shortenings);
    apply(prepared, &loads, &march.slid);
    let from = (march.body.lambda.clone(), march.body.u.clone());
    let mut outcome = attempt(prepared, settings, march, &from, kept, observer)?;
    if outcome.solution.status != Status::Interrupted {
        outcome.solution.status = Status::NoEquilibrium;
        prepared.loading.of_bolts = Some(escape);
    }
    Ok((loads, outcome))
}

/// Solves the step from the multipliers and displacements given, and if that fails from zero.
fn attempt(
    prepared: &Prepared,
    settings: &Settings,
    march: &mut March,
    from: &(Vec<f64>, Vec<f64>),
    kept: &mut Kept,
    observer: &mut Watch<Event>,
) -> Result<Outcome, Error> {
    let with = |start: Option<Vec<f64>>, start_displacement: Option<Vec<f64>>| Settings {
        solver: friction::Settings { start, start_displacement, ..settings.solver.clone() },
        ..settings.clone()
    };
    march.attempts += 1;
    let problem = &prepared.problem;
    let unloaded = Solution::nothing_acts(problem) && !may_be_locked(prepared, march);
    if unloaded && Solution::may_rest(problem) {
        let by_multigrid = kept.begins_with_multigrid(problem, &settings.solver);
        let path = if by_multigrid { SolverPath::Multigrid } else { SolverPath::Solves };
        let certificate = |u: &[f64], lambda: &[f64]| certify(problem, u, lambda, settings.solver.tolerance);
        let of = (problem.unknowns(), &problem.contact.friction[..]);
        if let Some(at_rest) = Solution::at_rest(of, path, &certificate) {
            return Ok(Outcome::new(at_rest, settings));
        }
    }
    if from.0.iter().any(|&x| x != 0.0) && !unloaded {
        let path = settings.solver.path;
        let (factor, newton) = (path != SolverPath::Multigrid, settings.method.method == Method::Newton);
        let warm = with(factor.then(|| from.0.clone()), newton.then(|| from.1.clone()));
        let warm = solve_again(prepared, &warm, kept, observer)?;
        if !matches!(warm.solution.status, Status::MaxIterations | Status::Stalled) {
            return Ok(warm);
        }
        march.attempts += 1;
        let mut cold = solve_again(prepared, &with(None, None), kept, observer)?;
        cold.seconds.add(&warm.seconds);
        cold.solution.counts.add(&warm.solution.counts);
        return Ok(cold);
    }
    solve_again(prepared, &with(None, None), kept, observer)
}

/// Whether friction may hold a floating body without any load, as it does a wedge: where something has slid, and contact that
/// carries the load of the last step can carry it reversed as well. Both together are forces in balance.
fn may_be_locked(prepared: &Prepared, march: &March) -> bool {
    let Some(last) = march.answers.last().filter(|_| !prepared.motions.is_empty()) else { return false };
    let has_slid = prepared.problem.contact.slip_reference.iter().any(|&slid| slid != 0.0);
    let reversed: Vec<f64> = last.f.iter().map(|f| -f).collect();
    has_slid && no_equilibrium_with(&prepared.problem, &prepared.motions, &reversed).is_none()
}

/// Multipliers and displacements at `t`, extrapolated from the last steps.
fn predicted(prepared: &Prepared, march: &March, t: f64) -> (Vec<f64>, Vec<f64>) {
    if march.answers.is_empty() {
        return (march.body.lambda.clone(), march.body.u.clone());
    }
    let of = |values: fn(&Answer) -> &Vec<f64>, weights: &[f64]| {
        extrapolated(&march.answers.iter().map(|answer| &values(answer)[..]).collect::<Vec<_>>(), weights)
    };
    let ContactProblem { elastic, contact, .. } = &prepared.problem;
    let squares = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    let off = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
    let mut away = |weights: &[f64]| {
        let away =
            [off(&of(|answer| &answer.f, weights), &elastic.f), off(&of(|answer| &answer.gap, weights), &contact.gap)];
        [away, [squares(&elastic.f), squares(&contact.gap)]]
    };
    let times: Vec<f64> = march.answers.iter().map(|answer| answer.t).collect();
    let weights = weights(&times, t, &mut away);
    (of(|answer| &answer.lambda, &weights), of(|answer| &answer.u, &weights))
}

/// Takes the solved step into the march.
fn finish(
    prepared: &Prepared,
    march: &mut March,
    loads: LoadState,
    outcome: &Outcome,
    [begin, t]: [f64; 2],
    finished: bool,
) -> StepLine {
    let (problem, steps) = (&prepared.problem, &prepared.loading.steps);
    let Solution { u, lambda, .. } = &outcome.solution;
    let balance = balance(problem, &march.body, &loads, u, lambda, &Counted::ALL);
    let number = march.records.len() + 1;
    let name = steps[march.at.step].name.as_str();
    let record = StepRecord::of(prepared, outcome, (number, name), [begin, t], march.attempts, &balance);
    let all = &record.answer.contact;
    let [x, y, z] = all.tangential_force;
    let line = StepLine {
        number,
        t,
        iterations: record.answer.counts.steps(),
        open: all.open,
        stick: all.stick,
        slip: all.slip,
        normal_force: all.normal_force,
        tangential_force: (x * x + y * y + z * z).sqrt(),
        dissipation: balance.dissipation,
    };
    march.records.push(record);
    march.laws.clone_from(&problem.contact.friction);
    march.lost.clone_from(&prepared.loading.lost);
    march.slid = slid(prepared, &loads, u);
    if march.answers.len() == KEPT {
        march.answers.remove(0);
    }
    let (f, gap) = (problem.elastic.f.clone(), problem.contact.gap.clone());
    march.answers.push(Answer { t, f, gap, u: u.clone(), lambda: lambda.clone() });
    march.body = BodyState { loads, u: u.clone(), lambda: lambda.clone(), balance };
    march.attempts = 0;
    if finished {
        march.at = march.at.advance(steps);
    }
    line
}

fn file(prepared: &Prepared, march: &March, outcome: &Outcome, t: f64) -> StepFile {
    let (problem, body) = (&prepared.problem, &march.body);
    StepFile {
        t,
        f: problem.elastic.f.clone(),
        gap: problem.contact.gap.clone(),
        slip_reference: problem.contact.slip_reference.clone(),
        strength: strength::kept(prepared),
        laws: body.loads.friction.clone().unwrap_or_default(),
        out: body.loads.out.iter().map(|(point, _)| *point).collect(),
        stood: prepared.loading.stood.clone(),
        motion: body.loads.motion.clone(),
        rounding: problem.contact.rounding,
        support_load: body.loads.support_load.clone(),
        support_free_load: body.loads.load.clone(),
        support_displacement: body.loads.displacement.clone(),
        initial_load: [body.loads.initial.load.as_slice(), &body.loads.initial.support_load].concat(),
        initial_energy: body.loads.initial.energy,
        shortening: body.loads.initial.shortening.clone(),
        u: body.u.clone(),
        lambda: body.lambda.clone(),
        states: outcome.solution.states.iter().map(|state| state.code().into()).collect(),
        energy: [body.balance.work, body.balance.elastic, body.balance.dissipation],
        position: march.at.write(),
    }
}

fn end(
    prepared: &mut Prepared,
    settings: &Settings,
    march: March,
    seconds: Seconds,
    kept: &mut Kept,
    interrupted: bool,
    observer: &mut Watch<Event>,
) -> Result<Outcome, Error> {
    let March { body, last, records, laws, lost, .. } = march;
    let Some((mut outcome, reference)) = last else {
        return Err(Error::interrupted());
    };
    if interrupted && !records.is_empty() {
        // What acts in the step that was left is taken back.
        apply(prepared, &body.loads, &vec![0.0; 2 * prepared.problem.points()]);
        prepared.problem.contact.friction = laws;
        prepared.loading.lost = lost;
        prepared.problem.contact.slip_reference = reference;
    }
    if !interrupted {
        // The answer of a step stands in its files, and an unsolved one is not replaced.
        if outcome.solution.status == Status::Solved {
            other_starts(prepared, settings, kept, &mut outcome, observer);
        }
        uniqueness_facts(prepared, settings, kept, &mut outcome, observer);
    }
    let doubtful = records.iter().any(|record| record.answer.status == Status::Uncertified);
    outcome.solution.status = match outcome.solution.status {
        _ if interrupted => Status::Interrupted,
        Status::Solved if doubtful => Status::Uncertified,
        status => status,
    };
    outcome.seconds = Seconds { coulomb: outcome.seconds.coulomb, ..seconds };
    outcome.steps = records;
    Ok(outcome)
}
