//! What rank 0 finds in the whole mesh, or at its boundary, and sends to each rank for its piece.

use std::collections::HashSet;

use super::bolts::{self, RankBolt, put_bolts, take_bolts};
use super::generate::Made;
use super::local::changes;
use super::outside::{self, Outside, Surfaces};
use super::parts::{self, Parts};
use super::ranges;
use super::scope;
use super::ties::{self, has_ties};
use crate::Error;
use crate::contact::{
    Body, ContactSurface, Counterpart, Helpers, PosedPoints, Role, SurfaceFacts, bodies_of, centroid, help,
};
use crate::fem::{Axes, DofMap, FaceMoments, Fix, Load, Solid, dof_map};
use crate::io::case::{Case, ContactSpec, LoadKind, NodalSpec};
use crate::mesh::{Bounds, Cuts, Group, Mesh, MeshNotes, MeshPiece, WeightedNode, pieces};
use crate::ranks::{Ranks, Wire, agree, put, sum, take};
use crate::run::pose::activity::ALWAYS;
use crate::run::pose::load_state::{refuse_overlap, translation};
use crate::run::pose::loads::{Fixes, end, fixes, load, one_temperature, springs};
use crate::run::pose::materials::materials;
use crate::run::pose::memory::was_of_memory;
use crate::run::pose::ties::TimedFix;
use crate::run::pose::{
    ContactFacts, MemoryLimit, coefficients, coupling_facts, made_mesh, place, planned, refuse_loss_without_steps,
    regions, surfaces,
};

/// A contact node counts as so many others: the local changes of contact take a tenth of a cycle on a brick, and are made by
/// the ranks that have contact alone.
const CONTACT_WEIGHT: f64 = 6.0;

/// The names under which the regions of the case reach the ranks.
pub(super) fn name(kind: &str, number: usize) -> String {
    format!("{kind} {number}")
}

/// What one rank needs to know of the whole.
pub(super) struct Share {
    pub piece: MeshPiece,
    /// The material of each cell of the piece.
    pub material_of_cell: Vec<u32>,
    /// For each prescribed displacement the axis that a plane of symmetry holds, or [`NO_AXIS`].
    pub symmetry: Vec<u32>,
    /// For each load those of its faces in the whole mesh, zero without faces.
    pub moments: Vec<FaceMoments>,
    /// What the rigid motions turn about, the mean of all nodes; length.
    pub center: [f64; 3],
    /// That of the box around the whole mesh, length.
    pub diagonal: f64,
    /// Nodes and cells of the whole.
    pub sizes: [u64; 2],
    /// The contact points all of whose nodes are in the piece, by their places there; those that its own nodes need are.
    pub points: PosedPoints,
    /// For each surface with contact points what it may touch. Its faces are the group "contact k", those of its counterpart
    /// "master k".
    pub kinds: Vec<u8>,
    /// The contact of the case that each of them is of.
    pub contact_of: Vec<u32>,
    /// The bodies of the whole, and the number of that of each node of the piece.
    pub bodies: Vec<Body>,
    pub body_of_node: Vec<u32>,
    pub bolts: Vec<RankBolt>,
    pub ties: ties::Here,
    /// Of rank 0.
    pub outside: Option<Outside>,
}

/// A surface that may touch an obstacle, another surface, and another surface that the case names first.
pub(super) const OBSTACLE: u8 = 0;
const PAIR: u8 = 1;
pub(super) const REVERSED: u8 = 2;

/// No axis of symmetry.
pub(super) const NO_AXIS: u32 = u32::MAX;

/// The share of each rank. The mesh is made or read by all of them where it can be, otherwise by rank 0, which holds all of it for
/// that time.
pub(super) fn share(case: &Case, ranks: &dyn Ranks) -> Result<Share, Error> {
    if has_ties(case) {
        return of_whole(case, None, ranks);
    }
    match of_parts(case, ranks)? {
        Ok(share) => Ok(share),
        Err(missing) => of_whole(case, missing, ranks),
    }
}

/// That of a mesh that ranks make or read part by part; if there is none, what was wrong, which rank 0 knows.
fn of_parts(case: &Case, ranks: &dyn Ranks) -> Result<Result<Share, Option<Error>>, Error> {
    let parts = match Made::new(case, ranks) {
        Some(made) => Ok(Box::new(made) as Box<dyn Parts>),
        None => ranges::read(case, ranks).map(|read| Box::new(read) as Box<dyn Parts>),
    };
    match parts {
        Ok(mut parts) => parts::share(case, &mut *parts, ranks),
        Err(wrong) => Ok(Err(wrong)),
    }
}

