//! What rank 0 finds in the whole mesh, and sends to each rank for its piece.

use std::collections::HashSet;

use super::bolts::{self, RankBolt, put_bolts, take_bolts};
use super::local::changes;
use super::scope;
use crate::Error;
use crate::contact::{Body, ContactSurface, Counterpart, PosedPoints, Role, bodies_of, centroid};
use crate::fem::{Axes, DofMap, FaceMoments, Fix, Load, Solid, dof_map};
use crate::io::case::{Case, ContactSpec, LoadKind, NodalSpec};
use crate::mesh::{Bounds, Group, Mesh, MeshPiece, bisection, pieces};
use crate::ranks::{Ranks, Wire, agree, put, take};
use crate::run::pose::activity::ALWAYS;
use crate::run::pose::load_state::{refuse_overlap, translation};
use crate::run::pose::loads::{Fixes, end, fixes, load, one_temperature};
use crate::run::pose::materials::materials;
use crate::run::pose::ties::TimedFix;
use crate::run::pose::{
    MemoryLimit, coefficients, made_mesh, place, planned, refuse_loss_without_steps, regions, surfaces,
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
}

/// A surface that may touch an obstacle, another surface, and another surface that the case names first.
pub(super) const OBSTACLE: u8 = 0;
const PAIR: u8 = 1;
pub(super) const REVERSED: u8 = 2;

/// No axis of symmetry.
pub(super) const NO_AXIS: u32 = u32::MAX;

/// The share of each rank: the mesh is made or read, checked and divided by rank 0, which holds all of it for that time.
pub(super) fn share(case: &Case, ranks: &dyn Ranks) -> Result<Share, Error> {
    let whole = if ranks.rank() == 0 { Whole::new(case, ranks.size()).map(Some) } else { Ok(None) };
    let whole = agree(ranks, whole)?;
    let Some(whole) = whole else { return Ok(Share::from_bytes(case, &ranks.exchange(Vec::new(), &[0])[0])) };
    let mut own = None;
    for (rank, message) in whole.messages(ranks.size()).enumerate() {
        // One after the other: rank 0 never holds all pieces beside the mesh.
        match rank {
            0 => own = Some(message),
            _ => drop(ranks.exchange(vec![(rank, message)], &[])),
        }
    }
    Ok(Share::from_bytes(case, &own.unwrap_or_default()))
}

/// The whole mesh, whose groups are the regions of the case.
struct Whole {
    mesh: Mesh,
    owner: Vec<u32>,
    material_of_cell: Vec<u32>,
    symmetry: Vec<u32>,
    moments: Vec<FaceMoments>,
    points: PosedPoints,
    kinds: Vec<u8>,
    contact_of: Vec<u32>,
    bodies: Vec<Body>,
    body_of_node: Vec<u32>,
    bolts: Vec<RankBolt>,
}

