//! The force and the shortening of bolts in an answer, and the search for the shortening that gives a force.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::Outcome;
use super::record::or_nan;
use crate::fem::full_displacement;
use crate::linalg::SmallLu;
use crate::run::pose::Prepared;
use crate::run::pose::bolts::{Bolt, Target};

/// A bolt in an answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoltState {
    /// Its name.
    pub name: String,
    /// Tension through the cut, newton.
    #[serde(deserialize_with = "or_nan")]
    pub force: f64,
    /// Length.
    pub shortening: f64,
}

/// Force and shortening of each bolt: the force is what the elastic energy grows by with the shortening.
pub fn bolt_states(prepared: &Prepared, outcome: &Outcome) -> Vec<BoltState> {
    if prepared.loading.bolts.is_empty() {
        return Vec::new();
    }
    let u = full_displacement(&prepared.model, &outcome.solution.u);
    let initial = &prepared.loading.initial;
    let state = |(number, bolt): (usize, &Bolt)| {
        let shortening = initial.shortening.get(number).copied().unwrap_or(0.0);
        let thermal = initial.thermal_force.get(number).copied().unwrap_or(0.0);
        let from_body: f64 = bolt.cut.force.iter().map(|&(dof, unit)| unit * u[dof as usize]).sum();
        let force = bolt.cut.stiffness * shortening - from_body + thermal;
        BoltState { name: bolt.name.clone(), force, shortening }
    };
    prepared.loading.bolts.iter().enumerate().map(state).collect()
}

/// Broyden's method for the shortenings of the bolts whose force is given.
#[derive(Debug)]
pub(crate) struct BoltSearch {
    /// Of all bolts.
    pub shortening: Vec<f64>,
    /// Of the next solve.
    pub tolerance: f64,
    /// Those that are searched, and their forces.
    sought: Vec<Sought>,
    /// Approximate derivative of the forces by the shortenings.
    slope: Vec<Vec<f64>>,
    last: Option<Last>,
    /// The tolerance that the last solve must have.
    wanted: f64,
    left: usize,
}

/// The last step of the search.
#[derive(Debug)]
struct Last {
    /// Lengths.
    step: Vec<f64>,
    /// The forces before it, what was missing of them, and how uncertain they were.
    found: Vec<f64>,
    missing: Vec<f64>,
    noise: f64,
}

/// A bolt whose force is given.
#[derive(Debug, Clone, Copy)]
struct Sought {
    bolt: usize,
    force: f64,
    /// The shortening up to which it is taken to bear nothing, where it begins from rest.
    clearance: Option<f64>,
}

struct Threshold;

impl Threshold {
    /// The tolerance of the first solve, which only shows how stiff the bolts are in their places.
    const FIRST_TOLERANCE: f64 = 1e-2;
    /// The tolerance of a solve over what is missing of the forces, as a part of the largest: a tenth of that is left.
    const OF_MISSING: f64 = 1e-3;
    /// Errors of the forces over the tolerance. Smaller changes say nothing of the slope.
    const NOISE: f64 = 10.0;
    /// Forces are met to this multiple of the tolerance of the solver, as a part of the largest ...
    const FORCE: f64 = 10.0;
    /// ... or to this one, once they come no nearer.
    const AT_LAST: f64 = 100.0;
}

impl BoltSearch {
    /// From the shortenings `before`.
    pub(super) fn new(bolts: &[Bolt], targets: &[Target], before: &[f64], tolerance: f64) -> Self {
        let start = |(number, target): (usize, &Target)| match target {
            Target::Shortening(s) => *s,
            // From rest where nothing could be learnt: the least shortening the force can take.
            Target::Force(force) if before[number] == 0.0 => force / bolts[number].cut.stiffness,
            Target::Force(_) | Target::Locked => before[number],
        };
        let shortening = targets.iter().enumerate().map(start).collect();
        let by_force = |(bolt, target): (usize, &Target)| match target {
            Target::Force(force) => {
                Some(Sought { bolt, force: *force, clearance: (before[bolt] == 0.0).then_some(0.0) })
            }
            _ => None,
        };
        let sought: Vec<Sought> = targets.iter().enumerate().filter_map(by_force).collect();
        let count = sought.len();
        let mut slope = vec![vec![0.0; count]; count];
        (0..count).for_each(|k| slope[k][k] = bolts[sought[k].bolt].cut.stiffness);
        let first = if count == 0 { tolerance } else { tolerance.max(Threshold::FIRST_TOLERANCE) };
        // A linear problem takes twice as many steps as there are bolts; contact opens and closes on top of that.
        let left = 20 + 4 * count;
        BoltSearch { shortening, tolerance: first, wanted: tolerance, sought, slope, last: None, left }
    }

