use rustc_hash::FxHashMap;

use super::obstacle::unit;
use crate::fem::{DofMap, direction, normal_sums};
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, dot, norm, scale, sub};

/// Nodes this part of a face's size off a plane lie in it.
const IN_PLANE: f64 = 1e-6;
/// Across a plane of symmetry a smooth surface turns as much as between its next nodes; averaged normals know that
/// to a factor.
const SMOOTH: f64 = 3.0;

/// Directions the square of whose cosine is nearer to one are the same.
const SAME: f64 = 1e-6;

/// What is known of a node that may lie on a plane of symmetry.
#[derive(Default, Clone, Copy)]
struct Edge {
    /// How far the faces reach to both sides, and how large they are; length.
    low: f64,
    high: f64,
    /// Whether an edge of a face lies in the plane.
    edge: bool,
    /// Largest change of the normal to a neighbour.
    bend: f64,
}

/// The outward normal of each node of the faces, ascending, averaged over the faces.
///
/// Half of the faces around a node on a plane of symmetry are not there: where the surface goes on smoothly beyond the
/// plane its normal lies in the plane. Such a plane is recognised by displacements prescribed to be zero across it. A face
/// that does not count for a node (the arguments of `counts`) has no part in its normal.
pub(super) fn normals(mesh: &Mesh, faces: &[u32], dofs: &DofMap, counts: &dyn Fn(u32, u32) -> bool) -> Vec<(u32, V3)> {
    let mut normals = turned_together(normal_sums(mesh, faces, counts), dofs);
    let of: FxHashMap<u32, V3> = normals.iter().copied().collect();
    let across = planes(mesh, faces, dofs);
    let constrained = |node: u32, d: V3| still(dofs, node).map(|q| dot(q, d).powi(2)).sum::<f64>() > 1.0 - SAME;
    let mut edges: FxHashMap<u32, Vec<Edge>> = FxHashMap::default();
    for &face in faces {
        let nodes = mesh.faces[face as usize].nodes();
        for &node in nodes.iter().filter(|node| counts(face, **node)) {
            let Some(planes) = across.get(&node) else { continue };
            let entries = edges.entry(node).or_insert_with(|| vec![Edge::default(); planes.len()]);
            for (&plane, entry) in planes.iter().zip(entries) {
                for &other in nodes.iter().filter(|&&other| other != node) {
                    let d = sub(mesh.nodes[other as usize], mesh.nodes[node as usize]);
                    let away = dot(d, plane);
                    (entry.low, entry.high) = (entry.low.min(away), entry.high.max(away));
                    entry.edge |= away.abs() <= IN_PLANE * norm(d) && constrained(other, plane);
                    entry.bend = entry.bend.max(norm(sub(of[&other], of[&node])));
                }
            }
        }
    }
    for (node, normal) in &mut normals {
        let Some(edges) = edges.get(node) else { continue };
        for (&plane, edge) in across[node].iter().zip(edges) {
            let one_sided = edge.low.abs().min(edge.high) <= IN_PLANE * (edge.high - edge.low);
            let along = dot(*normal, plane);
            if edge.edge && one_sided && along.abs() <= SMOOTH * edge.bend {
                *normal = unit(sub(*normal, scale(along, plane))).unwrap_or(*normal);
            }
        }
    }
    normals
}

