//! The same case on a coarser block, whose solution is a start for the finer one.

use super::prepare::{Prepared, prepare};
use crate::io::case::{Case, MeshSource};
use crate::mesh::{Block, Grid, Grids};

/// The case on a block with a quarter of the cells along each axis, and where the nodes of that block are.
#[derive(Debug, Clone)]
pub struct Coarser {
    pub(crate) prepared: Box<Prepared>,
    /// Node coordinates along each axis, length.
    pub(crate) axes: [Vec<f64>; 3],
}

/// Cells of the fine block for each cell of the coarse one: it costs 1/64, and what it gets wrong is put right in two
/// or three cycles. Two would save one of them for an eighth of the whole cost.
const RATIO: usize = 4;
/// Cells along each axis that a coarser block still has to have.
const LEAST: usize = 2;
/// Growth of the coarse cells from one to the next that one axis at least has to stay below. Cells that grow faster along all
/// three are for a contact zone at the fine corner and do not resolve it; their solution is a worse start than none: with a
/// growth of nine the active sets wander for 40 cycles. Towards a face or an edge even a growth of 5.5 is a good start.
const GROWTH: f64 = 2.5;

/// A case on a coarser block.
pub(crate) struct CoarserCase {
    pub case: Case,
    /// Node coordinates along each axis, length. Nodes are numbered along x first, then along y.
    pub axes: [Vec<f64>; 3],
}

impl CoarserCase {
    /// If the mesh is a block that has one.
    pub(crate) fn of(case: &Case) -> Option<CoarserCase> {
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
        let growth = |c: usize| block.grading[c].ln().abs() / (cells[c] - 1) as f64;
        if (0..3).all(|c| growth(c) > GROWTH.ln()) {
            return None;
        }
        let coarse = Block { cells, element, ..block.clone() };
        let grids = Grids::new(vec![(None, Grid::of_block(&coarse, vec![(None, case.mesh.placing.by)]).ok()?)]);
        let stride = [1, cells[0] + 1, (cells[0] + 1) * (cells[1] + 1)];
        let axis = |c: usize| (0..=cells[c]).map(|i| grids.place((i * stride[c]) as u64)[c]).collect();
        let axes = [axis(0), axis(1), axis(2)];
        let mut case = case.clone();
        case.mesh.source = MeshSource::Block(coarse);
        Some(CoarserCase { case, axes })
    }
}

/// The coarser problem, if there is one. What goes wrong here costs only the better start.
pub(crate) fn coarser(case: &Case) -> Option<Coarser> {
    let CoarserCase { case, axes } = CoarserCase::of(case)?;
    Some(Coarser { prepared: Box::new(prepare(&case).ok()?), axes })
}
