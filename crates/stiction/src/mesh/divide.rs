//! A mesh divided among ranks: the piece of each.

use super::{CellArray, CellKind, Cells, Face, Group, Mesh, MeshArrays, NodeArray, ascending, beside};
use crate::ranks::{Wire, put, take};

/// The mesh of one part: its nodes and all cells at them, and what [`pieces`] adds. Nodes and cells keep their order.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshPiece {
    /// With the named groups and the numbers of the arrays, as far as they are here; some groups may be empty.
    pub mesh: Mesh,
    /// The number of each node in the whole mesh, ascending.
    pub nodes: Vec<u64>,
    /// The part that each node belongs to.
    pub owner: Vec<u32>,
    /// The number of each cell in the whole mesh.
    pub cells: Vec<u64>,
}

/// The pieces of a mesh, one after the other: `owner` is the part of each node.
///
/// Each of `links` is a node whose displacement is measured from those after it. A piece has, beside the cells at own nodes,
/// those at nodes measured from own ones, and those at all from which a node of these cells is measured: with the displacements
/// so measured the rows of a matrix at own nodes are complete.
///
/// All pieces together take the time of one pass over the mesh and their own sizes, however many they are.
pub fn pieces<'a>(
    mesh: &'a Mesh,
    owner: &'a [u32],
    parts: usize,
    links: &[Vec<u32>],
) -> impl Iterator<Item = MeshPiece> + use<'a> {
    let mut links = Links::new(mesh, links, (owner, parts));
    let mut cells_of = vec![Vec::new(); parts];
    for (cell, (_, nodes)) in mesh.cell_iter().enumerate() {
        for (k, &v) in nodes.iter().enumerate() {
            let part = owner[v as usize];
            if !nodes[..k].iter().any(|&w| owner[w as usize] == part) {
                cells_of[part as usize].push(cell as u32);
            }
        }
    }
    let named = Named::new(mesh);
    cells_of
        .into_iter()
        .enumerate()
        .map(move |(part, cells)| piece(mesh, owner, &named, links.around(part, mesh, cells)))
}

/// For each node a list of numbers.
struct Lists {
    start: Vec<u32>,
    of: Vec<u32>,
}

impl Lists {
    /// From pairs of a node below `count` and a number.
    fn new(count: usize, pairs: impl Iterator<Item = [u32; 2]> + Clone) -> Lists {
        let mut start = vec![0; count + 1];
        pairs.clone().for_each(|[v, _]| start[v as usize + 1] += 1);
        (0..count).for_each(|v| start[v + 1] += start[v]);
        let (mut next, mut of) = (start.clone(), vec![0; start[count] as usize]);
        for [v, number] in pairs {
            of[next[v as usize] as usize] = number;
            next[v as usize] += 1;
        }
        Lists { start, of }
    }

    fn at(&self, v: u32) -> &[u32] {
        &self.of[self.start[v as usize] as usize..self.start[v as usize + 1] as usize]
    }
}

/// Nodes that are told apart from those that have come before, again and again from the beginning.
struct Marks {
    last: Vec<u32>,
    now: u32,
}

impl Marks {
    fn begin(&mut self) {
        self.now += 1;
    }

    fn is_new(&mut self, v: u32) -> bool {
        std::mem::replace(&mut self.last[v as usize], self.now) != self.now
    }
}

/// Links between nodes, and the cells at these.
struct Links {
    /// From what a node is measured.
    from: Lists,
    /// The nodes measured from one.
    measured: Lists,
    /// Of each part the nodes from which others are measured.
    of_part: Vec<Vec<u32>>,
    cells: Lists,
    marks: Marks,
}

