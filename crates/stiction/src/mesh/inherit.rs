//! What cells made of others inherit: groups, arrays, and fields at their nodes.

use std::collections::HashMap;

use super::components::root;
use super::face_table::sorted;
use super::shape::TET_EDGES;
use super::v3::{V3, dot, sub};
use super::{Buckets, CellKind, Group, Mesh, MeshArrays, RawCells, RawMesh, ascending, build};
use crate::Error;

/// No node, no face.
pub(super) const NONE: u32 = u32::MAX;

/// Local faces of a tetrahedron by the corner opposite to each.
pub(super) const OPPOSITE: [usize; 4] = [2, 3, 1, 0];

/// The values of a field at new nodes by those at nodes with lower numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rows {
    /// Number of the first new node.
    first: usize,
    start: Vec<usize>,
    /// Nodes and weights; the weights are dyadic fractions, which single precision has exactly.
    entries: Vec<(u32, f32)>,
}

impl Rows {
    pub(super) fn new(first: usize) -> Rows {
        Rows { first, start: vec![0], entries: Vec::new() }
    }

    /// Number of old nodes.
    pub(super) fn first(&self) -> usize {
        self.first
    }

    /// Adds the row of the next new node.
    pub(super) fn push(&mut self, row: impl IntoIterator<Item = (u32, f32)>) {
        self.entries.extend(row);
        self.start.push(self.entries.len());
    }

    /// The rows of the new nodes in their order.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[(u32, f32)]> {
        self.start.windows(2).map(|range| &self.entries[range[0]..range[1]])
    }

    /// Appends the values at the new nodes to the `components` values at each old node.
    pub(super) fn extend(&self, values: &mut Vec<f64>, components: usize) {
        values.truncate(components * self.first);
        for row in self.iter() {
            for c in 0..components {
                let at = |&(node, weight): &(u32, f32)| f64::from(weight) * values[components * node as usize + c];
                values.push(row.iter().map(at).sum());
            }
        }
    }
}

/// The faces whose children are looked for: those of the boundary by their numbers, after them faces of groups between
/// two cells.
pub(super) struct Labels {
    /// The label of each face of each cell of the old mesh, [`NONE`] without one.
    pub of_cell: Vec<[u32; 6]>,
    /// Corners of the faces between cells, in ascending order of their nodes, ascending.
    interior: Vec<[u32; 4]>,
    /// Whether a cell has it.
    owned: Vec<bool>,
    boundary: usize,
}

impl Labels {
    pub(super) fn new(mesh: &Mesh) -> Labels {
        let mut of_cell = vec![[NONE; 6]; mesh.cell_count()];
        for (number, face) in (0..).zip(&mesh.faces) {
            of_cell[face.cell as usize][face.local as usize] = number;
        }
        let interior = ascending(mesh.groups.iter().flat_map(|group| &group.interior_faces).map(|&face| sorted(face)));
        let mut owned = vec![false; interior.len()];
        let boundary = mesh.faces.len();
        if !interior.is_empty() {
            let mut touched = vec![false; mesh.nodes.len()];
            interior.as_flattened().iter().filter(|&&n| n != NONE).for_each(|&n| touched[n as usize] = true);
            for ((kind, cell), labels) in mesh.cell_iter().zip(&mut of_cell) {
                for (local, face) in kind.linear().faces().iter().enumerate() {
                    if face.iter().any(|&i| !touched[cell[i] as usize]) {
                        continue;
                    }
                    let corners = sorted(std::array::from_fn(|i| face.get(i).map_or(NONE, |&i| cell[i])));
                    if let Ok(place) = interior.binary_search(&corners) {
                        owned[place] = true;
                        labels[local] = (boundary + place) as u32;
                    }
                }
            }
        }
        Labels { of_cell, interior, owned, boundary }
    }
}

/// Tetrahedra made of the cells of a mesh.
pub(super) struct Children<'a> {
    pub old: &'a Mesh,
    /// The nodes of the old mesh, and the new ones after them.
    pub nodes: Vec<V3>,
    pub kind: CellKind,
    pub cells: Vec<u32>,
    /// The old cell of each.
    pub parent: &'a [u32],
    /// The label of the face opposite to each corner.
    pub labels: Vec<[u32; 4]>,
    pub rows: &'a Rows,
}

