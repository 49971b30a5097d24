//! Faces in a plane: clipping, shape functions at a point, quadrature over polygons.

use std::sync::LazyLock;

use crate::mesh::shape::{FACE_NODES, FaceShape, face_corners, face_node, face_shape};

/// A point of the plane.
pub(super) type P2 = [f64; 2];

fn cross(a: P2, b: P2, c: P2) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Area of a polygon, positive if it is counter-clockwise.
pub(super) fn area(polygon: &[P2]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    polygon.windows(2).map(|edge| 0.5 * cross(first, edge[0], edge[1])).sum()
}

/// The part of `subject` inside the convex, counter-clockwise `window` (Sutherland & Hodgman 1974), in `polygon`;
/// `input` is room to work in.
pub(super) fn clip(subject: &[P2], window: &[P2], polygon: &mut Vec<P2>, input: &mut Vec<P2>) {
    polygon.clear();
    polygon.extend_from_slice(subject);
    for (i, &a) in window.iter().enumerate() {
        let b = window[if i + 1 == window.len() { 0 } else { i + 1 }];
        std::mem::swap(polygon, input);
        polygon.clear();
        let Some(&last) = input.last() else { return };
        let (mut from, mut before) = (last, cross(a, b, last));
        for &to in input.iter() {
            let here = cross(a, b, to);
            if (before < 0.0) != (here < 0.0) {
                let t = before / (before - here);
                polygon.push([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
            }
            if here >= 0.0 {
                polygon.push(to);
            }
            (from, before) = (to, here);
        }
    }
}

/// Lowest and highest coordinates of a polygon.
pub(super) fn bounds(polygon: &[P2]) -> [P2; 2] {
    let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    polygon
        .iter()
        .fold(start, |[low, high], p| [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]])
}

/// A triangle or quadrilateral, linear or quadratic, with its shape functions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flat {
    nodes: [P2; FACE_NODES],
    count: usize,
    /// What it takes to integrate products of its functions: a linear quadrilateral whose map from the reference square
    /// is not affine has functions that are no polynomials.
    pub degree: Degree,
}

/// Newton steps for a point of a quadrilateral or a quadratic face; four are enough unless it is hardly convex.
const STEPS: usize = 20;

/// Polygons between the nodes of a quadratic triangle and of a quadratic quadrilateral.
const OF_TRIANGLE: [&[usize]; 4] = [&[0, 3, 5], &[3, 1, 4], &[5, 4, 2], &[3, 4, 5]];
const OF_QUADRILATERAL: [&[usize]; 5] = [&[0, 4, 7], &[4, 1, 5], &[5, 2, 6], &[6, 3, 7], &[4, 5, 6, 7]];

impl Flat {
    /// From 3, 4, 6 or 8 nodes: corners, then the middles of edges.
    pub(super) fn new(nodes: &[P2]) -> Flat {
        let mut all = [[0.0; 2]; FACE_NODES];
        all[..nodes.len()].copy_from_slice(nodes);
        let twist = [0, 1].map(|c| all[0][c] - all[1][c] + all[2][c] - all[3][c]);
        let size = [0, 1].map(|c| all[2][c] - all[0][c]);
        let bent = nodes.len() == 4 && twist[0].hypot(twist[1]) > 1e-10 * size[0].hypot(size[1]);
        let degree = match nodes.len() {
            3 => Degree::Linear,
            8 => Degree::Serendipity,
            _ if bent => Degree::Bent,
            _ => Degree::Polynomial,
        };
        Flat { nodes: all, count: nodes.len(), degree }
    }

    pub(super) fn corners(&self) -> &[P2] {
        &self.nodes[..face_corners(self.count)]
    }

    pub(super) fn nodes(&self) -> &[P2] {
        &self.nodes[..self.count]
    }

