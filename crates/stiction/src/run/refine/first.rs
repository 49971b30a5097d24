//! The mesh that refinement begins with.

use std::collections::HashMap;

use crate::Error;
use crate::io::case::{AccuracySpec, Case, MeshSource, MeshSpec, Region};
use crate::mesh::v3::dot;
use crate::mesh::{
    Bisection, BlockElement, Face, Mesh, MeshNote, MeshNotes, Order, ascending, round_facets, tetrahedra,
};
use crate::run::pose::{MemoryLimit, made_mesh, place, regions};

/// Boundary edges of linear cells at which the surface bends by more are edges of the part, degrees; as for obstacles from files.
const FEATURE_ANGLE: f64 = 30.0;

/// The mesh of the case as tetrahedra. Blocks and rings are made of the best of them, and of quadratic ones to begin with: rings then
/// have their radii. Linear cells of files become quadratic with their facets made round.
///
/// # Errors
/// If the mesh cannot be made, read or cut, or has more displacements than `max_unknowns` allows.
pub(super) fn first(
    case: &Case,
    accuracy: &AccuracySpec,
    limit: &MemoryLimit,
) -> Result<(Bisection, MeshNotes), Error> {
    let mut spec = case.mesh.clone();
    let (order, element) = match accuracy.quadratic {
        true => (Order::Quadratic, BlockElement::Tet10Six),
        false => (Order::Linear, BlockElement::Tet4Six),
    };
    made_of(&mut spec, element);
    let (mesh, mut notes) = made_mesh(&spec, limit)?;
    let is_linear = mesh.cells.iter().any(|block| block.kind.linear() == block.kind && !block.is_empty());
    let faces = held_piece_by_piece(&mesh, case)?;
    if faces > 0 {
        notes.0.push(MeshNote::HeldPieceByPiece { faces });
    }
    let mut bisection = tetrahedra(&mesh, order).map_err(|error| place::at(&spec.spot, error))?;
    let displacements = 3 * bisection.mesh.nodes.len();
    if accuracy.max_unknowns.is_some_and(|most| displacements > most) {
        let what = format!("the first mesh has {displacements} displacements as tetrahedra, more than `max_unknowns`");
        let remedy = format!("begin with a coarser mesh, or allow more than {displacements}");
        return Err(place::at(&spec.spot, Error::new("", what, remedy)));
    }
    if is_linear && accuracy.quadratic {
        let rounded = round_facets(&mut bisection, FEATURE_ANGLE);
        if rounded.moved + rounded.straight > 0 {
            let (moved, straight, most) = (rounded.moved, rounded.straight, rounded.most);
            notes.0.push(MeshNote::RoundedFacets { moved, most, straight });
        }
    }
    Ok((bisection, notes))
}

/// Boundary faces all of whose corners supports hold in one direction, no one of which has them all. Where two have them, these are sets
/// of nodes on one smooth surface: between two surfaces a layer of single cells has faces with the corners of both, and nothing is meant
/// to hold these.
fn held_piece_by_piece(mesh: &Mesh, case: &Case) -> Result<usize, Error> {
    let mut holders: HashMap<u32, [Vec<usize>; 3]> = HashMap::new();
    for (number, fix) in case.fixes.iter().enumerate() {
        for node in regions::nodes(mesh, &fix.on, &fix.spot)? {
            let of_node = holders.entry(node).or_default();
            (0..3).filter(|&c| fix.symmetry || fix.value[c].is_some()).for_each(|c| of_node[c].push(number));
        }
    }
    let is_piecewise = |lists: &[&Vec<usize>]| {
        let all = ascending(lists.iter().flat_map(|list| list.iter().copied()));
        let covered = |pair: [usize; 2]| lists.iter().all(|list| pair.iter().any(|fix| list.contains(fix)));
        !lists.iter().any(|list| list.is_empty()) && !all.iter().any(|&a| all.iter().any(|&b| covered([a, b])))
    };
    let of_sets: Vec<usize> = (0..case.fixes.len()).filter(|&fix| is_set_of_nodes(mesh, &case.fixes[fix].on)).collect();
    let mut beside: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    if of_sets.len() > 1 {
        let edges =
            |(number, face): (usize, &Face)| edges(face.corners()).map(move |edge| (edge, number)).collect::<Vec<_>>();
        mesh.faces
            .iter()
            .enumerate()
            .flat_map(edges)
            .for_each(|(edge, face)| beside.entry(edge).or_default().push(face));
    }
    let has = |nodes: &[u32], fix: usize, c: usize| {
        nodes.iter().all(|node| holders.get(node).is_some_and(|of_node| of_node[c].contains(&fix)))
    };
    // A set has a face next to this one, beyond an edge at which the surface does not bend.
    let goes_on = |number: usize, fix: usize, c: usize| {
        let own = mesh.face_normal(number);
        let is_smooth = |other: usize| dot(own, mesh.face_normal(other)) > FEATURE_ANGLE.to_radians().cos();
        edges(mesh.faces[number].corners())
            .filter(|edge| has(edge, fix, c))
            .flat_map(|edge| &beside[&edge])
            .any(|&other| other != number && has(mesh.faces[other].corners(), fix, c) && is_smooth(other))
    };
    let is_of_sets = |number: usize, c: usize| {
        let corners = mesh.faces[number].corners();
        let has_all = (0..case.fixes.len()).any(|fix| has(corners, fix, c));
        !has_all && of_sets.iter().filter(|&&fix| goes_on(number, fix, c)).count() > 1
    };
    let is_found = |&number: &usize| {
        let corners: Option<Vec<_>> = mesh.faces[number].corners().iter().map(|node| holders.get(node)).collect();
        let Some(corners) = corners else { return false };
        let held = |c: usize| corners.iter().all(|of_node| !of_node[c].is_empty());
        let piecewise = |c: usize| is_piecewise(&corners.iter().map(|of_node| &of_node[c]).collect::<Vec<_>>());
        (0..3).any(|c| held(c) && (piecewise(c) || of_sets.len() > 1 && is_of_sets(number, c)))
    };
    Ok((0..mesh.faces.len()).filter(is_found).count())
}

/// Whether a region is groups that name nodes.
fn is_set_of_nodes(mesh: &Mesh, region: &Region) -> bool {
    let of_nodes = |name: &str| mesh.group(name).is_some_and(|group| !group.nodes.is_empty());
    matches!(region, Region::Groups(names) if names.iter().all(|(name, _)| of_nodes(name)))
}

/// The edges of a face with these corners, each by its ends, ascending.
fn edges(corners: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| [a.min(b), a.max(b)])
}

/// Makes blocks and rings of `element`.
fn made_of(spec: &mut MeshSpec, element: BlockElement) {
    match &mut spec.source {
        MeshSource::Block(block) => block.element = element,
        MeshSource::Ring(ring) => ring.element = element,
        MeshSource::Parts(parts) => parts.iter_mut().for_each(|(_, part)| made_of(part, element)),
        MeshSource::File { .. } | MeshSource::Given(_) => {}
    }
}
