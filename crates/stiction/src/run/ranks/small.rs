//! What the ranks do not solve together rank 0 solves alone, as `stiction solve` does, where the whole is small enough for one of
//! them: the factor, smaller meshes to start from and further starts are there. The ranks judge its answers, of all load steps, and
//! keep them. What a case asks for that rank 0 alone can do, such as a search for further solutions, it does from the beginning.

use std::ops::ControlFlow;

use super::fretting::add_step;
use super::gather::{AtPoints, WholeAnswer};
use super::keep::Kept;
use super::local::{Local, changes};
use super::scope::is_left_to_all;
use super::solve::Everywhere;
use super::steps::put_state;
use super::tighten::Found;
use super::timed::note_where_it_stands;
use super::tractions::tractions;
use crate::Error;
use crate::certificate::certify_divided;
use crate::friction::{Counts, Multigrid, Progress, Solution, Status};
use crate::io::case::Case;
use crate::linalg::Watch;
use crate::ranks::{broadcast, put, take};
use crate::run::pose::axis::Position;
use crate::run::pose::loads::end;
use crate::run::pose::{Prepared, prepare};
use crate::run::results::Fretting;
use crate::run::solve::{AnswerRecord, Event, Settings, Step, StepRecord, solve, solve_steps};
use crate::solve::SolveEvent;

/// Unknowns of the whole up to which one rank solves it: seconds, and some 100 MB.
pub(super) const MOST_UNKNOWNS: usize = 20_000;

/// What rank 0 has found, as every rank has judged it.
pub(super) struct ByFirst {
    pub last: Found,
    pub steps: Vec<StepRecord>,
    /// What the points here have been through.
    pub fretting: Fretting,
    /// What rank 0 knows of the last answer.
    pub answer: AnswerRecord,
    /// Of the solutions beside it displacements and multipliers here.
    pub others: Vec<[Vec<f64>; 2]>,
}

/// What rank 0 has found: the answer of each increment, or the only one, and what is known of them.
struct FoundAlone {
    answers: Vec<WholeAnswer>,
    /// Solutions beside the last answer.
    others: Vec<WholeAnswer>,
    /// Where the increment after each begins, as [`Position::write`] says it.
    at: Vec<u64>,
    steps: Vec<StepRecord>,
    answer: AnswerRecord,
}

/// Solves the case on rank 0, from its beginning. `None` on every rank if it finds nothing either, or the ranks find that it does not pass.
/// Increments that were kept make way for those that it finds.
///
/// # Errors
/// As [`put_state`] and [`Kept::add`].
pub(super) fn by_first(
    case: &Case,
    local: &mut Local,
    multigrid: &mut Multigrid,
    kept: Option<&mut Kept>,
    observer: &mut Watch<Progress>,
) -> Result<Option<ByFirst>, Error> {
    if is_left_to_all(case) {
        return Ok(None);
    }
    let ranks = std::sync::Arc::clone(&local.division.ranks);
    let message = if ranks.rank() == 0 { answer(case, observer).unwrap_or_default() } else { Vec::new() };
    let Some(mut found) = FoundAlone::take(&broadcast(&*ranks, message)) else { return Ok(None) };
    // All are judged before the first one is kept.
    let mut fretting = Fretting::default();
    let mut rub = |local: &Local, at: &Found, _: usize| {
        rubbed(&mut fretting, local, at);
        Ok(())
    };
    let Some(mut last) = found.each(case, (local, multigrid), &mut rub)? else { return Ok(None) };
    let Some(others) = found.others(case, (local, multigrid))? else { return Ok(None) };
    if let Some(kept) = kept {
        kept.begin_again(&*ranks)?;
        fretting = Fretting::default();
        let mut keep = |local: &Local, at: &Found, k: usize| {
            rubbed(&mut fretting, local, at);
            let Everywhere { free, lambda, states, .. } = &at.everywhere;
            let next = std::array::from_fn(|c| found.at[4 * k + c] as usize);
            let Some(next) = Position::read(next, &case.steps) else { return Ok(()) };
            kept.add((local, case), (free, lambda, states), (&found.steps[..=k], &fretting), next)
        };
        let Some(again) = found.each(case, (local, multigrid), &mut keep)? else { return Ok(None) };
        last = again;
    }
    let FoundAlone { steps, answer, .. } = found;
    Ok(Some(ByFirst { last, steps, fretting, answer, others }))
}

