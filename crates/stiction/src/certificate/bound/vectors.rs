//! Vectors and tensors of the judge, its own.

pub(super) type V3 = [f64; 3];
pub(super) type Tensor = [f64; 6];

/// Places of the components `xx yy zz xy yz xz` of a symmetric tensor.
const INDEX: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
/// Orthonormal directions that span the same.
pub(super) fn basis(directions: &[V3]) -> Vec<V3> {
    let mut found: Vec<V3> = Vec::new();
    for &d in directions {
        let mut rest = d;
        for known in found.iter().chain(&found) {
            let along = dot(*known, rest);
            (0..3).for_each(|c| rest[c] -= along * known[c]);
        }
        // A plane that is named twice with other digits.
        if length(rest) > 1e-6 * length(d) {
            found.push(unit(rest));
        }
    }
    found
}

/// A part of a scale; nothing of nothing is nothing.
pub(super) fn ratio(value: f64, scale: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value / scale }
}

pub(super) fn traction(s: &Tensor, n: V3) -> V3 {
    std::array::from_fn(|i| (0..3).map(|j| s[INDEX[i][j]] * n[j]).sum())
}

pub(super) fn times(stiffness: &[[f64; 6]; 6], e: Tensor) -> Tensor {
    std::array::from_fn(|i| (0..6).map(|k| stiffness[i][k] * e[k]).sum())
}

pub(super) fn ascending(mut nodes: [u32; 3]) -> [u32; 3] {
    nodes.sort_unstable();
    nodes
}

pub(super) fn numbers(nodes: [u32; 3]) -> String {
    nodes.map(|node| (u64::from(node) + 1).to_string()).join(", ")
}

pub(super) fn dot(a: V3, b: V3) -> f64 {
    (0..3).map(|c| a[c] * b[c]).sum()
}

pub(super) fn minus(a: V3, b: V3) -> V3 {
    std::array::from_fn(|c| a[c] - b[c])
}

pub(super) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn length(a: V3) -> f64 {
    dot(a, a).sqrt()
}

pub(super) fn unit(a: V3) -> V3 {
    let size = length(a);
    a.map(|c| c / size)
}
