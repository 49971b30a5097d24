//! A case on several ranks: each makes or reads its part of the mesh, or rank 0 divides the whole; each poses, solves and writes its own.
//!
//! What ranks cannot do yet is refused by name (`scope`).

mod bolts;
mod cells;
mod check;
mod components;
mod deck;
mod elements;
mod energy;
mod estimate;
mod facts;
mod fretting;
mod gather;
mod generate;
mod hash;
mod homes;
mod keep;
mod local;
mod loose;
mod matching;
mod nested;
mod numbering;
mod outside;
#[cfg(feature = "report")]
mod page;
mod parts;
mod ranges;
mod record;
mod refine;
mod remarks;
mod report;
mod room;
mod scope;
mod share;
#[cfg_attr(not(all(feature = "plots", feature = "report")), path = "not_shown.rs")]
mod shown;
mod small;
mod solve;
mod statics;
mod steps;
mod surfaces;
mod ties;
mod tighten;
mod timed;
mod totals;
mod tractions;
mod write;

pub use check::check;
pub use deck::case_of_deck;
pub use keep::Keep;
#[cfg(feature = "report")]
pub use page::write_report;
pub use solve::{RankedAnswer, solve_on_ranks, solve_steps_on_ranks};
pub use write::{ForPeople, Written, write_on_ranks};