/// That of a mesh that rank 0 makes or reads; `missing` is the error if it cannot hold it.
pub(super) fn of_whole(case: &Case, missing: Option<Error>, ranks: &dyn Ranks) -> Result<Share, Error> {
    let whole = if ranks.rank() == 0 {
        Whole::made(case, &Helpers::new(ranks), missing).map(Some)
    } else {
        help(ranks);
        Ok(None)
    };
    let whole = agree(ranks, whole)?;
    let nodes = whole.as_ref().map_or(Vec::new(), Whole::nodes_to_divide);
    let cuts = Cuts::new(ranks, &nodes, ranks.size());
    enough(case, &cuts, &nodes, ranks)?;
    drop(nodes);
    Ok(Share::sent(case, whole.map(|whole| whole.divided(&cuts)), ranks))
}

/// Refuses ranks of which some would have no nodes: `nodes` are those that this rank has divided.
pub(super) fn enough(case: &Case, cuts: &Cuts, nodes: &[WeightedNode], ranks: &dyn Ranks) -> Result<(), Error> {
    let parts = ranks.size();
    let mut counts = vec![0.0; parts];
    nodes.iter().for_each(|node| counts[cuts.part(node.place, node.number) as usize] += 1.0);
    sum(ranks, &mut counts);
    if counts.contains(&0.0) {
        let what = format!("the mesh has too few nodes that move for {parts} ranks: some would have none");
        return Err(case.mesh.spot.error(what, "use fewer ranks"));
    }
    Ok(())
}

/// The share of this rank, as a message: rank 0, which alone has them, sends each its own.
fn sent(ranks: &dyn Ranks, divided: Option<Divided>) -> Vec<u8> {
    let Some(divided) = divided else { return ranks.exchange(Vec::new(), &[0]).swap_remove(0) };
    let mut own = Vec::new();
    for (rank, message) in divided.messages(ranks.size()).enumerate() {
        // One after the other: rank 0 never holds all pieces beside the mesh.
        match rank {
            0 => own = message,
            _ => drop(ranks.exchange(vec![(rank, message)], &[])),
        }
    }
    own
}

/// The whole mesh, or what of it lies at its boundary. Its groups are the regions of the case.
pub(super) struct Whole {
    pub mesh: Mesh,
    /// The numbers of its nodes and cells where these are not all.
    numbers: Option<[Vec<u64>; 2]>,
    /// Nodes and cells of the whole.
    sizes: [u64; 2],
    material_of_cell: Vec<u32>,
    symmetry: Vec<u32>,
    moments: Vec<FaceMoments>,
    points: PosedPoints,
    kinds: Vec<u8>,
    contact_of: Vec<u32>,
    bodies: Vec<Body>,
    body_of_node: Vec<u32>,
    bolts: Vec<RankBolt>,
    ties: ties::Whole,
    outside: Option<Outside>,
    /// What each node counts when the mesh is divided; nodes that go where another does, and that one, which counts for both.
    pub weights: Vec<f64>,
    leaders: Vec<[u32; 2]>,
}

impl Whole {
    /// Of a mesh that is too large to be made or read the error says what its boundary or a range of it is `missing`, if that was looked
    /// at.
    fn made(case: &Case, helpers: &Helpers, missing: Option<Error>) -> Result<Whole, Error> {
        let limit = MemoryLimit { divided: true, ..MemoryLimit::of(&case.solver) };
        let instead = |error: Error| if was_of_memory(&error) { missing.unwrap_or(error) } else { error };
        let (mesh, notes) = made_mesh(&case.mesh, &limit).map_err(instead)?;
        let sizes = [mesh.nodes.len() as u64, mesh.cell_count() as u64];
        Whole::new(case, (mesh, notes), (None, sizes), None, helpers)
    }