    /// Polygons that cover it: itself, or those between the nodes of a quadratic face.
    pub(super) fn pieces(&self) -> Vec<Vec<P2>> {
        let piece = |nodes: &&[usize]| nodes.iter().map(|&i| self.nodes[i]).collect();
        match self.count {
            6 => OF_TRIANGLE.iter().map(piece).collect(),
            8 => OF_QUADRILATERAL.iter().map(piece).collect(),
            _ => vec![self.corners().to_vec()],
        }
    }

    /// Values of the shape functions at `x`; those beyond its nodes are zero.
    pub(super) fn shape(&self, x: P2) -> [f64; FACE_NODES] {
        let mut shape = [0.0; FACE_NODES];
        let straight = self.straight(x);
        if self.count <= 4 {
            shape[..4].copy_from_slice(&straight);
            return shape;
        }
        // From where the point would be between straight edges.
        let corners = self.corners().len();
        let mut at = [0, 1].map(|c| (0..corners).map(|i| straight[i] * face_node(self.count, i)[c]).sum::<f64>());
        for _ in 0..STEPS {
            let FaceShape { value, slope } = face_shape(self.count, at);
            shape = value;
            let (mut r, mut first, mut second) = ([-x[0], -x[1]], [0.0; 2], [0.0; 2]);
            for (i, node) in self.nodes[..self.count].iter().enumerate() {
                for c in 0..2 {
                    r[c] += value[i] * node[c];
                    first[c] += slope[i][0] * node[c];
                    second[c] += slope[i][1] * node[c];
                }
            }
            let step = newton_step(r, first, second);
            if step.iter().any(|s| !s.is_finite()) || step[0].abs().max(step[1].abs()) < 1e-15 {
                break;
            }
            at = [at[0] - step[0], at[1] - step[1]];
        }
        shape
    }

    /// The shape functions of its corners alone at `x`; the last is zero on a triangle.
    fn straight(&self, x: P2) -> [f64; 4] {
        let [a, b, c, d, ..] = self.nodes;
        if self.corners().len() == 3 {
            let whole = cross(a, b, c);
            let (second, third) = (cross(a, x, c) / whole, cross(a, b, x) / whole);
            return [1.0 - second - third, second, third, 0.0];
        }
        // x = a + s e + t f + s t g on the unit square.
        let [e, f] = [[b[0] - a[0], b[1] - a[1]], [d[0] - a[0], d[1] - a[1]]];
        let g = [a[0] - b[0] + c[0] - d[0], a[1] - b[1] + c[1] - d[1]];
        let (mut s, mut t) = (0.5, 0.5);
        for _ in 0..STEPS {
            let r = [0, 1].map(|k| a[k] + s * e[k] + t * f[k] + s * t * g[k] - x[k]);
            let [step_s, step_t] = newton_step(r, [0, 1].map(|k| e[k] + t * g[k]), [0, 1].map(|k| f[k] + s * g[k]));
            (s, t) = (s - step_s, t - step_t);
            if step_s.abs().max(step_t.abs()) < 1e-15 {
                break;
            }
        }
        [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t]
    }
}

/// What solves `step[0] first + step[1] second = r`.
fn newton_step(r: P2, first: P2, second: P2) -> P2 {
    let det = first[0] * second[1] - first[1] * second[0];
    [(r[0] * second[1] - r[1] * second[0]) / det, (first[0] * r[1] - first[1] * r[0]) / det]
}

/// How exactly products of shape functions are integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Degree {
    /// Linear functions times linear ones: degree 2.
    Linear,
    /// Polynomials up to degree 5.
    Polynomial,
    /// Functions of quadrilaterals of eight nodes times one another: degree 6.
    Serendipity,
    /// Functions that are no polynomials.
    Bent,
}

