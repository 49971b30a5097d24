//! The outer surface of a mesh as flat triangles, in any position of its nodes: what a ray meets, and whether a point of
//! one body lies inside another.

use super::obstacle::unit;
use crate::mesh::v3::{V3, add, cross, det, dot, norm, scale, sub};
use crate::mesh::{Bounds, Face, Mesh, Tree};

/// Triangles that cover a face, by its local nodes.
const OF_TRIANGLE: &[[usize; 3]] = &[[0, 1, 2]];
const OF_QUADRILATERAL: &[[usize; 3]] = &[[0, 1, 2], [0, 2, 3]];
const OF_CURVED_TRIANGLE: &[[usize; 3]] = &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
const OF_CURVED_QUADRILATERAL: &[[usize; 3]] = &[[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 6], [4, 6, 7]];

/// Faces that bend by more meet at an edge, others stand for a smooth surface: eight faces, 45 degrees apart, are the
/// fewest by which anybody makes a cylinder. Radians.
const EDGE: f64 = 50.0 * std::f64::consts::PI / 180.0;
/// What a ray misses a triangle by, as a part of its size, where rounding may be all that parts them.
const GRAZING: f64 = 1e-9;

/// All boundary faces as triangles of nodes, which do not depend on where the nodes are.
pub(super) struct Outer {
    pub(super) triangles: Vec<[u32; 3]>,
    /// The face of each triangle.
    pub(super) face: Vec<u32>,
    /// The body of each triangle.
    pub(super) body: Vec<u32>,
    /// The first triangle of each face, and their number at the end.
    first: Vec<u32>,
}

impl Outer {
    /// `body` has a number for each node.
    pub(super) fn new(mesh: &Mesh, body: &[u32]) -> Outer {
        let (mut triangles, mut face, mut first) = (Vec::new(), Vec::new(), vec![0]);
        for (number, nodes) in (0..).zip(mesh.faces.iter().map(Face::nodes)) {
            let parts = match nodes.len() {
                3 => OF_TRIANGLE,
                4 => OF_QUADRILATERAL,
                6 => OF_CURVED_TRIANGLE,
                _ => OF_CURVED_QUADRILATERAL,
            };
            triangles.extend(parts.iter().map(|part| part.map(|i| nodes[i])));
            face.extend(parts.iter().map(|_| number));
            first.push(triangles.len() as u32);
        }
        let body = triangles.iter().map(|nodes| body[nodes[0] as usize]).collect();
        Outer { triangles, face, body, first }
    }

    /// The triangles of a face.
    pub(super) fn of_face(&self, face: u32) -> std::ops::Range<u32> {
        self.first[face as usize]..self.first[face as usize + 1]
    }
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hit {
    pub(super) triangle: u32,
    /// From the start of the ray; length.
    pub(super) distance: f64,
    /// Of the corners.
    pub(super) weights: [f64; 3],
}

/// The outer surface in one position.
pub(super) struct Skin<'a> {
    mesh: &'a Mesh,
    pub(super) outer: &'a Outer,
    /// Positions of the nodes, length.
    at: Vec<V3>,
    /// Unit normals outwards; zero for a triangle without area.
    pub(super) normal: Vec<V3>,
    pub(super) tree: Tree,
    /// Diagonal of the box around it, length.
    pub(super) size: f64,
}

