//! Dual mortar: how the nodes of a slave surface hang on the nodes of a master surface with another mesh.
//!
//! Lagrange multipliers with dual shape functions `psi_j` (Wohlmuth 2000), integrated face by face over the segments in
//! which slave and master faces overlap (Puso & Laursen 2004): on the plane through the middle of the slave face across
//! its normal both are projected and clipped, and what remains is integrated by triangles, exactly on flat faces.
//! `psi = A phi` on a face, `A = D M⁻¹`, `D = diag(int phi)`, `M = int phi phi'`, over the covered part only (Cichosz &
//! Bischoff 2011) and with the very quadrature of the coupling, which keeps the jump of a linear field zero whatever the
//! error of the quadrature.
//!
//! Quadratic faces are projected and clipped as the polygons between their nodes, a middle and a triangle or
//! quadrilateral at each corner; points are mapped back to the curved face. On the slave side `phi` are the functions of
//! `tributary.rs`, whose integrals are positive.
//!
//! Warped faces are taken as flat, along the mean normal of the slave face, and the coupling is that of the reference
//! configuration.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::flat::{Flat, P2, area, bounds, clip, quadrature};
use super::obstacle::unit;
use super::overhang::{Overhang, Places, places};
use super::patches::keep_nearest_part;
use super::tributary::{END, ends, positive};
use crate::fem::face_coordinates;
use crate::mesh::shape::FACE_NODES;
use crate::mesh::v3::{V3, add, cross, dot, scale, sub};
use crate::mesh::{Bounds, Mesh, Tree};

/// Faces meet if the cosine between their outward normals is below this: they look at one another within 75 degrees.
pub(super) const FACING: f64 = -0.25;
/// Faces that look the same way meet where they lie in one another: no farther apart than this part of the slave's size.
const COINCIDENT: f64 = 1e-3;
/// Overlaps smaller than this part of the slave face are rounding.
const SLIVER: f64 = 1e-13;
/// A face covered to less than this part is not covered: the dual functions over it could not be distinguished.
const LEAST_PART: f64 = 1e-6;
/// A face is wholly covered if no larger part is not.
const WHOLLY: f64 = 1e-9;
/// Edges shorter than this part of the size of a face are rounding, of coordinates far from the origin too.
const SHORT: f64 = 1e-9;
/// Weights below this are rounding: matching nodes then hang on one node only.
const ROUNDING: f64 = 1e-12;
/// A node that carries for dropped neighbours must still count with this part of itself.
const LEAST_OWN: f64 = 0.2;

/// A number for each node of a face.
pub(super) type PerNode = [f64; FACE_NODES];

/// What a slave face meets: everything about its nodes `i`, in the order of the face.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Met {
    /// `int phi_i` over the covered part; area.
    pub areas: PerNode,
    /// `int psi_i phi_k` for the nodes `k` of the master faces, ascending; area.
    pub masters: PerMaster,
    /// The covered area; 0 if the face meets nothing.
    pub covered: f64,
    /// The area of the flat pieces that stand for the face.
    pub flat: f64,
    /// From the face to what it meets, in the mean and least and most, negative where it lies in it; length.
    pub distance: f64,
    pub distances: [f64; 2],
    /// Of the faces it meets the normals times the areas met, and the middle of what is met of them.
    pub normals: V3,
    pub middle: V3,
    /// Whether it meets parts that do not hang together.
    pub several: bool,
    /// Whether a face of the other surface that looks the same way lies over or under it.
    pub averted: bool,
    /// Where in the covered part the functions of its nodes are largest; none if all of the face is covered.
    pub places: Option<Places>,
}

/// A face in space, seen along a direction.
pub(super) struct Seen {
    pub flat: Flat,
    /// Heights of the nodes above the plane.
    heights: PerNode,
}

/// A plane with axes; the third is its normal.
pub(super) struct Plane {
    pub origin: V3,
    pub axes: [V3; 3],
}

