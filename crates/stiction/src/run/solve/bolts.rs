//! The force and the shortening of bolts in an answer, and the search for the shortening that gives a force.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::Outcome;
use super::record::or_nan;
use crate::contact::ContactProblem;
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

/// Broyden's method for the shortenings of the bolts whose force is given. Where it gains nothing, as of joints that open while one bolt
/// slackens the other, the derivatives are measured at the best shortenings, one bolt after the other.
#[derive(Debug, Clone)]
pub(crate) struct BoltSearch {
    /// Of all bolts.
    pub shortening: Vec<f64>,
    /// Those that are searched, and their forces.
    sought: Vec<(usize, f64)>,
    /// Approximate derivative of the forces by the shortenings.
    slope: Vec<Vec<f64>>,
    /// The last step, and the forces before it.
    last: Option<(Vec<f64>, Vec<f64>)>,
    /// The best answer so far: shortenings and forces of the bolts sought, and the largest force that is missing.
    best: Option<(Vec<f64>, Vec<f64>, f64)>,
    /// Answers in a row in which the largest force that is missing was not halved.
    idle: usize,
    /// Which of the sought bolts is lengthened alone to measure the derivatives by it.
    measured: Option<usize>,
    /// Force; `at_first` was missing before the first step.
    allowed: f64,
    at_first: Option<f64>,
    /// [`BESIDE_LOADS`] of the tolerance.
    beside: f64,
    /// The sum of the sizes of all loads, force; zero where it is not known.
    pub loads: f64,
    /// A shortening beyond this is none, length.
    longest: f64,
    is_slackened: bool,
    /// Whether nothing was drawn together before.
    is_from_rest: bool,
    /// See [`BoltSearch::growth`].
    growth: f64,
    left: usize,
}

/// Forces are met to this multiple of the tolerance of the solver, as a part of the largest.
const FORCE_TOLERANCE: f64 = 10.0;

/// Where all bolts are slackened to zero, their forces are met as a part of what the cuts would carry at the shortenings before, times
/// this: nothing is a part of zero.
const SLACK: f64 = 1e-3;
/// With a clearance that takes longer than the force over the stiffness of the cut by this factor nothing is in proportion.
const CLEARANCE: f64 = 100.0;
/// Forces are met to this part of those found first at least, or of the loads if these are smaller or all forces are to be zero, times the
/// same: beside loads a small force is not known better.
const BESIDE_LOADS: f64 = 0.1;
/// No bolt is shortened by more than this times the radius of the largest body.
const BEYOND: f64 = 1e3;
/// Where more is missing than at first by this factor the search has lost its way.
const LOST: f64 = 1e6;
/// Derivatives are measured after so many answers and twice the number of bolts more, which Broyden's method takes for a linear problem,
/// without half of what was missing gained.
const IDLE: usize = 3;
/// They are measured by changes of this part of the largest shortening.
const CHANGE: f64 = 1e-2;
/// A force below this is none, in any unit.
const NOTHING: f64 = 1e-100;

impl BoltSearch {
    /// From the shortenings `before` (empty: none); `stiffness` is that of each cut.
    pub(crate) fn new(stiffness: &[f64], targets: &[Target], before: &[f64], tolerance: f64) -> Self {
        let old = |number: usize| before.get(number).copied().unwrap_or(0.0);
        let start = |(number, target): (usize, &Target)| match target {
            Target::Shortening(s) => *s,
            // From rest where nothing could be learnt: the least shortening the force can take.
            Target::Force(force) if old(number) == 0.0 => force / stiffness[number],
            Target::Force(_) | Target::Locked => old(number),
        };
        let shortening = targets.iter().enumerate().map(start).collect();
        let force = |(number, target): (usize, &Target)| match target {
            Target::Force(force) => Some((number, *force)),
            _ => None,
        };
        let sought: Vec<(usize, f64)> = targets.iter().enumerate().filter_map(force).collect();
        let count = sought.len();
        let mut slope = vec![vec![0.0; count]; count];
        (0..count).for_each(|k| slope[k][k] = stiffness[sought[k].0]);
        let largest = sought.iter().fold(0.0, |a: f64, s| a.max(s.1.abs()));
        let from = sought.iter().fold(0.0, |a: f64, s| a.max(stiffness[s.0] * old(s.0).abs()));
        let is_slackened = largest == 0.0;
        let whole = if is_slackened { (SLACK * from).max(NOTHING) } else { largest };
        let allowed = FORCE_TOLERANCE * tolerance * whole;
        // A linear problem takes twice as many steps as there are bolts; contact opens and closes on top of that.
        let is_from_rest =
            targets.iter().all(|target| matches!(target, Target::Force(_))) && before.iter().all(|&s| s == 0.0);
        let (growth, left) = (1.0, 20 + 4 * count);
        let at_first = None;
        BoltSearch {
            shortening,
            sought,
            slope,
            last: None,
            best: None,
            idle: 0,
            measured: None,
            allowed,
            at_first,
            beside: FORCE_TOLERANCE * tolerance * BESIDE_LOADS,
            loads: 0.0,
            longest: f64::INFINITY,
            is_slackened,
            is_from_rest,
            growth,
            left,
        }
    }

