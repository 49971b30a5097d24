//! How well shaped a cell is.

use super::CellKind;
use super::geometry::{GAUSS, HEX_CORNERS, HexEdges, corners, tet_jacobian};
use super::shape::{HEX20, HEX20_NODES, Reference, TET10, TET10_NODES, WEDGE6, WEDGE6_NODES, WEDGE15, WEDGE15_NODES};
use super::v3::{V3, det, dot, norm, sub};

/// Quality of a cell: 1 at best, 0 where flat, negative where inverted, NaN where all its nodes coincide.
///
/// Tetrahedron: `6 sqrt(2) V / l³` with the root mean square `l` of its six edges, 1 for the regular one
/// (Parthasarathy, Graichen, Hathaway 1994, measure gamma). Hexahedron: the scaled Jacobian, the least
/// determinant of the three unit edge vectors at the eight corners, 1 for a box (Knupp 2000, without the centre).
///
/// Quadratic tetrahedron: that of the straight one on its corners times the least Jacobian determinant over the greatest
/// at its nodes and integration points, which is 1 for straight edges with nodes in their middles. Quadratic
/// hexahedron: the least scaled Jacobian at its nodes and integration points.
///
/// Wedge: the least value at its nodes, for the quadratic one at its integration points as well, of the Jacobian
/// determinant over the length along the wedge and the two longer sides of the triangle there, which leaves the sine of
/// its least angle; 1 for a right prism on an equilateral triangle.
pub fn quality(nodes: &[[f64; 3]], kind: CellKind, cell: &[u32]) -> f64 {
    match kind {
        CellKind::Tet4 => tet_quality(&corners(nodes, cell)),
        CellKind::Hex8 => least(&corners(nodes, cell), &[1.0]),
        CellKind::Tet10 => {
            let x: [V3; 10] = corners(nodes, cell);
            let [low, high] = determinants(TET10_NODES.iter().chain(&*TET10), &x, |_| 1.0);
            tet_quality(&corners(nodes, cell)).abs() * low / high.abs()
        }
        CellKind::Hex20 => {
            let points = || HEX20_NODES.iter().chain(&*HEX20);
            let scaled = |[a, b, c]: [V3; 3]| norm(a) * norm(b) * norm(c);
            determinants(points(), &corners(nodes, cell), scaled)[0]
        }
        CellKind::Wedge6 => determinants(WEDGE6_NODES.iter(), &corners(nodes, cell), wedge_unit)[0],
        CellKind::Wedge15 => {
            let points = WEDGE15_NODES.iter().chain(&*WEDGE15);
            determinants(points, &corners(nodes, cell), wedge_unit)[0]
        }
    }
}

/// Least and greatest Jacobian determinant at the points, each divided by `unit` of its columns; NaN wins.
fn determinants<'a, const N: usize>(
    points: impl Iterator<Item = &'a Reference<N>>,
    x: &[V3; N],
    unit: impl Fn([V3; 3]) -> f64,
) -> [f64; 2] {
    let values = points.map(|at| {
        let columns = at.jacobian(x);
        det(columns) / unit(columns)
    });
    let keep = |a: f64, b: f64, b_wins: bool| if a.is_nan() || !(b_wins || b.is_nan()) { a } else { b };
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [keep(low, v, v < low), keep(high, v, v > high)])
}

/// The least scaled Jacobian a computation meets: as [`quality`], for linear hexahedra and wedges also at their Gauss
/// points.
pub(super) fn validity(nodes: &[V3], kind: CellKind, cell: &[u32]) -> f64 {
    match kind {
        CellKind::Tet4 => tet_quality(&corners(nodes, cell)),
        CellKind::Hex8 => least(&corners(nodes, cell), &[1.0, GAUSS]),
        CellKind::Wedge6 => {
            let points = WEDGE6_NODES.iter().chain(&*WEDGE6);
            determinants(points, &corners(nodes, cell), wedge_unit)[0]
        }
        CellKind::Tet10 | CellKind::Hex20 | CellKind::Wedge15 => quality(nodes, kind, cell),
    }
}

/// The determinant of a right prism on an equilateral triangle with the length along the wedge and the two longer sides
/// of the triangle that these columns of a Jacobian have.
fn wedge_unit([a, b, c]: [V3; 3]) -> f64 {
    let [a, b, third] = [norm(a), norm(b), norm(sub(a, b))];
    let longest = (a * b).max(a * third).max(b * third);
    0.75f64.sqrt() * longest * norm(c)
}

fn tet_quality(x: &[V3; 4]) -> f64 {
    let [a, b, c] = tet_jacobian(x);
    let edges = [a, b, c, sub(x[2], x[1]), sub(x[3], x[2]), sub(x[1], x[3])];
    let rms = (edges.iter().map(|&e| dot(e, e)).sum::<f64>() / 6.0).sqrt();
    std::f64::consts::SQRT_2 * det([a, b, c]) / (rms * rms * rms)
}

/// Least scaled Jacobian over the corners of the reference cube shrunk by each of `shrink`; NaN wins.
fn least(x: &[V3; 8], shrink: &[f64]) -> f64 {
    let edges = HexEdges::new(x);
    let mut least = f64::INFINITY;
    for s in shrink {
        for corner in &HEX_CORNERS {
            let [a, b, c] = edges.jacobian(corner.map(|v| v * s));
            let scaled = det([a, b, c]) / (norm(a) * norm(b) * norm(c));
            if scaled.is_nan() || scaled < least {
                least = scaled;
            }
            if least.is_nan() {
                return least;
            }
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_regular_tetrahedron_and_the_cube_are_perfect() {
        let tet = [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]];
        assert!((quality(&tet, CellKind::Tet4, &[0, 1, 2, 3]).abs() - 1.0).abs() < 1e-15);
        let hex: Vec<u32> = (0..8).collect();
        assert!((quality(&HEX_CORNERS, CellKind::Hex8, &hex) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_right_prism_on_an_equilateral_triangle_is_perfect_and_one_on_half_a_square_has_the_sine_of_45_degrees() {
        let prism = |third: [f64; 2]| [-1.0, 1.0].map(|z| [[0.0, 0.0, z], [1.0, 0.0, z], [third[0], third[1], z]]);
        let cell = [0, 1, 2, 3, 4, 5];
        let perfect = prism([0.5, 0.75f64.sqrt()]);
        assert!((quality(perfect.as_flattened(), CellKind::Wedge6, &cell) - 1.0).abs() < 1e-15);
        let half = prism([0.0, 1.0]);
        let found = quality(half.as_flattened(), CellKind::Wedge6, &cell);
        assert!((found - 0.5f64.sqrt() / 0.75f64.sqrt()).abs() < 1e-15);
        assert!((quality(half.as_flattened(), CellKind::Wedge6, &[3, 4, 5, 0, 1, 2]) + found).abs() < 1e-15);
    }

    #[test]
    fn a_sheared_cube_has_the_sine_of_its_angle() {
        // edges (1,0,0), (1,1,0), (0,0,1): the determinant of the unit vectors is sin 45°
        let sheared = HEX_CORNERS.map(|[x, y, z]| [x + y, y, z]);
        let hex: Vec<u32> = (0..8).collect();
        assert!((quality(&sheared, CellKind::Hex8, &hex) - 0.5f64.sqrt()).abs() < 1e-15);
    }
}
