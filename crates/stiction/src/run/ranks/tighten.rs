//! The march along the load steps on several ranks, and the search for the shortenings of bolts whose force is given: the steps of
//! `run/solve/steps.rs` with what each rank has.

use std::ops::ControlFlow;
use std::sync::Arc;

use super::keep::Finished;
use super::local::{Local, changes};
use super::outside::moved;
use super::solve::{Everywhere, everywhere};
use super::steps::{put_state, slid};
use super::timed::{changes_laws, lose_strength, note_where_it_stands};
use super::{bolts, energy, scope, statics};
use crate::Error;
use crate::certificate::{certify_divided, ghost_values};
use crate::contact::escape::Escape;
use crate::contact::{ContactProblem, Moved};
use crate::fem::full_displacement;
use crate::friction::{self, Counts, Multigrid, Progress, Solution, SolverPath, Status};
use crate::io::case::Case;
use crate::linalg::Watch;
use crate::ranks::{agree, max, sum};
use crate::run::pose::axis::Position;
use crate::run::pose::bolts::Target;
use crate::run::results::Fretting;
use crate::run::solve::balance::BodyState;
use crate::run::solve::bolts::BoltSearch;
use crate::run::solve::extrapolation::{KEPT, extrapolated, weights};
use crate::run::solve::{SlidingRecord, StepRecord};

/// Where the march stands.
pub(super) struct March {
    pub at: Position,
    /// How far each point here has slid since the start, length, `2m`.
    pub slid: Vec<f64>,
    /// Of each bolt, length.
    pub shortening: Vec<f64>,
    /// The points whose strength is lost by then.
    pub lost: Vec<bool>,
    /// The last answers, the latest one last.
    pub answers: Vec<Answer>,
    /// Displacements of all unknowns here to begin with, where some are known.
    pub start: Option<Vec<f64>>,
    /// Where the outside has moved to by the end of the last step, at rank 0; none before the first.
    pub moved: Option<Moved>,
    /// The body at the end of the last step, for the balance of energy.
    pub body: BodyState,
    /// What the points here have been through until then.
    pub fretting: Fretting,
}

/// What acts at a time, and the answer, of all unknowns and points here.
pub(super) struct Answer {
    pub t: f64,
    pub f: Vec<f64>,
    pub gap: Vec<f64>,
    pub u: Vec<f64>,
}

impl March {
    /// Goes on after increments that were finished before, whose records it returns.
    ///
    /// # Errors
    /// Expressions that are not finite at their times, at every rank.
    pub(super) fn go_on(&mut self, before: Finished, local: &mut Local, case: &Case) -> Result<Vec<StepRecord>, Error> {
        let Finished { records, u, lambda, fretting, lost, at } = before;
        let ranks = Arc::clone(&local.division.ranks);
        local.timed.lost.clone_from(&lost);
        self.lost = lost;
        for (number, u) in u {
            let record = &records[number];
            self.shortening = record.answer.bolts.iter().map(|bolt| bolt.shortening).collect();
            // Slip is counted from the start, and what acts does not depend on it.
            agree(&*ranks, put_state(local, case, record.t, &self.slid, &self.shortening))?;
            self.slid = slid(local, &u);
            note_where_it_stands(local, &u, record.t);
            if number + KEPT < records.len() {
                continue;
            }
            let (f, gap) = (local.problem.elastic.f.clone(), local.problem.contact.gap.clone());
            self.answers.push(Answer { t: record.t, f, gap, u });
        }
        if let (Some(record), Some(last)) = (records.last(), self.answers.last()) {
            let u = full_displacement(&local.model, &last.u);
            self.moved = agree(&*ranks, moved(local, u.as_chunks().0, record.t))?;
            let (loads, balance) = (energy::state(local, record.t), record.balance.balance());
            self.body = BodyState { loads, u: last.u.clone(), lambda, balance };
        }
        (self.at, self.fretting) = (at, fretting);
        Ok(records)
    }