impl Plane {
    /// Through the middle of a face across its mean normal.
    pub(super) fn of_face(mesh: &Mesh, face: u32) -> Option<Plane> {
        let normal = unit(mesh.face_vector_area(face as usize))?;
        let corners = &face_coordinates(mesh, face)[..mesh.faces[face as usize].corners().len()];
        let origin = scale(1.0 / corners.len() as f64, corners.iter().fold([0.0; 3], |a, &x| add(a, x)));
        let edge = sub(corners[1], corners[0]);
        let first = unit(sub(edge, scale(dot(edge, normal), normal)))?;
        Some(Plane { origin, axes: [first, cross(normal, first), normal] })
    }

    pub(super) fn see(&self, nodes: &[V3]) -> Seen {
        let (mut flat, mut heights) = ([[0.0; 2]; FACE_NODES], [0.0; FACE_NODES]);
        for (i, &x) in nodes.iter().enumerate() {
            let d = sub(x, self.origin);
            flat[i] = [dot(d, self.axes[0]), dot(d, self.axes[1])];
            heights[i] = dot(d, self.axes[2]);
        }
        Seen { flat: Flat::new(&flat[..nodes.len()]), heights }
    }
}

impl Seen {
    fn height(&self, x: P2) -> f64 {
        self.flat.shape(x).iter().zip(self.heights).map(|(s, h)| s * h).sum()
    }
}

/// What faces may meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search {
    /// They meet no farther than this along their normals, length.
    pub length: f64,
    /// A face that no face looks at meets those that look the same way and lie in it.
    pub averted: bool,
}

/// What each face of `slave` meets of the faces of `master`.
pub(super) fn meet(mesh: &Mesh, slave: &[u32], master: &[u32], search: Search) -> Vec<Met> {
    meet_some(mesh, slave, [slave, master], search)
}

/// The same of `some` faces of the slave. Only faces in the box around theirs and these moved along their normals, forwards and backwards by the
/// length of the search, are looked at, in the order of the lists.
pub(super) fn meet_some(mesh: &Mesh, some: &[u32], [slave, master]: [&[u32]; 2], search: Search) -> Vec<Met> {
    let tree =
        |faces: &[u32]| Tree::new(faces.iter().map(|&face| Bounds::around(face_coordinates(mesh, face))).collect());
    let sides = Sides { slave, own: tree(slave), master, other: tree(master) };
    let Search { length, averted } = search;
    let of = |&face: &u32| {
        let found = met(mesh, face, &sides, length, [false, averted]).unwrap_or_default();
        let again = averted && found.averted && found.covered == 0.0;
        if again { met(mesh, face, &sides, length, [true; 2]).unwrap_or(found) } else { found }
    };
    some.par_iter().map(of).collect()
}

/// The part of a slave face under one master face, or a piece of both.
pub(super) struct Segment {
    pub face: u32,
    /// Place of the master face among those that were looked at.
    seen: usize,
    pub polygon: Vec<P2>,
    /// Of its middle, from the slave face to the master face along the normal; length.
    pub distance: f64,
}

/// The faces of both surfaces, and trees of their places.
struct Sides<'a> {
    slave: &'a [u32],
    own: Tree,
    master: &'a [u32],
    other: Tree,
}