/// Calls `take` with points and weights over a counter-clockwise convex polygon, cut into triangles around its middle.
pub(super) fn quadrature(polygon: &[P2], degree: Degree, mut take: impl FnMut(P2, f64)) {
    let count = polygon.len() as f64;
    let middle = [0, 1].map(|c| polygon.iter().map(|p| p[c]).sum::<f64>() / count);
    let rule: &[([f64; 3], f64)] = match degree {
        Degree::Linear => &MIDDLES,
        Degree::Polynomial => &RADON,
        Degree::Serendipity => &DUNAVANT,
        Degree::Bent => &COLLAPSED,
    };
    for (i, &b) in polygon.iter().enumerate() {
        let c = polygon[if i + 1 == polygon.len() { 0 } else { i + 1 }];
        let area = 0.5 * cross(middle, b, c);
        if area > 0.0 {
            for (w, weight) in rule {
                take([0, 1].map(|k| w[0] * middle[k] + w[1] * b[k] + w[2] * c[k]), weight * area);
            }
        }
    }
}

/// The middles of the edges of a triangle: exact to degree 2.
const MIDDLES: [([f64; 3], f64); 3] =
    [([0.0, 0.5, 0.5], 1.0 / 3.0), ([0.5, 0.0, 0.5], 1.0 / 3.0), ([0.5, 0.5, 0.0], 1.0 / 3.0)];

/// Radon's rule of seven points, exact to degree 5.
static RADON: LazyLock<Vec<([f64; 3], f64)>> = LazyLock::new(|| {
    let root = 15f64.sqrt();
    let mut rule = vec![([1.0 / 3.0; 3], 9.0 / 40.0)];
    for s in [-root, root] {
        let (near, weight) = ((6.0 + s) / 21.0, (155.0 + s) / 1200.0);
        rule.extend((0..3).map(|i| (std::array::from_fn(|k| if k == i { 1.0 - 2.0 * near } else { near }), weight)));
    }
    rule
});

/// Twelve points, exact to degree 6 (Dunavant 1985, with the digits that its equations give): on the medians, and beside them.
static DUNAVANT: LazyLock<Vec<([f64; 3], f64)>> = LazyLock::new(|| {
    let mut rule = Vec::new();
    for (near, weight) in
        [(0.249_286_745_170_910_42, 0.116_786_275_726_379_37), (0.063_089_014_491_502_23, 0.050_844_906_370_206_82)]
    {
        rule.extend((0..3).map(|i| (std::array::from_fn(|k| if k == i { 1.0 - 2.0 * near } else { near }), weight)));
    }
    let (a, b) = (0.053_145_049_844_816_95, 0.310_352_451_033_784_4);
    let c = 1.0 - a - b;
    let beside = [[a, b, c], [b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]];
    rule.extend(beside.map(|w| (w, 0.082_851_075_618_373_58)));
    rule
});

/// Gauss's eight points on the unit interval, those of its upper half: distances from the middle, and weights.
const GAUSS: [[f64; 2]; 4] = [
    [0.091_717_321_247_824_95, 0.181_341_891_689_181],
    [0.262_766_204_958_164_5, 0.156_853_322_938_943_65],
    [0.398_333_238_706_813_4, 0.111_190_517_226_687_23],
    [0.480_144_928_248_768_1, 0.050_614_268_145_188_13],
];

