//! The primal path: contact with friction by one multigrid cycle a change of the active sets.
#![allow(clippy::needless_range_loop)]

mod frames;
mod iteration;
mod sets;

pub use iteration::{PrimalSettings, PrimalResult, primal};
