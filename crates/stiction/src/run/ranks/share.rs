//! What rank 0 finds in the whole mesh, and sends to each rank for its piece.

use super::scope;
use crate::Error;
use crate::contact::centroid;
use crate::fem::Axes;
use crate::io::case::{Case, LoadKind, Region, Spot};
use crate::mesh::v3::{norm, sub};
use crate::mesh::{Group, Mesh, MeshPiece, bisection, pieces};
use crate::ranks::{Ranks, Wire, agree, from_bytes, to_bytes};
use crate::run::pose::loads::{Fixes, fixes};
use crate::run::pose::materials::materials;
use crate::run::pose::{MemoryLimit, made_mesh, regions};

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
    /// For each load the area of its faces in the whole mesh, zero without faces.
    pub area: Vec<f64>,
    /// What the rigid motions turn about, the mean of all nodes; length.
    pub center: [f64; 3],
    /// The largest distance of a node from it.
    pub radius: f64,
    /// Nodes and cells of the whole.
    pub sizes: [u64; 2],
}

/// No axis of symmetry.
pub(super) const NO_AXIS: u32 = u32::MAX;

/// The share of each rank: the mesh is made or read, checked and divided by rank 0, which holds all of it for that time.
pub(super) fn share(case: &Case, ranks: &dyn Ranks) -> Result<Share, Error> {
    let whole = if ranks.rank() == 0 { Whole::new(case, ranks.size()).map(Some) } else { Ok(None) };
    let whole = agree(ranks, whole)?;
    let Some(whole) = whole else { return Ok(Share::from_bytes(&ranks.exchange(Vec::new(), &[0])[0])) };
    let mut own = None;
    for (rank, message) in whole.messages(ranks.size()).enumerate() {
        // One after the other: rank 0 never holds all pieces beside the mesh.
        match rank {
            0 => own = Some(message),
            _ => drop(ranks.exchange(vec![(rank, message)], &[])),
        }
    }
    Ok(Share::from_bytes(&own.unwrap_or_default()))
}

/// The whole mesh, whose groups are the regions of the case.
struct Whole {
    mesh: Mesh,
    owner: Vec<u32>,
    material_of_cell: Vec<u32>,
    symmetry: Vec<u32>,
    area: Vec<f64>,
}

impl Whole {
    fn new(case: &Case, parts: usize) -> Result<Whole, Error> {
        let limit = MemoryLimit::of(&case.solver);
        let (mut mesh, _) = made_mesh(&case.mesh, &limit)?;
        scope::check_mesh(case, &mesh)?;
        if mesh.nodes.len() < parts {
            let what = format!("the mesh has {} nodes and there are {parts} ranks", mesh.nodes.len());
            return Err(case.mesh.spot.error(what, "use fewer ranks"));
        }
        let (_, material_of_cell) = materials(&mesh, &case.materials)?;
        let Fixes { held, .. } = fixes(&mesh, case)?;
        let mut groups = Vec::new();
        let mut symmetry = Vec::new();
        for (k, (spec, fix)) in case.fixes.iter().zip(&held).enumerate() {
            groups.push(Group { name: name("fix", k), nodes: fix.nodes.clone(), ..Group::default() });
            let along = (0..3).find(|&c| fix.value[c].is_some()).filter(|_| spec.symmetry);
            if along.is_some() && fix.axes != Axes::Global {
                let what = "a plane of symmetry across no axis cannot be divided among ranks in this version";
                return Err(spec.spot.error(what, "use `stiction solve` on one machine"));
            }
            symmetry.push(along.map_or(NO_AXIS, |c| c as u32));
        }
        let mut area = Vec::new();
        for (k, load) in case.loads.iter().enumerate() {
            let (group, of_faces) = region_of_load(&mesh, load.on.as_ref(), &load.kind, &load.spot)?;
            groups.push(Group { name: name("load", k), ..group });
            area.push(of_faces);
        }
        let mut weights = vec![1.0; mesh.nodes.len()];
        for (k, contact) in case.contacts.iter().enumerate() {
            let faces = regions::faces(&mesh, &contact.on, &contact.spot, "the contact")?;
            mesh.face_nodes(&faces).iter().for_each(|&v| weights[v as usize] = CONTACT_WEIGHT);
            groups.push(Group { name: name("contact", k), faces, ..Group::default() });
        }
        mesh.groups = groups;
        // A part needs nodes that move: those held in all directions have no row in any matrix.
        for fix in held.iter().filter(|fix| fix.value.iter().all(Option::is_some)) {
            fix.nodes.iter().for_each(|&v| weights[v as usize] = 0.0);
        }
        let owner = bisection(&mesh.nodes, &weights, parts);
        let mut has_nodes = vec![false; parts];
        owner.iter().for_each(|&part| has_nodes[part as usize] = true);
        if has_nodes.contains(&false) {
            let what = format!("the mesh has too few nodes that move for {parts} ranks: some would have none");
            return Err(case.mesh.spot.error(what, "use fewer ranks"));
        }
        Ok(Whole { mesh, owner, material_of_cell, symmetry, area })
    }

