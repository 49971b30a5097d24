//! A case on several ranks: rank 0 reads the mesh and divides it, or each rank makes its part; each poses, solves and writes its own.
//!
//! What ranks cannot do yet is refused by name (`scope`).

mod bolts;
mod cells;
mod check;
mod components;
mod generate;
mod hash;
mod homes;
mod keep;
mod local;
mod numbering;
mod parts;
mod ranges;
mod record;
mod room;
mod scope;
mod share;
mod small;
mod solve;
mod steps;
mod tighten;
mod timed;
mod totals;
mod tractions;
mod write;

pub use check::check;
pub use keep::Keep;
pub use record::{RankRecord, RankedStep, RankedSummary};
pub use solve::{RankedAnswer, solve_on_ranks, solve_steps_on_ranks};
pub use write::write_on_ranks;
