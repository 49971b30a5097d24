//! Meshes as text, as other programs write them; shared by tests and benchmarks of readers.

use std::fmt::Write;

use stiction::mesh::{CellKind, Mesh};

/// Gmsh's type of a cell and the name in Abaqus.
fn names(kind: CellKind) -> (u8, &'static str) {
    match kind {
        CellKind::Tet4 => (4, "C3D4"),
        CellKind::Hex8 => (5, "C3D8"),
        CellKind::Tet10 => (11, "C3D10"),
        CellKind::Hex20 => (17, "C3D20"),
        CellKind::Wedge6 => (6, "C3D6"),
        CellKind::Wedge15 => (18, "C3D15"),
    }
}

/// As Gmsh writes it, in text.
pub fn msh(mesh: &Mesh) -> Vec<u8> {
    let (n, m) = (mesh.nodes.len(), mesh.cell_count());
    let (code, _) = names(mesh.cells[0].kind);
    let mut text = format!("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 {n} 1 {n}\n3 1 0 {n}\n");
    (1..=n).for_each(|i| put(&mut text, format_args!("{i}\n")));
    mesh.nodes.iter().for_each(|[x, y, z]| put(&mut text, format_args!("{x} {y} {z}\n")));
    put(&mut text, format_args!("$EndNodes\n$Elements\n1 {m} 1 {m}\n3 1 {code} {m}\n"));
    for (i, (_, cell)) in mesh.cell_iter().enumerate() {
        put(&mut text, format_args!("{}", i + 1));
        cell.iter().for_each(|node| put(&mut text, format_args!(" {}", node + 1)));
        text.push('\n');
    }
    text.push_str("$EndElements\n");
    text.into_bytes()
}

/// As an input of Abaqus, with the set `body`.
pub fn inp(mesh: &Mesh) -> Vec<u8> {
    let mut text = String::from("*NODE\n");
    for (i, [x, y, z]) in mesh.nodes.iter().enumerate() {
        put(&mut text, format_args!("{}, {x}, {y}, {z}\n", i + 1));
    }
    put(&mut text, format_args!("*ELEMENT, TYPE={}, ELSET=body\n", names(mesh.cells[0].kind).1));
    for (i, (_, cell)) in mesh.cell_iter().enumerate() {
        put(&mut text, format_args!("{}", i + 1));
        cell.iter().for_each(|node| put(&mut text, format_args!(", {}", node + 1)));
        text.push('\n');
    }
    text.into_bytes()
}

fn put(text: &mut String, what: std::fmt::Arguments) {
    text.write_fmt(what).unwrap_or(()); // a string takes everything
}