/// Goes on by the increment that ends with this answer.
fn rubbed(fretting: &mut Fretting, local: &Local, at: &Found) {
    let tractions = tractions(local, &at.everywhere.free, &at.everywhere.lambda);
    add_step(fretting, local, &at.everywhere, &at.shortening, &tractions);
}

/// What a run on one machine finds, as a message.
fn answer(case: &Case, observer: &mut Watch<Progress>) -> Option<Vec<u8>> {
    let mut prepared = prepare(case).ok()?;
    let settings = Settings::of(&case.solver);
    let mut watch = |event: &Event| match event {
        Event::Solver(SolveEvent::Iteration(progress)) => observer(progress),
        _ => ControlFlow::Continue(()),
    };
    let (mut answers, mut at, mut travels) = (Vec::new(), Vec::new(), false);
    let outcome = if case.steps.is_empty() {
        solve(&prepared, &settings, &mut watch).inspect(|outcome| {
            answers.push(WholeAnswer::of_outcome(&prepared, outcome));
        })
    } else {
        let mut each = |prepared: &Prepared, step: &Step| {
            answers.push(WholeAnswer::of_outcome(prepared, step.outcome));
            at.extend(step.file.position.map(|k| k as u64));
            travels |= prepared.loading.travel != [0.0; 3];
            Ok(())
        };
        solve_steps(&mut prepared, &settings, None, &mut each, &mut watch)
    };
    let outcome = outcome.ok()?;
    // Displacements there leave out what supports have in common; here they do not.
    if outcome.solution.status != Status::Solved || travels || prepared.loading.travel != [0.0; 3] {
        return None;
    }
    let others = outcome.solutions.iter().flat_map(|found| found.distinct.iter().skip(1));
    let others: Vec<WholeAnswer> = others.map(|other| WholeAnswer::of_solution(&prepared, other)).collect();
    let mut message = Vec::new();
    put(&at, &mut message);
    put(&[answers.len(), others.len()].map(|count| count as u64), &mut message);
    answers.iter().chain(&others).for_each(|answer| message.extend(answer.to_bytes()));
    message.extend(serde_json::to_vec(&(&outcome.steps, AnswerRecord::of(&prepared, &outcome))).ok()?);
    Some(message)
}

impl FoundAlone {
    /// From a message; an empty one is none.
    fn take(mut from: &[u8]) -> Option<Self> {
        if from.is_empty() {
            return None;
        }
        let at = take(&mut from);
        let counts: Vec<u64> = take(&mut from);
        let [count, others] = counts[..] else { return None };
        let mut all = |count: u64| (0..count).map(|_| WholeAnswer::take(&mut from)).collect::<Vec<_>>();
        let (answers, others) = (all(count), all(others));
        let (steps, answer) = serde_json::from_slice(from).ok()?;
        Some(FoundAlone { answers, others, at, steps, answer })
    }

