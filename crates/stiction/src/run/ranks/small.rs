//! What the ranks do not solve together rank 0 solves alone, as `stiction solve` does, where the whole is small enough for one of
//! them: the factor, smaller meshes to start from and further starts are there. The ranks judge its answer.

use std::ops::ControlFlow;

use super::gather::{AtPoints, WholeAnswer};
use super::local::{Local, changes};
use super::record::RankedStep;
use super::solve::Everywhere;
use super::steps::put_state;
use super::tighten::Found;
use crate::Error;
use crate::certificate::certify_divided;
use crate::friction::{Counts, Multigrid, Progress, Solution, Status};
use crate::io::case::Case;
use crate::linalg::Watch;
use crate::ranks::{broadcast, put, take};
use crate::run::pose::loads::end;
use crate::run::pose::prepare;
use crate::run::solve::{Event, Outcome, Settings, solve, solve_steps};
use crate::solve::SolveEvent;

/// Unknowns of the whole up to which one rank solves it: seconds, and some 100 MB.
pub(super) const MOST_UNKNOWNS: usize = 20_000;

/// Solves the case on rank 0. `None` if it finds nothing either, on every rank.
///
/// # Errors
/// As [`put_state`].
pub(super) fn by_first(
    case: &Case,
    local: &mut Local,
    multigrid: &mut Multigrid,
    observer: &mut Watch<Progress>,
) -> Result<Option<(Found, Vec<RankedStep>)>, Error> {
    // Its answer does not tell how far interfaces have yielded.
    if case.contacts.iter().any(|contact| contact.stiffness.is_some()) {
        return Ok(None);
    }
    let ranks = std::sync::Arc::clone(&local.division.ranks);
    let message = if ranks.rank() == 0 { answer(case, observer).unwrap_or_default() } else { Vec::new() };
    let message = broadcast(&*ranks, message);
    let mut from = &message[..];
    if from.is_empty() {
        return Ok(None);
    }
    let answer = WholeAnswer::take(&mut from);
    let iterations: Vec<u64> = take(&mut from);
    let Ok(steps) = serde_json::from_slice::<Vec<RankedStep>>(from) else { return Ok(None) };
    taken(case, (local, multigrid), &answer, steps, iterations.iter().sum::<u64>() as usize)
}

/// What a run on one machine finds, as a message: the answer, its iterations, its steps.
fn answer(case: &Case, observer: &mut Watch<Progress>) -> Option<Vec<u8>> {
    let mut prepared = prepare(case).ok()?;
    let settings = Settings::of(&case.solver);
    let mut watch = |event: &Event| match event {
        Event::Solver(SolveEvent::Iteration(progress)) => observer(progress),
        _ => ControlFlow::Continue(()),
    };
    let outcome = if case.steps.is_empty() {
        solve(&prepared, &settings, &mut watch)
    } else {
        solve_steps(&mut prepared, &settings, None, &mut |_, _| Ok(()), &mut watch)
    };
    let outcome = outcome.ok()?;
    match outcome.solution.status {
        // Displacements there leave out what supports have in common; here they do not.
        Status::Solved if prepared.loading.travel == [0.0; 3] => {}
        _ => return None,
    }
    let mut message = WholeAnswer::of_outcome(&prepared, &outcome).to_bytes();
    put(&[iterations(&outcome) as u64], &mut message);
    message.extend(serde_json::to_vec(&steps(&outcome)).ok()?);
    Some(message)
}

/// Iterations or cycles of an answer.
pub(super) fn iterations(outcome: &Outcome) -> usize {
    outcome.solution.counts.cycles.max(outcome.solution.counts.newton_steps)
}

fn steps(outcome: &Outcome) -> Vec<RankedStep> {
    let steps = outcome.steps.iter().map(|step| RankedStep {
        name: step.name.clone(),
        t: step.t,
        status: step.answer.status,
        iterations: step.answer.counts.steps(),
        certificate: step.answer.certificate.clone(),
        contact: step.answer.contact.clone(),
        pairs: step.answer.pairs.clone(),
        overlaps: step.answer.overlaps.clone(),
        smallness: step.answer.smallness.clone(),
        unheld: step.answer.unheld.clone(),
        bodies: step.answer.bodies.clone(),
        bolts: step.answer.bolts.clone(),
        couplings: step.answer.couplings.clone(),
    });
    steps.collect()
}

/// What of the answer is here, judged by all ranks.
///
/// # Errors
/// As [`put_state`].
pub(super) fn taken(
    case: &Case,
    (local, multigrid): (&mut Local, &mut Multigrid),
    answer: &WholeAnswer,
    steps: Vec<RankedStep>,
    iterations: usize,
) -> Result<Option<(Found, Vec<RankedStep>)>, Error> {
    let m = local.problem.points();
    let at_points = answer.at_points_of(local).filter(|_| answer.u.len() as u64 == local.sizes[0]);
    let mut missing = [f64::from(u8::from(at_points.is_none()))];
    crate::ranks::max(&*local.division.ranks, &mut missing);
    let Some(mut at_points) = at_points.filter(|_| missing[0] == 0.0) else { return Ok(None) };
    if changes(case) || !local.bolts.is_empty() {
        let t = steps.last().map_or(end(case), |step| step.t);
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
        counts: Counts { cycles: iterations, ..Counts::default() },
        history: Vec::new(),
    };
    Ok(Some((
        Found { solution, everywhere: Everywhere { free, u, lambda, states }, shortening: answer.shortening.clone() },
        steps,
    )))
}