/// The normals of sums over faces. Those of a node and of one that follows it (cyclic symmetry) are of one surface that goes on
/// across the cut: both get that of all faces, each in its own directions.
fn turned_together(mut sums: Vec<(u32, V3, f64)>, dofs: &DofMap) -> Vec<(u32, V3)> {
    let place = |sums: &[(u32, V3, f64)], node: u32| sums.binary_search_by_key(&node, |entry| entry.0).ok();
    let mut cuts: Vec<(usize, usize, [V3; 3])> = (dofs.follows.iter())
        .filter_map(|(&node, followed)| Some((place(&sums, node)?, place(&sums, followed.node)?, followed.axes)))
        .collect();
    cuts.sort_unstable_by_key(|(follower, leader, _)| [*follower, *leader]);
    for &(follower, leader, axes) in &cuts {
        let (_, sum, size) = sums[follower];
        let there = (0..3).fold([0.0; 3], |there, c| add(there, scale(sum[c], axes[c])));
        sums[leader].1 = add(sums[leader].1, there);
        sums[leader].2 += size;
    }
    for &(follower, leader, axes) in &cuts {
        let (_, sum, size) = sums[leader];
        (sums[follower].1, sums[follower].2) = (axes.map(|axis| dot(sum, axis)), size);
    }
    sums.into_iter().map(|(node, sum, size)| (node, direction(sum, size))).collect()
}

/// The directions in which the displacement of a node is prescribed to be zero.
pub(crate) fn still(dofs: &DofMap, node: u32) -> impl Iterator<Item = V3> {
    let zero = |dof: &u32| dofs.prescribed.binary_search(dof).is_ok_and(|i| dofs.value[i] == 0.0);
    (3 * node..3 * node + 3).filter(zero).map(|dof| dofs.direction(dof))
}

/// The normals of the planes of symmetry each node may lie on. Of the axes of a turned node the first alone is sure to be
/// one; where slanted planes meet the nodes around it know the others.
fn planes(mesh: &Mesh, faces: &[u32], dofs: &DofMap) -> FxHashMap<u32, Vec<V3>> {
    let mut planes: FxHashMap<u32, Vec<V3>> = FxHashMap::default();
    for &face in faces {
        let nodes = mesh.faces[face as usize].nodes();
        for &node in nodes {
            let own: Vec<V3> = still(dofs, node).collect();
            if own.is_empty() || (planes.contains_key(&node) && dofs.axes(node).is_none()) {
                continue;
            }
            let known = planes.entry(node).or_default();
            if dofs.axes(node).is_none() {
                *known = own;
                continue;
            }
            for plane in std::iter::once(node).chain(nodes.iter().copied()).filter_map(|n| still(dofs, n).next()) {
                let within = own.iter().map(|q| dot(*q, plane).powi(2)).sum::<f64>() > 1.0 - SAME;
                if within && known.iter().all(|other| dot(*other, plane).powi(2) < 1.0 - SAME) {
                    known.push(plane);
                }
            }
        }
    }
    planes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Field, Fix, dof_map};
    use crate::mesh::{Block, BlockElement, block};

    /// The top of a block, bent by `height`, with `u_x = 0` at `x = 0`.
    fn top(height: impl Fn(f64) -> f64) -> Vec<(f64, V3)> {
        let element = BlockElement::Hex8;
        let mut mesh =
            block(&Block { size: [1.0; 3], cells: [8, 2, 1], origin: [0.0; 3], grading: [1.0; 3], element }).unwrap();
        mesh.nodes.iter_mut().for_each(|x| x[2] *= height(x[0]));
        let wall = mesh.face_nodes(&mesh.group("x-min").unwrap().faces);
        let fix = Fix { nodes: wall, value: [Some(Field::Constant(0.0)), None, None], ..Fix::default() };
        let dofs = dof_map(&mesh, &[fix], 1.0).unwrap();
        let normals = normals(&mesh, &mesh.group("z-max").unwrap().faces, &dofs, &|_, _| true);
        normals.into_iter().map(|(node, n)| (mesh.nodes[node as usize][0], n)).collect()
    }

    #[test]
    fn a_crest_on_a_plane_of_symmetry_has_its_normal_in_the_plane_and_an_incline_has_not() {
        for (x, n) in top(|x| 1.0 - 0.2 * x * x) {
            assert!((x > 0.0) == (n[0] > 1e-3), "{x} {n:?}");
        }
        assert!(top(|x| 1.0 - 0.2 * x).iter().all(|(_, n)| (n[0] - 0.2 / 1.04f64.sqrt()).abs() < 1e-14));
    }
}
