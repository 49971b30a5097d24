//! Meshes of blocks and rings: each rank makes its own part of them. Rank 0 makes the cells at the boundary beside it, on which it
//! finds supports, loads and contact, and no rank ever has the whole.

use std::collections::HashMap;

use rayon::prelude::*;

use super::room;
use super::share::{Divided, Share, Whole, enough, name, sent};
use crate::Error;
use crate::contact::Body;
use crate::io::case::{Case, FixSpec, LoadKind, LoadSpec, MeshSource, MeshSpec, Region};
use crate::mesh::v3::{Sum, V3, norm, scale, sub};
use crate::mesh::{
    CornerBox, Cuts, Face, Grid, GridMesh, Grids, Group, Mesh, MeshPiece, Turn, WeightedNode, ascending,
};
use crate::ranks::{Ranks, agree, broadcast, from_bytes, gather_all, max, put, sum, take, to_bytes};
use crate::run::pose::MemoryLimit;
use crate::run::pose::activity::ALWAYS;
use crate::run::pose::loads::one_temperature_each;
use crate::run::pose::memory::{of_block, posing_fits};
use crate::run::pose::regions;

/// The grids of a case whose mesh is made of blocks and rings alone; none where something is asked of the inside of the whole:
/// the cut of a bolt.
pub(super) fn grids(case: &Case) -> Option<Grids> {
    if !case.bolts.is_empty() {
        return None;
    }
    let moved = |spec: &MeshSpec| (spec.placing.turn, spec.placing.by);
    let grid = |spec: &MeshSpec, placings: Vec<(Option<Turn>, V3)>| match &spec.source {
        MeshSource::Block(block) => Grid::of_block(block, placings).ok(),
        MeshSource::Ring(ring) => Grid::of_ring(ring, placings).ok(),
        _ => None,
    };
    let whole = moved(&case.mesh);
    let MeshSource::Parts(parts) = &case.mesh.source else {
        return Some(Grids::new(vec![(None, grid(&case.mesh, vec![whole])?)]));
    };
    let part = |(name, spec): &(String, MeshSpec)| Some((Some(name.clone()), grid(spec, vec![moved(spec), whole])?));
    Some(Grids::new(parts.iter().map(part).collect::<Option<_>>()?))
}

/// The share of each rank; why there is none, at rank 0, if it cannot pose the case on its boundary: what is wrong with it, or
/// whether the inside has what the boundary lacks, is then a matter of the whole.
pub(super) fn share(case: &Case, grids: &Grids, ranks: &dyn Ranks) -> Result<Result<Share, Option<Error>>, Error> {
    let (nodes, each) = (grids.sizes()[0] as f64 / ranks.size() as f64, grids.elements().map(of_block));
    room::part_fits([nodes, each.fold(0.0, f64::max)], &room::limit(case, ranks), ranks)?;
    let posed = (ranks.rank() == 0).then(|| boundary(case, grids, ranks.size()));
    let (whole, missing) = match posed {
        Some(Ok(whole)) => (Some(whole), None),
        Some(Err(error)) => (None, Some(error)),
        None => (None, None),
    };
    let outline = broadcast(ranks, whole.as_ref().map_or(Vec::new(), |whole| Outline::of(whole, grids).to_bytes()));
    if outline.is_empty() {
        return Ok(Err(missing));
    }
    let outline = Outline::from_bytes(&outline);
    let nodes = nodes_to_divide(case, grids, &outline, ranks);
    let cuts = Cuts::new(ranks, &nodes, ranks.size());
    enough(case, &cuts, &nodes, ranks)?;
    let boxes = boxes(grids, &cuts, &nodes, ranks);
    drop(nodes);
    let divided = whole.map(|whole| whole.divided(&cuts));
    let following = divided.as_ref().map_or(Vec::new(), Divided::following);
    let following: HashMap<u64, u32> = from_bytes(&broadcast(ranks, to_bytes(&following)))
        .into_iter()
        .map(|[v, part]: [u64; 2]| (v, part as u32))
        .collect();
    let share = Share::from_bytes(case, &sent(ranks, divided));
    let owner = |number: u64| match following.get(&number) {
        Some(&part) => part,
        None if ranks.size() == 1 => 0,
        None => cuts.part(grids.place(number), number),
    };
    let share = filled(case, share, (grids, &outline), (&owner, &boxes), ranks);
    agree(ranks, refuse_two_temperatures(case, &share.piece.mesh))?;
    Ok(Ok(share))
}

