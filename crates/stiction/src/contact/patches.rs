//! What nodes of contact surfaces stand for.
//!
//! On quadratic faces the integral of the function of a corner vanishes (triangles) or is negative (quadrilaterals), so
//! that a uniform pressure would pull there. Popp, Wohlmuth, Gee & Wall 2012 ("Dual quadratic mortar finite element
//! methods for 3D finite deformation contact", SIAM J. Sci. Comput. 34) give corners a part of the functions of the
//! middles of their edges: `φ_corner + END sum(φ_middle)` and `φ_middle` span the same displacements, with
//! `u_middle - END (u_corner + u_corner)` and `u_corner` as coefficients, and all integrals are positive. The dual
//! multipliers of these functions make contact a matter of the coefficients, one by one.

use crate::fem::{FacePoint, face_coordinates, face_points};
use crate::mesh::Mesh;
use crate::mesh::v3::norm;

/// Part of the function of the middle of an edge that each end of the edge gets: the paper's choice. Parallelograms need
/// more than 1/8, quadrilaterals whose Jacobian varies by a factor of nine just less than 1/5; a larger part smears
/// pressures over more nodes, and at 1/2 nothing would be left to the middle under a translation.
pub(super) const END: f64 = 0.2;

/// A node of a contact surface. Its jump is `u_node + sum(weight u_other)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    pub node: u32,
    /// Integral of its function over the faces, > 0; area. A pressure `p` gives it the force `p area`.
    pub area: f64,
    /// For the middle of an edge the ends with `-END`.
    pub others: Vec<(u32, f64)>,
}

impl Patch {
    /// Its jump under a unit translation. `share area` of all nodes add up to the area of the faces.
    pub fn share(&self) -> f64 {
        share(&self.others)
    }
}

pub(super) fn share(others: &[(u32, f64)]) -> f64 {
    1.0 + others.iter().map(|other| other.1).sum::<f64>()
}

/// The nodes of the boundary faces, ascending.
///
/// # Panics
/// If a face does not exist.
pub fn patches(mesh: &Mesh, faces: &[u32]) -> Vec<Patch> {
    let empty = |node: u32| Patch { node, area: 0.0, others: Vec::new() };
    let mut patches: Vec<Patch> = mesh.face_nodes(faces).into_iter().map(empty).collect();
    for &face in faces {
        let nodes = mesh.faces[face as usize].nodes();
        let mut areas = [0.0; 8];
        for FacePoint { shape, area, .. } in face_points(&face_coordinates(mesh, face)) {
            areas.iter_mut().zip(positive(&shape, nodes.len())).for_each(|(sum, s)| *sum += s * norm(area));
        }
        for (i, &node) in nodes.iter().enumerate() {
            let place = patches.partition_point(|patch| patch.node < node);
            patches[place].area += areas[i];
            if let Some(ends) = ends(nodes.len(), i) {
                patches[place].others = ends.map(|end| (nodes[end], -END)).into();
                patches[place].others.sort_unstable_by_key(|other| other.0);
            }
        }
    }
    patches
}

/// The two ends of the edge in whose middle node `i` of a face with so many nodes is; none for a corner.
pub(super) fn ends(nodes: usize, i: usize) -> Option<[usize; 2]> {
    let corners = nodes / 2;
    (nodes > 4 && i >= corners).then(|| [i - corners, (i + 1) % corners])
}

/// The positive functions from the shape functions of a face with so many nodes.
pub(super) fn positive(shape: &[f64; 8], nodes: usize) -> [f64; 8] {
    let mut positive = *shape;
    for (i, value) in shape[..nodes].iter().enumerate() {
        for end in ends(nodes, i).into_iter().flatten() {
            positive[end] += END * value;
        }
    }
    positive
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Block, BlockElement, block};

    #[test]
    fn every_node_of_a_quadratic_face_stands_for_some_area_and_all_for_the_whole() {
        // One triangle has 2/15 of its area at corners and 1/3 at middles of edges, a square 1/20 and 1/3.
        for (element, corner, middle) in
            [(BlockElement::Tet10Six, 2.0 / 15.0, 1.0 / 3.0), (BlockElement::Hex20, 0.05, 1.0 / 3.0)]
        {
            let mesh =
                block(&Block { size: [2.0; 3], cells: [1; 3], origin: [0.0; 3], grading: [1.0; 3], element }).unwrap();
            let face = mesh.group("z-min").unwrap().faces[0];
            let whole = mesh.face_area(face as usize);
            let patches = patches(&mesh, &[face]);
            assert!((patches.iter().map(|p| p.share() * p.area).sum::<f64>() - whole).abs() < 1e-14);
            for p in patches {
                let part = if p.others.is_empty() { corner } else { middle };
                assert!((p.area - part * whole).abs() < 1e-14, "{element:?} {p:?}");
            }
        }
    }
}
