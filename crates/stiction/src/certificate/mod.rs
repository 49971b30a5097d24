//! The certificate: is this displacement and this multiplier a solution of this problem?
//!
//! Recomputed from the problem's data by code that shares nothing with the solvers. Every measure is dimensionless,
//! an inequality against the tolerance, and does not change with the units. On several ranks each counts what is its own, with
//! an exchange that no solver uses.

mod balance;
mod bound;
mod duality;
mod measures;
mod parts;
mod point;
mod scales;
mod share;
mod stiffness;

pub use balance::{Balance, BodyBalance};
pub use bound::{
    BOUND_TOLERANCE, BoundClaim, BoundFields, BoundMeasure, BoundSide, BoundUnknown, FlatObstacle, JudgedBound, Touch,
    judge_bound, judge_tie,
};
pub use measures::{Certificate, PART_TOLERANCE, certify, certify_divided};
pub use parts::{Part, PartMeasure};
pub(crate) use share::fetched as ghost_values;