/// What lies at the boundary, posed.
fn boundary(case: &Case, grids: &Grids, parts: usize) -> Result<Whole, Error> {
    let limit = MemoryLimit { divided: true, ..MemoryLimit::of(&case.solver) };
    posing_fits(grids.boundary_nodes(), 0.0, &limit)?;
    let mut made = grids.mesh(grids.boundary_cells());
    made.mesh.groups = grids.groups(&made);
    let GridMesh { mesh, nodes, cells } = made;
    Whole::new(case, mesh, (Some([nodes, cells]), grids.sizes()), parts)
}

/// What rank 0 tells all of them of the whole.
struct Outline {
    /// The box around the whole, length.
    bounds: [V3; 2],
    /// The body and the material of each grid.
    body_of: Vec<u32>,
    material_of: Vec<u32>,
    /// Nodes that do not count as one, ascending, and what they count; [`FOLLOWS`] for those that go where another does.
    weights: Vec<(u64, f64)>,
}

const FOLLOWS: f64 = -1.0;

impl Outline {
    fn of(whole: &Whole, grids: &Grids) -> Outline {
        let (mut body_of, mut material_of) = (vec![0; grids.len()], vec![0; grids.len()]);
        for (cell, number) in whole.cell_numbers().enumerate() {
            let k = grids.of_cell(number);
            body_of[k] = whole.body_of_node[whole.mesh.cell(cell).1[0] as usize];
            material_of[k] = whole.material_of_cell[cell];
        }
        let follows = whole.follows();
        let weight = |v: usize| if follows.contains(&(v as u32)) { FOLLOWS } else { whole.weights[v] };
        let special = (0..whole.mesh.nodes.len()).map(|v| (whole.node_number(v), weight(v)));
        let weights = special.filter(|(_, weight)| *weight != 1.0).collect();
        Outline { bounds: whole.mesh.bounding_box(), body_of, material_of, weights }
    }

    fn to_bytes(&self) -> Vec<u8> {
        let mut to = Vec::new();
        put(&self.bounds, &mut to);
        put(&self.body_of, &mut to);
        put(&self.material_of, &mut to);
        put(&self.weights.iter().map(|(number, _)| *number).collect::<Vec<_>>(), &mut to);
        put(&self.weights.iter().map(|(_, weight)| *weight).collect::<Vec<_>>(), &mut to);
        to
    }

    fn from_bytes(mut bytes: &[u8]) -> Outline {
        let from = &mut bytes;
        let bounds: Vec<V3> = take(from);
        let (body_of, material_of, numbers) = (take(from), take(from), take::<u64>(from));
        let weights = numbers.into_iter().zip(take::<f64>(from)).collect();
        Outline { bounds: [bounds[0], bounds[1]], body_of, material_of, weights }
    }
}

/// The nodes that this rank divides for all: an equal part of them by their numbers.
fn nodes_to_divide(case: &Case, grids: &Grids, outline: &Outline, ranks: &dyn Ranks) -> Vec<WeightedNode> {
    let [count, _] = grids.sizes();
    let at = |rank: usize| (u128::from(count) * rank as u128 / ranks.size() as u128) as u64;
    let always = |fix: &&FixSpec| fix.during.period(&case.steps) == ALWAYS;
    let clamped = case.fixes.iter().filter(always).filter(|fix| !fix.symmetry && fix.value.iter().all(Option::is_some));
    let clamped: Vec<Inside> = clamped.map(|fix| Inside::of(&fix.on, grids, outline)).collect();
    let numbers = at(ranks.rank())..at(ranks.rank() + 1);
    let node = |number: u64| {
        let place = grids.place(number);
        let weight = match outline.weights.binary_search_by_key(&number, |(special, _)| *special) {
            Ok(k) => outline.weights[k].1,
            // Those of the boundary have their weights already.
            Err(_) if clamped.iter().any(|inside| inside.has_node(grids.of_node(number), place)) => 0.0,
            Err(_) => 1.0,
        };
        (weight != FOLLOWS).then_some(WeightedNode { place, number, weight })
    };
    numbers.into_par_iter().filter_map(node).collect()
}

