//! What the ranks do not solve together rank 0 solves alone, as `stiction solve` does, where the whole is small enough for one of
//! them: the factor, smaller meshes to start from and further starts are there. The ranks judge its answer.

use std::collections::HashMap;
use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::local::{Local, changes};
use super::record::RankedStep;
use super::solve::Everywhere;
use super::steps::put_state;
use super::tighten::Found;
use crate::Error;
use crate::certificate::certify_divided;
use crate::contact::Friction;
use crate::fem::full_displacement;
use crate::friction::{Counts, Multigrid, PointState, Progress, Solution, Status};
use crate::io::case::Case;
use crate::linalg::Watch;
use crate::ranks::broadcast;
use crate::run::pose::loads::end;
use crate::run::pose::{Prepared, prepare};
use crate::run::solve::{Event, Outcome, Settings, solve, solve_steps};
use crate::solve::SolveEvent;

/// Unknowns of the whole up to which one rank solves it: seconds, and some 100 MB.
pub(super) const MOST_UNKNOWNS: usize = 20_000;

/// The answer of rank 0, for all.
#[derive(Serialize, Deserialize)]
struct Answer {
    /// Displacements of all nodes along x, y, z, length; as bits, since they are to be the same.
    u: Vec<[u64; 3]>,
    /// For each point its surface, its node, the code of its state, and the bits of multipliers (newton), slip reference and gap
    /// (length) and law.
    points: Vec<(u32, u32, usize, [u64; 10])>,
    shortening: Vec<f64>,
    steps: Vec<RankedStep>,
    iterations: usize,
}

/// Solves the case on rank 0. `None` if it finds no answer either, on every rank.
///
/// # Errors
/// As [`put_state`].
pub(super) fn by_first(
    case: &Case,
    local: &mut Local,
    multigrid: &mut Multigrid,
    observer: &mut Watch<Progress>,
) -> Result<Option<(Found, Vec<RankedStep>)>, Error> {
    let ranks = std::sync::Arc::clone(&local.division.ranks);
    let answer = if ranks.rank() == 0 { answer(case, observer) } else { None };
    let message = answer.and_then(|answer| serde_json::to_vec(&answer).ok()).unwrap_or_default();
    let Ok(answer) = serde_json::from_slice::<Answer>(&broadcast(&*ranks, message)) else { return Ok(None) };
    taken(case, local, multigrid, answer)
}

/// The answer of a run on one machine, if it is solved.
fn answer(case: &Case, observer: &mut Watch<Progress>) -> Option<Answer> {
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
    let outcome = outcome.ok().filter(|outcome| outcome.solution.status == Status::Solved)?;
    // Displacements there leave out what supports have in common; here they do not.
    if prepared.loading.travel != [0.0; 3] {
        return None;
    }
    Some(of_outcome(&prepared, &outcome))
}

fn of_outcome(prepared: &Prepared, outcome: &Outcome) -> Answer {
    let (problem, Solution { u, lambda, states, counts, .. }) = (&prepared.problem, &outcome.solution);
    let m = problem.points();
    let nodes = prepared.facts.contacts.iter().flat_map(|contact| contact.surface.nodes.iter().copied());
    let point = |(j, node): (usize, u32)| {
        let pair = problem.labels.pairs.partition_point(|pair| pair.points.end <= j) as u32;
        let (slip, gap) = (&problem.contact.slip_reference, problem.contact.gap[j]);
        let [law, a, b, c] = problem.contact.friction[j].numbers();
        let numbers = [lambda[j], lambda[m + j], lambda[2 * m + j], slip[j], slip[m + j], gap, law, a, b, c];
        (pair, node, usize::from(states[j].code()), numbers.map(f64::to_bits))
    };
    let steps = outcome.steps.iter().map(|step| RankedStep {
        name: step.name.clone(),
        t: step.t,
        status: step.answer.status,
        iterations: step.answer.counts.steps(),
        certificate: step.answer.certificate.clone(),
        contact: step.answer.contact.clone(),
        bodies: step.answer.bodies.clone(),
        bolts: step.answer.bolts.clone(),
    });
    let all = full_displacement(&prepared.model, u);
    Answer {
        u: all.as_chunks().0[..prepared.mesh.nodes.len()].iter().map(|u: &[f64; 3]| u.map(f64::to_bits)).collect(),
        points: nodes.enumerate().map(point).collect(),
        shortening: prepared.loading.initial.shortening.clone(),
        steps: steps.collect(),
        iterations: counts.cycles.max(counts.newton_steps),
    }
}

/// What of the answer is here, judged by all ranks.
fn taken(
    case: &Case,
    local: &mut Local,
    multigrid: &mut Multigrid,
    answer: Answer,
) -> Result<Option<(Found, Vec<RankedStep>)>, Error> {
    let Answer { u, points, shortening, steps, iterations } = answer;
    let m = local.problem.points();
    let of_point: HashMap<(u32, u32), (usize, [u64; 10])> =
        points.into_iter().map(|(pair, node, code, numbers)| ((pair, node), (code, numbers))).collect();
    let here = |j: usize| {
        let node = local.piece.nodes[local.division.points[j] as usize] as u32;
        of_point.get(&(local.pair_of(j) as u32, node)).copied()
    };
    let found: Vec<(usize, [u64; 10])> = (0..m).map_while(here).collect();
    let complete = found.len() == m && u.len() as u64 == local.sizes[0];
    let mut missing = [f64::from(u8::from(!complete))];
    crate::ranks::max(&*local.division.ranks, &mut missing);
    if missing[0] > 0.0 {
        return Ok(None);
    }
    let number = |k: usize| found.iter().map(move |(_, numbers)| f64::from_bits(numbers[k]));
    let lambda: Vec<f64> = (0..3).flat_map(number).collect();
    let slip_reference: Vec<f64> = (3..5).flat_map(number).collect();
    if changes(case) || !local.bolts.is_empty() {
        let t = steps.last().map_or(end(case), |step| step.t);
        put_state(local, case, t, &vec![0.0; 2 * m], &shortening)?;
        local.problem.contact.slip_reference = slip_reference;
        // They are states of the last step where points take part in some steps only, or lose their strength.
        local.problem.contact.gap = number(5).collect();
        let law = |k: usize| Friction::of_numbers([6, 7, 8, 9].map(|n| f64::from_bits(found[k].1[n])));
        local.problem.contact.friction = (0..m).map(law).collect();
        let _ = multigrid.renewed(&local.problem);
    }
    let u: Vec<[f64; 3]> = local.piece.nodes.iter().map(|&v| u[v as usize].map(f64::from_bits)).collect();
    let dofs = &local.model.dofs;
    let mut components = u.as_flattened().to_vec();
    dofs.to_components(&mut components);
    let free: Vec<f64> = dofs.free.iter().map(|&dof| components[dof as usize]).collect();
    let certificate = certify_divided(&local.problem, &local.division, &free, &lambda, case.solver.tolerance);
    let state = |code: usize| PointState::of_code(code).unwrap_or(PointState::Open);
    let states: Vec<PointState> = found.iter().map(|(code, _)| state(*code)).collect();
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
    Ok(Some((Found { solution, everywhere: Everywhere { free, u, lambda, states }, shortening }, steps)))
}
