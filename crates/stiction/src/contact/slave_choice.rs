//! Which of two surfaces is the slave, that is, carries the contact points.
//!
//! A slave node that cannot carry a multiplier leaves its function to its neighbours. Over faces that are prescribed
//! altogether there is no such neighbour, so there the other surface becomes the slave of a pair of its own.

use serde::{Deserialize, Serialize};

use super::held::held_along;
use super::mortar::{Search, meet};
use super::pair::default_search;
use super::{ContactSurface, Counterpart, InitialGap, Master, SurfaceFriction};
use crate::fem::DofMap;
use crate::mesh::Mesh;

/// One of the two surfaces of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Role {
    /// The surface named in `on`.
    #[default]
    On,
    /// The surface named in `against`.
    Against,
}

/// Why a surface carries the contact points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reason {
    /// The case says so.
    Asked,
    /// Its friction is given by an array of the mesh on it.
    Array,
    /// It is made of nodes without faces.
    Nodes,
    /// Most nodes of the other surface are prescribed.
    Free,
    /// Supports hold nodes of the other surface along it while this one moves there.
    Unheld,
    /// Nodes of the other surface are wanted by another contact.
    Unshared,
    /// Its faces are smaller.
    Finer,
    /// Its body is softer.
    Softer,
    /// Neither differs; it was named first.
    #[default]
    First,
}

/// Sizes of faces whose ratio is below this are alike.
const ALIKE: f64 = 1.25;
/// Elastic moduli whose ratio is below this are alike.
const AS_STIFF: f64 = 1.01;
/// Beyond this ratio of the moduli the stiffer body is nearly a rigid obstacle, whose nodes follow no other: as slaves they
/// made multigrid slow from a ratio of 10 and fail from 100 on, while the softer slave takes as long at every ratio.
const NEARLY_RIGID: f64 = 5.0;

/// Which of two surfaces carries the contact points, the slave: one that is free to move rather than one whose nodes are
/// mostly prescribed; then that of a much softer body, to which the other is a rigid obstacle; then the one none of whose
/// nodes is held in a direction in which the other body moves, as a point of multigrid has to; then the one with the
/// smaller faces, whose nodes could otherwise sink in between those of the other; then that of the softer body, which
/// adapts to the other; then the first. `young` are the moduli behind the surface and behind its counterpart.
pub fn choose_slave(mesh: &Mesh, dofs: &DofMap, surface: &ContactSurface, young: [f64; 2]) -> (Role, Reason) {
    let Counterpart::Surface(master) = &surface.against else { return (Role::On, Reason::First) };
    let faces = [&surface.faces[..], &master.faces];
    let constrained = faces.map(|faces| mostly_constrained(mesh, dofs, faces));
    if constrained[0] != constrained[1] {
        return (if constrained[0] { Role::Against } else { Role::On }, Reason::Free);
    }
    let smaller = |a: f64, b: f64, alike: f64| match () {
        () if ROUNDED * alike * a < b => Some(Role::On),
        () if ROUNDED * alike * b < a => Some(Role::Against),
        () => None,
    };
    if let Some(softer) = smaller(young[0], young[1], NEARLY_RIGID) {
        return (softer, Reason::Softer);
    }
    let [a, b] = faces.map(|faces| face_size(mesh, faces));
    let search = master.search.unwrap_or_else(|| default_search(mesh, faces[0], faces[1]));
    let held = [([faces[0], faces[1]], a), ([faces[1], faces[0]], b)]
        .map(|(faces, size)| held_along(mesh, dofs, faces, (search, size), &surface.friction));
    if held[0] != held[1] {
        return (if held[0] > held[1] { Role::Against } else { Role::On }, Reason::Unheld);
    }
    if let Some(finer) = smaller(a, b, ALIKE) {
        return (finer, Reason::Finer);
    }
    match smaller(young[0], young[1], AS_STIFF) {
        Some(softer) => (softer, Reason::Softer),
        None => (Role::On, Reason::First),
    }
}

/// Sizes whose ratio is a limit but for rounding are alike in every place and unit.
const ROUNDED: f64 = 1.0 + 1e-9;

/// The ratio of moduli up to which points may lie on the stiffer body: multigrid refuses them from a hundred on.
const MUCH_STIFFER: f64 = 30.0;
/// The ratio of the sizes of faces up to which points may lie on the coarser surface. With two, of twelve pairs of feet less than a cell
/// apart four are said to tip over, with four none.
const MUCH_COARSER: f64 = 4.0;

