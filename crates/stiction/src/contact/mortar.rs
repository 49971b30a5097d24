//! Dual mortar: how the nodes of a slave surface hang on the nodes of a master surface with another mesh.
//!
//! Lagrange multipliers with dual shape functions `psi_j` (Wohlmuth 2000), integrated face by face over the segments in
//! which slave and master faces overlap (Puso & Laursen 2004): on the plane through the middle of the slave face across
//! its normal both are projected and clipped, and what remains is integrated by triangles, exactly on flat faces.
//! `psi = A phi` on a face, `A = D M⁻¹`, `D = diag(int phi)`, `M = int phi phi'`, over the covered part only (Cichosz &
//! Bischoff 2011) and with the very quadrature of the coupling, which keeps the jump of a linear field zero whatever the
//! error of the quadrature.

use rayon::prelude::*;

use super::flat::{Flat, P2, area, clip, quadrature};
use super::obstacle::unit;
use crate::mesh::v3::{V3, add, cross, dot, scale, sub};
use crate::mesh::{Bounds, Mesh, Tree};

/// Faces meet if the cosine between their outward normals is below this: they look at one another within 75 degrees.
const FACING: f64 = -0.25;
/// Overlaps smaller than this part of the slave face are rounding.
const SLIVER: f64 = 1e-13;
/// A face covered to less than this part is not covered: the dual functions over it could not be told apart.
const LEAST_PART: f64 = 1e-6;
/// Weights below this are rounding: matching nodes then hang on one node only.
const ROUNDING: f64 = 1e-12;

/// What a slave face meets: everything about its nodes `i`, in the order of the face.
#[derive(Debug, Clone, Default)]
pub(super) struct Met {
    /// `int phi_i` over the covered part; area.
    pub areas: [f64; 4],
    /// `int psi_i phi_k` for the nodes `k` of the master faces, ascending; area.
    pub masters: Vec<(u32, [f64; 4])>,
    /// The covered area; 0 if the face meets nothing.
    pub covered: f64,
    /// Whether a face of the other surface that looks the same way lies over or under it.
    pub averted: bool,
}

/// A face in space, seen along a direction.
struct Seen {
    flat: Flat,
    /// Heights of the corners above the plane.
    heights: [f64; 4],
}

/// A plane with axes; the third is its normal.
struct Plane {
    origin: V3,
    axes: [V3; 3],
}

impl Plane {
    /// Through the middle of a face across its mean normal.
    fn of_face(mesh: &Mesh, face: u32) -> Option<Plane> {
        let normal = unit(mesh.face_vector_area(face as usize))?;
        let corners = corners(mesh, face);
        let origin = scale(1.0 / corners.len() as f64, corners.iter().fold([0.0; 3], |a, &x| add(a, x)));
        let edge = sub(corners[1], corners[0]);
        let first = unit(sub(edge, scale(dot(edge, normal), normal)))?;
        Some(Plane { origin, axes: [first, cross(normal, first), normal] })
    }

    fn see(&self, corners: &[V3]) -> Seen {
        let (mut flat, mut heights) = ([[0.0; 2]; 4], [0.0; 4]);
        for (i, &x) in corners.iter().enumerate() {
            let d = sub(x, self.origin);
            flat[i] = [dot(d, self.axes[0]), dot(d, self.axes[1])];
            heights[i] = dot(d, self.axes[2]);
        }
        Seen { flat: Flat::new(&flat[..corners.len()]), heights }
    }
}

impl Seen {
    fn height(&self, x: P2) -> f64 {
        self.flat.shape(x).iter().zip(self.heights).map(|(s, h)| s * h).sum()
    }
}

fn corners(mesh: &Mesh, face: u32) -> Vec<V3> {
    mesh.faces[face as usize].nodes().iter().map(|&node| mesh.nodes[node as usize]).collect()
}

/// What each face of `slave` meets of the faces of `master` no farther than `search` (length) along its normal.
pub(super) fn meet(mesh: &Mesh, slave: &[u32], master: &[u32], search: f64) -> Vec<Met> {
    let tree = Tree::new(master.iter().map(|&face| Bounds::around(corners(mesh, face))).collect());
    slave.par_iter().map(|&face| met(mesh, face, master, &tree, search).unwrap_or_default()).collect()
}

