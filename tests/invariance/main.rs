//! What must not change an answer: units, place in space, numbering, threads.

mod frames;
mod ranks;
mod refinement;
mod slanted_symmetry;
mod stop;
