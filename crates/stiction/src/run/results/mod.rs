//! From an answer to a folder of results, and back.

mod accuracy_text;
mod ahead;
pub(super) mod algebraic;
pub(super) mod beside;
pub(super) mod check;
pub(super) mod check_steps;
pub(super) mod contact_csv;
pub(super) mod facts_text;
pub(super) mod fields;
mod fretting;
#[cfg(feature = "report")]
mod html;
pub(super) mod json;
mod kept;
mod level_file;
mod masters;
mod method_text;
mod of_ranks;
pub(super) mod overlap_text;
#[cfg(feature = "report")]
pub(super) mod page;
mod pair_text;
#[cfg_attr(not(feature = "plots"), path = "no_pictures.rs")]
pub(super) mod pictures;
pub(super) mod report;
mod rows;
pub(super) mod smallness_text;
pub(super) mod step_file;
pub(super) mod summary;
pub(super) mod sums;
#[cfg(feature = "report")]
pub(super) mod view;
pub(super) mod write;

pub use accuracy_text::level as level_line;
pub(super) use accuracy_text::rows as accuracy_rows;
pub use ahead::{Ahead, solve_writing};
pub use check::Checked;
pub use check_steps::CheckedStep;
pub use fields::{BodyFields, Side, SurfaceFields, body as body_fields};
pub use fretting::FrettingRecord;
pub(super) use fretting::{FIGURES, Fretting, PointHistory, PointStep, tension_along};
pub(super) use level_file::{LEVELS, keep_levels, kept_levels, problem_fingerprint, remove_levels};
pub use masters::pair_fields as surface_fields;
pub use of_ranks::{RankRecord, RanksRecord};
#[cfg(feature = "report")]
pub use page::write_report_on;
pub use report::{Report, ended_short, limit_load, passes_through, report, uniqueness};
pub use rows::Row;
pub(super) use rows::{Rows, print};
pub use step_file::{StepFiles, begin_steps, keep_step, widened_before};
pub(super) use step_file::{adopt_steps, discard_steps};
pub use summary::{FORMAT, Summary, Versions, summary};
pub use sums::SUMS;
pub use write::{Origin, phase_name, writable, write, write_with};

/// The name of the report in a result folder.
pub const REPORT: &str = "report.html";