/// The part of a slave face under one master face.
struct Segment {
    face: u32,
    seen: Seen,
    polygon: Vec<P2>,
    /// Of its middle, from the slave face to the master face along the normal; length.
    distance: f64,
}

fn met(mesh: &Mesh, face: u32, master: &[u32], tree: &Tree, search: f64) -> Option<Met> {
    let plane = Plane::of_face(mesh, face)?;
    let own = corners(mesh, face);
    let slave = plane.see(&own);
    let whole = area(slave.flat.corners());
    let reach = |side: f64| own.iter().map(move |&x| add(x, scale(side * search, plane.axes[2])));
    let candidates = tree.meeting(&Bounds::around(reach(-1.0).chain(reach(1.0))));
    let (mut segments, mut averted) = (Vec::new(), false);
    for other in candidates.into_iter().map(|i| master[i as usize]).filter(|&other| other != face) {
        let seen = plane.see(&corners(mesh, other));
        let mut polygon = clip(seen.flat.corners(), slave.flat.corners());
        if area(&polygon).abs() <= SLIVER * whole {
            continue;
        }
        let middle = [0, 1].map(|c| polygon.iter().map(|p| p[c]).sum::<f64>() / polygon.len() as f64);
        let distance = seen.height(middle) - slave.height(middle);
        let facing = dot(mesh.face_normal(other as usize), plane.axes[2]) < FACING;
        averted |= !facing && distance.abs() <= search;
        if facing && distance.abs() <= search {
            // Seen from the slave face the master face turns the other way.
            polygon.reverse();
            segments.push(Segment { face: other, seen, polygon, distance });
        }
    }
    keep_nearest(&mut segments, whole);
    let covered: f64 = segments.iter().map(|s| area(&s.polygon)).sum();
    if covered < LEAST_PART * whole {
        return Some(Met { averted, ..Met::default() });
    }
    couple(mesh, &slave, &segments, own.len()).map(|(areas, masters)| Met { areas, masters, covered, averted })
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

/// Integrals of `phi_i` and of `psi_i phi_k` over the segments.
fn couple(mesh: &Mesh, slave: &Seen, segments: &[Segment], n: usize) -> Option<([f64; 4], Vec<(u32, [f64; 4])>)> {
    let (mut d, mut m, mut points) = ([0.0; 4], [[0.0; 4]; 4], Vec::new());
    for (number, segment) in segments.iter().enumerate() {
        for (x, weight) in quadrature(&segment.polygon, slave.flat.bent || segment.seen.flat.bent) {
            let phi = slave.flat.shape(x);
            for i in 0..n {
                d[i] += weight * phi[i];
                (0..n).for_each(|j| m[i][j] += weight * phi[i] * phi[j]);
            }
            points.push((number, phi, segment.seen.flat.shape(x), weight));
        }
    }
    let inverse = inverse(m, n)?;
    let mut masters: Vec<(u32, [f64; 4])> = Vec::new();
    for segment in segments {
        masters.extend(mesh.faces[segment.face as usize].nodes().iter().map(|&node| (node, [0.0; 4])));
    }
    masters.sort_unstable_by_key(|entry| entry.0);
    masters.dedup_by_key(|entry| entry.0);
    for (number, phi, other, weight) in points {
        let psi: [f64; 4] = std::array::from_fn(|i| d[i] * (0..n).map(|j| inverse[i][j] * phi[j]).sum::<f64>());
        let nodes = mesh.faces[segments[number].face as usize].nodes();
        for (&node, shape) in nodes.iter().zip(other) {
            let place = masters.partition_point(|e| e.0 < node);
            let entry = &mut masters[place].1;
            (0..n).for_each(|i| entry[i] += weight * psi[i] * shape);
        }
    }
    Some((d, masters))
}

/// Inverse of a symmetric positive definite matrix of order `n <= 4`, by Gauss and Jordan after scaling its diagonal to
/// one; `None` if it is singular.
fn inverse(m: [[f64; 4]; 4], n: usize) -> Option<[[f64; 4]; 4]> {
    let s: [f64; 4] = std::array::from_fn(|i| if i < n { 1.0 / m[i][i].sqrt() } else { 1.0 });
    let mut a: [[f64; 4]; 4] = std::array::from_fn(|i| std::array::from_fn(|j| s[i] * s[j] * m[i][j]));
    let mut b: [[f64; 4]; 4] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
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
    /// `int psi_j / D_jj`: one, and more where the node carries what a dropped neighbour would have carried. The master
    /// weights add up to its negative.
    pub share: f64,
    /// Master nodes with `-M_jk / D_jj`, then dropped slave nodes, each ascending.
    pub others: Vec<(u32, f64)>,
}

/// The rows of the slave nodes that `keep` keeps, ascending by node, and the covered area of faces without such a node,
/// which no row stands for.
///
/// On a face with dropped nodes `q` the kept ones share their functions evenly, `psi_j + sum_q psi_q / kept`: the
/// functions still add up to one, so that a constant pressure is carried everywhere (Puso & Laursen 2004; Wohlmuth 2000
/// at cross points), and the displacement of the dropped node enters the jump of those that carry for it.
pub(super) fn rows(mesh: &Mesh, slave: &[u32], met: &[Met], keep: impl Fn(u32) -> bool) -> (Vec<Row>, f64) {
    // (node, place of the other: masters first, other, weight times area)
    let mut terms: Vec<(u32, u8, u32, f64)> = Vec::new();
    let mut own: Vec<(u32, f64, f64)> = Vec::new();
    let mut lost = 0.0;
    for (&face, met) in slave.iter().zip(met).filter(|(_, met)| met.covered > 0.0) {
        let nodes = mesh.faces[face as usize].nodes();
        let kept: Vec<usize> = (0..nodes.len()).filter(|&i| keep(nodes[i])).collect();
        let dropped: Vec<usize> = (0..nodes.len()).filter(|i| !kept.contains(i)).collect();
        if kept.is_empty() {
            lost += met.covered;
        }
        let part = 1.0 / kept.len() as f64;
        let with = |values: &[f64; 4], i: usize| values[i] + part * dropped.iter().map(|&q| values[q]).sum::<f64>();
        for &i in &kept {
            own.push((nodes[i], met.areas[i], with(&met.areas, i)));
            terms.extend(met.masters.iter().map(|(k, values)| (nodes[i], 0, *k, -with(values, i))));
            terms.extend(dropped.iter().map(|&q| (nodes[i], 1, nodes[q], part * met.areas[q])));
        }
    }
    // Sorting keeps the order of the faces within a sum: the result does not depend on threads.
    own.sort_by_key(|entry| entry.0);
    terms.sort_by_key(|entry| (entry.0, entry.1, entry.2));
    let mut terms = terms.chunk_by(|a, b| a.0 == b.0).peekable();
    let rows = own.chunk_by(|a, b| a.0 == b.0).map(|own| {
        let node = own[0].0;
        let (area, all) = own.iter().fold((0.0, 0.0), |(a, b), entry| (a + entry.1, b + entry.2));
        let mine = terms.next_if(|terms| terms[0].0 == node).unwrap_or(&[]);
        let sums = mine.chunk_by(|a, b| (a.1, a.2) == (b.1, b.2));
        let mut others: Vec<(u8, u32, f64)> =
            sums.map(|sum| (sum[0].1, sum[0].2, sum.iter().map(|t| t.3).sum::<f64>() / area)).collect();
        others.retain(|(_, _, weight)| weight.abs() > ROUNDING);
        // A translation of everything must not be a jump, to the last digit.
        let sum: f64 = 1.0 + others.iter().map(|other| other.2).sum::<f64>();
        let heaviest = others.iter_mut().filter(|o| o.0 == 0).max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()));
        heaviest.into_iter().for_each(|other| other.2 -= sum);
        let others = others.into_iter().map(|(_, other, weight)| (other, weight)).collect();
        Row { node, area, share: all / area, others }
    });
    (rows.collect(), lost)
}