/// With `same` what looks the same way is met, otherwise what looks back. With `every` all parts of the other surface are met, not
/// the nearest alone.
fn met(mesh: &Mesh, face: u32, sides: &Sides, search: f64, [same, every]: [bool; 2]) -> Option<Met> {
    let plane = Plane::of_face(mesh, face)?;
    let own = face_coordinates(mesh, face);
    let slave = plane.see(&own);
    let pieces = slave.flat.pieces();
    let whole: f64 = pieces.iter().map(|piece| area(piece)).sum();
    let search = if same { search.min(COINCIDENT * whole.abs().sqrt()) } else { search };
    let [low, high] = bounds(slave.flat.nodes());
    let reach = |side: f64| own.iter().map(move |&x| add(x, scale(side * search, plane.axes[2])));
    let candidates = sides.other.meeting(&Bounds::around(reach(-1.0).chain(reach(1.0))));
    let (mut segments, mut masters, mut averted) = (Vec::new(), Vec::new(), false);
    let (mut polygon, mut room) = (Vec::new(), Vec::new());
    for other in candidates.into_iter().map(|i| sides.master[i as usize]) {
        let seen = plane.see(&face_coordinates(mesh, other));
        let [from, to] = bounds(seen.flat.nodes());
        if (0..2).any(|c| to[c] < low[c] || high[c] < from[c]) {
            continue;
        }
        let cosine = dot(mesh.face_normal(other as usize), plane.axes[2]);
        let meets = if same { cosine > -FACING } else { cosine < FACING };
        let parts = seen.flat.pieces();
        let before = segments.len();
        for (mine, theirs) in pieces.iter().flat_map(|mine| parts.iter().map(move |theirs| (mine, theirs))) {
            clip(theirs, mine, &mut polygon, &mut room);
            if area(&polygon).abs() <= SLIVER * whole {
                continue;
            }
            let middle = [0, 1].map(|c| polygon.iter().map(|p| p[c]).sum::<f64>() / polygon.len() as f64);
            let distance = seen.height(middle) - slave.height(middle);
            averted |= cosine >= FACING && distance.abs() <= search;
            if meets && distance.abs() <= search {
                // Seen from the slave face a master face that looks back turns the other way.
                if !same {
                    polygon.reverse();
                }
                segments.push(Segment { face: other, seen: masters.len(), polygon: polygon.clone(), distance });
            }
        }
        if segments.len() > before {
            masters.push(seen);
        }
    }
    if !same {
        leave_out_beyond_own_side(mesh, (face, &plane, whole.abs().sqrt()), sides, &mut segments);
    }
    keep_nearest(&mut segments, whole);
    let several = !every && keep_nearest_part(mesh, &mut segments, whole);
    let covered: f64 = segments.iter().map(|s| area(&s.polygon)).sum();
    if covered < LEAST_PART * whole {
        return Some(Met { averted, flat: whole, ..Met::default() });
    }
    let places =
        (covered < (1.0 - WHOLLY) * whole).then(|| places(&slave.flat, segments.iter().map(|s| s.polygon.as_slice())));
    let distance = segments.iter().map(|s| area(&s.polygon) * s.distance).sum::<f64>() / covered;
    let heights = segments.iter().flat_map(|s| s.polygon.iter().map(|&x| masters[s.seen].height(x) - slave.height(x)));
    let distances = heights
        .chain(segments.iter().map(|s| s.distance))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)]);
    let normals = segments
        .iter()
        .fold([0.0; 3], |sum, s| add(sum, scale(area(&s.polygon).abs(), mesh.face_normal(s.face as usize))));
    let middle = middle_of(&plane, &masters, &segments, covered);
    couple(mesh, &slave, &masters, &segments, own.len()).map(|(areas, masters)| Met {
        areas,
        masters,
        covered,
        flat: whole,
        distance,
        distances,
        normals,
        middle,
        several,
        averted,
        places,
    })
}

/// Where the segments, of the area `covered`, lie on the master in the mean.
fn middle_of(plane: &Plane, masters: &[Seen], segments: &[Segment], covered: f64) -> V3 {
    let mut sum = [0.0; 3];
    for segment in segments {
        let [x, y] = [0, 1].map(|c| segment.polygon.iter().map(|p| p[c]).sum::<f64>() / segment.polygon.len() as f64);
        let at = [x, y, masters[segment.seen].height([x, y])];
        (0..3).for_each(|c| sum[c] += area(&segment.polygon) / covered * at[c]);
    }
    plane.axes.iter().zip(sum).fold(plane.origin, |middle, (&axis, x)| add(middle, scale(x, axis)))
}

