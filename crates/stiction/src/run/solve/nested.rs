//! Nested iteration (Kornhuber & Krause 2001, for contact): the same case on a coarser block gives displacements to
//! start from. Most of a contact surface then has its state already, which a start from zero finds a few rows of
//! nodes at a time.

use std::ops::ControlFlow;

use rayon::prelude::*;

use crate::fem::full_displacement;
use crate::friction::{Progress, Settings};
use crate::linalg::Stop;
use crate::run::pose::{Coarser, Prepared};
use crate::solve::Kept;

/// Accuracy of the coarse solution; a better one saves no fine cycles, one of 0.1 costs one now and then.
const TOLERANCE: f64 = 0.03;
/// Cycles allowed for it.
const CYCLES: usize = 100;

/// How the coarser problem is solved.
pub(crate) fn settings() -> Settings {
    Settings { tolerance: TOLERANCE, max_iterations: CYCLES, ..Settings::default() }
}

/// Displacements of the unknowns of `fine` by interpolation of the solution on the coarser block ([`weights`]); nothing
/// if it is not found, or not before `stop` asks to end.
pub(crate) fn start(coarser: &Coarser, fine: &Prepared, stop: &Stop) -> Option<Vec<f64>> {
    let problem = &coarser.prepared.problem;
    let mut settings = Settings { stop: stop.clone(), ..settings() };
    let mut kept = Kept::default();
    let set_up = kept.set_up(problem, &settings, &mut |_| ControlFlow::Continue(())).ok()?;
    settings.start_displacement = coarser.prepared.coarser.as_ref().and_then(|c| start(c, &coarser.prepared, stop));
    let mut watch = |_: &Progress| if stop.asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let solution = set_up.solution(problem, &settings, &mut watch).ok()?;
    if !solution.certificate.passed {
        return None;
    }
    if !fine.model.dofs.rotated.is_empty() {
        return None; // the interpolation is along x, y, z
    }
    let u = full_displacement(&coarser.prepared.model, &solution.u);
    let at = |x: [f64; 3]| {
        let mut sum = [0.0; 3];
        for (node, weight) in around(&coarser.axes, x) {
            (0..3).for_each(|c| sum[c] += weight * u[3 * node as usize + c]);
        }
        sum
    };
    let all: Vec<[f64; 3]> = fine.mesh.nodes.par_iter().map(|&x| at(x)).collect();
    let dofs = &fine.model.dofs;
    Some(dofs.free.iter().map(|&dof| all.as_flattened()[dofs.mesh_dof(dof) as usize]).collect())
}

/// Nodes along an axis from which on interpolation is cubic; what linear interpolation leaves in the balance costs a cycle
/// more, and on fewer nodes a cubic swings about what contact makes of the coarse displacements.
const CUBIC: usize = 5;

/// The nodes of a block around a place, with their weights; `axes` are where its nodes are along x, y and z.
pub(crate) fn around(axes: &[Vec<f64>; 3], x: [f64; 3]) -> impl Iterator<Item = (u64, f64)> {
    let [along_x, along_y, along_z] = [0, 1, 2].map(|c| weights(&axes[c], x[c]));
    let [in_row, rows] = [0, 1].map(|c| axes[c].len() as u64);
    let of_row = move |j: u64, k: u64, weight: f64| {
        along_x.into_iter().map(move |(i, in_x)| (i as u64 + in_row * (j + rows * k), weight * in_x))
    };
    let of_layer =
        move |k: u64, in_z: f64| along_y.into_iter().flat_map(move |(j, in_y)| of_row(j as u64, k, in_z * in_y));
    let all = along_z.into_iter().flat_map(move |(k, in_z)| of_layer(k as u64, in_z));
    all.filter(|(_, weight)| *weight != 0.0)
}

/// Interpolation along an axis: the nodes around a place and their weights.
fn weights(axis: &[f64], x: f64) -> [(usize, f64); 4] {
    let used = if axis.len() < CUBIC { 2 } else { 4 };
    let first = axis.partition_point(|&a| a <= x).saturating_sub(used / 2).min(axis.len() - used);
    let mut result = [(first, 0.0); 4];
    for (node, entry) in (first..first + used).zip(&mut result) {
        let others = (first..first + used).filter(|&other| other != node);
        *entry = (node, others.map(|other| (x - axis[other]) / (axis[node] - axis[other])).product());
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_reproduce_cubics_and_on_few_nodes_what_is_linear() {
        let axis = [0.0, 0.1, 0.35, 0.8, 1.3, 2.5];
        let poly = |x: f64, degree: i32| (0..=degree).map(|k| f64::from(k + 1) * (x - 0.7).powi(k)).sum::<f64>();
        for (nodes, degree) in [(6, 3), (5, 3), (4, 1), (3, 1)] {
            let axis = &axis[..nodes];
            for step in 0..=40 {
                let x = axis[nodes - 1] * f64::from(step) / 40.0;
                let found: f64 = weights(axis, x).iter().map(|&(i, weight)| weight * poly(axis[i], degree)).sum();
                assert!((found - poly(x, degree)).abs() < 1e-12, "{nodes} nodes, {x}: {found}");
                // The nodes are those around x.
                let used: Vec<f64> = weights(axis, x).iter().filter(|w| w.1 != 0.0).map(|w| axis[w.0]).collect();
                assert!(used.iter().any(|&a| a <= x) && used.iter().any(|&a| a >= x), "{x}: {used:?}");
            }
        }
    }
}
