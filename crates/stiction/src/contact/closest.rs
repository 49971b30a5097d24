//! Distance and normal of a surface of triangles.
//!
//! The sign follows from pseudonormals weighted with angles (Baerentzen & Aanaes 2005). Up to edges that bend by more than
//! the feature angle the triangles stand for a smooth surface: normals are interpolated, and the bulge over a triangle is
//! that of a surface of second degree, so that a ball of triangles errs by the fourth order of their size at contact.

use super::Side;
use super::obstacle::unit;
use super::skin::crossing;
use super::triangles::{BORDER, Triangles};
use crate::mesh::v3::{V3, add, cross, dot, norm, scale, sub};
use crate::mesh::weights_on_triangle;

/// Within this part of the surface's diagonal from a sharp edge the normal turns from one side to the other, as over a
/// fillet; the gap stays that of the sharp edge.
const FILLET: f64 = 1e-3;
/// What lies this part of the diagonal beside the border still looks at the surface.
const BESIDE: f64 = 1e-7;
/// A triangle faces the body if the cosine between its normal and the outward normal of the body is less than minus this.
const FACING: f64 = 0.05;
/// A triangle lies face to face with the body if that cosine is less than minus this: within 25 degrees.
const PARALLEL: f64 = 0.9;
/// Triangles whose normals have a larger cosine are one flat face.
const COPLANAR: f64 = 0.999;
/// Distances below this part of the diagonal are rounding.
const ROUNDING: f64 = 1e-14;
/// What lies this part of the diagonal beside an edge lies on it: coordinates of meshes and surfaces are rounded, and the last
/// digit must not say which of the sides gives the normal.
const ON_EDGE: f64 = 1e-6;

/// What the closest point of the surface lies on.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Feature {
    Face,
    /// From corner `k` to `k + 1`.
    Edge(usize),
    Corner(usize),
}

impl Triangles {
    /// Signed distance of `x` from the surface, positive on the body's side, and the unit normal towards the body;
    /// `None` beyond the border of an open surface, where there is nothing to meet.
    ///
    /// Of triangles as near as others those count that face a body with the outward normal `facing`: in a corner a floor
    /// meets the floor. Where only a triangle that looks away is near, that is the answer. `None` also beside a sharp edge of a
    /// triangle that lies face to face with the body.
    pub(super) fn distance(&self, x: V3, facing: Option<V3>) -> Option<(f64, V3)> {
        let any = self.nearest(x, |_| true);
        let Some(facing) = facing else { return any };
        let sign = if self.side == Side::Outside { 1.0 } else { -1.0 };
        if let Some(found) = self.face_to_face(x, facing, sign) {
            return found;
        }
        match (any, self.nearest(x, |t| sign * dot(self.normal(t), facing) < -FACING)) {
            // Beside the surface a feature that is not the nearest tells no side.
            (Some((far, _)), Some((near, _))) if far > 0.0 && near < 0.0 => any,
            (None, Some((near, _))) if near < 0.0 => None,
            (_, Some(found)) => Some(found),
            _ => any,
        }
    }

    /// At a sharp edge of a triangle that lies face to face with the body: the distance from that triangle and
    /// its own normal, up to a fillet beside the edge; the mean of its two sides would push the body along the face, and
    /// what lies farther beside it slides past the edge. None where no such triangle is nearest, or no such edge is near.
    fn face_to_face(&self, x: V3, facing: V3, sign: f64) -> Option<Option<(f64, V3)>> {
        let cosine = |t: u32| sign * dot(self.normal(t), facing);
        let (parallel, looks) = (|t: u32| cosine(t) < -PARALLEL, |t: u32| cosine(t) < -FACING);
        let weights = |t: u32| weights_on_triangle(x, self.corners(t));
        let distance2 = |t: u32| {
            let d = self.offset(x, t, weights(t));
            dot(d, d)
        };
        let (_, least) = self.tree.nearest(x, f64::INFINITY, distance2)?;
        let (least, fillet) = (least.sqrt() + 2.0 * ROUNDING * self.size, FILLET * self.size);
        let reach = least.max(fillet).powi(2);
        let (t, far) = self.tree.nearest(x, reach, |t| if parallel(t) { distance2(t) } else { f64::INFINITY })?;
        let (apart, plane, w) = (self.offset(x, t, weights(t)), self.normal(t), self.onto_edges(t, weights(t)));
        let height = dot(apart, plane);
        let beside = norm(sub(apart, scale(height, plane)));
        let is_over = beside <= ON_EDGE * self.size;
        // One that is not the nearest of all is met where it would be but for a small overlap.
        if far.sqrt() > least && !is_over {
            return None;
        }
        let feature = feature(w);
        let near = |k: &usize| self.sharp[t as usize][*k] && self.off_edge(t, *k, w) < fillet;
        let near: Vec<Feature> = (0..3).filter(near).map(Feature::Edge).collect();
        if !self.is_sharp(t, feature) && near.is_empty() {
            return None;
        }
        // On a ridge both flanks look at the body, and in a corner the closest point says little of what lies inside.
        let flank = |other: u32| looks(other) && dot(self.normal(other), self.normal(t)) <= COPLANAR;
        let is_ridge = near.into_iter().chain([feature]).any(|feature| self.any_around(t, feature, flank));
        let is_behind = || dot(apart, self.pseudonormal(t, feature)) * sign < 0.0 && feature != Feature::Face;
        if is_ridge || !is_over && is_behind() {
            return None;
        }
        if beside > fillet {
            return Some(None);
        }
        let (distance, normal) = (height - self.bulge(t, w), self.smooth_normal(t, w));
        Some(Some(match self.side {
            Side::Outside => (distance, normal),
            Side::Inside => (0.0 - distance, normal.map(|c| 0.0 - c)),
        }))
    }

