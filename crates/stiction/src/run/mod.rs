//! The whole way: from a case to a certified answer in a folder.
//!
//! Four rooms, each of which uses those before it: `pose` reads the mesh, resolves names and poses the contact problem
//! ([`prepare`]); `solve` solves and certifies it, one load step after the other ([`solve()`], [`solve_steps`]); `refine`
//! does so on ever finer meshes until the answer is accurate enough ([`solve_to_accuracy`]); `results`
//! fills the result folder ([`write()`]) and judges one anew from its files alone ([`check`]). [`solve_case`] goes the whole
//! way, [`solve_on_ranks`] goes one of its own for several ranks.

mod pose;
mod ranks;
mod refine;
mod results;
mod solve;
mod whole;

pub use crate::contact::escape::Escape;
pub use pose::{
    Bolt, BoltFacts, ContactFacts, Coupling, CouplingFacts, CyclicFacts, Facts, FixFacts, Initial, LoadFacts, Loading,
    MaterialFacts, MemoryLimit, Prepared, Seconds, Span, SpringFacts, prepare, read_mesh,
};
#[cfg(feature = "report")]
pub use ranks::write_report;
pub use ranks::{
    ForPeople, Keep, RankedAnswer, Written, case_of_deck, check, solve_on_ranks, solve_steps_on_ranks, write_on_ranks,
};
pub use refine::{Indicators, Level, Levels, Sequence, SolvedLevel, solve_to_accuracy};
#[cfg(feature = "report")]
pub use results::write_report_on;
pub use results::{
    Ahead, BodyFields, Checked, CheckedStep, FORMAT, FrettingRecord, Origin, REPORT, RankRecord, RanksRecord, Report,
    Row, SUMS, Side, StepFiles, Summary, SurfaceFields, Versions, begin_steps, body_fields, ended_short, keep_step,
    level_line, limit_load, passes_through, phase_name, report, solve_writing, summary, surface_fields, uniqueness,
    widened_before, writable, write, write_with,
};
pub use solve::{
    AccuracyRecord, AnswerRecord, AttemptRecord, Balance, BalanceRecord, BodyRecord, BoltState, BoundRecord,
    CertificateRecord, CountsRecord, CouplingState, DistinctRecord, Event, GoalRecord, KeepStep, LevelRecord,
    MethodDetails, Named, Outcome, OverlapName, OverlapRecord, PairRecord, PartRecord, Restart, Settings,
    SlidingRecord, SolutionsRecord, Step, StepLine, StepRecord, Totals, UniquenessRecord, ValueRecord, add_bound,
    bolt_states, coupling_states, discretisation_error, error_bound, escape, escape_of, pair_totals, solve,
    solve_steps, totals, widened,
};

pub use solve::quantities::{
    AdriftRecord, FacetedRecord, Micromotion, SMALL_ROTATION, SMALL_STRAIN, Smallness, nodal_stress_of,
};
pub use whole::{Plan, Stage, Teller, solve_case};

/// Discrete problems given as matrices.
pub mod algebraic {
    #[cfg(feature = "fclib")]
    pub use super::results::algebraic::write;
    pub use super::results::algebraic::{report, summary, table_head, table_row};
    pub use super::solve::algebraic::{Answer, Guess, Seconds, answer, answer_with_rank, read};
}
