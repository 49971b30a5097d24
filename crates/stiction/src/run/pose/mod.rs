//! From a case to a posed problem.

mod arrays;
pub(super) mod axis;
pub(super) mod bolts;
mod coarser;
mod coefficients;
mod facts;
pub(super) mod frames;
mod loads;
mod materials;
mod mesh;
pub(super) mod moment;
mod notes;
mod path;
pub(super) mod place;
mod prepare;
mod regions;
mod seconds;
mod surfaces;

pub use bolts::Bolt;
pub(super) use coarser::Coarser;
pub use facts::{BoltFacts, ContactFacts, Facts, FixFacts, LoadFacts, MaterialFacts, SpringFacts};
pub use mesh::read_mesh;
pub use moment::{Acting, Initial};
pub use prepare::{Prepared, prepare};
pub(super) use seconds::stopwatch;
pub use seconds::{Seconds, Span};
