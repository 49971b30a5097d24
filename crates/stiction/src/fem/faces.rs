use crate::mesh::Mesh;
use crate::mesh::shape::{FACE_NODES, face_node, face_rule, face_shape};
use crate::mesh::v3::{V3, add, norm, scale};

/// A point of a quadrature over a boundary face.
#[derive(Debug, Clone, Copy)]
pub struct FacePoint {
    /// Values of the shape functions of the face; those beyond its nodes are zero.
    pub shape: [f64; FACE_NODES],
    /// Its place, length.
    pub position: V3,
    /// Outward normal times the area the point stands for.
    pub area: V3,
}

/// Quadrature over the face with nodes at `x` (3, 4, 6 or 8: corners counter-clockwise seen from outside, then the
/// middles of its edges).
///
/// Triangles: Radon's rule of seven points, exact to degree 5. Quadrilaterals: 3 x 3 Gauss points on the mapped
/// surface, exact to degree 5 in each direction of the reference square.
pub fn face_points(x: &[V3]) -> Vec<FacePoint> {
    let at = |(reference, weight): ([f64; 2], f64)| {
        let shape = face_shape(x.len(), reference);
        let position = x.iter().zip(shape.value).fold([0.0; 3], |sum, (&x, s)| add(sum, scale(s, x)));
        FacePoint { shape: shape.value, position, area: scale(weight, shape.normal(x)) }
    };
    face_rule(x.len()).into_iter().map(at).collect()
}

/// Coordinates of the nodes of boundary face number `face`.
///
/// # Panics
/// If the face does not exist.
pub fn face_coordinates(mesh: &Mesh, face: u32) -> Vec<V3> {
    mesh.faces[face as usize].nodes().iter().map(|&i| mesh.nodes[i as usize]).collect()
}

/// For each node of the boundary faces `faces` the unit outward normal, averaged over the faces by the area the
/// node stands for; zero where the normals cancel. Nodes ascend. On quadratic faces the normals of the curved faces at
/// the node are averaged.
///
/// # Panics
/// If a face does not exist.
pub fn nodal_normals(mesh: &Mesh, faces: &[u32]) -> Vec<(u32, V3)> {
    let unit = |(node, sum, size): (u32, V3, f64)| (node, direction(sum, size));
    normal_sums(mesh, faces, &|_, _| true).into_iter().map(unit).collect()
}

/// A vector of length one along a sum of normals whose lengths add up to `size`; zero where they cancel.
pub(crate) fn direction(sum: V3, size: f64) -> V3 {
    let length = norm(sum);
    // What rounding leaves of normals that cancel is no direction.
    if length > 1e-12 * size { scale(1.0 / length, sum) } else { [0.0; 3] }
}

/// The normals of the faces around each node, ascending, as long as their areas: their sum and the sum of their lengths, of
/// the faces that count for the node (the arguments of `counts`).
pub(crate) fn normal_sums(mesh: &Mesh, faces: &[u32], counts: &dyn Fn(u32, u32) -> bool) -> Vec<(u32, V3, f64)> {
    let mut sums: Vec<(u32, V3, f64)> = mesh.face_nodes(faces).into_iter().map(|node| (node, [0.0; 3], 0.0)).collect();
    for &face in faces {
        let (x, nodes) = (face_coordinates(mesh, face), mesh.faces[face as usize].nodes());
        let normals = if x.len() > 4 { normals_at_nodes(&x) } else { normals_around_nodes(&x) };
        for (&node, normal) in nodes.iter().zip(normals).filter(|(node, _)| counts(face, **node)) {
            let place = sums.partition_point(|entry| entry.0 < node);
            let (_, sum, size) = &mut sums[place];
            (*sum, *size) = (add(*sum, normal), *size + norm(normal));
        }
    }
    sums
}

/// The normal of a curved face at each of its nodes, as long as its area.
fn normals_at_nodes(x: &[V3]) -> Vec<V3> {
    let area: f64 = face_points(x).iter().map(|point| norm(point.area)).sum();
    let normal = |i: usize| {
        let normal = face_shape(x.len(), face_node(x.len(), i)).normal(x);
        scale(area / norm(normal).max(f64::MIN_POSITIVE), normal)
    };
    (0..x.len()).map(normal).collect()
}

/// The integral of shape function and normal for each node of a linear face.
fn normals_around_nodes(x: &[V3]) -> Vec<V3> {
    let mut sums = vec![[0.0; 3]; x.len()];
    for point in face_points(x) {
        sums.iter_mut().zip(point.shape).for_each(|(sum, s)| *sum = add(*sum, scale(s, point.area)));
    }
    sums
}
