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

/// The same for edges between triangles, whose corners would stand for nothing at zero. Half of the paper's part: on Hertz's
/// contact forces and pressures are twice as accurate (`docs/hertz.md`). A smaller part leaves corners of curved faces with
/// a negative integral.
const END_OF_TRIANGLES: f64 = 0.1;

/// A node of a contact surface. Its jump is `u_node + sum(weight u_other)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// The node the area belongs to.
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

/// The nodes of the boundary faces of a pair, ascending.
///
/// # Panics
/// If a face does not exist.
pub fn patches(mesh: &Mesh, faces: &[u32]) -> Vec<Patch> {
    with_part(mesh, faces, END)
}

/// The same of faces against an obstacle. Triangles too curved for their own part take that of quadrilaterals.
pub(super) fn patches_on_obstacle(mesh: &Mesh, faces: &[u32]) -> Vec<Patch> {
    let patches = with_part(mesh, faces, END_OF_TRIANGLES);
    if patches.iter().all(|patch| patch.area > 0.0) { patches } else { with_part(mesh, faces, END) }
}

/// The same with `part` for edges between triangles.
fn with_part(mesh: &Mesh, faces: &[u32], part_of_triangles: f64) -> Vec<Patch> {
    let empty = |node: u32| Patch { node, area: 0.0, others: Vec::new() };
    let mut patches: Vec<Patch> = mesh.face_nodes(faces).into_iter().map(empty).collect();
    let place = |patches: &[Patch], node: u32| patches.partition_point(|patch| patch.node < node);
    for &face in faces {
        let nodes = mesh.faces[face as usize].nodes();
        let part = if nodes.len() == 6 { part_of_triangles } else { END };
        for (i, &node) in nodes.iter().enumerate() {
            let Some(ends) = ends(nodes.len(), i) else { continue };
            let at = place(&patches, node);
            // Between a triangle and a quadrilateral the larger part.
            if patches[at].others.first().is_none_or(|other| -other.1 < part) {
                patches[at].others = ends.map(|end| (nodes[end], -part)).into();
                patches[at].others.sort_unstable_by_key(|other| other.0);
            }
        }
    }
    for &face in faces {
        let nodes = mesh.faces[face as usize].nodes();
        let part = |i: usize| patches[place(&patches, nodes[i])].others.first().map_or(0.0, |other| -other.1);
        let parts: [f64; 8] = std::array::from_fn(|i| if i < nodes.len() { part(i) } else { 0.0 });
        let mut areas = [0.0; 8];
        for FacePoint { shape, area, .. } in face_points(&face_coordinates(mesh, face)) {
            let shape = positive(&shape, nodes.len(), &parts);
            areas.iter_mut().zip(shape).for_each(|(sum, s)| *sum += s * norm(area));
        }
        for (&node, area) in nodes.iter().zip(areas) {
            let at = place(&patches, node);
            patches[at].area += area;
        }
    }
    patches
}

/// The two ends of the edge in whose middle node `i` of a face with so many nodes is; none for a corner.
pub(super) fn ends(nodes: usize, i: usize) -> Option<[usize; 2]> {
    let corners = nodes / 2;
    (nodes > 4 && i >= corners).then(|| [i - corners, (i + 1) % corners])
}

/// The positive functions from the shape functions of a face with so many nodes; `parts` has that of each middle.
pub(super) fn positive(shape: &[f64; 8], nodes: usize, parts: &[f64; 8]) -> [f64; 8] {
    let mut positive = *shape;
    for (i, value) in shape[..nodes].iter().enumerate() {
        for end in ends(nodes, i).into_iter().flatten() {
            positive[end] += parts[i] * value;
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
        // A square has 1/20 of its area at corners and 1/3 at middles of edges, one triangle 2/3 of its part at corners.
        type Find = fn(&Mesh, &[u32]) -> Vec<Patch>;
        let cases: [(BlockElement, Find, f64); 4] = [
            (BlockElement::Tet10Six, patches, 2.0 / 15.0),
            (BlockElement::Hex20, patches, 0.05),
            (BlockElement::Tet10Six, patches_on_obstacle, 1.0 / 15.0),
            (BlockElement::Hex20, patches_on_obstacle, 0.05),
        ];
        for (element, find, corner) in cases {
            let mesh =
                block(&Block { size: [2.0; 3], cells: [1; 3], origin: [0.0; 3], grading: [1.0; 3], element }).unwrap();
            let face = mesh.group("z-min").unwrap().faces[0];
            let whole = mesh.face_area(face as usize);
            let patches = find(&mesh, &[face]);
            assert!((patches.iter().map(|p| p.share() * p.area).sum::<f64>() - whole).abs() < 1e-14);
            for p in patches {
                let part = if p.others.is_empty() { corner } else { 1.0 / 3.0 };
                assert!((p.area - part * whole).abs() < 1e-14, "{element:?} {p:?}");
            }
        }
    }
}
