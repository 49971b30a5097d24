//! Meshes of files that each rank reads a range of. Cells are checked and matched where the leaders of their faces are kept;
//! what is wrong or unusual is left to the reader of the whole.

use std::collections::HashSet;
use std::path::Path;

use super::cells::{CellList, Kinds};
use super::components::{bodies_of_cells, bodies_of_nodes, named};
use super::elements::{Named, place_of};
use super::homes::{Homes, Plan};
use super::matching::{Here, Surfaces, keeper};
use super::numbering::{Numbering, number};
use super::parts::{Owners, Part, PartNode, Parts};
use super::share::Whole;
use crate::Error;
use crate::contact::{Body, Helpers};
use crate::io::case::{AgainstSpec, Case, LoadKind, MeshSource, NodalSpec, Placing, Region};
use crate::io::ranges::MeshRanges;
use crate::mesh::v3::{V3, add};
use crate::mesh::{CellKind, Cells, Meeting, Mesh, MeshArrays, MeshNotes, MeshPiece, ascending, coincident_nodes};
use crate::ranks::{Ranks, agree, all_to_all, from_bytes, gather, gather_all, max, to_bytes};
use crate::run::pose::MemoryLimit;
use crate::run::pose::memory::{of_kinds, posing_fits, range_fits};

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

/// What this rank keeps of a mesh that ranks have read: nodes, and the cells of which it keeps the leader.
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

/// The mesh of the case, read by all ranks; why not if it has to be read as a whole, if anything is wrong with it.
pub(super) fn read(case: &Case, ranks: &dyn Ranks) -> Result<Read, Option<Error>> {
    let (path, scale) = file(case).ok_or(None)?;
    let file = together(ranks, MeshRanges::open(path, scale))?;
    let sizes = file.sizes();
    let alike = gather_all(ranks, to_bytes(&sizes)).iter().all(|other| from_bytes::<u64>(other) == sizes);
    together(ranks, Ok(alike.then_some(())))?;
    agree(ranks, range_fits(path, ranks.size()))?;
    let range = |count: u64| {
        let at = |rank: usize| (u128::from(count) * rank as u128 / ranks.size() as u128) as u64;
        at(ranks.rank())..at(ranks.rank() + 1)
    };
    let of_file = || {
        let nodes = file.nodes(range(sizes[0]))?;
        // Nodes of no cell as well: whoever wrote them wrote no mesh.
        if !nodes.1.iter().flatten().all(|x| x.is_finite()) {
            return Err(Error::new("", "a coordinate is not a finite number", "write the file again"));
        }
        Ok((nodes, file.elements(range(sizes[1]))?))
    };
    let ((tags, mut places), elements) = agree(ranks, of_file())?;

    let asked = asked(case);
    let asked: Vec<bool> = file.groups().iter().map(|group| asked.contains(group.as_str())).collect();
    let elements = Named::new(elements, &asked);
    let Numbering { homes, used, numbers } = number(ranks, &tags, &elements.keys, &elements.by_cells)?;
    let mut used = used.into_iter();
    places.retain(|_| used.next().unwrap_or(false));
    let (cells, classes, kinds) = elements.cells(ranks, &homes, &numbers);
    let surfaces = elements.regions(&numbers);
    drop((tags, elements, numbers));

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
    let list = named(ranks, body_of_cell, (file.groups(), &classes), count);
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

    fn boundary(&mut self, case: &Case, helpers: &Helpers) -> Result<Whole, Error> {
        let sizes = self.sizes();
        let boundary = self.boundary.take();
        let missing = || case.mesh.spot.error("the mesh has no boundary", "write the file again");
        let Boundary { mesh, numbers, body_of_node, bodies } = boundary.ok_or_else(missing)?;
        let limit = MemoryLimit { divided: true, ..MemoryLimit::of(&case.solver) };
        posing_fits(mesh.nodes.len() as f64, 0.0, &limit)?;
        let notes = MeshNotes(coincident_nodes(&mesh.nodes, &mesh.faces, &|v| numbers[0][v] + 1).into_iter().collect());
        Whole::new(case, (mesh, notes), (Some(numbers), sizes), Some((body_of_node, bodies)), helpers)
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