    /// Adds to the shortening of a bolt that begins from rest the `way` after which its parts bear its force; up to
    /// `clearance` they bear nothing.
    pub(super) fn close(&mut self, bolt: usize, clearance: f64, way: f64) {
        self.shortening[bolt] += way.max(0.0);
        self.sought.iter_mut().filter(|s| s.bolt == bolt).for_each(|s| s.clearance = Some(clearance));
    }

    /// Takes the forces found; breaks with whether they are those wanted, or goes on with other shortenings or a tighter
    /// tolerance.
    pub(super) fn next(&mut self, forces: &[f64]) -> ControlFlow<bool> {
        let found: Vec<f64> = self.sought.iter().map(|s| forces[s.bolt]).collect();
        let missing: Vec<f64> = self.sought.iter().zip(&found).map(|(s, f)| s.force - f).collect();
        let most = |values: &[f64]| values.iter().fold(0.0, |a: f64, m| a.max(m.abs()));
        let largest = self.sought.iter().fold(0.0, |a: f64, s| a.max(s.force.abs()));
        let (most_missing, noise) = (most(&missing), Threshold::NOISE * self.tolerance * largest);
        let nearer = self.last.as_ref().is_none_or(|last| most_missing < 0.5 * most(&last.missing));
        let met = most_missing <= Threshold::FORCE * self.wanted * largest;
        if self.tolerance == self.wanted
            && (met || !nearer && most_missing <= Threshold::AT_LAST * self.wanted * largest)
        {
            return ControlFlow::Break(true);
        }
        self.left -= 1;
        if self.left == 0 || !most_missing.is_finite() {
            return ControlFlow::Break(false);
        }
        self.tolerance = (Threshold::OF_MISSING * most_missing / largest).clamp(self.wanted, self.tolerance);
        if met {
            return ControlFlow::Continue(());
        }
        match &self.last {
            Some(Last { step, found: before, noise: other, .. }) => {
                let change: Vec<f64> = found.iter().zip(before).map(|(f, b)| f - b).collect();
                let square: f64 = step.iter().map(|s| s * s).sum();
                if most(&change) > noise.max(*other) {
                    for (row, change) in self.slope.iter_mut().zip(change) {
                        let wrong = change - row.iter().zip(step).map(|(r, s)| r * s).sum::<f64>();
                        row.iter_mut().zip(step).for_each(|(r, s)| *r += wrong * s / square);
                    }
                }
            }
            None => {
                for (k, (s, force)) in self.sought.iter().zip(&found).enumerate() {
                    let slope = s.clearance.map(|clearance| force / (self.shortening[s.bolt] - clearance));
                    if let Some(slope) = slope.filter(|&slope| force.abs() > noise && slope > 0.0) {
                        self.slope[k][k] = slope.min(self.slope[k][k]);
                    }
                }
            }
        }
        let step = SmallLu::new(self.slope.clone()).solve(&missing);
        if step.iter().any(|s| !s.is_finite()) || step.iter().all(|s| *s == 0.0) {
            return ControlFlow::Break(false);
        }
        self.sought.iter().zip(&step).for_each(|(sought, s)| self.shortening[sought.bolt] += s);
        self.last = Some(Last { step, found, missing, noise });
        ControlFlow::Continue(())
    }
}

/// How far `now` lies beyond `last` on the line from `before`, over the distance of these two.
pub(super) fn beyond(before: &[f64], last: &[f64], now: &[f64]) -> f64 {
    let way = |(before, last): (&f64, &f64)| last - before;
    let square: f64 = before.iter().zip(last).map(way).map(|d| d * d).sum();
    let ways = before.iter().zip(last).map(way).zip(last.iter().zip(now).map(way));
    let along: f64 = ways.map(|(a, b)| a * b).sum();
    if square > 0.0 { along / square } else { 0.0 }
}
