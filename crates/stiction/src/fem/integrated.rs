//! The stiffness of cells, integrated once for all that are equal.

use super::elements::{Element, Hex8, Hex20, Law, Tet4, Tet10, folded};
use super::solid::CellList;
use super::{Solid, turned::transposed};
use crate::Error;
use crate::mesh::CellKind;
use crate::mesh::geometry::{HexEdges, corners};
use crate::mesh::v3::V3;

/// Most 3 x 3 blocks that are kept, 17 MB: the cells around a range of nodes where no two are equal.
const MOST_BLOCKS: usize = 1 << 18;

/// Places at which a cell's edges are looked up; a place holds the last cell that came to it.
const PLACES: usize = 1 << 14;

/// The blocks of the cells met lately, for one thread.
///
/// Linear hexahedra whose edges and material are equal to the bit have the same stiffness, so that it depends on nothing
/// but the cell what is handed out: meshes of equal cells, as blocks and extruded ones, are integrated a few times only.
pub(super) struct Integrated<'a> {
    solid: &'a Solid<'a>,
    laws: &'a [Law<'a>],
    cells: &'a CellList<'a>,
    /// Rows of blocks `K_00 K_01 .. K_10 ..` of one shape after the other.
    blocks: Vec<[V3; 3]>,
    /// Row of the last linear tetrahedron.
    tet: [[V3; 3]; 4],
    /// Edges of all linear shapes.
    edges: Vec<f64>,
    shapes: Vec<Shape>,
    /// How many shapes were forgotten when there was no more room.
    forgotten: u32,
    /// For each cell one more than the number of its shape, counted with those that are forgotten; zero if it was not met.
    of_cell: Vec<u32>,
    /// For each place the same of the last shape that came to it.
    at: Vec<u32>,
}

struct Shape {
    /// Where its blocks and its edges begin.
    blocks: usize,
    edges: usize,
    material: u32,
}

