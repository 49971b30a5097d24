//! The cell types of VTK.

use crate::io::vtu::{
    HEXAHEDRON, QUAD, QUADRATIC_HEXAHEDRON, QUADRATIC_QUAD, QUADRATIC_TETRA, QUADRATIC_TRIANGLE, QUADRATIC_WEDGE,
    TETRA, TRIANGLE, VERTEX, WEDGE,
};
use crate::mesh::CellKind;

/// What this program makes of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// With the order in which its nodes are taken.
    Cell(CellKind, &'static [usize]),
    /// With its corners.
    Face(&'static [usize]),
    /// Points and lines: nodes, any number of them.
    Nodes,
    /// Cannot be used: what it is and the remedy.
    Refused(&'static str, &'static str),
}

const ORDER: &str = "write tetrahedra with 4 or 10 nodes, wedges with 6 or 15, hexahedra with 8 or 20 (VTK codes 10, 24, 13, 26, 12, 25)";
const SHAPE: &str = "mesh with tetrahedra, wedges and hexahedra only";
const ORDINARY: [usize; 20] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19];
/// Pixels and voxels count x first, then y.
const BY_AXES: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

const POLYGON: u8 = 7;
const PIXEL: u8 = 8;
const VOXEL: u8 = 11;

/// The role of a cell with that code and number of nodes.
pub(super) fn role(code: u8, nodes: usize) -> Role {
    match (code, nodes) {
        (VERTEX..=4 | 21, _) => Role::Nodes, // vertices, lines and what is made of them; 21 is a line of second order
        (TRIANGLE | POLYGON, 3) => Role::Face(&ORDINARY[..3]),
        (QUAD | POLYGON, 4) => Role::Face(&ORDINARY[..4]),
        (PIXEL, 4) => Role::Face(&BY_AXES[..4]),
        (TETRA, 4) => Role::Cell(CellKind::Tet4, &ORDINARY[..4]),
        (HEXAHEDRON, 8) => Role::Cell(CellKind::Hex8, &ORDINARY[..8]),
        (QUADRATIC_TRIANGLE, 6) => Role::Face(&ORDINARY[..3]),
        (QUADRATIC_QUAD, 8) => Role::Face(&ORDINARY[..4]),
        (QUADRATIC_TETRA, 10) => Role::Cell(CellKind::Tet10, &ORDINARY[..10]),
        (QUADRATIC_HEXAHEDRON, 20) => Role::Cell(CellKind::Hex20, &ORDINARY),
        (VOXEL, 8) => Role::Cell(CellKind::Hex8, &BY_AXES),
        (WEDGE, 6) => Role::Cell(CellKind::Wedge6, &ORDINARY[..6]),
        (QUADRATIC_WEDGE, 15) => Role::Cell(CellKind::Wedge15, &ORDINARY[..15]),
        (14 | 27 | 37 | 74, _) => Role::Refused("pyramid", SHAPE),
        (42, _) => Role::Refused("polyhedron", SHAPE),
        (28 | 30 | 34 | 69 | 70, _) => Role::Refused("face of higher order", ORDER),
        (71, _) => Role::Refused("tetrahedron of higher order", ORDER),
        (31 | 32 | 73, _) => Role::Refused("wedge of higher order", ORDER),
        (29 | 33 | 72, _) => Role::Refused("hexahedron of higher order", ORDER),
        (QUADRATIC_TRIANGLE | QUADRATIC_QUAD | QUADRATIC_TETRA | QUADRATIC_HEXAHEDRON | QUADRATIC_WEDGE, _) => {
            Role::Refused("quadratic cell with an unusual number of nodes", ORDER)
        }
        (TRIANGLE | QUAD | PIXEL | TETRA | HEXAHEDRON | VOXEL | WEDGE | POLYGON | 6, _) => {
            Role::Refused("cell with an unusual number of nodes", SHAPE)
        }
        _ => Role::Refused("cell of unknown type", SHAPE),
    }
}
