//! Files and cases as others write them, damaged ones, and the order of the modules.

#[path = "../common/case_run.rs"]
mod case_run;
#[path = "../common/mod.rs"]
mod common;

mod architecture;
mod fclib;
mod friction_arrays;
mod inputs;
