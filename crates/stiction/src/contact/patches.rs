//! Which faces of a slave surface, and which parts of the other one, count for a node.
//!
//! A node has one multiplier along one normal. At a sharp edge of the slave surface it is that of the side that meets more of the
//! other surface; where that one ends and another part of it lies behind or beyond a step, it is that of the nearer part. In a face that
//! is left out its neighbours carry for the node, as for any node without a multiplier.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::{FxHashMap, FxHashSet};

use super::flat::area;
use super::levels::Level;
use super::mortar::{Met, Segment};
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, dot, unit};

/// Faces around a node are one smooth surface if the normal of each has a larger cosine with that of all (an edge may bend by
/// 74 degrees), and next to one another if theirs have.
const SMOOTH: f64 = 0.8;
/// Of two parts that do not hang together the one that is farther by more than this part of a face's size lies behind.
const BEHIND: f64 = 0.05;
/// What covers less of a face is not what the face lies on.
const LEAST_PART: f64 = 0.02;

/// The faces that do not count for a node: pairs of both.
#[derive(Debug, Default)]
pub(super) struct Patches {
    /// The smooth side of the surface that each face is of.
    side: FxHashMap<u32, u32>,
    /// On another side of a sharp edge.
    across_edge: FxHashSet<(u32, u32)>,
    /// On a farther part of the other surface.
    behind: FxHashSet<(u32, u32)>,
}

impl Patches {
    /// Of the faces `slave` that have `met` others. Ties hold in all directions: for them faces that meet something always
    /// count.
    pub(super) fn new(mesh: &Mesh, slave: &[u32], met: &[Met], tied: bool) -> Patches {
        let mut around: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (i, &face) in slave.iter().enumerate() {
            mesh.faces[face as usize].nodes().iter().for_each(|&node| around.entry(node).or_default().push(i));
        }
        let sides = sides(mesh, slave);
        let mut meets = vec![0.0; slave.len()];
        sides.iter().zip(met).for_each(|(&side, met)| meets[side] += met.covered);
        let mut patches = Patches {
            side: slave.iter().zip(&sides).map(|(&face, &side)| (face, side as u32)).collect(),
            ..Patches::default()
        };
        for (&node, faces) in &around {
            let left_out = across_edge(mesh, slave, met, faces, (&sides, &meets));
            let left_out = left_out.into_iter().filter(|&i| !tied || met[i].covered == 0.0);
            patches.across_edge.extend(left_out.map(|i| (node, slave[i])));
        }
        // A strip of single faces between two edges would carry nothing: its nodes keep the mean of the sides.
        let strips: FxHashSet<u32> = (slave.iter().zip(met))
            .filter(|(_, met)| met.covered > 0.0)
            .map(|(&face, _)| (face, mesh.faces[face as usize].nodes()))
            .filter(|(face, nodes)| nodes.iter().all(|&node| !patches.shapes(*face, node)))
            .flat_map(|(_, nodes)| nodes.iter().copied())
            .collect();
        patches.across_edge.retain(|(node, _)| !strips.contains(node));
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
        !self.across_edge.contains(&(node, face))
    }

    /// Whether a node carries its own part of a face.
    pub(super) fn carries(&self, face: u32, node: u32) -> bool {
        self.shapes(face, node) && !self.behind.contains(&(node, face))
    }

    /// The smooth side of the surface that a face is of.
    pub(super) fn side(&self, face: u32) -> u32 {
        self.side[&face]
    }
}

/// For each face the first of the smooth side it is of: sides end at sharp edges, so that all nodes of an edge choose alike.
fn sides(mesh: &Mesh, slave: &[u32]) -> Vec<usize> {
    let mut of_edge: FxHashMap<[u32; 2], Vec<usize>> = FxHashMap::default();
    for (i, &face) in slave.iter().enumerate() {
        let corners = mesh.faces[face as usize].corners();
        for (k, &corner) in corners.iter().enumerate() {
            let next = corners[(k + 1) % corners.len()];
            of_edge.entry([corner.min(next), corner.max(next)]).or_default().push(i);
        }
    }
    let mut side: Vec<usize> = vec![usize::MAX; slave.len()];
    for first in 0..slave.len() {
        if side[first] != usize::MAX {
            continue;
        }
        let mut open = vec![first];
        side[first] = first;
        while let Some(i) = open.pop() {
            let corners = mesh.faces[slave[i] as usize].corners();
            let normal = mesh.face_normal(slave[i] as usize);
            for (k, &corner) in corners.iter().enumerate() {
                let next = corners[(k + 1) % corners.len()];
                for &other in &of_edge[&[corner.min(next), corner.max(next)]] {
                    if side[other] == usize::MAX && dot(mesh.face_normal(slave[other] as usize), normal) >= SMOOTH {
                        side[other] = first;
                        open.push(other);
                    }
                }
            }
        }
    }
    side
}

