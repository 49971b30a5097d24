//! How wide the edges of contact and of slip are that a mesh can tell.

use super::Outcome;
use super::contact_terms::parts;
use crate::contact::{ContactSurface, Pair};
use crate::friction::PointState;
use crate::mesh::v3::{cross, norm, sub};
use crate::run::pose::Prepared;
use crate::run::pose::frames::frames;

/// What a mesh does not tell of a pair: an edge runs through the triangles between the nodes of its faces, and where in them is not known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::run) struct Edge {
    /// Area of the triangles with points in contact and open ones, length squared.
    pub area: f64,
    /// Friction that sticking points in triangles with slipping ones leave below their limits, force; whatever its direction, as the shears of such
    /// points turn when they slip.
    pub friction: f64,
}

/// The edges of contact and of slip of each pair.
pub(in crate::run) fn edges(prepared: &Prepared, outcome: &Outcome) -> Vec<Edge> {
    let (problem, mesh, lambda) = (&prepared.problem, &prepared.mesh, &outcome.solution.lambda);
    let frames = frames(prepared);
    let left = |j: usize| {
        let [normal, t1, t2] = problem.rows(j).map(|row| lambda[row]);
        let left = problem.contact.friction[j].bound(normal) - t1.hypot(t2);
        // Bonded points have no limit.
        if left.is_finite() { left.max(0.0) } else { 0.0 }
    };
    let of_pair = |(surface, pair): (&ContactSurface, &Pair)| {
        let nodes = mesh.face_nodes(&surface.faces);
        // Of a node without a point nothing is known.
        let mut point: Vec<Option<usize>> = vec![None; nodes.len()];
        for j in pair.points.clone() {
            if let Ok(place) = nodes.binary_search(&frames[j].node) {
                point[place] = Some(j);
            }
        }
        let place = |node: u32| nodes.binary_search(&node).ok();
        let state = |place: usize| point[place].map(|j| outcome.solution.states[j]);
        let mut edge = Edge::default();
        let mut beside_slip = vec![false; nodes.len()];
        for &number in &surface.faces {
            let face = mesh.faces[number as usize].nodes();
            for part in parts(face.len()) {
                let corners = part.map(|k| face[k]);
                let has =
                    |wanted: PointState| corners.iter().filter_map(|&node| state(place(node)?)).any(|s| s == wanted);
                let (slips, sticks) = (has(PointState::Slip), has(PointState::Stick));
                if has(PointState::Open) && (slips || sticks) {
                    let [a, b, c] = corners.map(|node| mesh.nodes[node as usize]);
                    edge.area += 0.5 * norm(cross(sub(b, a), sub(c, a)));
                }
                if slips && sticks {
                    corners.iter().filter_map(|&node| place(node)).for_each(|at| beside_slip[at] = true);
                }
            }
        }
        let sticking = point.iter().zip(beside_slip).filter_map(|(point, beside)| point.filter(|_| beside));
        edge.friction = sticking.filter(|&j| outcome.solution.states[j] == PointState::Stick).map(left).sum();
        edge
    };
    prepared.surfaces.iter().zip(&problem.labels.pairs).map(of_pair).collect()
}