impl Children<'_> {
    /// The mesh of the children; `named` are the new nodes that belong to a group because its nodes do.
    pub(super) fn mesh(self, faces: &Labels, named: impl Fn(&Group) -> Vec<u32>) -> Result<Mesh, Error> {
        let Children { old, nodes, kind, cells, parent, labels, rows } = self;
        let cells = vec![RawCells { kind, nodes: cells, ids: Vec::new() }];
        let (mut mesh, _) = build(RawMesh { nodes, cells, ..RawMesh::default() })?;
        let label_of_face = |face: &super::Face| {
            let opposite = OPPOSITE.iter().position(|&local| local == face.local as usize);
            opposite.map_or(NONE, |corner| labels[face.cell as usize][corner])
        };
        let of_face: Vec<u32> = mesh.faces.iter().map(label_of_face).collect();
        mesh.groups = (old.groups.iter())
            .map(|group| Group {
                name: group.name.clone(),
                cells: members(&group.cells, old.cell_count(), parent),
                faces: members(&group.faces, faces.boundary, &of_face),
                interior_faces: Vec::new(),
                nodes: [group.nodes.clone(), named(group)].concat(),
            })
            .collect();
        for (group, of) in mesh.groups.iter_mut().zip(&old.groups) {
            if !of.interior_faces.is_empty() {
                between(group, of, faces, &mesh.cells[0], &labels);
            }
            group.nodes.sort_unstable();
            group.nodes.dedup();
        }
        mesh.arrays = arrays(&old.arrays, rows, parent, &of_face);
        Ok(mesh)
    }
}

/// Numbers of the children whose parent is one of `parents`, which are below `count`; ascending.
fn members(parents: &[u32], count: usize, of: &[u32]) -> Vec<u32> {
    let mut is_in = vec![false; if parents.is_empty() { 0 } else { count }];
    parents.iter().for_each(|&parent| is_in[parent as usize] = true);
    (0..).zip(of).filter(|(_, parent)| is_in.get(**parent as usize) == Some(&true)).map(|(child, _)| child).collect()
}

/// The children of the faces of a group between cells, with the middles of their edges.
fn between(group: &mut Group, of: &Group, faces: &Labels, cells: &super::Cells, labels: &[[u32; 4]]) {
    let mut is_in = vec![false; faces.interior.len()];
    for face in &of.interior_faces {
        match faces.interior.binary_search(&sorted(*face)) {
            Ok(place) if faces.owned[place] => is_in[place] = true,
            // A face of no cell has no children.
            _ => group.interior_faces.push(*face),
        }
    }
    for (number, labels) in labels.iter().enumerate() {
        for (corner, &label) in labels.iter().enumerate() {
            if label == NONE || (label as usize) < faces.boundary || !is_in[label as usize - faces.boundary] {
                continue;
            }
            let (cell, local) = (cells.cell(number), cells.kind.faces()[OPPOSITE[corner]]);
            group.interior_faces.push([cell[local[0]], cell[local[1]], cell[local[2]], NONE]);
            group.nodes.extend(local[3..].iter().map(|&i| cell[i]));
        }
    }
    group.interior_faces.sort_unstable_by_key(|face| (sorted(*face), *face));
    group.interior_faces.dedup_by_key(|face| sorted(*face));
}

fn arrays(old: &MeshArrays, rows: &Rows, parent: &[u32], of_face: &[u32]) -> MeshArrays {
    let mut arrays = old.clone();
    arrays.nodes.iter_mut().for_each(|array| rows.extend(&mut array.values, 1));
    for array in &mut arrays.cells {
        array.values = parent.iter().map(|&cell| array.values[cell as usize]).collect();
        if !array.faces.is_empty() {
            let own = |(face, label): (u32, &u32)| {
                let place = array.faces.binary_search_by_key(label, |own| own.0).ok()?;
                Some((face, array.faces[place].1))
            };
            array.faces = (0..).zip(of_face).filter_map(own).collect();
        }
    }
    arrays
}

/// The edges of tetrahedra, by their lower and then their higher node.
pub(super) struct Edges {
    /// Where those of each lower node begin.
    start: Vec<usize>,
    high: Vec<u32>,
}