impl<'a> Skin<'a> {
    /// With the nodes at `at`.
    pub(super) fn new(mesh: &'a Mesh, outer: &'a Outer, at: Vec<V3>) -> Skin<'a> {
        let corners = |nodes: &[u32; 3]| nodes.map(|node| at[node as usize]);
        let normal = |[a, b, c]: [V3; 3]| unit(cross(sub(b, a), sub(c, a))).unwrap_or([0.0; 3]);
        let normals = outer.triangles.iter().map(|nodes| normal(corners(nodes))).collect();
        let boxes: Vec<Bounds> = outer.triangles.iter().map(|nodes| Bounds::around(corners(nodes))).collect();
        let size = boxes.iter().fold(Bounds::around([]), |a, b| a.with(b)).diagonal();
        Skin { mesh, outer, normal: normals, tree: Tree::new(boxes), size, at }
    }

    pub(super) fn corners(&self, triangle: u32) -> [V3; 3] {
        self.outer.triangles[triangle as usize].map(|node| self.at[node as usize])
    }

    pub(super) fn point(&self, triangle: u32, weights: [f64; 3]) -> V3 {
        weighted(self.corners(triangle), weights)
    }

    /// Whether the faces of two triangles have a node in common.
    pub(super) fn adjacent(&self, a: u32, b: u32) -> bool {
        let nodes = |t: u32| self.mesh.faces[self.outer.face[t as usize] as usize].nodes();
        let of_b = nodes(b);
        nodes(a).iter().any(|node| of_b.contains(node))
    }

    /// Where the ray from `x` along the unit vector `way` meets triangle `t` within `length`.
    pub(super) fn hit(&self, t: u32, x: V3, way: V3, length: f64) -> Option<Hit> {
        let (distance, weights) = crossing(self.corners(t), x, way)?;
        let slack = GRAZING * length;
        (-slack <= distance && distance <= length + slack).then_some(Hit { triangle: t, distance, weights })
    }

    /// All hits within `length` but of triangles around triangle `from`, the nearest first.
    pub(super) fn hits(&self, from: u32, x: V3, way: V3, length: f64) -> Vec<Hit> {
        let candidates = self.tree.along(x, scale(length, way)).into_iter().filter(|&t| !self.adjacent(from, t));
        let mut hits: Vec<Hit> = candidates.filter_map(|t| self.hit(t, x, way, length)).collect();
        hits.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        hits
    }

    /// How far `x`, a point of triangle `from`, is from leaving `body` along the unit vector `way`; `None` outside of it:
    /// what a ray meets first of a closed surface tells the side it comes from. On an edge that bounds both sides nothing
    /// is known.
    pub(super) fn way_out(&self, from: u32, x: V3, way: V3, body: u32) -> Option<f64> {
        let mut hits = self.hits(from, x, way, self.size);
        hits.retain(|hit| self.outer.body[hit.triangle as usize] == body);
        let first = hits.first()?.distance;
        let near = hits.iter().take_while(|hit| hit.distance <= first + GRAZING * self.size);
        let leaves = |hit: &Hit| dot(self.normal[hit.triangle as usize], way) > 0.0;
        near.into_iter().all(leaves).then_some(first)
    }

    /// How far the smooth surface that the triangles stand for may be off triangle `t`: what it bends by to its neighbours,
    /// or these to theirs, for where a surface ends there is nothing to bend to.
    pub(super) fn sag(&self, t: u32) -> f64 {
        let around = Bounds::around(self.corners(t));
        let nodes = self.outer.triangles[t as usize];
        let beside = |other: &u32| {
            let common = self.outer.triangles[*other as usize].iter().filter(|node| nodes.contains(node)).count();
            common >= 2 && self.bend(t, *other) < EDGE
        };
        self.tree.meeting(&around).into_iter().filter(beside).map(|other| self.own_sag(other)).fold(0.0, f64::max)
    }

    /// The angle between the normals of two triangles, radians.
    fn bend(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|t| self.normal[t as usize]);
        norm(cross(a, b)).atan2(dot(a, b))
    }

    /// Across each edge, the rise of an arc over a chord as long as the triangle is high, with the curvature by which the
    /// two triangles bend.
    fn own_sag(&self, t: u32) -> f64 {
        let nodes = self.outer.triangles[t as usize];
        let mut sag = 0.0;
        for other in self.tree.meeting(&Bounds::around(self.corners(t))) {
            let theirs = self.outer.triangles[other as usize];
            let apex = |of: [u32; 3], not: [u32; 3]| of.into_iter().filter(|n| !not.contains(n)).collect::<Vec<u32>>();
            let ([own], [across]) = (&apex(nodes, theirs)[..], &apex(theirs, nodes)[..]) else { continue };
            let edge: Vec<u32> = nodes.into_iter().filter(|node| node != own).collect();
            let [a, b] = [edge[0], edge[1]].map(|node| self.at[node as usize]);
            let height = |node: u32| off_line(self.at[node as usize], a, b);
            let (own, across) = (height(*own), height(*across));
            let bend = self.bend(t, other);
            if bend < EDGE && own > 0.0 {
                // The middles of the triangles are a third of their heights off the edge.
                sag += 3.0 * bend / (own + across) * own * own / 8.0;
            }
        }
        sag
    }
}

/// The point with these weights of the corners.
pub(super) fn weighted([a, b, c]: [V3; 3], [u, v, w]: [f64; 3]) -> V3 {
    add(scale(u, a), add(scale(v, b), scale(w, c)))
}