    /// A case on a mesh, to be divided among the ranks, which help to find contact. The body of each node, and the bodies, are found
    /// unless they are `known`.
    pub(super) fn new(
        case: &Case,
        (mut mesh, notes): (Mesh, MeshNotes),
        (numbers, sizes): (Option<[Vec<u64>; 2]>, [u64; 2]),
        known: Option<(Vec<u32>, Vec<Body>)>,
        helpers: &Helpers,
    ) -> Result<Whole, Error> {
        let parts = helpers.ranks();
        if sizes[0] < parts as u64 {
            let what = format!("the mesh has {} nodes and there are {parts} ranks", sizes[0]);
            return Err(case.mesh.spot.error(what, "use fewer ranks"));
        }
        let (materials, material_of_cell) = materials(&mesh, &case.materials)?;
        let Fixes { held, timed, facts: fix_facts, .. } = fixes(&mesh, case)?;
        let (body_of_node, bodies) = known.unwrap_or_else(|| bodies_of(&mesh));
        let mut groups = Vec::new();
        let symmetry = fixed_regions(case, &held, &timed, &mut groups)?;
        for (k, spring) in case.springs.iter().enumerate() {
            let faces = regions::faces(&mesh, &spring.on, &spring.spot, "the spring")?;
            groups.push(Group { name: name("spring", k), faces, ..Group::default() });
        }
        let dofs = dof_map(&mesh, &held, end(case)).map_err(|error| place::at(&case.mesh.spot, error))?;
        let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &material_of_cell };
        let moments = loaded_regions(case, &solid, &mut groups)?;
        let (points, surfaces) = contact((case, numbers.is_none()), &solid, &dofs, &held, (&mut groups, helpers))?;
        let kinds = surfaces.surfaces.iter().map(kind).collect();
        let contact_of = surfaces.contact_of.iter().map(|&k| k as u32).collect();
        let (bolts, bolt_facts) = bolts::of_whole(case, &solid, &dofs, &points)?;
        let ties = ties::Whole::new(case, &solid, &dofs, (&held, &timed), &points)?;
        let found = outside::Found {
            notes,
            kinds: mesh.cells.iter().map(|block| block.kind).collect(),
            fixes: fix_facts,
            springs: springs(&mesh, &case.springs)?.1,
            bolts: bolt_facts,
            couplings: coupling_facts(&mesh, case, &ties.couplings)?,
            tied: ties.held,
        };
        let of_nodes = (numbers.as_ref().map(|[nodes, _]| &nodes[..]), &body_of_node[..]);
        let outside = Some(Outside::new(&mesh, of_nodes, surfaces, found));
        mesh.groups = groups;
        keep_arrays(case, &mut mesh);
        let leaders = ties.leaders(&mesh, points.leaders());
        let weights = weights(&mesh, &points, &dofs, &leaders, parts);
        Ok(Whole {
            mesh,
            numbers,
            sizes,
            material_of_cell,
            symmetry,
            moments,
            points,
            kinds,
            contact_of,
            bodies,
            body_of_node,
            bolts,
            ties,
            outside,
            weights,
            leaders,
        })
    }

    /// The number of a node in the whole.
    pub(super) fn node_number(&self, v: usize) -> u64 {
        self.numbers.as_ref().map_or(v as u64, |[nodes, _]| nodes[v])
    }

    /// The nodes that go where others do.
    pub(super) fn follows(&self) -> HashSet<u32> {
        self.leaders.iter().map(|[node, _]| *node).collect()
    }

    fn nodes_to_divide(&self) -> Vec<WeightedNode> {
        let follows = self.follows();
        let leads = (0..self.mesh.nodes.len()).filter(|v| !follows.contains(&(*v as u32)));
        let node =
            |v: usize| WeightedNode { place: self.mesh.nodes[v], number: self.node_number(v), weight: self.weights[v] };
        leads.map(node).collect()
    }

    pub(super) fn divided(self, cuts: &Cuts) -> Divided {
        let part = |(v, x): (usize, &[f64; 3])| cuts.part(*x, self.node_number(v));
        let mut owner: Vec<u32> = self.mesh.nodes.iter().enumerate().map(part).collect();
        self.leaders.iter().for_each(|&[node, leader]| owner[node as usize] = owner[leader as usize]);
        Divided { whole: self, owner }
    }
}

/// The same with the rank of each node.
pub(super) struct Divided {
    whole: Whole,
    owner: Vec<u32>,
}

impl Divided {
    /// The nodes that go where others do, by their numbers in the whole, and their ranks.
    pub(super) fn following(&self) -> Vec<[u64; 2]> {
        let rank = |&[node, _]: &[u32; 2]| [self.whole.node_number(node as usize), self.owner[node as usize].into()];
        self.whole.leaders.iter().map(rank).collect()
    }

