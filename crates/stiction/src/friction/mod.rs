//! Solvers for contact with friction. Knows no mesh.
//!
//! [`solve`] is Newton's method on the law itself and on the dual operator, with what helps it when it stalls;
//! [`solve_primal`] finds the displacements themselves by multigrid, for large problems. [`solve_with`] takes any
//! [`Method`], among them those of Haslinger, Kucera & Dostal (2004): squares around the discs of friction, Uzawa's
//! method on copies of the multipliers, and the fixed point on the bounds of friction. [`run_method`] is the same on
//! the dual energy alone ([`Quadratic`]), without displacements and certificate.

pub mod algebraic;
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
mod primal;
mod proximal;
mod quadratic;
mod rigid_start;
mod run_method;
mod solution;
mod solve;
mod solve_with;
mod squares;

pub use coulomb::{CoulombFacts, coulomb_facts};
pub use law::{PointState, states};
pub use method::{
    CopiesAtOnce, Given, Method, MethodCounts, MethodEnd, MethodReport, MethodSettings, MethodStep, Minimization,
    ObserveMethod, Penalty, Splitting, Start, Sweeps,
};
pub use primal::{Primal, descend_primal, solve_primal};
pub use quadratic::Quadratic;
pub use rigid_start::rigid_rest;
pub use run_method::{fixed_point_defect, run_method};
pub use solution::{Counts, Phase, Progress, Settings, Solution, Status};
pub use solve::solve;
pub use solve_with::{Answer, solve_with};
pub use squares::{Coupling, polygon};
