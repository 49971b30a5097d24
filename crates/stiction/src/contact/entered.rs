//! Faces that an obstacle reaches into between their nodes. Contact with obstacles is that of nodes: what touches none of a
//! face's nodes meets no contact point, and its force is missing.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::Obstacle;
use super::skin::{Outer, Skin, weighted};
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, norm, scale, sub};

/// An obstacle that has got into a face by more than this part of the way is worth a word: where faces are curved, a face
/// may be entered by less.
const ENTERED: f64 = 0.05;
/// Facets of a curved body lie in the obstacle that it touches by up to the rise of their arcs, which is known to this factor.
const RISES: f64 = 2.0;
/// Samples lie off the border of their triangle by this weight: there a point of one face lies on others as well.
pub(super) const OFF_BORDER: f64 = 0.02;

/// The body's surface, and how its nodes have moved relative to the obstacle.
pub(super) struct Motion<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) outer: &'a Outer,
    /// Before anything has moved.
    pub(super) still: &'a Skin<'a>,
    /// Of each node; length.
    pub(super) way: &'a (dyn Fn(u32) -> V3 + Sync),
    /// Depths below it are rounding, length.
    pub(super) rounding: f64,
}

/// A place of a face that the obstacle reaches into.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Entered {
    /// A node of the face.
    pub(super) node: u32,
    /// A point of the undeformed body, length.
    pub(super) place: V3,
    /// Length, > 0.
    pub(super) depth: f64,
}

/// Where `obstacle` reaches into those of `faces` that lie beside no face with a node that touches it: beside contact a face is
/// entered by what its cells do not resolve.
pub(super) fn between_nodes(motion: &Motion, obstacle: &Obstacle, faces: &[u32]) -> Vec<Entered> {
    let Motion { mesh, outer, rounding, .. } = *motion;
    let nodes = mesh.face_nodes(faces);
    let at = |node: u32| add(mesh.nodes[node as usize], (motion.way)(node));
    // None beyond the border of an open surface.
    let distances: FxHashMap<u32, Option<f64>> =
        nodes.par_iter().map(|&node| (node, obstacle.distance(at(node)).map(|(distance, _)| distance))).collect();
    // Nodes in contact are kept out along the normals of where they were: on a curved surface they come off it by the second order.
    let touches =
        |node: &u32| distances[node].is_some_and(|distance| distance <= rounding + ENTERED * norm((motion.way)(*node)));
    let mut beside = vec![false; mesh.nodes.len()];
    for &face in faces {
        let nodes = mesh.faces[face as usize].nodes();
        if nodes.iter().any(touches) {
            nodes.iter().for_each(|&node| beside[node as usize] = true);
        }
    }
    let of_face = |&face: &u32| {
        let nodes = mesh.faces[face as usize].nodes();
        let far = nodes.iter().all(|node| distances[node].is_some());
        let near = nodes.iter().any(|node| beside[*node as usize]);
        let gap = nodes.iter().filter_map(|node| distances[node]).fold(f64::INFINITY, f64::min);
        let triangles = if near { 0..0 } else { outer.of_face(face) };
        triangles.flat_map(move |t| of_triangle(motion, obstacle, t, far.then_some(gap))).collect::<Vec<Entered>>()
    };
    faces.par_iter().flat_map_iter(of_face).collect()
}

/// The samples of triangle `t` that lie in the obstacle. The nodes of its face are farther than `gap` from it; without that, only
/// what has moved into the obstacle lies in it.
fn of_triangle(motion: &Motion, obstacle: &Obstacle, t: u32, gap: Option<f64>) -> Vec<Entered> {
    let Motion { mesh, outer, still, way, rounding } = *motion;
    let nodes = outer.triangles[t as usize];
    let ways = nodes.map(way);
    let corners: [V3; 3] = std::array::from_fn(|i| add(mesh.nodes[nodes[i] as usize], ways[i]));
    let longest = (0..3).map(|i| norm(sub(corners[(i + 1) % 3], corners[i]))).fold(0.0, f64::max);
    if gap.is_some_and(|gap| gap > longest) {
        return Vec::new(); // no point is farther from all corners
    }
    let edges = match obstacle {
        Obstacle::Surface(triangles) => triangles.sharp_edges_behind(corners, OFF_BORDER),
        _ => Vec::new(),
    };
    // Sharp edges are as deep as they lie behind the face, and elsewhere the obstacle as its surface is far.
    let points = samples().into_iter().map(|weights| (weights, 0.0)).chain(edges);
    let entered = |(weights, edge): ([f64; 3], f64)| {
        let (x, way) = (still.point(t, weights), weighted(ways, weights));
        let inside = -obstacle.distance(add(x, way))?.0;
        if inside <= rounding {
            return None;
        }
        let depth = inside.max(edge);
        let has_moved_in = comes_from_outside(obstacle, x, way, rounding);
        let part = if has_moved_in { ENTERED * norm(way) } else { 0.0 };
        let allowed = rounding + part + RISES * still.sag(t);
        let is_inside = has_moved_in || gap.is_some();
        (is_inside && depth > allowed).then_some(Entered { node: nodes[0], place: x, depth })
    };
    points.filter_map(entered).collect()
}

/// How deep a point that was outside of an obstacle at rest, or is kept outside by a contact point, lies in it after it has
/// moved by `way`.
pub(super) fn got_in(obstacle: &Obstacle, x: V3, way: V3, held: bool, rounding: f64) -> Option<f64> {
    let entered = held || comes_from_outside(obstacle, x, way, rounding);
    let depth = || obstacle.distance(add(x, way)).map(|(distance, _)| -distance);
    if entered { depth() } else { None }
}

/// Whether what moves from `x` by `way`, and lies in the obstacle then, was outside of it.
fn comes_from_outside(obstacle: &Obstacle, x: V3, way: V3, rounding: f64) -> bool {
    match obstacle {
        // Behind an open surface is not inside: the way there counts.
        Obstacle::Surface(triangles) => triangles.is_entered(x, way),
        _ => obstacle.distance(x).is_some_and(|(distance, _)| distance >= -rounding),
    }
}

/// Weights of the corners of a triangle: its centre, beside its corners, beside the middles of its edges.
fn samples() -> Vec<[f64; 3]> {
    let towards = |corner: V3| add(scale(1.0 - 3.0 * OFF_BORDER, corner), [OFF_BORDER; 3]);
    let unit = |k: usize| std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
    let middle = |k: usize| std::array::from_fn(|i| if i == k { 0.0 } else { 0.5 });
    let border = (0..3).flat_map(|k| [towards(unit(k)), towards(middle(k))]);
    [[1.0 / 3.0; 3]].into_iter().chain(border).collect()
}
