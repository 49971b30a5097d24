//! From a posed problem to a certified answer.

pub(super) mod balance;
mod bolts;
mod clearance;
mod nested;
mod path;
mod steps;
mod totals;

pub use balance::Balance;
pub use bolts::{BoltState, bolt_states};
pub use path::{Event, Outcome, Path, Settings, StepLine, solve};
pub use steps::{KeepStep, Restart, Step, solve_steps};
pub use totals::{Totals, pair_totals, totals};
