//! Mesh files of which any part can be read by itself: binary Gmsh 4.1, and VTU with raw appended data, compressed or not.
//!
//! What else there is in a file, and whatever is wrong with it, is a matter of the readers of whole files, which have the words for it.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::ops::Range;
use std::path::Path;

use super::{check_scale, fits, gmsh, regular_file, vtu_read};
use crate::Error;
use crate::mesh::CellKind;

/// A mesh file whose nodes and elements can be read from any one to any other.
pub struct MeshRanges {
    file: Stored,
    scale: f64,
    of: Format,
}

enum Format {
    Gmsh(gmsh::Blocks),
    Vtu(vtu_read::Layout),
}

/// Some elements of a file, in its order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Elements {
    /// Sets of groups, by their places in [`MeshRanges::groups`], ascending: an element that is said to be of set `k` is in those of
    /// `sets[k]`.
    pub sets: Vec<Vec<u32>>,
    /// The volume cells, one block for each of [`CellKind::ALL`].
    pub cells: Vec<RangeCells>,
    /// Corners of triangles, which end in `u64::MAX`, and quadrilaterals by the numbers of the file, with their sets.
    pub faces: Vec<([u64; 4], u32)>,
    /// Nodes of lines and points by the numbers of the file, with their sets.
    pub nodes: Vec<(u64, u32)>,
}

/// Cells of one kind.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RangeCells {
    /// The numbers in the file of the nodes of each, in the order of its kind.
    pub nodes: Vec<u64>,
    /// The set of each cell.
    pub sets: Vec<u32>,
}

impl Elements {
    pub(super) fn with(sets: Vec<Vec<u32>>) -> Elements {
        let cells = CellKind::ALL.map(|_| RangeCells::default()).into();
        Elements { sets, cells, ..Elements::default() }
    }

    /// The block of a kind.
    pub(super) fn of_kind(&mut self, kind: CellKind) -> &mut RangeCells {
        let which = CellKind::ALL.iter().position(|other| *other == kind).unwrap_or(0);
        &mut self.cells[which]
    }
}

impl MeshRanges {
    /// The file at `path`, whose coordinates are multiplied by `scale` > 0; none where it has to be read as a whole: it is text or of
    /// another version, or what is in it cannot be said of a part.
    ///
    /// # Errors
    /// If it cannot be read, or is damaged.
    pub fn open(path: &Path, scale: f64) -> Result<Option<MeshRanges>, Error> {
        check_scale(scale)?;
        let file = Stored::open(path).map_err(|error| super::unreadable(path, &error))?;
        let ending = path.extension().map_or(String::new(), |e| e.to_string_lossy().to_lowercase());
        let of = match ending.as_str() {
            "msh" => gmsh::blocks(&file).map(|blocks| blocks.map(Format::Gmsh)),
            "vtu" => vtu_read::layout(&file).map(|layout| layout.map(Format::Vtu)),
            _ => Ok(None),
        };
        let of = of.map_err(|error| error.at(&path.display().to_string()))?;
        Ok(of.map(|of| MeshRanges { file, scale, of }))
    }

    /// The names of all groups.
    pub fn groups(&self) -> &[String] {
        match &self.of {
            Format::Gmsh(blocks) => &blocks.groups,
            Format::Vtu(layout) => &layout.groups,
        }
    }

    /// Nodes and elements that the file says it has.
    pub fn sizes(&self) -> [u64; 2] {
        match &self.of {
            Format::Gmsh(blocks) => blocks.sizes(),
            Format::Vtu(layout) => layout.sizes(),
        }
    }

    /// Whether wedges that are inside out are to be turned, as by [`RawMesh::turn_wedges`](crate::mesh::RawMesh::turn_wedges).
    pub fn turns_wedges(&self) -> bool {
        matches!(self.of, Format::Vtu(_))
    }

    /// The numbers in the file of the nodes in `range`, and their places; length. Those of files that give no numbers count from 1.
    ///
    /// # Errors
    /// If the range is not in the file, or what is there cannot be read.
    pub fn nodes(&self, range: Range<u64>) -> Result<(Vec<u64>, Vec<[f64; 3]>), Error> {
        let (numbers, mut places) = match &self.of {
            Format::Gmsh(blocks) => blocks.nodes(&self.file, range)?,
            Format::Vtu(layout) => layout.nodes(&self.file, range)?,
        };
        places.iter_mut().flatten().for_each(|x| *x *= self.scale);
        Ok((numbers, places))
    }

    /// The elements in `range`.
    ///
    /// # Errors
    /// If the range is not in the file, or what is there cannot be read or used.
    pub fn elements(&self, range: Range<u64>) -> Result<Elements, Error> {
        match &self.of {
            Format::Gmsh(blocks) => blocks.elements(&self.file, range),
            Format::Vtu(layout) => layout.elements(&self.file, range),
        }
    }
}

/// A file that is read at any place.
pub(super) struct Stored {
    file: File,
    /// Bytes.
    pub length: u64,
}

/// Bytes of what heads a file, or stands between its large parts, that are looked at: what is longer is read with the whole.
const MOST_HEAD: u64 = 1 << 24;
/// Those that are looked at first.
const FIRST_HEAD: u64 = 1 << 14;

impl Stored {
    pub(super) fn open(path: &Path) -> std::io::Result<Stored> {
        regular_file(path)?;
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Ok(Stored { file, length })
    }

    /// So many bytes from a place.
    pub(super) fn bytes(&self, at: u64, count: u64) -> Result<Vec<u8>, Error> {
        let ends =
            || Error::new(format!("byte {at}"), format!("the file ends where {count} bytes should follow"), DAMAGED);
        let size = usize::try_from(count).map_err(|_| ends())?;
        if at.checked_add(count).is_none_or(|end| end > self.length) {
            return Err(ends());
        }
        let read = || -> std::io::Result<Vec<u8>> {
            fits(size)?;
            let mut bytes = vec![0; size];
            (&self.file).seek(SeekFrom::Start(at))?;
            (&self.file).read_exact(&mut bytes)?;
            Ok(bytes)
        };
        read().map_err(|error| Error::new(format!("byte {at}"), format!("cannot read the file ({error})"), DAMAGED))
    }

    /// What `parse` makes of the bytes from a place on, of which it is given more and more until it makes something of them.
    pub(super) fn head<T>(&self, at: u64, mut parse: impl FnMut(Vec<u8>) -> Result<T, Error>) -> Result<T, Error> {
        let (left, mut size) = (self.length.saturating_sub(at), FIRST_HEAD);
        loop {
            let found = parse(self.bytes(at, size.min(left))?);
            if found.is_ok() || size >= left.min(MOST_HEAD) {
                return found;
            }
            size *= 4;
        }
    }
}

/// The remedy for whatever a writer would not have written.
const DAMAGED: &str = "the file is damaged or incomplete; write it again";

#[cfg(test)]
#[path = "ranges_tests.rs"]
mod tests;
