//! Nodes of a slave surface that lie beyond the edge of the other one.
//!
//! The dual function of such a node `o` has its resultant at the node, which no pressure on the covered part has: a body would stand
//! with its weight beyond the edge it stands on. Its force acts instead at the covered place `x` where the function of the
//! node is largest. There a unit force does the work of `phi_k(x)` at each node `k` of the face: the jump of the node gets
//! `phi_k(x) / phi_o(x)` times the jumps of its neighbours, and these stand for so much less of its area. A constant pressure and all
//! displacements that can be constrained are as before; what is left out are resultants beyond the edge.

use std::collections::BTreeMap;

use rustc_hash::{FxHashMap, FxHashSet};

use super::flat::{Flat, P2};
use super::mortar::{Edges, Met, PerNode};
use super::tributary::{END, positive};
use crate::mesh::Mesh;
use crate::mesh::shape::FACE_NODES;

/// A node whose function gets so close to one is not beyond the edge.
const REACHED: f64 = 1.0 - 1e-3;
/// Two nodes whose places are closer than this, in the functions of the face, have one multiplier.
const SAME_PLACE: f64 = 0.2;
/// A node whose function stays below this has no multiplier: its force would act on its neighbours for the most part, and multigrid takes
/// many more cycles (flange of `bench/assemblies`, 200 000 unknowns, three load steps: 260, 96 and 90 at 0.35; 80, 35 and 37 at 0.5; 113, 45
/// and 44 with nodes beyond the edge as any others).
const LEAST_REACH: f64 = 0.5;
/// Smaller parts of quadratic faces are left out: functions of corners are nearly zero at the middles of edges, and with them the flange
/// takes three times the cycles.
const SMALL_PART: f64 = 0.01;
/// Parts below this are rounding.
const ROUNDING: f64 = 1e-9;
/// Places where a function is as large as this part of its largest value count alike.
const EQUAL: f64 = 1.0 - 1e-9;
/// Nodes beyond the edge act on one another along chains of so many at most.
const MOST_LINKS: usize = 2;
/// The part of its area that a node keeps at least.
const LEAST_AREA: f64 = 0.1;

/// For each node of a face the values of all functions where its own is largest in the covered part.
pub(super) type Places = Box<[PerNode; FACE_NODES]>;

/// Among the corners, the middles of sides and the middles of these polygons; the functions are those with positive integrals. Where several places are
/// equal, their mean.
pub(super) fn places<'a>(face: &Flat, polygons: impl Iterator<Item = &'a [P2]>) -> Places {
    let n = face.nodes().len();
    let values = |x: P2| positive(&face.shape(x), n, &[END; FACE_NODES]);
    let mut candidates: Vec<PerNode> = Vec::new();
    for polygon in polygons {
        candidates.extend(polygon.iter().map(|&x| values(x)));
        if n > 4 {
            let next = polygon.iter().cycle().skip(1);
            let half = |(a, b): (&P2, &P2)| [0, 1].map(|c| 0.5 * (a[c] + b[c]));
            candidates.extend(polygon.iter().zip(next).map(half).map(values));
        }
    }
    let mean = |i: usize| {
        let largest = candidates.iter().map(|values| values[i]).fold(f64::NEG_INFINITY, f64::max);
        let equal = || candidates.iter().filter(|values| largest <= 0.0 || values[i] >= EQUAL * largest);
        let part = 1.0 / equal().count().max(1) as f64;
        equal().fold([0.0; FACE_NODES], |sum, values| std::array::from_fn(|k| sum[k] + part * values[k]))
    };
    Box::new(std::array::from_fn(|i| if i < n { mean(i) } else { [0.0; FACE_NODES] }))
}

/// The nodes beyond the edge.
#[derive(Debug, Default)]
pub(super) struct Overhang {
    /// Of each the neighbours on which its force acts as well, with their parts of its own; the nodes that reach least come first, and a
    /// neighbour reaches farther.
    shifts: Vec<(u32, BTreeMap<u32, f64>)>,
    /// Those without a place of their own.
    pub(super) dropped: FxHashSet<u32>,
}

/// Values that differ by rounding are the same, so that nodes do not change places where a mesh is turned.
fn without_rounding(value: f64) -> f64 {
    (value / ROUNDING).round() * ROUNDING
}

/// A node with the faces it carries in that have places: the place of the face and of the node in it.
type InFaces = BTreeMap<u32, Vec<(usize, usize)>>;

