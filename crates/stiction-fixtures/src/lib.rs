//! Makers of bodies, cases, files and piles that tests and benchmarks share, and the shortest way to an answer.
//!
//! Makers panic where the library refuses what they made: that is a mistake of the test.

pub mod bricks;
pub mod campaign;
pub mod case_run;
pub mod counting;
pub mod dense;
pub mod failing;
pub mod faults;
pub mod folder;
pub mod fuzz;
pub mod hostile;
mod mutate;
pub mod piles;
pub mod random_assembly;
pub mod random_case;
pub mod renumbered;
pub mod tamper;
pub mod written;

pub use bricks::*;
