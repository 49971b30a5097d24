//! The two sides of the cut of a bolt.

use super::bolts::Bolt;
use super::regions;
use crate::Error;
use crate::fem::DofMap;
use crate::io::case::{AgainstSpec, BoltSpec, Case, Region, Spot};
use crate::mesh::v3::{V3, dot, mean, scale};
use crate::mesh::{Mesh, ascending};

/// Nodes on the side of the cut its axis comes from, those of the cut included, and on the other.
pub(crate) fn sides(mesh: &Mesh, bolt: &Bolt) -> [Vec<bool>; 2] {
    let at_cut = |node: u32| bolt.cut.nodes.binary_search(&node).is_ok();
    let mut beyond = reached(mesh, &bolt.cut.cells, &at_cut);
    let mut before = reached(mesh, &others(mesh, &bolt.cut.nodes, &bolt.cut.cells), &at_cut);
    for &node in &bolt.cut.nodes {
        (beyond[node as usize], before[node as usize]) = (false, true);
    }
    [before, beyond]
}

/// Nodes reached from cells through others without crossing the nodes of the cut.
fn reached(mesh: &Mesh, from: &[u32], at_cut: &dyn Fn(u32) -> bool) -> Vec<bool> {
    let mut reached = vec![false; mesh.nodes.len()];
    mesh.cell_nodes(from).iter().filter(|&&node| !at_cut(node)).for_each(|&node| reached[node as usize] = true);
    // A sweep in either direction passes through a part whose cells are numbered along it.
    let count = mesh.cell_count();
    let mut grows = true;
    while grows {
        grows = false;
        for cell in (0..count).chain((0..count).rev()) {
            let nodes = mesh.cell(cell).1;
            if nodes.iter().any(|&node| reached[node as usize]) {
                for &node in nodes.iter().filter(|&&node| !at_cut(node)) {
                    grows |= !std::mem::replace(&mut reached[node as usize], true);
                }
            }
        }
    }
    reached
}

/// Cells at the nodes of a cut that are not among `cells` (ascending).
fn others(mesh: &Mesh, nodes: &[u32], cells: &[u32]) -> Vec<u32> {
    let touches = |cell: &[u32]| cell.iter().any(|node| nodes.binary_search(node).is_ok());
    let all = (0u32..).zip(mesh.cell_iter()).filter(|(_, (_, of_cell))| touches(of_cell)).map(|(cell, _)| cell);
    all.filter(|cell| cells.binary_search(cell).is_err()).collect()
}

/// Boundary faces of bodies that contacts name.
fn contact_faces(mesh: &Mesh, case: &Case) -> impl Iterator<Item = u32> {
    contact_regions(case).flat_map(|(region, spot)| regions::boundary_faces(mesh, region, spot))
}

/// What contacts name of bodies.
fn contact_regions(case: &Case) -> impl Iterator<Item = (&Region, &Spot)> {
    case.contacts.iter().flat_map(|contact| {
        let other = match &contact.against {
            AgainstSpec::Surface { region, .. } => Some((region, &contact.spot)),
            _ => None,
        };
        std::iter::once((&contact.on, &contact.spot)).chain(other)
    })
}

/// Of the cosine between the normal of a face and the axis of a bolt: from here on what presses on the face counts as force along it.
const ACROSS: f64 = 0.5;

/// Faces at the nodes of a cut on which contact or a load acts along the axis.
pub(super) fn pressed_at(mesh: &Mesh, case: &Case, nodes: &[u32], axis: V3) -> Vec<u32> {
    let on_faces = case.loads.iter().filter(|load| !load.kind.on_cells() && !load.kind.at_nodes());
    let loaded = on_faces.filter_map(|load| load.on.as_ref().map(|region| (region, &load.spot)));
    let is_at_cut = |&face: &u32| {
        let at_cut = mesh.faces[face as usize].nodes().iter().any(|node| nodes.binary_search(node).is_ok());
        at_cut && dot(mesh.face_normal(face as usize), axis).abs() >= ACROSS
    };
    let loaded = loaded.flat_map(|(region, spot)| regions::boundary_faces(mesh, region, spot));
    let faces = contact_faces(mesh, case).chain(loaded);
    ascending(faces.filter(is_at_cut))
}

