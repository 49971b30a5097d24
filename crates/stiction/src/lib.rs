//! Static elastic contact with dry friction in three dimensions, without penalty parameters and with a certificate for
//! every answer.
//!
//! # The problem
//!
//! Elastic bodies with `n` unknown displacements `u` may touch at `m` contact points. `B = [N; T1; T2]` (`3m x n`) maps
//! displacements to the normal and the two tangential jumps of the points, `lambda = [lambda_n; lambda_t1; lambda_t2]`
//! (newton per point, length `3m`) are the forces that the body exerts on its counterpart:
//!
//! ```text
//! K u = f - Bᵀ lambda                                              equilibrium
//! N u <= gap,   lambda_n >= 0,   lambda_n (gap - N u) = 0          contact: compression is positive
//! |lambda_t| <= F lambda_n                                         Coulomb friction
//! s = T u - slip_reference,   s != 0  =>  lambda_t = F lambda_n s / |s|
//! ```
//! Friction acts along the slip `s` because `lambda` is the force on the counterpart. Given friction (Tresca) has a bound of
//! its own in place of `F lambda_n`. Any consistent system of units will do.
//!
//! # From matrices
//!
//! [`solve`] takes a [`ContactProblem`] and [`Settings`], chooses multigrid or a Cholesky factor, and returns a
//! [`Solution`] with its [`Certificate`]: measures of every line above, recomputed from the data by code that shares
//! nothing with the solvers.
//!
//! ```
//! use stiction::{ContactProblem, Csr, Friction, Settings, Status, SymmetricCsr, solve};
//! # fn main() -> Result<(), stiction::Error> {
//! // A node on three springs of 1000 N/mm, pressed on the floor below by 10 N and pulled along it by 4 N.
//! let k = Csr::from_triplets(3, 3, &[(0, 0, 1e3), (1, 1, 1e3), (2, 2, 1e3)]);
//! let jump = Csr::from_triplets(3, 3, &[(0, 2, -1.0), (1, 0, 1.0), (2, 1, 1.0)]); // -u_z, u_x, u_y
//! let load = vec![4.0, 0.0, -10.0];
//! let friction = vec![Friction::Coulomb { coefficient: 0.3 }];
//! let k = SymmetricCsr::from_full(&k, "K")?;
//! let problem = ContactProblem::from_matrices(k, load, jump, vec![0.0], friction);
//! let solution = solve(&problem, &Settings::default())?;
//! assert_eq!(solution.status, Status::Solved);
//! assert!((solution.lambda[0] - 10.0).abs() < 1e-6); // N
//! assert!((solution.lambda[1] - 3.0).abs() < 1e-6); // friction, 0.3 of it
//! assert!((solution.u[0] - 1e-3).abs() < 1e-9); // mm of slip: (4 - 3) N on 1000 N/mm
//! # Ok(())
//! # }
//! ```
//! The examples `row_of_springs` and `own_mesh` start from matrices as well.
//!
//! # From a case file
//!
//! [`io::case`] reads a case, [`run::prepare`] poses it, [`run::solve()`] or [`run::solve_steps`] solves it and
//! [`run::write()`] fills a folder with results; the command `stiction` is these four calls.
//!
//! # What is promised
//!
//! Within 0.1 three ways in stay as they are: [`solve`] with what it takes and returns, [`io::case`] with the functions of
//! [`run`] named above, and [`discrete`]. Case files, result files and exit codes stay too. The rest of what is public may
//! change.
//!
//! # Rooms
//!
//! In the order in which they may use one another (`ARCHITECTURE.md` draws the arrows): [`linalg`] and [`mesh`] know
//! nothing of the rest; [`fem`] turns a mesh into a stiffness matrix and a load; [`contact`] poses the
//! [`ContactProblem`], the first waist: no solver to its left, no mesh to its right; [`dual`] applies
//! `Q = B K⁻¹ Bᵀ`; [`qp`] has quadratic programs over simple sets; [`friction`] solves; [`discrete`] solves problems
//! given by `W`, `q` and coefficients; [`certificate`] judges; [`io`] alone opens files; [`run`] walks the whole way.

#![warn(missing_docs, unreachable_pub)]
#![warn(clippy::missing_errors_doc)]
// Matrices keep their capitals.
#![allow(non_snake_case)]

pub mod accuracy;
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
pub mod ranks;
pub mod run;
mod solve;

pub use certificate::{Certificate, certify};
pub use contact::{Contact, ContactProblem, Elastic, Friction, Labels};
pub use error::Error;
pub use friction::{PointState, Progress, Settings, Solution, SolverPath, Status};
pub use linalg::{Csr, SymmetricCsr};
pub use solve::{
    Attempt, Kept, Observer, Solutions, SolveEvent, Start, multigrid_is_faster, solve, solve_from_starts,
    solve_with_kept,
};
