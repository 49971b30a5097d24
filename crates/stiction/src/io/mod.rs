//! Case files, mesh readers and result writers: the only module that opens files.

mod labels;
mod number;
pub(crate) mod replace;

pub mod abaqus;
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
pub mod report;
pub mod step;
pub mod storage;
pub mod surface;
pub mod vtu;
pub mod vtu_read;

use std::io::Read as _;
use std::path::Path;

use crate::Error;
use crate::linalg::in_huge_pages;

/// The bytes of a mesh file.
fn mesh_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let read = || -> std::io::Result<Vec<u8>> {
        let mut file = std::fs::File::open(path)?;
        let length = file.metadata()?.len().try_into().unwrap_or(0);
        let mut bytes = Vec::new();
        // What does not fit is told as an error, not by an abort.
        bytes.try_reserve_exact(length)?;
        bytes = in_huge_pages(bytes);
        file.read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    read().map_err(|e| {
        let what = format!("the mesh file cannot be read ({e})");
        Error::new(path.display().to_string(), what, "check its path and permissions")
    })
}

/// An error unless coordinates can be multiplied by `scale`.
fn check_scale(scale: f64) -> Result<(), Error> {
    if scale.is_finite() && scale > 0.0 {
        return Ok(());
    }
    Err(Error::new("", format!("the scale {scale} is not a positive number"), "1e-3 turns mm into m"))
}
