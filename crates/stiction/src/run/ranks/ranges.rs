//! Meshes of files that each rank reads a range of. Cells are checked and matched where the lowest nodes of their faces are kept;
//! what is wrong or unusual is left to the reader of the whole.

use std::collections::{BTreeSet, HashSet};
use std::path::Path;

use super::cells::{CellList, Kinds};
use super::components::{bodies_of_cells, bodies_of_nodes, named};
use super::homes::{Homes, Plan};
use super::numbering::{NONE, Numbering, number};
use super::parts::{Owners, Part, PartNode, Parts};
use super::share::Whole;
use crate::Error;
use crate::contact::Body;
use crate::io::case::{AgainstSpec, Case, LoadKind, MeshSource, NodalSpec, Placing, Region};
use crate::io::ranges::{Elements, MeshRanges};
use crate::mesh::v3::{V3, add};
use crate::mesh::{CellKind, Cells, Face, Group, Meeting, Mesh, MeshArrays, MeshPiece, RawCells, RawMesh, ascending};
use crate::ranks::{Ranks, agree, all_to_all, from_bytes, gather, gather_all, max, put, take, to_bytes};
use crate::run::pose::MemoryLimit;
use crate::run::pose::memory::{of_kinds, posing_fits};

/// The file of a case, and the factor on its coordinates, if ranges of it say all that the case asks for: not the cuts of bolts, which
/// go through the inside, nor arrays.
fn file(case: &Case) -> Option<(&Path, f64)> {
    let array = |component: &NodalSpec| matches!(component, NodalSpec::Array { .. });
    let of_array = |kind: &LoadKind| match kind {
        LoadKind::TemperatureArray { .. } => true,
        LoadKind::Nodal(value) => value.iter().any(array),
        _ => false,
    };
    let arrays = case.loads.iter().any(|load| of_array(&load.kind))
        || case.contacts.iter().any(|contact| contact.friction.is_array());
    match &case.mesh.source {
        MeshSource::File { path, scale, .. } if case.bolts.is_empty() && !arrays => Some((path, *scale)),
        _ => None,
    }
}

/// The groups whose nodes and faces the case asks for.
fn asked<'a>(case: &'a Case) -> HashSet<&'a str> {
    let contacts = case.contacts.iter().flat_map(|contact| {
        let (against, closed) = match &contact.against {
            AgainstSpec::Surface { region, closed_at, .. } => (Some(region), closed_at.as_ref()),
            AgainstSpec::Obstacle(_) | AgainstSpec::File(_) => (None, None),
        };
        [Some(&contact.on), against, closed]
    });
    let loads = case.loads.iter().map(|load| load.on.as_ref());
    let regions = case.fixes.iter().map(|fix| &fix.on).chain(case.springs.iter().map(|spring| &spring.on));
    let names = |region: &'a Region| match region {
        Region::Groups(names) => names.iter().map(|(name, _)| name.as_str()).collect(),
        Region::Box { .. } | Region::Point(_) => Vec::new(),
    };
    regions.chain(contacts.chain(loads).flatten()).flat_map(names).collect()
}

/// What this rank keeps of a mesh that ranks have read: nodes, and the cells of which it keeps the lowest node.
pub(super) struct Read {
    homes: Homes,
    /// Of each node, length.
    places: Vec<V3>,
    node_kinds: Vec<u32>,
    bodies: Vec<u32>,
    cells: CellList,
    kinds: Kinds,
    /// For each class the names of its groups.
    groups: Vec<Vec<String>>,
    meeting: Vec<Vec<u32>>,
    /// Of rank 0.
    boundary: Option<Boundary>,
}

/// The cells at the boundary.
struct Boundary {
    mesh: Mesh,
    numbers: [Vec<u64>; 2],
    body_of_node: Vec<u32>,
    bodies: Vec<Body>,
}

/// What all ranks have found; what is wrong, or nothing, if a rank has found that or nothing.
fn together<T>(ranks: &dyn Ranks, found: Result<Option<T>, Error>) -> Result<T, Option<Error>> {
    let found = agree(ranks, found)?;
    let mut missing = [f64::from(u8::from(found.is_none()))];
    max(ranks, &mut missing);
    found.filter(|_| missing[0] == 0.0).ok_or(None)
}

