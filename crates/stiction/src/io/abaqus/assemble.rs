//! From a deck to a mesh.

use std::collections::{BTreeMap, HashSet};
use std::rc::Rc;

use super::deck::{Deck, Kind};
use super::elements::{Role, faces};
use super::place::{Model, place};
use super::sets::{Found, Resolver};
use crate::Error;
use crate::mesh::{CellKind, Mesh, MeshArrays, MeshNote, MeshNotes, RawCells, RawGroup, RawMesh, build};

/// Places the parts, collects cells and groups and builds the mesh.
pub(super) fn assemble(mut deck: Deck, scale: f64) -> Result<(Mesh, MeshNotes), Error> {
    let model = place(&mut deck)?;
    let mut notes = Vec::new();
    if !deck.skipped.is_empty() {
        notes.push(MeshNote::NotRead { what: std::mem::take(&mut deck.skipped) });
    }
    has_cells(&model)?;
    let groups = groups(&deck, &model, &mut notes)?;
    drop(deck);
    finish(model, groups, MeshArrays::default(), notes, scale)
}

fn has_cells(model: &Model) -> Result<(), Error> {
    if CellKind::ALL.iter().all(|&kind| model.count(kind) == 0) {
        let what = format!("there are no volume cells among its {} nodes", model.nodes.len());
        return Err(Error::new("", what, "write the solid elements too (C3D4, C3D6, C3D8, C3D10, C3D15 or C3D20)"));
    }
    Ok(())
}

/// Builds the mesh of a model with its groups and arrays.
pub(super) fn finish(
    mut model: Model,
    groups: Vec<RawGroup>,
    arrays: MeshArrays,
    mut notes: Vec<MeshNote>,
    scale: f64,
) -> Result<(Mesh, MeshNotes), Error> {
    has_cells(&model)?;
    let cells = CellKind::ALL.map(|kind| cells(&mut model, kind));
    let mut nodes = std::mem::take(&mut model.nodes);
    if scale != 1.0 {
        nodes.iter_mut().flatten().for_each(|x| *x *= scale);
    }
    let labels = std::mem::take(&mut model.node_labels);
    drop(model); // the build needs memory of its own
    let (mesh, built) =
        build(RawMesh { nodes, node_ids: ids(labels), cells: cells.into(), groups, arrays, ..RawMesh::default() })?;
    notes.extend(built.0);
    Ok((mesh, MeshNotes(notes)))
}

/// All cells of a kind; those of a single block are moved.
fn cells(model: &mut Model, kind: CellKind) -> RawCells {
    let (mut nodes, mut labels) = (Vec::new(), Vec::new());
    for block in model.blocks.iter_mut().filter(|block| block.role == Role::Cell(kind)) {
        if labels.is_empty() {
            (nodes, labels) = (std::mem::take(&mut block.nodes), std::mem::take(&mut block.labels));
        } else {
            nodes.append(&mut block.nodes);
            labels.append(&mut block.labels);
        }
    }
    RawCells { kind, nodes, ids: labels.into_iter().map(u64::from).collect() }
}

/// Numbers of nodes, empty if they are counted from 1.
fn ids(labels: Vec<u32>) -> Vec<u64> {
    if labels.iter().enumerate().all(|(i, &label)| label as usize == i + 1) {
        return Vec::new();
    }
    labels.into_iter().map(u64::from).collect()
}

/// A set on its way to a group.
struct Named {
    kind: Kind,
    name: String,
    found: Rc<Found>,
}

fn groups(deck: &Deck, model: &Model, notes: &mut Vec<MeshNote>) -> Result<Vec<RawGroup>, Error> {
    let mut groups: Vec<RawGroup> = Vec::new();
    // sets of one name stand together, in the order of their first
    let mut of_name: BTreeMap<String, usize> = BTreeMap::new();
    let mut named: Vec<Vec<Named>> = Vec::new();
    for set in found(deck, model, notes)? {
        let key = set.name.to_uppercase();
        let next = named.len();
        match *of_name.entry(key).or_insert(next) {
            at if at == next => named.push(vec![set]),
            at => named[at].push(set),
        }
    }
    for mut same in named {
        let rank = |set: &Named| [Kind::Surface, Kind::Nodes, Kind::Elements].iter().position(|&k| k == set.kind);
        same.sort_by_key(rank);
        let mut first: Option<(usize, Vec<u32>)> = None;
        for set in same {
            let nodes = if first.is_some() || set.kind != Kind::Elements { nodes(model, &set) } else { Vec::new() };
            match &first {
                Some((group, theirs)) if *theirs == nodes && !nodes.is_empty() => {
                    add(model, &set, &mut groups[*group])?
                }
                Some(_) => {
                    let suffix = if set.kind == Kind::Nodes { "nset" } else { "elset" };
                    let group = format!("{} ({suffix})", set.name);
                    notes.push(MeshNote::Renamed { name: set.name.clone(), group: group.clone() });
                    groups.push(RawGroup { name: group, ..RawGroup::default() });
                    let last = groups.len() - 1;
                    add(model, &set, &mut groups[last])?;
                }
                None => {
                    groups.push(RawGroup { name: set.name.clone(), ..RawGroup::default() });
                    let last = groups.len() - 1;
                    add(model, &set, &mut groups[last])?;
                    first = Some((last, nodes));
                }
            }
        }
    }
    Ok(groups)
}