    /// Takes the bodies of the problem: where parts that nothing holds have gone far beyond them, forces are rounding.
    pub(crate) fn among(mut self, problem: &ContactProblem) -> Self {
        let radii = problem.labels.bodies.iter().flat_map(|bodies| &bodies.list).map(|body| body.radius);
        let largest = radii.fold(0.0, f64::max);
        self.longest = if largest > 0.0 { BEYOND * largest } else { f64::INFINITY };
        self
    }

    /// The bolts whose force is sought, and how large it shall be.
    pub(crate) fn sought(&self) -> &[(usize, f64)] {
        &self.sought
    }

    /// Whether shortenings may be found beside the displacements, which are known as a part of the forces sought.
    pub(crate) fn may_be_found_together(&self) -> bool {
        !self.sought.is_empty() && !self.is_slackened
    }

    /// Goes on from shortenings that a solver has found, by what they are longer.
    pub(crate) fn lengthen(&mut self, by: &[f64]) {
        self.is_from_rest = false;
        self.sought.iter().zip(by).for_each(|(&(bolt, _), by)| self.shortening[bolt] += by);
    }

    /// By how much displacements grow from the first answer to the next one, where all bolts are drawn together from rest: contact without a
    /// gap and without other loads is scaled by the shortenings. One otherwise.
    pub(crate) fn growth(&self) -> f64 {
        self.growth
    }

    /// The mean of the forces wanted over those found at the first shortenings from rest, where hardly a clearance had to be closed.
    fn first_growth(&self, found: &[f64]) -> Option<f64> {
        let is_first = |k: usize| self.shortening[self.sought[k].0] * self.slope[k][k] <= CLEARANCE * self.sought[k].1;
        let pulls = |k: usize| self.sought[k].1 > 0.0 && found[k] > 0.0 && is_first(k);
        let all = self.is_from_rest && self.last.is_none() && (0..found.len()).all(pulls);
        let growth = self.sought.iter().map(|s| s.1).sum::<f64>() / found.iter().sum::<f64>();
        Some(growth).filter(|growth| all && growth.is_finite())
    }

