//! From what a file says to a valid mesh.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::face_table::FaceTable;
use super::notes::SHOWN;
use super::v3::V3;
use super::{Bounds, CellKind, Cells, Face, Mesh, MeshNote, MeshNotes, RawMesh, arrays, ascending, check, groups};
use crate::Error;

/// Node numbers that a thread looks through at a time.
const AT_A_TIME: usize = 1 << 14;

/// Boundary nodes closer than this fraction of the mesh's diagonal are reported as coincident.
const COINCIDENT: f64 = 1e-9;

/// Checks a mesh, finds its boundary and matches its groups to it.
///
/// Faces and outward normals follow from the cells alone. Nodes of no cell are dropped, the others keep their order.
/// Errors name cells that are inverted, flat, collapsed, given twice, or overlap their neighbours, and coordinates
/// that are not finite, by their numbers in the file. The result does not depend on the number of threads.
///
/// # Errors
/// If cells are inverted, flat, collapsed, given twice or overlap, or coordinates are not finite: with their numbers in the file.
pub fn build(mut raw: RawMesh) -> Result<(Mesh, MeshNotes), Error> {
    check::numbers(&raw)?;
    raw.cells.retain(|block| !block.nodes.is_empty());
    let mut notes = Vec::new();
    let raw_groups = std::mem::take(&mut raw.groups);
    let former = drop_orphans(&mut raw, &mut notes);
    check::shapes(&raw)?;
    let (mut raw_arrays, array_faces) = (std::mem::take(&mut raw.arrays), std::mem::take(&mut raw.array_faces));

    let (table, seen) = FaceTable::new(&raw);
    check::neighbours(&raw, &seen)?;
    let faces: Vec<Face> = seen.boundary.iter().map(|&face| table.face(face)).collect();
    notes.extend(coincident_nodes(&raw.nodes, &faces, &|node| raw.node_id(node)));
    note_unjoined(&raw, &table, &faces, &mut notes);

    arrays::match_faces(&mut raw_arrays, &array_faces, &former, &table, &seen.boundary);
    let match_group = |g| groups::group(g, &former, &table, &seen.boundary, &faces, &mut notes);
    let groups = raw_groups.into_iter().map(match_group).collect();
    drop(table);
    let cells = raw.cells.into_iter().map(|block| Cells { kind: block.kind, nodes: block.nodes }).collect();
    Ok((Mesh { nodes: raw.nodes, cells, faces, groups, arrays: raw_arrays }, MeshNotes(notes)))
}

/// The nodes as they were before those of no cell were dropped.
pub(super) struct Former {
    /// The new number of each, or `u32::MAX` if it was dropped.
    pub kept: Vec<u32>,
    /// Their numbers in the file; empty if counted from 1.
    ids: Vec<u64>,
}

impl Former {
    /// The number in the file of former node `i`.
    pub(super) fn id(&self, i: usize) -> u64 {
        self.ids.get(i).copied().unwrap_or(i as u64 + 1)
    }

    /// The new numbers of the corners of a face; none if one of them was dropped.
    pub(super) fn now(&self, corners: [u32; 4]) -> Option<[u32; 4]> {
        let now = corners.map(|n| if n == u32::MAX { n } else { self.kept[n as usize] });
        let whole = !now[..3].contains(&u32::MAX) && (now[3] == u32::MAX) == (corners[3] == u32::MAX);
        whole.then_some(now)
    }
}

/// Removes the nodes of no cell.
fn drop_orphans(raw: &mut RawMesh, notes: &mut Vec<MeshNote>) -> Former {
    let used: Vec<AtomicBool> = raw.nodes.par_iter().map(|_| AtomicBool::new(false)).collect();
    let mark = |&n: &u32| {
        // What is set already is left alone: writing it again would take it from another thread.
        if !used[n as usize].load(Ordering::Relaxed) {
            used[n as usize].store(true, Ordering::Relaxed);
        }
    };
    let nodes = raw.cells.par_iter().flat_map(|block| block.nodes.par_chunks(AT_A_TIME));
    nodes.for_each(|some| some.iter().for_each(mark));
    let mut kept = vec![u32::MAX; raw.nodes.len()];
    let mut orphans = Vec::new();
    for ((i, slot), used) in kept.iter_mut().enumerate().zip(used) {
        if used.into_inner() {
            *slot = (i - orphans.len()) as u32;
        } else {
            orphans.push(i);
        }
    }
    let mut former = Former { kept, ids: Vec::new() };
    if orphans.is_empty() {
        former.ids.clone_from(&raw.node_ids);
        return former;
    }
    former.ids = std::mem::take(&mut raw.node_ids);
    let first = orphans.iter().take(SHOWN).map(|&i| former.id(i)).collect();
    notes.push(MeshNote::OrphanNodes { count: orphans.len(), first });
    let remain = || (0..former.kept.len()).filter(|&i| former.kept[i] != u32::MAX);
    raw.node_ids = remain().map(|i| former.id(i)).collect();
    raw.nodes = remain().map(|i| raw.nodes[i]).collect();
    for array in &mut raw.arrays.nodes {
        array.values = remain().filter_map(|i| array.values.get(i).copied()).collect();
    }
    for node in raw.cells.iter_mut().flat_map(|block| &mut block.nodes) {
        *node = former.kept[*node as usize];
    }
    former
}

/// Notes nodes of the boundary that lie at the same place without being joined, by their `number` in the file.
pub(crate) fn coincident_nodes(nodes: &[V3], faces: &[Face], number: &dyn Fn(usize) -> u64) -> Option<MeshNote> {
    let on_boundary = ascending(faces.iter().flat_map(Face::nodes).copied());
    let distance = COINCIDENT * Bounds::around(on_boundary.iter().map(|&n| nodes[n as usize])).diagonal();
    let (pairs, first) = check::coincident(nodes, &on_boundary, distance);
    first.map(|first| MeshNote::CoincidentNodes { pairs, distance, first: first.map(|n| number(n as usize)) })
}

/// Notes quadrilaterals whose corners also carry triangles: both are boundary though they touch.
fn note_unjoined(raw: &RawMesh, table: &FaceTable, faces: &[Face], notes: &mut Vec<MeshNote>) {
    if raw.cells.iter().all(|block| block.kind.linear() != CellKind::Tet4) {
        return;
    }
    let touches = |f: &&Face| match *f.corners() {
        [a, b, c, d] => [[a, b, c], [b, c, d], [c, d, a], [d, a, b]]
            .iter()
            .any(|t| !table.find([t[0], t[1], t[2], u32::MAX]).is_empty()),
        _ => false,
    };
    let unjoined: Vec<&Face> = faces.iter().filter(touches).collect();
    if !unjoined.is_empty() {
        let first = unjoined.iter().take(SHOWN).map(|f| raw.cell_id(f.cell as usize)).collect();
        notes.push(MeshNote::UnjoinedFaces { count: unjoined.len(), first });
    }
}

#[cfg(test)]
#[path = "build_tests.rs"]
mod tests;