impl Links {
    fn new(mesh: &Mesh, links: &[Vec<u32>], (owner, parts): (&[u32], usize)) -> Links {
        let count = mesh.nodes.len();
        let pairs = || links.iter().flat_map(|link| link[1..].iter().map(|&other| [link[0], other]));
        let (from, measured) = (Lists::new(count, pairs()), Lists::new(count, pairs().map(|[v, other]| [other, v])));
        let is_linked = |v: u32| !from.at(v).is_empty() || !measured.at(v).is_empty();
        let mut cells = Vec::new();
        for (cell, (_, nodes)) in mesh.cell_iter().enumerate().filter(|_| !links.is_empty()) {
            cells.extend(nodes.iter().filter(|&&v| is_linked(v)).map(|&v| [v, cell as u32]));
        }
        let cells = Lists::new(count, cells.iter().copied());
        let mut of_part = vec![Vec::new(); parts];
        let are_measured = (0..count as u32).filter(|&v| !measured.at(v).is_empty());
        are_measured.for_each(|v| of_part[owner[v as usize] as usize].push(v));
        Links { from, measured, of_part, cells, marks: Marks { last: vec![0; count], now: 0 } }
    }

    /// The cells of a part, from those at its nodes; asked once.
    fn around(&mut self, part: usize, mesh: &Mesh, mut cells: Vec<u32>) -> Vec<u32> {
        let Links { from, measured, of_part, cells: at, marks } = self;
        let on_own = reached(std::mem::take(&mut of_part[part]), measured, marks);
        cells.extend(on_own.into_iter().flat_map(|v| at.at(v)));
        marks.begin();
        let nodes = cells.iter().flat_map(|&c| mesh.cell(c as usize).1).copied();
        let linked: Vec<u32> = nodes.filter(|&v| !from.at(v).is_empty() && marks.is_new(v)).collect();
        cells.extend(reached(linked, from, marks).into_iter().flat_map(|v| at.at(v)));
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}

/// What is reached from some nodes, again and again.
fn reached(mut begin: Vec<u32>, next: &Lists, marks: &mut Marks) -> Vec<u32> {
    marks.begin();
    let mut found = Vec::new();
    while let Some(v) = begin.pop() {
        let before = found.len();
        found.extend(next.at(v).iter().copied().filter(|&w| marks.is_new(w)));
        begin.extend(&found[before..]);
    }
    found
}

/// Faces by their cells, and groups by what is in them.
struct Named {
    /// Cells with their faces, ascending.
    faces: Vec<[u32; 2]>,
    /// Cells, faces and nodes with the groups that they are in, ascending.
    groups: [Vec<[u32; 2]>; 3],
}

impl Named {
    fn new(mesh: &Mesh) -> Named {
        let faces = ascending(mesh.faces.iter().zip(0..).map(|(face, f)| [face.cell, f]));
        let of: [fn(&Group) -> &[u32]; 3] = [|group| &group.cells, |group| &group.faces, |group| &group.nodes];
        let groups = || mesh.groups.iter().zip(0..);
        let groups = of.map(|of| ascending(groups().flat_map(|(group, k)| of(group).iter().map(move |&it| [it, k]))));
        Named { faces, groups }
    }

    /// The faces of cells, ascending.
    fn faces_of(&self, cells: &[u32]) -> Vec<u32> {
        ascending(cells.iter().flat_map(|&cell| beside(&self.faces, cell)))
    }

