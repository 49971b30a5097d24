use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, cross, norm, scale, sub};

/// A point of a quadrature over a boundary face.
#[derive(Debug, Clone, Copy)]
pub(super) struct FacePoint {
    /// Values of the shape functions of the face; the last is zero on a triangle.
    pub shape: [f64; 4],
    pub position: V3,
    /// Outward normal times the area the point stands for.
    pub area: V3,
}

/// Quadrature over the face with corners `x`, counter-clockwise seen from outside.
///
/// Triangles: Radon's rule of seven points, exact to degree 5. Quadrilaterals: 3 x 3 Gauss points on the bilinear
/// surface, exact to degree 5 in each direction of the reference square.
pub(super) fn face_points(x: &[V3]) -> Vec<FacePoint> {
    if x.len() == 3 { triangle_points(x) } else { quadrilateral_points(x) }
}

fn triangle_points(x: &[V3]) -> Vec<FacePoint> {
    let area = scale(0.5, cross(sub(x[1], x[0]), sub(x[2], x[0])));
    let root = 15f64.sqrt();
    let third = 1.0 / 3.0;
    let mut rule = vec![([third; 3], 9.0 / 40.0)];
    for s in [-root, root] {
        let (near, weight) = ((6.0 + s) / 21.0, (155.0 + s) / 1200.0);
        for i in 0..3 {
            rule.push((std::array::from_fn(|k| if k == i { 1.0 - 2.0 * near } else { near }), weight));
        }
    }
    let at = |(b, weight): ([f64; 3], f64)| FacePoint {
        shape: [b[0], b[1], b[2], 0.0],
        position: add(add(scale(b[0], x[0]), scale(b[1], x[1])), scale(b[2], x[2])),
        area: scale(weight, area),
    };
    rule.into_iter().map(at).collect()
}

fn quadrilateral_points(x: &[V3]) -> Vec<FacePoint> {
    const SIGN: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let gauss = [(-0.6f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6f64.sqrt(), 5.0 / 9.0)];
    let mut points = Vec::with_capacity(9);
    for (eta, weight_eta) in gauss {
        for (xi, weight_xi) in gauss {
            let mut point = FacePoint { shape: [0.0; 4], position: [0.0; 3], area: [0.0; 3] };
            let (mut along_xi, mut along_eta) = ([0.0; 3], [0.0; 3]);
            for (i, [a, b]) in SIGN.into_iter().enumerate() {
                point.shape[i] = 0.25 * (1.0 + a * xi) * (1.0 + b * eta);
                point.position = add(point.position, scale(point.shape[i], x[i]));
                along_xi = add(along_xi, scale(0.25 * a * (1.0 + b * eta), x[i]));
                along_eta = add(along_eta, scale(0.25 * b * (1.0 + a * xi), x[i]));
            }
            point.area = scale(weight_xi * weight_eta, cross(along_xi, along_eta));
            points.push(point);
        }
    }
    points
}

/// Coordinates of the corners of boundary face number `face`.
pub(super) fn face_corners(mesh: &Mesh, face: u32) -> Vec<V3> {
    mesh.faces[face as usize].nodes().iter().map(|&i| mesh.nodes[i as usize]).collect()
}

/// For each node of the boundary faces `faces` (indices into `mesh.faces`) the area it stands for, the integral
/// of its shape function over them. Nodes ascend; the areas sum to the area of the faces.
///
/// # Panics
/// If a face does not exist.
pub fn nodal_areas(mesh: &Mesh, faces: &[u32]) -> Vec<(u32, f64)> {
    let sums = nodal_sums(mesh, faces, |point| [norm(point.area), 0.0, 0.0]);
    sums.into_iter().map(|(node, sum)| (node, sum[0])).collect()
}

/// For each node of the boundary faces `faces` the unit outward normal, averaged over the faces by the area the
/// node stands for; zero where the normals cancel. Nodes ascend.
///
/// # Panics
/// If a face does not exist.
pub fn nodal_normals(mesh: &Mesh, faces: &[u32]) -> Vec<(u32, V3)> {
    let areas = nodal_areas(mesh, faces);
    let sums = nodal_sums(mesh, faces, |point| point.area);
    let unit = |((node, sum), (_, area)): ((u32, V3), (u32, f64))| {
        let length = norm(sum);
        // What rounding leaves of normals that cancel is no direction.
        (node, if length > 1e-12 * area { scale(1.0 / length, sum) } else { [0.0; 3] })
    };
    sums.into_iter().zip(areas).map(unit).collect()
}

/// For each node of the faces the integral of its shape function times `density`; nodes ascend.
fn nodal_sums(mesh: &Mesh, faces: &[u32], density: impl Fn(&FacePoint) -> V3) -> Vec<(u32, V3)> {
    let mut nodes: Vec<u32> = faces.iter().flat_map(|&f| mesh.faces[f as usize].nodes()).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut sums: Vec<(u32, V3)> = nodes.iter().map(|&node| (node, [0.0; 3])).collect();
    for &face in faces {
        for point in face_points(&face_corners(mesh, face)) {
            let value = density(&point);
            for (&node, &shape) in mesh.faces[face as usize].nodes().iter().zip(&point.shape) {
                let sum = &mut sums[nodes.partition_point(|&other| other < node)].1;
                *sum = add(*sum, scale(shape, value));
            }
        }
    }
    sums
}
