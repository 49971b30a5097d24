//! The part of a face below the level of a liquid.

use super::faces::{FacePoint, face_points};
use crate::mesh::shape::{face_corners, face_rule, face_shape};
use crate::mesh::v3::{V3, add, scale};

/// A point of the reference face and its depth.
type Deep = ([f64; 2], f64);

/// Depths that differ by less than this part of the largest are equal: rounding of coordinates.
const ROUNDING: f64 = 1e-12;
/// Halvings of a face in each direction on which the depth is not linear.
const HALVINGS: usize = 3;

/// Quadrature over the part of the face with nodes at `x` (as for [`face_points`]) where `depth`, a linear function of the
/// place, is positive.
///
/// Where the depth is linear on the reference face (triangles and parallelograms that are flat, with middles of edges in
/// the middle) the face is cut along the level and the rule is exact to degree 5: exact for the pressure of a liquid times
/// a shape function. Other faces are cut along a chord of the level in each of 64 triangles (128 for four corners). The
/// chord is off by the second order of their size and the force, whose pressure vanishes there, by the fourth.
pub(super) fn submerged_points(x: &[V3], depth: &dyn Fn(V3) -> f64) -> Vec<FacePoint> {
    let n = face_corners(x.len());
    let at = |reference: [f64; 2]| {
        let value = face_shape(x.len(), reference).value;
        x.iter().zip(value).fold([0.0; 3], |sum, (&x, s)| add(sum, scale(s, x)))
    };
    let deep = |reference: [f64; 2]| (reference, depth(at(reference)));
    let corners: &[[f64; 2]] = if n == 3 {
        &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    } else {
        &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
    };
    let corners: Vec<Deep> = corners.iter().map(|&corner| deep(corner)).collect();
    let mut parts: Vec<[Deep; 3]> = (2..n).map(|k| [corners[0], corners[k - 1], corners[k]]).collect();
    if !is_linear(x, depth) {
        for _ in 0..HALVINGS {
            parts = parts.iter().flat_map(|part| quarters(part, &deep)).collect();
        }
    }
    let all = |test: &dyn Fn(f64) -> bool| parts.iter().flatten().all(|&(_, depth)| test(depth));
    if all(&|depth| depth >= 0.0) {
        return face_points(x);
    }
    if all(&|depth| depth <= 0.0) {
        return Vec::new();
    }
    let rule = face_rule(3);
    let mut points = Vec::new();
    for [a, b, c] in parts.iter().flat_map(below) {
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let area = (u[0] * v[1] - u[1] * v[0]).abs();
        for &(place, weight) in &rule {
            let reference = [0, 1].map(|k| a[k] + place[0] * u[k] + place[1] * v[k]);
            let shape = face_shape(x.len(), reference);
            let normal = scale(weight * area, shape.normal(x));
            points.push(FacePoint { shape: shape.value, position: at(reference), area: normal });
        }
    }
    points
}

fn is_linear(x: &[V3], depth: &dyn Fn(V3) -> f64) -> bool {
    let n = face_corners(x.len());
    let d: Vec<f64> = x.iter().map(|&x| depth(x)).collect();
    let rounding = ROUNDING * d.iter().fold(0.0, |a: f64, d| a.max(d.abs()));
    let twist = if n == 4 { d[0] - d[1] + d[2] - d[3] } else { 0.0 };
    let off_middle = (n..d.len()).map(|i| d[i] - 0.5 * (d[i - n] + d[(i - n + 1) % n]));
    off_middle.chain([twist]).all(|off| off.abs() <= rounding)
}

/// A triangle cut into four at the middles of its edges.
fn quarters([a, b, c]: &[Deep; 3], deep: &dyn Fn([f64; 2]) -> Deep) -> [[Deep; 3]; 4] {
    let middle = |p: &Deep, q: &Deep| deep([0.5 * (p.0[0] + q.0[0]), 0.5 * (p.0[1] + q.0[1])]);
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
}

/// The part of a triangle where its depth is positive, as triangles.
fn below(corners: &[Deep; 3]) -> Vec<[[f64; 2]; 3]> {
    let mut polygon: Vec<[f64; 2]> = Vec::with_capacity(4);
    for i in 0..3 {
        let ((p, from), (q, to)) = (corners[i], corners[(i + 1) % 3]);
        if from >= 0.0 {
            polygon.push(p);
        }
        if (from > 0.0) != (to > 0.0) && from != 0.0 && to != 0.0 {
            let share = from / (from - to);
            polygon.push([0, 1].map(|k| p[k] + share * (q[k] - p[k])));
        }
    }
    (2..polygon.len()).map(|k| [polygon[0], polygon[k - 1], polygon[k]]).collect()
}