/// Where in the grids the nodes of this rank are: all ranks tell it of those that they have divided.
fn boxes(grids: &Grids, cuts: &Cuts, nodes: &[WeightedNode], ranks: &dyn Ranks) -> Vec<(usize, CornerBox)> {
    let mut boxes: HashMap<[u64; 2], CornerBox> = HashMap::new();
    let around =
        |a: CornerBox, b: CornerBox| [[0, 1, 2].map(|c| a[0][c].min(b[0][c])), [0, 1, 2].map(|c| a[1][c].max(b[1][c]))];
    for node in nodes {
        let (grid, corners) = grids.corners_of(node.number);
        let key = [u64::from(cuts.part(node.place, node.number)), grid as u64];
        boxes.entry(key).and_modify(|found| *found = around(*found, corners)).or_insert(corners);
    }
    let mut list: Vec<[u64; 8]> =
        boxes.iter().map(|([part, grid], [[a, b, c], [x, y, z]])| [*part, *grid, *a, *b, *c, *x, *y, *z]).collect();
    list.sort_unstable();
    let mut own: Vec<(usize, CornerBox)> = Vec::new();
    for message in gather_all(ranks, to_bytes(&list)) {
        for [part, grid, a, b, c, x, y, z] in from_bytes::<[u64; 8]>(&message) {
            if part != ranks.rank() as u64 {
                continue;
            }
            let (grid, corners) = (grid as usize, [[a, b, c], [x, y, z]]);
            match own.iter_mut().find(|(other, _)| *other == grid) {
                Some((_, found)) => *found = around(*found, corners),
                None => own.push((grid, corners)),
            }
        }
    }
    own
}

/// The rank of a node.
type Owner<'a> = dyn Fn(u64) -> u32 + Sync + 'a;

/// Cells that a thread looks through at a time.
const CHUNK: usize = 1 << 13;

/// The share of a rank with the inside of its part: `share` has its boundary.
fn filled(
    case: &Case,
    share: Share,
    (grids, outline): (&Grids, &Outline),
    (owner, boxes): (&Owner, &[(usize, CornerBox)]),
    ranks: &dyn Ranks,
) -> Share {
    let own = ranks.rank() as u32;
    let has_own = |&cell: &u64| {
        let mut nodes = Vec::with_capacity(20);
        grids.cell_nodes(cell, &mut nodes);
        nodes.into_iter().any(|node| owner(node) == own)
    };
    let mut cells = share.piece.cells.clone();
    for &(grid, corners) in boxes {
        let near: Vec<u64> = grids.cells_at(grid, corners).collect();
        let found: Vec<Vec<u64>> =
            near.par_chunks(CHUNK).map(|some| some.iter().copied().filter(has_own).collect()).collect();
        cells.extend(found.into_iter().flatten());
    }
    cells.par_sort_unstable();
    cells.dedup();
    let GridMesh { mut mesh, nodes, cells } = grids.mesh(cells);
    let owners: Vec<u32> = nodes.par_iter().map(|&node| owner(node)).collect();
    mesh.groups = groups(&share.piece, (&mesh, &nodes, &cells));
    fill_groups(case, &mut mesh, (&nodes, &cells, &owners), (grids, outline), ranks);
    let place = |number: u64| nodes.partition_point(|&node| node < number) as u32;
    let Share { piece, mut points, mut bodies, sizes, .. } = share;
    points.renumber(&|node| place(piece.nodes[node as usize]));
    let body_of_node: Vec<u32> = nodes.iter().map(|&node| outline.body_of[grids.of_node(node)]).collect();
    let own_nodes = || mesh.nodes.iter().zip(&body_of_node).zip(&owners).filter(|(_, owner)| **owner == own);
    let center = centres(own_nodes().map(|((x, body), _)| (*x, *body)), &mut bodies, sizes[0], ranks);
    Share {
        material_of_cell: cells.iter().map(|&cell| outline.material_of[grids.of_cell(cell)]).collect(),
        piece: MeshPiece { mesh, nodes, owner: owners, cells },
        points,
        bodies,
        body_of_node,
        center,
        sizes,
        ..share
    }
}

