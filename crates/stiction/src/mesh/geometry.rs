//! Vectors of three numbers and the measures of single cells and faces.

use super::CellKind;

pub(super) type Vec3 = [f64; 3];

pub(super) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// `a . (b x c)`.
pub(super) fn det(a: Vec3, b: Vec3, c: Vec3) -> f64 {
    dot(a, cross(b, c))
}

/// Signs of the reference coordinates of a hexahedron's corners, in the node order of [`CellKind::Hex8`].
pub(super) const HEX_CORNERS: [Vec3; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Distance of the two Gauss points of an interval of length 2 from its middle, `1/sqrt(3)`.
pub(super) const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Columns of the Jacobian of the trilinear map at the reference point `xi`; length per reference length.
pub(super) fn hex_jacobian(x: &[Vec3; 8], xi: Vec3) -> [Vec3; 3] {
    let mut columns = [[0.0; 3]; 3];
    for (corner, point) in HEX_CORNERS.iter().zip(x) {
        let h = [0, 1, 2].map(|a| 1.0 + corner[a] * xi[a]);
        let gradient =
            [0.125 * corner[0] * h[1] * h[2], 0.125 * corner[1] * h[0] * h[2], 0.125 * corner[2] * h[0] * h[1]];
        for (column, g) in columns.iter_mut().zip(gradient) {
            for (c, p) in column.iter_mut().zip(point) {
                *c += g * p;
            }
        }
    }
    columns
}

/// The corners of a cell, or of as many of its nodes as are asked for.
pub(super) fn corners<const N: usize>(nodes: &[Vec3], cell: &[u32]) -> [Vec3; N] {
    std::array::from_fn(|i| nodes[cell[i] as usize])
}

/// Volume of a cell; negative if it is inverted. Exact for the trilinear hexahedron, whose Jacobian determinant
/// is quadratic in each reference coordinate.
pub(super) fn cell_volume(nodes: &[Vec3], kind: CellKind, cell: &[u32]) -> f64 {
    match kind {
        CellKind::Tet4 => {
            let x: [Vec3; 4] = corners(nodes, cell);
            det(sub(x[1], x[0]), sub(x[2], x[0]), sub(x[3], x[0])) / 6.0
        }
        CellKind::Hex8 => {
            let x: [Vec3; 8] = corners(nodes, cell);
            let at = |c: &Vec3| {
                let [a, b, c] = hex_jacobian(&x, c.map(|s| s * GAUSS));
                det(a, b, c)
            };
            HEX_CORNERS.iter().map(at).sum()
        }
    }
}

/// The integral of the unit normal over a face with three or four corners; area. Its length is the area of a
/// plane face, and what a warped face shows to its mean normal.
pub(super) fn vector_area(nodes: &[Vec3], face: &[u32]) -> Vec3 {
    let x = |i: usize| nodes[face[i] as usize];
    let twice = match face.len() {
        3 => cross(sub(x(1), x(0)), sub(x(2), x(0))),
        _ => cross(sub(x(2), x(0)), sub(x(3), x(1))),
    };
    twice.map(|c| 0.5 * c)
}
