//! Reader of Gmsh meshes: MSH 2.2 and 4.1, ASCII and binary of either byte order.
//!
//! Format: <https://gmsh.info/doc/texinfo/gmsh.html#Gmsh-file-formats>. Physical groups become named groups: volumes
//! give cells, surfaces faces, curves and points nodes. A group without a name is called by its number. Volumes in
//! no physical group are cells all the same. `$NodeData` and `$ElementData` of one component are arrays of the mesh; of
//! several time steps the last counts.

mod assemble;
mod complete;
mod contents;
mod cursor;
mod data;
mod foreign;
mod ranges;
mod tags;
mod types;
mod version2;
mod version4;

use std::borrow::Cow;
use std::path::Path;

use crate::Error;
use crate::mesh::{Mesh, MeshNotes};
use contents::Contents;
use cursor::{Cursor, Encoding};
pub(super) use ranges::{Blocks, blocks};

/// The mesh in the file at `path`, its coordinates multiplied by `scale` > 0.
///
/// Errors name the file, the line (ASCII) or byte (binary) or element, what is wrong there, and the remedy.
///
/// # Errors
/// If the file cannot be read, or holds what cannot be used: with line, byte or element and the remedy.
pub fn read(path: &Path, scale: f64) -> Result<(Mesh, MeshNotes), Error> {
    let name = path.display().to_string();
    mesh(Cow::Owned(super::mesh_bytes(path)?), &name, scale)
}

/// The mesh in `bytes`, called `source_name` in messages, its coordinates multiplied by `scale` > 0.
///
/// Never panics and never allocates more than a fixed multiple of the length of `bytes`.
///
/// # Errors
/// If it holds what cannot be used: with line, byte or element and the remedy.
pub fn parse(bytes: &[u8], source_name: &str, scale: f64) -> Result<(Mesh, MeshNotes), Error> {
    mesh(Cow::Borrowed(bytes), source_name, scale)
}

fn mesh(bytes: Cow<[u8]>, source_name: &str, scale: f64) -> Result<(Mesh, MeshNotes), Error> {
    let mesh = || {
        super::check_scale(scale)?;
        foreign::refuse(&bytes, source_name)?;
        assemble::assemble(sections(bytes)?, scale)
    };
    mesh().map_err(|e| e.at(source_name))
}

/// What is known of a file between its sections.
#[derive(Default)]
struct Read {
    contents: Contents,
    version: Option<u8>,
    encoding: Encoding,
    /// Names of the sections that come once.
    seen: Vec<&'static str>,
}

/// Sections that a file has once, or has to have.
const ONCE: [&str; 4] = ["$MeshFormat", "$Nodes", "$Elements", "$Entities"];

/// Reads all sections in whatever order they come. Bytes of our own are given back section by section: text takes twice the
/// memory of what it says.
fn sections(mut file: Cow<[u8]>) -> Result<Contents, Error> {
    let mut read = Read::default();
    read.contents.bytes = file.len();
    let (mut from, mut before) = (0, [0; 2]);
    loop {
        let mut at = Cursor::new(&file[from..]);
        (at.before, at.encoding) = (before, read.encoding);
        if !at.skip_space() {
            let missing = ONCE[..3].iter().find(|needed| !read.seen.contains(needed));
            return match missing {
                Some(needed) => Err(at.fail(format!("there is no section {needed}"), cursor::DAMAGED)),
                None => Ok(read.contents),
            };
        }
        section(&mut at, &mut read)?;
        let done = from + at.pos;
        before = [before[0] + done - from, before[1] + super::newlines(&file[from..done])];
        from = done;
        if let Cow::Owned(bytes) = &mut file
            && from > bytes.len() / 8
        {
            bytes.drain(..from);
            bytes.shrink_to_fit();
            from = 0;
        }
    }
}

