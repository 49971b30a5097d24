//! io.

pub mod gmsh;