/// Whether the other surface of a pair could carry the points just as well, but for the size of its faces and the stiffness of its body;
/// `young` are the moduli behind the surface with the points and behind the other one.
pub(crate) fn may_change_sides(mesh: &Mesh, dofs: &DofMap, surface: &ContactSurface, young: [f64; 2]) -> bool {
    let Counterpart::Surface(master) = &surface.against else { return false };
    if ![Reason::Finer, Reason::Softer, Reason::First].contains(&master.reason)
        || matches!(master.gap, InitialGap::ClosedAt(_))
        || young[1] > MUCH_STIFFER * young[0]
    {
        return false;
    }
    let [own, other] = [&surface.faces[..], &master.faces].map(|faces| (faces, face_size(mesh, faces)));
    let search = master.search.unwrap_or_else(|| default_search(mesh, own.0, other.0));
    let held = |faces, size| held_along(mesh, dofs, faces, (search, size), &surface.friction);
    other.1 <= MUCH_COARSER * own.1 && held([other.0, own.0], other.1) <= held([own.0, other.0], own.1)
}

/// Root of the mean area of the faces; length.
pub(crate) fn face_size(mesh: &Mesh, faces: &[u32]) -> f64 {
    let area: f64 = faces.iter().map(|&face| mesh.face_area(face as usize)).sum();
    (area / faces.len().max(1) as f64).sqrt()
}

/// Where faces of the slave are prescribed altogether and what they meet is not, the other surface is the slave.
///
/// A prescribed node carries no multiplier. Its neighbours carry for it where there are free ones; over whole prescribed
/// faces nothing would keep the other body out, and multipliers there would be more than the other body has nodes to
/// tell them apart. Takes such faces out of `surface`, and returns the pair with the other role; if they are all the faces,
/// `surface` itself changes its roles.
pub fn reverse_where_constrained(mesh: &Mesh, dofs: &DofMap, surface: &mut ContactSurface) -> Option<ContactSurface> {
    let Counterpart::Surface(master) = &mut surface.against else { return None };
    if master.nodes.is_some() {
        return None;
    }
    let all_constrained = |face: &u32| mesh.faces[*face as usize].nodes().iter().all(|&node| constrained(dofs, node));
    let (fixed, free): (Vec<u32>, Vec<u32>) = surface.faces.iter().partition(|&face| all_constrained(face));
    if fixed.is_empty() {
        return None;
    }
    let search = master.search.unwrap_or_else(|| default_search(mesh, &surface.faces, &master.faces));
    let met = meet(
        mesh,
        &master.faces,
        &fixed,
        Search { length: search, averted: surface.friction == SurfaceFriction::Bonded },
    );
    let faces = master.faces.iter().zip(&met).filter(|(_, met)| met.covered > 0.0).map(|(&face, _)| face);
    let faces: Vec<u32> = faces.collect();
    if faces.iter().all(all_constrained) {
        return None;
    }
    let slave = if master.slave == Role::On { Role::Against } else { Role::On };
    let (search, reason) = (Some(search), Reason::Free);
    if free.is_empty() {
        std::mem::swap(&mut surface.faces, &mut master.faces);
        (master.slave, master.reason, master.search) = (slave, reason, search);
        return None;
    }
    let other = Master { faces: fixed, gap: master.gap.clone(), search, slave, reason, nodes: None };
    (surface.faces, master.search) = (free, search);
    let (name, friction) = (format!("{}-constrained", surface.name), surface.friction.clone());
    let (against, stiffness) = (Counterpart::Surface(other), surface.stiffness);
    Some(ContactSurface { name, faces, against, friction, stiffness, periods: surface.periods.clone() })
}

/// Whether more than half of the nodes are prescribed altogether.
fn mostly_constrained(mesh: &Mesh, dofs: &DofMap, faces: &[u32]) -> bool {
    let nodes = mesh.face_nodes(faces);
    2 * nodes.iter().filter(|&&node| constrained(dofs, node)).count() > nodes.len()
}

/// Whether all components of a node are prescribed.
fn constrained(dofs: &DofMap, node: u32) -> bool {
    (0..3).all(|c| dofs.unknown[(3 * node + c) as usize] == u32::MAX)
}
