//! Rectangular blocks, for problems that need no mesher.

use rayon::prelude::*;

use super::quadratic::quadratic;
use super::{CellKind, Mesh, RawCells, RawGroup, RawMesh, build};
use crate::Error;

/// A box divided into cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Edge lengths, > 0.
    pub size: [f64; 3],
    /// Cells along each axis, >= 1.
    pub cells: [usize; 3],
    /// The corner with the lowest coordinates.
    pub origin: [f64; 3],
    /// Length of the last cell over that of the first along each axis, > 0, in geometric progression; 1 is uniform.
    pub grading: [f64; 3],
    /// Kind of its cells.
    pub element: BlockElement,
}

/// What each cell of a block is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockElement {
    /// Five tetrahedra, alternating so that neighbours conform. At parity 0 the cell at the origin has its central
    /// tetrahedron on the corners 100 010 001 111, at parity 1 on 000 110 101 011.
    Tet4Five {
        /// 0 or 1.
        parity: u8,
    },
    /// Six tetrahedra around the diagonal from the lowest to the highest corner of every cell (Kuhn 1960).
    Tet4Six,
    /// Hexahedra with eight nodes.
    Hex8,
    /// The tetrahedra of [`BlockElement::Tet4Five`] with nodes in the middles of their edges.
    Tet10Five {
        /// 0 or 1.
        parity: u8,
    },
    /// The tetrahedra of [`BlockElement::Tet4Six`] with nodes in the middles of their edges.
    Tet10Six,
    /// Hexahedra with twenty nodes.
    Hex20,
    /// Two wedges along z, cut along the diagonal from the lowest to the highest corner of every cell seen from above.
    Wedge6,
    /// The wedges of [`BlockElement::Wedge6`] with nodes in the middles of their edges.
    Wedge15,
}

impl BlockElement {
    /// The element with the same corners and straight edges.
    pub fn linear(self) -> BlockElement {
        match self {
            BlockElement::Tet4Five { parity } | BlockElement::Tet10Five { parity } => BlockElement::Tet4Five { parity },
            BlockElement::Tet4Six | BlockElement::Tet10Six => BlockElement::Tet4Six,
            BlockElement::Hex8 | BlockElement::Hex20 => BlockElement::Hex8,
            BlockElement::Wedge6 | BlockElement::Wedge15 => BlockElement::Wedge6,
        }
    }

    /// The kind of its cells.
    pub fn kind(self) -> CellKind {
        match self {
            BlockElement::Tet4Five { .. } | BlockElement::Tet4Six => CellKind::Tet4,
            BlockElement::Hex8 => CellKind::Hex8,
            BlockElement::Tet10Five { .. } | BlockElement::Tet10Six => CellKind::Tet10,
            BlockElement::Hex20 => CellKind::Hex20,
            BlockElement::Wedge6 => CellKind::Wedge6,
            BlockElement::Wedge15 => CellKind::Wedge15,
        }
    }

    /// Whether there are nodes in the middles of edges.
    pub fn is_quadratic(self) -> bool {
        self != self.linear()
    }
}

impl Block {
    /// Number of nodes, as a float: it may be beyond what can be numbered.
    pub fn nodes(&self) -> f64 {
        let [x, y, z] = self.cells.map(|n| n as f64);
        let corners = (x + 1.0) * (y + 1.0) * (z + 1.0);
        if !self.element.is_quadratic() {
            return corners;
        }
        let across = |a: f64, b: f64, c: f64| a * b * (c + 1.0);
        let along = |a: f64, b: f64, c: f64| a * (b + 1.0) * (c + 1.0);
        let sides = along(x, y, z) + along(y, z, x) + along(z, x, y);
        let diagonals = across(x, y, z) + across(y, z, x) + across(z, x, y);
        corners
            + sides
            + match self.element.linear() {
                BlockElement::Hex8 => 0.0,
                BlockElement::Wedge6 => across(x, y, z),
                BlockElement::Tet4Six => diagonals + x * y * z,
                _ => diagonals,
            }
    }
}

