//! The measures of single cells and faces, and the mappings from reference cells.

use super::CellKind;
use super::shape::{HEX20, Reference, TET10, WEDGE6, WEDGE15, face_rule, face_shape};
use super::v3::{V3, add, cross, det, norm, scale, sub};

/// Signs of the reference coordinates of a hexahedron's corners, in the node order of [`CellKind::Hex8`].
pub(crate) const HEX_CORNERS: [V3; 8] = [
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
pub(crate) const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Columns of the Jacobian of the map from the unit tetrahedron, whose volume is 1/6: the edges from corner 0.
pub(crate) fn tet_jacobian(x: &[V3; 4]) -> [V3; 3] {
    [sub(x[1], x[0]), sub(x[2], x[0]), sub(x[3], x[0])]
}

/// The edges of a hexahedron along each reference axis. Along x they lie at `(y, z)` = (-, -), (+, -), (-, +),
/// (+, +), along y at `(x, z)`, along z at `(x, y)` in the same order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HexEdges(pub [[V3; 4]; 3]);

impl HexEdges {
    pub(crate) fn new(x: &[V3; 8]) -> Self {
        const ALONG: [[[usize; 2]; 4]; 3] =
            [[[0, 1], [3, 2], [4, 5], [7, 6]], [[0, 3], [1, 2], [4, 7], [5, 6]], [[0, 4], [1, 5], [3, 7], [2, 6]]];
        let mut edges = [[[0.0; 3]; 4]; 3];
        for (edge, [from, to]) in edges.as_flattened_mut().iter_mut().zip(ALONG.as_flattened()) {
            *edge = sub(x[*to], x[*from]);
        }
        HexEdges(edges)
    }

    /// Columns of the Jacobian of the trilinear map at the reference point `(x, y, z)`; length per reference length.
    pub(crate) fn jacobian(&self, [x, y, z]: V3) -> [V3; 3] {
        let column = |edges: &[V3; 4], s: f64, t: f64| {
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
#[inline]
pub(crate) fn corners<const N: usize>(nodes: &[V3], cell: &[u32]) -> [V3; N] {
    std::array::from_fn(|i| nodes[cell[i] as usize])
}

/// Volume of a cell; negative if it is inverted. Exact for each kind: the Jacobian determinant of the trilinear
/// hexahedron is quadratic in each reference coordinate, those of wedges and curved cells are no more than the rules take.
pub(crate) fn cell_volume(nodes: &[V3], kind: CellKind, cell: &[u32]) -> f64 {
    match kind {
        CellKind::Tet4 => {
            let x: [V3; 4] = corners(nodes, cell);
            det(tet_jacobian(&x)) / 6.0
        }
        CellKind::Hex8 => {
            let edges = HexEdges::new(&corners(nodes, cell));
            HEX_CORNERS.iter().map(|corner| det(edges.jacobian(corner.map(|s| s * GAUSS)))).sum()
        }
        CellKind::Tet10 => curved_volume(&*TET10, &corners(nodes, cell)),
        CellKind::Hex20 => curved_volume(&*HEX20, &corners(nodes, cell)),
        CellKind::Wedge6 => curved_volume(&*WEDGE6, &corners(nodes, cell)),
        CellKind::Wedge15 => curved_volume(&*WEDGE15, &corners(nodes, cell)),
    }
}

fn curved_volume<const N: usize>(rule: &[Reference<N>], x: &[V3; N]) -> f64 {
    rule.iter().map(|at| at.weight * det(at.jacobian(x))).sum()
}

/// The integral of the unit normal over a face with 3, 4, 6 or 8 nodes; area. Its length is the area of a plane face,
/// and what a warped or curved face shows to its mean normal.
pub(crate) fn vector_area(nodes: &[V3], face: &[u32]) -> V3 {
    let x = |i: usize| nodes[face[i] as usize];
    let twice = match face.len() {
        3 => cross(sub(x(1), x(0)), sub(x(2), x(0))),
        4 => cross(sub(x(2), x(0)), sub(x(3), x(1))),
        _ => return normals(nodes, face).fold([0.0; 3], add),
    };
    twice.map(|c| 0.5 * c)
}

/// Area of a quadratic face, by the rule of loads.
pub(crate) fn curved_area(nodes: &[V3], face: &[u32]) -> f64 {
    normals(nodes, face).map(norm).sum()
}

/// The normals at the points of the rule of a face, as long as the area the points stand for.
fn normals(nodes: &[V3], face: &[u32]) -> impl Iterator<Item = V3> {
    let x: Vec<V3> = face.iter().map(|&i| nodes[i as usize]).collect();
    let rule = face_rule(x.len()).into_iter();
    rule.map(move |(at, weight)| scale(weight, face_shape(x.len(), at).normal(&x)))
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
