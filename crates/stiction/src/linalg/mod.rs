//! Sparse storage, orderings, Cholesky factors and Krylov methods. Knows no mesh and no contact.

mod cholesky;
mod csr;
mod gmres;
mod kernels;
mod lanczos;
mod lu;
pub mod memory;
pub(crate) mod multigrid;
mod null_space;
mod ordering;
mod pages;
mod pattern;
mod selected;
mod small;
mod stop;
mod symbolic;
mod symmetric;
mod symmetric_csr;
mod trailing;
mod vectorised;

pub use cholesky::{Cholesky, Path};
pub use csr::Csr;
pub use gmres::{Krylov, gmres};
pub use lanczos::{Ritz, largest_eigenvalue};
pub use lu::Lu;
pub use null_space::null_space;
pub use ordering::{NodeGraph, nested_dissection, nested_dissection_until, ordering_bytes};
pub(crate) use ordering::{fronts, mean_distance};
pub use pages::in_huge_pages;
pub(crate) use pattern::{Pattern, piece};
pub use selected::inverse_forms;
pub use small::{SmallCholesky, SmallLu, symmetric_eigen};
pub use stop::{Stop, Watch};
pub use symbolic::{Plan, last, plan};
pub use symmetric::Symmetric;
pub use symmetric_csr::SymmetricCsr;
pub use trailing::Trailing;
pub(crate) use vectorised::vectorised;

/// Euclidean norm.
pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// Scalar product.
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

/// `y += a x`.
pub fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
}

/// Largest magnitude, zero for an empty vector.
pub fn max_abs(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, v| f64::max(m, v.abs()))
}