/// Where the line from `x` along `way` crosses a triangle, its border included: how many times `way` from `x`, and the
/// weights of the corners (Möller & Trumbore 1997). `None` beside it, and where the line runs within its plane.
pub(super) fn crossing(corners: [V3; 3], x: V3, way: V3) -> Option<(f64, [f64; 3])> {
    let [a, b, c] = corners.map(|corner| sub(corner, x));
    let (first, second) = (sub(b, a), sub(c, a));
    let turned = cross(first, second);
    let volume = dot(turned, way);
    if volume.abs() <= GRAZING * norm(turned) * norm(way) {
        return None;
    }
    let [u, v, w] = [det([way, b, c]), det([way, c, a]), det([way, a, b])].map(|part| part / volume);
    (u.min(v).min(w) >= -GRAZING).then(|| (dot(turned, a) / volume, [u, v, w]))
}

/// Distance of `x` from the line through `a` and `b`.
fn off_line(x: V3, a: V3, b: V3) -> f64 {
    let (along, from) = (sub(b, a), sub(x, a));
    let length = norm(along);
    if length > 0.0 { norm(cross(along, from)) / length } else { norm(from) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Block, BlockElement, Ring, block, bodies, ring};

    #[test]
    fn a_line_through_a_point_of_a_triangle_crosses_it_there_and_one_beside_it_does_not() {
        let corners = [[0.3, -0.2, 1.0], [1.4, 0.1, 0.7], [0.2, 1.1, 1.3]];
        let (x, weights) = ([-0.4, 0.6, 2.5], [0.2, 0.5, 0.3]);
        let to = weighted(corners, weights);
        let (t, found) = crossing(corners, x, scale(0.25, sub(to, x))).unwrap();
        assert!((t - 4.0).abs() < 1e-13 && (0..3).all(|i| (found[i] - weights[i]).abs() < 1e-14), "{t} {found:?}");
        let beside = weighted(corners, [-0.01, 0.51, 0.5]);
        assert_eq!(crossing(corners, x, sub(beside, x)), None);
        assert_eq!(crossing(corners, to, sub(corners[1], corners[0])), None);
    }

    #[test]
    fn a_ray_tells_inside_from_outside_on_meshes_of_every_kind_of_cell() {
        for element in [BlockElement::Tet4Six, BlockElement::Hex8, BlockElement::Tet10Six, BlockElement::Hex20] {
            let one = Block { size: [2.0, 2.0, 3.0], cells: [2, 2, 3], origin: [0.0; 3], grading: [1.0; 3], element };
            let mesh = block(&one).unwrap();
            let outer = Outer::new(&mesh, &bodies(&mesh));
            let skin = Skin::new(&mesh, &outer, mesh.nodes.clone());
            // A triangle of the bottom, whose neighbours a ray upwards does not meet.
            let bottom = (0..outer.triangles.len() as u32).find(|&t| skin.normal[t as usize][2] < -0.5).unwrap();
            let up = [0.0, 0.0, 1.0];
            assert_eq!(skin.way_out(bottom, [1.1, 0.7, 1.0], up, 0), Some(2.0), "{element:?}");
            // From above and from beside.
            for outside in [[1.1, 0.7, 3.5], [2.5, 0.7, 1.0]] {
                assert_eq!(skin.way_out(bottom, outside, up, 0), None);
            }
        }
    }

    /// On a cylinder of radius 1 the faces of a ring rise over their chords by `1 - cos`, and no less is allowed for.
    #[test]
    fn sag_covers_the_rise_of_an_arc_and_is_none_on_flat_sides() {
        for element in [BlockElement::Tet4Six, BlockElement::Hex8] {
            let (cells, grading) = ([2, 6, 2], [1.0; 3]);
            let mesh = ring(&Ring { radii: [0.5, 1.0], height: 0.3, degrees: 90.0, cells, grading, element }).unwrap();
            let all = Outer::new(&mesh, &bodies(&mesh));
            let skin = Skin::new(&mesh, &all, mesh.nodes.clone());
            let rise = 1.0 - (7.5f64).to_radians().cos();
            let (mut round, mut flat) = (0, 0);
            for t in 0..all.triangles.len() as u32 {
                let corners = skin.corners(t);
                let sag = skin.sag(t);
                if corners.iter().all(|x| (x[0].hypot(x[1]) - 1.0).abs() < 1e-12) {
                    round += 1;
                    assert!((rise..4.0 * rise).contains(&sag), "{sag} for {rise}");
                } else if corners.iter().all(|x| x[2].abs() < 1e-12) {
                    flat += 1;
                    assert!(sag < 1e-14);
                }
            }
            assert!(round > 10 && flat > 10);
        }
    }
}
