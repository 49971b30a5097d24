//! From surfaces to contact points and the rows of `B`; for those who assemble elsewhere without a stiffness.

use rustc_hash::{FxHashMap, FxHashSet};

use super::chains::Chains;
use super::claims::{Claims, Lost, SIDE, Shares};
use super::followers::merge;
use super::meeting::AllMet;
use super::node_to_surface::points_of_nodes;
use super::pair::points_of_pair;
use super::points::{Point, faces_that_look, points_on_obstacle};
use super::spans::{Span, Version, spans, united};
use super::{ContactSurface, Counterpart, Master, SurfaceFacts, SurfaceFriction};
use crate::Error;
use crate::fem::DofMap;
use crate::linalg::Csr;
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, dot, norm};

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
    let (points, facts) = all_points(mesh, dofs, surfaces, AllMet::default())?;
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
/// At any time a node carries the points of one surface only where pairs are concerned: see [`claims`](super::claims). Bonded surfaces
/// get their points first, then those that may touch an obstacle, then pairs. Nodes that several obstacles have in common
/// stay with each. What faces meet is found unless it is `known`.
pub(super) fn all_points(
    mesh: &Mesh,
    dofs: &DofMap,
    surfaces: &[ContactSurface],
    known: AllMet,
) -> Result<(Vec<Point>, Vec<SurfaceFacts>), Error> {
    let bonded = |s: &ContactSurface| s.friction == SurfaceFriction::Bonded;
    let mut order: Vec<usize> = (0..surfaces.len()).collect();
    let mut claims = Claims::new(mesh, dofs, surfaces, known);
    order.sort_by_key(|&i| {
        (!bonded(&surfaces[i]), matches!(surfaces[i].against, Counterpart::Surface(_)), claims.places[i])
    });
    let mut spans = spans(surfaces);
    // What never holds has points all the same, which are always out.
    let never = (0..surfaces.len()).filter(|number| spans.iter().all(|span| !span.surfaces.contains(number)));
    let never: Vec<Span> = never.map(|number| Span { times: Vec::new(), surfaces: vec![number] }).collect();
    spans.extend(never);
    let last_of = |number: usize| spans.iter().rposition(|span| span.surfaces.contains(&number));
    let mut made: Vec<Vec<(Version, Excluded)>> = surfaces.iter().map(|_| Vec::new()).collect();
    for (place, span) in spans.iter().enumerate() {
        let Shares { lost, .. } = claims.shares(&span.surfaces);
        let (mut tied, mut chains) = (FxHashSet::default(), Chains::default());
        for &number in order.iter().filter(|number| span.surfaces.contains(number)) {
            let (surface, lost) = (&surfaces[number], &lost[number]);
            let taken = taken(mesh, surface, &chains);
            let known = if spans.len() == 1 { Excluded::new() } else { excluded(mesh, surface, lost, [&tied, &taken]) };
            let same = made[number]
                .iter()
                .position(|(version, excluded)| *excluded == known && chains.closed_by(&version.points).is_empty());
            let at = match same {
                Some(at) => at,
                None => {
                    let found = points_of(&mut claims, (mesh, dofs), (surfaces, number), (lost, &tied, taken), &chains);
                    let (points, facts) = found.map_err(|e| e.at(&quoted(&surface.name)))?;
                    made[number].push((Version { points, facts, times: Vec::new() }, known));
                    made[number].len() - 1
                }
            };
            let Version { points, facts, times } = &mut made[number][at].0;
            times.extend(&span.times);
            chains.add(points);
            if bonded(surface) {
                tied.extend(&facts.nodes);
                // Nodes an obstacle holds in every direction have no point and are tied all the same.
                if let Counterpart::Obstacle(obstacle) = &surface.against {
                    let looking = faces_that_look(mesh, &surface.faces, obstacle);
                    tied.extend(mesh.face_nodes(looking.as_ref().unwrap_or(&surface.faces)));
                }
            }
            if last_of(number) == Some(place) {
                claims.forget(number);
            }
        }
    }
    let versions = made.into_iter().map(|made| made.into_iter().map(|(version, _)| version).collect());
    let (points, facts): (Vec<_>, Vec<_>) = versions.filter_map(united).unzip();
    Ok((points.into_iter().flatten().collect(), facts))
}

