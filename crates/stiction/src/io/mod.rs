//! Case files, mesh readers and result writers: the only module that opens files.
//!
//! A reader of meshes has `parse`, which takes bytes and opens no file (what a file includes is asked of a closure), and
//! turns them into a [`RawMesh`](crate::mesh::RawMesh); [`mesh::build`](crate::mesh::build) checks it. A table of element
//! types says in one place what is computed with and what is refused. What a few bytes can promise (counts, ranges,
//! nested sets, instances, compressed data) is bounded before memory is taken, and text is given back as it is read:
//! reading takes at most three times the memory of the mesh.

pub(crate) mod checksum;
mod contents;
mod labels;
#[cfg(any(feature = "plots", feature = "report"))]
pub(crate) mod look;
mod number;
pub(crate) mod replace;

pub mod abaqus;
pub mod arrays;
pub mod bound;
pub mod case;
pub mod deck;
pub mod expression;
#[cfg(feature = "fclib")]
pub mod fclib;
#[cfg(feature = "fclib")]
pub mod fclib_write;
pub mod folder;
pub mod frd;
pub mod gmsh;
pub mod lock;
pub mod machine;
pub mod matrix_market;
pub mod npz;
pub mod pieces;
#[cfg(feature = "plots")]
pub mod plot;
pub mod problem;
pub mod pvtu;
pub mod ranges;
pub mod step;
pub mod storage;
pub mod surface;
pub mod text;
pub(crate) mod units;
pub mod vtu;
pub mod vtu_mesh;
pub mod vtu_read;

pub use contents::Contents;

use std::collections::TryReserveError;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

use crate::Error;
use crate::linalg::in_huge_pages;

/// The bytes of a mesh file.
fn mesh_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let read = || -> std::io::Result<Vec<u8>> {
        regular_file(path)?;
        let mut file = std::fs::File::open(path)?;
        let length = file.metadata()?.len().try_into().unwrap_or(0);
        fits(length)?;
        let mut bytes = in_huge_pages(vec![0; length]);
        if read_by_threads(&file, &mut bytes) {
            file.seek(SeekFrom::Start(length as u64))?;
        } else {
            bytes.clear();
        }
        // All of it, or what it has grown by.
        file.read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    read().map_err(|e| {
        let what = format!("the mesh file cannot be read ({e})");
        Error::new(path.display().to_string(), what, "check its path and permissions")
    })
}

/// The bytes of a file of matrices or arrays.
fn file_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    regular_file(path).and_then(|()| std::fs::read(path)).map_err(|error| unreadable(path, &error))
}

fn unreadable(path: &Path, error: &std::io::Error) -> Error {
    let what = format!("cannot read this file ({error})");
    Error::new(path.display().to_string(), what, "check its name and permissions")
}

/// A pipe may wait for ever and a device may never end: neither is opened.
fn regular_file(path: &Path) -> std::io::Result<()> {
    if std::fs::metadata(path)?.is_file() { Ok(()) } else { Err(std::io::Error::other("it is no regular file")) }
}

/// An error instead of an abort where so many bytes cannot be had.
fn fits(bytes: usize) -> Result<(), TryReserveError> {
    let mut room = Vec::<u8>::new();
    // Room that nothing uses would not be asked for.
    std::hint::black_box(&mut room).try_reserve_exact(bytes)
}

/// Fills `bytes` from the start of the file; false where that must be left to one reader.
#[cfg(unix)]
fn read_by_threads(file: &std::fs::File, bytes: &mut [u8]) -> bool {
    use rayon::prelude::*;
    use std::os::unix::fs::FileExt as _;
    /// Read at a time.
    const PART: usize = 4 << 20;
    let part = |(k, part): (usize, &mut [u8])| file.read_exact_at(part, (k * PART) as u64);
    // What is no file of a known length, such as a pipe, has the length zero or cannot be read at a place.
    !bytes.is_empty() && bytes.par_chunks_mut(PART).enumerate().try_for_each(part).is_ok()
}

#[cfg(not(unix))]
fn read_by_threads(_: &std::fs::File, _: &mut [u8]) -> bool {
    false
}

/// Ends of lines.
fn newlines(bytes: &[u8]) -> usize {
    memchr::memchr_iter(b'\n', bytes).count()
}

/// An error unless coordinates can be multiplied by `scale`.
fn check_scale(scale: f64) -> Result<(), Error> {
    if scale.is_finite() && scale > 0.0 {
        return Ok(());
    }
    Err(Error::new("", format!("the scale {scale} is not a positive number"), "1e-3 turns mm into m"))
}