impl<'a> Integrated<'a> {
    pub fn new(solid: &'a Solid<'a>, laws: &'a [Law<'a>], cells: &'a CellList<'a>) -> Self {
        let of_cell = vec![0; solid.mesh.cell_count()];
        let (blocks, edges, shapes, at) = (Vec::new(), Vec::new(), Vec::new(), vec![0; PLACES]);
        let tet = [[[0.0; 3]; 3]; 4];
        Integrated { solid, laws, cells, blocks, tet, edges, shapes, forgotten: 0, of_cell, at }
    }

    /// Nodes of the cell, and the blocks of the row of `node`, which is one of them, in the order of the nodes.
    pub fn row(&mut self, cell: u32, node: u32) -> Result<(&'a [u32], &[[V3; 3]]), Error> {
        let (kind, nodes) = self.cells.get(cell as usize);
        let i = nodes.iter().position(|&j| j == node).expect("a cell at a node has it");
        if kind == CellKind::Tet4 {
            // A row of these is had sooner than found among cells that are all different.
            let law = self.laws[self.solid.material_of_cell[cell as usize] as usize];
            let element = Tet4::new(&corners(&self.solid.mesh.nodes, nodes));
            self.tet = element.ok_or_else(|| folded(self.solid, cell as usize, kind, nodes))?.row(i, law);
            return Ok((nodes, &self.tet));
        }
        let shape = match self.of_cell[cell as usize].checked_sub(self.forgotten + 1) {
            Some(known) => known as usize,
            None => self.shape(cell as usize, kind, nodes)?,
        };
        Ok((nodes, &self.blocks[self.shapes[shape].blocks + i * nodes.len()..][..nodes.len()]))
    }

    fn shape(&mut self, cell: usize, kind: CellKind, nodes: &[u32]) -> Result<usize, Error> {
        if self.blocks.len() > MOST_BLOCKS {
            self.forgotten += self.shapes.len() as u32;
            self.blocks.clear();
            self.edges.clear();
            self.shapes.clear();
            if self.forgotten > u32::MAX / 2 {
                self.forgotten = 0;
                self.of_cell.fill(0);
                self.at.fill(0);
            }
        }
        let material = self.solid.material_of_cell[cell];
        let first = self.edges.len();
        self.add_edges(kind, nodes);
        let place = place(&self.edges[first..], material);
        let known = self.at[place].checked_sub(self.forgotten + 1).map(|known| known as usize);
        let shape = match known.filter(|&known| self.is_equal(known, first, material)) {
            Some(known) => {
                self.edges.truncate(first);
                known
            }
            None => {
                let blocks = self.blocks.len();
                self.integrate(cell, kind, nodes, self.laws[material as usize])?;
                self.shapes.push(Shape { blocks, edges: first, material });
                self.shapes.len() - 1
            }
        };
        let number = self.forgotten + shape as u32 + 1;
        self.at[place] = number;
        self.of_cell[cell] = number;
        Ok(shape)
    }

    /// All that the mapping of a linear hexahedron depends on; of a quadratic cell nothing, as its sums see where it lies.
    fn add_edges(&mut self, kind: CellKind, nodes: &[u32]) {
        let at = &self.solid.mesh.nodes;
        match kind {
            CellKind::Hex8 => {
                self.edges.extend(HexEdges::new(&corners(at, nodes)).0.as_flattened().as_flattened());
            }
            CellKind::Tet4 | CellKind::Tet10 | CellKind::Hex20 => {}
        }
    }

    /// Whether the shape has the edges that stand last in the list, and there are any.
    fn is_equal(&self, shape: usize, edges: usize, material: u32) -> bool {
        let Shape { edges: own, material: of, .. } = self.shapes[shape];
        let end = self.shapes.get(shape + 1).map_or(edges, |next| next.edges);
        // Zeros of either sign are the same number but need not lead to the same bits.
        let bits = |range: std::ops::Range<usize>| self.edges[range].iter().map(|x| x.to_bits());
        of == material && edges < self.edges.len() && bits(own..end).eq(bits(edges..self.edges.len()))
    }

    fn integrate(&mut self, cell: usize, kind: CellKind, nodes: &[u32], law: Law) -> Result<(), Error> {
        let at = &self.solid.mesh.nodes;
        let done = match kind {
            CellKind::Tet4 => Tet4::new(&corners(at, nodes)).map(|e| add_blocks(&e, law, &mut self.blocks)),
            CellKind::Hex8 => Hex8::new(&corners(at, nodes)).map(|e| add_blocks(&e, law, &mut self.blocks)),
            CellKind::Tet10 => Tet10::new(&corners(at, nodes)).map(|e| add_blocks(&e, law, &mut self.blocks)),
            CellKind::Hex20 => Hex20::new(&corners(at, nodes)).map(|e| add_blocks(&e, law, &mut self.blocks)),
        };
        done.ok_or_else(|| folded(self.solid, cell, kind, nodes))
    }
}

/// A number below [`PLACES`] that depends on every bit.
fn place(edges: &[f64], material: u32) -> usize {
    // Multiplication by an odd constant (the golden ratio, Knuth 6.4) carries low bits up, the turn high ones down.
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    let mixed = |sum: u64, bits: u64| (sum.rotate_left(29) ^ bits).wrapping_mul(GOLDEN);
    let sum = edges.iter().fold(u64::from(material), |sum, x| mixed(sum, x.to_bits()));
    (sum >> 40) as usize % PLACES
}

/// Adds the blocks of all rows; those left of the diagonal are transposed ones, which they are equal to, to the bit.
fn add_blocks<const N: usize, const Q: usize>(element: &Element<N, Q>, law: Law, blocks: &mut Vec<[V3; 3]>) {
    let first = blocks.len();
    for i in 0..N {
        for j in 0..i {
            let upper = transposed(&blocks[first + j * N + i]);
            blocks.push(upper);
        }
        blocks.extend_from_slice(&element.row_from(i, i, law)[i..]);
    }
}
