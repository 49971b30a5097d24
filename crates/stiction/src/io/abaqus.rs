//! Reader of Abaqus and CalculiX inputs (`.inp`): their mesh and its sets, nothing of the model.
//!
//! Formats: CalculiX CrunchiX User's Manual, chapter "Input deck format"; Abaqus Keywords Reference. `*NODE`,
//! `*ELEMENT`, `*NSET`, `*ELSET`, `*SURFACE`, `*INCLUDE` (and `INPUT=` of the first two) are read, in parts and
//! instances too. What else changes nodes or elements (`*NGEN`, `*SYSTEM`, `*NMAP` ..) is refused; all other keywords
//! are skipped and named in a note.
//!
//! Groups: an element set gives cells (solids), faces (shells, membranes and plane elements on the surface) or nodes
//! (lines); a surface gives boundary faces; a node set gives nodes, and faces too where whole boundary faces make it
//! up. Where kinds of sets share a name but not their nodes, as sets of Abaqus/CAE do, the surface keeps the name, or
//! else the node set; the others are called `NAME (nset)` and `NAME (elset)`. Sets that are `INTERNAL` give no groups.
//! Sets of a part that is placed several times are called `INSTANCE.NAME`.

mod assemble;
mod cards;
mod deck;
mod elements;
mod input;
mod keyword;
mod lines;
mod place;
mod read;
mod sets;
mod sweep;

pub(in crate::io) use cards::{Card, Row};
pub(in crate::io) use deck::Kind;
pub(in crate::io) use input::{Input, kind_name};
pub(in crate::io) use sets::{Found, Resolver};
pub(in crate::io) use sweep::{Family, NONE as NO_NODE};

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::mesh::{Mesh, MeshNotes};

/// Contents of the file an input names by `*INCLUDE`, or why there are none.
pub type Include<'a> = &'a dyn Fn(&str) -> Result<Vec<u8>, String>;

/// The mesh in the file at `path`, its coordinates multiplied by `scale` > 0. Included files are looked for beside it, and
/// have to lie in its folder or below, or in one of the folders `include` or below: a deck from elsewhere reads nothing else.
///
/// Errors name the file, the line or element, what is wrong there, and the remedy.
///
/// # Errors
/// If the file cannot be read, or holds what cannot be used: with file, line or element and the remedy.
pub fn read(path: &Path, scale: f64, include: &[PathBuf]) -> Result<(Mesh, MeshNotes), Error> {
    let name = path.display().to_string();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let include = |file: &str| included(folder, include, file);
    let mesh = || {
        super::check_scale(scale)?;
        let bytes = super::mesh_bytes(path)?;
        assemble::assemble(read::deck(Cow::Owned(bytes), &include, false)?, scale)
    };
    mesh().map_err(|e| if e.place == name { e } else { e.at(&name) })
}

/// The bytes of the file that a deck in `folder` calls `name`, or why they are not read.
fn included(folder: &Path, also: &[PathBuf], name: &str) -> Result<Vec<u8>, String> {
    let whole = folder.join(name).canonicalize().map_err(|e| e.to_string())?;
    let allowed = std::iter::once(folder).chain(also.iter().map(PathBuf::as_path));
    if !allowed.filter_map(|folder| folder.canonicalize().ok()).any(|folder| whole.starts_with(folder)) {
        return Err("it lies outside the folder of the input; name its folder with --include DIR".into());
    }
    super::regular_file(&whole).and_then(|()| std::fs::read(&whole)).map_err(|e| e.to_string())
}

/// The mesh in `bytes`, called `source_name` in messages, its coordinates multiplied by `scale` > 0.
///
/// Never panics, never follows more than a thousand includes, and never allocates more than a fixed multiple of the
/// length of all files together.
///
/// # Errors
/// If it holds what cannot be used: with line or element and the remedy.
pub fn parse(bytes: &[u8], source_name: &str, scale: f64, include: Include) -> Result<(Mesh, MeshNotes), Error> {
    let mesh = || {
        super::check_scale(scale)?;
        assemble::assemble(read::deck(Cow::Borrowed(bytes), include, false)?, scale)
    };
    mesh().map_err(|e| e.at(source_name))
}

#[cfg(test)]
mod tests;