    /// For each rank in turn.
    fn messages(&self, parts: usize) -> impl Iterator<Item = Vec<u8>> {
        let Divided { whole, owner } = self;
        let Whole {
            mesh,
            numbers,
            sizes,
            material_of_cell,
            symmetry,
            moments,
            points,
            kinds,
            contact_of,
            bodies,
            body_of_node,
            bolts,
            ties,
            ..
        } = whole;
        let center = centroid(mesh);
        let diagonal = Bounds::around(mesh.nodes.iter().copied()).diagonal();
        let links = [points.links(), ties.links(&|_| true)].concat();
        let by_node = points.by_node();
        let message = move |(rank, mut piece): (usize, MeshPiece)| {
            let mut to = Vec::new();
            sizes.write(&mut to);
            center.write(&mut to);
            diagonal.write(&mut to);
            put(&piece.cells.iter().map(|&cell| material_of_cell[cell as usize]).collect::<Vec<_>>(), &mut to);
            put(symmetry, &mut to);
            put(&moments.iter().map(FaceMoments::numbers).collect::<Vec<_>>(), &mut to);
            put(kinds, &mut to);
            put(contact_of, &mut to);
            put(&piece.nodes.iter().map(|&node| body_of_node[node as usize]).collect::<Vec<_>>(), &mut to);
            put(
                &bodies
                    .iter()
                    .map(|body| [body.centre[0], body.centre[1], body.centre[2], body.radius])
                    .collect::<Vec<_>>(),
                &mut to,
            );
            bodies.iter().for_each(|body| put(body.name.as_bytes(), &mut to));
            put_bolts(bolts, &piece, &mut to);
            let place = |node: u32| piece.nodes.binary_search(&u64::from(node)).ok().map(|k| k as u32);
            to.extend(ties.message(&place, &|node| owner[node as usize] as usize == rank));
            to.extend(points.message(&by_node, &piece.nodes));
            if let Some([nodes, cells]) = numbers {
                piece.nodes.iter_mut().for_each(|v| *v = nodes[*v as usize]);
                piece.cells.iter_mut().for_each(|c| *c = cells[*c as usize]);
            }
            to.extend(piece.to_bytes());
            to
        };
        pieces(mesh, owner, parts, &links).enumerate().map(message)
    }
}

/// The nodes of each prescribed displacement as a group, and the axis that a plane of symmetry holds, or [`NO_AXIS`].
fn fixed_regions(case: &Case, held: &[Fix], timed: &[TimedFix], groups: &mut Vec<Group>) -> Result<Vec<u32>, Error> {
    let (mut symmetry, mut held, mut timed) = (Vec::new(), held.iter(), timed.iter().map(|timed| &timed.fix));
    for (k, spec) in case.fixes.iter().enumerate() {
        let always = spec.during.period(&case.steps) == ALWAYS;
        let Some(fix) = (if always { held.next() } else { timed.next() }) else { continue };
        groups.push(Group { name: name("fix", k), nodes: fix.nodes.clone(), ..Group::default() });
        let along = (0..3).find(|&c| fix.value[c].is_some()).filter(|_| spec.symmetry);
        if along.is_some() && fix.axes != Axes::Global {
            let what = "a plane of symmetry across no axis cannot be divided among ranks in this version";
            return Err(spec.spot.error(what, "use `stiction solve` on one machine"));
        }
        symmetry.push(along.map_or(NO_AXIS, |c| c as u32));
    }
    Ok(symmetry)
}

