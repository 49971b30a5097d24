//! Motions of bodies that nothing holds any more: contact has opened, and no load pushes along them.
//!
//! Such a motion is part of no equation, and an iteration leaves it where it ends. A body at rest stays where it is: of all answers
//! this takes the one nearest to the displacements before.

use crate::certificate::certify;
use crate::contact::ContactProblem;
use crate::contact::adrift::{Held, adrift};
use crate::contact::among::Among;
use crate::contact::rigid::RigidMotions;
use crate::friction::{PointState, Solution, Status};
use crate::linalg::{SmallCholesky, axpy, dot, max_abs};

/// Moving back by less than this part of the largest displacement changes nothing that is read.
const NOTHING: f64 = 1e-6;
/// A displacement that no rigid motion has, over the largest before, that is rounding.
const STRAIN: f64 = 1e-12;
/// Of jumps, over the largest.
const ROUNDING: f64 = 1e-10;

/// Moves bodies of an answer along the motions that nothing holds, as near to the displacements `before` (none: zero) as gaps allow.
/// Forces stay what they are. Both displacements leave out the same travel of supports.
pub(super) fn move_back(
    problem: &ContactProblem,
    motions: &RigidMotions,
    before: Option<&[f64]>,
    tolerance: f64,
    solution: &mut Solution,
) {
    if !matches!(solution.status, Status::Solved | Status::Uncertified) {
        return;
    }
    let is_closed = |j: usize| solution.states[j] != PointState::Open;
    let held = Held { lambda: &solution.lambda, is_closed: &is_closed };
    let Some(u) = moved_back((problem, motions), before, (&solution.u, held), &Among::ALONE) else { return };
    let certificate = certify(problem, &u, &solution.lambda, tolerance);
    if certificate.passed || !solution.certificate.passed {
        (solution.u, solution.certificate) = (u, certificate);
    }
}

/// Such displacements of all unknowns, where ranks share the problem of those here; `None` where they are those of the answer.
pub(crate) fn moved_back(
    (problem, motions): (&ContactProblem, &RigidMotions),
    before: Option<&[f64]>,
    (u, held): (&[f64], Held),
    among: &Among,
) -> Option<Vec<f64>> {
    let free = adrift((problem, motions), held, &|_| false, among);
    if free.is_empty() {
        return None;
    }
    let own = |values: Vec<f64>| {
        let values = values.into_iter().enumerate();
        values.map(|(i, value)| if (among.unknown)(i) { value } else { 0.0 }).collect::<Vec<f64>>()
    };
    let away: Vec<f64> = match before {
        Some(before) => before.iter().zip(u).map(|(before, u)| before - u).collect(),
        None => u.iter().map(|u| -u).collect(),
    };
    // The motions are orthonormal: lengths of their combinations are those of the displacements.
    let mut wanted = motions.work(&own(away));
    (among.sum)(&mut wanted);
    let gram = free.iter().enumerate().map(|(a, of)| free[..=a].iter().map(|other| dot(of, other)).collect());
    let gram = SmallCholesky::new(gram.collect())?;
    let weights = gram.solve(&free.iter().map(|of| dot(of, &wanted)).collect::<Vec<f64>>());
    let mut alpha = vec![0.0; wanted.len()];
    weights.iter().zip(&free).for_each(|(weight, of)| axpy(*weight, of, &mut alpha));
    let jump = motions.jumps(&problem.contact.B).times(&alpha);
    let is_open = |j: usize| (among.point)(j) && !held.holds(problem, j);
    let part = as_far_as_gaps_allow(problem, u, &jump, (&is_open, among));
    alpha.iter_mut().for_each(|a| *a *= part);
    let mut change = vec![0.0; u.len()];
    motions.add(&alpha, &mut change);
    let mut sizes = [max_abs(&change), max_abs(u)];
    (among.max)(&mut sizes);
    if sizes[0] <= NOTHING * sizes[1] {
        return None;
    }
    let mut moved = u.to_vec();
    axpy(1.0, &change, &mut moved);
    take_out_rounding(motions, (&change, u), &mut moved, among);
    Some(moved)
}

/// A body without strain that has come back from far keeps the rounding of where it was, which its certificate takes for forces: such
/// a body moves rigidly.
fn take_out_rounding(motions: &RigidMotions, (change, before): (&[f64], &[f64]), u: &mut [f64], among: &Among) {
    for body in &motions.bodies {
        let of = |values: &[f64]| body.unknowns.iter().map(|&i| values[i as usize]).collect::<Vec<f64>>();
        let mut sizes = [max_abs(&of(change)), max_abs(&of(before))];
        (among.max)(&mut sizes);
        if sizes[0] == 0.0 {
            continue;
        }
        let mut strained = of(u);
        for motion in &body.motions {
            let own =
                body.unknowns.iter().zip(motion).zip(&strained).filter(|((i, _), _)| (among.unknown)(**i as usize));
            let mut weight = [own.map(|((_, motion), strained)| motion * strained).sum::<f64>()];
            (among.sum)(&mut weight);
            axpy(-weight[0], motion, &mut strained);
        }
        if among.largest(strained.iter().map(|strained| strained.abs())) <= STRAIN * sizes[1] {
            body.unknowns.iter().zip(&strained).for_each(|(&i, strained)| u[i as usize] -= strained);
        }
    }
}

/// The part of `jump` that closes no gap of an open point by more than rounding, at most one.
fn as_far_as_gaps_allow(
    problem: &ContactProblem,
    u: &[f64],
    jump: &[f64],
    (is_open, among): (&dyn Fn(usize) -> bool, &Among),
) -> f64 {
    let now = problem.contact.B.times(u);
    let rounding = ROUNDING * among.largest([max_abs(jump)].into_iter());
    let wide = |j: usize| (problem.contact.gap[j] - now[j]).max(0.0);
    let closing = (0..problem.points()).filter(|&j| is_open(j) && jump[j] > wide(j) + rounding);
    let mut least = [-closing.map(|j| wide(j) / jump[j]).fold(1.0, f64::min)];
    (among.max)(&mut least);
    -least[0]
}
