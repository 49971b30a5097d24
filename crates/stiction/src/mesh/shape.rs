//! Shape functions and quadrature of quadratic cells, of wedges, and of all kinds of faces.
//!
//! Reference cells: the tetrahedron `x, y, z >= 0, x + y + z <= 1`; the cube, and the square for faces, `[-1, 1]`; the
//! triangle `x, y >= 0, x + y <= 1`; the wedge, that triangle times `[-1, 1]`. Middles of edges follow the corners (Zienkiewicz & Taylor, "The Finite Element
//! Method", 2000, volume 1, chapter 8).

use std::sync::LazyLock;

use super::geometry::{GAUSS, HEX_CORNERS};
use super::v3::{V3, add, cross, scale};

/// Corners of the edges of a tetrahedron, in the order of the nodes in their middles.
pub(crate) const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Corners of the edges of a hexahedron, in the order of the nodes in their middles.
pub(crate) const HEX_EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

/// Corners of the edges of a wedge, in the order of the nodes in their middles.
pub(crate) const WEDGE_EDGES: [[usize; 2]; 9] =
    [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];

/// Corners of the reference wedge.
pub(crate) const WEDGE_CORNERS: [V3; 6] =
    [[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];

/// Shape functions of a cell with `N` nodes at a point of its reference cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reference<const N: usize> {
    pub shape: [f64; N],
    pub gradient: [V3; N],
    /// Reference volume the point stands for; zero if it is no point of a quadrature.
    pub weight: f64,
}

impl<const N: usize> Reference<N> {
    /// Columns of the Jacobian of the map to the cell with nodes at `x`; length per reference length.
    pub(crate) fn jacobian(&self, x: &[V3; N]) -> [V3; 3] {
        let mut columns = [[0.0; 3]; 3];
        for (x, g) in x.iter().zip(&self.gradient) {
            for (column, &g) in columns.iter_mut().zip(g) {
                *column = add(*column, scale(g, *x));
            }
        }
        columns
    }
}

fn tet10(x: V3, weight: f64) -> Reference<10> {
    let b = [1.0 - x[0] - x[1] - x[2], x[0], x[1], x[2]];
    let slope = [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut at = Reference { shape: [0.0; 10], gradient: [[0.0; 3]; 10], weight };
    for i in 0..4 {
        at.shape[i] = b[i] * (2.0 * b[i] - 1.0);
        at.gradient[i] = scale(4.0 * b[i] - 1.0, slope[i]);
    }
    for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
        at.shape[4 + k] = 4.0 * b[i] * b[j];
        at.gradient[4 + k] = add(scale(4.0 * b[j], slope[i]), scale(4.0 * b[i], slope[j]));
    }
    at
}

/// The serendipity hexahedron.
fn hex20(x: V3, weight: f64) -> Reference<20> {
    let mut at = Reference { shape: [0.0; 20], gradient: [[0.0; 3]; 20], weight };
    for (i, s) in HEX_CORNERS.iter().enumerate() {
        let f: V3 = std::array::from_fn(|c| 1.0 + s[c] * x[c]);
        let rest = s[0] * x[0] + s[1] * x[1] + s[2] * x[2] - 2.0;
        at.shape[i] = 0.125 * f[0] * f[1] * f[2] * rest;
        at.gradient[i] = std::array::from_fn(|c| 0.125 * s[c] * f[(c + 1) % 3] * f[(c + 2) % 3] * (rest + f[c]));
    }
    for (k, [i, j]) in HEX_EDGES.into_iter().enumerate() {
        let s: V3 = std::array::from_fn(|c| 0.5 * (HEX_CORNERS[i][c] + HEX_CORNERS[j][c]));
        // along its edge a bubble, across it linear
        let along = |c: usize| s[c] == 0.0;
        let f: V3 = std::array::from_fn(|c| if along(c) { 1.0 - x[c] * x[c] } else { 1.0 + s[c] * x[c] });
        let d: V3 = std::array::from_fn(|c| if along(c) { -2.0 * x[c] } else { s[c] });
        at.shape[8 + k] = 0.25 * f[0] * f[1] * f[2];
        at.gradient[8 + k] = std::array::from_fn(|c| 0.25 * d[c] * f[(c + 1) % 3] * f[(c + 2) % 3]);
    }
    at
}

