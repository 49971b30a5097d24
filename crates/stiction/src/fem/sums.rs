//! The rows of the stiffness matrix, summed over the cells.

use std::borrow::Borrow;

use super::Solid;
use super::elements::{Element, Hex8, Hex20, Law, Tet4, Tet10, folded};
use super::incidence::{Incidence, NodeRange};
use super::integrated::Shapes;
use super::solid::CellList;
use crate::Error;
use crate::mesh::CellKind;
use crate::mesh::geometry::corners;
use crate::mesh::v3::V3;

/// The 3 x 3 blocks of one range of nodes after the other, for one thread. Cells are added in ascending order.
pub(super) struct Sums<'a> {
    solid: &'a Solid<'a>,
    /// Of each material.
    laws: &'a [Law<'a>],
    cells: &'a CellList<'a>,
    incidence: &'a Incidence,
    /// Rows of linear tetrahedra are integrated faster than added to those of a range: each is summed when it is asked for.
    only_tets: bool,
    shapes: Shapes,
    /// Rows of the range in the order of its neighbours, or the row asked for.
    blocks: Vec<[V3; 3]>,
    /// For each node its place among the neighbours of the node asked for.
    place: Vec<u32>,
}

impl<'a> Sums<'a> {
    pub fn new(solid: &'a Solid<'a>, laws: &'a [Law<'a>], cells: &'a CellList<'a>, incidence: &'a Incidence) -> Self {
        let only_tets = solid.mesh.cells.iter().all(|block| block.kind == CellKind::Tet4);
        let place = vec![0; if only_tets { solid.mesh.nodes.len() } else { 0 }];
        Sums { solid, laws, cells, incidence, only_tets, shapes: Shapes::new(), blocks: Vec::new(), place }
    }

    /// Makes the rows of `range` ready. An error for a folded cell.
    pub fn start(&mut self, range: &NodeRange) -> Result<(), Error> {
        if !self.only_tets {
            self.clear(range.blocks());
            range
                .cells(self.incidence, self.cells)
                .into_iter()
                .try_for_each(|cell| self.add_cell(cell as usize, range))?;
        }
        Ok(())
    }

    /// The blocks of the row of node `i` of the range that was started, in the order of its neighbours.
    pub fn row(&mut self, i: usize, range: &NodeRange) -> Result<&mut [[V3; 3]], Error> {
        if self.only_tets {
            self.sum_tets(i as u32, range.neighbours(i))?;
            return Ok(&mut self.blocks);
        }
        Ok(&mut self.blocks[range.row(i)])
    }

    fn clear(&mut self, blocks: usize) {
        self.blocks.clear();
        self.blocks.resize(blocks, [[0.0; 3]; 3]);
    }

    fn sum_tets(&mut self, node: u32, neighbours: &[u32]) -> Result<(), Error> {
        self.clear(neighbours.len());
        (0..).zip(neighbours).for_each(|(k, &j)| self.place[j as usize] = k);
        for &cell in self.incidence.at(node as usize) {
            let (kind, nodes) = self.cells.get(cell as usize);
            let law = self.laws[self.solid.material_of_cell[cell as usize] as usize];
            let element = Tet4::new(&corners(&self.solid.mesh.nodes, nodes))
                .ok_or_else(|| folded(self.solid, cell as usize, kind, nodes))?;
            let i = nodes.iter().position(|&j| j == node).expect("a cell at a node has it");
            for (&j, from) in nodes.iter().zip(&element.row(i, law)) {
                add_block(&mut self.blocks[self.place[j as usize] as usize], from);
            }
        }
        Ok(())
    }

    fn add_cell(&mut self, cell: usize, range: &NodeRange) -> Result<(), Error> {
        let (kind, nodes) = self.cells.get(cell);
        let at = &self.solid.mesh.nodes;
        let material = self.solid.material_of_cell[cell];
        let law = self.laws[material as usize];
        let sums = &mut self.blocks;
        let added = match kind {
            CellKind::Tet4 => Tet4::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, sums)),
            CellKind::Hex8 => {
                let x = corners(at, nodes);
                match self.shapes.rows(cell, &x, material, law) {
                    Some(rows) => {
                        add_rows(|i| &rows[i], nodes, range, sums);
                        Some(())
                    }
                    None => Hex8::new(&x).map(|e| add(&e, law, nodes, range, sums)),
                }
            }
            CellKind::Tet10 => Tet10::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, sums)),
            CellKind::Hex20 => Hex20::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, sums)),
        };
        added.ok_or_else(|| folded(self.solid, cell, kind, nodes))
    }
}

/// Adds the rows of the nodes of one cell that belong to the range.
fn add<const N: usize, const Q: usize>(
    element: &Element<N, Q>,
    law: Law,
    nodes: &[u32],
    range: &NodeRange,
    sums: &mut [[V3; 3]],
) {
    add_rows(|i| element.row(i, law), nodes, range, sums);
}

/// The same of a cell whose node `i` has the row `row(i)`.
fn add_rows<const N: usize, R: Borrow<[[V3; 3]; N]>>(
    row: impl Fn(usize) -> R,
    nodes: &[u32],
    range: &NodeRange,
    sums: &mut [[V3; 3]],
) {
    for (i, &node) in nodes.iter().enumerate() {
        if !range.nodes.contains(&(node as usize)) {
            continue;
        }
        let neighbours = range.neighbours(node as usize);
        let to = &mut sums[range.row(node as usize)];
        for (&other, from) in nodes.iter().zip(row(i).borrow()) {
            add_block(&mut to[neighbours.partition_point(|&j| j < other)], from);
        }
    }
}

fn add_block(to: &mut [V3; 3], from: &[V3; 3]) {
    to.as_flattened_mut().iter_mut().zip(from.as_flattened()).for_each(|(to, from)| *to += from);
}
