//! Contact surfaces and obstacles; poses the [`ContactProblem`], the first waist of the program.

mod closest;
pub mod equilibrium;
mod flat;
mod frame;
mod friction_law;
mod isotropic;
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
pub mod sliding;
mod surface;
mod triangles;

pub use obstacle::{Obstacle, Side};
pub use patches::{Patch, patches};
pub use pose::pose;
pub use problem::{Bodies, Body, Contact, ContactProblem, Elastic, Friction, Labels, Pair, Supports};
pub use roles::{Reason, Role, choose_slave, reverse_where_held};
pub use surface::{
    Across, Coefficient, ContactSurface, CoulombLaw, Counterpart, InitialGap, Master, PairFacts, SEARCH, SurfaceFacts,
    SurfaceFriction,
};
pub use triangles::{RawSurface, Triangles};