impl Overhang {
    /// Of the faces `slave` that have `met` others and in which nodes are carried for by themselves (`carries`).
    pub(super) fn new(
        mesh: &Mesh,
        slave: &[u32],
        met: &[Met],
        edges: &Edges,
        carries: impl Fn(u32, u32) -> bool,
    ) -> Overhang {
        let mut reach: FxHashMap<u32, f64> = FxHashMap::default();
        let mut faces = InFaces::new();
        for (at, (&face, met)) in slave.iter().zip(met).enumerate().filter(|(_, (_, met))| met.covered > 0.0) {
            for (i, &node) in mesh.faces[face as usize].nodes().iter().enumerate().filter(|(_, n)| carries(face, **n)) {
                let value = met.places.as_ref().map_or(1.0, |places| without_rounding(places[i][i]));
                let largest = reach.entry(node).or_insert(value);
                *largest = largest.max(value);
                if met.places.is_some() {
                    faces.entry(node).or_default().push((at, i));
                }
            }
        }
        faces.retain(|node, _| reach[node] < REACHED);
        // Whether a neighbour is measured before a node.
        let farther = |k: u32, o: u32| match (reach.get(&k), reach[&o]) {
            (Some(&there), here) => there > here || (there == here && k < o),
            (None, _) => false,
        };
        // Middles of edges are measured from the ends, which cannot be measured from them.
        let ends: FxHashSet<u32> = edges.values().flatten().copied().collect();
        let of_face = |at: usize| mesh.faces[slave[at] as usize].nodes();
        let least = if edges.is_empty() { ROUNDING } else { SMALL_PART };
        let mut overhang = Overhang::default();
        for (&o, faces_of) in &faces {
            let at_place_of_another = || {
                let is_another = |at: usize, i: usize, (m, node): (usize, &u32)| {
                    let Some(places) = &met[at].places else { return false };
                    *node != o && faces.contains_key(node) && farther(*node, o) && near(&places[i], &places[m])
                };
                let largest = |at: usize, i: usize| {
                    met[at].places.as_ref().is_some_and(|places| without_rounding(places[i][i]) >= EQUAL * reach[&o])
                };
                faces_of.iter().any(|&(at, i)| {
                    largest(at, i) && of_face(at).iter().enumerate().any(|other| is_another(at, i, other))
                })
            };
            // One node of the faces carries for the others where none is within.
            let is_farthest = faces_of.iter().all(|&(at, _)| of_face(at).iter().all(|&k| !farther(k, o)));
            let has_no_place = reach[&o] < LEAST_REACH || ends.contains(&o) || at_place_of_another();
            if has_no_place && !is_farthest {
                overhang.dropped.insert(o);
                continue;
            }
            // The mean of the faces by the areas that the node has there.
            let (mut parts, mut sum) = (BTreeMap::<u32, f64>::new(), 0.0);
            for &(at, i) in faces_of {
                let Some(places) = &met[at].places else { continue };
                let (area, values) = (met[at].areas[i], places[i]);
                if area <= 0.0 || values[i] <= 0.0 {
                    continue;
                }
                sum += area;
                for (&k, value) in of_face(at).iter().zip(values).filter(|(k, _)| **k != o) {
                    *parts.entry(k).or_default() += area * value / values[i];
                }
            }
            parts.retain(|&k, part| {
                *part /= sum;
                part.abs() > least && farther(k, o)
            });
            overhang.shifts.push((o, parts));
        }
        overhang.shifts.sort_by(|a, b| reach[&a.0].total_cmp(&reach[&b.0]).then(b.0.cmp(&a.0)));
        let mut links: FxHashMap<u32, usize> = FxHashMap::default();
        for (o, parts) in overhang.shifts.iter_mut().rev() {
            let of = |k: &u32| links.get(k).copied().unwrap_or(0);
            parts.retain(|k, _| of(k) < MOST_LINKS);
            let longest = parts.keys().map(of).max().unwrap_or(0);
            links.insert(*o, 1 + longest);
        }
        overhang
    }

    /// For nodes with multipliers, given their `areas`: the neighbours each acts on as well, with their parts of it, and of each node the part of
    /// its area that is left.
    pub(super) fn moved(
        &self,
        areas: &FxHashMap<u32, f64>,
    ) -> (BTreeMap<u32, BTreeMap<u32, f64>>, FxHashMap<u32, f64>) {
        let (mut moved, mut taken): (BTreeMap<u32, BTreeMap<u32, f64>>, BTreeMap<u32, f64>) = Default::default();
        let kept = |k: u32, taken: &BTreeMap<u32, f64>| {
            let (area, most) = (areas[&k], (1.0 - LEAST_AREA) * areas[&k]);
            let all = taken.get(&k).copied().unwrap_or(0.0);
            (if all > most { most / all } else { 1.0 }, area - all.min(most))
        };
        for (o, parts) in self.shifts.iter().filter(|(o, _)| areas.contains_key(o)) {
            let (_, area) = kept(*o, &taken);
            let parts: BTreeMap<u32, f64> =
                parts.iter().filter(|(k, _)| areas.contains_key(k)).map(|(&k, &part)| (k, part)).collect();
            parts.iter().for_each(|(&k, part)| *taken.entry(k).or_default() += part * area);
            moved.insert(*o, parts);
        }
        for (k, part) in moved.values_mut().flatten() {
            *part *= kept(*k, &taken).0;
        }
        let left = taken.keys().map(|&k| (k, kept(k, &taken).1 / areas[&k])).collect();
        (moved, left)
    }
}

/// Whether two places are hardly apart, by the values of the functions of the face there.
fn near(a: &PerNode, b: &PerNode) -> bool {
    let sums = [a, b].map(|values| values.iter().sum::<f64>());
    0.5 * a.iter().zip(b).map(|(x, y)| (x / sums[0] - y / sums[1]).abs()).sum::<f64>() < SAME_PLACE
}