/// Reads the next section.
fn section(at: &mut Cursor, read: &mut Read) -> Result<(), Error> {
    let start = at.pos;
    let name = at.line();
    at.section = std::str::from_utf8(name).unwrap_or("");
    if name.first() != Some(&b'$') || at.section.is_empty() {
        return Err(at.fail_at(start, "a section was expected to begin here, with $ and its name", cursor::DAMAGED));
    }
    if let Some(once) = ONCE.iter().find(|once| **once == at.section) {
        if read.seen.contains(once) {
            return Err(at.fail_at(start, format!("a second section {}", at.section), cursor::DAMAGED));
        }
        read.seen.push(once);
    }
    let Read { contents, version, .. } = read;
    match (at.section, *version) {
        ("$MeshFormat", _) => {
            *version = Some(mesh_format(at)?);
            read.encoding = at.encoding;
        }
        ("$PhysicalNames", _) => physical_names(at, contents)?,
        ("$Nodes", Some(2)) => version2::nodes(at, contents)?,
        ("$Nodes", Some(_)) => version4::nodes(at, contents)?,
        ("$Elements", Some(2)) => version2::elements(at, contents)?,
        ("$Elements", Some(_)) => version4::elements(at, contents)?,
        ("$Entities", Some(4)) => version4::entities(at, contents)?,
        ("$NodeData" | "$ElementData", Some(_)) => data::read(at, contents)?,
        ("$ElementNodeData", Some(_)) => return data::refuse(at, contents),
        ("$Nodes" | "$Elements" | "$Entities", None) => {
            return Err(at.fail_at(start, format!("{} comes before $MeshFormat", at.section), cursor::DAMAGED));
        }
        ("$PartitionedEntities", _) => {
            return Err(at.fail_at(start, "the mesh is partitioned", "save it without partitions"));
        }
        ("$ParametricNodes", _) => {
            let remedy = "save it without them (Mesh.SaveParametric = 0) or as MSH 4.1";
            return Err(at.fail_at(start, "the nodes have parametric coordinates", remedy));
        }
        _ => return at.skip_section(), // unknown sections may come as often as they like
    }
    at.expect_end()
}

/// `version file-type data-size`, and in binary files a 1 that shows the byte order. Gives 2 or 4.
fn mesh_format(at: &mut Cursor) -> Result<u8, Error> {
    let start = at.pos;
    let line = String::from_utf8_lossy(at.line()).into_owned();
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let [version, file_type, data_size, ..] = words[..] else {
        return Err(at.fail_at(start, format!("\"{line}\" is not version, file type and data size"), cursor::DAMAGED));
    };
    let major = match version.parse::<f64>() {
        Ok(2.2) => 2,
        Ok(4.1) => 4,
        _ => {
            let remedy = "save it as MSH 4.1 or 2.2, with gmsh -format msh41 or Mesh.MshFileVersion = 4.1";
            return Err(at.fail_at(start, format!("MSH version {version} cannot be read"), remedy));
        }
    };
    if file_type == "0" {
        return Ok(major);
    }
    let size = match data_size {
        "4" if major == 4 => 4,
        "8" => 8,
        _ => {
            return Err(at.fail_at(start, format!("a data size of {data_size} bytes cannot be read"), "save it again"));
        }
    };
    let start = at.pos;
    let big = match at.take(4)? {
        [1, 0, 0, 0] => false,
        [0, 0, 0, 1] => true,
        _ => return Err(at.fail_at(start, "the number that shows the byte order is not 1", cursor::DAMAGED)),
    };
    at.encoding = Encoding::Binary { big, size };
    Ok(major)
}

/// A count, and lines `dimension tag "name"`; text also in binary files.
fn physical_names(at: &mut Cursor, contents: &mut Contents) -> Result<(), Error> {
    let count = at.text_integer("the number of names")?;
    for _ in 0..count {
        let dimension = at.text_integer("a dimension")?;
        let tag = at.text_integer("the number of a physical group")?;
        let start = at.pos;
        let line = String::from_utf8_lossy(at.line());
        let line = line.trim();
        let name = line.strip_prefix('"').and_then(|l| l.strip_suffix('"')).unwrap_or(line);
        if name.is_empty() || !(0..=3).contains(&dimension) {
            return Err(at.fail_at(
                start,
                "a physical name is a dimension from 0 to 3, a number and a name",
                cursor::DAMAGED,
            ));
        }
        contents.names.push((dimension as u8, tag, name.to_string()));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
#[cfg(test)]
#[path = "gmsh/written_tests.rs"]
pub(crate) mod written;
