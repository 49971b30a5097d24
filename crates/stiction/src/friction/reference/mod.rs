//! The methods of Haslinger, Kucera & Dostal, JCAM 164-165 (2004) 387-408, and their kin: squares around the discs of
//! friction, Uzawa's method on copies of the multipliers, the discs themselves, and the fixed point on the bounds of
//! friction.

mod discs;
mod faces;
mod fixed_point;
mod given;
mod lagrangian;
mod method;
mod minimize;
mod quadratic;
mod run_method;
mod solve_with;
mod squares;

pub use method::{
    CopiesAtOnce, Given, Method, MethodCounts, MethodReport, MethodSettings, MethodStep, Minimization, Penalty,
    Splitting, Start, Sweeps,
};
pub use quadratic::Quadratic;
pub use run_method::{fixed_point_defect, run_method};
pub use solve_with::{Answer, solve_with};
pub use squares::Coupling;
