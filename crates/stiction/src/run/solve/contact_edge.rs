//! How wide the edge of contact is that a mesh can tell.

use super::Outcome;
use super::contact_terms::parts;
use crate::contact::{ContactSurface, Pair};
use crate::friction::PointState;
use crate::mesh::v3::{cross, norm, sub};
use crate::run::pose::Prepared;
use crate::run::pose::frames::frames;

/// For each pair the area between points in contact and open ones, length squared: of triangles between the nodes of its faces those that
/// have both. The edge of contact runs through them, and where in them the mesh does not tell.
pub(in crate::run) fn edges(prepared: &Prepared, outcome: &Outcome) -> Vec<f64> {
    let (problem, mesh) = (&prepared.problem, &prepared.mesh);
    let frames = frames(prepared);
    let of_pair = |(surface, pair): (&ContactSurface, &Pair)| {
        let nodes = mesh.face_nodes(&surface.faces);
        // Of a node without a point nothing is known.
        let mut is_open: Vec<Option<bool>> = vec![None; nodes.len()];
        for j in pair.points.clone() {
            if let Ok(place) = nodes.binary_search(&frames[j].node) {
                is_open[place] = Some(outcome.solution.states[j] == PointState::Open);
            }
        }
        let known = |node: u32| nodes.binary_search(&node).ok().and_then(|place| is_open[place]);
        let of_face = |&number: &u32| -> f64 {
            let face = mesh.faces[number as usize].nodes();
            let with_both = parts(face.len()).iter().map(|part| part.map(|k| face[k])).filter(|corners| {
                let has = |open: bool| corners.iter().any(|&node| known(node) == Some(open));
                has(true) && has(false)
            });
            let area = |corners: [u32; 3]| {
                let [a, b, c] = corners.map(|node| mesh.nodes[node as usize]);
                0.5 * norm(cross(sub(b, a), sub(c, a)))
            };
            with_both.map(area).sum()
        };
        surface.faces.iter().map(of_face).sum()
    };
    prepared.surfaces.iter().zip(&problem.labels.pairs).map(of_pair).collect()
}