    /// Takes the forces found; breaks with whether they are those wanted, or goes on with other shortenings.
    pub(crate) fn next(&mut self, forces: &[f64]) -> ControlFlow<bool> {
        let found: Vec<f64> = self.sought.iter().map(|&(bolt, _)| forces[bolt]).collect();
        let missing: Vec<f64> = self.sought.iter().zip(&found).map(|(s, f)| s.1 - f).collect();
        let largest = |forces: &[f64]| forces.iter().fold(0.0, |most: f64, force| most.max(force.abs()));
        if self.at_first.is_none() {
            // Of bolts without force what is found may be nothing but rounding of the loads.
            let level = if self.is_slackened { self.loads } else { largest(&found).min(self.loads) };
            self.allowed = self.allowed.max(self.beside * level);
        }
        let at_first = *self.at_first.get_or_insert(largest(&missing));
        if missing.iter().all(|m| m.abs() <= self.allowed) {
            return ControlFlow::Break(self.shortening.iter().all(|s| s.abs() <= self.longest));
        }
        self.left -= 1;
        self.growth = 1.0;
        if let Some(growth) = self.first_growth(&found) {
            (self.growth, self.is_from_rest) = (growth, false);
            self.sought.iter().for_each(|&(bolt, _)| self.shortening[bolt] *= growth);
            return ControlFlow::Continue(());
        }
        if self.left == 0 || missing.iter().any(|m| !m.is_finite() || m.abs() > LOST * at_first) {
            return ControlFlow::Break(false);
        }
        // A bolt without force stays where it is, however loose: its force says nothing of its stiffness.
        let is_slack: Vec<bool> = (self.sought.iter().zip(&missing))
            .map(|(sought, missing)| sought.1 == 0.0 && missing.abs() <= self.allowed)
            .collect();
        let (found, missing) = match self.measured(&found, &is_slack) {
            Measured::Nothing => (found, missing),
            Measured::Bolt => return ControlFlow::Continue(()),
            Measured::All(best) => {
                let missing = self.sought.iter().zip(&best).map(|(s, f)| s.1 - f).collect();
                (best, missing)
            }
        };
        if let Some((step, before)) = &self.last {
            let square: f64 = step.iter().map(|s| s * s).sum();
            let rows = self.slope.iter_mut().zip(found.iter().zip(before)).zip(&is_slack);
            for ((row, (f, b)), _) in rows.filter(|(_, is_slack)| !**is_slack) {
                let wrong = f - b - row.iter().zip(step).map(|(r, s)| r * s).sum::<f64>();
                row.iter_mut().zip(step).for_each(|(r, s)| *r += wrong * s / square);
            }
        }
        let (mut slope, mut change) = (self.slope.clone(), missing);
        for k in (0..is_slack.len()).filter(|&k| is_slack[k]) {
            slope[k].fill(0.0);
            (slope[k][k], change[k]) = (1.0, 0.0);
        }
        let step = SmallLu::new(slope).solve(&change);
        if step.iter().any(|s| !s.is_finite()) || step.iter().all(|s| *s == 0.0) {
            return ControlFlow::Break(false);
        }
        self.sought.iter().zip(&step).for_each(|(&(bolt, _), s)| self.shortening[bolt] += s);
        self.last = Some((step, found));
        ControlFlow::Continue(())
    }

    /// Takes forces that are measured, or begins to measure where nothing has been gained for long. Bolts that stay where they are
    /// (`is_slack`) are not moved.
    fn measured(&mut self, found: &[f64], is_slack: &[bool]) -> Measured {
        let here: Vec<f64> = self.sought.iter().map(|&(bolt, _)| self.shortening[bolt]).collect();
        if let (Some(k), Some((at, forces, _))) = (self.measured, &self.best) {
            let by = here[k] - at[k];
            for (row, (f, before)) in self.slope.iter_mut().zip(found.iter().zip(forces)) {
                row[k] = (f - before) / by;
            }
            return self.measure(k + 1, is_slack);
        }
        let most = self.sought.iter().zip(found).map(|(s, f)| (s.1 - f).abs()).fold(0.0, f64::max);
        let least = self.best.as_ref().map_or(f64::INFINITY, |best| best.2);
        self.idle = if most < 0.5 * least { 0 } else { self.idle + 1 };
        if most < least {
            self.best = Some((here, found.to_vec(), most));
        }
        if self.idle < IDLE + 2 * self.sought.len() {
            return Measured::Nothing;
        }
        self.left += self.sought.len();
        self.measure(0, is_slack)
    }

    /// Goes to the best shortenings, of which that of the first bolt from `from` on that moves is changed by a little.
    fn measure(&mut self, from: usize, is_slack: &[bool]) -> Measured {
        let Some((at, forces, _)) = &self.best else { return Measured::Nothing };
        self.sought.iter().zip(at).for_each(|(&(bolt, _), s)| self.shortening[bolt] = *s);
        let change = CHANGE * at.iter().fold(0.0, |most: f64, s| most.max(s.abs()));
        self.measured = (from..at.len()).find(|&k| !is_slack[k] && change > 0.0);
        match self.measured {
            Some(k) => {
                let (bolt, wanted) = self.sought[k];
                self.shortening[bolt] += change.copysign(wanted - forces[k]);
                Measured::Bolt
            }
            None => {
                (self.idle, self.last) = (0, None);
                Measured::All(forces.clone())
            }
        }
    }
}

