//! Discrete problems with Coulomb friction that come as matrices, `W` singular, not quite symmetric and of any scale.
//!
//! The way: [`prepare`] leaves out redundant constraints and condenses a global problem to its points ([`condense`]) or
//! keeps its velocities, whichever is cheaper; every point is scaled by the trace of its block of `W`; gradients choose a
//! start; proximal terms make the problem regular ([`solve`]); each regularised problem is solved by a semismooth Newton
//! method on the law of Alart and Curnier, with sparse unsymmetric factors; where Newton's method fails the proximal term
//! grows, and at last sweeps or gradients start it from elsewhere.

mod admm;
mod blocks;
mod condense;
mod form;
mod gradient;
mod linear;
mod measures;
mod monitor;
mod problem;
mod proximal;
mod rank;
mod redundant;
mod saddle;
mod settings;
mod solve;
mod sparse;
mod sweeps;
mod system;

pub use condense::{Condensed, Recovered, condense};
pub use form::{Form, Prepared, prepare};
pub use measures::{Measures, measure};
pub use problem::{Bilateral, DiscreteProblem, Equalities, GlobalProblem, LocalProblem};
pub use rank::rank;
pub use settings::{Counts, Method, Progress, Settings, Solution, Status};
pub use solve::solve;

use crate::friction::law::V3;
