//! The command as a user runs it: what it prints, writes and refuses; and the shipped cases and recipes, each held against
//! statics, a closed form or a published number.

mod accuracy;
mod algebraic;
mod bad_input;
mod both_sides;
mod bound;
mod ccx;
mod decks;
mod durable;
mod faults;
mod folder;
mod interrupt;
mod memory;
mod paper;
mod passing;
mod recipes;
mod report;
mod several_bodies;
mod shell;
mod shipped;
mod smaller;
mod solve_and_check;
mod steps;
mod tampering;
