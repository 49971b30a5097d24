//! Records of what is known of other solutions, and of what several starts have found.

use serde::{Deserialize, Serialize};

use super::quantities::energy;
use super::record::or_infinite;
use crate::friction::{CoulombFacts, PointState, Solution, Status};
use crate::linalg::dot;
use crate::run::pose::Prepared;
use crate::solve::{Attempt, Solutions};

/// What is known of other solutions where friction is Coulomb's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UniquenessRecord {
    /// Estimated contraction of the fixed point.
    #[serde(deserialize_with = "or_infinite")]
    pub contraction: f64,
    /// Bound on the coefficient below which the solution is unique.
    pub uniqueness_bound: Option<f64>,
    /// The largest coefficient of the problem.
    pub largest_coefficient: f64,
    /// Whether the coefficient is below the bound.
    pub unique: bool,
}

impl UniquenessRecord {
    pub(crate) fn of(facts: &CoulombFacts) -> Self {
        UniquenessRecord {
            contraction: facts.contraction,
            uniqueness_bound: facts.uniqueness_bound,
            largest_coefficient: facts.largest_coefficient,
            unique: facts.proved_unique(),
        }
    }
}

/// What several starts have found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SolutionsRecord {
    /// One for each start that was tried.
    pub starts: Vec<AttemptRecord>,
    /// Certified solutions that differ; the first is the answer, number `k` from 2 on is in `solution-k.npz`.
    pub distinct: Vec<DistinctRecord>,
    /// Why not all starts were tried.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended: Option<String>,
}

/// A start and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AttemptRecord {
    /// Its name.
    pub start: String,
    /// How it ended.
    pub status: Status,
    /// Number of the solution it has found, from 1.
    pub solution: Option<usize>,
}

/// One of several solutions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DistinctRecord {
    /// `1/2 u'Ku - f'u`, as that of the answer.
    pub energy: f64,
    /// Work of friction along the slip, of the last load step if there are any.
    pub dissipation: f64,
    /// Sum of the normal forces.
    pub normal_force: f64,
    /// Points that are open.
    pub open: usize,
    /// Points that stick.
    pub stick: usize,
    /// Points that slip.
    pub slip: usize,
    /// The worst measure of its certificate.
    #[serde(deserialize_with = "or_infinite")]
    pub worst: f64,
}

impl SolutionsRecord {
    pub(crate) fn of(prepared: &Prepared, found: &Solutions) -> Self {
        let attempt = |attempt: &Attempt| AttemptRecord {
            start: attempt.start.name(),
            status: attempt.status,
            solution: attempt.solution.map(|place| place + 1),
        };
        SolutionsRecord {
            starts: found.attempts.iter().map(attempt).collect(),
            distinct: found.distinct.iter().map(|solution| DistinctRecord::of(prepared, solution)).collect(),
            ended: found
                .ended
                .as_ref()
                .map(|error| if error.interrupted { "interrupted".into() } else { error.to_string() }),
        }
    }
}

impl DistinctRecord {
    fn of(prepared: &Prepared, solution: &Solution) -> Self {
        let problem = &prepared.problem;
        let m = problem.points();
        let count = |state| solution.states.iter().filter(|s| **s == state).count();
        // `v` of the tangents is minus the slip.
        let v = problem.gap_and_slip(&solution.u);
        DistinctRecord {
            energy: energy(prepared, &solution.u),
            dissipation: -dot(&solution.lambda[m..], &v[m..]),
            normal_force: dot(&problem.labels.unity_sum, &solution.lambda[..m]),
            open: count(PointState::Open),
            stick: count(PointState::Stick),
            slip: count(PointState::Slip),
            worst: solution.certificate.worst,
        }
    }
}