    /// Whether a triangle of an open surface turns its back to a body at `x` with the outward normal `outward`, touching it or right
    /// before it, nearer than the `distance` of what the body meets.
    pub(super) fn turns_its_back(&self, x: V3, outward: V3, distance: f64) -> bool {
        let sign = if self.side == Side::Outside { 1.0 } else { -1.0 };
        let apart = |t: u32| self.offset(x, t, weights_on_triangle(x, self.corners(t)));
        let is_ahead = |d: V3| norm(d) <= ROUNDING * self.size || -dot(d, outward) > PARALLEL * norm(d);
        let distance2 = |t: u32| {
            let d = apart(t);
            let is_back = sign * dot(self.normal(t), outward) > PARALLEL && is_ahead(d);
            if is_back { dot(d, d) } else { f64::INFINITY }
        };
        let reach = distance - ROUNDING * self.size;
        self.border_edges > 0 && reach > 0.0 && self.tree.nearest(x, reach * reach, distance2).is_some()
    }

    /// Whether what moves from `x` by `way` passes from the body's side of the surface to the other, and not back.
    pub(super) fn is_entered(&self, x: V3, way: V3) -> bool {
        let sign = if self.side == Side::Outside { 1.0 } else { -1.0 };
        let of = |t: u32| {
            let (share, _) = crossing(self.corners(t), x, way)?;
            (0.0..=1.0).contains(&share).then(|| (share, sign * dot(self.normal(t), way) < 0.0))
        };
        let crossings = self.tree.along(x, way).into_iter().filter_map(of);
        crossings.max_by(|a, b| a.0.total_cmp(&b.0)).is_some_and(|(_, inwards)| inwards)
    }

    /// The same for the triangles with `allowed`.
    ///
    /// The sign is that of the pseudonormal at the closest point: of the face, the mean of the two at an edge, weighted
    /// with the angles at a corner (Baerentzen & Aanaes 2005). The normal is that of a smooth surface up to sharp edges;
    /// from these it points to `x`, close to them it turns gradually.
    fn nearest(&self, x: V3, allowed: impl Fn(u32) -> bool) -> Option<(f64, V3)> {
        let weights = |t: u32| weights_on_triangle(x, self.corners(t));
        let distance2 = |t: u32| {
            let d = self.offset(x, t, weights(t));
            if allowed(t) { dot(d, d) } else { f64::INFINITY }
        };
        let (t, _) = self.tree.nearest(x, f64::INFINITY, distance2)?;
        let w = weights(t);
        let apart = self.offset(x, t, w);
        let feature = feature(w);
        let pseudo = self.pseudonormal(t, feature);
        if self.on_border(t, feature) && self.beside(t, feature, apart) {
            return None;
        }
        let length = norm(apart);
        let length = if length <= ROUNDING * self.size { 0.0 } else { length };
        let sign = if dot(apart, pseudo) < 0.0 { -1.0 } else { 1.0 };
        let normal = self.normal_at(t, self.onto_edges(t, w), scale(sign, apart))?;
        let distance = sign * length - self.bulge(t, w);
        Some(match self.side {
            Side::Outside => (distance, normal),
            Side::Inside => (0.0 - distance, normal.map(|c| 0.0 - c)),
        })
    }