    /// Of each of `count` groups what is `here`, ascending, by the places there; `kind` 0 is of cells, 1 of faces, 2 of nodes.
    fn in_groups(&self, kind: usize, here: &[u32], count: usize) -> Vec<Vec<u32>> {
        let mut found = vec![Vec::new(); count];
        for (&it, k) in here.iter().zip(0..) {
            beside(&self.groups[kind], it).for_each(|group| found[group as usize].push(k));
        }
        found
    }
}

fn piece(mesh: &Mesh, owner: &[u32], named: &Named, cells: Vec<u32>) -> MeshPiece {
    let nodes = ascending(cells.iter().flat_map(|&c| mesh.cell(c as usize).1).copied());
    let place = |list: &[u32], number: u32| list.binary_search(&number).ok().map(|k| k as u32);
    let local = |v: u32| place(&nodes, v).unwrap_or(u32::MAX);
    let (mut blocks, mut first) = (Vec::new(), 0u32);
    for block in &mesh.cells {
        let end = first + block.len() as u32;
        let own = &cells[cells.partition_point(|&c| c < first)..cells.partition_point(|&c| c < end)];
        let of_block = own.iter().flat_map(|&c| block.cell((c - first) as usize)).map(|&v| local(v));
        let block = Cells { kind: block.kind, nodes: of_block.collect() };
        if !block.is_empty() {
            blocks.push(block);
        }
        first = end;
    }
    let faces = named.faces_of(&cells);
    let [mut cells_of, mut faces_of, mut nodes_of] =
        [(0, &cells), (1, &faces), (2, &nodes)].map(|(kind, here)| named.in_groups(kind, here, mesh.groups.len()));
    let group = |(k, group): (usize, &Group)| Group {
        name: group.name.clone(),
        cells: std::mem::take(&mut cells_of[k]),
        faces: std::mem::take(&mut faces_of[k]),
        interior_faces: Vec::new(),
        nodes: std::mem::take(&mut nodes_of[k]),
    };
    let at = |values: &[f64], here: &[u32]| here.iter().map(|&k| values[k as usize]).collect();
    let of_nodes = |array: &NodeArray| NodeArray { name: array.name.clone(), values: at(&array.values, &nodes) };
    let of_cells = |array: &CellArray| {
        let of_face = |(f, k): (&u32, u32)| {
            let place = array.faces.binary_search_by_key(f, |own| own.0).ok()?;
            Some((k, array.faces[place].1))
        };
        CellArray {
            name: array.name.clone(),
            values: at(&array.values, &cells),
            faces: faces.iter().zip(0..).filter_map(of_face).collect(),
        }
    };
    let mut piece = Mesh {
        nodes: nodes.iter().map(|&v| mesh.nodes[v as usize]).collect(),
        cells: blocks,
        faces: Vec::new(),
        groups: mesh.groups.iter().enumerate().map(group).collect(),
        arrays: MeshArrays {
            nodes: mesh.arrays.nodes.iter().map(of_nodes).collect(),
            cells: mesh.arrays.cells.iter().map(of_cells).collect(),
            others: Vec::new(),
        },
    };
    let own_face = |&f: &u32| {
        let Face { cell, local, .. } = mesh.faces[f as usize];
        let cell = place(&cells, cell).unwrap_or(u32::MAX);
        let (kind, nodes) = piece.cell(cell as usize);
        Face::of_cell(kind, nodes, cell, local)
    };
    piece.faces = faces.iter().map(own_face).collect();
    MeshPiece {
        mesh: piece,
        owner: nodes.iter().map(|&v| owner[v as usize]).collect(),
        nodes: nodes.into_iter().map(u64::from).collect(),
        cells: cells.into_iter().map(u64::from).collect(),
    }
}

impl MeshPiece {
    /// As a message.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut to = Vec::new();
        let Mesh { nodes, cells, faces, groups, .. } = &self.mesh;
        put(nodes, &mut to);
        put(&self.nodes, &mut to);
        put(&self.owner, &mut to);
        put(&self.cells, &mut to);
        let code = |kind: CellKind| CellKind::ALL.iter().position(|k| *k == kind).unwrap_or_default() as u32;
        put(&cells.iter().map(|block| code(block.kind)).collect::<Vec<u32>>(), &mut to);
        cells.iter().for_each(|block| put(&block.nodes, &mut to));
        put(&faces.iter().map(|face| [face.cell, u32::from(face.local)]).collect::<Vec<[u32; 2]>>(), &mut to);
        (groups.len() as u64).write(&mut to);
        for group in groups {
            put(group.name.as_bytes(), &mut to);
            [&group.cells, &group.faces, &group.nodes].into_iter().for_each(|list| put(list, &mut to));
        }
        put_arrays(&self.mesh.arrays, &mut to);
        to
    }

