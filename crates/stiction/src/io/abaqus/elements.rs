//! The element types of Abaqus and CalculiX.

use crate::mesh::CellKind;

/// What this program makes of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Cell(CellKind),
    /// A face of the surface, with 3, 4, 6 or 8 nodes.
    Face(usize),
    /// A line: its nodes.
    Nodes(usize),
    /// Known, but not computed with; what it is and the remedy.
    Refused(&'static str, &'static str),
    /// Springs, masses, connectors and whatever else has no place in a solid.
    Skipped,
}

const ORDER: &str = "mesh with C3D4, C3D6, C3D8, C3D10, C3D15 or C3D20";
const SHAPE: &str = "mesh with tetrahedra, wedges and hexahedra only";

/// Names of faces begin with one of these, and the number of nodes follows.
const FACES: [&str; 11] = ["SFM3D", "STRI", "CPEG", "CPS", "CPE", "CAX", "M3D", "R3D", "DS", "MGAX", "S"];
/// Beginnings of names of lines with two nodes, and with three.
const LINES: [&[&str]; 2] =
    [&["T3D2", "T2D2", "B31", "B21", "B33", "R2D2", "RB3D2", "RB2D2"], &["T3D3", "T2D3", "B32", "B22"]];

impl Role {
    /// The role of the element type called `name`, in capitals. Letters behind the number of nodes tell how it is
    /// integrated (R, I, H, M, T ..) and change nothing here.
    pub(super) fn of(name: &str) -> Role {
        // DC3D8 conducts heat on the same nodes
        let solid = name.strip_prefix('D').unwrap_or(name).strip_prefix("C3D");
        if let Some(nodes) = solid.map(leading_number) {
            return match nodes {
                4 => Role::Cell(CellKind::Tet4),
                8 => Role::Cell(CellKind::Hex8),
                10 => Role::Cell(CellKind::Tet10),
                20 => Role::Cell(CellKind::Hex20),
                27 => Role::Refused("a hexahedron with 27 nodes", ORDER),
                6 => Role::Cell(CellKind::Wedge6),
                15 => Role::Cell(CellKind::Wedge15),
                18 => Role::Refused("a wedge with 18 nodes", ORDER),
                5 | 13 => Role::Refused("a pyramid", SHAPE),
                _ => Role::Refused("an unknown solid", SHAPE),
            };
        }
        if let Some(longer) = LINES.iter().position(|list| list.iter().any(|begin| name.starts_with(begin))) {
            return Role::Nodes(2 + longer);
        }
        let face = FACES.iter().find_map(|family| name.strip_prefix(family));
        match face.map(leading_number) {
            Some(nodes @ (3 | 4 | 6 | 8)) => Role::Face(nodes),
            Some(65) => Role::Face(6), // STRI65: six nodes, five degrees of freedom each
            Some(9) => Role::Refused("a face with nine nodes", ORDER),
            _ => Role::Skipped,
        }
    }

    /// Nodes of an element that is kept.
    pub(super) fn nodes(self) -> usize {
        match self {
            Role::Cell(kind) => kind.nodes(),
            Role::Face(nodes) | Role::Nodes(nodes) => nodes,
            Role::Refused(..) | Role::Skipped => 0,
        }
    }
}

/// The digits a text begins with; 0 if there are none.
fn leading_number(text: &str) -> usize {
    let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    text[..digits].parse().unwrap_or(0)
}

/// Local corners of the faces S1, S2, .. of a cell, as the CalculiX manual (section "*SURFACE") counts them.
pub(super) fn faces(kind: CellKind) -> &'static [&'static [usize]] {
    match kind.linear() {
        CellKind::Tet4 | CellKind::Tet10 => &[&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]],
        CellKind::Hex8 | CellKind::Hex20 => {
            &[&[0, 1, 2, 3], &[4, 7, 6, 5], &[0, 4, 5, 1], &[1, 5, 6, 2], &[2, 6, 7, 3], &[3, 7, 4, 0]]
        }
        CellKind::Wedge6 | CellKind::Wedge15 => &[&[0, 1, 2], &[3, 5, 4], &[0, 3, 4, 1], &[1, 4, 5, 2], &[2, 5, 3, 0]],
    }
}
