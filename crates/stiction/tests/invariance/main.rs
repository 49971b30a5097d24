//! What must not change an answer: units, place in space, numbering, threads.

#[path = "../common/case_run.rs"]
mod case_run;
#[path = "../common/mod.rs"]
mod common;

mod frames;
mod slanted_symmetry;
