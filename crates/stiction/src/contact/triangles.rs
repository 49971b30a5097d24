//! A surface of triangles as an obstacle: adjacency, normals and what cannot be used.

use rustc_hash::FxHashMap;

use super::Side;
use super::stitch::joined;
use crate::Error;
pub(super) use crate::mesh::facets::BORDER;
use crate::mesh::facets::{corner_normals, normal, weighted_normal};
use crate::mesh::v3::{V3, add, cross, det, dot, norm, scale, sub};
use crate::mesh::{Bounds, Tree, ascending};

/// Degrees that count for nothing in a bend: files of single precision, and prisms of twelve sides, which bend by 30 degrees.
const BEND_ROUNDING: f64 = 0.01;

/// Triangles as a file gives them, points of equal coordinates being one.
#[derive(Debug, Clone, Default)]
pub struct RawSurface {
    /// Length.
    pub points: Vec<V3>,
    /// Counter-clockwise seen from the side the normal points to; no two corners of a triangle are the same.
    pub triangles: Vec<[u32; 3]>,
    /// The line or number of each triangle in its file, for messages; which of both is `place`.
    pub labels: Vec<u32>,
    /// `on line` or `number`.
    pub place: &'static str,
    /// Triangles that were left out because two of their corners are the same point.
    pub collapsed: usize,
    seen: FxHashMap<[u64; 3], u32>,
}

impl RawSurface {
    /// Without triangles; `place` is how messages introduce a triangle's label, `on line` or `number`.
    pub fn new(place: &'static str) -> Self {
        RawSurface { place, ..RawSurface::default() }
    }

    /// The number of a point, which is added unless it is there.
    pub fn point(&mut self, x: V3) -> u32 {
        // -0 is 0.
        let next = self.points.len() as u32;
        let number = *self.seen.entry(x.map(|c| (c + 0.0).to_bits())).or_insert(next);
        if number == next {
            self.points.push(x);
        }
        number
    }

    /// Adds a triangle unless two of its corners are the same; `label` is its line or number.
    pub fn triangle(&mut self, corners: [u32; 3], label: usize) {
        let [a, b, c] = corners;
        if a == b || b == c || c == a {
            self.collapsed += 1;
            return;
        }
        self.triangles.push(corners);
        self.labels.push(u32::try_from(label).unwrap_or(u32::MAX));
    }

    /// Frees what only merging needs.
    pub fn finish(mut self) -> Self {
        self.seen = FxHashMap::default();
        self
    }
}

/// A surface of triangles to which closest points are found.
#[derive(Debug, Clone)]
pub struct Triangles {
    pub(super) points: Vec<V3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The triangle across the edge from corner `k` to `k + 1`, or [`BORDER`].
    pub(super) across: Vec<[u32; 3]>,
    /// Whether the surface bends by more than the feature angle there.
    pub(super) sharp: Vec<[bool; 3]>,
    /// Into `smooth`: the normal of each corner, averaged over the triangles around it up to sharp edges.
    pub(super) corner: Vec<[u32; 3]>,
    pub(super) smooth: Vec<V3>,
    /// Sum of the normals around each point, weighted with the angles there (Baerentzen & Aanaes 2005).
    pub(super) around: Vec<V3>,
    pub(super) tree: Tree,
    /// Diagonal of the box around the surface; length.
    pub(super) size: f64,
    /// Which side the body is on.
    pub side: Side,
    /// How the file calls the surface.
    pub name: String,
    /// Edges that belong to one triangle only; none on a closed surface.
    pub border_edges: usize,
    /// Edges that bend by more than the feature angle.
    pub sharp_edges: usize,
    /// Volume a closed surface encloses, negative where its normals point inwards; zero for an open one.
    pub volume: f64,
    /// Triangles without area, which are left out.
    pub collapsed: usize,
    /// Corners at borders that lie on others but for the last digits, and are joined to them.
    pub stitched: usize,
}

/// What may be the same surface twice is one and the same.
impl PartialEq for Triangles {
    fn eq(&self, other: &Triangles) -> bool {
        self.points == other.points && self.triangles == other.triangles && self.side == other.side
    }
}

