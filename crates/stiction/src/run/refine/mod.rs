//! An answer as accurate as asked: solve, estimate the error, refine the cells that hold most of it, and again.
//!
//! The meshes are nested and of tetrahedra. Each level starts from the displacements of the one before it. Which surface of a
//! pair carries the contact points, and how far counterparts are looked for, stays what the first mesh gave.

mod first;
mod marking;
mod prediction;
mod sequence;
mod shape;
mod sharp_edges;
mod values;

pub(super) use sequence::other_case;
pub use sequence::{Indicators, Level, Levels, Sequence, SolvedLevel, solve_to_accuracy};