/// Leaves out what lies in the body deeper than the body is thick there: behind a face of its own that looks back. Top and bottom of two
/// plates on one another, with whole skins named, look away from one another and do not overlap.
/// `size` is the root of the area of the face.
fn leave_out_beyond_own_side(
    mesh: &Mesh,
    (face, plane, size): (u32, &Plane, f64),
    sides: &Sides,
    segments: &mut Vec<Segment>,
) {
    let deepest = segments.iter().map(|s| s.distance).fold(0.0, f64::min);
    if deepest >= -COINCIDENT * size {
        return;
    }
    let own = face_coordinates(mesh, face);
    let inwards = own.iter().map(|&x| add(x, scale(deepest, plane.axes[2])));
    let near = sides.own.meeting(&Bounds::around(own.iter().copied().chain(inwards)));
    let looks_back = |&other: &u32| other != face && dot(mesh.face_normal(other as usize), plane.axes[2]) < FACING;
    let backs: Vec<Seen> = (near.into_iter().map(|i| sides.slave[i as usize]).filter(looks_back))
        .map(|other| plane.see(&face_coordinates(mesh, other)))
        .collect();
    let (mut polygon, mut room) = (Vec::new(), Vec::new());
    segments.retain(|segment| {
        if segment.distance >= -COINCIDENT * size {
            return true;
        }
        let mut mine = segment.polygon.clone();
        if area(&mine) < 0.0 {
            mine.reverse();
        }
        // Edges as short as rounding have no direction to clip by.
        let same = |a: P2, b: P2| (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) <= SHORT * size;
        mine.dedup_by(|a, b| same(*a, *b));
        while mine.len() > 1 && same(mine[0], mine[mine.len() - 1]) {
            mine.pop();
        }
        let mut before = 0.0;
        for back in &backs {
            for piece in back.flat.pieces() {
                clip(&piece, &mine, &mut polygon, &mut room);
                if polygon.is_empty() {
                    continue;
                }
                let middle = [0, 1].map(|c| polygon.iter().map(|p| p[c]).sum::<f64>() / polygon.len() as f64);
                let height = back.height(middle);
                if height < 0.0 && height > segment.distance + COINCIDENT * size {
                    before += area(&polygon).abs();
                }
            }
        }
        before < 0.5 * area(&mine)
    });
}

/// Where several layers lie over one another, only the nearest is met.
fn keep_nearest(segments: &mut Vec<Segment>, whole: f64) {
    let mut covered: f64 = segments.iter().map(|s| area(&s.polygon)).sum();
    while covered > (1.0 + 1e-6) * whole {
        let far = segments.iter().enumerate().max_by(|a, b| a.1.distance.abs().total_cmp(&b.1.distance.abs()));
        let Some((far, _)) = far else { return };
        covered -= area(&segments.remove(far).polygon);
    }
}

/// For the nodes of other faces `k` an integral with each node of a face.
type PerMaster = Vec<(u32, PerNode)>;

/// Integrals of `phi_i` and of `psi_i phi_k` over the segments, the latter as `D M⁻¹ int phi_i phi_k`.
fn couple(mesh: &Mesh, slave: &Seen, masters: &[Seen], segments: &[Segment], n: usize) -> Option<(PerNode, PerMaster)> {
    let (mut d, mut m) = ([0.0; FACE_NODES], [[0.0; FACE_NODES]; FACE_NODES]);
    let mut coupled = PerMaster::new();
    for segment in segments {
        let (other, nodes) = (&masters[segment.seen].flat, mesh.faces[segment.face as usize].nodes());
        let mut g = [[0.0; FACE_NODES]; FACE_NODES];
        quadrature(&segment.polygon, slave.flat.degree.max(other.degree), |x, weight| {
            let (phi, shape) = (positive(&slave.flat.shape(x), n, &[END; 8]), other.shape(x));
            for i in 0..n {
                let own = weight * phi[i];
                d[i] += own;
                (0..n).for_each(|j| m[i][j] += own * phi[j]);
                (0..nodes.len()).for_each(|k| g[k][i] += own * shape[k]);
            }
        });
        coupled.extend(nodes.iter().zip(g).map(|(&node, g)| (node, g)));
    }
    coupled.sort_by_key(|entry| entry.0);
    coupled.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1.iter_mut().zip(next.1).for_each(|(sum, g)| *sum += g);
        }
        same
    });
    let inverse = inverse(m, n)?;
    for (_, g) in &mut coupled {
        let phi = *g;
        (0..n).for_each(|i| g[i] = d[i] * (0..n).map(|j| inverse[i][j] * phi[j]).sum::<f64>());
    }
    Some((d, coupled))
}

