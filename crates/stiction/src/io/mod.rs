//! Case files, mesh readers and result writers: the only module that opens files.

mod replace;

pub mod arrays;
pub mod case;
pub mod expression;
pub mod fclib;
pub mod fclib_write;
pub mod folder;
pub mod gmsh;
pub mod machine;
pub mod matrix_market;
pub mod npz;
pub mod plot;
pub mod problem;
pub mod step;
pub mod storage;
pub mod vtu;
