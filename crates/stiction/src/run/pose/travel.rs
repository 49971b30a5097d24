//! The travel: a translation that supports and obstacles have in common, taken off before anything is solved.
//!
//! A body that is carried far and then pressed a little has displacements of which the strain is the last digits. Where
//! the translation nearest to the prescribed displacements is larger than the mesh, the problem is posed in a frame that
//! travels with them. A smaller one costs no more digits than the coordinates of the nodes themselves.

use crate::fem::{DofMap, FeModel};
use crate::mesh::v3::{add, dot, norm, scale, sub};
use crate::mesh::{Bounds, Mesh};

/// The translation of least squares through the prescribed displacements where it is larger than the mesh, otherwise
/// zero; length. Springs tie a body to the ground: with them there is none.
pub(super) fn travel(mesh: &Mesh, model: &FeModel, dofs: &DofMap) -> [f64; 3] {
    let largest = dofs.value.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
    let size = Bounds::around(mesh.nodes.iter().copied()).diagonal();
    if model.springs.is_some() || largest <= size {
        return [0.0; 3];
    }
    let first = nearest(dofs, &dofs.value);
    if norm(first) <= size {
        return [0.0; 3];
    }
    // Once more for the rounding of the first, so that one common value leaves exactly zero.
    add(first, nearest(dofs, &without(first, dofs)))
}

/// What is left of the prescribed displacements, length `p`.
pub(super) fn without(travel: [f64; 3], dofs: &DofMap) -> Vec<f64> {
    dofs.prescribed.iter().zip(&dofs.value).map(|(&dof, value)| value - dot(dofs.direction(dof), travel)).collect()
}

/// What the rounding of numbers of this size, which cancel, leaves open in gaps and slips; length.
pub(super) fn travel_rounding(travel: [f64; 3]) -> f64 {
    f64::EPSILON * norm(travel)
}

/// The translation of least squares through `value`; of several the shortest, which conjugate gradients from zero find in
/// three steps.
fn nearest(dofs: &DofMap, value: &[f64]) -> [f64; 3] {
    let directions = || dofs.prescribed.iter().map(|&dof| dofs.direction(dof));
    let normal = |a: [f64; 3]| directions().fold([0.0; 3], |sum, d| add(sum, scale(dot(d, a), d)));
    let mut a = [0.0; 3];
    let mut r = directions().zip(value).fold([0.0; 3], |sum, (d, v)| add(sum, scale(*v, d)));
    let (mut p, start) = (r, norm(r));
    for _ in 0..3 {
        let image = normal(p);
        let square = dot(r, r);
        if norm(r) <= f64::EPSILON * start || dot(p, image) <= 0.0 {
            break;
        }
        let length = square / dot(p, image);
        a = add(a, scale(length, p));
        r = sub(r, scale(length, image));
        p = add(r, scale(dot(r, r) / square, p));
    }
    a
}
