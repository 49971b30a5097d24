//! The primal path: the displacements themselves by multigrid, one cycle for each change of the active sets. Costs
//! little more than one linear solve and needs no factor, so it is the path of large problems.

mod directions;
mod frames;
mod iteration;
mod sets;
mod solve;

pub use solve::{Primal, solve_primal};
