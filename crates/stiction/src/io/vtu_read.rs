//! Reader of VTK XML unstructured grids (`.vtu`).
//!
//! Format: "VTK XML file formats", <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>. Text,
//! base64 and raw appended data, plain or compressed with zlib, of either byte order.
//!
//! Groups come from arrays of whole numbers with one component. An array `part` on cells gives a group `part-3` of all
//! its cells with the value 3: volumes as cells, triangles and quadrilaterals as faces, lines and vertices as nodes.
//! Where all values are 0 or 1 the group of the ones is called `part`. An array on points gives nodes in the same way
//! (and faces, where whole boundary faces make up a group), without a group of zeros where all values are 0 or 1.
//! Arrays of numbers that are all different or of more than a thousand values are no groups, nor are VTK's own.

mod arrays;
mod assemble;
mod document;
mod fields;
mod ranges;
mod stream;
mod types;
mod xml;

use std::path::Path;

pub(super) use ranges::{Layout, layout};

pub use fields::{Fields, Over, Polygons, read_body, read_fields, read_polygons};

use crate::Error;
use crate::mesh::{Mesh, MeshNotes};

/// The mesh in the file at `path`, its coordinates multiplied by `scale` > 0.
///
/// Errors name the file, the line or array, what is wrong there, and the remedy.
///
/// # Errors
/// If the file cannot be read, or holds what cannot be used: with line or array and the remedy.
pub fn read(path: &Path, scale: f64) -> Result<(Mesh, MeshNotes), Error> {
    parse(&super::mesh_bytes(path)?, &path.display().to_string(), scale)
}

/// The mesh in `bytes`, called `source_name` in messages, its coordinates multiplied by `scale` > 0.
///
/// Never panics, and never allocates more than ten times the length of `bytes` and 64 MB: what zlib promises beyond that is
/// refused before it is decompressed.
///
/// # Errors
/// If it holds what cannot be used: with line or array and the remedy.
pub fn parse(bytes: &[u8], source_name: &str, scale: f64) -> Result<(Mesh, MeshNotes), Error> {
    let mesh = || {
        super::check_scale(scale)?;
        assemble::assemble(&document::document(bytes)?, scale)
    };
    mesh().map_err(|e| e.at(source_name))
}

#[cfg(test)]
mod tests;
