//! From surfaces to contact points and the rows of `B`; for those who assemble elsewhere without a stiffness.

use std::collections::{HashMap, HashSet};

use super::claims::{Shares, places};
use super::followers::merge;
use super::node_to_surface::points_of_nodes;
use super::pair::{Matched, points_of_pair};
use super::points::{Point, points_on_obstacle};
use super::{ContactSurface, Counterpart, SurfaceFacts, SurfaceFriction};
use crate::Error;
use crate::fem::DofMap;
use crate::linalg::Csr;
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, dot};

/// Contact of surfaces as rows over all displacements of a mesh, prescribed ones included; `m` points.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactRows {
    /// Jump operator, `3m x 3 nodes`: normal rows, then first, then second tangential ones.
    pub B: Csr,
    /// Initial gap along the normal, length, `m`.
    pub gap: Vec<f64>,
    /// The area each point stands for, `m`, length squared.
    pub area: Vec<f64>,
    /// See [`Labels::unity_sum`](super::Labels::unity_sum), `m`.
    pub unity_sum: Vec<f64>,
    /// The node of each point, `m`.
    pub node: Vec<u32>,
    /// Its unit normal, towards the counterpart, and its tangents, `m`; a tangent in which the point cannot move is zero.
    pub axes: Vec<[V3; 3]>,
}

/// The rows that [`pose`](super::pose()) takes. Of `mesh` nodes and faces are read, no cells.
///
/// # Errors
/// As of [`pose`](super::pose()).
pub fn contact_rows(
    mesh: &Mesh,
    dofs: &DofMap,
    surfaces: &[ContactSurface],
) -> Result<(ContactRows, Vec<SurfaceFacts>), Error> {
    let (points, facts) = all_points(mesh, dofs, surfaces)?;
    let (free, prescribed) = jump(dofs, &points);
    let mut entries: Vec<(usize, usize, f64)> = Vec::with_capacity(free.value.len() + prescribed.value.len());
    for (part, places) in [(&free, &dofs.free), (&prescribed, &dofs.prescribed)] {
        entries.extend(part.entries().map(|(i, j, v)| (i, places[j] as usize, v)));
    }
    let rows = ContactRows {
        B: Csr::from_triplets(3 * points.len(), 3 * mesh.nodes.len(), &entries),
        gap: points.iter().map(|point| point.gap).collect(),
        area: points.iter().map(|point| point.area).collect(),
        unity_sum: points.iter().map(|point| point.unity_sum).collect(),
        node: points.iter().map(|point| point.node).collect(),
        axes: points.iter().map(|point| [point.normal, point.frame[1], point.frame[2]]).collect(),
    };
    Ok((rows, facts))
}

