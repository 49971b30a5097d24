//! Contact surfaces and obstacles; poses the [`ContactProblem`], the first waist of the program.

mod discrete;
pub mod equilibrium;
mod flat;
mod frame;
mod mortar;
mod normals;
mod obstacle;
mod pair;
mod patches;
mod points;
mod pose;
mod problem;
pub mod rigid;
mod roles;
mod surface;

pub use discrete::{Bilateral, DiscreteProblem, Equalities, GlobalProblem, LocalProblem};
pub use obstacle::{Obstacle, Side};
pub use pose::pose;
pub use problem::{Bodies, Body, ContactProblem, Friction, Pair, Supports};
pub use roles::{Reason, Role, choose_slave};
pub use surface::{ContactSurface, Counterpart, InitialGap, Master, PairFacts, SEARCH, SurfaceFacts, SurfaceFriction};