    /// By how much normals are off those of a smooth surface around the point that is nearest to `x`, radians: the bulge of second degree leaves
    /// them the cube of the angle between the triangle and the surface at its corners. A pin in a bore of 24 triangles around climbs 0.3
    /// mrad where that is 2.2.
    pub(super) fn normal_error(&self, x: V3) -> f64 {
        let distance2 = |t: u32| {
            let d = self.offset(x, t, weights_on_triangle(x, self.corners(t)));
            dot(d, d)
        };
        let Some((t, _)) = self.tree.nearest(x, f64::INFINITY, distance2) else { return 0.0 };
        let off = |k: usize| norm(cross(self.normal(t), self.smooth[self.corner[t as usize][k] as usize]));
        (0..3).map(off).fold(0.0, f64::max).powi(3)
    }

    /// From the point of a triangle with the weights `w` to `x`.
    fn offset(&self, x: V3, t: u32, w: [f64; 3]) -> V3 {
        let [a, b, c] = self.corners(t);
        // From the corner with the largest weight, so that it is exact at a corner.
        let from = |p: V3, q: V3, v: f64, r: V3, w: f64| sub(sub(x, p), add(scale(v, sub(q, p)), scale(w, sub(r, p))));
        match w {
            [u, v, w] if u >= v && u >= w => from(a, b, v, c, w),
            [u, v, w] if v >= w => from(b, a, u, c, w),
            [u, v, _] => from(c, a, u, b, v),
        }
    }

    /// How far the smooth surface that the triangles stand for lies above a point of one: half the mean distance of the
    /// tangent planes of its corners, which is exact for surfaces of second degree (as the projections of Boubekeur &
    /// Alexa, Phong tessellation, 2008). Zero on a flat one.
    fn bulge(&self, t: u32, w: [f64; 3]) -> f64 {
        let (corners, number) = (self.corners(t), self.corner[t as usize]);
        let above = |k: usize| {
            let plane = self.smooth[number[k] as usize];
            w[k] * dot(self.offset(corners[k], t, w), plane)
        };
        0.5 * (above(0) + above(1) + above(2))
    }

    /// The weights of a point of a triangle; where it lies on an edge or a corner but for [`ON_EDGE`], those there.
    fn onto_edges(&self, t: u32, w: [f64; 3]) -> [f64; 3] {
        let least = ON_EDGE * self.size;
        let mut on = w;
        for k in 0..3 {
            if self.off_edge(t, k, w) <= least {
                on[(k + 2) % 3] = 0.0;
            }
        }
        let sum: f64 = on.iter().sum();
        if sum > 0.0 { on.map(|w| w / sum) } else { w }
    }