impl Triangles {
    /// Edges at which the surface bends by more than `feature_angle`, in degrees, are sharp; elsewhere it stands for a
    /// smooth one.
    ///
    /// # Errors
    /// No triangle at all, an edge of more than two triangles, triangles on both sides of an edge that look to opposite
    /// sides, points that are not finite.
    pub fn new(raw: RawSurface, name: &str, side: Side, feature_angle: f64) -> Result<Triangles, Error> {
        let RawSurface { points, mut triangles, labels, place, mut collapsed, .. } = raw;
        let called = |t: u32| format!("{place} {}", labels.get(t as usize).copied().unwrap_or(t + 1));
        if triangles.is_empty() {
            return Err(Error::new("", "the surface has no triangle", "give a surface with at least one"));
        }
        if let Some(t) =
            triangles.iter().position(|t| t.iter().any(|&p| !points[p as usize].iter().all(|c| c.is_finite())))
        {
            let what = format!("a corner of the triangle {} is not finite", called(t as u32));
            return Err(Error::new("", what, "check the coordinates and the scale"));
        }
        let (mut across, mut border_edges) = neighbours(&triangles, &called)?;
        let mut stitched = 0;
        if let Some(to) = joined(&points, &triangles, &border_points(&triangles, &across)) {
            let merged: Vec<[u32; 3]> = triangles.iter().map(|corners| corners.map(|p| to[p as usize])).collect();
            let is_whole = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
            let left: Vec<[u32; 3]> = merged.iter().copied().filter(is_whole).collect();
            // Sheets that meet in more than pairs, or look to opposite sides, keep their borders.
            let found = neighbours(&left, &called);
            if let Some(found) = found.ok().filter(|_| !left.is_empty()) {
                stitched = (0..).zip(&to).filter(|(p, to)| p != *to).count();
                collapsed += merged.len() - left.len();
                (triangles, (across, border_edges)) = (left, found);
            }
        }
        let normal = |t: u32| normal(&points, triangles[t as usize]);
        let bends = (feature_angle + BEND_ROUNDING).to_radians().cos();
        let is_sharp = |t: u32, other: u32| {
            let (a, b) = (normal(t), normal(other));
            // A triangle without area has no normal to bend from.
            other != BORDER && dot(a, b) < bends && a != [0.0; 3] && b != [0.0; 3]
        };
        let sharp: Vec<[bool; 3]> =
            (0..triangles.len()).map(|t| across[t].map(|other| other != BORDER && is_sharp(t as u32, other))).collect();
        let (corner, smooth) = corner_normals(&points, &triangles, &across, &sharp);
        let mut around = vec![[0.0; 3]; points.len()];
        for corners in &triangles {
            for k in 0..3 {
                let at = &mut around[corners[k] as usize];
                *at = add(*at, weighted_normal(&points, *corners, k));
            }
        }
        let closed = border_edges == 0;
        let volume = |t: &[u32; 3]| det(t.map(|p| sub(points[p as usize], points[triangles[0][0] as usize]))) / 6.0;
        let tree = Tree::new(triangles.iter().map(|t| Bounds::around(t.map(|p| points[p as usize]))).collect());
        Ok(Triangles {
            volume: if closed { triangles.iter().map(volume).sum() } else { 0.0 },
            size: Bounds::around(points.iter().copied()).diagonal(),
            sharp_edges: sharp.iter().flatten().filter(|&&s| s).count() / 2,
            points,
            triangles,
            across,
            sharp,
            corner,
            smooth,
            around,
            tree,
            side,
            name: name.to_string(),
            border_edges,
            collapsed,
            stitched,
        })
    }

    /// Whether it is closed around the body, which looks at it from within.
    pub fn is_room(&self) -> bool {
        match self.side {
            Side::Outside => self.volume < 0.0,
            Side::Inside => self.volume > 0.0,
        }
    }

    /// Corners of the triangles; length.
    pub fn points(&self) -> &[V3] {
        &self.points
    }