    /// Displacements and multipliers here of the solutions beside the last answer, judged by all ranks, whose measure of each
    /// becomes what is known of it. `None` where one does not pass.
    ///
    /// # Errors
    /// As [`put_state`].
    fn others(
        &mut self,
        case: &Case,
        (local, multigrid): (&mut Local, &mut Multigrid),
    ) -> Result<Option<Vec<[Vec<f64>; 2]>>, Error> {
        let t = self.steps.last().map_or(end(case), |step| step.t);
        let mut others = Vec::new();
        for (k, answer) in (1..).zip(&self.others) {
            let taken = taken(case, (local, multigrid), answer, t, &self.answer)?;
            let Some(found) = taken.filter(|found| found.solution.status == Status::Solved) else { return Ok(None) };
            if let Some(record) = self.answer.solutions.as_mut().and_then(|found| found.distinct.get_mut(k)) {
                record.worst = found.solution.certificate.worst;
            }
            others.push([found.everywhere.free, found.everywhere.lambda]);
        }
        Ok(Some(others))
    }

    /// Each answer in its turn, judged by all ranks and given to `each` with its number; the last one. `None` where one does not pass.
    ///
    /// # Errors
    /// As [`put_state`]; those of `each`.
    fn each(
        &self,
        case: &Case,
        (local, multigrid): (&mut Local, &mut Multigrid),
        each: &mut dyn FnMut(&Local, &Found, usize) -> Result<(), Error>,
    ) -> Result<Option<Found>, Error> {
        let mut last = None;
        for (k, answer) in self.answers.iter().enumerate() {
            let t = self.steps.get(k).map_or(end(case), |step| step.t);
            let taken = taken(case, (local, multigrid), answer, t, &self.answer)?;
            let Some(found) = taken.filter(|found| found.solution.status == Status::Solved) else { return Ok(None) };
            note_where_it_stands(local, &found.everywhere.free, t);
            each(local, &found, k)?;
            last = Some(found);
        }
        Ok(last)
    }
}

/// What of an answer at time `t` is here, judged by all ranks; `of_first` is what rank 0 knows of it. `None` if points here are not known to it.
///
/// # Errors
/// As [`put_state`].
pub(super) fn taken(
    case: &Case,
    (local, multigrid): (&mut Local, &mut Multigrid),
    answer: &WholeAnswer,
    t: f64,
    of_first: &AnswerRecord,
) -> Result<Option<Found>, Error> {
    let m = local.problem.points();
    let at_points = answer.at_points_of(local).filter(|_| answer.u.len() as u64 == local.sizes[0]);
    let mut missing = [f64::from(u8::from(at_points.is_none()))];
    crate::ranks::max(&*local.division.ranks, &mut missing);
    let Some(mut at_points) = at_points.filter(|_| missing[0] == 0.0) else { return Ok(None) };
    if changes(case) || !local.bolts.is_empty() {
        put_state(local, case, t, &vec![0.0; 2 * m], &answer.shortening)?;
        at_points.put_into(&mut local.problem.contact);
        let _ = multigrid.renewed(&local.problem);
    }
    let AtPoints { lambda, states, .. } = at_points;
    let u: Vec<[f64; 3]> = local.piece.nodes.iter().map(|&v| answer.u[v as usize]).collect();
    let dofs = &local.model.dofs;
    let mut components = u.as_flattened().to_vec();
    dofs.to_components(&mut components);
    let free: Vec<f64> = dofs.free.iter().map(|&dof| components[dofs.mesh_dof(dof) as usize]).collect();
    let certificate = certify_divided(&local.problem, &local.division, &free, &lambda, case.solver.tolerance);
    let own = multigrid.own_points();
    let solution = Solution {
        status: if certificate.passed { Status::Solved } else { Status::Stalled },
        path: crate::friction::SolverPath::Multigrid,
        u: free.clone(),
        lambda: (0..3).flat_map(|r| own.iter().map(move |&j| r * m + j as usize)).map(|i| lambda[i]).collect(),
        states: own.iter().map(|&j| states[j as usize]).collect(),
        certificate,
        counts: Counts { cycles: of_first.counts.steps(), ..Counts::default() },
        history: Vec::new(),
    };
    let everywhere = Everywhere { free, u, lambda, states };
    Ok(Some(Found { solution, everywhere, shortening: answer.shortening.clone() }))
}