/// The cells at a cut whose sides are drawn together, and the direction into them: those beyond it, unless faces of these are `pressed` at nodes
/// of the cut. Displacements of these nodes are those of the other side, so that forces there would act on the wrong part: a cut at
/// the height of the head's bearing face would leave a sixth of the force out. Then the cells before it are taken, drawn the other way.
pub(super) fn whole_sides(
    mesh: &Mesh,
    spec: &BoltSpec,
    (beyond, nodes, axis): (Vec<u32>, &[u32], V3),
    pressed: &[u32],
) -> Result<(Vec<u32>, V3), Error> {
    if pressed.is_empty() {
        return Ok((beyond, axis));
    }
    let beyond = ascending(beyond);
    let is_beyond = |face: &&u32| beyond.binary_search(&mesh.faces[**face as usize].cell).is_ok();
    let Some(&face) = pressed.iter().find(is_beyond) else { return Ok((beyond, axis)) };
    if pressed.iter().all(|face| is_beyond(&face)) {
        return Ok((others(mesh, nodes, &beyond), scale(-1.0, axis)));
    }
    let at = mean(mesh.faces[face as usize].nodes().iter().map(|&node| mesh.nodes[node as usize]));
    let what = format!(
        "the cut of bolt \"{}\" runs through nodes of faces on both of its sides that contact or loads press on, one of them at {at:.4?}",
        spec.name
    );
    Err(spec
        .spot
        .error(what, "cut the shank further from its ends: give another `point`, or refine the mesh between them"))
}

/// Of the cosine between two directions.
const ROUNDING: f64 = 1e-9;

/// Whether a held degree of freedom resists a motion along the axis.
pub(super) fn holds_along(dofs: &DofMap, dof: u32, axis: V3) -> bool {
    dot(axis, dofs.direction(dof)).abs() > ROUNDING
}

/// Refuses a force through a cut beyond which nothing can take it: no contact, no support and no load.
pub(super) fn refuse_loose(mesh: &Mesh, case: &Case, dofs: &DofMap, bolt: &Bolt) -> Result<(), Error> {
    let others = !case.couplings.is_empty() || !case.equations.is_empty() || !case.springs.is_empty();
    if !bolt.is_by_force() || others || !case.cyclic.is_empty() {
        return Ok(());
    }
    let mut taken = vec![false; mesh.nodes.len()];
    // A plane of symmetry along the bolt takes nothing of its force.
    let held = dofs.prescribed.iter().filter(|&&dof| holds_along(dofs, dof, bolt.cut.axis)).map(|dof| dof / 3);
    held.for_each(|node| taken[node as usize] = true);
    // Contact node by node names nodes that make up no face.
    for (region, spot) in contact_regions(case) {
        regions::nodes(mesh, region, spot)?.into_iter().for_each(|node| taken[node as usize] = true);
    }
    for load in &case.loads {
        let Some(region) = &load.on else { return Ok(()) };
        regions::nodes(mesh, region, &load.spot)?.into_iter().for_each(|node| taken[node as usize] = true);
    }
    let is_loose = |side: &Vec<bool>| !side.iter().zip(&taken).any(|(side, taken)| *side && *taken);
    if !sides(mesh, bolt).iter().any(is_loose) {
        return Ok(());
    }
    let what = format!(
        "bolt \"{}\" has a force, and nothing can take it on one side of its cut: neither contact nor a support or a load",
        bolt.name
    );
    let remedy = "cut the shank between the surfaces that the bolt clamps: give another `point`, or name the contacts of its ends";
    Err(bolt.spot.error(what, remedy))
}
