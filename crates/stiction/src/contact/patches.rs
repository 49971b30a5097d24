//! Which faces of a slave surface, and which parts of the other one, count for a node.
//!
//! A node has one multiplier along one normal. At a sharp edge of the slave surface it is that of the side that meets more of the
//! other surface; where that one ends and another part of it lies behind, it is that of the nearer part. In a face that is
//! left out its neighbours carry for the node, as for any node without a multiplier.

use std::collections::{BTreeMap, HashSet};

use super::flat::area;
use super::mortar::{Met, Segment};
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, dot, unit};

/// Faces around a node are one smooth surface if the normal of each has a larger cosine with that of all: a coarse cylinder of
/// ten sides is smooth, an edge that bends by 74 degrees is not.
const SMOOTH: f64 = 0.8;
/// Distances that differ by less than this part of the size of a face are the same.
const SAME_DISTANCE: f64 = 1e-6;
/// What covers less of a face is not what the face lies on.
const LEAST_PART: f64 = 0.02;

/// The faces that do not count for a node: pairs of both.
#[derive(Debug, Default)]
pub(super) struct Patches {
    /// On another side of a sharp edge.
    averse: HashSet<(u32, u32)>,
    /// On a farther part of the other surface.
    behind: HashSet<(u32, u32)>,
}

impl Patches {
    /// Of the faces `slave` that have `met` others. Ties hold in all directions: for them faces that meet something always
    /// count.
    pub(super) fn new(mesh: &Mesh, slave: &[u32], met: &[Met], tied: bool) -> Patches {
        let mut around: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (i, &face) in slave.iter().enumerate() {
            mesh.faces[face as usize].nodes().iter().for_each(|&node| around.entry(node).or_default().push(i));
        }
        let mut patches = Patches::default();
        for (&node, faces) in &around {
            let averse = averse(mesh, slave, met, faces);
            let averse = averse.into_iter().filter(|&i| !tied || met[i].covered == 0.0);
            patches.averse.extend(averse.map(|i| (node, slave[i])));
        }
        // A strip of single faces between two edges would carry nothing: its nodes keep the mean of the sides.
        for (&face, _) in slave.iter().zip(met).filter(|(_, met)| met.covered > 0.0) {
            let nodes = mesh.faces[face as usize].nodes();
            if nodes.iter().all(|&node| !patches.shapes(face, node)) {
                patches.averse.retain(|(node, _)| !nodes.contains(node));
            }
        }
        if !tied {
            for (&node, faces) in &around {
                let behind = behind(&patches, node, slave, met, faces);
                patches.behind.extend(behind.into_iter().map(|i| (node, slave[i])));
            }
        }
        patches
    }

    /// Whether a face has a part in the normal of a node of it.
    pub(super) fn shapes(&self, face: u32, node: u32) -> bool {
        !self.averse.contains(&(node, face))
    }

    /// Whether a node carries its own part of a face.
    pub(super) fn carries(&self, face: u32, node: u32) -> bool {
        self.shapes(face, node) && !self.behind.contains(&(node, face))
    }
}

/// The faces around a node that do not belong to its normal: none unless they have a sharp edge there.
fn averse(mesh: &Mesh, slave: &[u32], met: &[Met], around: &[usize]) -> Vec<usize> {
    let normal = |i: usize| mesh.face_normal(slave[i] as usize);
    let sum = around.iter().fold([0.0; 3], |sum: V3, &i| add(sum, mesh.face_vector_area(slave[i] as usize)));
    if unit(sum).is_some_and(|mean| around.iter().all(|&i| dot(normal(i), mean) >= SMOOTH)) {
        return Vec::new();
    }
    let meets = |side: usize| -> f64 {
        around.iter().filter(|&&i| dot(normal(i), normal(side)) >= SMOOTH).map(|&i| met[i].covered).sum()
    };
    let mut best: Option<(usize, f64)> = None;
    for &i in around.iter().filter(|&&i| met[i].covered > 0.0) {
        let covered = meets(i);
        // Of sides that meet as much the first, whatever the rounding.
        if best.is_none_or(|(_, most)| covered > (1.0 + SAME_DISTANCE) * most) {
            best = Some((i, covered));
        }
    }
    let Some((side, _)) = best else { return Vec::new() };
    around.iter().copied().filter(|&i| dot(normal(i), normal(side)) < SMOOTH).collect()
}