// Corner numbers of a cell: 1 for x, 2 for y, 4 for z.
const FIVE_EVEN: [[usize; 4]; 5] = [[1, 2, 4, 7], [0, 1, 2, 4], [3, 2, 1, 7], [5, 1, 4, 7], [6, 4, 2, 7]];
const FIVE_ODD: [[usize; 4]; 5] = [[0, 5, 3, 6], [1, 3, 0, 5], [2, 0, 3, 6], [4, 5, 0, 6], [7, 3, 5, 6]];
const SIX: [[usize; 4]; 6] = [[0, 1, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 5, 1, 7], [0, 3, 2, 7], [0, 6, 4, 7]];
const HEX: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];
const WEDGES: [[usize; 6]; 2] = [[0, 1, 3, 4, 5, 7], [0, 3, 2, 4, 7, 6]];

/// The mesh of a block: nodes numbered with x fastest, then y, then z, after them those in the middles of edges by the
/// numbers of their ends; groups `x-min` `x-max` `y-min` `y-max` `z-min` `z-max` of faces and `body` of all cells.
///
/// Without grading the nodes lie exactly at `origin + size * i / n`.
///
/// # Errors
/// If a size, a number of cells or a grading cannot be used, or the mesh has too many nodes.
pub fn block(block: &Block) -> Result<Mesh, Error> {
    shape_error(block)?;
    count_error(block)?;
    let axes = [axis(block, 0)?, axis(block, 1)?, axis(block, 2)?];
    let mut nodes = Vec::with_capacity(axes.iter().map(Vec::len).product());
    for &z in &axes[2] {
        for &y in &axes[1] {
            nodes.extend(axes[0].iter().map(|&x| [x, y, z]));
        }
    }
    let mut cells = cells(block);
    if block.element.is_quadratic() {
        cells = quadratic(&mut nodes, cells);
    }
    let count = cells.nodes.len() / cells.kind.nodes();
    let body = RawGroup { name: "body".into(), cells: (0..count as u32).collect(), ..RawGroup::default() };
    let raw = RawMesh { nodes, cells: vec![cells], groups: vec![body], ..RawMesh::default() };
    let (mut mesh, _) = build(raw).map_err(|e| e.at("block"))?;
    let sides = sides(&axes, &mesh);
    mesh.groups.splice(0..0, sides);
    Ok(mesh)
}

/// Refuses sizes, numbers of cells and gradings that no block has.
pub(super) fn shape_error(block: &Block) -> Result<(), Error> {
    let fail = |what: String, remedy: &str| Err(Error::new("block", what, remedy));
    for c in 0..3 {
        let name = ["x", "y", "z"][c];
        if !(block.size[c].is_finite() && block.size[c] > 0.0) {
            return fail(format!("its size along {name} is {}", block.size[c]), "sizes are positive lengths");
        }
        if !(block.grading[c].is_finite() && block.grading[c] > 0.0) {
            return fail(
                format!("its grading along {name} is {}", block.grading[c]),
                "gradings are positive; 1 is uniform",
            );
        }
        if !block.origin[c].is_finite() {
            return fail(format!("the {name} coordinate of its origin is {}", block.origin[c]), "give a finite number");
        }
        if block.cells[c] == 0 {
            return fail(format!("it has no cells along {name}"), "give at least one");
        }
    }
    if let BlockElement::Tet4Five { parity: 2.. } = block.element.linear() {
        return fail("its parity is neither 0 nor 1".into(), "choose one of them");
    }
    Ok(())
}

/// Refuses more nodes than can be numbered in a whole mesh.
fn count_error(block: &Block) -> Result<(), Error> {
    // the faces of six tetrahedra a cell must be numbered by u32, as must the nodes
    let room = f64::from(u32::MAX / 36);
    if block.nodes() > room {
        let [x, y, z] = block.cells;
        let what = format!("{x} x {y} x {z} cells are too many");
        return Err(Error::new("block", what, format!("a block has at most {room:.0} nodes")));
    }
    Ok(())
}

