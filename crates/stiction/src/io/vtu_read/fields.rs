//! Fields of a file of results: what `io::vtu` wrote, read again.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use super::document::{Array, Document, Format, Section, document};
use super::types::{Role, role};
use crate::Error;
use crate::io::fits;
use crate::mesh::{CellKind, Mesh};

/// Named arrays of a grid as numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fields {
    /// Number of points.
    pub points: usize,
    /// Number of cells.
    pub cells: usize,
    /// Numbers of each array asked for, one after another; `None` for one that the file does not have.
    pub arrays: Vec<Option<Vec<f64>>>,
}

/// Which array: over points or over cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// One entry a point.
    Points,
    /// One entry a cell.
    Cells,
}

/// Polygons in space, such as the faces of contact surfaces.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Polygons {
    /// Places of the points.
    pub points: Vec<[f64; 3]>,
    /// Numbers of the points of each.
    pub faces: Vec<Vec<u32>>,
}

/// The mesh of volume cells in the file at `path`, and the arrays asked for. Points keep their numbers; cells, and what arrays say of
/// them, are sorted by kind.
///
/// # Errors
/// If the file cannot be read, or is no grid whose points all belong to cells.
pub fn read_body(path: &Path, wanted: &[(Over, &str)]) -> Result<(Mesh, Fields), Error> {
    let place = |e: Error| e.at(&path.display().to_string());
    let bytes = crate::io::mesh_bytes(path)?;
    let document = document(&bytes).map_err(place)?;
    let (mesh, _) = super::assemble::assemble(&document, 1.0).map_err(place)?;
    if mesh.nodes.len() != document.points {
        let what = "some of its points belong to no cell";
        return Err(place(Error::new("", what, "this is no result; solve the case again")));
    }
    let mut fields = fields(&document, wanted).map_err(place)?;
    sort_by_kind(&document, wanted, &mut fields).map_err(place)?;
    Ok((mesh, fields))
}

/// Puts arrays over cells in the order in which the mesh has the cells.
fn sort_by_kind(document: &Document, wanted: &[(Over, &str)], fields: &mut Fields) -> Result<(), Error> {
    let codes = document
        .integers(document.needed(Section::Cells, "types")?, document.cells, |n| u8::try_from(n).unwrap_or(u8::MAX))?;
    let kind = |code: u8| {
        let is = |kind: &CellKind| matches!(role(code, kind.nodes()), Role::Cell(found, _) if found == *kind);
        CellKind::ALL.iter().position(is)
    };
    let mut order: Vec<u32> = (0..codes.len() as u32).collect();
    order.sort_by_key(|&cell| kind(codes[cell as usize]));
    let of_cells = wanted.iter().zip(&mut fields.arrays).filter(|((over, _), _)| *over == Over::Cells);
    for values in of_cells.filter_map(|(_, array)| array.as_mut()) {
        let width = values.len() / codes.len().max(1);
        let sorted = order.iter().flat_map(|&cell| &values[cell as usize * width..][..width]);
        *values = sorted.copied().collect();
    }
    Ok(())
}

/// The arrays asked for alone.
///
/// # Errors
/// If the file cannot be read.
pub fn read_fields(path: &Path, wanted: &[(Over, &str)]) -> Result<Fields, Error> {
    let bytes = match with_holes(path, wanted) {
        Ok(Some(bytes)) => bytes,
        Ok(None) | Err(_) => crate::io::mesh_bytes(path)?,
    };
    let read = document(&bytes).and_then(|document| fields(&document, wanted));
    read.map_err(|e| e.at(&path.display().to_string()))
}