    /// For each rank in turn.
    fn messages(&self, parts: usize) -> impl Iterator<Item = Vec<u8>> {
        let Whole { mesh, owner, material_of_cell, symmetry, area } = self;
        let center = centroid(mesh);
        let radius = mesh.nodes.iter().map(|&x| norm(sub(x, center))).fold(0.0, f64::max);
        let sizes = [mesh.nodes.len() as u64, mesh.cell_count() as u64];
        let message = move |piece: MeshPiece| {
            let materials = piece.cells.iter().map(|&cell| material_of_cell[cell as usize]).collect();
            let (symmetry, area) = (symmetry.clone(), area.clone());
            Share { piece, material_of_cell: materials, symmetry, area, center, radius, sizes }.to_bytes()
        };
        pieces(mesh, owner, parts).map(message)
    }
}

/// The faces, nodes or cells of a load, and the area of the faces.
fn region_of_load(mesh: &Mesh, on: Option<&Region>, kind: &LoadKind, spot: &Spot) -> Result<(Group, f64), Error> {
    let mut group = Group::default();
    if kind.at_nodes() {
        let all = || Ok((0..mesh.nodes.len() as u32).collect());
        group.nodes = on.map_or_else(all, |region| regions::nodes(mesh, region, spot))?;
    } else if kind.on_cells() {
        let all = || Ok((0..mesh.cell_count() as u32).collect());
        group.cells = on.map_or_else(all, |region| regions::cells(mesh, region, spot))?;
    } else {
        let nowhere = || spot.error("this load does not say where it acts", "add on = \"z-max\" or another group");
        group.faces = regions::faces(mesh, on.ok_or_else(nowhere)?, spot, "the load")?;
    }
    let area = group.faces.iter().map(|&face| mesh.face_area(face as usize)).sum();
    Ok((group, area))
}

impl Share {
    fn to_bytes(&self) -> Vec<u8> {
        let Share { piece, material_of_cell, symmetry, area, center, radius, sizes } = self;
        let mut to = Vec::new();
        [material_of_cell.len(), symmetry.len(), area.len()].map(|n| n as u64).write(&mut to);
        sizes.write(&mut to);
        center.write(&mut to);
        radius.write(&mut to);
        [to, to_bytes(material_of_cell), to_bytes(symmetry), to_bytes(area), piece.to_bytes()].concat()
    }

    fn from_bytes(bytes: &[u8]) -> Share {
        let [materials, fixes, loads] = <[u64; 3]>::read(bytes).map(|n| n as usize);
        let (sizes, center, radius) = (Wire::read(&bytes[24..]), Wire::read(&bytes[40..]), f64::read(&bytes[64..]));
        let (material_of_cell, rest) = bytes[72..].split_at(4 * materials);
        let (symmetry, rest) = rest.split_at(4 * fixes);
        let (area, rest) = rest.split_at(8 * loads);
        let (material_of_cell, symmetry) = (from_bytes(material_of_cell), from_bytes(symmetry));
        let (area, piece) = (from_bytes(area), MeshPiece::from_bytes(rest));
        Share { piece, material_of_cell, symmetry, area, center, radius, sizes }
    }
}
