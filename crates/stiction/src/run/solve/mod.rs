//! From a posed problem to a certified answer.

pub(super) mod algebraic;
pub(super) mod balance;
pub(super) mod bolts;
mod bound;
pub(super) mod clearance;
mod contact_edge;
mod contact_terms;
mod couplings;
mod discretisation;
pub(super) mod extrapolation;
pub(in crate::run) mod free_motions;
mod levels;
mod named;
pub(crate) mod nested;
pub(super) mod passing;
pub(super) mod path;
pub(super) mod quantities;
mod record;
mod solutions;
mod steps;
pub(super) mod strength;
pub(super) mod stretch;
mod totals;
pub(crate) mod tractions;

pub use balance::Balance;
pub use bolts::{BoltState, bolt_states};
pub use bound::{BoundRecord, add_bound, error_bound};
pub(super) use contact_edge::edges;
pub(super) use contact_terms::contact_terms;
pub use couplings::{CouplingState, coupling_states};
pub use discretisation::discretisation_error;
pub(in crate::run) use levels::LARGEST_PRESSURE;
pub use levels::{AccuracyRecord, GoalRecord, LevelRecord, ValueRecord};
pub use named::Named;
pub use passing::widened;
pub use path::{Event, Outcome, Settings, StepLine, solve};
pub use quantities::{escape, escape_of};
pub use record::{
    AnswerRecord, BalanceRecord, BodyRecord, CertificateRecord, CountsRecord, MethodDetails, OverlapName,
    OverlapRecord, PairRecord, PartRecord, SlidingRecord, StepRecord,
};
pub(super) use record::{Whereabouts, or_infinite, seconds, word};
pub use solutions::{AttemptRecord, DistinctRecord, SolutionsRecord, UniquenessRecord};
pub use steps::{KeepStep, Restart, Step, solve_steps};
pub use totals::{Totals, pair_totals, totals};
