//! Hexahedra with 27 nodes and prisms with 18, read as those with 20 and 15: the nodes in the middles of faces and of the
//! cell are left out.
//!
//! The edges are the same, and so are the faces as far as neighbours and contact see them. This is what meshing with
//! `Mesh.SecondOrderIncomplete = 1` would have given, as long as nobody moved these nodes or hangs on them.

use std::collections::HashSet;

use super::contents::Contents;
use super::types::Role;
use crate::Error;
use crate::mesh::MeshNote;
use crate::mesh::v3::{V3, add, norm, scale, sub};

/// A node in the middle may lie this part of the longest edge of its cell off the place where the nodes that stay put it: on
/// doubly curved surfaces Gmsh puts it on the surface itself, which is nearer by far.
const OFF: f64 = 0.05;

/// A type of element of which some nodes are left out.
struct Complete {
    /// Gmsh's number of it.
    number: i64,
    name: &'static str,
    /// How many nodes stay.
    kept: usize,
    /// Corners of the quadrilaterals in the order of the nodes in their middles, and their edges by the place of the node in
    /// their middle (Gmsh reference manual, "Node ordering").
    faces: &'static [([usize; 4], [usize; 4])],
    /// Whether the last node is in the middle of the cell.
    has_centre: bool,
}

const COMPLETE: [Complete; 2] = [
    Complete {
        number: 12,
        name: "hexahedron",
        kept: 20,
        faces: &[
            ([0, 3, 2, 1], [9, 13, 11, 8]),
            ([0, 1, 5, 4], [8, 12, 16, 10]),
            ([0, 4, 7, 3], [10, 17, 15, 9]),
            ([1, 2, 6, 5], [11, 14, 18, 12]),
            ([2, 3, 7, 6], [13, 15, 19, 14]),
            ([4, 5, 6, 7], [16, 18, 19, 17]),
        ],
        has_centre: true,
    },
    Complete {
        number: 13,
        name: "prism",
        kept: 15,
        faces: &[([0, 1, 4, 3], [6, 10, 12, 8]), ([0, 2, 5, 3], [7, 11, 13, 8]), ([1, 2, 5, 4], [9, 11, 14, 10])],
        has_centre: false,
    },
];

fn complete(number: i64) -> Option<&'static Complete> {
    COMPLETE.iter().find(|kind| kind.number == number)
}

/// Makes sure that the nodes left out are no loss, and notes how many they are.
///
/// # Errors
/// One of them belongs to another cell that keeps it, or lies elsewhere.
pub(super) fn check(contents: &Contents, notes: &mut Vec<MeshNote>) -> Result<(), Error> {
    let cells = || contents.runs.iter().filter(|run| matches!(run.kind.role, Role::Cell(_)));
    let refuse = |element: u64, what: String| {
        Err(Error::new(format!("element {element}"), what, "mesh with Mesh.SecondOrderIncomplete = 1"))
    };
    let mut dropped: HashSet<u32> = HashSet::new();
    let mut counts = [0; COMPLETE.len()];
    for (run, kind) in cells().filter_map(|run| Some((run, complete(run.kind.number)?))) {
        for (i, nodes) in contents.nodes_of(run).enumerate() {
            let x: Vec<V3> = nodes.iter().map(|&node| contents.nodes[node as usize]).collect();
            let around = |corners: &[usize; 4]| [0, 1, 2, 3].map(|k| norm(sub(x[corners[k]], x[corners[(k + 1) % 4]])));
            let longest = kind.faces.iter().flat_map(|(corners, _)| around(corners)).fold(0.0, f64::max);
            let off = middles(kind, &x).into_iter().zip(&x[kind.kept..]).map(|(place, &x)| norm(sub(place, x)));
            let worst = off.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((k, off)) = worst.filter(|worst| worst.1 > OFF * longest) {
                let tag = contents.node_tags[nodes[kind.kept + k] as usize];
                let (name, kept) = (kind.name, kind.kept);
                let what = format!("its node {tag} lies {off:.3e} from where a {name} of {kept} nodes has that place");
                return refuse(contents.element_tags.get(run.first + i), what);
            }
            dropped.extend(&nodes[kind.kept..]);
        }
        let place = COMPLETE.iter().position(|other| other.number == kind.number).unwrap_or(0);
        counts[place] += run.count;
    }
    if counts == [0; COMPLETE.len()] {
        return Ok(());
    }
    for run in cells() {
        let kept = complete(run.kind.number).map_or(run.kind.nodes, |kind| kind.kept);
        for (i, nodes) in contents.nodes_of(run).enumerate() {
            if let Some(&node) = nodes[..kept].iter().find(|&node| dropped.contains(node)) {
                let tag = contents.node_tags[node as usize];
                let what = format!("its node {tag} is the middle of a face or of a cell with nodes there");
                return refuse(contents.element_tags.get(run.first + i), what);
            }
        }
    }
    let plural = |kind: &Complete| if kind.name == "prism" { "prisms of 18" } else { "hexahedra of 27" };
    let each = COMPLETE.iter().zip(counts).filter(|(_, count)| *count > 0);
    let each: Vec<String> = each.map(|(kind, n)| format!("{n} {} nodes", plural(kind))).collect();
    let kept: Vec<String> =
        COMPLETE.iter().zip(counts).filter(|(_, n)| *n > 0).map(|(kind, _)| kind.kept.to_string()).collect();
    let (count, each, kept) = (dropped.len(), each.join(" and "), kept.join(" and "));
    let what = format!("{count} nodes within the {each}, which become those of {kept}");
    notes.push(MeshNote::NotRead { what: vec![what] });
    Ok(())
}

/// Where the serendipity functions of the nodes that stay put the middles of faces and of the cell: a corner counts -1/4, the
/// middle of an edge 1/2 on a face and 1/4 in a hexahedron.
fn middles(kind: &Complete, x: &[V3]) -> Vec<V3> {
    let sum = |places: &[usize]| places.iter().fold([0.0; 3], |sum, &place| add(sum, x[place]));
    let place =
        |corners: &[usize], edges: &[usize], weight: f64| add(scale(-0.25, sum(corners)), scale(weight, sum(edges)));
    let mut middles: Vec<V3> = kind.faces.iter().map(|(corners, edges)| place(corners, edges, 0.5)).collect();
    if kind.has_centre {
        let all: Vec<usize> = (0..kind.kept).collect();
        middles.push(place(&all[..8], &all[8..], 0.25));
    }
    middles
}