/// The contact points, and the kind of each surface, whose faces become groups. Which surface carries the
/// points, and how far it looks for the other one, is a matter of whole surfaces.
fn contact(
    (case, is_whole): (&Case, bool),
    solid: &Solid,
    dofs: &DofMap,
    held: &[Fix],
    (groups, helpers): (&mut Vec<Group>, &Helpers),
) -> Result<(PosedPoints, Surfaces), Error> {
    let mesh = solid.mesh;
    refuse_loss_without_steps(&case.contacts, &case.steps)?;
    let mut surfaces = surfaces::surfaces(mesh, &case.contacts, &case.steps)?;
    surfaces::assign(solid, dofs, &case.couplings, &mut surfaces);
    let of = surfaces::reverse(solid, dofs, &mut surfaces);
    for (surface, &k) in surfaces.iter().zip(&of) {
        // Nodes that make up no face may lie inside, which rank 0 has of a whole alone.
        let alone = matches!(&surface.against, Counterpart::Surface(master) if master.nodes.is_some());
        if alone && !is_whole {
            return Err(scope::refused(
                &case.contacts[k].spot,
                "a contact of nodes without faces, of a mesh that rank 0 has no memory for,",
            ));
        }
    }
    let named = |(surface, &k): (&ContactSurface, &usize)| ContactSpec {
        name: surface.name.clone(),
        ..case.contacts[k].clone()
    };
    let specs: Vec<ContactSpec> = surfaces.iter().zip(&of).map(named).collect();
    coefficients::read(mesh, &specs, &mut surfaces, end(case))?;
    let (points, facts) = PosedPoints::new(mesh, dofs, &surfaces, helpers.meet(mesh, &surfaces)).map_err(|error| {
        let named = surfaces.iter().position(|surface| error.place == format!("contact \"{}\"", surface.name));
        named.map_or(error.clone(), |k| place::at(&case.contacts[of[k]].spot, error))
    })?;
    if let Some(k) = facts.iter().position(|facts| facts.held_along_surface > 0) {
        // Multigrid, which ranks solve by, wants the node of a point free.
        let what = "contact points that a support holds along the surface while the other body moves there cannot be divided among \
                    ranks in this version";
        let remedy = "let `slave` name the other surface, or use `stiction solve` on one machine";
        return Err(case.contacts[of[k]].spot.error(what, remedy));
    }
    let mut seen = HashSet::new();
    let changes = |facts: &SurfaceFacts| !facts.out.is_empty() || facts.nodes.iter().any(|&node| !seen.insert(node));
    if let Some(k) = facts.iter().position(changes) {
        let what = "contacts that have nodes in common, at different times or as obstacles,";
        return Err(scope::refused(&case.contacts[of[k]].spot, what));
    }
    overlap_of_held_nodes(case, mesh, held, (&surfaces, &of), &points)?;
    for (k, surface) in surfaces.iter().enumerate() {
        groups.push(Group { name: name("contact", k), faces: surface.faces.clone(), ..Group::default() });
        if let Counterpart::Surface(master) = &surface.against {
            groups.push(Group { name: name("master", k), faces: master.faces.clone(), ..Group::default() });
        }
    }
    let contacts = facts.into_iter().zip(&surfaces).zip(&specs);
    let contacts = contacts.map(|((facts, surface), spec)| ContactFacts::new(facts, surface, spec)).collect();
    Ok((points, Surfaces { surfaces, contacts, specs, contact_of: of }))
}

/// What a surface may touch.
fn kind(surface: &ContactSurface) -> u8 {
    match &surface.against {
        Counterpart::Surface(master) if master.slave == Role::Against => REVERSED,
        Counterpart::Surface(_) => PAIR,
        Counterpart::Obstacle(_) => OBSTACLE,
    }
}

/// Refuses nodes that are held where an obstacle gets to, at the end of every planned increment.
fn overlap_of_held_nodes(
    case: &Case,
    mesh: &Mesh,
    held: &[Fix],
    (surfaces, of): (&[ContactSurface], &[usize]),
    points: &PosedPoints,
) -> Result<(), Error> {
    if !changes(case) {
        return Ok(());
    }
    let mut times = planned(case);
    if times.is_empty() {
        times.push(end(case));
    }
    let carries: HashSet<u32> = points.nodes().collect();
    for t in times {
        let dofs = dof_map(mesh, held, t).map_err(|error| place::at(&case.mesh.spot, error))?;
        for (surface, &k) in surfaces.iter().zip(of) {
            let contact = &case.contacts[k];
            let moved = translation(contact.motion.as_ref(), t);
            let moved = moved.map_err(|error| place::instead(&contact.spot, error))?;
            refuse_overlap(mesh, &dofs, surface, &carries, moved, t)
                .map_err(|error| place::at(&contact.spot, error))?;
        }
    }
    Ok(())
}

/// What each node counts when the mesh is divided.
fn weights(mesh: &Mesh, points: &PosedPoints, dofs: &DofMap, leaders: &[[u32; 2]], parts: usize) -> Vec<f64> {
    let mut weights = vec![1.0; mesh.nodes.len()];
    points.nodes().chain(points.links().into_iter().flatten()).for_each(|v| weights[v as usize] = CONTACT_WEIGHT);
    // A part needs nodes that move: those held in all directions have no row in any matrix.
    for three in dofs.prescribed.windows(3).filter(|three| three[0] % 3 == 0 && three[2] == three[0] + 2) {
        weights[three[0] as usize / 3] = 0.0;
    }
    for &[node, leader] in leaders {
        weights[leader as usize] += std::mem::take(&mut weights[node as usize]);
    }
    // Others have to be left for the part of one that leads many.
    let most = weights.iter().sum::<f64>() / (2 * parts) as f64;
    leaders.iter().for_each(|&[_, leader]| weights[leader as usize] = weights[leader as usize].min(most));
    weights
}