/// The faces around a node that meet another part of the other surface than the nearest of them, and farther away.
fn behind(patches: &Patches, node: u32, slave: &[u32], met: &[Met], around: &[usize]) -> Vec<usize> {
    let meets: Vec<usize> =
        around.iter().copied().filter(|&i| met[i].covered > 0.0 && patches.shapes(slave[i], node)).collect();
    let distances: Vec<f64> = meets.iter().map(|&i| met[i].distance).collect();
    let size = meets.iter().fold(0.0, |size: f64, &i| size.max(met[i].flat.abs().sqrt()));
    let nodes: Vec<Vec<u32>> = meets.iter().map(|&i| met[i].masters.iter().map(|entry| entry.0).collect()).collect();
    farther(&distances, size, &nodes).into_iter().map(|k| meets[k]).collect()
}

/// Of parts, each at a distance and with nodes of the other surface, those that hang together with the nearest by no common
/// nodes and are farther away.
fn farther(distances: &[f64], size: f64, nodes: &[Vec<u32>]) -> Vec<usize> {
    let Some(nearest) = (0..distances.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b])) else {
        return Vec::new();
    };
    let mut away: Vec<usize> =
        (0..distances.len()).filter(|&k| distances[k] > distances[nearest] + SAME_DISTANCE * size).collect();
    let mut reached: HashSet<u32> =
        (0..distances.len()).filter(|k| !away.contains(k)).flat_map(|k| nodes[k].iter().copied()).collect();
    while let Some(place) = away.iter().position(|&k| nodes[k].iter().any(|node| reached.contains(node))) {
        reached.extend(&nodes[away.swap_remove(place)]);
    }
    away
}

/// Leaves of the segments of a face those on what it lies on: where the other surface ends under the face and another part of it
/// lies behind, the dual functions, negative in places, would make an overlap of two distances.
pub(super) fn keep_nearest_part(mesh: &Mesh, segments: &mut Vec<Segment>, whole: f64) {
    let mut parts: Vec<(HashSet<u32>, Vec<usize>)> = Vec::new();
    for (k, segment) in segments.iter().enumerate() {
        let nodes = mesh.faces[segment.face as usize].nodes();
        let (joined, apart): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|(known, _)| nodes.iter().any(|node| known.contains(node)));
        let mut part = (nodes.iter().copied().collect::<HashSet<u32>>(), vec![k]);
        for (known, members) in joined {
            part.0.extend(known);
            part.1.extend(members);
        }
        parts = apart;
        parts.push(part);
    }
    if parts.len() < 2 {
        return;
    }
    let sum = |members: &[usize], of: &dyn Fn(&Segment) -> f64| -> f64 {
        let mut members = members.to_vec();
        members.sort_unstable();
        members.iter().map(|&k| of(&segments[k])).sum()
    };
    let covers = |members: &[usize]| sum(members, &|segment| area(&segment.polygon).abs());
    let distance = |members: &[usize]| {
        sum(members, &|segment| area(&segment.polygon).abs() * segment.distance.abs()) / covers(members)
    };
    let enough: Vec<usize> = (0..parts.len()).filter(|&p| covers(&parts[p].1) >= LEAST_PART * whole.abs()).collect();
    let Some(nearest) = enough.into_iter().map(|p| distance(&parts[p].1)).min_by(|a, b| a.total_cmp(b)) else {
        return;
    };
    let stays = |members: &[usize]| distance(members) <= nearest + SAME_DISTANCE * whole.abs().sqrt();
    let mut kept = vec![false; segments.len()];
    for (_, members) in parts.iter().filter(|(_, members)| stays(members)) {
        members.iter().for_each(|&k| kept[k] = true);
    }
    let mut kept = kept.into_iter();
    segments.retain(|_| kept.next() == Some(true));
}