/// The mean of all nodes; that of each body and how far its nodes are from it.
fn centres(
    own: impl Iterator<Item = (V3, u32)> + Clone,
    bodies: &mut [Body],
    count: u64,
    ranks: &dyn Ranks,
) -> [f64; 3] {
    let mut sums = vec![(Sum::default(), 0.0); bodies.len()];
    for (x, body) in own.clone() {
        let (sum, count) = &mut sums[body as usize];
        sum.add(x);
        *count += 1.0;
    }
    let mut counts: Vec<f64> = sums.iter().map(|(_, count)| *count).collect();
    sum(ranks, &mut counts);
    let parts: Vec<V3> = sums.iter().flat_map(|(sum, _)| sum.parts()).collect();
    let all: Vec<Vec<V3>> = gather_all(ranks, to_bytes(&parts)).iter().map(|message| from_bytes(message)).collect();
    let of_body = |body: usize| Sum::of(all.iter().flat_map(|parts| [parts[2 * body], parts[2 * body + 1]]));
    for (number, (body, count)) in bodies.iter_mut().zip(&counts).enumerate() {
        body.centre = scale(1.0 / count.max(1.0), of_body(number).value());
    }
    let whole = Sum::of((0..bodies.len()).flat_map(|body| of_body(body).parts()));
    let mut radii = vec![0.0f64; bodies.len()];
    for (x, body) in own {
        let radius = &mut radii[body as usize];
        *radius = radius.max(norm(sub(x, bodies[body as usize].centre)));
    }
    max(ranks, &mut radii);
    bodies.iter_mut().zip(radii).for_each(|(body, radius)| body.radius = radius);
    scale(1.0 / count.max(1) as f64, whole.value())
}

/// The groups of the boundary of a part, in the part.
fn groups(boundary: &MeshPiece, (mesh, nodes, cells): (&Mesh, &[u64], &[u64])) -> Vec<Group> {
    let face_of = |face: &Face, cell: u64| (cell, face.local);
    let faces: Vec<(u64, u8)> = mesh.faces.iter().map(|face| face_of(face, cells[face.cell as usize])).collect();
    let face = |&number: &u32| {
        let face = &boundary.mesh.faces[number as usize];
        let face = face_of(face, boundary.cells[face.cell as usize]);
        faces.partition_point(|other| *other < face) as u32
    };
    let place = |list: &[u64], number: u64| list.partition_point(|&other| other < number) as u32;
    let group = |group: &Group| Group {
        name: group.name.clone(),
        cells: group.cells.iter().map(|&cell| place(cells, boundary.cells[cell as usize])).collect(),
        faces: group.faces.iter().map(face).collect(),
        interior_faces: Vec::new(),
        nodes: group.nodes.iter().map(|&node| place(nodes, boundary.nodes[node as usize])).collect(),
    };
    boundary.mesh.groups.iter().map(group).collect()
}

/// What a region has of the inside.
enum Inside<'a> {
    /// All of some grids.
    Grids(Vec<usize>),
    /// A box, in a whole with these bounds.
    Box(Box<dyn Fn(V3) -> bool + Sync + 'a>),
    /// One node at most.
    Point(V3),
}

impl<'a> Inside<'a> {
    fn of(region: &'a Region, grids: &Grids, outline: &'a Outline) -> Inside<'a> {
        match region {
            Region::Groups(names) => Inside::Grids(names.iter().filter_map(|(name, _)| grids.of_group(name)).collect()),
            Region::Box { min, max } => Inside::Box(Box::new(regions::in_box([*min, *max], outline.bounds))),
            Region::Point(point) => Inside::Point(*point),
        }
    }

    fn has_node(&self, grid: usize, place: V3) -> bool {
        match self {
            Inside::Grids(list) => list.contains(&grid),
            Inside::Box(within) => within(place),
            Inside::Point(_) => false,
        }
    }
}

