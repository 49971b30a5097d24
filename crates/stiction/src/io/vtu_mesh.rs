//! A mesh with its groups and arrays as `.vtu`: what [`vtu_read`](super::vtu_read) reads back as the same mesh.
//!
//! Each group is an array of zeros and ones, on points for what it has of nodes, on cells for its cells and faces; faces of
//! groups are cells of their own behind the volume cells.

use std::collections::BTreeMap;
use std::path::Path;

use super::vtu::{Array, Grid, face_code, write};
use crate::Error;
use crate::mesh::Mesh;

/// Writes the mesh.
///
/// # Errors
/// If the file cannot be written, or a group has faces inside the body, which such a file cannot hold.
pub fn write_mesh(path: &Path, mesh: &Mesh) -> Result<(), Error> {
    let mut grid = Grid::from_mesh(mesh);
    let cells = mesh.cell_count();
    // Faces that groups or arrays name, each once.
    let mut faces: BTreeMap<u32, usize> = BTreeMap::new();
    let of_groups = mesh.groups.iter().flat_map(|group| &group.faces).copied();
    let of_arrays = mesh.arrays.cells.iter().flat_map(|array| &array.faces).map(|own| own.0);
    of_groups.chain(of_arrays).for_each(|face| {
        faces.insert(face, 0);
    });
    for (number, (&face, place)) in faces.iter_mut().enumerate() {
        let nodes = mesh.faces[face as usize].nodes();
        grid.push(face_code(nodes.len()), nodes);
        *place = cells + number;
    }
    let [mut on_points, mut on_cells]: [Vec<(&str, Vec<i32>)>; 2] = [Vec::new(), Vec::new()];
    for group in &mesh.groups {
        if !group.interior_faces.is_empty() {
            let what = format!("group \"{}\" has faces between two cells", group.name);
            return Err(Error::new(path.display().to_string(), what, "give the mesh as a Gmsh file"));
        }
        if !group.nodes.is_empty() {
            let mut mask = vec![0; mesh.nodes.len()];
            group.nodes.iter().for_each(|&node| mask[node as usize] = 1);
            on_points.push((&group.name, mask));
        }
        if !group.cells.is_empty() || !group.faces.is_empty() {
            let mut mask = vec![0; cells + faces.len()];
            group.cells.iter().for_each(|&cell| mask[cell as usize] = 1);
            group.faces.iter().for_each(|face| mask[faces[face]] = 1);
            on_cells.push((&group.name, mask));
        }
    }
    let numbers: Vec<(&str, Vec<f64>)> = mesh
        .arrays
        .cells
        .iter()
        .map(|array| {
            let mut values = array.values.clone();
            values.resize(cells + faces.len(), f64::NAN);
            array.faces.iter().for_each(|&(face, value)| values[faces[&face]] = value);
            (array.name.as_str(), values)
        })
        .collect();
    let points: Vec<Array> = on_points
        .iter()
        .map(|(name, mask)| Array::integer(name, mask))
        .chain(mesh.arrays.nodes.iter().map(|array| Array::scalar(&array.name, &array.values)))
        .collect();
    let cells: Vec<Array> = on_cells
        .iter()
        .map(|(name, mask)| Array::integer(name, mask))
        .chain(numbers.iter().map(|(name, values)| Array::scalar(name, values)))
        .collect();
    write(path, &grid, &points, &cells)
}
