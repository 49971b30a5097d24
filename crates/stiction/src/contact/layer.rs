//! Interfaces that yield: gaskets, rock joints, the "linear" contact of finite element decks.
//!
//! A point of such a surface gets a node of its own in front of the node of the mesh, tied to it by springs along the normal
//! and the tangents, and its rows of `B` begin at this node. The law, the solvers and the certificate stay those of hard
//! contact: what the springs are compressed by is the pressure over the stiffness by equilibrium alone, and slip is what
//! the interface does beyond its elastic shear. In `K` the layer is like a layer of thin cells: its nodes move
//! with the rigid motions of their bodies, so that multigrid and floating bodies see nothing new.

use super::points::Point;
use crate::fem::FeModel;
use crate::linalg::{Csr, SymmetricCsr};
use crate::mesh::v3::V3;

/// Stiffness of an interface per area, force per length³.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterfaceStiffness {
    /// Pressure over the overlap it causes, > 0.
    pub normal: f64,
    /// Shear over the displacement it causes where the interface sticks, > 0.
    pub tangential: f64,
}

/// Gives points with a stiffness their nodes and puts the springs into `model`.
pub(super) fn add_layer(model: &mut FeModel, points: &mut [Point]) {
    let before = model.dofs.free.len();
    // Where springs end at what is prescribed.
    let (mut at_supports, mut among_supports) = (Vec::new(), Vec::new());
    for point in points.iter_mut() {
        let Some(stiffness) = point.stiffness else { continue };
        let dofs = &mut model.dofs;
        let layer = (dofs.unknown.len() / 3) as u32;
        let own = [0, 1, 2].map(|c| dofs.unknown[3 * point.node as usize + c]);
        let mut frame = point.frame.map(|axis| dofs.components(point.node, axis));
        let (free, held): (Vec<usize>, Vec<usize>) = (0..3).partition(|&c| own[c] != u32::MAX);
        // What a support holds of the node it holds of the layer, but where the other body moves along the surface.
        let slides = |&c: &usize| held.contains(&c) && (frame[1][c] != 0.0 || frame[2][c] != 0.0);
        let of_layer: Vec<usize> = (0..3).filter(|c| free.contains(c) || slides(c)).collect();
        if of_layer.len() > free.len() {
            frame[0] = dofs.components(point.node, point.normal);
        }
        for c in 0..3 {
            if of_layer.contains(&c) {
                dofs.unknown.push(dofs.free.len() as u32);
                dofs.free.push(3 * layer + c as u32);
            } else {
                dofs.unknown.push(u32::MAX);
            }
        }
        dofs.layer.push(point.node);
        point.layer = Some(layer);
        // Over the whole surface a uniform pressure compresses all points alike: a translation by a length moves the point by
        // its partition-of-unity sum.
        let area = point.area / point.unity_sum;
        let along = [stiffness.normal, stiffness.tangential, stiffness.tangential].map(|k| k * area);
        let springs = springs(&frame, along);
        let unknowns: Vec<(usize, usize)> = free.iter().map(|&c| (c, own[c] as usize)).collect();
        let first = add_node(&mut model.stiffness, &unknowns, &of_layer, &springs);
        if of_layer.len() == free.len() {
            continue;
        }
        let prescribed =
            held.iter().filter_map(|&c| Some((c, dofs.prescribed.binary_search(&(3 * point.node + c as u32)).ok()?)));
        for (c, p) in prescribed.clone() {
            at_supports.extend(unknowns.iter().map(|&(d, j)| (p, j, springs[c][d])));
            at_supports.extend(of_layer.iter().enumerate().map(|(k, &d)| (p, first + k, 0.0 - springs[c][d])));
            among_supports.extend(prescribed.clone().map(|(d, q)| (p, q, springs[c][d])));
        }
    }
    let after = model.dofs.free.len();
    model.load.resize(after, 0.0);
    model.support_stiffness.cols = after;
    if !at_supports.is_empty() {
        for &(p, j, k) in &at_supports {
            model.load[j] -= k * model.dofs.value[p];
        }
        at_supports.extend(model.support_stiffness.entries());
        among_supports.extend(model.support_support.entries());
        let p = model.dofs.prescribed.len();
        model.support_stiffness = Csr::from_triplets(p, after, &at_supports);
        model.support_support = Csr::from_triplets(p, p, &among_supports);
    }
    if let Some(springs) = model.springs.as_mut().filter(|_| after > before) {
        let moved = |i: usize| if i < before { i } else { i + after - before };
        let entries: Vec<(usize, usize, f64)> = springs.entries().map(|(i, j, v)| (moved(i), moved(j), v)).collect();
        let size = springs.rows + after - before;
        *springs = Csr::from_triplets(size, size, &entries);
    }
}

/// `sum of k a aᵀ` over the axes of the frame.
fn springs(frame: &[V3; 3], stiffness: [f64; 3]) -> [V3; 3] {
    let mut sum = [[0.0; 3]; 3];
    for (axis, k) in frame.iter().zip(stiffness) {
        for (row, a) in sum.iter_mut().zip(axis) {
            row.iter_mut().zip(axis).for_each(|(entry, b)| *entry += k * a * b);
        }
    }
    sum
}

/// Adds the rows of a node with the components `free`, which `springs` tie to the unknowns `own`, each after the component it is;
/// returns the first of them.
fn add_node(k: &mut SymmetricCsr, own: &[(usize, usize)], free: &[usize], springs: &[V3; 3]) -> usize {
    for (a, &(c, i)) in own.iter().enumerate() {
        for &(d, j) in &own[..=a] {
            k.entry_mut(i, j).into_iter().for_each(|entry| *entry += springs[c][d]);
        }
    }
    let first = k.rows;
    for (a, &c) in free.iter().enumerate() {
        let before = (first..first + a).map(|i| i as u32);
        let columns: Vec<u32> = own.iter().map(|&(_, i)| i as u32).chain(before).collect();
        let tied = own.iter().map(|&(d, _)| 0.0 - springs[c][d]);
        let values: Vec<f64> = tied.chain(free[..a].iter().map(|&d| springs[c][d])).collect();
        k.push_row(&columns, &values, springs[c][c]);
    }
    first
}