    /// Displacements at `t` to start from, with what acts then in `local`: those to begin with, or extrapolated from the last steps.
    fn predicted(&self, local: &Local, t: f64) -> Option<Vec<f64>> {
        if self.answers.is_empty() {
            return self.start.clone();
        }
        let of = |values: fn(&Answer) -> &Vec<f64>, weights: &[f64]| {
            extrapolated(&self.answers.iter().map(|answer| &values(answer)[..]).collect::<Vec<_>>(), weights)
        };
        let problem = &local.problem;
        let labels = problem.elastic.node_of.as_deref().unwrap_or_default();
        let own_unknown = |i: usize| local.division.is_own(labels[i]);
        let own_point = |j: usize| local.division.is_own(local.division.points[j]);
        let squares = |a: &[f64], b: &[f64], own: &dyn Fn(usize) -> bool| -> f64 {
            a.iter().zip(b).enumerate().filter(|(i, _)| own(*i)).map(|(_, (a, b))| (a - b) * (a - b)).sum()
        };
        let (f, gap) = (&problem.elastic.f, &problem.contact.gap);
        let (no_load, no_gap) = (vec![0.0; f.len()], vec![0.0; gap.len()]);
        let mut away = |weights: &[f64]| {
            let mut sums = [
                squares(&of(|answer| &answer.f, weights), f, &own_unknown),
                squares(&of(|answer| &answer.gap, weights), gap, &own_point),
                squares(&no_load, f, &own_unknown),
                squares(&no_gap, gap, &own_point),
            ];
            sum(&*local.division.ranks, &mut sums);
            [[sums[0], sums[1]], [sums[2], sums[3]]]
        };
        let times: Vec<f64> = self.answers.iter().map(|answer| answer.t).collect();
        let weights = weights(&times, t, &mut away);
        Some(of(|answer| &answer.u, &weights))
    }
}

/// What is solved, and by what.
pub(super) struct Solver<'a, 'b> {
    pub local: &'a mut Local,
    pub multigrid: &'a mut Multigrid,
    /// The problem of the points of this rank.
    pub own: ContactProblem,
    pub case: &'a Case,
    pub settings: friction::Settings,
    pub observer: &'a mut Watch<'b, Progress>,
    /// Solves of the present step, those of longer increments that failed included.
    pub attempts: usize,
}

/// An answer, what of it is known here, and the shortenings of the bolts.
pub(super) struct Found {
    pub solution: Solution,
    pub everywhere: Everywhere,
    pub shortening: Vec<f64>,
}

impl Solver<'_, '_> {
    /// The answer at time `t`, where `targets` are prescribed of the bolts.
    ///
    /// # Errors
    /// Expressions that are not finite at that time, at every rank.
    pub(super) fn step(&mut self, march: &March, targets: &[Target], t: f64) -> Result<Found, Error> {
        let stiffness: Vec<f64> = self.local.bolts.iter().map(|b| b.bolt.cut.stiffness).collect();
        let tolerance = self.settings.tolerance;
        // An attempt that has failed leaves no trace.
        self.local.timed.lost.clone_from(&march.lost);
        let mut search = BoltSearch::new(&stiffness, targets, &march.shortening, tolerance).among(&self.local.problem);
        let from_rest: Vec<bool> = march.shortening.iter().map(|&s| s == 0.0).collect();
        if !search.sought().is_empty() {
            self.put(t, &march.slid, &[])?;
            search.loads = self.sum_of_loads();
            let with = (&*self.multigrid, &self.own);
            bolts::close_clearance(self.local, with, targets, &from_rest, &mut search.shortening);
        }
        self.attempts += 1;
        let (mut from, mut counts) = (None, Counts::default());
        let mut tries_together = if search.may_be_found_together() { 2 } else { 0 };
        loop {
            self.put(t, &march.slid, &search.shortening)?;
            from = from.or_else(|| march.predicted(self.local, t));
            if tries_together > 0 {
                tries_together -= 1;
                let sought = bolts::sought(self.local, search.sought(), &search.shortening);
                let settings = self.starting(from.as_deref(), &search.shortening);
                let set_up = self.multigrid.set_up(&self.own);
                let found = set_up.tighten(&self.own, &sought, &settings, self.observer);
                let found = found.map_err(|_| dependent(self.case))?;
                counts.add(&found.counts);
                if found.solved {
                    tries_together = 0;
                    search.lengthen(&found.shortening);
                    self.put(t, &march.slid, &search.shortening)?;
                    let zeros = vec![0.0; 3 * self.local.problem.points()];
                    from = Some(ghost_values(&self.local.problem, &self.local.division, &found.u, &zeros).0);
                }
            }
            let mut solution = self.attempt(from.as_deref(), &search.shortening)?;
            counts.add(&solution.counts);
            let found = everywhere(self.local, self.multigrid, &solution);
            if solution.status == Status::Solved && self.is_held_by_what_is_out(&found.lambda) {
                solution.status = Status::NoEquilibrium;
            }
            let states = bolts::states(self.local, &found.u, &search.shortening);
            let next = search.next(&states.iter().map(|bolt| bolt.force).collect::<Vec<f64>>());
            let solved = solution.status == Status::Solved;
            // Each solve takes the strength of some points, so that this ends.
            if solved && lose_strength(self.local, self.case, &found.states) {
                from = Some(found.free);
                continue;
            }
            if !solved || next.is_break() {
                if solved && next == ControlFlow::Break(false) {
                    solution.status = Status::Stalled;
                }
                solution.counts = counts;
                return Ok(Found { solution, everywhere: found, shortening: search.shortening });
            }
            let growth = search.growth();
            from = Some(found.free.iter().map(|u| growth * u).collect());
        }
    }

