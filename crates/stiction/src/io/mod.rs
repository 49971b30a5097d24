//! io.

mod replace;

pub mod npz;
pub mod plot;
pub mod vtu;
