//! From an answer to a folder of results, and back.

mod ahead;
pub mod algebraic;
mod check;
mod check_steps;
mod facts_text;
pub(super) mod fields;
mod method_text;
mod page;
mod pair_text;
mod pictures;
mod report;
mod sides;
mod step_file;
pub(super) mod summary;
mod view;
mod write;

pub use ahead::{Ahead, solve_writing};
pub use check::{Checked, check};
pub use check_steps::CheckedStep;
pub use page::{REPORT, write_report, write_report_on};
pub use report::{departure, report, uniqueness, used_up};
pub use step_file::{StepFiles, begin_steps, keep_step};
pub use summary::summary;
pub use write::{Origin, writable, write, write_with};