    /// The unit normal at the closest point; `away` leads from it to the point or, inside, the other way.
    fn normal_at(&self, t: u32, w: [f64; 3], away: V3) -> Option<V3> {
        let feature = feature(w);
        let sharp = self.is_sharp(t, feature);
        let smooth = self.smooth_normal(t, w);
        let fillet = FILLET * self.size;
        if sharp {
            let pseudo = match feature {
                Feature::Edge(k) => self.along_edge(t, k, w[(k + 1) % 3], fillet),
                _ => unit(self.pseudonormal(t, feature))?,
            };
            return unit(add(away, scale(fillet, pseudo))).or(Some(pseudo));
        }
        // Over a face: the nearer a sharp edge, the more of its normal.
        let near = (0..3).filter(|&k| self.sharp[t as usize][k]).map(|k| (self.off_edge(t, k, w), k));
        match near.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((distance, k)) if distance < fillet => {
                let edge = self.along_edge(t, k, self.share_along(t, k, w), fillet);
                let own = scale(norm(away) + distance, smooth);
                unit(add(own, scale(fillet - distance, edge)))
            }
            _ => Some(smooth),
        }
    }

    /// The normal interpolated from those of the corners; that of the triangle where they cancel.
    fn smooth_normal(&self, t: u32, w: [f64; 3]) -> V3 {
        let corner = self.corner[t as usize];
        let sum = (0..3).fold([0.0; 3], |sum, k| add(sum, scale(w[k], self.smooth[corner[k] as usize])));
        unit(sum).unwrap_or_else(|| self.normal(t))
    }

    /// Of any length.
    fn pseudonormal(&self, t: u32, feature: Feature) -> V3 {
        match feature {
            Feature::Face => self.normal(t),
            Feature::Edge(k) => match self.across[t as usize][k] {
                BORDER => self.normal(t),
                other => add(self.normal(t), self.normal(other)),
            },
            Feature::Corner(k) => self.around[self.triangles[t as usize][k] as usize],
        }
    }

    /// The unit normal of a sharp edge, close to its ends that of the corners; `part` of the way along it.
    fn along_edge(&self, t: u32, k: usize, part: f64, fillet: f64) -> V3 {
        let corners = self.corners(t);
        let length = norm(sub(corners[(k + 1) % 3], corners[k]));
        let own = unit(self.pseudonormal(t, Feature::Edge(k))).unwrap_or_else(|| self.normal(t));
        let (end, from_end) = if part < 0.5 { (k, part * length) } else { ((k + 1) % 3, (1.0 - part) * length) };
        let part = (from_end / fillet).min(1.0);
        let corner = unit(self.pseudonormal(t, Feature::Corner(end))).unwrap_or(own);
        unit(add(scale(part, own), scale(1.0 - part, corner))).unwrap_or(own)
    }

    /// Distance of a point of the triangle from its edge `k`.
    fn off_edge(&self, t: u32, k: usize, w: [f64; 3]) -> f64 {
        let corners = self.corners(t);
        let d = sub(corners[(k + 2) % 3], corners[k]);
        let e = unit(sub(corners[(k + 1) % 3], corners[k])).unwrap_or([0.0; 3]);
        w[(k + 2) % 3] * norm(sub(d, scale(dot(d, e), e)))
    }

    /// How far along edge `k` the foot of a point of the triangle lies, 0 to 1.
    fn share_along(&self, t: u32, k: usize, w: [f64; 3]) -> f64 {
        let corners = self.corners(t);
        let (d, e) = (sub(corners[(k + 2) % 3], corners[k]), sub(corners[(k + 1) % 3], corners[k]));
        (w[(k + 1) % 3] + w[(k + 2) % 3] * dot(d, e) / dot(e, e).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
    }

    /// Whether a sharp edge is there.
    fn is_sharp(&self, t: u32, feature: Feature) -> bool {
        match feature {
            Feature::Face => false,
            Feature::Edge(k) => self.sharp[t as usize][k],
            Feature::Corner(k) => self.fan(t, k, |triangle, edge| self.sharp[triangle as usize][edge]),
        }
    }

    fn on_border(&self, t: u32, feature: Feature) -> bool {
        match feature {
            Feature::Face => false,
            Feature::Edge(k) => self.across[t as usize][k] == BORDER,
            Feature::Corner(k) => self.fan(t, k, |triangle, edge| self.across[triangle as usize][edge] == BORDER),
        }
    }

    /// Whether a point whose closest point lies on the border is off the surface and not just above or below it.
    fn beside(&self, t: u32, feature: Feature, apart: V3) -> bool {
        let normal = match feature {
            Feature::Edge(_) | Feature::Face => self.normal(t),
            Feature::Corner(_) => unit(self.pseudonormal(t, feature)).unwrap_or_else(|| self.normal(t)),
        };
        norm(sub(apart, scale(dot(apart, normal), normal))) > BESIDE * self.size + BESIDE * norm(apart)
    }

    /// Whether `is` holds for some triangle at a feature of a triangle.
    fn any_around(&self, t: u32, feature: Feature, is: impl Fn(u32) -> bool) -> bool {
        match feature {
            Feature::Face => false,
            Feature::Edge(k) => self.across[t as usize][k] != BORDER && is(self.across[t as usize][k]),
            Feature::Corner(k) => self.fan(t, k, |triangle, _| is(triangle)),
        }
    }

    /// Whether `is` holds for some edge at corner `k` of a triangle, over all triangles reached around it.
    fn fan(&self, t: u32, k: usize, is: impl Fn(u32, usize) -> bool) -> bool {
        let point = self.triangles[t as usize][k];
        let corner_of = |t: u32| self.triangles[t as usize].iter().position(|&p| p == point);
        // Once around one way, and from the start the other way where a border ends it.
        for backwards in [false, true] {
            let mut at = t;
            while let Some(k) = corner_of(at) {
                let (leaving, other) = if backwards { ((k + 2) % 3, k) } else { (k, (k + 2) % 3) };
                if is(at, leaving) || is(at, other) {
                    return true;
                }
                at = self.across[at as usize][leaving];
                if at == t {
                    return false;
                }
                if at == BORDER {
                    break;
                }
            }
        }
        false
    }
}

fn feature(w: [f64; 3]) -> Feature {
    match w.map(|w| w != 0.0) {
        [true, false, false] => Feature::Corner(0),
        [false, true, false] => Feature::Corner(1),
        [false, false, true] => Feature::Corner(2),
        [true, true, false] => Feature::Edge(0),
        [false, true, true] => Feature::Edge(1),
        [true, false, true] => Feature::Edge(2),
        _ => Feature::Face,
    }
}
