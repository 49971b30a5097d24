//! Solvers for contact with friction. Knows no mesh.
//!
//! [`solve`] is Newton's method on the law itself and on the dual operator, with what helps it when it stalls;
//! [`solve_multigrid`] finds the displacements themselves by multigrid, for large problems. [`solve_with`] takes any
//! [`Method`], among them those of Haslinger, Kucera & Dostal (2004): squares around the discs of friction, Uzawa's
//! method on copies of the multipliers, and the fixed point on the bounds of friction. [`run_method`] is the same on
//! the dual energy alone ([`Quadratic`]), without displacements and certificate.

pub mod direct;
pub(crate) mod law;
pub mod multigrid;
pub mod reference;
mod solution;
mod strength;
pub(crate) mod system;
mod tangent;
mod uniqueness;

pub use direct::{coulomb_facts, rigid_equilibrium, solve};
pub use law::PointState;
pub(crate) use multigrid::{
    MOST_EQUATIONS, Part, SetUp, SoughtForce, Tightened, equations, is_over_many, multigrid_bytes, multigrid_fits,
    points_in,
};
pub use multigrid::{Multigrid, coulomb_facts_by_multigrid, solve_multigrid};
pub use reference::{
    Answer, CopiesAtOnce, Coupling, Given, Method, MethodCounts, MethodReport, MethodSettings, MethodStep,
    Minimization, Penalty, Quadratic, Splitting, Start, Sweeps, fixed_point_defect, run_method, solve_with,
};
pub use solution::{Counts, End, Phase, Progress, Settings, Solution, SolverPath, Status};
pub use tangent::{free_motions, tied_rows};
pub use uniqueness::CoulombFacts;
