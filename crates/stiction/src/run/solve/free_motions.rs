//! Motions of bodies that nothing holds any more: contact has opened, and no load pushes along them.
//!
//! Such a motion is part of no equation, and an iteration leaves it where it ends. A body at rest stays where it is: of all answers
//! this takes the one nearest to the displacements before.

use crate::certificate::certify;
use crate::contact::rigid::RigidMotions;
use crate::contact::{ContactProblem, Friction};
use crate::friction::{PointState, Solution, Status};
use crate::linalg::{SmallCholesky, axpy, dot, max_abs};

/// A motion that moves no point that holds by more than this part of its largest displacement is free.
const UNSEEN: f64 = 1e-6;
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
    if motions.is_empty() || !matches!(solution.status, Status::Solved | Status::Uncertified) {
        return;
    }
    let (m, B) = (problem.points(), &problem.contact.B);
    let jumps = motions.jumps(B);
    let holds = |i: usize| {
        let (law, closed) = (&problem.contact.friction[i % m], solution.states[i % m] != PointState::Open);
        match law {
            Friction::Bonded => true,
            _ if i < m => closed || solution.lambda[i] != 0.0,
            // Given friction holds points that are open as well.
            _ => solution.lambda[i] != 0.0 || law.bound(if closed { f64::MAX } else { 0.0 }) > 0.0,
        }
    };
    let held: Vec<usize> = (0..3 * m).filter(|&i| holds(i)).collect();
    let free = motions.without_jump(&jumps, &held, B.max_abs(), UNSEEN);
    if free.is_empty() {
        return;
    }
    let away: Vec<f64> = match before {
        Some(before) => before.iter().zip(&solution.u).map(|(before, u)| before - u).collect(),
        None => solution.u.iter().map(|u| -u).collect(),
    };
    // The motions are orthonormal: lengths of their combinations are those of the displacements.
    let wanted = motions.work(&away);
    let gram = free.iter().enumerate().map(|(a, of)| free[..=a].iter().map(|other| dot(of, other)).collect());
    let Some(gram) = SmallCholesky::new(gram.collect()) else { return };
    let weights = gram.solve(&free.iter().map(|of| dot(of, &wanted)).collect::<Vec<f64>>());
    let mut alpha = vec![0.0; wanted.len()];
    weights.iter().zip(&free).for_each(|(weight, of)| axpy(*weight, of, &mut alpha));
    let part = as_far_as_gaps_allow(problem, &solution.u, &jumps.times(&alpha), &|j| !holds(j));
    alpha.iter_mut().for_each(|a| *a *= part);
    let mut change = vec![0.0; solution.u.len()];
    motions.add(&alpha, &mut change);
    if max_abs(&change) <= NOTHING * max_abs(&solution.u) {
        return;
    }
    let mut u = solution.u.clone();
    axpy(1.0, &change, &mut u);
    take_out_rounding(motions, &change, &solution.u, &mut u);
    let certificate = certify(problem, &u, &solution.lambda, tolerance);
    if certificate.passed || !solution.certificate.passed {
        (solution.u, solution.certificate) = (u, certificate);
    }
}

/// A body without strain that has come back from far keeps the rounding of where it was, which its certificate takes for forces: such
/// a body moves rigidly.
fn take_out_rounding(motions: &RigidMotions, change: &[f64], before: &[f64], u: &mut [f64]) {
    for body in &motions.bodies {
        let of = |values: &[f64]| body.unknowns.iter().map(|&i| values[i as usize]).collect::<Vec<f64>>();
        if max_abs(&of(change)) == 0.0 {
            continue;
        }
        let mut strained = of(u);
        for motion in &body.motions {
            let weight = dot(motion, &strained);
            axpy(-weight, motion, &mut strained);
        }
        if max_abs(&strained) <= STRAIN * max_abs(&of(before)) {
            body.unknowns.iter().zip(&strained).for_each(|(&i, strained)| u[i as usize] -= strained);
        }
    }
}

/// The part of `jump` that closes no gap of an open point by more than rounding, at most one.
fn as_far_as_gaps_allow(problem: &ContactProblem, u: &[f64], jump: &[f64], is_open: &dyn Fn(usize) -> bool) -> f64 {
    let now = problem.contact.B.times(u);
    let rounding = ROUNDING * max_abs(jump);
    let wide = |j: usize| (problem.contact.gap[j] - now[j]).max(0.0);
    let closing = (0..problem.points()).filter(|&j| is_open(j) && jump[j] > wide(j) + rounding);
    closing.map(|j| wide(j) / jump[j]).fold(1.0, f64::min)
}