/// Inverse of a symmetric positive definite matrix of order `n <= 8`, by Gauss and Jordan after scaling its diagonal to
/// one; `None` if it is singular.
fn inverse(m: [PerNode; FACE_NODES], n: usize) -> Option<[PerNode; FACE_NODES]> {
    let s: PerNode = std::array::from_fn(|i| if i < n { 1.0 / m[i][i].sqrt() } else { 1.0 });
    let mut a: [PerNode; FACE_NODES] = std::array::from_fn(|i| std::array::from_fn(|j| s[i] * s[j] * m[i][j]));
    let mut b: [PerNode; FACE_NODES] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))?;
        a.swap(k, pivot);
        b.swap(k, pivot);
        let scale = 1.0 / a[k][k];
        if !scale.is_finite() {
            return None;
        }
        a[k].iter_mut().chain(&mut b[k]).for_each(|x| *x *= scale);
        let (row, other) = (a[k], b[k]);
        for i in (0..n).filter(|&i| i != k) {
            let factor = a[i][k];
            (0..n).for_each(|j| (a[i][j], b[i][j]) = (a[i][j] - factor * row[j], b[i][j] - factor * other[j]));
        }
    }
    Some(std::array::from_fn(|i| std::array::from_fn(|j| s[i] * s[j] * b[i][j])))
}

/// The weighted jump at a slave node, `u_node + sum(weight u_other)`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    pub node: u32,
    /// `D_jj = int phi_j` over the covered part.
    pub area: f64,
    /// `int psi_j / D_jj`: one, or `1 - 2 END` in the middle of an edge, and more where the node carries what a dropped
    /// neighbour would have carried. The master weights add up to its negative.
    pub unity_sum: f64,
    /// Master nodes with `-M_jk / D_jj`, then slave nodes (dropped ones, ends of edges, those it acts on as well), each ascending.
    pub others: Vec<(u32, f64)>,
}

/// Over so many rings of faces kept nodes carry for dropped ones: a corner triangle may have only dropped nodes, but what
/// is farther away is not theirs.
const RINGS: usize = 2;

/// Who carries for each dropped node with a covered patch, and which part of it: the kept nodes next to it.
type Carriers = BTreeMap<Dropped, Vec<(u32, f64)>>;

/// A node and the side of the surface on which it keeps no multiplier.
type Dropped = (u32, u32);

