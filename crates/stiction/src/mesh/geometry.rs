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

/// The edges of a hexahedron along each reference axis. Along x they lie at `(y, z)` = (-, -), (+, -), (-, +),
/// (+, +), along y at `(x, z)`, along z at `(x, y)` in the same order.
pub(super) struct HexEdges([[Vec3; 4]; 3]);

impl HexEdges {
    pub fn new(x: &[Vec3; 8]) -> Self {
        const ALONG: [[[usize; 2]; 4]; 3] =
            [[[0, 1], [3, 2], [4, 5], [7, 6]], [[0, 3], [1, 2], [4, 7], [5, 6]], [[0, 4], [1, 5], [3, 7], [2, 6]]];
        let mut edges = [[[0.0; 3]; 4]; 3];
        for (edge, [from, to]) in edges.as_flattened_mut().iter_mut().zip(ALONG.as_flattened()) {
            *edge = sub(x[*to], x[*from]);
        }
        HexEdges(edges)
    }

    /// Columns of the Jacobian of the trilinear map at the reference point `(x, y, z)`; length per reference length.
    pub fn jacobian(&self, [x, y, z]: Vec3) -> [Vec3; 3] {
        let column = |edges: &[Vec3; 4], s: f64, t: f64| {
            let weights = [(1.0 - s) * (1.0 - t), (1.0 + s) * (1.0 - t), (1.0 - s) * (1.0 + t), (1.0 + s) * (1.0 + t)];
            let mut sum = [0.0; 3];
            for (weight, edge) in weights.iter().zip(edges) {
                for c in 0..3 {
                    sum[c] += 0.125 * weight * edge[c];
                }
            }
            sum
        };
        [column(&self.0[0], y, z), column(&self.0[1], x, z), column(&self.0[2], x, y)]
    }
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
            let edges = HexEdges::new(&corners(nodes, cell));
            let at = |c: &Vec3| {
                let [a, b, c] = edges.jacobian(c.map(|s| s * GAUSS));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_volume_of_a_truncated_pyramid_is_exact() {
        let x = HEX_CORNERS.map(|[x, y, z]| if z > 0.0 { [0.5 * x, 0.5 * y, z] } else { [x, y, z] });
        let cell: Vec<u32> = (0..8).collect();
        // height 2, areas 4 and 1: h / 3 (A + a + sqrt(A a))
        assert!((cell_volume(&x, CellKind::Hex8, &cell) - 14.0 / 3.0).abs() < 1e-14);
    }
}
