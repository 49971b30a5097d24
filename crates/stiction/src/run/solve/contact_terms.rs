//! What the laws of contact and friction miss between the nodes, for the marking of cells.
//!
//! At each node either the gap or the pressure vanishes, and sliding takes all of the friction there is. Between a node in
//! contact and an open one, or a sticking and a sliding one, both are there at once. `2 int (p g + s |w| - q . w)` is what
//! this adds to a bound of the squared error, see [`bound`](crate::accuracy::bound): `p` pressure, `g` gap, `s` limit of
//! friction, `q` shear traction, `w` slip. It tells where the edges of contact and of sliding are too coarse.

use super::Outcome;
use crate::mesh::v3::{V3, add, cross, dot, norm, scale, sub};
use crate::run::pose::Prepared;
use crate::run::pose::frames::frames;

/// Of a contact point: pressure, gap, limit of friction, shear traction and slip.
#[derive(Debug, Clone, Copy, Default)]
struct State {
    pressure: f64,
    gap: f64,
    limit: f64,
    shear: V3,
    slip: V3,
}

impl State {
    fn added(&self, other: &State) -> State {
        State {
            pressure: self.pressure + other.pressure,
            gap: self.gap + other.gap,
            limit: self.limit + other.limit,
            shear: add(self.shear, other.shear),
            slip: add(self.slip, other.slip),
        }
    }

    /// Power per area of what the laws forbid, with `slid` the length of the slip.
    fn missed(&self, slid: f64) -> f64 {
        self.pressure * self.gap + self.limit * slid - dot(self.shear, self.slip)
    }
}

/// For each face of a contact surface its cell and twice the integral, energy.
pub(crate) fn contact_terms(prepared: &Prepared, outcome: &Outcome) -> Vec<(u32, f64)> {
    let (problem, mesh) = (&prepared.problem, &prepared.mesh);
    let frames = frames(prepared);
    let gap_and_slip = problem.gap_and_slip(&outcome.solution.u);
    let m = problem.points();
    let mut terms = Vec::new();
    for (surface, pair) in prepared.surfaces.iter().zip(&problem.labels.pairs) {
        let nodes = mesh.face_nodes(&surface.faces);
        let mut states = vec![State::default(); nodes.len()];
        for j in pair.points.clone() {
            let Ok(place) = nodes.binary_search(&frames[j].node) else { continue };
            let (share, friction) = (problem.labels.unity_sum[j], problem.contact.friction[j]);
            // Force over area: means over neighbours would have a pressure where there is a gap.
            let [pressure, q1, q2] = problem.rows(j).map(|row| outcome.solution.lambda[row] / problem.labels.area[j]);
            let shear = frames[j].tangential([q1, q2]);
            let slip = frames[j].tangential([-gap_and_slip[m + j], -gap_and_slip[2 * m + j]]);
            let limit = friction.bound(outcome.solution.lambda[j]) / problem.labels.area[j];
            // What the solver leaves of a gap or of a pressure is none, and bonded points have no law.
            if limit.is_finite() {
                let gap = if outcome.solution.lambda[j] > 0.0 { 0.0 } else { gap_and_slip[j] / share };
                states[place] = State { pressure, gap, limit, shear, slip: scale(1.0 / share, slip) };
            }
        }
        for &number in &surface.faces {
            let face = &mesh.faces[number as usize];
            let at = |k: usize| {
                let node = face.nodes()[k];
                let state = nodes.binary_search(&node).map_or(State::default(), |place| states[place]);
                (mesh.nodes[node as usize], state)
            };
            let sum: f64 = parts(face.nodes().len()).iter().map(|part| of_triangle(part.map(at))).sum();
            terms.push((face.cell, 2.0 * sum));
        }
    }
    terms
}

/// Triangles between the nodes of a face.
pub(super) fn parts(nodes: usize) -> &'static [[usize; 3]] {
    match nodes {
        3 => &[[0, 1, 2]],
        4 => &[[0, 1, 2], [0, 2, 3]],
        6 => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
        _ => &[[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 7], [5, 6, 7]],
    }
}

/// The integral over a triangle of what is missed, all fields linear between its nodes.
fn of_triangle(corners: [(V3, State); 3]) -> f64 {
    let [a, b, c] = corners.map(|(place, _)| place);
    let area = 0.5 * norm(cross(sub(b, a), sub(c, a)));
    let states = corners.map(|(_, state)| state);
    let lengths = states.map(|state| norm(state.slip));
    let whole = states.iter().fold(State::default(), |sum, state| sum.added(state));
    let own: f64 = states.iter().zip(lengths).map(|(state, slid)| state.missed(slid)).sum();
    area / 12.0 * (whole.missed(lengths.iter().sum()) + own).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [V3; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    fn of(states: [State; 3]) -> f64 {
        of_triangle([0, 1, 2].map(|k| (CORNERS[k], states[k])))
    }

    /// `int x (1 - x - y)` over the triangle is 1/24.
    #[test]
    fn between_contact_and_open_pressure_meets_a_gap() {
        let closed = State { pressure: 3.0, ..State::default() };
        let open = State { gap: 2.0, ..State::default() };
        assert!((of([closed, open, State::default()]) - 6.0 / 24.0).abs() < 1e-15);
        assert_eq!(of([closed; 3]), 0.0);
        assert_eq!(of([open; 3]), 0.0);
    }

    #[test]
    fn between_stick_and_slip_friction_is_not_used_up() {
        let sliding = State { pressure: 1.0, limit: 2.0, shear: [2.0, 0.0, 0.0], slip: [0.5, 0.0, 0.0], gap: 0.0 };
        let sticking = State { shear: [0.5, 0.0, 0.0], slip: [0.0; 3], ..sliding };
        assert!(of([sliding; 3]).abs() < 1e-15);
        assert!(of([sticking; 3]).abs() < 1e-15);
        // At one node 1.5 of the limit are left, at another the slip is 0.5.
        assert!((of([sliding, sliding, sticking]) - 1.5 * 0.5 * 2.0 / 24.0).abs() < 1e-15);
    }
}