/// Middles of edges (`edges`) leave their functions to other middles where there are any: ends of the edge would depend
/// on one another through it.
fn carriers(
    mesh: &Mesh,
    slave: &[u32],
    met: &[Met],
    edges: &Edges,
    keep: &impl Fn(u32, u32) -> Result<(), u32>,
) -> Carriers {
    // For each dropped node the others of its faces, each with where that one is dropped, if it is.
    let mut near: BTreeMap<Dropped, BTreeSet<(u32, Option<u32>)>> = BTreeMap::new();
    for (&face, _) in slave.iter().zip(met).filter(|(_, met)| met.covered > 0.0) {
        let nodes = mesh.faces[face as usize].nodes();
        for &node in nodes {
            let Err(side) = keep(face, node) else { continue };
            let others = nodes.iter().filter(|&&other| other != node).map(|&other| (other, keep(face, other).err()));
            near.entry((node, side)).or_default().extend(others);
        }
    }
    let mut carriers = Carriers::new();
    for _ in 0..RINGS {
        let mut ring = Carriers::new();
        for (&dropped, others) in near.iter().filter(|(dropped, _)| !carriers.contains_key(dropped)) {
            let is_kept_middle = |(other, side): &&(u32, Option<u32>)| edges.contains_key(other) && side.is_none();
            let middles = edges.contains_key(&dropped.0) && others.iter().any(|other| is_kept_middle(&other));
            let of = |&(other, side): &(u32, Option<u32>)| match side {
                None => Some(vec![(other, 1.0)]),
                Some(side) => carriers.get(&(other, side)).cloned(),
            };
            let known: Vec<Vec<(u32, f64)>> =
                others.iter().filter(|other| !middles || is_kept_middle(other)).filter_map(of).collect();
            let part = 1.0 / known.len() as f64;
            let mut parts: BTreeMap<u32, f64> = BTreeMap::new();
            known.iter().flatten().for_each(|&(other, weight)| *parts.entry(other).or_default() += part * weight);
            if !parts.is_empty() {
                ring.insert(dropped, parts.into_iter().collect());
            }
        }
        carriers.append(&mut ring);
    }
    carriers
}

/// The rows of the slave nodes that `keep` keeps in a face (its arguments), ascending by node, and the covered area no row
/// stands for. Where it does not, it tells on which side of the surface the node is dropped.
///
/// A dropped node `q` leaves its function to the kept nodes next to it, `psi_j + sum_q c_jq psi_q`, `sum_j c_jq = 1`: the
/// functions still add up to one, so that a constant pressure is carried everywhere (Puso & Laursen 2004; Wohlmuth 2000
/// at cross points), and the displacement of the dropped node enters the jump of those that carry for it. Nobody carries for nodes
/// that are `left_out`: something else is met there.
pub(super) fn rows(
    mesh: &Mesh,
    slave: &[u32],
    met: &[Met],
    (edges, overhang): (&Edges, &Overhang),
    keep: impl Fn(u32, u32) -> Result<(), u32>,
    left_out: impl Fn(u32) -> bool,
) -> (Vec<Row>, f64) {
    let carriers = carriers(mesh, slave, met, edges, &keep);
    let mut sums: FxHashMap<u32, Sums> = FxHashMap::default();
    let stands_for = |node: &u32, area: f64| if edges.contains_key(node) { (1.0 - 2.0 * END) * area } else { area };
    let mut lost = 0.0;
    for (&face, met) in slave.iter().zip(met).filter(|(_, met)| met.covered > 0.0) {
        for (i, &node) in mesh.faces[face as usize].nodes().iter().enumerate() {
            let Err(side) = keep(face, node) else {
                let own = sums.entry(node).or_default();
                own.area += met.areas[i];
                own.add(met, i, 1.0);
                continue;
            };
            if left_out(node) {
                continue;
            }
            let Some(carriers) = carriers.get(&(node, side)) else {
                lost += stands_for(&node, met.areas[i]);
                continue;
            };
            for &(carrier, part) in carriers {
                let carrier = sums.entry(carrier).or_default();
                *carrier.dropped.entry(node).or_default() += part * met.areas[i];
                carrier.add(met, i, part);
            }
        }
    }
    let left = act_within(overhang, &mut sums);
    let mut rows = Vec::with_capacity(sums.len());
    let mut sums: Vec<(u32, Sums)> = sums.into_iter().collect();
    sums.sort_unstable_by_key(|entry| entry.0);
    for (node, sums) in sums {
        let area = sums.area;
        match sums.row(node, edges) {
            Some(row) => {
                let area = left.get(&node).unwrap_or(&1.0) * row.area;
                rows.push(Row { area, ..row });
            }
            None => lost += stands_for(&node, area),
        }
    }
    (rows, lost)
}

