//! The second waist: `min 1/2 x'Ax - b'x` over a simple set, with `A` as an operator. Knows no mesh and no friction.
//!
//! [`minimize_in_bounds`] for bounds on single entries; [`minimize_in_sets`] for products of
//! [`PointSet`]s.

mod arc;
mod bounds;
mod face;
mod iterate;
mod kprgp;
mod mprgp;
mod program;
mod set;
mod sets;
mod status;

pub use bounds::{Bounds, minimize_in_bounds};
pub use face::Preconditioner;
pub use iterate::Stop;
pub use mprgp::MprgpSettings;
pub use program::{Program, QpCounts, QpSolution};
pub use set::{PointSet, project};
pub use sets::{SetSettings, minimize_in_sets};
pub use status::QpStatus;

#[cfg(test)]
mod tests;
