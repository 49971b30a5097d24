use std::path::PathBuf;

use super::*;
use crate::mesh::{MeshNote, info};

mod data;
mod encodings;
mod files;
mod messages;
mod robustness;

const SUFFIXES: [&str; 4] = ["22-ascii", "22-binary", "41-ascii", "41-binary"];

fn path(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/meshes")).join(name)
}

/// One tetrahedron in MSH 2.2 with the given elements beside it.
fn tet22(count: usize, elements: &str) -> String {
    let nodes = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n9 0 0 1\n$EndNodes\n";
    format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{nodes}$Elements\n{count}\n{elements}$EndElements\n")
}
