//! Sparse storage, orderings, Cholesky factors and Krylov methods. Knows no mesh and no contact.

mod csr;

pub use csr::Csr;