/// Barycentric coordinates of the triangle at a point of the reference wedge, and their derivatives.
fn barycentric([x, y, _]: V3) -> ([f64; 3], [[f64; 2]; 3]) {
    ([1.0 - x - y, x, y], [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
}

/// The linear wedge.
fn wedge6(x: V3, weight: f64) -> Reference<6> {
    let (b, slope) = barycentric(x);
    let mut at = Reference { shape: [0.0; 6], gradient: [[0.0; 3]; 6], weight };
    for (i, corner) in WEDGE_CORNERS.iter().enumerate() {
        let (k, s) = (i % 3, corner[2]);
        let along = 0.5 * (1.0 + s * x[2]);
        at.shape[i] = b[k] * along;
        at.gradient[i] = [slope[k][0] * along, slope[k][1] * along, 0.5 * s * b[k]];
    }
    at
}

/// The serendipity wedge.
fn wedge15(x: V3, weight: f64) -> Reference<15> {
    let (b, slope) = barycentric(x);
    let z = x[2];
    let mut at = Reference { shape: [0.0; 15], gradient: [[0.0; 3]; 15], weight };
    for (i, corner) in WEDGE_CORNERS.iter().enumerate() {
        let (k, s) = (i % 3, corner[2]);
        let along = 1.0 + s * z;
        // b (2 b - 1) (1 + s z) / 2 less half of the bubble along z
        at.shape[i] = 0.5 * b[k] * along * (2.0 * b[k] - 2.0 + s * z);
        let of_b = 0.5 * along * (4.0 * b[k] - 2.0 + s * z);
        at.gradient[i] = [slope[k][0] * of_b, slope[k][1] * of_b, 0.5 * s * b[k] * (2.0 * b[k] - 1.0 + 2.0 * s * z)];
    }
    for (k, [i, j]) in WEDGE_EDGES.into_iter().enumerate() {
        let (a, c) = (i % 3, j % 3);
        (at.shape[6 + k], at.gradient[6 + k]) = if a == c {
            let bubble = 1.0 - z * z;
            (b[a] * bubble, [slope[a][0] * bubble, slope[a][1] * bubble, -2.0 * z * b[a]])
        } else {
            let s = WEDGE_CORNERS[i][2];
            let along = 2.0 * (1.0 + s * z);
            let across = |d: usize| along * (b[c] * slope[a][d] + b[a] * slope[c][d]);
            (b[a] * b[c] * along, [across(0), across(1), 2.0 * s * b[a] * b[c]])
        };
    }
    at
}

/// Three points of the triangle, exact to degree 2, at each of two Gauss points along the wedge: the volume, loads and
/// stiffness of straight wedges are exact. The two points of C3D6 in Abaqus and CalculiX leave the twist about the
/// axis of the wedge without stiffness.
pub(crate) static WEDGE6: LazyLock<[Reference<6>; 6]> = LazyLock::new(|| {
    std::array::from_fn(|q| {
        let [x, y] = [[1.0 / 6.0, 1.0 / 6.0], [2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0]][q % 3];
        wedge6([x, y, [-GAUSS, GAUSS][q / 3]], 1.0 / 6.0)
    })
});

/// Radon's seven points of the triangle, exact to degree 5, at each of three Gauss points along the wedge: volumes of
/// curved cells, loads and rigid motions are exact.
pub(crate) static WEDGE15: LazyLock<[Reference<15>; 21]> = LazyLock::new(|| {
    let triangle = face_rule(6);
    std::array::from_fn(|q| {
        let (([x, y], a), (z, b)) = (triangle[q % 7], GAUSS3[q / 7]);
        wedge15([x, y, z], a * b)
    })
});

/// Fourteen points with positive weights, exact to degree 5 (Walkington 2000, "Quadrature on simplices of arbitrary
/// dimension"): volumes of curved cells, loads and rigid motions are exact, and the stiffness has full rank.
pub(crate) static TET10: LazyLock<[Reference<10>; 14]> = LazyLock::new(|| {
    let inner =
        [(0.310_885_919_263_300_6, 0.112_687_925_718_015_86), (0.092_735_250_310_891_23, 0.073_493_043_116_361_96)];
    let mut rule: Vec<(V3, f64)> = Vec::with_capacity(14);
    for (a, weight) in inner {
        let b = 1.0 - 3.0 * a;
        rule.extend([[a, a, a], [b, a, a], [a, b, a], [a, a, b]].map(|x| (x, weight)));
    }
    let (a, weight) = (0.045_503_704_125_649_65, 0.042_546_020_777_081_466);
    let b = 0.5 - a;
    rule.extend([[a, a, b], [a, b, a], [b, a, a], [b, b, a], [b, a, b], [a, b, b]].map(|x| (x, weight)));
    std::array::from_fn(|q| tet10(rule[q].0, rule[q].1 / 6.0))
});

/// Gauss points of an interval of length 2 with their weights, exact to degree 5.
pub(crate) const GAUSS3: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// 3 x 3 x 3 Gauss points: exact to degree 5 in each direction, which the volume of a curved cell has.
pub(crate) static HEX20: LazyLock<[Reference<20>; 27]> = LazyLock::new(|| {
    std::array::from_fn(|q| {
        let [(x, a), (y, b), (z, c)] = [GAUSS3[q % 3], GAUSS3[q / 3 % 3], GAUSS3[q / 9]];
        hex20([x, y, z], a * b * c)
    })
});

/// The nodes of the reference cells: where the Jacobian of a cell is most likely to fail.
pub(crate) static TET10_NODES: LazyLock<[Reference<10>; 10]> = LazyLock::new(|| {
    let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    std::array::from_fn(|i| {
        let x = if i < 4 { corner[i] } else { middle(corner[TET_EDGES[i - 4][0]], corner[TET_EDGES[i - 4][1]]) };
        tet10(x, 0.0)
    })
});

pub(crate) static HEX20_NODES: LazyLock<[Reference<20>; 20]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let [a, b] = if i < 8 { [i, i] } else { HEX_EDGES[i - 8] };
        hex20(middle(HEX_CORNERS[a], HEX_CORNERS[b]), 0.0)
    })
});

