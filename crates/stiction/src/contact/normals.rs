use std::collections::HashMap;

use super::obstacle::unit;
use crate::fem::{DofMap, nodal_normals};
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, norm, sub};

/// Nodes this part of a face's size off a plane lie in it.
const IN_PLANE: f64 = 1e-6;
/// Across a plane of symmetry a smooth surface turns as much as between its next nodes; averaged normals know that
/// to a factor.
const SMOOTH: f64 = 3.0;

/// What is known of a node that may lie on a plane of symmetry across an axis.
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
/// plane its normal lies in the plane. Such a plane is recognised by displacements prescribed to be zero across it.
pub(super) fn normals(mesh: &Mesh, faces: &[u32], dofs: &DofMap) -> Vec<(u32, V3)> {
    let mut normals = nodal_normals(mesh, faces);
    let of: HashMap<u32, V3> = normals.iter().copied().collect();
    let held = |node: u32, c: usize| {
        let place = dofs.prescribed.binary_search(&(3 * node + c as u32));
        place.is_ok_and(|i| dofs.value[i] == 0.0)
    };
    let mut edges: HashMap<(u32, usize), Edge> = HashMap::new();
    for &face in faces {
        let nodes = mesh.faces[face as usize].nodes();
        for &node in nodes {
            for c in (0..3).filter(|&c| held(node, c)) {
                let entry = edges.entry((node, c)).or_default();
                for &other in nodes.iter().filter(|&&other| other != node) {
                    let d = sub(mesh.nodes[other as usize], mesh.nodes[node as usize]);
                    (entry.low, entry.high) = (entry.low.min(d[c]), entry.high.max(d[c]));
                    entry.edge |= d[c].abs() <= IN_PLANE * norm(d) && held(other, c);
                    entry.bend = entry.bend.max(norm(sub(of[&other], of[&node])));
                }
            }
        }
    }
    for (node, normal) in &mut normals {
        for c in 0..3 {
            let Some(edge) = edges.get(&(*node, c)) else { continue };
            let one_sided = edge.low.abs().min(edge.high) <= IN_PLANE * (edge.high - edge.low);
            if edge.edge && one_sided && normal[c].abs() <= SMOOTH * edge.bend {
                let mut within = *normal;
                within[c] = 0.0;
                *normal = unit(within).unwrap_or(*normal);
            }
        }
    }
    normals
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
        let fix = Fix { nodes: wall, value: [Some(Field::Constant(0.0)), None, None] };
        let dofs = dof_map(&mesh, &[fix], 1.0).unwrap();
        let normals = normals(&mesh, &mesh.group("z-max").unwrap().faces, &dofs);
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
