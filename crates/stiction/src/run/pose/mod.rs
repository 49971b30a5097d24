//! From a case to a posed problem.

pub(super) mod activity;
mod arrays;
pub(super) mod axis;
pub(super) mod bolts;
mod coarser;
pub(super) mod coefficients;
mod counts;
pub(super) mod couplings;
pub(super) mod cut_sides;
mod cyclic;
mod facts;
pub(super) mod frames;
pub(super) mod interface;
pub(super) mod load_state;
pub(super) mod loads;
pub(super) mod materials;
pub(super) mod memory;
mod mesh;
pub(super) mod notes;
mod path;
pub(super) mod place;
mod prepare;
pub(super) mod regions;
mod seconds;
pub(super) mod surfaces;
pub(super) mod ties;
mod travel;

pub use bolts::Bolt;
pub(super) use coarser::{Coarser, CoarserCase};
pub use couplings::Coupling;
pub use facts::{
    BoltFacts, ContactFacts, CouplingFacts, CyclicFacts, Facts, FixFacts, LoadFacts, MaterialFacts, SpringFacts,
};
pub use load_state::{Initial, Loading};
pub use memory::MemoryLimit;
pub(super) use mesh::mesh as made_mesh;
pub use mesh::read_mesh;
pub use prepare::{Prepared, prepare};
pub(super) use prepare::{coupling_facts, planned, prepare_to_look_at, refuse_loss_without_steps};
pub(super) use seconds::stopwatch;
pub use seconds::{Seconds, Span};