/// The nodes of the linear wedge.
pub(crate) static WEDGE6_NODES: LazyLock<[Reference<6>; 6]> = LazyLock::new(|| WEDGE_CORNERS.map(|x| wedge6(x, 0.0)));

pub(crate) static WEDGE15_NODES: LazyLock<[Reference<15>; 15]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let [a, b] = if i < 6 { [i, i] } else { WEDGE_EDGES[i - 6] };
        wedge15(middle(WEDGE_CORNERS[a], WEDGE_CORNERS[b]), 0.0)
    })
});

fn middle(a: V3, b: V3) -> V3 {
    scale(0.5, add(a, b))
}

/// Most nodes a face has.
pub(crate) const FACE_NODES: usize = 8;

/// Shape functions of a face and their derivatives; those beyond its nodes are zero.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FaceShape {
    pub value: [f64; FACE_NODES],
    pub slope: [[f64; 2]; FACE_NODES],
}

impl FaceShape {
    /// Normal of the map from the reference face to the face with nodes at `x`, as long as area per reference area.
    pub(crate) fn normal(&self, x: &[V3]) -> V3 {
        let (mut first, mut second) = ([0.0; 3], [0.0; 3]);
        for (x, slope) in x.iter().zip(&self.slope) {
            first = add(first, scale(slope[0], *x));
            second = add(second, scale(slope[1], *x));
        }
        cross(first, second)
    }
}

const SQUARE: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Corners of a face with so many nodes.
pub(crate) fn face_corners(nodes: usize) -> usize {
    if nodes == 3 || nodes == 6 { 3 } else { 4 }
}

