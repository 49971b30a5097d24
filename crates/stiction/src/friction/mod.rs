//! Solvers for contact with friction on the dual operator: Newton's method on the law itself and what helps it when
//! it stalls. Knows no mesh.

mod coulomb;
mod discs;
mod faces;
mod fixed_point;
mod given;
mod lagrangian;
mod law;
mod method;
mod minimize;
mod newton;
mod newton_system;
mod quadratic;
mod run_method;
mod solve;
mod squares;

pub use coulomb::{CoulombFacts, coulomb_facts};
pub use law::{PointState, states};
pub use method::{
    CopiesAtOnce, Given, Method, MethodCounts, MethodEnd, MethodReport, MethodSettings, MethodStep, Minimization,
    ObserveMethod, Penalty, Splitting, Start, Sweeps,
};
pub use quadratic::Quadratic;
pub use run_method::{fixed_point_defect, run_method};
pub use solve::{Counts, Phase, Progress, Settings, Solution, Status, solve};
pub use squares::{Coupling, polygon};