impl Whole {
    fn new(case: &Case, parts: usize) -> Result<Whole, Error> {
        let limit = MemoryLimit { divided: true, ..MemoryLimit::of(&case.solver) };
        let (mut mesh, _) = made_mesh(&case.mesh, &limit)?;
        if mesh.nodes.len() < parts {
            let what = format!("the mesh has {} nodes and there are {parts} ranks", mesh.nodes.len());
            return Err(case.mesh.spot.error(what, "use fewer ranks"));
        }
        let (materials, material_of_cell) = materials(&mesh, &case.materials)?;
        let Fixes { held, timed, .. } = fixes(&mesh, case)?;
        let (body_of_node, bodies) = bodies_of(&mesh);
        let mut groups = Vec::new();
        let symmetry = fixed_regions(case, &held, &timed, &mut groups)?;
        for (k, spring) in case.springs.iter().enumerate() {
            let faces = regions::faces(&mesh, &spring.on, &spring.spot, "the spring")?;
            groups.push(Group { name: name("spring", k), faces, ..Group::default() });
        }
        let dofs = dof_map(&mesh, &held, end(case)).map_err(|error| place::at(&case.mesh.spot, error))?;
        let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &material_of_cell };
        let moments = loaded_regions(case, &solid, &mut groups)?;
        let (points, kinds, contact_of) = contact(case, &solid, &dofs, &held, &mut groups)?;
        let bolts = bolts::of_whole(case, &solid, &dofs, &points)?;
        mesh.groups = groups;
        keep_arrays(case, &mut mesh);
        let owner = divided(case, &mesh, &points, &held, parts)?;
        Ok(Whole {
            mesh,
            owner,
            material_of_cell,
            symmetry,
            moments,
            points,
            kinds,
            contact_of,
            bodies,
            body_of_node,
            bolts,
        })
    }

    /// For each rank in turn.
    fn messages(&self, parts: usize) -> impl Iterator<Item = Vec<u8>> {
        let Whole {
            mesh,
            owner,
            material_of_cell,
            symmetry,
            moments,
            points,
            kinds,
            contact_of,
            bodies,
            body_of_node,
            bolts,
        } = self;
        let center = centroid(mesh);
        let diagonal = Bounds::around(mesh.nodes.iter().copied()).diagonal();
        let sizes = [mesh.nodes.len() as u64, mesh.cell_count() as u64];
        let message = move |piece: MeshPiece| {
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
            to.extend(points.message(&piece.nodes));
            to.extend(piece.to_bytes());
            to
        };
        pieces(mesh, owner, parts, &points.links()).map(message)
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
    case: &Case,
    solid: &Solid,
    dofs: &DofMap,
    held: &[Fix],
    groups: &mut Vec<Group>,
) -> Result<(PosedPoints, Vec<u8>, Vec<u32>), Error> {
    let mesh = solid.mesh;
    refuse_loss_without_steps(&case.contacts, &case.steps)?;
    let mut surfaces = surfaces::surfaces(mesh, &case.contacts)?;
    surfaces::assign(solid, dofs, &mut surfaces);
    let of = surfaces::reverse(solid, dofs, &mut surfaces);
    for (surface, &k) in surfaces.iter().zip(&of) {
        if matches!(&surface.against, Counterpart::Surface(master) if master.nodes.is_some()) {
            return Err(scope::refused(&case.contacts[k].spot, "a contact of nodes without faces"));
        }
    }
    let specs: Vec<ContactSpec> = of.iter().map(|&k| case.contacts[k].clone()).collect();
    coefficients::read(mesh, &specs, &mut surfaces, end(case))?;
    let (points, _) = PosedPoints::new(mesh, dofs, &surfaces).map_err(|error| {
        let named = surfaces.iter().position(|surface| error.place == format!("contact \"{}\"", surface.name));
        named.map_or(error.clone(), |k| place::at(&case.contacts[of[k]].spot, error))
    })?;
    overlap_of_held_nodes(case, mesh, held, (&surfaces, &of), &points)?;
    let kinds = surfaces.iter().map(|surface| match &surface.against {
        Counterpart::Surface(master) if master.slave == Role::Against => REVERSED,
        Counterpart::Surface(_) => PAIR,
        Counterpart::Obstacle(_) => OBSTACLE,
    });
    let kinds = kinds.collect();
    for (k, surface) in surfaces.into_iter().enumerate() {
        groups.push(Group { name: name("contact", k), faces: surface.faces, ..Group::default() });
        if let Counterpart::Surface(master) = surface.against {
            groups.push(Group { name: name("master", k), faces: master.faces, ..Group::default() });
        }
    }
    Ok((points, kinds, of.iter().map(|&k| k as u32).collect()))
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

/// The rank of each node.
fn divided(case: &Case, mesh: &Mesh, points: &PosedPoints, held: &[Fix], parts: usize) -> Result<Vec<u32>, Error> {
    let mut weights = vec![1.0; mesh.nodes.len()];
    points.nodes().chain(points.links().into_iter().flatten()).for_each(|v| weights[v as usize] = CONTACT_WEIGHT);
    // A part needs nodes that move: those held in all directions have no row in any matrix.
    for fix in held.iter().filter(|fix| fix.value.iter().all(Option::is_some)) {
        fix.nodes.iter().for_each(|&v| weights[v as usize] = 0.0);
    }
    let owner = bisection_with_leaders(mesh, weights, &points.leaders(), parts);
    let mut has_nodes = vec![false; parts];
    owner.iter().for_each(|&part| has_nodes[part as usize] = true);
    if has_nodes.contains(&false) {
        let what = format!("the mesh has too few nodes that move for {parts} ranks: some would have none");
        return Err(case.mesh.spot.error(what, "use fewer ranks"));
    }
    Ok(owner)
}

/// The parts of the nodes where some are in that of a leader: `leaders` are pairs of both.
fn bisection_with_leaders(mesh: &Mesh, mut weights: Vec<f64>, leaders: &[[u32; 2]], parts: usize) -> Vec<u32> {
    if leaders.is_empty() {
        return bisection(&mesh.nodes, &weights, parts);
    }
    let mut follows = vec![u32::MAX; mesh.nodes.len()];
    for &[node, leader] in leaders {
        follows[node as usize] = leader;
        weights[leader as usize] += std::mem::take(&mut weights[node as usize]);
    }
    let free: Vec<usize> = (0..mesh.nodes.len()).filter(|&v| follows[v] == u32::MAX).collect();
    let places: Vec<[f64; 3]> = free.iter().map(|&v| mesh.nodes[v]).collect();
    let of_free = bisection(&places, &free.iter().map(|&v| weights[v]).collect::<Vec<_>>(), parts);
    let mut owner = vec![0; mesh.nodes.len()];
    free.iter().zip(of_free).for_each(|(&v, part)| owner[v] = part);
    leaders.iter().for_each(|&[node, leader]| owner[node as usize] = owner[leader as usize]);
    owner
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
        }
    }
}
