//! Hexahedra with 27 nodes, read as those with 20: the seven nodes in the middles of faces and of the cell are left out.
//!
//! The edges are the same, and so are the faces as far as neighbours and contact see them. This is what meshing with
//! `Mesh.SecondOrderIncomplete = 1` would have given, as long as nobody moved these nodes or hangs on them.

use std::collections::HashSet;

use super::contents::Contents;
use super::types::Role;
use crate::Error;
use crate::mesh::MeshNote;
use crate::mesh::v3::{V3, add, norm, scale, sub};

/// Gmsh's number of the hexahedron with 27 nodes, and how many of them stay.
const HEX27: i64 = 12;
const KEPT: usize = 20;
/// A node in the middle may lie this part of the longest edge of its cell off the place where 20 nodes put it: on doubly
/// curved surfaces Gmsh puts it on the surface itself, which is nearer by far.
const OFF: f64 = 0.05;

/// Corners of the faces in the order of the nodes 21 to 26 (Gmsh reference manual, "Node ordering"), and their edges by the
/// place of the node in their middle.
const FACES: [([usize; 4], [usize; 4]); 6] = [
    ([0, 3, 2, 1], [9, 13, 11, 8]),
    ([0, 1, 5, 4], [8, 12, 16, 10]),
    ([0, 4, 7, 3], [10, 17, 15, 9]),
    ([1, 2, 6, 5], [11, 14, 18, 12]),
    ([2, 3, 7, 6], [13, 15, 19, 14]),
    ([4, 5, 6, 7], [16, 18, 19, 17]),
];

/// Makes sure that the nodes left out are no loss, and notes how many they are.
///
/// # Errors
/// One of them belongs to another cell, or lies elsewhere.
pub(super) fn check(contents: &Contents, notes: &mut Vec<MeshNote>) -> Result<(), Error> {
    let cells = || contents.runs.iter().filter(|run| matches!(run.kind.role, Role::Cell(_)));
    let refuse = |element: u64, what: String| {
        Err(Error::new(format!("element {element}"), what, "mesh with Mesh.SecondOrderIncomplete = 1"))
    };
    let mut dropped: HashSet<u32> = HashSet::new();
    let mut count = 0;
    for run in cells().filter(|run| run.kind.number == HEX27) {
        for (i, nodes) in contents.nodes_of(run).enumerate() {
            let x: Vec<V3> = nodes.iter().map(|&node| contents.nodes[node as usize]).collect();
            let longest =
                FACES.iter().flat_map(|(corners, _)| (0..4).map(|k| norm(sub(x[corners[k]], x[corners[(k + 1) % 4]]))));
            let longest = longest.fold(0.0, f64::max);
            let off = middles(&x).into_iter().zip(&x[KEPT..]).map(|(place, &x)| norm(sub(place, x)));
            let worst = off.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((k, off)) = worst.filter(|worst| worst.1 > OFF * longest) {
                let tag = contents.node_tags[nodes[KEPT + k] as usize];
                let what = format!("its node {tag} lies {off:.3e} from where a hexahedron of 20 nodes has that place");
                return refuse(contents.element_tags.get(run.first + i), what);
            }
            dropped.extend(&nodes[KEPT..]);
            count += 1;
        }
    }
    if count == 0 {
        return Ok(());
    }
    for run in cells() {
        let kept = if run.kind.number == HEX27 { KEPT } else { run.kind.nodes };
        for (i, nodes) in contents.nodes_of(run).enumerate() {
            if let Some(&node) = nodes[..kept].iter().find(|&node| dropped.contains(node)) {
                let tag = contents.node_tags[node as usize];
                let what = format!("its node {tag} is the middle of a face or of a hexahedron with 27 nodes");
                return refuse(contents.element_tags.get(run.first + i), what);
            }
        }
    }
    let what = format!("{} nodes within the {count} hexahedra of 27 nodes, which become those of 20", dropped.len());
    notes.push(MeshNote::NotRead { what: vec![what] });
    Ok(())
}

/// Where the serendipity functions of the 20 nodes put the middles of faces and of the cell: a corner counts -1/4, the middle
/// of an edge 1/2 on a face and 1/4 in the cell.
fn middles(x: &[V3]) -> [V3; 7] {
    let sum = |places: &[usize]| places.iter().fold([0.0; 3], |sum, &place| add(sum, x[place]));
    let place =
        |corners: &[usize], edges: &[usize], weight: f64| add(scale(-0.25, sum(corners)), scale(weight, sum(edges)));
    let all: Vec<usize> = (0..KEPT).collect();
    let whole = place(&all[..8], &all[8..], 0.25);
    std::array::from_fn(|k| FACES.get(k).map_or(whole, |(corners, edges)| place(corners, edges, 0.5)))
}