/// Lists of all ranks, each once and in order.
fn distinct(ranks: &dyn Ranks, own: impl Iterator<Item = Vec<u32>>) -> Vec<Vec<u32>> {
    let mut message = Vec::new();
    own.for_each(|list| put(&list, &mut message));
    let mut all = BTreeSet::new();
    for message in gather_all(ranks, message) {
        let from = &mut &message[..];
        while !from.is_empty() {
            all.insert(take(from));
        }
    }
    all.into_iter().collect()
}

fn place_of<T: Ord>(list: &[T], value: &T) -> u32 {
    list.partition_point(|other| other < value) as u32
}

/// The mesh of the case, read by all ranks; why not if it has to be read as a whole, if anything is wrong with it.
pub(super) fn read(case: &Case, ranks: &dyn Ranks) -> Result<Read, Option<Error>> {
    let (path, scale) = file(case).ok_or(None)?;
    let file = together(ranks, MeshRanges::open(path, scale))?;
    let sizes = file.sizes();
    let alike = gather_all(ranks, to_bytes(&sizes)).iter().all(|other| from_bytes::<u64>(other) == sizes);
    together(ranks, Ok(alike.then_some(())))?;
    let range = |count: u64| {
        let at = |rank: usize| (u128::from(count) * rank as u128 / ranks.size() as u128) as u64;
        at(ranks.rank())..at(ranks.rank() + 1)
    };
    let of_file = file.nodes(range(sizes[0])).and_then(|nodes| Ok((nodes, file.elements(range(sizes[1]))?)));
    let ((tags, mut places), elements) = agree(ranks, of_file)?;

    let asked = asked(case);
    let asked: Vec<bool> = file.groups().iter().map(|group| asked.contains(group.as_str())).collect();
    let named = Named::new(elements, &asked);
    let Numbering { homes, used, numbers } = number(ranks, &tags, &named.keys, &named.by_cells)?;
    let mut used = used.into_iter();
    places.retain(|_| used.next().unwrap_or(false));
    let (cells, classes, kinds) = named.cells(ranks, &homes, &numbers);
    let surfaces = named.regions(&numbers);
    drop((tags, named, numbers));

    let mut here = Here::new(ranks, &homes, cells, &kinds, &places, file.turns_wedges());
    let meeting = agree(ranks, Meeting::new(&here.raw))?;
    let found = Surfaces::new(ranks, &homes, (&here, &meeting), surfaces);
    drop(meeting);
    let Placing { turn, by } = &case.mesh.placing;
    places.iter_mut().for_each(|x| *x = add(turn.as_ref().map_or(*x, |turn| turn.apply(*x)), *by));

    let own = places.len();
    let mesh = Mesh {
        nodes: std::mem::take(&mut here.raw.nodes),
        cells: here.raw.cells.drain(..).map(|block| Cells { kind: block.kind, nodes: block.nodes }).collect(),
        ..empty()
    };
    let (bodies, count) = bodies_of_nodes(ranks, &homes, (&here.plan, &mesh), own);
    drop(mesh);
    let kept = here.kept(ranks, &homes, &kinds);
    let of_node = here.plan.fetch(ranks, &bodies);
    let body_of_cell = bodies_of_cells(&kept, &kinds, (&here.numbers, &of_node));
    let list = self::named(ranks, body_of_cell, (file.groups(), &classes), count);
    let (node_kinds, meeting) = here.node_kinds(ranks, &kept, &kinds, own);

    let marked = here.marked(ranks, &homes, &found.marked, own);
    let mut outer = CellList::default();
    for (number, class, nodes) in kept.iter(&kinds) {
        if nodes.iter().any(|node| marked[place_of(&here.numbers, node) as usize] > 0) {
            outer.push(number, class, nodes);
        }
    }
    let outer = gather(ranks, outer.to_bytes()).map(|messages| CellList::of(messages, &kinds)).unwrap_or_default();
    let numbers = outer.node_numbers();
    let plan = Plan::new(ranks, &homes, &numbers);
    let (at, body_of_node) = (plan.fetch(ranks, &places), plan.fetch(ranks, &bodies));
    let mesh = Mesh { nodes: at, cells: outer.blocks(&kinds, &numbers), ..empty() };
    let boundary = found.gathered(ranks, (file.groups(), &classes), (mesh, &numbers, &outer)).map(|mesh| Boundary {
        mesh,
        numbers: [numbers, outer.numbers],
        body_of_node,
        bodies: list,
    });
    let name = |&group: &u32| file.groups()[group as usize].clone();
    let groups = classes.iter().map(|groups| groups.iter().map(name).collect()).collect();
    Ok(Read { homes, places, node_kinds, bodies, cells: kept, kinds, groups, meeting, boundary })
}