/// The members of all sets that give groups.
fn found(deck: &Deck, model: &Model, notes: &mut Vec<MeshNote>) -> Result<Vec<Named>, Error> {
    let mut resolver = Resolver::new(deck, model);
    let mut all: Vec<Named> = Vec::new();
    let mut taken: HashSet<(Kind, String)> = HashSet::new();
    let several = model.scopes.len() > 2;
    for (scope, place) in model.scopes.iter().enumerate() {
        let part = &deck.parts[place.part];
        for kind in [Kind::Surface, Kind::Elements, Kind::Nodes] {
            for (number, set) in part.sets[kind as usize].list.iter().enumerate().filter(|(_, set)| !set.internal) {
                let found = resolver.members((scope, kind, number))?;
                // a set of the assembly goes before one of the only part
                let free = taken.insert((kind, set.name.to_uppercase()));
                let qualified = scope > 0 && (several || !free);
                let name = if qualified { format!("{}.{}", place.name, set.name) } else { set.name.clone() };
                if !found.missing.is_empty() {
                    let (count, first) =
                        (found.missing.len(), found.missing.iter().take(5).map(|&l| l.into()).collect());
                    notes.push(MeshNote::UnknownMembers { group: name.clone(), count, first });
                }
                all.push(Named { kind, name, found });
            }
        }
    }
    Ok(all)
}

/// The nodes of a set, ascending; of faces on the boundary, which nobody knows yet, none.
fn nodes(model: &Model, set: &Named) -> Vec<u32> {
    let mut nodes = set.found.nodes.clone();
    nodes.extend(set.found.elements.iter().flat_map(|&element| model.element_nodes(element)));
    if set.found.skin.is_empty() {
        nodes.extend(
            set.found.sides.iter().filter_map(|&side| corners(model, side)).flatten().filter(|&n| n != u32::MAX),
        );
    }
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Nodes of a face of an element; none if it has no such face.
pub(super) fn corners(model: &Model, (element, side): (u32, u8)) -> Option<[u32; 4]> {
    if let Some(face) = model.swept.as_ref().and_then(|swept| swept.face(element, side)) {
        return face;
    }
    let nodes = model.element_nodes(element);
    let mut corners = [u32::MAX; 4];
    match model.element(element).0.role {
        Role::Cell(kind) => {
            let local = faces(kind).get(side as usize)?;
            corners.iter_mut().zip(*local).for_each(|(corner, &i)| *corner = nodes[i]);
        }
        _ => return None,
    }
    Some(corners)
}

/// Adds the members of a set to a group.
fn add(model: &Model, set: &Named, group: &mut RawGroup) -> Result<(), Error> {
    let found = &set.found;
    group.nodes.extend(&found.nodes);
    group.faces_of_nodes |= !found.nodes.is_empty();
    for &element in &found.elements {
        match model.cell(element) {
            Some(cell) => group.cells.push(cell),
            None => flat(model, element, group),
        }
    }
    for &element in &found.skin {
        match model.cell(element) {
            Some(cell) => group.skin.push(cell),
            None => flat(model, element, group),
        }
    }
    for &(element, side) in &found.sides {
        let Some(corners) = corners(model, (element, side)) else {
            let (block, i) = model.element(element);
            let place = format!("surface {}", set.name);
            let what = format!("element {} has no face S{}", block.labels[i], side + 1);
            return Err(Error::new(place, what, "tetrahedra have faces S1 to S4, wedges S1 to S5, hexahedra S1 to S6"));
        };
        group.faces.push(corners);
    }
    Ok(())
}

/// Adds an element that is no cell.
fn flat(model: &Model, element: u32, group: &mut RawGroup) {
    let nodes = model.element_nodes(element);
    match model.element(element).0.role {
        Role::Face(count) => {
            // corners come first, of triangles three
            let fourth = if count.is_multiple_of(3) { u32::MAX } else { nodes[3] };
            group.faces.push([nodes[0], nodes[1], nodes[2], fourth]);
        }
        _ => group.nodes.extend(nodes),
    }
}
