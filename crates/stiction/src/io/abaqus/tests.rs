use super::*;
use crate::mesh::{MeshNote, info};

mod decks;
mod messages;
mod robustness;

/// Two unit cubes side by side along x, with gaps in the numbers, and what follows them.
fn cubes(rest: &str) -> String {
    "*NODE, NSET=Nall
10,0,0,0
20,1.,0,0
30,1.,1.,0
40,0,1.,0
50,0,0,1.
60,1.,0,1.
70,1.,1.,1.
80,0,1.,1.
90,2.,0,0
100,2.,1.,0
110,2.,0,1.
120,2.,1.,1.
*ELEMENT, TYPE=C3D8, ELSET=Eall
7, 10,20,30,40,50,60,70,80
9, 20,90,100,30,60,110,120,70
"
    .to_string()
        + rest
}

fn nothing(_: &str) -> Result<Vec<u8>, String> {
    Err("there is none".into())
}

fn mesh_of(text: &str) -> (Mesh, MeshNotes) {
    parse(text.as_bytes(), "part.inp", 1.0, &nothing).unwrap_or_else(|e| panic!("{e}"))
}

/// Outward normal and centre of the faces of a group, each component in eighths, sorted.
fn sides(mesh: &Mesh, group: &str) -> Vec<[i32; 6]> {
    let face = |&f: &u32| {
        let nodes = mesh.faces[f as usize].nodes();
        let normal = mesh.face_normal(f as usize);
        let centre =
            [0, 1, 2].map(|c| nodes.iter().map(|&n| mesh.nodes[n as usize][c]).sum::<f64>() / nodes.len() as f64);
        [normal[0], normal[1], normal[2], centre[0], centre[1], centre[2]].map(|x| (8.0 * x).round() as i32)
    };
    let mut sides: Vec<[i32; 6]> =
        mesh.group(group).unwrap_or_else(|| panic!("{group}")).faces.iter().map(face).collect();
    sides.sort_unstable();
    sides
}

/// Coordinates of the nodes of a group.
fn points(mesh: &Mesh, group: &str) -> Vec<[f64; 3]> {
    let group = mesh.group(group).unwrap_or_else(|| panic!("{group}"));
    mesh.group_nodes(group).iter().map(|&n| mesh.nodes[n as usize]).collect()
}
