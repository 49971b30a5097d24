//! Nested iteration (Kornhuber & Krause 2001, for contact): the same case on a coarser block gives displacements to
//! start from. Most of a contact surface then has its state already, which a start from zero finds a few rows of
//! nodes at a time.

use std::ops::ControlFlow;

use super::prepare::{Prepared, prepare};
use crate::fem::full_displacement;
use crate::friction::{Primal, Settings, solve_primal};
use crate::io::case::{Case, MeshSource};
use crate::mesh::Block;

/// The case on a block with a quarter of the cells along each axis, and where the nodes of that block are.
#[derive(Debug, Clone)]
pub struct Coarser {
    prepared: Box<Prepared>,
    /// Node coordinates along each axis.
    axes: [Vec<f64>; 3],
}

/// Cells of the fine block for each cell of the coarse one: it costs 1/64, and what it gets wrong is put right in two
/// or three cycles. Two would save one of them for an eighth of the whole cost.
const RATIO: usize = 4;
/// Cells along each axis that a coarser block still has to have.
const LEAST: usize = 2;
/// Accuracy of the coarse solution; a better one saves no fine cycles.
const TOLERANCE: f64 = 0.1;
/// Cycles allowed for it.
const CYCLES: usize = 100;

/// The coarser problem, if the mesh is a block that has one. What goes wrong here costs only the better start.
pub(super) fn coarser(case: &Case) -> Option<Coarser> {
    let MeshSource::Block(block) = &case.mesh.source else { return None };
    if case.mesh.placing.turn.is_some() {
        return None; // the cells no longer lie along the axes
    }
    // Linear cells half as large know as much as quadratic ones, and their nodes lie on a grid.
    let element = block.element.linear();
    let ratio = if block.element.is_quadratic() { RATIO / 2 } else { RATIO };
    let cells = block.cells.map(|n| (n / ratio).max(LEAST));
    if (0..3).all(|c| cells[c] >= block.cells[c]) {
        return None;
    }
    let mut coarse = case.clone();
    coarse.mesh.source = MeshSource::Block(Block { cells, element, ..block.clone() });
    let prepared = Box::new(prepare(&coarse).ok()?);
    let stride = [1, cells[0] + 1, (cells[0] + 1) * (cells[1] + 1)];
    let axis = |c: usize| (0..=cells[c]).map(|i| prepared.mesh.nodes[i * stride[c]][c]).collect();
    let axes = [axis(0), axis(1), axis(2)];
    Some(Coarser { prepared, axes })
}

/// Displacements of the unknowns of `fine` by trilinear interpolation of the solution on the coarser block; nothing if
/// it is not found.
pub(super) fn start(coarser: &Coarser, fine: &Prepared) -> Option<Vec<f64>> {
    let problem = &coarser.prepared.problem;
    let mut primal = Primal::new(problem).ok()?;
    let start_displacement = coarser.prepared.coarser.as_ref().and_then(|c| start(c, &coarser.prepared));
    let settings = Settings { tolerance: TOLERANCE, max_iterations: CYCLES, start_displacement, ..Settings::default() };
    let solution = solve_primal(problem, &mut primal, &settings, &mut |_| ControlFlow::Continue(()));
    if !solution.certificate.passed {
        return None;
    }
    if !fine.model.dofs.turned.is_empty() {
        return None; // the interpolation is along x, y, z
    }
    let u = full_displacement(&coarser.prepared.model, &solution.u);
    let sizes = [0, 1, 2].map(|c| coarser.axes[c].len());
    let at = |x: [f64; 3], component: usize| -> f64 {
        let places = [0, 1, 2].map(|c| {
            let axis = &coarser.axes[c];
            let i = axis.partition_point(|&a| a <= x[c]).clamp(1, axis.len() - 1) - 1;
            (i, ((x[c] - axis[i]) / (axis[i + 1] - axis[i])).clamp(0.0, 1.0))
        });
        let mut sum = 0.0;
        for corner in 0..8 {
            let (mut node, mut weight, mut stride) = (0, 1.0, 1);
            for c in 0..3 {
                let upper = corner >> c & 1;
                let (i, share) = places[c];
                node += (i + upper) * stride;
                weight *= if upper == 1 { share } else { 1.0 - share };
                stride *= sizes[c];
            }
            sum += weight * u[3 * node + component];
        }
        sum
    };
    let value = |&dof: &u32| at(fine.mesh.nodes[dof as usize / 3], dof as usize % 3);
    Some(fine.model.dofs.free.iter().map(value).collect())
}
