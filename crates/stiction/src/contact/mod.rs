//! Contact surfaces and obstacles; poses the [`ContactProblem`], the first waist of the program.

mod discrete;
mod obstacle;
mod pose;
mod problem;
pub mod rigid;

pub use discrete::{Bilateral, DiscreteProblem, Equalities, GlobalProblem, LocalProblem};
pub use obstacle::{Obstacle, Side};
pub use pose::{ContactSurface, SurfaceFacts, SurfaceFriction, pose};
pub use problem::{ContactProblem, Friction, Pair, Supports};