    /// Triangles by indices into the points.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    pub(super) fn corners(&self, t: u32) -> [V3; 3] {
        self.triangles[t as usize].map(|p| self.points[p as usize])
    }

    /// The unit normal of a triangle; zero if it has no area.
    /// Where sharp edges lie behind a triangle of a body's surface, as weights of its `corners` of at least `least` and depths:
    /// of each edge its ends or where it leaves what lies behind the triangle, no deeper than the triangle is long.
    pub(super) fn sharp_edges_behind(&self, corners: [V3; 3], least: f64) -> Vec<([f64; 3], f64)> {
        let [a, b, c] = corners;
        let (ab, ac) = (sub(b, a), sub(c, a));
        let upright = cross(ab, ac);
        let twice_area2 = dot(upright, upright);
        if twice_area2 == 0.0 {
            return Vec::new(); // nothing lies behind a line
        }
        let inwards = scale(-1.0 / twice_area2.sqrt(), upright);
        let reach = scale([ab, ac, sub(c, b)].map(norm).into_iter().fold(0.0, f64::max), inwards);
        let behind = Bounds::around(corners.into_iter().chain(corners.map(|x| add(x, reach))));
        // Linear in the place: weights of the corners, depth, and what is left of the reach.
        let place = |x: V3| {
            let (d, depth) = (sub(x, a), dot(sub(x, a), inwards));
            let (v, w) = (dot(cross(d, ac), upright) / twice_area2, dot(cross(ab, d), upright) / twice_area2);
            [1.0 - v - w, v, w, depth, norm(reach) - depth]
        };
        let mut found = Vec::new();
        for t in self.tree.meeting(&behind) {
            for k in (0..3).filter(|&k| self.sharp[t as usize][k] && self.across[t as usize][k] > t) {
                let ends = [k, (k + 1) % 3].map(|k| place(self.corners(t)[k]));
                let at =
                    |part: f64| std::array::from_fn::<f64, 5, _>(|i| ends[0][i] + part * (ends[1][i] - ends[0][i]));
                let (mut from, mut to) = (0.0f64, 1.0f64);
                for (i, (first, last)) in ends[0].into_iter().zip(ends[1]).enumerate() {
                    let bound = if i < 3 { least } else { 0.0 };
                    let crossing = (bound - first) / (last - first);
                    match (first < bound, last < bound) {
                        (true, true) => to = -1.0,
                        (true, false) => from = from.max(crossing),
                        (false, true) => to = to.min(crossing),
                        (false, false) => {}
                    }
                }
                if from <= to {
                    found.extend([at(from), at(to)].map(|[u, v, w, depth, _]| ([u, v, w], depth)));
                }
            }
        }
        found
    }

    pub(super) fn normal(&self, t: u32) -> V3 {
        normal(&self.points, self.triangles[t as usize])
    }
}

/// The points at edges of one triangle only, ascending.
fn border_points(triangles: &[[u32; 3]], across: &[[u32; 3]]) -> Vec<u32> {
    let of = |(corners, across): (&[u32; 3], &[u32; 3])| -> Vec<u32> {
        let border = (0..3).filter(|&k| across[k] == BORDER);
        border.flat_map(|k| [corners[k], corners[(k + 1) % 3]]).collect()
    };
    ascending(triangles.iter().zip(across).flat_map(of))
}

/// The triangle across each edge, and the number of edges that have none.
fn neighbours(triangles: &[[u32; 3]], called: &dyn Fn(u32) -> String) -> Result<(Vec<[u32; 3]>, usize), Error> {
    // Lower and higher point of each edge, its triangle, and three times whether it runs down, plus its number.
    let mut edges: Vec<(u32, u32, u32, u8)> = Vec::with_capacity(3 * triangles.len());
    for (t, corners) in (0..).zip(triangles) {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), t, k as u8 + if a > b { 3 } else { 0 }));
        }
    }
    edges.sort_unstable();
    let mut across = vec![[BORDER; 3]; triangles.len()];
    let mut border = 0;
    for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        match *edge {
            [_] => border += 1,
            [(_, _, t, i), (_, _, u, j)] if (i < 3) != (j < 3) => {
                across[t as usize][usize::from(i % 3)] = u;
                across[u as usize][usize::from(j % 3)] = t;
            }
            [(_, _, t, _), (_, _, u, _)] => {
                let what =
                    format!("the triangles {} and {} share an edge and look to opposite sides", called(t), called(u));
                let remedy = "orient all triangles alike (mesh tools call it unifying or recalculating normals)";
                return Err(Error::new("", what, remedy));
            }
            [_, ..] => {
                let some = edge.iter().take(4).map(|e| called(e.2)).collect::<Vec<_>>().join(", ");
                let what = format!("{} triangles share one edge, among them those {some}", edge.len());
                let remedy = "an edge has two sides: remove double triangles and inner walls, or give two surfaces";
                return Err(Error::new("", what, remedy));
            }
            [] => {}
        }
    }
    Ok((across, border))
}