/// The faces, nodes or cells of each load as a group, and the moments of its faces.
fn loaded_regions(case: &Case, solid: &Solid, groups: &mut Vec<Group>) -> Result<Vec<FaceMoments>, Error> {
    let mesh = solid.mesh;
    let loads: Vec<Load> = case.loads.iter().map(|spec| load(mesh, spec)).collect::<Result<_, _>>()?;
    one_temperature(mesh, &loads, &case.loads)?;
    let region = |(k, load): (usize, Load)| {
        let group = Group { name: name("load", k), ..Group::default() };
        match load {
            Load::Traction { faces, .. }
            | Load::Pressure { faces, .. }
            | Load::Force { faces, .. }
            | Load::Resultant { faces, .. }
            | Load::Hydrostatic { faces, .. } => Group { faces, ..group },
            Load::Nodal { nodes, .. } => Group { nodes, ..group },
            Load::Gravity { cells, .. } | Load::Rotation { cells, .. } => {
                Group { cells: with_mass(solid, cells), ..group }
            }
            Load::Temperature { cells, .. } => Group { cells, ..group },
        }
    };
    let first = groups.len();
    groups.extend(loads.into_iter().enumerate().map(region));
    Ok(groups[first..].iter().map(|group| FaceMoments::new(mesh, &group.faces)).collect())
}

/// Those of the cells that have mass: a piece may have others only. All of them where none has, which is an error that all ranks see.
fn with_mass(solid: &Solid, cells: Vec<u32>) -> Vec<u32> {
    let has_mass = |&cell: &u32| solid.materials[solid.material_of_cell[cell as usize] as usize].density > 0.0;
    let heavy: Vec<u32> = cells.iter().copied().filter(has_mass).collect();
    if heavy.is_empty() { cells } else { heavy }
}

/// Leaves the mesh the arrays that loads name.
fn keep_arrays(case: &Case, mesh: &mut Mesh) {
    let mut named: HashSet<&str> = HashSet::new();
    for load in &case.loads {
        match &load.kind {
            LoadKind::TemperatureArray { name, .. } => drop(named.insert(name)),
            LoadKind::Nodal(value) => named.extend(value.iter().filter_map(|component| match component {
                NodalSpec::Array { name, .. } => Some(name.as_str()),
                NodalSpec::Field(_) => None,
            })),
            _ => {}
        }
    }
    mesh.arrays.nodes.retain(|array| named.contains(array.name.as_str()));
    mesh.arrays.cells.retain(|array| named.contains(array.name.as_str()));
}

impl Share {
    /// That of this rank; rank 0 alone has `divided`.
    pub(super) fn sent(case: &Case, mut divided: Option<Divided>, ranks: &dyn Ranks) -> Share {
        let outside = divided.as_mut().and_then(|divided| divided.whole.outside.take());
        Share { outside, ..Share::from_bytes(case, &sent(ranks, divided)) }
    }

    fn from_bytes(case: &Case, bytes: &[u8]) -> Share {
        let (sizes, center, diagonal) = (Wire::read(bytes), Wire::read(&bytes[16..]), Wire::read(&bytes[40..]));
        let mut from = &bytes[48..];
        let from = &mut from;
        let (material_of_cell, symmetry, moments) = (take(from), take(from), take::<[f64; 13]>(from));
        let (kinds, contact_of, body_of_node) = (take(from), take(from), take(from));
        let places: Vec<[f64; 4]> = take(from);
        let body = |[x, y, z, radius]: [f64; 4]| Body {
            name: String::from_utf8_lossy(&take::<u8>(from)).into_owned(),
            centre: [x, y, z],
            radius,
        };
        let bodies = places.into_iter().map(body).collect();
        let bolts = take_bolts(&case.bolts, from);
        let ties = ties::Here::take(case, from);
        let points = PosedPoints::take(from);
        let piece = MeshPiece::from_bytes(from);
        Share {
            piece,
            material_of_cell,
            symmetry,
            moments: moments.into_iter().map(FaceMoments::of_numbers).collect(),
            center,
            diagonal,
            sizes,
            points,
            kinds,
            contact_of,
            bodies,
            body_of_node,
            bolts,
            ties,
            outside: None,
        }
    }
}

#[cfg(test)]
#[path = "share_tests.rs"]
mod tests;