/// What the derivatives of the forces are known by.
enum Measured {
    /// They are not measured.
    Nothing,
    /// By bolts up to the one that is changed now.
    Bolt,
    /// By all bolts, at shortenings with these forces.
    All(Vec<f64>),
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the forces grow in proportion from nothing the second answer has them, however soft the joint is beside the cells at the cuts.
    #[test]
    fn from_rest_all_shortenings_grow_by_what_lacks_of_the_forces() {
        let targets = [Target::Force(900.0), Target::Force(1100.0)];
        let mut search = BoltSearch::new(&[1e6, 1e6], &targets, &[0.0, 0.0], 1e-8);
        let forces = |s: &[f64]| vec![1e4 * s[0], 1e4 * s[1]];
        assert_eq!(search.next(&forces(&search.shortening)), ControlFlow::Continue(()));
        assert!((search.growth() - 100.0).abs() < 1e-9, "{}", search.growth());
        assert_eq!(search.next(&forces(&search.shortening)), ControlFlow::Break(true));
        // Later the joint has a history: the search goes on by what it has learnt.
        let mut later = BoltSearch::new(&[1e6, 1e6], &targets, &[0.01, 0.01], 1e-8);
        assert_eq!(later.next(&forces(&later.shortening)), ControlFlow::Continue(()));
        assert_eq!(later.growth(), 1.0);
    }

    /// A joint that the loads press together, in proportion, whose forces the solver knows to its tolerance: no search for forces that are
    /// smaller follows what is not known.
    #[test]
    fn small_forces_beside_loads_are_found_as_well_as_these_are_known() {
        for wanted in [0.0, 1e-9, 1e-3] {
            let mut search = BoltSearch::new(&[2e5], &[Target::Force(wanted)], &[], 1e-8);
            search.loads = 100.0;
            let (mut count, mut noise) = (0, 1e-7);
            loop {
                noise *= -0.9;
                let force = -40.0 + 3e4 * search.shortening[0] + noise;
                count += 1;
                match search.next(&[force]) {
                    ControlFlow::Continue(()) => {}
                    ControlFlow::Break(reached) => break assert!(reached && count < 8, "{wanted} {reached} {count}"),
                }
            }
            let exact = (40.0 + wanted) / 3e4;
            assert!((search.shortening[0] - exact).abs() < 1e-7 * exact, "{wanted} {}", search.shortening[0]);
        }
    }

    /// Three loose bolts around one that is tightened: each is pulled by what the others are shortened, until its head lifts off.
    #[test]
    fn bolts_without_force_stay_about_as_long_as_they_were() {
        let pulled = [[0.4, 0.0, 0.2, 0.3], [0.2, 0.5, 0.0, 0.3], [0.4, 0.3, 0.6, 0.0]];
        let stiffness = [346e3, 5e3, 4e3, 19e3];
        let forces = |s: &[f64]| {
            let loose = |k: usize| {
                let others: f64 = (1..4).map(|j| pulled[k - 1][j] * s[j]).sum();
                (stiffness[k] * (s[k] + pulled[k - 1][0] * s[0] - 0.5 * others)).max(0.0)
            };
            vec![stiffness[0] * s[0] + 2e7 * s[0].powi(2), loose(1), loose(2), loose(3)]
        };
        let targets = [Target::Force(1000.0), Target::Force(0.0), Target::Force(0.0), Target::Force(0.0)];
        let mut search = BoltSearch::new(&[1e6; 4], &targets, &[], 1e-8);
        let mut longest: f64 = 0.0;
        let reached = loop {
            let found = search.next(&forces(&search.shortening));
            longest = search.shortening.iter().fold(longest, |a, s| a.max(s.abs()));
            if let ControlFlow::Break(reached) = found {
                break reached;
            }
        };
        // The heads lift off at 0.002; a search that takes their force for their stiffness lengthens a bolt by 0.21.
        assert!(reached && longest < 0.005, "{reached} {longest}");
    }
}