fn empty() -> Mesh {
    Mesh { nodes: Vec::new(), cells: Vec::new(), faces: Vec::new(), groups: Vec::new(), arrays: MeshArrays::default() }
}

/// The elements that a rank has read, and all numbers of nodes that they name.
struct Named {
    elements: Elements,
    /// Ascending, and whether a cell names each.
    keys: Vec<u64>,
    by_cells: Vec<bool>,
}

/// Faces and nodes of groups, by the numbers of their nodes in the whole.
#[derive(Default)]
struct Regions {
    /// The group and the corners of each; triangles end in [`NONE`].
    faces: Vec<[u64; 5]>,
    nodes: Vec<[u64; 2]>,
}

impl Named {
    /// Of faces and lines what is in the groups that are `asked` for.
    fn new(mut elements: Elements, asked: &[bool]) -> Named {
        let wanted: Vec<bool> =
            elements.sets.iter().map(|set| set.iter().any(|&group| asked[group as usize])).collect();
        elements.faces.retain(|(_, set)| wanted[*set as usize]);
        elements.nodes.retain(|(_, set)| wanted[*set as usize]);
        let of_cells = ascending(elements.cells.iter().flat_map(|block| block.nodes.iter().copied()));
        let corners = elements.faces.iter().flat_map(|(corners, _)| corners.iter().copied().filter(|&c| c != NONE));
        let others = corners.chain(elements.nodes.iter().map(|(node, _)| *node));
        let keys = ascending(of_cells.iter().copied().chain(others));
        let by_cells = keys.iter().map(|key| of_cells.binary_search(key).is_ok()).collect();
        Named { elements, keys, by_cells }
    }

    /// The cells by their numbers in the whole, each at the ranks that keep the lowest nodes of its faces: these see all cells at a
    /// face. With the groups of each class, and the kinds of all cells.
    fn cells(&self, ranks: &dyn Ranks, homes: &Homes, numbers: &[u64]) -> (CellList, Vec<Vec<u32>>, Kinds) {
        let Elements { sets, cells, .. } = &self.elements;
        let used: BTreeSet<u32> = cells.iter().flat_map(|block| block.sets.iter().copied()).collect();
        let classes = distinct(ranks, used.into_iter().map(|set| sets[set as usize].clone()));
        let class_of: Vec<u32> = sets.iter().map(|set| place_of(&classes, set)).collect();
        let counts: Vec<u64> = cells.iter().map(|block| block.sets.len() as u64).collect();
        let all: Vec<Vec<u64>> =
            gather_all(ranks, to_bytes(&counts)).iter().map(|message| from_bytes(message)).collect();
        let (mut out, mut kinds, mut end) = (vec![CellList::default(); ranks.size()], Kinds::default(), 0);
        for (k, (kind, block)) in CellKind::ALL.into_iter().zip(cells).enumerate() {
            let first = end + all[..ranks.rank()].iter().map(|counts| counts[k]).sum::<u64>();
            end += all.iter().map(|counts| counts[k]).sum::<u64>();
            kinds.ends[k] = end;
            for ((number, list), &set) in (first..).zip(block.nodes.chunks_exact(kind.nodes())).zip(&block.sets) {
                let mut nodes = [0; 20];
                let nodes = &mut nodes[..list.len()];
                nodes.iter_mut().zip(list).for_each(|(node, key)| *node = numbers[place_of(&self.keys, key) as usize]);
                let lowest = kind.linear().faces().iter().map(|face| face.iter().map(|&i| nodes[i]).min().unwrap_or(0));
                for home in ascending(lowest.map(|node| homes.of(node))) {
                    out[home].push(number, class_of[set as usize], nodes);
                }
            }
        }
        let messages = out.into_iter().map(|list| list.to_bytes()).collect();
        (CellList::of(all_to_all(ranks, messages), &kinds), classes, kinds)
    }

