//! Groups of a file matched to the cells and faces of the mesh.

use super::build::Former;
use super::face_table::{FaceTable, sorted};
use super::notes::SHOWN;
use super::{Face, Group, MeshNote, RawGroup, ascending};

/// The group in the numbers of the mesh; `boundary` are the numbers in `table` of the mesh's `faces`, ascending.
pub(super) fn group(
    group: RawGroup,
    former: &Former,
    table: &FaceTable,
    boundary: &[u32],
    faces: &[Face],
    notes: &mut Vec<MeshNote>,
) -> Group {
    let kept = &former.kept;
    let mut out = Group { name: group.name, cells: group.cells, ..Group::default() };
    let mut between = 0;
    let mut loose = 0;
    for face in group.faces {
        // a node of no cell: the face cannot be expressed in nodes of the mesh
        let Some(corners) = former.now(face) else {
            loose += 1;
            continue;
        };
        match *table.find(corners) {
            [only] => out.faces.extend(boundary.binary_search(&only).ok().map(|i| i as u32)),
            ref owners => {
                out.interior_faces.push(corners);
                if let Some(&owner) = owners.first() {
                    let face = table.face(owner);
                    out.nodes.extend(&face.nodes()[face.corners().len()..]);
                }
                *if owners.is_empty() { &mut loose } else { &mut between } += 1;
            }
        }
    }
    let lost: Vec<u32> = group.nodes.iter().copied().filter(|&n| kept[n as usize] == u32::MAX).collect();
    out.nodes.extend(group.nodes.iter().map(|&n| kept[n as usize]).filter(|&n| n != u32::MAX));
    out.faces.extend(skin(group.skin, faces));
    for list in [&mut out.cells, &mut out.faces, &mut out.nodes] {
        list.sort_unstable();
        list.dedup();
    }
    if group.faces_of_nodes && out.faces.is_empty() {
        out.faces = spanned(&out.nodes, faces);
    }
    out.interior_faces.sort_unstable_by_key(|f| (sorted(*f), *f));
    out.interior_faces.dedup_by_key(|f| sorted(*f));

    let name = || out.name.clone();
    if between > 0 {
        notes.push(MeshNote::InteriorFaces { group: name(), count: between });
    }
    if loose > 0 {
        notes.push(MeshNote::LooseFaces { group: name(), count: loose });
    }
    if !lost.is_empty() {
        let first = lost.iter().take(SHOWN).map(|&n| former.id(n as usize)).collect();
        notes.push(MeshNote::GroupNodesDropped { group: name(), count: lost.len(), first });
    }
    if out.cells.is_empty() && out.faces.is_empty() && out.interior_faces.is_empty() && out.nodes.is_empty() {
        notes.push(MeshNote::EmptyGroup { group: name() });
    }
    out
}

/// Numbers of the boundary faces of these cells.
fn skin(mut cells: Vec<u32>, faces: &[Face]) -> Vec<u32> {
    if cells.is_empty() {
        return cells;
    }
    cells.sort_unstable();
    let of_cells = faces.iter().enumerate().filter(|(_, face)| cells.binary_search(&face.cell).is_ok());
    of_cells.map(|(number, _)| number as u32).collect()
}

/// Numbers of the boundary faces all of whose nodes are in `nodes`, ascending; none unless each node has such a face.
fn spanned(nodes: &[u32], faces: &[Face]) -> Vec<u32> {
    let within = |face: &Face| face.nodes().iter().all(|node| nodes.binary_search(node).is_ok());
    let spanned: Vec<u32> = (0..faces.len() as u32).filter(|&f| within(&faces[f as usize])).collect();
    let covered = ascending(spanned.iter().flat_map(|&f| faces[f as usize].nodes()));
    if covered.len() == nodes.len() { spanned } else { Vec::new() }
}
