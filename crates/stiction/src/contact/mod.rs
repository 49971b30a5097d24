//! Contact surfaces and obstacles; poses the [`ContactProblem`], the first waist of the program.

mod chains;
mod claims;
mod closest;
mod division;
mod entered;
pub mod equilibrium;
pub mod escape;
mod false_overlap;
mod flat;
mod followers;
mod frame;
mod friction_law;
mod held;
mod hull;
mod isotropic;
mod law;
mod layer;
mod levels;
mod mortar;
mod node_to_surface;
mod normals;
mod obstacle;
mod overhang;
mod overlap;
mod pair;
mod part;
mod patches;
mod points;
mod pose;
mod posed;
mod problem;
pub mod rigid;
mod rounding;
mod rows;
mod skin;
mod slave_choice;
pub mod sliding;
mod spans;
mod stitch;
mod strength;
mod stretch;
mod surface;
mod triangles;
mod tributary;

pub(crate) use claims::sides_to_change;
pub use division::Division;
pub use law::Friction;
pub use layer::InterfaceStiffness;
pub(crate) use node_to_surface::faces_around;
pub(crate) use normals::still;
pub use obstacle::{Obstacle, Side};
pub use overlap::{Assembly, Moved, Overlap, OverlapKind, SMALL_MOTION, overlaps};
pub(crate) use pair::area_met_when_moved;
pub use pose::pose;
pub(crate) use pose::{bodies_of, centroid, pose_points};
pub(crate) use posed::PosedPoints;
pub use problem::{Bodies, Body, Contact, ContactProblem, Elastic, Labels, Pair, Supports};
pub use rows::{ContactRows, contact_rows};
pub use slave_choice::{Reason, Role, choose_slave, reverse_where_constrained};
pub(crate) use slave_choice::{face_size, may_change_sides};
pub use surface::{
    ALWAYS, Across, Coefficient, Cohesion, ContactSurface, CoulombLaw, Counterpart, InitialGap, Master, PairFacts,
    Period, SEARCH, SurfaceFacts, SurfaceFriction,
};
pub use triangles::{RawSurface, Triangles};
pub use tributary::{TributaryArea, tributary_areas};
