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
pub struct TributaryArea {
    /// The node the area belongs to.
    pub node: u32,
    /// Integral of its function over the faces, > 0; area. A pressure `p` gives it the force `p area`.
    pub area: f64,
    /// For the middle of an edge the ends with `-END`.
    pub others: Vec<(u32, f64)>,
}

impl TributaryArea {
    /// Its jump under a unit translation. `unity_sum * area` of all nodes adds up to the area of the faces.
    pub fn unity_sum(&self) -> f64 {
        unity_sum(&self.others)
    }
}

pub(super) fn unity_sum(others: &[(u32, f64)]) -> f64 {
    1.0 + others.iter().map(|other| other.1).sum::<f64>()
}

/// The nodes of the boundary faces of a pair, ascending.
///
/// # Panics
/// If a face does not exist.
pub fn tributary_areas(mesh: &Mesh, faces: &[u32]) -> Vec<TributaryArea> {
    with_part(mesh, faces, END)
}

/// The same of faces against an obstacle. Triangles too curved for their own part take that of quadrilaterals.
pub(super) fn areas_on_obstacle(mesh: &Mesh, faces: &[u32]) -> Vec<TributaryArea> {
    let areas = with_part(mesh, faces, END_OF_TRIANGLES);
    if areas.iter().all(|area_of_node| area_of_node.area > 0.0) { areas } else { with_part(mesh, faces, END) }
}

/// The same with `part` for edges between triangles.
fn with_part(mesh: &Mesh, faces: &[u32], part_of_triangles: f64) -> Vec<TributaryArea> {
    let empty = |node: u32| TributaryArea { node, area: 0.0, others: Vec::new() };
    let mut areas: Vec<TributaryArea> = mesh.face_nodes(faces).into_iter().map(empty).collect();
    let place = |areas: &[TributaryArea], node: u32| areas.partition_point(|area_of_node| area_of_node.node < node);
    for &face in faces {
        let nodes = mesh.faces[face as usize].nodes();
        let part = if nodes.len() == 6 { part_of_triangles } else { END };
        for (i, &node) in nodes.iter().enumerate() {
            let Some(ends) = ends(nodes.len(), i) else { continue };
            let at = place(&areas, node);
            // Between a triangle and a quadrilateral the larger part.
            if areas[at].others.first().is_none_or(|other| -other.1 < part) {
                areas[at].others = ends.map(|end| (nodes[end], -part)).into();
                areas[at].others.sort_unstable_by_key(|other| other.0);
            }
        }
    }
    for &face in faces {
        let nodes = mesh.faces[face as usize].nodes();
        let part = |i: usize| areas[place(&areas, nodes[i])].others.first().map_or(0.0, |other| -other.1);
        let parts: [f64; 8] = std::array::from_fn(|i| if i < nodes.len() { part(i) } else { 0.0 });
        let mut of_nodes = [0.0; 8];
        for FacePoint { shape, area, .. } in face_points(&face_coordinates(mesh, face)) {
            let shape = positive(&shape, nodes.len(), &parts);
            of_nodes.iter_mut().zip(shape).for_each(|(sum, s)| *sum += s * norm(area));
        }
        for (&node, area) in nodes.iter().zip(of_nodes) {
            let at = place(&areas, node);
            areas[at].area += area;
        }
    }
    areas
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
        type Find = fn(&Mesh, &[u32]) -> Vec<TributaryArea>;
        let cases: [(BlockElement, Find, f64); 4] = [
            (BlockElement::Tet10Six, tributary_areas, 2.0 / 15.0),
            (BlockElement::Hex20, tributary_areas, 0.05),
            (BlockElement::Tet10Six, areas_on_obstacle, 1.0 / 15.0),
            (BlockElement::Hex20, areas_on_obstacle, 0.05),
        ];
        for (element, find, corner) in cases {
            let mesh =
                block(&Block { size: [2.0; 3], cells: [1; 3], origin: [0.0; 3], grading: [1.0; 3], element }).unwrap();
            let face = mesh.group("z-min").unwrap().faces[0];
            let whole = mesh.face_area(face as usize);
            let areas = find(&mesh, &[face]);
            assert!((areas.iter().map(|p| p.unity_sum() * p.area).sum::<f64>() - whole).abs() < 1e-14);
            for p in areas {
                let part = if p.others.is_empty() { corner } else { 1.0 / 3.0 };
                assert!((p.area - part * whole).abs() < 1e-14, "{element:?} {p:?}");
            }
        }
    }
}
