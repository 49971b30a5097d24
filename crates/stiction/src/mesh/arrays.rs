//! Numbers that a file gives at its nodes and cells.

use super::build::Former;
use super::face_table::FaceTable;

/// Numbers at nodes and cells, such as temperatures and coefficients of friction.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshArrays {
    /// Arrays on nodes.
    pub nodes: Vec<NodeArray>,
    /// Arrays on cells.
    pub cells: Vec<CellArray>,
    /// Arrays that are not one number at each place: the name and what it is instead, as in "it has 3 components".
    pub others: Vec<(String, String)>,
}

/// A number at each node; NaN where the file gives none.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeArray {
    /// Its name in the file.
    pub name: String,
    /// One value a node; not a number where the file has none.
    pub values: Vec<f64>,
}

/// A number for each cell, and for boundary faces that have one of their own.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CellArray {
    /// Its name in the file.
    pub name: String,
    /// One for each cell; NaN where the file gives none.
    pub values: Vec<f64>,
    /// Boundary faces, ascending, with the numbers that the file gives for surface elements on them. Before a mesh is
    /// built the first are indices into `RawMesh::array_faces`, in any order.
    pub faces: Vec<(u32, f64)>,
}

impl CellArray {
    /// The number of boundary face `face` of cell `cell`: its own where it has one, otherwise that of the cell.
    pub fn of_face(&self, face: u32, cell: u32) -> f64 {
        match self.faces.binary_search_by_key(&face, |own| own.0) {
            Ok(place) => self.faces[place].1,
            Err(_) => self.values.get(cell as usize).copied().unwrap_or(f64::NAN),
        }
    }
}

/// Finds the boundary faces that numbers belong to; `boundary` are the numbers of boundary faces in `table`, ascending.
pub(super) fn match_faces(
    arrays: &mut MeshArrays,
    corners: &[[u32; 4]],
    former: &Former,
    table: &FaceTable,
    boundary: &[u32],
) {
    if arrays.cells.iter().all(|array| array.faces.is_empty()) {
        return;
    }
    let place = |corners: &[u32; 4]| match *table.find(former.now(*corners)?) {
        [only] => boundary.binary_search(&only).ok().map(|place| place as u32),
        _ => None,
    };
    let places: Vec<Option<u32>> = corners.iter().map(place).collect();
    for array in &mut arrays.cells {
        let own = |&(face, value): &(u32, f64)| Some((places[face as usize]?, value));
        array.faces = array.faces.iter().filter_map(own).collect();
        array.faces.sort_by_key(|own| own.0);
        array.faces.dedup_by_key(|own| own.0);
    }
}
