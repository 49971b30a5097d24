//! The whole way: from a case to a certified answer in a folder.
//!
//! [`prepare`] reads the mesh, resolves names and poses the contact problem; [`solve`] solves and certifies it;
//! [`write()`] fills the result folder; [`check`] judges a result folder anew from its files alone.

mod ahead;
pub mod algebraic;
mod axis;
mod balance;
mod bolts;
mod check;
mod check_steps;
mod facts;
mod facts_text;
mod fields;
mod loads;
mod materials;
mod mesh;
mod method_text;
mod moment;
mod nested;
mod page;
mod pair_text;
pub mod paper;
mod pictures;
mod place;
mod prepare;
mod regions;
mod report;
mod seconds;
mod sides;
mod solve;
mod step_file;
mod steps;
mod summary;
mod surfaces;
mod totals;
mod view;
mod write;

pub use ahead::{Ahead, solve_writing};
pub use balance::Balance;
pub use bolts::{Bolt, BoltState, bolt_states};
pub use check::{Checked, check};
pub use check_steps::CheckedStep;
pub use facts::{BoltFacts, ContactFacts, Facts, FixFacts, LoadFacts, MaterialFacts, SpringFacts};
pub use mesh::read_mesh;
pub use moment::{Acting, Initial};
pub use page::{REPORT, write_report, write_report_on};
pub use prepare::{Prepared, prepare};
pub use report::{departure, report, uniqueness};
pub use seconds::{Seconds, Span};
pub use solve::{Event, Outcome, Path, Settings, StepLine, solve};
pub use step_file::{StepFiles, begin_steps, keep_step};
pub use steps::{KeepStep, Restart, Step, solve_steps};
pub use summary::summary;
pub use totals::{Totals, pair_totals, totals};
pub use write::{Origin, writable, write, write_with};
