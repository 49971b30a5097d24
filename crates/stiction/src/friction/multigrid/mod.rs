//! The primal path: the displacements themselves by multigrid, one cycle for each change of the active sets. Costs
//! little more than one linear solve and needs no factor, so it is the path of large problems.

// Three components and three directions are told by their indices.
#![allow(clippy::needless_range_loop)]

mod bounds;
mod descent;
mod directions;
mod floating;
mod frames;
mod iteration;
mod nested;
mod sets;
mod solve;

pub use solve::{Primal, descend_primal, solve_primal};