    /// The inverse of [`Self::to_bytes`].
    ///
    /// # Panics
    /// If the message is none of its making.
    pub fn from_bytes(bytes: &[u8]) -> MeshPiece {
        let mut from = bytes;
        let from = &mut from;
        let coordinates: Vec<[f64; 3]> = take(from);
        let (nodes, owner, numbers) = (take(from), take(from), take(from));
        let kinds: Vec<u32> = take(from);
        let cells = kinds.iter().map(|&k| Cells { kind: CellKind::ALL[k as usize], nodes: take(from) }).collect();
        let faces: Vec<[u32; 2]> = take(from);
        let (count, rest) = from.split_at(8);
        *from = rest;
        let group = |from: &mut &[u8]| Group {
            name: String::from_utf8_lossy(&take::<u8>(from)).into_owned(),
            cells: take(from),
            faces: take(from),
            interior_faces: Vec::new(),
            nodes: take(from),
        };
        let groups = (0..u64::read(count)).map(|_| group(from)).collect();
        let arrays = take_arrays(from);
        let mut mesh = Mesh { nodes: coordinates, cells, faces: Vec::new(), groups, arrays };
        let face = |&[cell, local]: &[u32; 2]| {
            let (kind, nodes) = mesh.cell(cell as usize);
            Face::of_cell(kind, nodes, cell, local as u8)
        };
        mesh.faces = faces.iter().map(face).collect();
        MeshPiece { mesh, nodes, owner, cells: numbers }
    }
}

fn put_arrays(arrays: &MeshArrays, to: &mut Vec<u8>) {
    put(&[arrays.nodes.len() as u64, arrays.cells.len() as u64], to);
    for NodeArray { name, values } in &arrays.nodes {
        put(name.as_bytes(), to);
        put(values, to);
    }
    for CellArray { name, values, faces } in &arrays.cells {
        put(name.as_bytes(), to);
        put(values, to);
        let (numbers, of_faces): (Vec<u32>, Vec<f64>) = faces.iter().copied().unzip();
        put(&numbers, to);
        put(&of_faces, to);
    }
}

