//! What contact in a given state leaves to small motions, for modes and for stiffnesses of joints.

use super::PointState;
use crate::contact::ContactProblem;
use crate::linalg::{Csr, null_space};

/// The rows of `B` that hold in a state, `c x n`: normal ones of the points in contact, then both tangential ones of those
/// that stick. Small motions `v` about the state have `C v = 0` as long as no point changes: sliding points keep their
/// friction and move along their tangents.
///
/// # Panics
/// If there is not one state for each point.
pub fn tied_rows(problem: &ContactProblem, states: &[PointState]) -> Csr {
    let m = problem.points();
    assert_eq!(states.len(), m);
    let points = |tied: &'static [PointState]| (0..m).filter(|&j| tied.contains(&states[j]));
    let normal = points(&[PointState::Stick, PointState::Slip]);
    let rows = normal.chain((1..3).flat_map(|k| points(&[PointState::Stick]).map(move |j| k * m + j)));
    let rows: Vec<u32> = rows.map(|row| row as u32).collect();
    problem.contact.B.select_rows(&rows)
}

/// A basis of these motions, `n x k`, see [`null_space`]. `Zᵀ K Z` is the stiffness of the bodies in this state of contact.
///
/// # Panics
/// If there is not one state for each point.
pub fn free_motions(problem: &ContactProblem, states: &[PointState]) -> Csr {
    null_space(&tied_rows(problem, states))
}
