//! Solvers for contact with friction on the dual operator: Newton's method on the law itself and what helps it when
//! it stalls. Knows no mesh.

pub mod algebraic;
mod coulomb;
mod law;
mod newton;
mod newton_system;
mod solve;

pub use coulomb::{CoulombFacts, coulomb_facts};
pub use law::{PointState, states};
pub use solve::{Counts, Phase, Progress, Settings, Solution, Status, solve};
