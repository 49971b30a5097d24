//! The rows of the stiffness matrix, summed over the cells.

use super::Solid;
use super::elements::{Element, Hex8, Hex20, Law, Tet4, Tet10, folded};
use super::incidence::{Incidence, NodeRange, Touching, is_needed};
use super::integrated::Shapes;
use super::ratios::Ratios;
use super::solid::CellList;
use crate::Error;
use crate::mesh::CellKind;
use crate::mesh::geometry::corners;
use crate::mesh::v3::{V3, scale};

/// The 3 x 3 blocks of one range of nodes after the other, for one thread. Cells are added in ascending order, linear
/// tetrahedra before others.
pub(super) struct Sums<'a> {
    terms: Terms<'a>,
    incidence: &'a Incidence,
    shapes: Shapes,
    touching: Touching,
    blocks: Vec<[V3; 3]>,
    /// Sums of products of a second and further ratio.
    products: Vec<[V3; 3]>,
}

/// What is summed.
struct Terms<'a> {
    solid: &'a Solid<'a>,
    /// Of each material.
    laws: &'a [Law<'a>],
    cells: &'a CellList<'a>,
    /// Nodes of which some displacement is prescribed.
    held: &'a [bool],
    ratios: Ratios,
}

impl<'a> Sums<'a> {
    pub fn new(
        solid: &'a Solid<'a>,
        laws: &'a [Law<'a>],
        cells: &'a CellList<'a>,
        incidence: &'a Incidence,
        held: &'a [bool],
    ) -> Self {
        let terms = Terms { solid, laws, cells, held, ratios: Ratios::new(laws) };
        let (blocks, products) = (Vec::new(), Vec::new());
        Sums { terms, incidence, shapes: Shapes::new(), touching: Touching::default(), blocks, products }
    }

    /// The blocks of the rows of `range`, in the order of its neighbours. An error for a folded cell.
    pub fn of(&mut self, range: &NodeRange) -> Result<&mut [[V3; 3]], Error> {
        let Sums { terms, incidence, shapes, touching, blocks, products } = self;
        let cells = touching.cells(range, incidence);
        zero(blocks, range);
        let mut is_first = true;
        for (number, ratio) in terms.ratios.each() {
            let mut own = cells.iter().filter(|&&cell| terms.ratio(cell) == Some(number)).peekable();
            if own.peek().is_none() {
                continue;
            }
            if is_first {
                is_first = false;
                own.try_for_each(|&cell| terms.add_products(cell, range, blocks))?;
                blocks.iter_mut().for_each(|sum| *sum = Ratios::block(sum, ratio));
            } else {
                zero(products, range);
                own.try_for_each(|&cell| terms.add_products(cell, range, products))?;
                blocks.iter_mut().zip(&*products).for_each(|(sum, of)| add_to(sum, &Ratios::block(of, ratio)));
            }
        }
        let mut others = cells.iter().filter(|&&cell| terms.ratio(cell).is_none());
        others.try_for_each(|&cell| terms.add(cell, range, shapes, blocks))?;
        Ok(blocks)
    }
}

fn zero(blocks: &mut Vec<[V3; 3]>, range: &NodeRange) {
    blocks.clear();
    blocks.resize(range.blocks(), [[0.0; 3]; 3]);
}

impl Terms<'_> {
    /// The number of its ratio, if products of the cell are summed.
    fn ratio(&self, cell: u32) -> Option<usize> {
        let is_linear = self.cells.get(cell as usize).0 == CellKind::Tet4;
        if is_linear { self.ratios.of(self.solid.material_of_cell[cell as usize]) } else { None }
    }

    /// Adds the products of the gradients of a linear tetrahedron, from which [`Ratios::block`] makes its blocks.
    fn add_products(&self, cell: u32, range: &NodeRange, sums: &mut [[V3; 3]]) -> Result<(), Error> {
        let (kind, nodes) = self.cells.get(cell as usize);
        let element = Tet4::new(&corners(&self.solid.mesh.nodes, nodes));
        let element = element.ok_or_else(|| folded(self.solid, cell as usize, kind, nodes))?;
        let law = self.laws[self.solid.material_of_cell[cell as usize] as usize];
        // Of equal factors, so that the products of i and j are those of j and i to the bit.
        let root = (law.mu * element.weight[0]).sqrt();
        let [a, b, c, d] = element.gradient[0];
        let gradient = [scale(root, a), scale(root, b), scale(root, c), scale(root, d)];
        let product = |i: usize, j: usize| {
            let (a, b) = (gradient[i], gradient[j]);
            [scale(a[0], b), scale(a[1], b), scale(a[2], b)]
        };
        add_blocks::<4>(product, nodes, range, self.held, sums);
        Ok(())
    }

    /// Adds the blocks of a cell.
    fn add(&self, cell: u32, range: &NodeRange, shapes: &mut Shapes, sums: &mut [[V3; 3]]) -> Result<(), Error> {
        let (kind, nodes) = self.cells.get(cell as usize);
        let at = &self.solid.mesh.nodes;
        let material = self.solid.material_of_cell[cell as usize];
        let (law, held) = (self.laws[material as usize], self.held);
        let added = match kind {
            CellKind::Tet4 => Tet4::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, held, sums)),
            CellKind::Hex8 => {
                let x = corners(at, nodes);
                match shapes.rows(cell as usize, &x, material, law) {
                    Some(rows) => {
                        add_blocks::<8>(|i, j| rows[i][j], nodes, range, held, sums);
                        Some(())
                    }
                    None => Hex8::new(&x).map(|e| add(&e, law, nodes, range, held, sums)),
                }
            }
            CellKind::Tet10 => Tet10::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, held, sums)),
            CellKind::Hex20 => Hex20::new(&corners(at, nodes)).map(|e| add(&e, law, nodes, range, held, sums)),
        };
        added.ok_or_else(|| folded(self.solid, cell as usize, kind, nodes))
    }
}

/// Adds what one cell contributes to the rows of the range.
fn add<const N: usize, const Q: usize>(
    element: &Element<N, Q>,
    law: Law,
    nodes: &[u32],
    range: &NodeRange,
    held: &[bool],
    sums: &mut [[V3; 3]],
) {
    let dilatation = element.dilatation(law);
    add_blocks::<N>(|i, j| element.block(i, j, law, dilatation.as_ref()), nodes, range, held, sums);
}

/// The same of a cell whose nodes `i` and `j` have the block `block(i, j)`.
#[inline(always)]
fn add_blocks<const N: usize>(
    block: impl Fn(usize, usize) -> [V3; 3],
    nodes: &[u32],
    range: &NodeRange,
    held: &[bool],
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
            if is_needed(node as usize, other as usize, held) {
                add_to(&mut to[place as usize], &block(i, j));
            }
        }
    }
}

#[inline(always)]
fn add_to(sum: &mut [V3; 3], block: &[V3; 3]) {
    sum.as_flattened_mut().iter_mut().zip(block.as_flattened()).for_each(|(sum, b)| *sum += b);
}