/// The points of all surfaces, in their order.
///
/// A node carries the points of one surface only where pairs are concerned: see [`claims`](super::claims). Bonded surfaces get
/// their points first, then those that may touch an obstacle, then pairs. Nodes that several obstacles have in common
/// stay with each.
pub(super) fn all_points(
    mesh: &Mesh,
    dofs: &DofMap,
    surfaces: &[ContactSurface],
) -> Result<(Vec<Point>, Vec<SurfaceFacts>), Error> {
    let bonded = |s: &ContactSurface| s.friction == SurfaceFriction::Bonded;
    let mut order: Vec<usize> = (0..surfaces.len()).collect();
    let places = places(mesh, surfaces);
    order.sort_by_key(|&i| (!bonded(&surfaces[i]), matches!(surfaces[i].against, Counterpart::Surface(_)), places[i]));
    let Shares { lost, mut matched, .. } = Shares::new(mesh, dofs, surfaces);
    let (mut tied, mut taken) = (HashSet::new(), HashSet::new());
    let mut found: HashMap<usize, (Vec<Point>, SurfaceFacts)> = HashMap::new();
    for number in order {
        let (surface, lost) = (&surfaces[number], &lost[number]);
        let at_surface = |e: Error| e.at(&quoted(&surface.name));
        let found_here = match &surface.against {
            Counterpart::Obstacle(obstacle) => points_on_obstacle(mesh, dofs, surface, obstacle, (lost, &tied)),
            Counterpart::Surface(master) => match &master.nodes {
                Some(nodes) => points_of_nodes(mesh, dofs, surface, master, nodes, (lost, &taken)),
                None => matched
                    .remove(&number)
                    .map_or_else(|| Matched::new(mesh, dofs, surface, master), Ok)
                    .and_then(|matched| points_of_pair(&matched, dofs, lost, &taken)),
            },
        };
        let (mut points, mut facts) = found_here.map_err(at_surface)?;
        merge(mesh, surface, &dofs.follows, &mut points, &mut facts).map_err(at_surface)?;
        // A node that points hang on carries none of another surface: both sides would be held to one another twice.
        for point in &points {
            taken.insert(point.node);
            taken.extend(point.others.iter().map(|other| other.0));
            taken.extend(point.across.iter().map(|other| other.0));
        }
        if bonded(surface) {
            tied.extend(&facts.nodes);
            // Nodes an obstacle holds in every direction have no point and are tied all the same.
            tied.extend(mesh.face_nodes(&surface.faces).iter().filter(|_| facts.pair.is_none()));
        }
        found.insert(number, (points, facts));
    }
    let (points, facts): (Vec<_>, Vec<_>) = (0..surfaces.len()).filter_map(|i| found.remove(&i)).unzip();
    Ok((points.into_iter().flatten().collect(), facts))
}

fn quoted(name: &str) -> String {
    format!("contact \"{name}\"")
}

/// `B` over the unknown and over the prescribed degrees of freedom.
pub(super) fn jump(dofs: &DofMap, points: &[Point]) -> (Csr, Csr) {
    let m = points.len();
    let (mut free, mut constrained) = (Vec::new(), Vec::new());
    let mut add = |row: usize, dof: u32, value: f64| {
        let unknown = dofs.unknown[dof as usize];
        if value == 0.0 {
        } else if unknown != u32::MAX {
            free.push((row, unknown as usize, value));
        } else if let Ok(p) = dofs.prescribed.binary_search(&dof) {
            constrained.push((row, p, value));
        }
    };
    for (j, point) in points.iter().enumerate() {
        let [normal, first, second] = point.frame;
        // Where the node cannot move along the normal there is no normal row, not for the other nodes either.
        let whole = [if normal == [0.0; 3] { normal } else { point.normal }, first, second];
        for (k, (row, &full)) in point.frame.iter().zip(&whole).enumerate() {
            let along = |node: u32, v: [f64; 3]| dofs.components(node, v);
            let [row, own] = [along(point.node, *row), along(point.node, full)];
            for c in 0..3 {
                let dof = 3 * point.node + c as u32;
                let is_free = |dof: u32| dofs.unknown[dof as usize] != u32::MAX;
                let at_layer = point.layer.map_or(dof, |layer| 3 * layer + c as u32);
                match () {
                    () if is_free(dof) => add(k * m + j, at_layer, row[c]),
                    // The layer slides before a node that is held.
                    () if is_free(at_layer) => add(k * m + j, at_layer, own[c]),
                    () => add(k * m + j, dof, own[c]),
                }
            }
            for &(other, weight) in &point.others {
                let full = along(other, full);
                (0..3).for_each(|c| add(k * m + j, 3 * other + c as u32, weight * full[c]));
            }
            for (other, weight, axes) in &point.across {
                let full = along(*other, axes.map(|axis| dot(axis, full)));
                (0..3).for_each(|c| add(k * m + j, 3 * other + c as u32, weight * full[c]));
            }
        }
    }
    let n = dofs.free.len();
    (Csr::from_triplets(3 * m, n, &free), Csr::from_triplets(3 * m, dofs.prescribed.len(), &constrained))
}
