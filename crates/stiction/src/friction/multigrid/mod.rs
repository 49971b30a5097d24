//! Multigrid for contact with friction: an active-set iteration on the displacements with one multigrid cycle for each
//! change of the active sets. It costs little more than one linear solve and needs no factor, which suits large problems.
//!
//! [`solve_multigrid`] walks the stages of the fallback strategy (`strategy.rs`). The iteration is `iteration.rs`;
//! with `tightening.rs` it finds the shortenings of bolts whose force is given as well. The trials
//! by which constants were chosen are in docs/notes/2026-11-23-multigrid-trials.md.

// Three components and three directions are read by their indices.
#![allow(clippy::needless_range_loop)]

mod active_set;
mod coarse_start;
mod descent;
mod directions;
mod divided;
mod divided_bodies;
mod elastic;
mod equations;
mod fixed_point;
mod floating;
mod iteration;
mod layers;
mod loose;
mod memory;
mod monitor;
mod part;
mod points;
mod shortened;
mod solve;
mod springs;
mod step_length;
mod strategy;
#[cfg(test)]
mod tests;
mod tightening;
mod transform;
mod uniqueness;

pub(crate) use equations::{MOST as MOST_EQUATIONS, equations, is_over_many};
pub(crate) use memory::{multigrid_bytes, multigrid_fits};
pub(crate) use part::{Part, SetUp, points_in};
pub use solve::{Multigrid, solve_multigrid};
pub(crate) use tightening::{SoughtForce, Tightened};
pub use uniqueness::coulomb_facts_by_multigrid;
