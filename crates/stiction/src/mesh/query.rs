//! Questions other modules ask of a mesh.

use std::ops::Range;

use rayon::prelude::*;

use super::geometry::{cell_volume, curved_area, vector_area};
use super::info::CellShape;
use super::quality::quality;
use super::v3::{V3, norm};
use super::{Bounds, CellKind, Cells, Group, Mesh};

impl Mesh {
    /// Kind and nodes of cell number `i < cell_count()`.
    pub fn cell(&self, i: usize) -> (CellKind, &[u32]) {
        let mut local = i;
        for block in &self.cells {
            if local < block.len() {
                return (block.kind, block.cell(local));
            }
            local -= block.len();
        }
        panic!("cell {i} of {}", self.cell_count())
    }

    /// Kind and nodes of all cells in the order of their numbers.
    pub fn cell_iter(&self) -> impl Iterator<Item = (CellKind, &[u32])> {
        self.cells.iter().flat_map(|block| block.nodes.chunks_exact(block.kind.nodes()).map(move |c| (block.kind, c)))
    }

    /// Number and nodes of the cells with numbers in `range`, ascending.
    pub(crate) fn cells_in(&self, range: Range<usize>) -> impl Iterator<Item = (usize, &[u32])> {
        let mut first = 0;
        self.cells.iter().flat_map(move |block| {
            let (n, offset) = (block.kind.nodes(), first);
            first += block.len();
            let [start, end] = [range.start, range.end].map(|cell| cell.clamp(offset, first));
            (start..end).zip(block.nodes[(start - offset) * n..(end - offset) * n].chunks_exact(n))
        })
    }

    /// Integral of the outward unit normal over boundary face number `face`; area.
    pub fn face_vector_area(&self, face: usize) -> [f64; 3] {
        vector_area(&self.nodes, self.faces[face].nodes())
    }

    /// Area of boundary face number `face`; of a warped bilinear quadrilateral the area it shows to its mean normal, of a
    /// curved quadratic face its own, integrated by the rule of loads.
    pub fn face_area(&self, face: usize) -> f64 {
        let nodes = self.faces[face].nodes();
        if nodes.len() <= 4 { norm(self.face_vector_area(face)) } else { curved_area(&self.nodes, nodes) }
    }

    /// Outward unit normal of boundary face number `face`, the mean one of a warped quadrilateral.
    pub fn face_normal(&self, face: usize) -> [f64; 3] {
        let area = self.face_vector_area(face);
        let length = norm(area);
        area.map(|c| c / length)
    }

    /// Volume of cell number `i`, positive.
    pub fn cell_volume(&self, i: usize) -> f64 {
        let (kind, nodes) = self.cell(i);
        cell_volume(&self.nodes, kind, nodes)
    }

    /// Volume and [`quality`] of all cells.
    pub(crate) fn cell_shapes(&self) -> Vec<CellShape> {
        self.of_cells(|x, kind, cell| CellShape { volume: cell_volume(x, kind, cell), quality: quality(x, kind, cell) })
    }

    /// What is to be known of each cell by its nodes and its kind, in the order of their numbers.
    pub(super) fn of_cells<T: Send>(&self, of_cell: fn(&[V3], CellKind, &[u32]) -> T) -> Vec<T> {
        let of_block = |block: &Cells| -> Vec<T> {
            let cells = block.nodes.par_chunks_exact(block.kind.nodes());
            cells.map(|cell| of_cell(&self.nodes, block.kind, cell)).collect()
        };
        self.cells.iter().flat_map(of_block).collect()
    }

    /// Volume of all cells.
    pub fn volume(&self) -> f64 {
        self.of_cells(cell_volume).iter().sum()
    }

    /// Lowest and highest coordinates; infinite and reversed for a mesh without nodes.
    pub fn bounding_box(&self) -> [[f64; 3]; 2] {
        let Bounds { low, high } = Bounds::around(self.nodes.iter().copied());
        [low, high]
    }

    /// Nodes of the boundary faces numbered `faces`, ascending, each once.
    pub fn face_nodes(&self, faces: &[u32]) -> Vec<u32> {
        ascending(faces.iter().flat_map(|&f| self.faces[f as usize].nodes()).copied())
    }

    /// Nodes of the cells numbered `cells`, ascending, each once.
    pub fn cell_nodes(&self, cells: &[u32]) -> Vec<u32> {
        let mut is_node = vec![false; if cells.is_empty() { 0 } else { self.nodes.len() }];
        cells.iter().flat_map(|&c| self.cell(c as usize).1).for_each(|&node| is_node[node as usize] = true);
        (0..).zip(is_node).filter(|(_, is)| *is).map(|(node, _)| node).collect()
    }

    /// Nodes of everything in a group: its cells, its faces on the boundary or not, and its nodes; ascending, each once.
    pub fn group_nodes(&self, group: &Group) -> Vec<u32> {
        let interior = group.interior_faces.iter().flatten().copied().filter(|&n| n != u32::MAX);
        let mut nodes = ascending(interior.chain(group.nodes.iter().copied()));
        nodes.extend(self.face_nodes(&group.faces));
        nodes.extend(self.cell_nodes(&group.cells));
        ascending(nodes)
    }
}

/// The numbers that stand beside `key` in ascending pairs.
pub(crate) fn beside(pairs: &[[u32; 2]], key: u32) -> impl Iterator<Item = u32> {
    let from = pairs.partition_point(|pair| pair[0] < key);
    pairs[from..].iter().take_while(move |pair| pair[0] == key).map(|pair| pair[1])
}

/// The numbers in ascending order, each once.
pub(crate) fn ascending<T: Ord>(numbers: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut numbers: Vec<T> = numbers.into_iter().collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}
