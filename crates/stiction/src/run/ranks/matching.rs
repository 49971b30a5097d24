//! Cells of all ranks matched at their faces, and what of that lies at the surface of the whole.

use std::collections::BTreeSet;

use super::cells::{CellList, Kinds};
use super::elements::{Regions, distinct, place_of};
use super::homes::{Homes, Plan, leader};
use super::numbering::NONE;
use crate::mesh::v3::V3;
use crate::mesh::{CellKind, Cells, Face, Group, Meeting, Mesh, RawCells, RawMesh, ascending};
use crate::ranks::{Ranks, all_to_all, from_bytes, gather, to_bytes};

/// The cells at the faces whose leaders a rank keeps, as a mesh.
pub(super) struct Here {
    cells: CellList,
    /// Of the nodes in the whole, ascending.
    pub numbers: Vec<u64>,
    pub plan: Plan,
    pub raw: RawMesh,
}

impl Here {
    pub(super) fn new(
        ranks: &dyn Ranks,
        homes: &Homes,
        mut cells: CellList,
        kinds: &Kinds,
        places: &[V3],
        turns: bool,
    ) -> Here {
        let numbers = cells.node_numbers();
        let plan = Plan::new(ranks, homes, &numbers);
        let nodes = plan.fetch(ranks, places);
        let mut ids = cells.numbers.iter().map(|number| number + 1);
        let block = |block: Cells| {
            let ids = ids.by_ref().take(block.len()).collect();
            RawCells { kind: block.kind, nodes: block.nodes, ids }
        };
        let blocks = cells.blocks(kinds, &numbers).into_iter().map(block).collect();
        let node_ids = numbers.iter().map(|number| number + 1).collect();
        let mut raw = RawMesh { nodes, node_ids, cells: blocks, ..RawMesh::default() };
        if turns {
            raw.turn_wedges();
            cells.nodes = raw.cells.iter().flat_map(|block| &block.nodes).map(|&v| numbers[v as usize]).collect();
        }
        Here { cells, numbers, plan, raw }
    }

    /// Each cell is kept by one rank.
    pub(super) fn kept(&mut self, ranks: &dyn Ranks, homes: &Homes, kinds: &Kinds) -> CellList {
        let cells = std::mem::take(&mut self.cells);
        let mut kept = CellList::default();
        for (number, class, nodes) in cells.iter(kinds) {
            if keeper(homes, kinds.of(number), nodes) == ranks.rank() {
                kept.push(number, class, nodes);
            }
        }
        kept
    }

    /// Of each node that this rank keeps its kind, and the classes of each kind.
    pub(super) fn node_kinds(
        &self,
        ranks: &dyn Ranks,
        kept: &CellList,
        kinds: &Kinds,
        own: usize,
    ) -> (Vec<u32>, Vec<Vec<u32>>) {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (_, class, nodes) in kept.iter(kinds) {
            pairs.extend(nodes.iter().map(|node| (place_of(&self.numbers, node), class)));
        }
        let pairs = ascending(pairs);
        let told = ascending(self.plan.tell_some(ranks, &pairs));
        let classes = |run: &[(u32, u32)]| run.iter().map(|(_, class)| *class).collect::<Vec<u32>>();
        let runs = || told.chunk_by(|a, b| a.0 == b.0);
        let met = distinct(ranks, runs().map(classes).collect::<BTreeSet<_>>().into_iter());
        let mut of_node = vec![0; own];
        runs().for_each(|run| of_node[run[0].0 as usize] = place_of(&met, &classes(run)));
        (of_node, met)
    }

    /// Which nodes here are marked, by the numbers of those that ranks have marked.
    pub(super) fn marked(&self, ranks: &dyn Ranks, homes: &Homes, numbers: &[u64], own: usize) -> Vec<u8> {
        let mut marks = vec![0u8; own];
        let told = Plan::new(ranks, homes, numbers).tell(ranks, &vec![1u8; numbers.len()]);
        told.into_iter().for_each(|(place, mark)| marks[place as usize] = mark);
        self.plan.fetch(ranks, &marks)
    }
}

/// The rank that keeps a cell: that of the leader of its corners.
pub(super) fn keeper(homes: &Homes, kind: CellKind, nodes: &[u64]) -> usize {
    homes.of(leader(nodes[..kind.linear().nodes()].iter().copied()))
}

/// What ranks have found of the surface of the whole and of its groups, each a part.
pub(super) struct Surfaces {
    /// Boundary faces: number of the cell, and which of its faces.
    boundary: Vec<[u64; 2]>,
    /// Those of groups, with the group before them.
    faces: Vec<[u64; 3]>,
    /// Faces of groups that are none of the boundary: group and corners, of which triangles end in [`NONE`].
    interior: Vec<[u64; 5]>,
    /// Nodes of groups.
    nodes: Vec<[u64; 2]>,
    /// The nodes of all that, ascending.
    pub marked: Vec<u64>,
}

