//! Where contact reaches a sharp edge, at which pressures may grow without bound.

use std::collections::HashMap;

use crate::contact::{Counterpart, Pair, still};
use crate::fem::DofMap;
use crate::friction::PointState;
use crate::mesh::v3::{V3, cross, dot, sub, unit};
use crate::mesh::{Face, Mesh};
use crate::run::pose::Prepared;
use crate::run::pose::frames::PointFrame;
use crate::run::solve::Outcome;
use crate::run::solve::tractions::Tractions;

/// Faces whose normals have a smaller cosine meet at a sharp edge: 30 degrees, more than facets of round bodies.
const SHARP: f64 = 0.866;

/// Of the squares of the components of a normal along directions that are held: from here on it is held whole.
const HELD: f64 = 1.0 - 1e-6;

/// Whether a face is a plane of symmetry, beyond which the body goes on: all its corners stay in it, and some may move along it.
fn is_of_symmetry(dofs: &DofMap, face: &Face, normal: V3) -> bool {
    let held = |node: u32| still(dofs, node).map(|direction| dot(direction, normal).powi(2)).sum::<f64>() > HELD;
    let is_free = |node: u32| still(dofs, node).count() < 3;
    let corners = || face.corners().iter().copied();
    corners().all(held) && corners().any(is_free)
}

/// The nodes of `faces` at edges where the boundary of the body turns sharply, ascending.
fn at_sharp_edges(mesh: &Mesh, dofs: &DofMap, faces: &[u32]) -> Vec<u32> {
    let nodes = mesh.face_nodes(faces);
    let is_of_surface = |node: &u32| nodes.binary_search(node).is_ok();
    // The first normal at each edge, by its corners.
    let mut seen: HashMap<[u32; 2], V3> = HashMap::new();
    let mut sharp = Vec::new();
    for face in mesh.faces.iter().filter(|face| face.corners().iter().any(is_of_surface)) {
        let corners = face.corners();
        let [a, b, c] = [0, 1, corners.len() - 1].map(|k| mesh.nodes[corners[k] as usize]);
        let Some(normal) = unit(cross(sub(b, a), sub(c, a))) else { continue };
        if is_of_symmetry(dofs, face, normal) {
            continue;
        }
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
    let (mesh, dofs, surface) = (&prepared.mesh, &prepared.model.dofs, prepared.surfaces.get(number)?);
    let sharp = at_sharp_edges(mesh, dofs, &surface.faces);
    let closed = pair.points.clone().filter(|&j| outcome.solution.states[j] != PointState::Open);
    let own = closed.filter(|&j| sharp.binary_search(&frames[j].node).is_ok());
    let own = own.map(|j| (tractions.points[j][0], frames[j].node));
    let mut others = Vec::new();
    if let Counterpart::Surface(master) = &surface.against {
        let sharp = at_sharp_edges(mesh, dofs, &master.faces);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Field, Fix, dof_map};
    use crate::mesh::{Block, BlockElement, block};

    /// The places of sharp edges of the top of a unit cube of 2³ cells, where the components `held` of the face at x = 0 are held.
    fn sharp(held: [bool; 3], element: BlockElement) -> Vec<V3> {
        let mesh =
            block(&Block { size: [1.0; 3], cells: [2; 3], origin: [0.0; 3], grading: [1.0; 3], element }).unwrap();
        let side = mesh.face_nodes(&mesh.group("x-min").unwrap().faces);
        let value = held.map(|held| held.then_some(Field::Constant(0.0)));
        let dofs = dof_map(&mesh, &[Fix { nodes: side, value, ..Fix::default() }], 1.0).unwrap();
        let nodes = at_sharp_edges(&mesh, &dofs, &mesh.group("z-max").unwrap().faces);
        nodes.into_iter().map(|node| mesh.nodes[node as usize]).collect()
    }

    #[test]
    fn a_plane_of_symmetry_makes_no_edge_and_a_clamp_does() {
        for element in [BlockElement::Hex8, BlockElement::Hex20, BlockElement::Tet10Six] {
            let rim = |x: &V3| x[..2].iter().any(|c| *c == 0.0 || *c == 1.0);
            let (free, clamped) = (sharp([false; 3], element), sharp([true; 3], element));
            assert!(free.iter().all(rim) && free == clamped && free.len() >= 8, "{free:?}");
            // Held along its normal: what is left of the rim are three sides.
            let mirrored: Vec<V3> = free.iter().copied().filter(|x| x[0] > 0.0 || x[1] == 0.0 || x[1] == 1.0).collect();
            assert_eq!(sharp([true, false, false], element), mirrored);
        }
    }
}
