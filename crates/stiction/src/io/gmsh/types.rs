//! The element types of Gmsh.

use crate::mesh::CellKind;

/// What this program makes of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Cell(CellKind),
    Face,
    /// A point or a line: its nodes.
    Nodes,
    /// Cannot be used; the remedy.
    Refused(&'static str),
}

/// An element type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ElementType {
    pub number: i64,
    pub name: &'static str,
    pub dimension: u8,
    pub nodes: usize,
    pub role: Role,
}

const ORDER: &str = "elements are of order 1 or 2: mesh with Mesh.ElementOrder = 1 or 2";
const SHAPE: &str = "mesh with tetrahedra, prisms and hexahedra only; cut pyramids into tetrahedra";

/// The element type with that number in the format's table.
pub(super) fn element_type(number: i64) -> Option<ElementType> {
    let refused = Role::Refused(ORDER);
    let (name, dimension, nodes, role) = match number {
        1 => ("2-node line", 1, 2, Role::Nodes),
        2 => ("3-node triangle", 2, 3, Role::Face),
        3 => ("4-node quadrilateral", 2, 4, Role::Face),
        4 => ("4-node tetrahedron", 3, 4, Role::Cell(CellKind::Tet4)),
        5 => ("8-node hexahedron", 3, 8, Role::Cell(CellKind::Hex8)),
        6 => ("6-node prism", 3, 6, Role::Cell(CellKind::Wedge6)),
        7 => ("5-node pyramid", 3, 5, Role::Refused(SHAPE)),
        8 => ("3-node line", 1, 3, Role::Nodes),
        9 => ("6-node triangle", 2, 6, Role::Face),
        10 => ("9-node quadrilateral", 2, 9, Role::Face),
        11 => ("10-node tetrahedron", 3, 10, Role::Cell(CellKind::Tet10)),
        12 => ("27-node hexahedron", 3, 27, Role::Cell(CellKind::Hex20)),
        13 => ("18-node prism", 3, 18, Role::Cell(CellKind::Wedge15)),
        14 => ("14-node pyramid", 3, 14, Role::Refused(SHAPE)),
        15 => ("point", 0, 1, Role::Nodes),
        16 => ("8-node quadrilateral", 2, 8, Role::Face),
        17 => ("20-node hexahedron", 3, 20, Role::Cell(CellKind::Hex20)),
        18 => ("15-node prism", 3, 15, Role::Cell(CellKind::Wedge15)),
        19 => ("13-node pyramid", 3, 13, Role::Refused(SHAPE)),
        20 => ("9-node triangle", 2, 9, refused),
        21 => ("10-node triangle", 2, 10, refused),
        22 => ("12-node triangle", 2, 12, refused),
        23 => ("15-node triangle", 2, 15, refused),
        24 => ("15-node incomplete triangle", 2, 15, refused),
        25 => ("21-node triangle", 2, 21, refused),
        26 => ("4-node line", 1, 4, refused),
        27 => ("5-node line", 1, 5, refused),
        28 => ("6-node line", 1, 6, refused),
        29 => ("20-node tetrahedron", 3, 20, refused),
        30 => ("35-node tetrahedron", 3, 35, refused),
        31 => ("56-node tetrahedron", 3, 56, refused),
        36 => ("16-node quadrilateral", 2, 16, refused),
        37 => ("25-node quadrilateral", 2, 25, refused),
        92 => ("64-node hexahedron", 3, 64, refused),
        93 => ("125-node hexahedron", 3, 125, refused),
        _ => return None,
    };
    Some(ElementType { number, name, dimension, nodes, role })
}

/// Places in Gmsh's list of the nodes of a cell, in our order; of 27 nodes the first 20 are taken,
/// of 18 the first 15 (Gmsh reference manual, "Node ordering"): the edges of quadratic cells are 01 12 20 03 23 13 there,
/// 01 03 04 12 15 23 26 37 45 47 56 67, and 01 02 03 12 14 25 34 35 45.
pub(super) fn order(kind: CellKind) -> &'static [usize] {
    match kind {
        CellKind::Tet4 => &[0, 1, 2, 3],
        CellKind::Hex8 => &[0, 1, 2, 3, 4, 5, 6, 7],
        CellKind::Tet10 => &[0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
        CellKind::Hex20 => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
        CellKind::Wedge6 => &[0, 1, 2, 3, 4, 5],
        CellKind::Wedge15 => &[0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11],
    }
}
