//! Nodes, cells, boundary faces and named groups. Knows no elements, no physics and no files.
//!
//! A [`Mesh`] is made by [`block()`], or from what a file says by [`build`], which finds the boundary and refuses
//! cells that no computation could use. [`info`] tells what is in it.

mod arrays;
mod bisect;
pub mod block;
mod buckets;
mod build;
mod check;
mod components;
mod cut;
mod cuts;
mod divide;
mod face_table;
pub(crate) mod facets;
pub(crate) mod geometry;
mod grid;
mod groups;
mod info;
mod inherit;
mod join;
mod kinks;
mod meeting;
mod notes;
mod quadratic;
mod quality;
mod query;
mod raw;
mod ring;
mod rounding;
pub(crate) mod shape;
mod tree;
pub(crate) mod v3;

pub use arrays::{CellArray, MeshArrays, NodeArray};
pub use bisect::{Bisection, Refined, refine};
pub use block::{Block, BlockElement, block};
pub(crate) use buckets::Buckets;
pub use build::build;
pub(crate) use build::coincident_nodes;
pub use components::bodies;
pub use cut::{Order, cut, tetrahedra};
pub use cuts::{Cuts, WeightedNode};
pub use divide::{MeshPiece, pieces};
pub(crate) use grid::around;
pub use grid::{CornerBox, Grid, GridMesh, Grids};
pub use info::{CellInfo, GroupInfo, MeshInfo, info};
pub(crate) use info::{CellShape, info_with};
pub use join::{Turn, join, place};
pub use kinks::kinks;
pub use meeting::Meeting;
pub(crate) use notes::many;
pub use notes::{MeshNote, MeshNotes};
pub use quality::quality;
pub(crate) use query::{ascending, beside};
pub use raw::{RawCells, RawGroup, RawMesh};
pub use ring::{MOST_DEGREES, Ring, ring};
pub use rounding::{Rounded, round_facets};
pub use tree::{Bounds, Tree, nearest_on_triangle, weights_on_triangle};

/// The shape and interpolation of a cell. Local node order is that of VTK, for linear cells that of Gmsh as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CellKind {
    /// Linear tetrahedron; positive if node 3 lies on the side of `(1 - 0) x (2 - 0)`.
    Tet4,
    /// Trilinear hexahedron: bottom 0 1 2 3 counter-clockwise seen from above, top 4 5 6 7 over it.
    Hex8,
    /// Quadratic tetrahedron: after the corners the middles of the edges 01 12 20 03 13 23.
    Tet10,
    /// Serendipity hexahedron: after the corners the middles of the edges 01 12 23 30, 45 56 67 74, 04 15 26 37.
    Hex20,
    /// Wedge, linear over its triangles and from one to the other: bottom 0 1 2 counter-clockwise seen from above, top
    /// 3 4 5 over it.
    Wedge6,
    /// Quadratic wedge: after the corners the middles of the edges 01 12 20, 34 45 53, 03 14 25.
    Wedge15,
}

impl CellKind {
    /// All kinds, in the order in which readers list their cells.
    pub const ALL: [CellKind; 6] =
        [CellKind::Tet4, CellKind::Hex8, CellKind::Tet10, CellKind::Hex20, CellKind::Wedge6, CellKind::Wedge15];

    /// Nodes of a cell.
    pub fn nodes(self) -> usize {
        match self {
            CellKind::Tet4 => 4,
            CellKind::Hex8 => 8,
            CellKind::Tet10 => 10,
            CellKind::Hex20 => 20,
            CellKind::Wedge6 => 6,
            CellKind::Wedge15 => 15,
        }
    }

    /// The kind with the same corners and straight edges; its nodes come first.
    pub fn linear(self) -> CellKind {
        match self {
            CellKind::Tet4 | CellKind::Tet10 => CellKind::Tet4,
            CellKind::Hex8 | CellKind::Hex20 => CellKind::Hex8,
            CellKind::Wedge6 | CellKind::Wedge15 => CellKind::Wedge6,
        }
    }

    /// The two corners of each edge with a node in its middle; these nodes follow the corners in this order.
    pub fn edges(self) -> &'static [[usize; 2]] {
        match self {
            CellKind::Tet4 | CellKind::Hex8 | CellKind::Wedge6 => &[],
            CellKind::Tet10 => &shape::TET_EDGES,
            CellKind::Hex20 => &shape::HEX_EDGES,
            CellKind::Wedge15 => &shape::WEDGE_EDGES,
        }
    }

    /// Local nodes of each face: corners counter-clockwise seen from outside the cell, then the middles of its edges
    /// from the one after the first corner on.
    pub fn faces(self) -> &'static [&'static [usize]] {
        match self {
            CellKind::Tet4 => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]],
            CellKind::Hex8 => {
                &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
            }
            CellKind::Tet10 => &[&[0, 2, 1, 6, 5, 4], &[0, 1, 3, 4, 8, 7], &[1, 2, 3, 5, 9, 8], &[0, 3, 2, 7, 9, 6]],
            CellKind::Hex20 => &[
                &[0, 3, 2, 1, 11, 10, 9, 8],
                &[4, 5, 6, 7, 12, 13, 14, 15],
                &[0, 1, 5, 4, 8, 17, 12, 16],
                &[1, 2, 6, 5, 9, 18, 13, 17],
                &[2, 3, 7, 6, 10, 19, 14, 18],
                &[3, 0, 4, 7, 11, 16, 15, 19],
            ],
            CellKind::Wedge6 => &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
            CellKind::Wedge15 => &[
                &[0, 2, 1, 8, 7, 6],
                &[3, 4, 5, 9, 10, 11],
                &[0, 1, 4, 3, 6, 13, 9, 12],
                &[1, 2, 5, 4, 7, 14, 10, 13],
                &[2, 0, 3, 5, 8, 12, 11, 14],
            ],
        }
    }

    /// The name used in messages and case files.
    pub fn name(self) -> &'static str {
        match self {
            CellKind::Tet4 => "tet4",
            CellKind::Hex8 => "hex8",
            CellKind::Tet10 => "tet10",
            CellKind::Hex20 => "hex20",
            CellKind::Wedge6 => "wedge6",
            CellKind::Wedge15 => "wedge15",
        }
    }
}

