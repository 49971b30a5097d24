//! What mechanics says: closed forms, statics, published numbers, orders of convergence.

#[path = "../common/case_run.rs"]
mod case_run;
#[path = "../common/mod.rs"]
mod common;

mod bolts;
mod certificate;
mod closed_forms;
mod corners;
mod floating;
mod friction_laws;
mod geometry;
mod loads;
mod materials;
mod mortar;
mod published;
mod quadratic;
mod steps;
mod surfaces;
