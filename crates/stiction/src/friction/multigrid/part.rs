//! Multigrid where points share their nodes with others that are out: the problem of the points that are in, each of which then has
//! a node of its own.

use super::solve::Multigrid;
use crate::certificate::certify;
use crate::contact::ContactProblem;
use crate::friction::{PointState, Solution, Status};

/// A hierarchy, and where it is not that of all points those that it is of.
pub(crate) struct SetUp<'a> {
    pub multigrid: &'a mut Multigrid,
    pub part: Option<Part>,
}

/// The points that are in, and the problem of these alone.
pub(crate) struct Part {
    points: Vec<u32>,
    pub problem: ContactProblem,
}

/// The points that are in, ascending.
pub(crate) fn points_in(problem: &ContactProblem) -> Vec<u32> {
    let out = &problem.contact.out;
    (0..problem.points() as u32).filter(|j| out.binary_search(j).is_err()).collect()
}

impl Part {
    pub(crate) fn new(problem: &ContactProblem, points: Vec<u32>) -> Part {
        Part { problem: problem.of_points(&points), points }
    }

    /// The multipliers of all points of the whole problem, `3m`.
    pub(crate) fn of_all(&self, whole: &ContactProblem, lambda: &[f64]) -> Vec<f64> {
        whole.of_all_points(&self.points, lambda)
    }

    /// The solution of the whole problem, judged as such; points that are out are open.
    pub(crate) fn whole(&self, whole: &ContactProblem, solution: Solution) -> Solution {
        let lambda = self.of_all(whole, &solution.lambda);
        let mut states = vec![PointState::Open; whole.points()];
        self.points.iter().zip(&solution.states).for_each(|(&j, &state)| states[j as usize] = state);
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