impl Edges {
    pub(super) fn new(nodes: usize, corners: &[[u32; 4]]) -> Edges {
        let of = |range: std::ops::Range<usize>| {
            corners[range].iter().flat_map(|cell| TET_EDGES.map(|[i, j]| edge(cell[i], cell[j])))
        };
        let mut each = Buckets::new(nodes, corners.len(), of);
        let (mut start, mut high) = (vec![0], Vec::with_capacity(each.items.len() / 4));
        for range in each.start.windows(2) {
            let bucket = &mut each.items[range[0]..range[1]];
            bucket.sort_unstable();
            for (i, &node) in bucket.iter().enumerate() {
                if i == 0 || bucket[i - 1] != node {
                    high.push(node);
                }
            }
            start.push(high.len());
        }
        Edges { start, high }
    }

    pub(super) fn len(&self) -> usize {
        self.high.len()
    }

    /// Both ends of each in their order.
    pub(super) fn iter(&self) -> impl Iterator<Item = [u32; 2]> {
        let of = |(low, range): (u32, &[usize])| self.high[range[0]..range[1]].iter().map(move |&high| [low, high]);
        (0..).zip(self.start.windows(2)).flat_map(of)
    }

    /// The number of the edge between two nodes.
    pub(super) fn find(&self, a: u32, b: u32) -> Option<usize> {
        let [low, high] = edge(a, b);
        let start = self.start[low as usize];
        self.high[start..self.start[low as usize + 1]].iter().position(|&node| node == high).map(|place| start + place)
    }
}

/// Corners of all edges of a kind of cell, with nodes in their middles or without.
pub(super) fn edges_of(kind: CellKind) -> &'static [[usize; 2]] {
    match kind.linear() {
        CellKind::Tet4 | CellKind::Tet10 => CellKind::Tet10.edges(),
        CellKind::Hex8 | CellKind::Hex20 => CellKind::Hex20.edges(),
        CellKind::Wedge6 | CellKind::Wedge15 => CellKind::Wedge15.edges(),
    }
}

