//! What a file says, before anybody believed it.

use rayon::prelude::*;

use super::geometry::cell_volume;
use super::{CellKind, MeshArrays};

/// Nodes, cells and groups as a reader found them; [`super::build`] checks them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMesh {
    /// Coordinates.
    pub nodes: Vec<[f64; 3]>,
    /// Numbers of the nodes in the file, for messages; empty if they are counted from 1.
    pub node_ids: Vec<u64>,
    /// Cells as the file lists them.
    pub cells: Vec<RawCells>,
    /// Groups as the file lists them.
    pub groups: Vec<RawGroup>,
    /// One value for each of `nodes` and for each cell.
    pub arrays: MeshArrays,
    /// Corners of the surface elements for which `arrays` have numbers, as in [`RawGroup::faces`].
    pub array_faces: Vec<[u32; 4]>,
}

/// Cells of one kind. The number of a cell runs through the blocks in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct RawCells {
    /// The kind of all of them.
    pub kind: CellKind,
    /// Indices into [`RawMesh::nodes`], `kind.nodes()` a cell.
    pub nodes: Vec<u32>,
    /// Numbers of the cells in the file, for messages; empty if they are counted from 1 through all blocks.
    pub ids: Vec<u64>,
}

/// A named set as the file lists it: any order, repetitions allowed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawGroup {
    /// Its name.
    pub name: String,
    /// Cell numbers.
    pub cells: Vec<u32>,
    /// Corners of faces, starting anywhere and turning either way; triangles end in `u32::MAX`.
    pub faces: Vec<[u32; 4]>,
    /// Indices into [`RawMesh::nodes`].
    pub nodes: Vec<u32>,
    /// Numbers of cells all of whose boundary faces belong to the group.
    pub skin: Vec<u32>,
    /// Whether boundary faces with all their nodes in `nodes` belong to the group, where such faces have all of them.
    pub faces_of_nodes: bool,
}

impl RawMesh {
    /// Puts the triangles of wedges that are inside out the other way round: VTK's manual has the first one turn one way,
    /// its shape functions and most programs the other, and there are meshes of both.
    pub fn turn_wedges(&mut self) {
        let nodes = &self.nodes;
        for block in self.cells.iter_mut().filter(|block| block.kind.linear() == CellKind::Wedge6) {
            let kind = block.kind;
            block.nodes.par_chunks_exact_mut(kind.nodes()).for_each(|cell| {
                if cell.iter().all(|&node| (node as usize) < nodes.len()) && cell_volume(nodes, kind, cell) < 0.0 {
                    cell[..6].rotate_left(3);
                    if let Some(middles) = cell.get_mut(6..12) {
                        middles.rotate_left(3);
                    }
                }
            });
        }
    }

    /// Number of cells of all kinds, counting a broken last one.
    pub(super) fn cell_count(&self) -> usize {
        self.cells.iter().map(|block| block.nodes.len().div_ceil(block.kind.nodes())).sum()
    }

    /// The number of node `i` in the file.
    pub(super) fn node_id(&self, i: usize) -> u64 {
        self.node_ids.get(i).copied().unwrap_or(i as u64 + 1)
    }

    /// The number of cell `i` in the file.
    pub(super) fn cell_id(&self, i: usize) -> u64 {
        let mut local = i;
        for block in &self.cells {
            let count = block.nodes.len().div_ceil(block.kind.nodes());
            if local < count {
                return block.ids.get(local).copied().unwrap_or(i as u64 + 1);
            }
            local -= count;
        }
        i as u64 + 1
    }

    /// Kind and nodes of cell `i`, of a broken last one those that are there.
    pub(super) fn cell(&self, i: usize) -> (CellKind, &[u32]) {
        let mut local = i;
        for block in &self.cells {
            let n = block.kind.nodes();
            if let Some(cell) = block.nodes.chunks(n).nth(local) {
                return (block.kind, cell);
            }
            local -= block.nodes.len().div_ceil(n);
        }
        panic!("cell {i} of {}", self.cell_count())
    }
}