/// A square of Gauss points collapsed onto the triangle: exact to degree 14.
static COLLAPSED: LazyLock<Vec<([f64; 3], f64)>> = LazyLock::new(|| {
    let line: Vec<[f64; 2]> = GAUSS.iter().flat_map(|&[x, w]| [[0.5 - x, w], [0.5 + x, w]]).collect();
    let at = |[r, a]: [f64; 2], [s, b]: [f64; 2]| ([r, (1.0 - r) * (1.0 - s), (1.0 - r) * s], 2.0 * a * b * (1.0 - r));
    line.iter().flat_map(|&r| line.iter().map(move |&s| at(r, s))).collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    fn clip(subject: &[P2], window: &[P2]) -> Vec<P2> {
        let mut polygon = Vec::new();
        super::clip(subject, window, &mut polygon, &mut Vec::new());
        polygon
    }

    const SQUARE: [P2; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    #[test]
    fn clipping_keeps_what_both_cover() {
        let corner = [[0.5, 0.5], [2.0, 0.5], [2.0, 2.0], [0.5, 2.0]];
        assert!((area(&clip(&corner, &SQUARE)) - 0.25).abs() < 1e-16);
        let triangle = [[-1.0, 0.5], [0.5, -1.0], [2.0, 0.5]]; // its lower corner lies outside
        // Of the strip 0 <= y <= 1/2 the edges y = -x - 1/2 and y = x - 3/2 of the triangle leave all inside the square.
        assert!((area(&clip(&triangle, &SQUARE)) - 0.5).abs() < 1e-15);
        assert_eq!(area(&clip(&SQUARE, &SQUARE)), 1.0);
        assert!(clip(&[[3.0, 0.0], [4.0, 0.0], [4.0, 1.0]], &SQUARE).is_empty());
        // What is cut off and what stays add up to the whole.
        let odd = [[0.2, -0.3], [1.4, 0.1], [0.9, 1.2], [-0.2, 0.8]];
        let halves =
            [[[0.5, -9.0], [0.5, 9.0], [-9.0, 9.0], [-9.0, -9.0]], [[0.5, 9.0], [0.5, -9.0], [9.0, -9.0], [9.0, 9.0]]];
        let sum: f64 = halves.iter().map(|half| area(&clip(&odd, half))).sum();
        assert!((sum - area(&odd)).abs() < 1e-14);
    }

    #[test]
    fn all_rules_integrate_polynomials_exactly() {
        let triangle = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let factorial = |n: i32| (1..=n).product::<i32>() as f64;
        for (rule, degree) in
            [(Degree::Linear, 2), (Degree::Polynomial, 5), (Degree::Serendipity, 6), (Degree::Bent, 10)]
        {
            for (p, q) in (0..=degree).flat_map(|p| (0..=degree - p).map(move |q| (p, q))) {
                let mut sum = 0.0;
                quadrature(&triangle, rule, |x, w| sum += w * x[0].powi(p) * x[1].powi(q));
                let exact = if p + q <= 10 {
                    factorial(p) * factorial(q)
                        / ((p + q + 1)..=(p + q + 2)).fold(factorial(p + q), |a, k| a * f64::from(k))
                } else {
                    0.0
                };
                assert!((sum - exact).abs() < 1e-15, "{p} {q}: {sum} {exact}");
            }
        }
    }

    #[test]
    fn shape_functions_reproduce_every_point() {
        let quad = Flat::new(&[[0.0, 0.0], [2.0, 0.3], [1.7, 1.5], [-0.2, 1.0]]);
        let triangle = Flat::new(&[[0.0, 0.0], [2.0, 0.3], [-0.2, 1.0]]);
        let degrees = [quad, triangle, Flat::new(&SQUARE)].map(|flat| flat.degree);
        assert_eq!(degrees, [Degree::Bent, Degree::Linear, Degree::Polynomial]);
        let corners = [[0.0, 0.0], [2.0, 0.3], [1.7, 1.5], [-0.2, 1.0]];
        let curved: Vec<P2> =
            (corners.into_iter())
                .chain((0..4).map(|i| {
                    [0, 1].map(|c| 0.5 * (corners[i][c] + corners[(i + 1) % 4][c]) + 0.04 * (i * 2 + c) as f64)
                }))
                .collect();
        let six = [[0.0, 0.0], [2.0, 0.3], [-0.2, 1.0], [1.0, 0.05], [1.0, 0.8], [-0.15, 0.5]];
        for flat in [quad, triangle, Flat::new(&curved), Flat::new(&six)] {
            for x in [[0.0, 0.0], [0.5, 0.4], [-0.2, 1.0], [0.01, 0.9]] {
                let shape = flat.shape(x);
                let back = [0, 1].map(|c| flat.nodes.iter().zip(shape).map(|(p, s)| s * p[c]).sum::<f64>());
                assert!(
                    (0..2).all(|c| (back[c] - x[c]).abs() < 1e-14) && (shape.iter().sum::<f64>() - 1.0).abs() < 1e-14
                );
            }
        }
    }
}
