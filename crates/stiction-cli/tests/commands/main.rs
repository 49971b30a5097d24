//! The command as a user runs it: what it prints, what it writes, what it refuses.

#[path = "../common/mod.rs"]
mod common;

mod algebraic;
mod bad_input;
mod both_sides;
mod interrupt;
mod paper;
mod report;
mod smaller;
mod solve_and_check;
mod steps;
