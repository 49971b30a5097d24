//! A case on several ranks: rank 0 makes the mesh and divides it, each rank poses, solves and writes its own part.
//!
//! What ranks cannot do yet is refused by name (`scope`).

mod bolts;
mod local;
mod record;
mod scope;
mod share;
mod small;
mod solve;
mod steps;
mod tighten;
mod totals;
mod tractions;
mod write;

pub use record::{RankRecord, RankedStep, RankedSummary};
pub use solve::{RankedAnswer, solve_on_ranks};
pub use write::write_on_ranks;
