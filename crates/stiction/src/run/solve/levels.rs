//! What is known of an answer on a sequence of ever finer meshes.

use serde::{Deserialize, Serialize};

use super::named::Named;
use super::record::or_nan;

/// How accurate the answer of the last mesh is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AccuracyRecord {
    /// What was asked for.
    pub goals: Vec<GoalRecord>,
    /// Whether all of it was reached.
    pub reached: bool,
    /// Why refinement ended before that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended: Option<String>,
    /// Displacements at which the goals are expected to be met, where they are not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub needed_unknowns: Option<f64>,
    /// One for each mesh.
    pub levels: Vec<LevelRecord>,
    /// What the last mesh gives, with error bars.
    pub values: Vec<ValueRecord>,
    /// What finer meshes do not mend.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// A goal and what was reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GoalRecord {
    /// The key of the case.
    pub name: String,
    /// Relative error asked for.
    pub asked: f64,
    /// What the last mesh has; none before there are enough meshes to tell.
    pub reached: Option<f64>,
}

impl GoalRecord {
    /// Whether it is met.
    pub fn met(&self) -> bool {
        self.reached.is_some_and(|reached| reached <= self.asked)
    }
}

/// A mesh of the sequence and its answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LevelRecord {
    /// From 0.
    pub level: usize,
    /// Tetrahedra.
    pub cells: usize,
    /// Displacements that were solved for.
    pub unknowns: usize,
    /// Contact points.
    pub points: usize,
    /// Estimated error in the energy norm, relative; of load steps the largest.
    #[serde(deserialize_with = "or_nan")]
    pub error: f64,
    /// Proven bound of the error of the mean stress, relative, where a goal has asked for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<f64>,
    /// Iterations or cycles; of load steps their sum.
    pub iterations: usize,
    /// CPU seconds of the level.
    pub cpu_seconds: f64,
    /// What is read from the answer, by name.
    pub values: Named,
    /// Their error bars if this were the last mesh; those that are not known, and values without a bound, are left out.
    #[serde(default)]
    pub bars: Named,
}

impl LevelRecord {
    /// What a goal in the energy norm is held against: where it has to be proven the bound, if there is one, but no less than the
    /// estimate, which speaks of all load steps.
    pub(in crate::run) fn known(&self, proven: bool) -> f64 {
        self.bound.filter(|_| proven).map_or(self.error, |bound| bound.max(self.error))
    }
}

/// Name of the largest pressure of a contact among the values, before that of the contact.
pub(in crate::run) const LARGEST_PRESSURE: &str = "largest pressure";

/// A number of the last mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ValueRecord {
    /// What it is.
    pub name: String,
    /// `None` where it grows with every mesh.
    pub value: Option<f64>,
    /// The exact value is expected within this distance; none before there are enough meshes to tell.
    pub bar: Option<f64>,
    /// The time of the end of a load step before the last, if it is a number of that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub t: Option<f64>,
}