/// Cells of one kind. The number of a cell in its mesh runs through the blocks in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// The kind of all of them.
    pub kind: CellKind,
    /// Node numbers, `kind.nodes()` a cell.
    pub nodes: Vec<u32>,
}

impl Cells {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.nodes.len() / self.kind.nodes()
    }

    /// Whether there is no cell.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Nodes of the `i`-th cell of this block.
    pub fn cell(&self, i: usize) -> &[u32] {
        let k = self.kind.nodes();
        &self.nodes[i * k..(i + 1) * k]
    }
}

/// A boundary face: a face of exactly one cell, seen from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Face {
    /// Corners counter-clockwise seen from outside, then the middles of the edges; `u32::MAX` beyond the last.
    all: [u32; shape::FACE_NODES],
    /// Number of the cell in the mesh.
    pub cell: u32,
    /// Which of the cell's faces.
    pub local: u8,
}

impl Face {
    /// The face number `local` of cell number `cell` whose nodes are `cell_nodes`.
    pub fn of_cell(kind: CellKind, cell_nodes: &[u32], cell: u32, local: u8) -> Self {
        let mut all = [u32::MAX; shape::FACE_NODES];
        for (node, &i) in all.iter_mut().zip(kind.faces()[local as usize]) {
            *node = cell_nodes[i];
        }
        Face { all, cell, local }
    }

    /// A face of no cell that is known, by its nodes in the order of [`Self::nodes`]; none unless they are 3, 4, 6 or 8.
    pub fn of_nodes(nodes: &[u32]) -> Option<Self> {
        let mut all = [u32::MAX; shape::FACE_NODES];
        all.get_mut(..nodes.len()).filter(|_| [3, 4, 6, 8].contains(&nodes.len()))?.copy_from_slice(nodes);
        Some(Face { all, cell: u32::MAX, local: 0 })
    }

    /// The same with other numbers of nodes.
    pub(crate) fn renumbered(mut self, number: impl Fn(u32) -> u32) -> Self {
        let count = self.nodes().len();
        self.all[..count].iter_mut().for_each(|node| *node = number(*node));
        self
    }

    /// All its nodes, 3, 4, 6 or 8: the corners counter-clockwise seen from outside, then the middle of the edge from
    /// each corner to the next.
    pub fn nodes(&self) -> &[u32] {
        let count = [3, 4, 6].into_iter().find(|&count| self.all[count] == u32::MAX);
        &self.all[..count.unwrap_or(shape::FACE_NODES)]
    }

    /// Its three or four corners, counter-clockwise seen from outside.
    pub fn corners(&self) -> &[u32] {
        &self.all[..shape::face_corners(self.nodes().len())]
    }

    /// Its nodes in the order in which its border runs through them.
    pub fn border(&self) -> Vec<u32> {
        border(self.nodes())
    }
}

/// The nodes around a face in their order; given are corners, then the middles of edges.
pub(crate) fn border(nodes: &[u32]) -> Vec<u32> {
    let (corners, middles) = nodes.split_at(shape::face_corners(nodes.len()));
    if middles.is_empty() {
        return corners.to_vec();
    }
    corners.iter().zip(middles).flat_map(|(&corner, &middle)| [corner, middle]).collect()
}

/// A named set of cells, boundary faces or nodes; often only one of the lists is used.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// Cell numbers, ascending.
    pub cells: Vec<u32>,
    /// Indices into [`Mesh::faces`], ascending.
    pub faces: Vec<u32>,
    /// Faces of the group that are no boundary faces (their corners; triangles end in `u32::MAX`). The middles of their
    /// edges are among `nodes`.
    pub interior_faces: Vec<[u32; 4]>,
    /// Nodes named directly or by points and edges, ascending.
    pub nodes: Vec<u32>,
}

/// A valid mesh: every cell has positive volume, every node belongs to a cell, faces are shared by at most two cells.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Coordinates.
    pub nodes: Vec<[f64; 3]>,
    /// The cells, kind by kind.
    pub cells: Vec<Cells>,
    /// All boundary faces.
    pub faces: Vec<Face>,
    /// The named groups.
    pub groups: Vec<Group>,
    /// Numbers at nodes and cells that the file gives, such as temperatures.
    pub arrays: MeshArrays,
}

impl Mesh {
    /// Number of cells of all kinds.
    pub fn cell_count(&self) -> usize {
        self.cells.iter().map(Cells::len).sum()
    }

    /// The group called `name`.
    pub fn group(&self, name: &str) -> Option<&Group> {
        self.groups.iter().find(|g| g.name == name)
    }
}
