//! The direct path: Newton's method on the law of friction over the dual operator, with its fallbacks.

mod coulomb;
mod dual_system;
mod proximal;
pub(super) mod rigid_start;
mod shared_nodes;
mod solve;
mod starts;

pub use coulomb::coulomb_facts;
pub use rigid_start::rigid_equilibrium;
pub use solve::solve;
pub(super) use solve::{make_admissible, path_of};
