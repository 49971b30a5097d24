//! Each body and each pair measured by its own forces.
//!
//! The measures of the whole are counted in the largest forces there are: beside a pair that carries kilonewtons one
//! that carries millinewtons could be wrong altogether. Equilibrium and the law leave nothing out, so that one measure
//! of each body and one of each pair suffice.

use super::point::Point;
use super::scales::{ROUNDING, measure};
use super::share::Share;
use crate::contact::{ContactProblem, Pair};

/// Forces below this part of those of the whole are none: a body that nothing loads has what iteration and rounding leave
/// (random cases by multigrid: up to 1.2e-13), and nothing of its own to count them in.
const NOTHING: f64 = 1e-12;

/// What is measured by its own forces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// A body: equilibrium at its unknowns.
    Body,
    /// A pair: the law at its points.
    Pair,
}

impl Part {
    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Part::Body => "body",
            Part::Pair => "pair",
        }
    }
}

/// A body or a pair, measured by its own forces.
#[derive(Debug, Clone, PartialEq)]
pub struct PartMeasure {
    /// Which of both.
    pub part: Part,
    /// Its name as the labels of the problem have it.
    pub name: String,
    /// Of a body `|f - K u - Bᵀ lambda|` over the larger of `|f|` and `|Bᵀ lambda|`, norms over its unknowns. Of a pair
    /// `|lambda - P(lambda - r w)|` at its points, with the unbalanced forces at the unknowns they touch, over its
    /// `|lambda|`. What rounding explains is not counted.
    pub residual: f64,
}

/// Unbalanced force, contact force and the magnitudes that `K u` adds up from, at each unknown, newton.
pub(super) struct NodalForces<'a> {
    pub imbalance: &'a [f64],
    pub contact: &'a [f64],
    pub internal: &'a [f64],
    /// The Euclidean norm of the loads or of the contact forces of the whole, newton.
    pub whole: f64,
}

impl NodalForces<'_> {
    /// `error` over `own` forces, less what rounding explains.
    fn measure(&self, error: f64, rounding: f64, own: f64) -> f64 {
        let nothing = NOTHING * self.whole;
        measure(error, if own > nothing { rounding } else { rounding + nothing }, own)
    }
}

/// Equilibrium of each body. One without any load or contact force has nothing to count it in but the forces of the whole,
/// as the measure of equilibrium does. Without a list of bodies everything counts as one.
pub(super) fn bodies(problem: &ContactProblem, share: &Share, forces: &NodalForces) -> Vec<PartMeasure> {
    let labels = problem.labels.bodies.as_ref();
    let names: Vec<String> =
        labels.map_or(vec!["body".into()], |b| b.list.iter().map(|body| body.name.clone()).collect());
    // Squares of imbalance, load, contact force and magnitude.
    let mut squares = vec![[0.0; 4]; names.len()];
    for i in (0..problem.unknowns()).filter(|&i| share.has_unknown(i)) {
        let values = [forces.imbalance[i], problem.elastic.f[i], forces.contact[i], forces.internal[i]];
        let sums = &mut squares[labels.map_or(0, |b| b.of[i] as usize)];
        sums.iter_mut().zip(values).for_each(|(sum, v)| *sum += v * v);
    }
    share.sum(squares.as_flattened_mut());
    let measured = |(name, sums): (String, [f64; 4])| {
        let [imbalance, load, contact, internal] = sums.map(f64::sqrt);
        let own = load.max(contact);
        let residual = if own > 0.0 { forces.measure(imbalance, ROUNDING * internal, own) } else { 0.0 };
        PartMeasure { part: Part::Body, name, residual }
    };
    names.into_iter().zip(squares).map(measured).collect()
}

/// The law at the points of each pair, and equilibrium where they are unless all its forces are zero. No force of a pair
/// is known better than the forces inside the bodies it touches add up; `body` has the body of each unknown.
pub(super) fn pairs(
    problem: &ContactProblem,
    share: &Share,
    body: &[u32],
    points: &[Point],
    lambda: &[f64],
    forces: &NodalForces,
) -> Vec<PartMeasure> {
    // Every rank has the list of all bodies, and unknowns of some.
    let listed = problem.labels.bodies.as_ref().map(|bodies| bodies.list.len());
    let count = listed.unwrap_or_else(|| body.iter().map(|&b| b as usize + 1).max().unwrap_or(0));
    let mut inside = vec![0.0; count];
    let of_unknowns = body.iter().zip(forces.internal).enumerate().filter(|(i, _)| share.has_unknown(*i));
    for (_, (&b, force)) in of_unknowns {
        inside[b as usize] += force * force;
    }
    share.sum(&mut inside);
    let distinct = |mut list: Vec<u32>| {
        list.sort_unstable();
        list.dedup();
        list
    };
    let measured = |pair: &Pair| {
        let own = || pair.points.clone().filter(|&j| share.has_point(j));
        let rows = |j: usize| problem.rows(j).into_iter();
        // Points of other ranks may touch unknowns of this one.
        let of_points = pair.points.clone().flat_map(rows).flat_map(|i| problem.contact.B.row(i).0.iter().copied());
        let unknowns = distinct(of_points.filter(|&i| share.has_unknown(i as usize)).collect());
        let mut touched = vec![0.0; inside.len()];
        unknowns.iter().for_each(|&i| touched[body[i as usize] as usize] = 1.0);
        share.max(&mut touched);
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
        let mut sums = [
            own().map(|j| points[j].residual_squared()).sum::<f64>(),
            square(&mut own().flat_map(rows).map(|i| lambda[i])),
            square(&mut unknowns.iter().map(|&i| forces.imbalance[i as usize])),
            square(&mut own().map(|j| points[j].rounding)),
        ];
        share.sum(&mut sums);
        let [error, own_force, imbalance, point_rounding] = sums.map(f64::sqrt);
        let inside = inside.iter().zip(&touched).filter(|(_, t)| **t > 0.0).map(|(sum, _)| sum).sum::<f64>().sqrt();
        let imbalance = if own_force > 0.0 { imbalance } else { 0.0 };
        let rounding = point_rounding + ROUNDING * inside;
        let residual = forces.measure(error.hypot(imbalance), rounding, own_force);
        PartMeasure { part: Part::Pair, name: pair.name.clone(), residual }
    };
    problem.labels.pairs.iter().map(measured).collect()
}