/// Lets nodes beyond the edge act on their neighbours as well; returns the part of its area that is left to each neighbour.
fn act_within(overhang: &Overhang, sums: &mut FxHashMap<u32, Sums>) -> FxHashMap<u32, f64> {
    let areas = sums.iter().map(|(&node, sums)| (node, sums.area)).collect();
    let (moved, left) = overhang.moved(&areas);
    let own: BTreeMap<u32, Sums> =
        moved.values().flatten().filter_map(|(k, _)| Some((*k, sums.get(k)?.clone()))).collect();
    for (o, parts) in &moved {
        let Some(sums) = sums.get_mut(o) else { continue };
        for (k, part) in parts {
            let (other, part) = (&own[k], part * sums.area);
            let scale = part / other.area;
            sums.masters.extend(other.masters.iter().map(|(master, value)| (*master, scale * value)));
            *sums.dropped.entry(*k).or_default() += part;
            other.dropped.iter().for_each(|(q, value)| *sums.dropped.entry(*q).or_default() += scale * value);
        }
    }
    left
}

/// The ends of the edge for each node in the middle of one.
pub(super) type Edges = FxHashMap<u32, [u32; 2]>;

pub(super) fn edges(mesh: &Mesh, faces: &[u32]) -> Edges {
    let of_face = |&face: &u32| {
        let nodes = mesh.faces[face as usize].nodes();
        (0..nodes.len()).filter_map(move |i| Some((nodes[i], ends(nodes.len(), i)?.map(|end| nodes[end]))))
    };
    faces.iter().flat_map(of_face).collect()
}

/// Integrals over all faces around a node, those of the nodes it carries for included; area.
#[derive(Clone, Default)]
struct Sums {
    /// `int phi_j`.
    area: f64,
    /// Terms of `int psi_j phi_k` of master nodes `k`, in the order of the faces.
    masters: Vec<(u32, f64)>,
    /// `int psi_j phi_q` of slave nodes `q` that are dropped, or on which the node acts as well.
    dropped: BTreeMap<u32, f64>,
}

impl Sums {
    fn add(&mut self, met: &Met, i: usize, part: f64) {
        self.masters.extend(met.masters.iter().map(|(k, values)| (*k, part * values[i])));
    }

    /// The row, scaled so that its own node counts once; none if hardly anything of that node is left.
    fn row(mut self, node: u32, edges: &Edges) -> Option<Row> {
        let mut slave: BTreeMap<u32, f64> = BTreeMap::new();
        let mut count = |node: u32, weight: f64| {
            *slave.entry(node).or_default() += weight;
            for &end in edges.get(&node).into_iter().flatten() {
                *slave.entry(end).or_default() -= END * weight;
            }
        };
        count(node, 1.0);
        self.dropped.iter().for_each(|(&q, value)| count(q, value / self.area));
        let own = slave.remove(&node).filter(|own| *own >= LEAST_OWN)?;
        let (area, unity_sum) = (self.area * own, 1.0 + slave.values().sum::<f64>() / own);
        self.masters.sort_by_key(|term| term.0);
        let same_node = self.masters.chunk_by(|a, b| a.0 == b.0);
        let mut others: Vec<(u32, f64)> =
            same_node.map(|terms| (terms[0].0, -terms.iter().map(|term| term.1).sum::<f64>() / area)).collect();
        others.retain(|(_, weight)| weight.abs() > ROUNDING);
        // A translation of everything must not be a jump, to the last digit.
        let sum = unity_sum + others.iter().map(|other| other.1).sum::<f64>();
        let heaviest = others.iter_mut().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        heaviest.into_iter().for_each(|other| other.1 -= sum);
        others.extend(slave.into_iter().map(|(q, weight)| (q, weight / own)));
        Some(Row { node, area, unity_sum, others })
    }
}