/// Adds what regions of nodes and cells have inside the part to the groups that stand for them.
fn fill_groups(
    case: &Case,
    mesh: &mut Mesh,
    (nodes, cells, owners): (&[u64], &[u64], &[u32]),
    (grids, outline): (&Grids, &Outline),
    ranks: &dyn Ranks,
) {
    let everywhere = Inside::Grids((0..grids.len()).collect());
    let add_nodes = |list: Vec<u32>, group: Option<usize>, mesh: &mut Mesh| {
        let Some(nodes) = group.map(|k| &mut mesh.groups[k].nodes) else { return };
        *nodes = ascending(nodes.iter().copied().chain(list));
    };
    let named = |mesh: &Mesh, name: String| mesh.groups.iter().position(|group| group.name == name);
    let nodes_in = |inside: &Inside, mesh: &Mesh| -> Vec<u32> {
        let here = |&v: &usize| inside.has_node(grids.of_node(nodes[v]), mesh.nodes[v]);
        (0..nodes.len()).filter(here).map(|v| v as u32).collect()
    };
    let of_nodes = |inside: &Inside, group: Option<usize>, mesh: &mut Mesh| match inside {
        Inside::Point(point) => {
            let nearest = nearest(*point, mesh, (nodes, owners), ranks);
            let here = nearest.and_then(|number| nodes.binary_search(&number).ok()).map(|v| v as u32);
            if let Some(group) = group {
                mesh.groups[group].nodes = here.into_iter().collect();
            }
        }
        _ => add_nodes(nodes_in(inside, mesh), group, mesh),
    };
    for (k, fix) in case.fixes.iter().enumerate() {
        let group = named(mesh, name("fix", k));
        of_nodes(&Inside::of(&fix.on, grids, outline), group, mesh);
    }
    let density =
        |cell: u32| case.materials[outline.material_of[grids.of_cell(cells[cell as usize])] as usize].material.density;
    for (k, load) in case.loads.iter().enumerate() {
        let (group, LoadSpec { on, kind, .. }) = (named(mesh, name("load", k)), load);
        let inside = on.as_ref().map(|on| Inside::of(on, grids, outline));
        let inside = inside.as_ref().unwrap_or(&everywhere);
        match kind {
            LoadKind::Nodal(_) => of_nodes(inside, group, mesh),
            LoadKind::Gravity(_)
            | LoadKind::Rotation { .. }
            | LoadKind::Temperature(_)
            | LoadKind::TemperatureArray { .. } => {
                let has = |&cell: &u32| {
                    let grid = grids.of_cell(cells[cell as usize]);
                    mesh.cell(cell as usize).1.iter().all(|&v| inside.has_node(grid, mesh.nodes[v as usize]))
                };
                let mut list: Vec<u32> = (0..cells.len() as u32).filter(has).collect();
                if matches!(kind, LoadKind::Gravity(_) | LoadKind::Rotation { .. }) {
                    // As of a whole: those with mass, or all where none has.
                    let mut heavy = [f64::from(u8::from(list.iter().any(|&cell| density(cell) > 0.0)))];
                    max(ranks, &mut heavy);
                    list.retain(|&cell| heavy[0] == 0.0 || density(cell) > 0.0);
                }
                // All cells here, those of the boundary among them.
                if let Some(group) = group {
                    mesh.groups[group].cells = list;
                }
            }
            _ => {}
        }
    }
}

/// Each cell has one temperature at most, also inside, which rank 0 does not see.
fn refuse_two_temperatures(case: &Case, mesh: &Mesh) -> Result<(), Error> {
    let heated = case.loads.iter().enumerate().filter_map(|(k, load)| match load.kind {
        LoadKind::Temperature(_) | LoadKind::TemperatureArray { .. } => {
            Some((&mesh.group(&name("load", k))?.cells[..], &load.spot))
        }
        _ => None,
    });
    one_temperature_each(mesh.cell_count(), heated)
}

/// The node nearest to a point, the one with the least number if several are.
fn nearest(point: V3, mesh: &Mesh, (nodes, owners): (&[u64], &[u32]), ranks: &dyn Ranks) -> Option<u64> {
    let own = (0..nodes.len()).filter(|&v| owners[v] == ranks.rank() as u32);
    let square = |v: usize| (0..3).map(|c| (mesh.nodes[v][c] - point[c]).powi(2)).sum::<f64>();
    let best = own.map(|v| (square(v), nodes[v])).min_by(|a, b| a.0.total_cmp(&b.0));
    let message = best.map_or(Vec::new(), |(square, number)| to_bytes(&[square.to_bits(), number]));
    let all = gather_all(ranks, message);
    let found = all.iter().filter(|message| !message.is_empty()).map(|message| from_bytes::<u64>(message));
    let found = found.map(|numbers| (f64::from_bits(numbers[0]), numbers[1]));
    found.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, number)| number)
}
