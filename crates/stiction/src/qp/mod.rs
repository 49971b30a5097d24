//! The second waist: `min 1/2 x'Ax - b'x` over a simple set, with `A` as an operator. Knows no mesh and no friction.

mod accelerated;
mod set;

pub use accelerated::{Accelerated, accelerated_gradient};
pub use set::{PointSet, project};