fn take_arrays(from: &mut &[u8]) -> MeshArrays {
    let counts: Vec<u64> = take(from);
    let name = |from: &mut &[u8]| String::from_utf8_lossy(&take::<u8>(from)).into_owned();
    let nodes = (0..counts[0]).map(|_| NodeArray { name: name(from), values: take(from) }).collect();
    let of_cells = |from: &mut &[u8]| {
        let (name, values, numbers) = (name(from), take(from), take::<u32>(from));
        CellArray { name, values, faces: numbers.into_iter().zip(take::<f64>(from)).collect() }
    };
    MeshArrays { nodes, cells: (0..counts[1]).map(|_| of_cells(from)).collect(), others: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Block, BlockElement, Cuts, WeightedNode, block};
    use crate::ranks::Alone;

    #[test]
    fn parts_have_equal_weights_and_pieces_all_cells_and_faces_at_their_nodes() {
        for element in [BlockElement::Tet4Five { parity: 0 }, BlockElement::Hex8] {
            let (size, cells, grading) = ([3.0, 2.0, 1.0], [9, 6, 5], [1.0; 3]);
            let mut mesh = block(&Block { size, cells, origin: [0.0; 3], grading, element }).unwrap();
            let numbers = |count: usize| (0..count).map(|k| k as f64).collect::<Vec<f64>>();
            mesh.arrays.nodes.push(NodeArray { name: "n".into(), values: numbers(mesh.nodes.len()) });
            let faces =
                (0..mesh.faces.len() as u32).step_by(3).map(|face| (face, f64::from(mesh.faces[face as usize].cell)));
            let (name, faces) = ("c".into(), faces.collect());
            mesh.arrays.cells.push(CellArray { name, values: numbers(mesh.cell_count()), faces });
            let nodes: Vec<WeightedNode> = (mesh.nodes.iter().zip(0..))
                .map(|(&place, number)| WeightedNode { place, number, weight: 1.0 })
                .collect();
            let some = Group {
                name: "some".into(),
                cells: (1..mesh.cell_count() as u32).step_by(5).collect(),
                nodes: (2..mesh.nodes.len() as u32).step_by(7).collect(),
                ..Group::default()
            };
            mesh.groups.push(some);
            // Some nodes of the last layer hang on some of the first.
            let last = mesh.nodes.len() as u32 - 1;
            let links: Vec<Vec<u32>> = (0..20).map(|k| vec![last - k, k, k + 1]).collect();
            for parts in [1, 2, 3, 7] {
                let cuts = Cuts::new(&Alone, &nodes, parts);
                let owner: Vec<u32> = nodes.iter().map(|node| cuts.part(node.place, node.number)).collect();
                let mut counts = vec![0; parts];
                owner.iter().for_each(|&part| counts[part as usize] += 1);
                let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
                assert!(most - least <= parts, "{counts:?}");
                let mut volume = 0.0;
                for (part, piece) in pieces(&mesh, &owner, parts, &links).enumerate() {
                    assert_eq!(piece, MeshPiece::from_bytes(&piece.to_bytes()));
                    let MeshPiece { mesh: here, nodes, cells, .. } = &piece;
                    let as_numbers = |list: &[u64]| list.iter().map(|&k| k as f64).collect::<Vec<f64>>();
                    assert_eq!(here.arrays.nodes[0].values, as_numbers(nodes));
                    assert_eq!(here.arrays.cells[0].values, as_numbers(cells));
                    for (group, whole) in here.groups.iter().zip(&mesh.groups) {
                        let has = |list: &[u32], number: u64| list.iter().any(|&k| u64::from(k) == number);
                        for (list, all, numbers) in
                            [(&group.cells, &whole.cells, cells), (&group.nodes, &whole.nodes, nodes)]
                        {
                            let expected = (0u32..).zip(numbers).filter(|(_, number)| has(all, **number));
                            assert_eq!(*list, expected.map(|(k, _)| k).collect::<Vec<u32>>(), "{}", whole.name);
                        }
                        let number = |face: &Face| (cells[face.cell as usize], face.local);
                        let found = group.faces.iter().map(|&f| number(&here.faces[f as usize]));
                        let expected = whole.faces.iter().map(|&f| &mesh.faces[f as usize]);
                        let expected = expected.map(|face| (u64::from(face.cell), face.local));
                        let expected = expected.filter(|(cell, _)| cells.binary_search(cell).is_ok());
                        assert_eq!(found.collect::<Vec<_>>(), expected.collect::<Vec<_>>(), "{}", whole.name);
                    }
                    let faces = &here.arrays.cells[0].faces;
                    assert!(!faces.is_empty());
                    for &(face, value) in faces {
                        assert_eq!(value, cells[here.faces[face as usize].cell as usize] as f64);
                    }
                    let own = |v: u32| piece.owner[v as usize] as usize == part;
                    for (k, (_, list)) in here.cell_iter().enumerate() {
                        let whole: Vec<u64> = list.iter().map(|&v| nodes[v as usize]).collect();
                        let (_, expected) = mesh.cell(cells[k] as usize);
                        assert!(whole.iter().zip(expected).all(|(a, b)| *a == u64::from(*b)));
                        // Each cell counts where its first node belongs.
                        volume += if own(list[0]) { here.cell_volume(k) } else { 0.0 };
                    }
                    let here_all = |v: u32| {
                        let all = mesh.cell_iter().zip(0u64..).filter(|((_, list), _)| list.contains(&v));
                        all.map(|(_, cell)| cell).all(|cell| cells.binary_search(&cell).is_ok())
                    };
                    let owned = |v: u32| owner[v as usize] as usize == part;
                    for link in &links {
                        let measured = link[1..].iter().any(|&v| owned(v));
                        assert!(!measured || here_all(link[0]));
                        assert!(!(owned(link[0]) || measured) || link[1..].iter().all(|&v| here_all(v)));
                    }
                    let at_own = |nodes: &[u32], own: &dyn Fn(u32) -> bool| nodes.iter().any(|&v| own(v));
                    let in_whole = |v: u32| owner[v as usize] as usize == part;
                    let cells_there = mesh.cell_iter().filter(|(_, list)| at_own(list, &in_whole)).count();
                    assert_eq!(here.cell_iter().filter(|(_, list)| at_own(list, &own)).count(), cells_there);
                    let faces_there = mesh.faces.iter().filter(|face| at_own(face.nodes(), &in_whole)).count();
                    assert_eq!(here.faces.iter().filter(|face| at_own(face.nodes(), &own)).count(), faces_there);
                }
                assert!((volume - 6.0).abs() < 1e-12, "{volume}");
            }
        }
    }
}