/// The nodes of a surface that others have, ascending, and how it has lost them.
type Excluded = Vec<(u32, Option<Lost>, [bool; 2])>;

fn excluded(
    mesh: &Mesh,
    surface: &ContactSurface,
    lost: &FxHashMap<u32, Lost>,
    sets: [&FxHashSet<u32>; 2],
) -> Excluded {
    let of_node = |node: u32| (node, lost.get(&node).copied(), sets.map(|set| set.contains(&node)));
    named(mesh, surface)
        .into_iter()
        .map(of_node)
        .filter(|(_, lost, sets)| lost.is_some() || sets.contains(&true))
        .collect()
}

/// The points of one surface, which has `lost` nodes to others, where others are `tied` or `taken`. Nodes of a pair from which a chain of
/// points leads [back](Chains::closed_by) to them get none.
fn points_of<'a>(
    claims: &mut Claims<'a>,
    (mesh, dofs): (&Mesh, &DofMap),
    (surfaces, number): (&'a [ContactSurface], usize),
    (lost, tied, mut taken): (&FxHashMap<u32, Lost>, &FxHashSet<u32>, FxHashSet<u32>),
    chains: &Chains,
) -> Result<(Vec<Point>, SurfaceFacts), Error> {
    let surface = &surfaces[number];
    loop {
        let (mut points, mut facts) = match &surface.against {
            Counterpart::Obstacle(obstacle) => points_on_obstacle(mesh, dofs, surface, obstacle, (lost, tied))?,
            Counterpart::Surface(master) => match &master.nodes {
                Some(nodes) => points_of_nodes(mesh, dofs, surface, master, nodes, (lost, &taken))?,
                None => points_of_pair(claims.matched(number, master)?, dofs, lost, &taken)?,
            },
        };
        merge(mesh, surface, &dofs.follows, &mut points, &mut facts)?;
        let closed = match &surface.against {
            Counterpart::Obstacle(_) => Vec::new(),
            Counterpart::Surface(_) => chains.closed_by(&points),
        };
        if closed.is_empty() {
            return Ok((points, facts));
        }
        taken.extend(closed);
    }
}

/// The nodes of a pair that may have no point, because they are [`taken`](Chains::is_taken) by earlier ones.
fn taken(mesh: &Mesh, surface: &ContactSurface, chains: &Chains) -> FxHashSet<u32> {
    let Counterpart::Surface(master) = &surface.against else { return FxHashSet::default() };
    if chains.is_empty() {
        return FxHashSet::default();
    }
    let opposite = around(mesh, &master.faces);
    named(mesh, surface).into_iter().filter(|&node| chains.is_taken(node, &opposite)).collect()
}

/// The nodes of a surface and of the faces that go on from it without a sharp edge.
fn around(mesh: &Mesh, faces: &[u32]) -> FxHashSet<u32> {
    let mut normals: FxHashMap<u32, V3> = FxHashMap::default();
    for &face in faces {
        let normal = mesh.face_normal(face as usize);
        for &node in mesh.faces[face as usize].nodes() {
            let sum = normals.entry(node).or_default();
            *sum = add(*sum, normal);
        }
    }
    let goes_on = |face: usize| {
        let along = |sum: &V3| {
            let normal = mesh.face_normal(face);
            dot(normal, *sum) > SIDE * norm(normal) * norm(*sum)
        };
        mesh.faces[face].nodes().iter().any(|node| normals.get(node).is_some_and(along))
    };
    let beside = (0..mesh.faces.len()).filter(|&face| goes_on(face)).flat_map(|face| mesh.faces[face].nodes());
    normals.keys().chain(beside).copied().collect()
}

/// The nodes of a surface that may have points.
fn named(mesh: &Mesh, surface: &ContactSurface) -> Vec<u32> {
    match &surface.against {
        Counterpart::Surface(Master { nodes: Some(nodes), .. }) => nodes.clone(),
        _ => mesh.face_nodes(&surface.faces),
    }
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
            for (other, weight, axes) in &point.beyond_cut {
                let full = along(*other, axes.map(|axis| dot(axis, full)));
                (0..3).for_each(|c| add(k * m + j, 3 * other + c as u32, weight * full[c]));
            }
        }
    }
    let n = dofs.free.len();
    (Csr::from_triplets(3 * m, n, &free), Csr::from_triplets(3 * m, dofs.prescribed.len(), &constrained))
}
