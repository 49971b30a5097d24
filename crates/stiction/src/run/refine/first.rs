//! The mesh that refinement begins with.

use std::collections::HashMap;

use crate::Error;
use crate::io::case::{AccuracySpec, Case, MeshSource, MeshSpec};
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

/// Boundary faces all of whose corners supports hold in one direction, no one and no two of which have them all: between two surfaces a
/// layer of single cells has faces with the corners of both, and nothing is meant to hold these.
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
    let is_found = |face: &&Face| {
        let corners: Option<Vec<_>> = face.corners().iter().map(|node| holders.get(node)).collect();
        corners
            .is_some_and(|corners| (0..3).any(|c| is_piecewise(&corners.iter().map(|of| &of[c]).collect::<Vec<_>>())))
    };
    Ok(mesh.faces.iter().filter(is_found).count())
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
