//! The rows of the stiffness matrix, summed over the cells.
//!
//! Of the blocks right of the diagonal only those at nodes with prescribed components are summed: `K` is its lower
//! triangle, and the others are mirror images.

use super::Solid;
use super::congruent_cells::Shapes;
use super::elements::{Element, Hex8, Hex20, Law, Tet4, Tet10, Wedge6, Wedge15, folded};
use super::incidence::{Incidence, Needed, NodeRange, Touching};
use super::solid::CellList;
use crate::Error;
use crate::mesh::CellKind;
use crate::mesh::geometry::corners;
use crate::mesh::v3::V3;

/// The 3 x 3 blocks of one range of nodes after the other, for one thread. Cells are added in ascending order.
pub(super) struct RowAssembly<'a> {
    solid: &'a Solid<'a>,
    /// Of each material.
    laws: &'a [Law<'a>],
    cells: &'a CellList<'a>,
    incidence: &'a Incidence,
    needed: &'a Needed,
    shapes: Shapes,
    touching: Touching,
    blocks: Vec<[V3; 3]>,
}

impl<'a> RowAssembly<'a> {
    pub(super) fn new(
        solid: &'a Solid<'a>,
        laws: &'a [Law<'a>],
        cells: &'a CellList<'a>,
        incidence: &'a Incidence,
        needed: &'a Needed,
    ) -> Self {
        let (shapes, touching) = (Shapes::new(), Touching::default());
        RowAssembly { solid, laws, cells, incidence, needed, shapes, touching, blocks: Vec::new() }
    }

    /// The blocks of the rows of `range`, in the order of its neighbours. An error for a folded cell.
    pub(super) fn of(&mut self, range: &NodeRange) -> Result<&mut [[V3; 3]], Error> {
        self.blocks.clear();
        self.blocks.resize(range.blocks(), [[0.0; 3]; 3]);
        let cells = self.touching.cells(range, self.incidence);
        cells.into_iter().try_for_each(|cell| self.add_cell(cell as usize, range))?;
        Ok(&mut self.blocks)
    }

    fn add_cell(&mut self, cell: usize, range: &NodeRange) -> Result<(), Error> {
        let (kind, nodes) = self.cells.get(cell);
        let at = &self.solid.mesh.nodes;
        let material = self.solid.material_of_cell[cell];
        let law = self.laws[material as usize];
        let (needed, sums) = (self.needed, &mut self.blocks);
        let added = match kind {
            CellKind::Tet4 => Tet4::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, needed, sums)),
            CellKind::Hex8 => {
                let x = corners(at, nodes);
                match self.shapes.rows(cell, &x, material, law) {
                    Some(rows) => {
                        add_blocks::<8>(|i, j| rows[i][j], nodes, range, needed, sums);
                        Some(())
                    }
                    None => Hex8::new(&x).map(|e| add(&e, law, nodes, range, needed, sums)),
                }
            }
            CellKind::Tet10 => Tet10::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, needed, sums)),
            CellKind::Hex20 => Hex20::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, needed, sums)),
            CellKind::Wedge6 => Wedge6::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, needed, sums)),
            CellKind::Wedge15 => Wedge15::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, needed, sums)),
        };
        added.ok_or_else(|| folded(self.solid, cell, kind, nodes))
    }
}

/// Adds what one cell contributes to the rows of the range.
fn add<const N: usize, const Q: usize>(
    element: &Element<N, Q>,
    law: Law,
    nodes: &[u32],
    range: &NodeRange,
    needed: &Needed,
    sums: &mut [[V3; 3]],
) {
    let dilatation = element.dilatation(law);
    add_blocks::<N>(|i, j| element.block(i, j, law, dilatation.as_ref()), nodes, range, needed, sums);
}

/// The same of a cell whose nodes `i` and `j` have the block `block(i, j)`.
#[inline(always)]
fn add_blocks<const N: usize>(
    block: impl Fn(usize, usize) -> [V3; 3],
    nodes: &[u32],
    range: &NodeRange,
    needed: &Needed,
    sums: &mut [[V3; 3]],
) {
    let nodes: &[u32; N] = nodes.first_chunk().expect("a cell has all its nodes");
    for (i, &node) in nodes.iter().enumerate() {
        if !range.nodes.contains(&(node as usize)) {
            continue;
        }
        // Where each node of the cell stands among the neighbours: counting all of them takes less time than a search.
        let mut places = [0u32; N];
        for &neighbour in range.neighbours(node as usize) {
            places.iter_mut().zip(nodes).for_each(|(place, &other)| *place += u32::from(neighbour < other));
        }
        let to = &mut sums[range.row(node as usize)];
        for (j, (&other, &place)) in nodes.iter().zip(&places).enumerate() {
            if needed.has(node as usize, other as usize) {
                let (to, from) = (to[place as usize].as_flattened_mut(), block(i, j));
                to.iter_mut().zip(from.as_flattened()).for_each(|(to, from)| *to += from);
            }
        }
    }
}