/// Reference coordinates of node `i` of a face with so many nodes.
pub(crate) fn face_node(nodes: usize, i: usize) -> [f64; 2] {
    let n = face_corners(nodes);
    let corner = |i: usize| if n == 3 { [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][i] } else { SQUARE[i] };
    if i < n {
        return corner(i);
    }
    let (a, b) = (corner(i - n), corner((i - n + 1) % n));
    [0, 1].map(|c| 0.5 * (a[c] + b[c]))
}

/// Shape functions of a face with 3, 4, 6 or 8 nodes at a point of the reference triangle or square. The node in the
/// middle of the edge from corner `i` to the next is number `i` after the corners.
pub(crate) fn face_shape(nodes: usize, x: [f64; 2]) -> FaceShape {
    let mut at = FaceShape::default();
    let n = face_corners(nodes);
    if n == 3 {
        let b = [1.0 - x[0] - x[1], x[0], x[1]];
        let slope = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
        for i in 0..3 {
            let j = (i + 1) % 3;
            if nodes == 3 {
                (at.value[i], at.slope[i]) = (b[i], slope[i]);
            } else {
                at.value[i] = b[i] * (2.0 * b[i] - 1.0);
                at.slope[i] = slope[i].map(|s| (4.0 * b[i] - 1.0) * s);
                at.value[3 + i] = 4.0 * b[i] * b[j];
                at.slope[3 + i] = [0, 1].map(|c| 4.0 * (b[j] * slope[i][c] + b[i] * slope[j][c]));
            }
        }
        return at;
    }
    for (i, s) in SQUARE.into_iter().enumerate() {
        let f = [1.0 + s[0] * x[0], 1.0 + s[1] * x[1]];
        let rest = if nodes == 4 { 1.0 } else { s[0] * x[0] + s[1] * x[1] - 1.0 };
        let bend = if nodes == 4 { [0.0; 2] } else { f };
        at.value[i] = 0.25 * f[0] * f[1] * rest;
        at.slope[i] = [0, 1].map(|c| 0.25 * s[c] * f[1 - c] * (rest + bend[c]));
        if nodes == 8 {
            let next = SQUARE[(i + 1) % 4];
            // along its edge a bubble, across it linear
            let along = usize::from(s[0] == next[0]);
            let across = 1 - along;
            let (bubble, line) = (1.0 - x[along] * x[along], 1.0 + s[across] * x[across]);
            at.value[4 + i] = 0.5 * bubble * line;
            at.slope[4 + i][along] = -x[along] * line;
            at.slope[4 + i][across] = 0.5 * bubble * s[across];
        }
    }
    at
}