    /// Faces of which a node belongs to no cell are none of the mesh.
    fn regions(&self, numbers: &[u64]) -> Regions {
        let number = |key: u64| if key == NONE { NONE } else { numbers[place_of(&self.keys, &key) as usize] };
        let Elements { sets, faces, nodes, .. } = &self.elements;
        let mut regions = Regions::default();
        for (keys, set) in faces {
            let corners = keys.map(number);
            if (0..4).all(|k| (corners[k] == NONE) == (keys[k] == NONE)) {
                let face = |&group: &u32| [u64::from(group), corners[0], corners[1], corners[2], corners[3]];
                regions.faces.extend(sets[*set as usize].iter().map(face));
            }
        }
        for (key, set) in nodes.iter().filter(|(key, _)| number(*key) != NONE) {
            regions.nodes.extend(sets[*set as usize].iter().map(|&group| [u64::from(group), number(*key)]));
        }
        regions
    }
}

/// The cells at the faces whose lowest nodes a rank keeps, as a mesh.
struct Here {
    cells: CellList,
    /// Of the nodes in the whole, ascending.
    numbers: Vec<u64>,
    plan: Plan,
    raw: RawMesh,
}

impl Here {
    fn new(ranks: &dyn Ranks, homes: &Homes, mut cells: CellList, kinds: &Kinds, places: &[V3], turns: bool) -> Here {
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
    fn kept(&mut self, ranks: &dyn Ranks, homes: &Homes, kinds: &Kinds) -> CellList {
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
    fn node_kinds(&self, ranks: &dyn Ranks, kept: &CellList, kinds: &Kinds, own: usize) -> (Vec<u32>, Vec<Vec<u32>>) {
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
    fn marked(&self, ranks: &dyn Ranks, homes: &Homes, numbers: &[u64], own: usize) -> Vec<u8> {
        let mut marks = vec![0u8; own];
        let told = Plan::new(ranks, homes, numbers).tell(ranks, &vec![1u8; numbers.len()]);
        told.into_iter().for_each(|(place, mark)| marks[place as usize] = mark);
        self.plan.fetch(ranks, &marks)
    }
}

/// The rank that keeps a cell: that of its lowest corner.
fn keeper(homes: &Homes, kind: CellKind, nodes: &[u64]) -> usize {
    homes.of(nodes[..kind.linear().nodes()].iter().copied().min().unwrap_or(0))
}

/// What ranks have found of the surface of the whole and of its groups, each a part.
struct Surfaces {
    /// Boundary faces: number of the cell, and which of its faces.
    boundary: Vec<[u64; 2]>,
    /// Those of groups, with the group before them.
    faces: Vec<[u64; 3]>,
    /// Faces of groups that are none of the boundary: group and corners, of which triangles end in [`NONE`].
    interior: Vec<[u64; 5]>,
    /// Nodes of groups.
    nodes: Vec<[u64; 2]>,
    /// The nodes of all that, ascending.
    marked: Vec<u64>,
}

impl Surfaces {
    fn new(ranks: &dyn Ranks, homes: &Homes, (here, meeting): (&Here, &Meeting), regions: Regions) -> Surfaces {
        let number = |&v: &u32| here.numbers[v as usize];
        let name = |face: &Face| [here.cells.numbers[face.cell as usize], u64::from(face.local)];
        let own = |face: &Face| face.corners().iter().map(number).min().is_some_and(|v| homes.of(v) == ranks.rank());
        let (mut boundary, mut marked) = (Vec::new(), Vec::new());
        for face in meeting.boundary().filter(own) {
            boundary.push(name(&face));
            marked.extend(face.nodes().iter().map(number));
        }
        let Regions { faces: asked, mut nodes } = regions;
        let mut out = vec![Vec::new(); ranks.size()];
        for face in asked {
            out[homes.of(face[1..].iter().copied().min().unwrap_or(0))].push(face);
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
    fn gathered(
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
fn all_of<const N: usize>(ranks: &dyn Ranks, own: &[[u64; N]]) -> Option<Vec<[u64; N]>> {
    gather(ranks, to_bytes(own)).map(|all| all.iter().flat_map(|message| from_bytes::<[u64; N]>(message)).collect())
}

impl Parts for Read {
    fn sizes(&self) -> [u64; 2] {
        [self.homes.count(), self.kinds.count()]
    }

    fn bytes(&self) -> f64 {
        let mut first = 0;
        let there = CellKind::ALL
            .into_iter()
            .zip(self.kinds.ends)
            .filter(|(_, end)| std::mem::replace(&mut first, *end) < *end);
        of_kinds(there.map(|(kind, _)| kind))
    }

    fn groups(&self) -> &[Vec<String>] {
        &self.groups
    }

    fn kinds(&self) -> &[Vec<u32>] {
        &self.meeting
    }

    fn boundary(&mut self, case: &Case, parts: usize) -> Result<Whole, Error> {
        let sizes = self.sizes();
        let boundary = self.boundary.take();
        let missing = || case.mesh.spot.error("the mesh has no boundary", "write the file again");
        let Boundary { mesh, numbers, body_of_node, bodies } = boundary.ok_or_else(missing)?;
        let limit = MemoryLimit { divided: true, ..MemoryLimit::of(&case.solver) };
        posing_fits(mesh.nodes.len() as f64, 0.0, &limit)?;
        Whole::new(case, mesh, (Some(numbers), sizes), Some((body_of_node, bodies)), parts)
    }

    fn count(&self) -> usize {
        self.places.len()
    }

    fn node(&self, k: usize) -> PartNode {
        PartNode { number: self.homes.first() + k as u64, place: self.places[k], kind: self.node_kinds[k] }
    }

    fn part(&self, beside: &MeshPiece, owners: &Owners, ranks: &dyn Ranks) -> Part {
        let (homes, kinds) = (&self.homes, &self.kinds);
        let owner = |(&place, number): (&V3, u64)| owners.of(number, || place);
        let owner: Vec<u32> = self.places.iter().zip(homes.first()..).map(owner).collect();
        let numbers = self.cells.node_numbers();
        let of_node = Plan::new(ranks, homes, &numbers).fetch(ranks, &owner);
        let mut out = vec![CellList::default(); ranks.size()];
        for (number, class, nodes) in self.cells.iter(kinds) {
            for part in ascending(nodes.iter().map(|node| of_node[place_of(&numbers, node) as usize])) {
                out[part as usize].push(number, class, nodes);
            }
        }
        let mut cells = CellList::of(all_to_all(ranks, out.into_iter().map(|list| list.to_bytes()).collect()), kinds);
        self.add(beside, &mut cells, ranks);
        let cells = cells.in_order(kinds);
        let nodes = cells.node_numbers();
        let plan = Plan::new(ranks, homes, &nodes);
        let fetch = |own: &[u32]| plan.fetch(ranks, own);
        let mesh = Mesh { nodes: plan.fetch(ranks, &self.places), cells: cells.blocks(kinds, &nodes), ..empty() };
        Part {
            classes: cells.classes,
            kinds: fetch(&self.node_kinds),
            bodies: fetch(&self.bodies),
            piece: MeshPiece { mesh, owner: fetch(&owner), nodes, cells: cells.numbers },
        }
    }
}

impl Read {
    /// Adds the cells that come with the boundary and are at no node of this rank; their classes are asked of those that keep them.
    fn add(&self, beside: &MeshPiece, cells: &mut CellList, ranks: &dyn Ranks) {
        let mut asked = vec![Vec::new(); ranks.size()];
        let mut others = CellList::default();
        for (&number, (kind, list)) in beside.cells.iter().zip(beside.mesh.cell_iter()) {
            if cells.numbers.binary_search(&number).is_err() {
                let nodes: Vec<u64> = list.iter().map(|&v| beside.nodes[v as usize]).collect();
                asked[keeper(&self.homes, kind, &nodes)].push((number, others.numbers.len()));
                others.push(number, 0, &nodes);
            }
        }
        let messages = asked.iter().map(|list| to_bytes(&list.iter().map(|(number, _)| *number).collect::<Vec<u64>>()));
        let class = |number: u64| self.cells.classes[place_of(&self.cells.numbers, &number) as usize];
        let answer = |message: &Vec<u8>| to_bytes(&from_bytes(message).into_iter().map(class).collect::<Vec<u32>>());
        let answers = all_to_all(ranks, all_to_all(ranks, messages.collect()).iter().map(answer).collect());
        for (list, answer) in asked.iter().zip(answers) {
            list.iter().zip(from_bytes(&answer)).for_each(|((_, k), class)| others.classes[*k] = class);
        }
        cells.numbers.extend(others.numbers);
        cells.classes.extend(others.classes);
        cells.nodes.extend(others.nodes);
    }
}
