//! The mesh of a case.

use std::path::{Path, PathBuf};

use super::memory::{self, MemoryLimit, posing_fits};
use super::place;
use crate::Error;
use crate::io::case::{MeshSource, MeshSpec};
use crate::io::{abaqus, gmsh, vtu_read};
use crate::mesh::{Mesh, MeshNotes, block, join, place as move_mesh, ring};

/// The mesh in the file at `path`, its coordinates multiplied by `scale` > 0; the ending of the name gives the format:
/// Gmsh's `.msh`, `.inp` of Abaqus and CalculiX, or VTK's `.vtu`. An input includes files of its own folder and below, and
/// of the folders `include`.
///
/// # Errors
/// If the ending is none of these, or the file cannot be read or used.
pub fn read_mesh(path: &Path, scale: f64, include: &[PathBuf]) -> Result<(Mesh, MeshNotes), Error> {
    let ending = path.extension().map_or(String::new(), |e| e.to_string_lossy().to_lowercase());
    memory::reading_fits(path)?;
    match ending.as_str() {
        "msh" => gmsh::read(path, scale),
        "inp" => abaqus::read(path, scale, include),
        "vtu" => vtu_read::read(path, scale),
        _ => {
            let what = match ending.as_str() {
                "" => "the name of this mesh file has no ending that tells its format".to_string(),
                _ => format!("mesh files ending in .{ending} cannot be read in this version"),
            };
            let remedy = "convert it to Gmsh's .msh (2.2 or 4.1), an Abaqus or CalculiX .inp, or VTK's .vtu";
            Err(Error::new(path.display().to_string(), what, remedy))
        }
    }
}

/// Makes or reads the mesh that `spec` asks for; `limit` bounds what may be begun.
pub(crate) fn mesh(spec: &MeshSpec, limit: &MemoryLimit) -> Result<(Mesh, MeshNotes), Error> {
    let made = match &spec.source {
        MeshSource::Block(description) => {
            let fits = posing_fits(description.nodes(), memory::of_block(description.element), limit);
            fits.and_then(|()| block(description)).map(|mesh| (mesh, MeshNotes::default()))
        }
        MeshSource::Ring(description) => {
            let nodes: f64 = description.cells.iter().map(|&n| n as f64 + 1.0).product();
            let fits = posing_fits(nodes, memory::of_block(description.element), limit);
            fits.and_then(|()| ring(description)).map(|mesh| (mesh, MeshNotes::default()))
        }
        MeshSource::File { path, scale, include } => {
            let read = read_mesh(path, *scale, include);
            read.and_then(|read| posing_fits(read.0.nodes.len() as f64, memory::of_mesh(&read.0), limit).map(|()| read))
        }
        MeshSource::Given(given) => {
            let fits = posing_fits(given.0.nodes.len() as f64, memory::of_mesh(&given.0), limit);
            fits.map(|()| (**given).clone())
        }
        MeshSource::Parts(parts) => return joined(parts, spec, limit),
    };
    let (mut mesh, notes) = made.map_err(|error| place::at(&spec.spot, error))?;
    move_mesh(&mut mesh, spec.placing.turn.as_ref(), spec.placing.by);
    Ok((mesh, notes))
}

/// All parts in one mesh; what their readers noted is kept.
fn joined(parts: &[(String, MeshSpec)], spec: &MeshSpec, limit: &MemoryLimit) -> Result<(Mesh, MeshNotes), Error> {
    let (mut meshes, mut notes) = (Vec::new(), Vec::new());
    for (name, part) in parts {
        let (made, noted) = mesh(part, limit)?;
        meshes.push((name.clone(), made));
        notes.extend(noted.0);
    }
    let nodes: f64 = meshes.iter().map(|(_, mesh)| mesh.nodes.len() as f64).sum();
    let cells: f64 = meshes.iter().map(|(_, mesh)| mesh.cell_count() as f64).sum();
    let countable = 3.0 * nodes < f64::from(u32::MAX) && cells < f64::from(u32::MAX);
    if !countable {
        let what = format!("the parts have {:.0} million nodes together, more than can be numbered", nodes / 1e6);
        return Err(spec.spot.error(what, "use fewer cells"));
    }
    let each = meshes.iter().map(|(_, mesh)| memory::of_mesh(mesh)).fold(0.0, f64::max);
    posing_fits(nodes, each, limit).map_err(|error| place::at(&spec.spot, error))?;
    let mut joined = join(meshes);
    move_mesh(&mut joined, spec.placing.turn.as_ref(), spec.placing.by);
    Ok((joined, MeshNotes(notes)))
}