/// Points and weights over the reference face. Triangles: Radon's rule of seven points, exact to degree 5. Squares:
/// 3 x 3 Gauss points, exact to degree 5 in each direction.
pub(crate) fn face_rule(nodes: usize) -> Vec<([f64; 2], f64)> {
    if face_corners(nodes) == 4 {
        return GAUSS3.iter().flat_map(|&(y, b)| GAUSS3.map(|(x, a)| ([x, y], a * b))).collect();
    }
    let root = 15f64.sqrt();
    let mut rule = vec![([1.0 / 3.0; 2], 9.0 / 80.0)];
    for s in [-root, root] {
        let (near, weight) = ((6.0 + s) / 21.0, (155.0 + s) / 2400.0);
        let far = 1.0 - 2.0 * near;
        rule.extend([[near, near], [far, near], [near, far]].map(|x| (x, weight)));
    }
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const N: usize>(nodes: &[Reference<N>; N], at: impl Fn(V3) -> Reference<N>, place: impl Fn(usize) -> V3) {
        for (i, at) in nodes.iter().enumerate() {
            for (j, value) in at.shape.iter().enumerate() {
                assert!((value - f64::from(u8::from(i == j))).abs() < 1e-14, "{i} {j}");
            }
        }
        let x = [0.21, 0.13, 0.35];
        let here = at(x);
        // all polynomials of degree two are reproduced, values and slopes
        let quadratic = |[x, y, z]: V3| 1.0 - 2.0 * x + 0.5 * y + z + x * x - 3.0 * y * y + 0.2 * z * z + x * y - y * z;
        let slope = [-2.0 + 2.0 * x[0] + x[1], 0.5 - 6.0 * x[1] + x[0] - x[2], 1.0 + 0.4 * x[2] - x[1]];
        let value: f64 = (0..N).map(|i| here.shape[i] * quadratic(place(i))).sum();
        assert!((value - quadratic(x)).abs() < 1e-14);
        for (c, slope) in slope.into_iter().enumerate() {
            let found: f64 = (0..N).map(|i| here.gradient[i][c] * quadratic(place(i))).sum();
            assert!((found - slope).abs() < 1e-13, "{c}: {found}");
        }
    }

    #[test]
    fn shape_functions_are_one_at_their_node_and_reproduce_quadratic_fields() {
        let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let tet = |i: usize| {
            if i < 4 {
                corner[i]
            } else {
                TET_EDGES[i - 4].map(|k| corner[k]).into_iter().fold([0.0; 3], |a, b| add(a, scale(0.5, b)))
            }
        };
        check(&TET10_NODES, |x| tet10(x, 0.0), tet);
        let hex = |i: usize| {
            if i < 8 {
                HEX_CORNERS[i]
            } else {
                middle(HEX_CORNERS[HEX_EDGES[i - 8][0]], HEX_CORNERS[HEX_EDGES[i - 8][1]])
            }
        };
        check(&HEX20_NODES, |x| hex20(x, 0.0), hex);
        let wedge = |i: usize| {
            let [a, b] = if i < 6 { [i, i] } else { WEDGE_EDGES[i - 6] };
            middle(WEDGE_CORNERS[a], WEDGE_CORNERS[b])
        };
        check(&WEDGE15_NODES, |x| wedge15(x, 0.0), wedge);
        for n in [3, 4, 6, 8] {
            let x = [0.23, 0.41];
            let here = face_shape(n, x);
            let square = if n > 4 { 1.0 } else { 0.0 };
            let field = |[x, y]: [f64; 2]| 2.0 - x + 3.0 * y + square * (x * x - 2.0 * y * y + x * y);
            let slope = [-1.0 + square * (2.0 * x[0] + x[1]), 3.0 + square * (x[0] - 4.0 * x[1])];
            let sum = |part: &dyn Fn(usize) -> f64| (0..n).map(|i| part(i) * field(face_node(n, i))).sum::<f64>();
            assert!((sum(&|i| here.value[i]) - field(x)).abs() < 1e-14, "{n}");
            assert!((0..2).all(|c| (sum(&|i| here.slope[i][c]) - slope[c]).abs() < 1e-14), "{n}");
            for i in 0..n {
                let at = face_shape(n, face_node(n, i));
                assert!((0..n).all(|j| (at.value[j] - f64::from(u8::from(i == j))).abs() < 1e-15), "{n} {i}");
            }
        }
    }

    #[test]
    fn the_rule_of_fourteen_points_is_exact_to_degree_five() {
        let factorial = |n: usize| (1..=n).product::<usize>() as f64;
        for (p, q, r) in (0..=5).flat_map(|p| (0..=5 - p).flat_map(move |q| (0..=5 - p - q).map(move |r| (p, q, r)))) {
            // the point is where the shape functions of a linear field say it is
            let place = |at: &Reference<10>| {
                [1, 2, 3].map(|k| {
                    at.shape[k]
                        + TET_EDGES
                            .iter()
                            .zip(&at.shape[4..])
                            .map(|(e, s)| if e.contains(&k) { 0.5 * s } else { 0.0 })
                            .sum::<f64>()
                })
            };
            let sum: f64 = TET10
                .iter()
                .map(|at| {
                    let [x, y, z] = place(at);
                    at.weight * x.powi(p as i32) * y.powi(q as i32) * z.powi(r as i32)
                })
                .sum();
            let exact = factorial(p) * factorial(q) * factorial(r) / factorial(p + q + r + 3);
            assert!((sum - exact).abs() < 1e-15, "{p} {q} {r}: {sum} {exact}");
        }
    }
}