/// Node coordinates along an axis.
pub(super) fn axis(block: &Block, c: usize) -> Result<Vec<f64>, Error> {
    let n = block.cells[c];
    let (origin, size) = (block.origin[c], block.size[c]);
    // logarithm of the ratio of neighbouring cells: lengths 1, q, q², ... sum up to (qⁱ - 1) / (q - 1)
    let log_q = if n > 1 { block.grading[c].ln() / (n - 1) as f64 } else { 0.0 };
    let at = |i: usize| {
        if log_q == 0.0 {
            origin + size * i as f64 / n as f64
        } else {
            origin + size * ((i as f64 * log_q).exp_m1() / (n as f64 * log_q).exp_m1())
        }
    };
    let axis: Vec<f64> = (0..=n).map(at).collect();
    if axis.windows(2).all(|w| w[0] < w[1]) && axis[n].is_finite() {
        return Ok(axis);
    }
    let name = ["x", "y", "z"][c];
    let what = format!("along {name} neighbouring nodes fall onto one another");
    Err(Error::new("block", what, "use fewer cells, a milder grading, or an origin nearer to the block"))
}

/// Cells that each cell of the grid is cut into.
pub(super) fn parts(element: BlockElement) -> usize {
    match element.linear() {
        BlockElement::Tet4Five { .. } => 5,
        BlockElement::Tet4Six => 6,
        BlockElement::Wedge6 => 2,
        _ => 1,
    }
}

/// The corners of the cells in the cell of the grid whose places along the axes have this sum.
pub(super) fn corners(element: BlockElement, sum: u64) -> &'static [usize] {
    match element.linear() {
        BlockElement::Tet4Five { parity } if (sum + u64::from(parity)).is_multiple_of(2) => FIVE_EVEN.as_flattened(),
        BlockElement::Tet4Five { .. } => FIVE_ODD.as_flattened(),
        BlockElement::Tet4Six => SIX.as_flattened(),
        BlockElement::Wedge6 => WEDGES.as_flattened(),
        _ => &HEX,
    }
}

/// All cells with their corners, numbered with x fastest; those of one grid cell follow one another.
fn cells(block: &Block) -> RawCells {
    let [nx, ny, nz] = block.cells;
    let (element, kind) = (block.element.linear(), block.element.kind().linear());
    let of_cell = parts(element) * kind.nodes();
    let mut nodes = vec![0; nx * ny * nz * of_cell];
    nodes.par_chunks_exact_mut(nx * ny * of_cell).enumerate().for_each(|(k, layer)| {
        let mut own = layer.chunks_exact_mut(of_cell);
        for j in 0..ny {
            for (i, own) in (0..nx).zip(&mut own) {
                let corner = |b: usize| {
                    let (x, y, z) = (i + (b & 1), j + (b >> 1 & 1), k + (b >> 2));
                    (x + (nx + 1) * (y + (ny + 1) * z)) as u32
                };
                own.iter_mut().zip(corners(element, (i + j + k) as u64)).for_each(|(node, &b)| *node = corner(b));
            }
        }
    });
    RawCells { kind, nodes, ids: Vec::new() }
}

/// The groups of faces on the sides, across each axis in turn.
pub(super) const SIDE_NAMES: [&str; 6] = ["x-min", "x-max", "y-min", "y-max", "z-min", "z-max"];

/// The six groups of faces: a boundary face lies on the side where all its nodes have the coordinate of that side.
fn sides(axes: &[Vec<f64>; 3], mesh: &Mesh) -> Vec<super::Group> {
    let mut groups = SIDE_NAMES.map(|name| super::Group { name: name.into(), ..super::Group::default() });
    for (number, face) in mesh.faces.iter().enumerate() {
        for (c, axis) in axes.iter().enumerate() {
            for (side, end) in [axis[0], axis[axis.len() - 1]].into_iter().enumerate() {
                // the middle of an edge between equal coordinates has the very same
                if face.nodes().iter().all(|&node| mesh.nodes[node as usize][c] == end) {
                    groups[2 * c + side].faces.push(number as u32);
                }
            }
        }
    }
    groups.into()
}

#[cfg(test)]
#[path = "block_tests.rs"]
pub(super) mod tests;
