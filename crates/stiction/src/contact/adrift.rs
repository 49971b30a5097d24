//! Motions of an answer that nothing resists: where bodies are along them is a matter of where the iteration began.

use super::among::Among;
use super::rigid::{FloatingBody, RigidMotions};
use super::{ContactProblem, Friction};

/// A motion that moves no point that holds by more than this part of its largest displacement is free.
const UNSEEN: f64 = 1e-6;

/// Forces of an answer at all points of a problem, `3m` (newton), and which points are closed.
#[derive(Clone, Copy)]
pub(crate) struct Held<'a> {
    pub lambda: &'a [f64],
    pub is_closed: &'a dyn Fn(usize) -> bool,
}

impl Held<'_> {
    /// Whether the row `i` of `B` holds what moves along it.
    pub(crate) fn holds(&self, problem: &ContactProblem, i: usize) -> bool {
        let m = problem.points();
        let (law, closed) = (&problem.contact.friction[i % m], (self.is_closed)(i % m));
        match law {
            Friction::Bonded => true,
            _ if i < m => closed || self.lambda[i] != 0.0,
            // Given friction holds points that are open as well.
            _ => self.lambda[i] != 0.0 || law.bound(if closed { f64::MAX } else { 0.0 }) > 0.0,
        }
    }
}

/// Independent rigid motions of the floating bodies, combinations of the columns of [`RigidMotions`], that move no point that holds. Bodies
/// that `are_left_out`, by their numbers among the floating ones, move in none of them.
pub(crate) fn adrift(
    (problem, motions): (&ContactProblem, &RigidMotions),
    held: Held,
    are_left_out: &dyn Fn(usize) -> bool,
    among: &Among,
) -> Vec<Vec<f64>> {
    if motions.is_empty() {
        return Vec::new();
    }
    let m = problem.points();
    let rows: Vec<usize> = (0..3 * m).filter(|&i| (among.point)(i % m) && held.holds(problem, i)).collect();
    let left_out = |(b, body): (usize, &FloatingBody)| vec![are_left_out(b); body.motions.len()];
    let left_out: Vec<bool> = (0..).zip(&motions.bodies).flat_map(left_out).collect();
    let jumps = motions.jumps(&problem.isotropic_rows());
    motions.without_jump_among(&jumps, (&rows, &left_out), problem.contact.B.max_abs(), UNSEEN, among)
}
