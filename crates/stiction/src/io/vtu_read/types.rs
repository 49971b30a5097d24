//! The cell types of VTK.

use crate::io::vtu::{HEXAHEDRON, QUAD, TETRA, TRIANGLE, VERTEX};
use crate::mesh::CellKind;

/// What this program makes of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// With the order in which its nodes are taken.
    Cell(CellKind, &'static [usize]),
    Face(&'static [usize]),
    /// Points and lines: nodes, any number of them.
    Nodes,
    /// Cannot be used: what it is and the remedy.
    Refused(&'static str, &'static str),
}

const ORDER: &str = "this version computes with linear elements: mesh with first order";
const SHAPE: &str = "mesh with tetrahedra or hexahedra only";
const ORDINARY: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];
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
        (HEXAHEDRON, 8) => Role::Cell(CellKind::Hex8, &ORDINARY),
        (VOXEL, 8) => Role::Cell(CellKind::Hex8, &BY_AXES),
        (13 | 26 | 31 | 32 | 73, _) => Role::Refused("wedge", SHAPE),
        (14 | 27 | 37 | 74, _) => Role::Refused("pyramid", SHAPE),
        (42, _) => Role::Refused("polyhedron", SHAPE),
        (22 | 23 | 28 | 30 | 34 | 69 | 70, _) => Role::Refused("face of second order", ORDER),
        (24 | 71, _) => Role::Refused("tetrahedron of second order", ORDER),
        (25 | 29 | 33 | 72, _) => Role::Refused("hexahedron of second order", ORDER),
        (TRIANGLE | QUAD | PIXEL | TETRA | HEXAHEDRON | VOXEL | POLYGON | 6, _) => {
            Role::Refused("cell with an unusual number of nodes", SHAPE)
        }
        _ => Role::Refused("cell of unknown type", SHAPE),
    }
}