    /// How the loads at time `t` carry away a body or what bolts hold, see [`statics::escape`].
    ///
    /// # Errors
    /// As [`Self::step`].
    pub(super) fn escape(&mut self, march: &March, targets: &[Target], t: f64) -> Result<Option<Escape>, Error> {
        let by_force = self.local.bolts.iter().any(|bolt| bolt.bolt.is_by_force());
        if self.multigrid.motions().is_empty() && !by_force {
            return Ok(None);
        }
        self.local.timed.lost.clone_from(&march.lost);
        self.put(t, &march.slid, &vec![0.0; self.local.bolts.len()])?;
        Ok(statics::escape(self.local, (self.multigrid, &self.own), targets))
    }

    /// What friction resists at the normal forces of the last step that was solved, or without one at those found, where nothing is solved.
    pub(super) fn limit_load(&self, march: &March, found: &Found) -> Option<SlidingRecord> {
        if !matches!(found.solution.status, Status::Stalled | Status::MaxIterations) {
            return None;
        }
        let (before, m) = (&march.body.lambda, self.local.problem.points());
        let own = self.multigrid.own_points();
        let of_own = |all: &[f64]| (0..3).flat_map(|r| own.iter().map(move |&j| all[r * m + j as usize])).collect();
        let mut solved = [before.iter().fold(0.0, |most: f64, force| most.max(force.abs()))];
        max(&*self.local.division.ranks, &mut solved);
        let lambda: Vec<f64> = if solved[0] > 0.0 { of_own(before) } else { found.solution.lambda.clone() };
        statics::limit_load(self.local, (self.multigrid, &self.own), &lambda)
    }

    /// The sum of the sizes of all loads, force.
    fn sum_of_loads(&self) -> f64 {
        let Local { problem, model, division, .. } = &*self.local;
        let own = model.dofs.free.iter().zip(&problem.elastic.f).filter(|(dof, _)| division.is_own(**dof / 3));
        let mut all = [own.map(|(_, f)| f.abs()).sum::<f64>()];
        sum(&*division.ranks, &mut all);
        all[0]
    }

    /// Whether a point that takes no part carries force: nothing else keeps a body there.
    fn is_held_by_what_is_out(&self, lambda: &[f64]) -> bool {
        if !changes_laws(self.case) {
            return false;
        }
        let mut carried =
            [self.local.problem.contact.out.iter().fold(0.0, |most: f64, &j| most.max(lambda[j as usize]))];
        max(&*self.local.division.ranks, &mut carried);
        carried[0] > 0.0
    }

    /// Puts what acts at time `t` into the problem, which without steps, bolts and obstacles that move contains it.
    fn put(&mut self, t: f64, slid: &[f64], shortening: &[f64]) -> Result<(), Error> {
        if !changes(self.case) && shortening.is_empty() {
            return Ok(());
        }
        let ranks = Arc::clone(&self.local.division.ranks);
        agree(&*ranks, put_state(self.local, self.case, t, slid, shortening))?;
        if let Some(own) = self.multigrid.renewed(&self.local.problem) {
            self.own = own;
        }
        Ok(())
    }

