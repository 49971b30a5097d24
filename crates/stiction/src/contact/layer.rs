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
    for point in points.iter_mut() {
        let Some(stiffness) = point.stiffness else { continue };
        let dofs = &mut model.dofs;
        let layer = (dofs.unknown.len() / 3) as u32;
        let own = [0, 1, 2].map(|c| dofs.unknown[3 * point.node as usize + c]);
        let free: Vec<usize> = (0..3).filter(|&c| own[c] != u32::MAX).collect();
        for (c, unknown) in own.into_iter().enumerate() {
            if unknown == u32::MAX {
                // What a support holds of the node it holds of the layer.
                dofs.unknown.push(u32::MAX);
            } else {
                dofs.unknown.push(dofs.free.len() as u32);
                dofs.free.push(3 * layer + c as u32);
            }
        }
        dofs.layer.push(point.node);
        point.layer = Some(layer);
        let frame = point.frame.map(|axis| dofs.components(point.node, axis));
        // Over the whole surface a uniform pressure compresses all points alike: a translation by a length moves the point by
        // its partition-of-unity sum.
        let area = point.area / point.unity_sum;
        let along = [stiffness.normal, stiffness.tangential, stiffness.tangential].map(|k| k * area);
        let springs = springs(&frame, along);
        add_node(&mut model.stiffness, &free.iter().map(|&c| own[c] as usize).collect::<Vec<_>>(), &free, &springs);
    }
    let after = model.dofs.free.len();
    model.load.resize(after, 0.0);
    model.support_stiffness.cols = after;
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

/// Adds the rows of a node that `springs` tie to the unknowns `own`, which are the components `free` of theirs.
fn add_node(k: &mut SymmetricCsr, own: &[usize], free: &[usize], springs: &[V3; 3]) {
    for (a, &i) in own.iter().enumerate() {
        for (b, &j) in own.iter().enumerate().take(a + 1) {
            k.entry_mut(i, j).into_iter().for_each(|entry| *entry += springs[free[a]][free[b]]);
        }
    }
    let first = k.rows;
    for (a, &c) in free.iter().enumerate() {
        let columns: Vec<u32> = own.iter().map(|&i| i as u32).chain((first..first + a).map(|i| i as u32)).collect();
        let tied = free.iter().map(|&d| 0.0 - springs[c][d]);
        let values: Vec<f64> = tied.chain(free[..a].iter().map(|&d| springs[c][d])).collect();
        k.push_row(&columns, &values, springs[c][c]);
    }
}