/// The bytes of the file with zeros in the place of arrays that nobody asked for: they are most of a result, and memory
/// that is not written costs nothing. `None` where the arrays do not stand behind the description, as those of `io::vtu` do.
fn with_holes(path: &Path, wanted: &[(Over, &str)]) -> std::io::Result<Option<Vec<u8>>> {
    /// Far more than the description of any result takes.
    const HEAD: usize = 1 << 16;
    let mut file = File::open(path)?;
    let length = usize::try_from(file.metadata()?.len()).unwrap_or(0);
    fits(length)?;
    let mut bytes = vec![0; length];
    let head = bytes.len().min(HEAD);
    file.read_exact(&mut bytes[..head])?;
    let Some(parts) = document(&bytes).ok().and_then(|document| parts(&document, bytes.len(), wanted)) else {
        return Ok(None);
    };
    for part in parts {
        let part = part.start.max(head)..part.end.max(head);
        file.seek(SeekFrom::Start(part.start as u64))?;
        file.read_exact(&mut bytes[part])?;
    }
    Ok(Some(bytes))
}

/// Where in a file of that many bytes the arrays stand.
fn parts(document: &Document, bytes: usize, wanted: &[(Over, &str)]) -> Option<Vec<Range<usize>>> {
    let (appended, _) = document.appended?;
    let place = |array: &Array| match array.format {
        Format::Appended(offset) => Some((bytes - appended.len()).saturating_add(offset as usize).min(bytes)),
        Format::Ascii(_) | Format::Binary(_) => None,
    };
    let starts = document.arrays.iter().map(place).collect::<Option<Vec<_>>>()?;
    let end = |start: usize| starts.iter().copied().filter(|&other| other > start).min().unwrap_or(bytes);
    let found = wanted.iter().filter_map(|&(over, name)| document.arrays.iter().position(|a| is(a, over, name)));
    Some(found.map(|i| starts[i]..end(starts[i])).collect())
}

fn is(array: &Array, over: Over, name: &str) -> bool {
    let section = if over == Over::Points { Section::PointData } else { Section::CellData };
    array.section == section && array.name == name
}

/// The cells of the file, whatever they are, as polygons of their points, and the arrays asked for.
///
/// # Errors
/// If the file cannot be read, or a cell names a point that there is not.
pub fn read_polygons(path: &Path, wanted: &[(Over, &str)]) -> Result<(Polygons, Fields), Error> {
    let bytes = crate::io::mesh_bytes(path)?;
    let read = document(&bytes).and_then(|document| Ok((polygons(&document)?, fields(&document, wanted)?)));
    read.map_err(|e| e.at(&path.display().to_string()))
}

fn fields(document: &Document, wanted: &[(Over, &str)]) -> Result<Fields, Error> {
    let array = |&(over, name): &(Over, &str)| {
        let count = if over == Over::Points { document.points } else { document.cells };
        let found = document.arrays.iter().find(|a| is(a, over, name));
        found.map(|a| document.floats(a, count.saturating_mul(a.components))).transpose()
    };
    let arrays = wanted.iter().map(array).collect::<Result<_, Error>>()?;
    Ok(Fields { points: document.points, cells: document.cells, arrays })
}

fn polygons(document: &Document) -> Result<Polygons, Error> {
    let damaged = || Error::new("", "a cell names points that there are not", super::xml::DAMAGED);
    let points = document.floats(document.needed(Section::Points, "Points")?, document.points.saturating_mul(3))?;
    let ends = document.integers(document.needed(Section::Cells, "offsets")?, document.cells, |n| n)?;
    let count = ends.last().map_or(Ok(0), |&n| usize::try_from(n)).map_err(|_| damaged())?;
    let nodes = document.integers(document.needed(Section::Cells, "connectivity")?, count, |n| n)?;
    let (mut faces, mut from) = (Vec::with_capacity(ends.len()), 0);
    for end in ends {
        let end = usize::try_from(end).map_err(|_| damaged())?;
        let own = nodes.get(from..end).ok_or_else(damaged)?.iter();
        let point = |&n: &i64| u32::try_from(n).ok().filter(|&n| (n as usize) < document.points);
        faces.push(own.map(point).collect::<Option<_>>().ok_or_else(damaged)?);
        from = end;
    }
    Ok(Polygons { points: points.as_chunks::<3>().0.to_vec(), faces })
}