/// The lower end of an edge first.
pub(super) fn edge(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// An order of edges: by their lengths, where these are equal by their nodes. Lengths that differ by rounding are equal,
/// since single precision rounds them alike; `unit` is the square of a length.
pub(super) fn longer(nodes: &[V3], unit: f64, [a, b]: [u32; 2]) -> (u32, [u32; 2]) {
    let [low, high] = edge(a, b);
    let along = sub(nodes[high as usize], nodes[low as usize]);
    // The bits of numbers that are not negative are in the order of the numbers.
    (((dot(along, along) / unit) as f32).to_bits(), [low, high])
}

/// Edges between corners that lie in what a set of nodes stands for; ascending.
///
/// A set does not say what that is. Of its nodes that edges join, if every one belongs to a cell that has all its corners in the set it is
/// the volume of such cells; else, by the same rule, the surface of boundary faces, then of faces; else it is a curve or
/// points. Three nodes of a curve may be corners of one triangle where it turns: its longest edge is then a chord. Single
/// points that are neighbours cannot be told from a curve.
pub(super) fn edges_between(mesh: &Mesh, set: &[u32], unit: f64) -> Vec<[u32; 2]> {
    let parts = joined(mesh, set).into_iter().filter(|part| part.len() > 1);
    ascending(parts.flat_map(|part| edges_within(mesh, &part, unit)))
}

/// The nodes of a set in parts, the corners of each joined by edges of cells between nodes of the set.
fn joined(mesh: &Mesh, set: &[u32]) -> Vec<Vec<u32>> {
    let mut is_in = vec![false; mesh.nodes.len()];
    set.iter().for_each(|&node| is_in[node as usize] = true);
    let mut parent: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    for (kind, cell) in mesh.cell_iter() {
        for [a, b] in edges_of(kind).iter().map(|&[i, j]| [cell[i], cell[j]]) {
            if is_in[a as usize] && is_in[b as usize] {
                let [a, b] = [a, b].map(|node| root(&mut parent, node));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut parts: Vec<Vec<u32>> = Vec::new();
    let mut place = HashMap::new();
    for &node in set {
        let next = parts.len();
        let part = *place.entry(root(&mut parent, node)).or_insert(next);
        if part == next {
            parts.push(Vec::new());
        }
        parts[part].push(node);
    }
    parts
}

fn edges_within(mesh: &Mesh, set: &[u32], unit: f64) -> Vec<[u32; 2]> {
    let mut is_in = vec![false; mesh.nodes.len()];
    set.iter().for_each(|&node| is_in[node as usize] = true);
    let whole = |corners: &[u32]| corners.iter().all(|&node| is_in[node as usize]);
    // Kinds and corners of the cells that touch the set.
    let cells = mesh.cell_iter().map(|(kind, cell)| (kind.linear(), &cell[..kind.linear().nodes()]));
    let near: Vec<(CellKind, &[u32])> = cells.filter(|(_, cell)| cell.iter().any(|&n| is_in[n as usize])).collect();
    let edges =
        |&(kind, cell): &(CellKind, &[u32])| edges_of(kind).iter().map(|&[i, j]| edge(cell[i], cell[j])).collect();
    let faces = |&(kind, cell): &(CellKind, &[u32])| -> Vec<Vec<u32>> {
        kind.faces().iter().map(|face| face.iter().map(|&i| cell[i]).collect()).collect()
    };
    let faces = || near.iter().flat_map(faces).filter(|face| whole(face));
    let round = |face: &[u32]| (0..face.len()).map(|i| edge(face[i], face[(i + 1) % face.len()])).collect();

    let corners = ascending(near.iter().flat_map(|(_, cell)| *cell).copied().filter(|&n| is_in[n as usize])).len();
    let covering = |edges: Vec<Vec<[u32; 2]>>| {
        let edges = ascending(edges.concat());
        (ascending(edges.as_flattened().iter().copied()).len() == corners).then_some(edges)
    };
    let boundary = || mesh.faces.iter().map(super::Face::corners).filter(|face| whole(face));
    let curve = || {
        let longest = |face: Vec<u32>| -> Option<[u32; 2]> {
            let edges: Vec<[u32; 2]> = round(&face);
            edges.into_iter().max_by_key(|&edge| longer(&mesh.nodes, unit, edge)).filter(|_| face.len() == 3)
        };
        let chords = ascending(faces().filter_map(longest));
        let all: Vec<Vec<[u32; 2]>> = near.iter().map(edges).collect();
        let is_along = |edge: &[u32; 2]| whole(edge) && chords.binary_search(edge).is_err();
        ascending(all.into_iter().flatten().filter(is_along))
    };
    covering(near.iter().filter(|(_, cell)| whole(cell)).map(edges).collect())
        .or_else(|| covering(boundary().map(round).collect()))
        .or_else(|| covering(faces().map(|face| round(&face)).collect()))
        .unwrap_or_else(curve)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Block, BlockElement, block};

    /// What one part of a set stands for does not depend on the others: a face beside single points, all of a layer beside an edge.
    #[test]
    fn parts_of_a_set_that_no_edge_joins_stand_for_themselves() {
        for element in [BlockElement::Tet4Six, BlockElement::Tet4Five { parity: 0 }, BlockElement::Hex8] {
            let (size, cells, origin, grading) = ([4.0; 3], [4; 3], [0.0; 3], [1.0; 3]);
            let mesh = block(&Block { size, cells, origin, grading, element }).unwrap();
            let nodes = |is_in: &dyn Fn(V3) -> bool| -> Vec<u32> {
                (0..).zip(&mesh.nodes).filter(|(_, x)| is_in(**x)).map(|(node, _)| node).collect()
            };
            let within = |list: &[u32]| edges_between(&mesh, list, 1.0);
            let face = nodes(&|[.., z]| z == 0.0);
            let layer = nodes(&|[.., z]| z <= 1.0);
            let edge = nodes(&|[x, _, z]| x == 0.0 && z == 4.0);
            let point = nodes(&|x| x == [4.0; 3]);
            assert_eq!((within(&edge).len(), within(&point).len()), (4, 0));
            for part in [&face, &layer] {
                let all = ascending([&part[..], &edge, &point].concat());
                assert_eq!(within(&all), ascending([within(part), within(&edge)].concat()), "{element:?}");
            }
            let on_face = |[a, b]: &[u32; 2]| [a, b].iter().all(|&&node| mesh.nodes[node as usize][2] == 0.0);
            assert!(within(&face).len() >= 40 && within(&face).iter().all(on_face), "{element:?}");
        }
    }
}