    /// Settings that start from `from`, or from bolts that bear.
    fn starting(&self, from: Option<&[f64]>, shortening: &[f64]) -> friction::Settings {
        let given = from.map(<[f64]>::to_vec);
        let given = given.or_else(|| bolts::start(self.local, (&*self.multigrid, &self.own), shortening));
        friction::Settings { start_displacement: given, ..self.settings.clone() }
    }

    /// Whether friction may hold a floating body without any load, as it does a wedge: where something has slid.
    fn may_be_locked(&self) -> bool {
        let has_slid = self.local.problem.contact.slip_reference.iter().any(|&slid| slid != 0.0);
        let mut ranks = [f64::from(u8::from(has_slid))];
        max(&*self.local.division.ranks, &mut ranks);
        ranks[0] > 0.0 && !self.multigrid.motions().is_empty()
    }

    /// Whether an answer holds by forces that friction locks, where nothing acts.
    fn is_locked(&self, found: &Solution) -> bool {
        let is_locked = found.status == Status::Solved && found.lambda.iter().any(|&force| force != 0.0);
        let mut ranks = [f64::from(u8::from(is_locked))];
        max(&*self.local.division.ranks, &mut ranks);
        ranks[0] > 0.0
    }

    /// The answer where nothing acts.
    fn at_rest(&self) -> Option<Solution> {
        let Local { problem, division, .. } = &*self.local;
        let mut others = [f64::from(u8::from(!Solution::may_rest(problem)))];
        max(&*division.ranks, &mut others);
        let no_forces = vec![0.0; 3 * problem.points()];
        let certificate =
            |u: &[f64], _: &[f64]| certify_divided(problem, division, u, &no_forces, self.settings.tolerance);
        let of = (problem.unknowns(), &self.own.contact.friction[..]);
        if others == [0.0] { Solution::at_rest(of, SolverPath::Multigrid, &certificate) } else { None }
    }

    /// Solves from the displacements given, and if that fails from the beginning.
    ///
    /// # Errors
    /// If equations over many nodes depend on one another, at every rank.
    pub(super) fn attempt(&mut self, from: Option<&[f64]>, shortening: &[f64]) -> Result<Solution, Error> {
        let at_rest = self.at_rest();
        if !self.may_be_locked()
            && let Some(at_rest) = at_rest
        {
            return Ok(at_rest);
        }
        let mut settings = self.starting(from, shortening);
        if at_rest.is_some() {
            settings.max_iterations = settings.max_iterations.min(LOCKED);
        }
        let first = self.solved(&settings)?;
        if first.status == Status::Interrupted {
            return Ok(first);
        }
        if !self.is_locked(&first)
            && let Some(at_rest) = at_rest
        {
            return Ok(Solution { counts: first.counts, history: first.history, ..at_rest });
        }
        if from.is_none() || !matches!(first.status, Status::MaxIterations | Status::Stalled) {
            return Ok(first);
        }
        let settings = self.starting(None, shortening);
        let mut second = self.solved(&settings)?;
        second.counts.add(&first.counts);
        self.attempts += 1;
        Ok(second)
    }

    fn solved(&mut self, settings: &friction::Settings) -> Result<Solution, Error> {
        let found = self.multigrid.set_up(&self.own).solution(&self.own, settings, self.observer);
        found.map_err(|_| dependent(self.case))
    }
}

/// Cycles in which forces that friction locks are found where nothing acts, if there are any: from the answer before they take those of
/// any step. Where there are none the iteration has nothing to measure its residual by.
const LOCKED: usize = 100;

/// Where multigrid has no field for an equation over many nodes.
fn dependent(case: &Case) -> Error {
    let of_couplings = case.couplings.iter().map(|coupling| &coupling.spot);
    let spot = case.equations.iter().map(|equation| &equation.spot).chain(of_couplings).next();
    let what =
        "equations over many nodes, or mean motions, that depend on one another, on supports or on closed contact";
    scope::refused(spot.unwrap_or(&case.mesh.spot), what)
}
