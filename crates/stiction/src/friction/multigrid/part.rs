//! Multigrid of some of the points of a problem: where points share their nodes with others that are out, of those that are in, each of
//! which then has a node of its own; where some are equations over many nodes, of the others.

use super::equations::rows_of;
use super::solve::{Multigrid, solve_multigrid, solve_part};
use super::tightening::{SoughtForce, Tightened, tighten_by_multigrid, tighten_part};
use crate::Error;
use crate::certificate::certify;
use crate::contact::ContactProblem;
use crate::friction::{PointState, Progress, Settings, Solution, Status};
use crate::linalg::Watch;

/// A hierarchy, and where it is not that of all points those that it is of.
pub(crate) struct SetUp<'a> {
    pub multigrid: &'a mut Multigrid,
    pub part: Option<Part>,
}

impl SetUp<'_> {
    /// The solution of `problem`, as [`solve_multigrid`].
    ///
    /// # Errors
    /// If equations over many nodes depend on one another.
    pub(crate) fn solution(
        self,
        problem: &ContactProblem,
        settings: &Settings,
        observer: &mut Watch<Progress>,
    ) -> Result<Solution, Error> {
        match &self.part {
            None => Ok(solve_multigrid(problem, self.multigrid, settings, observer)),
            Some(part) => solve_part((problem, part), self.multigrid, settings, observer),
        }
    }

    /// The solution with the shortenings of bolts whose force is given, as [`tighten_by_multigrid`].
    ///
    /// # Errors
    /// As [`SetUp::solution`].
    pub(crate) fn tighten(
        self,
        problem: &ContactProblem,
        sought: &[SoughtForce],
        settings: &Settings,
        observer: &mut Watch<Progress>,
    ) -> Result<Tightened, Error> {
        match &self.part {
            None => Ok(tighten_by_multigrid(problem, self.multigrid, sought, settings, observer)),
            Some(part) => tighten_part((problem, part), self.multigrid, sought, settings, observer),
        }
    }
}

/// Some of the points, and the problem of these alone.
pub(crate) struct Part {
    pub(super) points: Vec<u32>,
    /// Points of the whole that hold as equations.
    pub equations: Vec<u32>,
    pub problem: ContactProblem,
}

/// The points that are in, ascending.
pub(crate) fn points_in(problem: &ContactProblem) -> Vec<u32> {
    let out = &problem.contact.out;
    (0..problem.points() as u32).filter(|j| out.binary_search(j).is_err()).collect()
}

impl Part {
    /// `equations` are all of the problem: those that are out do not hold.
    pub(crate) fn new(problem: &ContactProblem, points: Vec<u32>, mut equations: Vec<u32>) -> Part {
        equations.retain(|j| problem.contact.out.binary_search(j).is_err());
        Part { problem: problem.of_points(&points), points, equations }
    }

    /// The multipliers of all points of the whole problem, `3m`, from those of the points and of its equations.
    pub(crate) fn of_all(&self, whole: &ContactProblem, lambda: &[f64], multipliers: &[f64]) -> Vec<f64> {
        let mut all = whole.of_all_points(&self.points, lambda);
        let rows = rows_of(whole, &self.equations);
        rows.into_iter().zip(multipliers).for_each(|(i, &multiplier)| all[i] = multiplier);
        all
    }

    /// The states of all points of the whole problem from those of the points; points that are out are open.
    pub(crate) fn states_of_all(&self, whole: &ContactProblem, of_points: &[PointState]) -> Vec<PointState> {
        let mut states = vec![PointState::Open; whole.points()];
        self.equations.iter().for_each(|&j| states[j as usize] = PointState::Stick);
        self.points.iter().zip(of_points).for_each(|(&j, &state)| states[j as usize] = state);
        states
    }

    /// The solution of the whole problem, judged as such, from that of the points. No equation holds, and no rank has another part.
    pub(crate) fn whole(&self, whole: &ContactProblem, solution: Solution) -> Solution {
        let lambda = self.of_all(whole, &solution.lambda, &[]);
        let states = self.states_of_all(whole, &solution.states);
        let certificate = certify(whole, &solution.u, &lambda, solution.certificate.tolerance);
        let status = match solution.status {
            Status::Solved if !certificate.passed => Status::Stalled,
            status => status,
        };
        Solution { status, lambda, states, certificate, ..solution }
    }

    /// A solution of the whole problem at these points.
    pub(crate) fn narrowed(&self, solution: &Solution) -> Solution {
        let (m, all) = (self.points.len(), solution.states.len());
        let mut lambda = vec![0.0; 3 * m];
        for (place, &j) in self.points.iter().enumerate() {
            (0..3).for_each(|r| lambda[r * m + place] = solution.lambda[r * all + j as usize]);
        }
        let states = self.points.iter().map(|&j| solution.states[j as usize]).collect();
        Solution { lambda, states, ..solution.clone() }
    }
}