impl Surfaces {
    pub(super) fn new(
        ranks: &dyn Ranks,
        homes: &Homes,
        (here, meeting): (&Here, &Meeting),
        regions: Regions,
    ) -> Surfaces {
        let number = |&v: &u32| here.numbers[v as usize];
        let name = |face: &Face| [here.cells.numbers[face.cell as usize], u64::from(face.local)];
        let own = |face: &Face| homes.of(leader(face.corners().iter().map(number))) == ranks.rank();
        let (mut boundary, mut marked) = (Vec::new(), Vec::new());
        for face in meeting.boundary().filter(own) {
            boundary.push(name(&face));
            marked.extend(face.nodes().iter().map(number));
        }
        let Regions { faces: asked, mut nodes } = regions;
        let mut out = vec![Vec::new(); ranks.size()];
        for face in asked {
            out[homes.of(leader(face[1..].iter().copied().filter(|&corner| corner != NONE)))].push(face);
        }
        let asked = all_to_all(ranks, out.iter().map(|list| to_bytes(list)).collect());
        let (mut faces, mut interior) = (Vec::new(), Vec::new());
        for face in asked.iter().flat_map(|message| from_bytes::<[u64; 5]>(message)) {
            let [group, corners @ ..] = face;
            let place = |corner: u64| match corner {
                NONE => Some(u32::MAX),
                _ => here.numbers.binary_search(&corner).ok().map(|v| v as u32),
            };
            let found = match corners.map(place) {
                [Some(a), Some(b), Some(c), Some(d)] => meeting.find([a, b, c, d]),
                _ => None,
            };
            match found {
                Some((face, true)) => faces.push([group, name(&face)[0], name(&face)[1]]),
                found => {
                    interior.push(face);
                    let middles = found.map_or(Vec::new(), |(face, _)| face.nodes()[face.corners().len()..].to_vec());
                    nodes.extend(middles.iter().map(|v| [group, number(v)]));
                }
            }
        }
        marked.extend(interior.iter().flat_map(|face| face[1..].iter().copied()).filter(|&corner| corner != NONE));
        marked.extend(nodes.iter().map(|[_, node]| *node));
        Surfaces { boundary, faces, interior, nodes, marked: ascending(marked) }
    }

    /// At rank 0 the mesh of the cells at all that, with its faces and groups; the numbers are those of its nodes.
    pub(super) fn gathered(
        &self,
        ranks: &dyn Ranks,
        (names, classes): (&[String], &[Vec<u32>]),
        (mut mesh, numbers, cells): (Mesh, &[u64], &CellList),
    ) -> Option<Mesh> {
        let boundary = all_of(ranks, &self.boundary);
        let (faces, interior) = (all_of(ranks, &self.faces), all_of(ranks, &self.interior));
        let nodes = all_of(ranks, &self.nodes);
        let boundary = ascending(boundary?);
        let face = |&[cell, local]: &[u64; 2]| {
            let cell = place_of(&cells.numbers, &cell);
            let (kind, nodes) = mesh.cell(cell as usize);
            Face::of_cell(kind, nodes, cell, local as u8)
        };
        mesh.faces = boundary.iter().map(face).collect();
        let mut groups: Vec<Group> =
            names.iter().map(|name| Group { name: name.clone(), ..Group::default() }).collect();
        for (cell, class) in (0..).zip(&cells.classes) {
            classes[*class as usize].iter().for_each(|&group| groups[group as usize].cells.push(cell));
        }
        for [group, cell, local] in faces? {
            groups[group as usize].faces.push(place_of(&boundary, &[cell, local]));
        }
        for [group, corners @ ..] in interior? {
            let place = |corner: u64| if corner == NONE { u32::MAX } else { place_of(numbers, &corner) };
            groups[group as usize].interior_faces.push(corners.map(place));
        }
        for [group, node] in nodes? {
            groups[group as usize].nodes.push(place_of(numbers, &node));
        }
        for group in &mut groups {
            group.faces = ascending(std::mem::take(&mut group.faces));
            group.nodes = ascending(std::mem::take(&mut group.nodes));
        }
        mesh.groups = groups;
        Some(mesh)
    }
}

/// At rank 0 what all ranks have.
pub(super) fn all_of<const N: usize>(ranks: &dyn Ranks, own: &[[u64; N]]) -> Option<Vec<[u64; N]>> {
    gather(ranks, to_bytes(own)).map(|all| all.iter().flat_map(|message| from_bytes::<[u64; N]>(message)).collect())
}
