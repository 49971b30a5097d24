//! Bodies that nothing holds.

use crate::contact::rigid::RigidMotions;
use crate::contact::{Bodies, ContactProblem, Friction};
use crate::friction::{Solution, Status};
use crate::run::pose::Prepared;

/// The bodies of an answer whose places nothing decides: contact alone could hold them, and no pressure, pull or tie leads from
/// them to a body that is held or to an obstacle; a force below the tolerance of the certificate, of the largest, is none. Empty where
/// nothing is solved, and where there is one body.
pub(crate) fn unheld(prepared: &Prepared, solution: &Solution) -> Vec<String> {
    unheld_among(&prepared.problem, &prepared.motions, (solution, &solution.lambda), &|_| {})
}

/// The same of the part of a problem that a rank has, with the contact forces `lambda` of all its points, those of other ranks
/// among them; `max` takes the maxima over all ranks.
pub(crate) fn unheld_among(
    problem: &ContactProblem,
    motions: &RigidMotions,
    (solution, lambda): (&Solution, &[f64]),
    max: &dyn Fn(&mut [f64]),
) -> Vec<String> {
    let solved = solution.status == Status::Solved;
    let Some(bodies) = problem.labels.bodies.as_ref().filter(|bodies| solved && bodies.list.len() > 1) else {
        return Vec::new();
    };
    let tolerance = solution.certificate.tolerance;
    let (count, m) = (bodies.list.len(), problem.points());
    // What each body holds on to, with the ground after the last one.
    let ground = count;
    let mut joins = vec![0.0; (count + 1) * (count + 1)];
    let mut join = |a: usize, b: usize| {
        joins[a * (count + 1) + b] = 1.0;
        joins[b * (count + 1) + a] = 1.0;
    };
    let floats = floating(bodies, motions, max);
    (0..count).filter(|&body| !floats[body]).for_each(|body| join(body, ground));
    // Couplings and equations make one body of several.
    for body in &motions.bodies {
        let body_of = |&i: &u32| bodies.of[i as usize] as usize;
        let first = body.unknowns.first().map_or(ground, body_of);
        body.unknowns.iter().map(body_of).for_each(|other| join(first, other));
    }
    let sizes = problem.elastic.f.iter().chain(lambda).map(|force| force.abs());
    let mut largest = [sizes.fold(0.0, f64::max)];
    max(&mut largest);
    // Supports and couplings of some steps are ties, and hold without a force.
    let ties = |j: usize| {
        problem.contact.friction[j] == Friction::Bonded && problem.contact.out.binary_search(&(j as u32)).is_err()
    };
    // Given friction acts on open points too, along the surface alone: a body is free to leave there.
    let rows = |j: usize| if problem.contact.friction[j].tension() == 0.0 { 0..1 } else { 0..3 };
    let acts = |&j: &usize| ties(j) || rows(j).any(|r| lambda[r * m + j].abs() > tolerance * largest[0]);
    for j in (0..m).filter(acts) {
        let row = |i: usize| problem.contact.B.row(i).0;
        let mut touched: Vec<usize> =
            problem.rows(j).into_iter().flat_map(row).map(|&i| bodies.of[i as usize] as usize).collect();
        let held = |i: usize| problem.labels.supports.as_ref().is_some_and(|held| !held.B.row(i).0.is_empty());
        touched.sort_unstable();
        touched.dedup();
        if touched.len() < 2 || problem.rows(j).into_iter().any(held) {
            touched.push(ground);
        }
        touched.windows(2).for_each(|two| join(two[0], two[1]));
    }
    max(&mut joins);
    let mut is_held = vec![false; count + 1];
    let mut reached = vec![ground];
    while let Some(body) = reached.pop() {
        if !std::mem::replace(&mut is_held[body], true) {
            reached.extend((0..=count).filter(|&other| joins[body * (count + 1) + other] > 0.0));
        }
    }
    (0..count).filter(|&body| !is_held[body]).map(|body| bodies.list[body].name.clone()).collect()
}

/// Whether contact alone could hold each body.
fn floating(bodies: &Bodies, motions: &RigidMotions, max: &dyn Fn(&mut [f64])) -> Vec<bool> {
    let mut floats = vec![0.0; bodies.list.len()];
    for &i in motions.bodies.iter().flat_map(|body| &body.unknowns) {
        floats[bodies.of[i as usize] as usize] = 1.0;
    }
    max(&mut floats);
    floats.iter().map(|&floats| floats > 0.0).collect()
}
