//! Static elastic contact with dry friction in three dimensions, with a certificate for every answer.
//!
//! The modules, in the order in which they may use one another (`ARCHITECTURE.md` draws the arrows):
//! [`linalg`] and [`mesh`] know nothing of the rest; [`fem`] turns a mesh into a stiffness matrix and a load;
//! [`contact`] poses a [`contact::ContactProblem`], the first waist: no solver to its left, no mesh to its right;
//! [`dual`] applies `Q = B K⁻¹ Bᵀ`; [`qp`] is the second waist and knows no friction; [`friction`] solves;
//! [`certificate`] judges, sharing no code with what it judges; [`io`] alone opens files; [`run`] walks the whole way.
//!
//! Signs and layout, everywhere: `m` contact points, `n` displacement unknowns, `B = [N; T1; T2]` in `R^{3m x n}`,
//! `lambda = [lambda_n; lambda_t1; lambda_t2]` in newton per contact point, `K u = f - Bᵀ lambda`, `N u <= gap`,
//! `lambda_n >= 0` in compression, and the friction `lambda_t` points along the slip `T u` (it is the force the
//! body exerts on its counterpart).

pub mod certificate;
pub mod contact;
pub mod discrete;
pub mod dual;
mod error;
pub mod fem;
pub mod friction;
pub mod io;
pub mod linalg;
pub mod mesh;
pub mod qp;
pub mod run;
mod solve;

pub use certificate::{Certificate, certify};
pub use contact::{Contact, ContactProblem, Elastic, Friction, Labels};
pub use error::Error;
pub use friction::{PointState, Progress, Settings, Solution, SolverPath, Status};
pub use linalg::{Csr, SymmetricCsr};
pub use solve::{Kept, Observer, SolveEvent, multigrid_is_faster, solve, solve_with_kept};