/// The faces around a node that do not belong to its normal: none unless they have a sharp edge there. `meets` has the area that
/// each of the `sides` meets.
fn across_edge(
    mesh: &Mesh,
    slave: &[u32],
    met: &[Met],
    around: &[usize],
    (sides, meets): (&[usize], &[f64]),
) -> Vec<usize> {
    let normal = |i: usize| mesh.face_normal(slave[i] as usize);
    let mean = |of: &dyn Fn(usize) -> bool| {
        let of = around.iter().filter(|&&i| of(i));
        unit(of.fold([0.0; 3], |sum: V3, &i| add(sum, mesh.face_vector_area(slave[i] as usize))))
    };
    if mean(&|_| true).is_some_and(|mean| around.iter().all(|&i| dot(normal(i), mean) >= SMOOTH)) {
        return Vec::new();
    }
    let candidates: BTreeSet<usize> = around.iter().filter(|&&i| met[i].covered > 0.0).map(|&i| sides[i]).collect();
    let Some(best) = candidates.iter().copied().reduce(|a, b| if meets[b] > meets[a] { b } else { a }) else {
        return Vec::new();
    };
    // How squarely a normal looks at what the faces meet.
    let looks = |normal: V3, of: &dyn Fn(usize) -> bool| {
        let of: Vec<usize> = around.iter().copied().filter(|&i| met[i].covered > 0.0 && of(i)).collect();
        let covered: f64 = of.iter().map(|&i| met[i].covered).sum();
        -of.iter().map(|&i| dot(normal, met[i].normals)).sum::<f64>() / covered
    };
    let is_best = |i: usize| sides[i] == best;
    let Some(own) = mean(&is_best) else { return Vec::new() };
    // A ridge or tip that is pressed on one flat part looks at it with the mean of its flanks.
    let all_met = mean(&|i| met[i].covered > 0.0);
    let of_all = all_met.filter(|&all| looks(all, &|_| true) > looks(own, &is_best));
    let chosen = of_all.unwrap_or(own);
    let left_out = |i: usize| match of_all {
        Some(_) => met[i].covered == 0.0 && dot(normal(i), chosen) < SMOOTH,
        None => !is_best(i) && dot(normal(i), chosen) < SMOOTH,
    };
    around.iter().copied().filter(|&i| left_out(i)).collect()
}

/// The faces around a node that meet another part of the other surface than the nearest of them, behind it or beyond a step down from it:
/// the mean of both levels would hold nothing before it is closed, or too early.
fn behind(patches: &Patches, node: u32, slave: &[u32], met: &[Met], around: &[usize]) -> Vec<usize> {
    let meets: Vec<usize> =
        around.iter().copied().filter(|&i| met[i].covered > 0.0 && patches.shapes(slave[i], node)).collect();
    let Some(nearest) = meets.iter().copied().min_by(|&a, &b| met[a].distance.total_cmp(&met[b].distance)) else {
        return Vec::new();
    };
    let size = meets.iter().fold(0.0, |size: f64, &i| size.max(met[i].flat.abs().sqrt()));
    let limit = met[nearest].distance + BEHIND * size;
    let level = |i: usize| Some(Level { point: met[i].middle, normal: unit(met[i].normals)? });
    let upper = level(nearest);
    let is_beyond_step = |i: usize| match (level(i), upper) {
        (Some(level), Some(upper)) => level.is_step_down_from(&upper, size),
        _ => false,
    };
    let nodes = |i: usize| met[i].masters.iter().map(|entry| entry.0);
    let is_near = |&i: &usize| met[i].distance <= limit && !is_beyond_step(i);
    let (near, mut behind): (Vec<usize>, Vec<usize>) = meets.into_iter().partition(is_near);
    let mut reached: FxHashSet<u32> = near.into_iter().flat_map(nodes).collect();
    while let Some(place) = behind.iter().position(|&i| nodes(i).any(|node| reached.contains(&node))) {
        reached.extend(nodes(behind.swap_remove(place)));
    }
    behind
}

/// Leaves of the segments of a face those on what it lies on: where the other surface ends under the face and another part of it
/// lies behind, the dual functions, negative in places, would make an overlap of two distances. Whether parts that do not
/// hang together are left.
pub(super) fn keep_nearest_part(mesh: &Mesh, segments: &mut Vec<Segment>, whole: f64) -> bool {
    let mut parts: Vec<(FxHashSet<u32>, Vec<usize>)> = Vec::new();
    for (k, segment) in segments.iter().enumerate() {
        let nodes = mesh.faces[segment.face as usize].nodes();
        let (joined, apart): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|(known, _)| nodes.iter().any(|node| known.contains(node)));
        let mut part = (nodes.iter().copied().collect::<FxHashSet<u32>>(), vec![k]);
        for (known, members) in joined {
            part.0.extend(known);
            part.1.extend(members);
        }
        part.1.sort_unstable();
        parts = apart;
        parts.push(part);
    }
    if parts.len() < 2 {
        return false;
    }
    let covers = |members: &[usize]| members.iter().map(|&k| area(&segments[k].polygon).abs()).sum::<f64>();
    let distance = |members: &[usize]| {
        let of = |&k: &usize| area(&segments[k].polygon).abs() * segments[k].distance;
        members.iter().map(of).sum::<f64>() / covers(members)
    };
    let large = parts.iter().filter(|(_, members)| covers(members) >= LEAST_PART * whole.abs());
    let Some(nearest) = large.map(|(_, members)| distance(members)).min_by(|a, b| a.total_cmp(b)) else { return true };
    let limit = nearest + BEHIND * whole.abs().sqrt();
    let mut kept = vec![false; segments.len()];
    let mut left = 0;
    for (_, members) in parts.iter().filter(|(_, members)| distance(members) <= limit) {
        members.iter().for_each(|&k| kept[k] = true);
        left += 1;
    }
    let mut kept = kept.into_iter();
    segments.retain(|_| kept.next() == Some(true));
    left > 1
}
