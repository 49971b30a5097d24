//! Where contact reaches a sharp edge, at which pressures may grow without bound.

use std::collections::HashMap;

use crate::contact::{Counterpart, Pair};
use crate::friction::PointState;
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, cross, dot, sub, unit};
use crate::run::pose::Prepared;
use crate::run::pose::frames::PointFrame;
use crate::run::solve::Outcome;
use crate::run::solve::tractions::Tractions;

/// Faces whose normals have a smaller cosine meet at a sharp edge: 30 degrees, more than facets of round bodies.
const SHARP: f64 = 0.866;

/// The nodes of `faces` at edges where the boundary of the body turns sharply, ascending.
fn at_sharp_edges(mesh: &Mesh, faces: &[u32]) -> Vec<u32> {
    let nodes = mesh.face_nodes(faces);
    let is_of_surface = |node: &u32| nodes.binary_search(node).is_ok();
    // The first normal at each edge, and whether another face turns away from it. Edges by their corners.
    let mut seen: HashMap<[u32; 2], V3> = HashMap::new();
    let mut sharp = Vec::new();
    for face in mesh.faces.iter().filter(|face| face.corners().iter().any(is_of_surface)) {
        let corners = face.corners();
        let [a, b, c] = [0, 1, corners.len() - 1].map(|k| mesh.nodes[corners[k] as usize]);
        let Some(normal) = unit(cross(sub(b, a), sub(c, a))) else { continue };
        for k in 0..corners.len() {
            let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
            if !is_of_surface(&a) || !is_of_surface(&b) {
                continue;
            }
            let first = *seen.entry([a.min(b), a.max(b)]).or_insert(normal);
            if dot(first, normal) < SHARP {
                sharp.extend([a, b]);
                sharp.extend(face.nodes().get(corners.len() + k));
            }
        }
    }
    sharp.sort_unstable();
    sharp.dedup();
    sharp
}

/// The largest pressure of a contact at nodes at sharp edges of either body, and where it is; `None` where contact reaches none.
pub(super) fn largest_at_sharp_edge(
    prepared: &Prepared,
    outcome: &Outcome,
    (number, pair): (usize, &Pair),
    frames: &[PointFrame],
    tractions: &Tractions,
) -> Option<(f64, V3)> {
    let (mesh, surface) = (&prepared.mesh, prepared.surfaces.get(number)?);
    let sharp = at_sharp_edges(mesh, &surface.faces);
    let closed = pair.points.clone().filter(|&j| outcome.solution.states[j] != PointState::Open);
    let own = closed.filter(|&j| sharp.binary_search(&frames[j].node).is_ok());
    let own = own.map(|j| (tractions.points[j][0], frames[j].node));
    let mut others = Vec::new();
    if let Counterpart::Surface(master) = &surface.against {
        let sharp = at_sharp_edges(mesh, &master.faces);
        let nodes = mesh.face_nodes(&master.faces);
        let received = nodes.into_iter().zip(&tractions.masters[number]);
        others.extend(received.filter_map(|(node, traction)| {
            let pressure = (*traction)?[0];
            sharp.binary_search(&node).is_ok().then_some((pressure, node))
        }));
    }
    let largest =
        own.chain(others).filter(|(pressure, _)| *pressure > 0.0).reduce(|a, b| if b.0 > a.0 { b } else { a });
    largest.map(|(pressure, node)| (pressure, mesh.nodes[node as usize]))
}
