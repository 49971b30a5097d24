//! Arrows over a map of a surface.

use std::collections::BTreeMap;

use super::camera::{Area, Camera, Vec3, add, dot, norm};
use super::color::INK;
use super::decor::SMALL;
use super::drawing::{Align, Drawing};
use super::font;
use super::scene::Surface;
use super::ticks::{number, round_down};

/// Pixels between neighbouring arrows, of the longest and of the shortest.
const SPACING: f64 = 44.0;
const LONGEST: f64 = 46.0;
const SHORTEST: f64 = 6.0;

/// The scale of a set of arrows.
pub(super) struct Arrows {
    /// The largest vector, > 0.
    largest: f64,
}

impl Arrows {
    /// The scale that makes the largest vector as long as arrows may be; `None` if all are zero or missing.
    pub(super) fn scaled(vectors: &[Vec3]) -> Option<Arrows> {
        let largest = vectors.iter().map(|&v| norm(v)).filter(|n| n.is_finite()).fold(0.0, f64::max);
        (largest > f64::MIN_POSITIVE).then_some(Arrows { largest })
    }

    /// The arrows of a regular grid of points of the picture within `area`, where the surface seen there has vectors
    /// that are not about zero; vertices of a surface without faces have an arrow each.
    pub(super) fn on(&self, camera: &Camera, area: Area, surface: Surface, vectors: &[Vec3]) -> Vec<[[f64; 2]; 2]> {
        let at: Vec<Vec3> = surface.points.iter().map(|&p| camera.project(p)).collect();
        // Depth and vector of what is seen at each point of the grid.
        let mut seen: BTreeMap<(usize, usize), (f64, Vec3)> = BTreeMap::new();
        for face in surface.faces {
            for k in 1..face.len() - 1 {
                let nodes = [face[0], face[k], face[k + 1]].map(|n| n as usize);
                sample(nodes.map(|n| at[n]), area, |place, depth, weights| {
                    let vector = (0..3).fold([0.0; 3], |sum, k| add(sum, weights[k], vectors[nodes[k]]));
                    let best = seen.entry(place).or_insert((depth, vector));
                    if depth > best.0 {
                        *best = (depth, vector);
                    }
                });
            }
        }
        let mut places: Vec<([f64; 2], Vec3)> =
            seen.into_iter().map(|((i, j), (_, v))| ([grid(area.left, i), grid(area.top, j)], v)).collect();
        if surface.faces.is_empty() {
            places = at.iter().zip(vectors).map(|(p, &v)| ([p[0], p[1]], v)).collect();
        }
        let factor = LONGEST / self.largest;
        let arrow = |([x, y], v): ([f64; 2], Vec3)| {
            let (dx, dy) = (0.5 * factor * dot(camera.axes[0], v), -0.5 * factor * dot(camera.axes[1], v));
            // Comparisons with NaN are false: missing vectors are left out, as are those too short to have a shaft.
            (2.0 * dx.hypot(dy) > SHORTEST).then_some([[x - dx, y - dy], [x + dx, y + dy]])
        };
        places.into_iter().filter_map(arrow).collect()
    }

    /// An arrow of round length with its value, its label above.
    pub(super) fn reference(&self, drawing: &mut Drawing, at: [f64; 2], label: &str, unit: &str) {
        let value = round_down(self.largest);
        let length = LONGEST * value / self.largest;
        let room = drawing.width as f64 - at[0] - 15.0;
        drawing.text(&font::fitting(label, SMALL, room), at, SMALL, INK, Align::Left);
        let y = at[1] + 34.0;
        haloed(drawing, [at[0], y], [at[0] + length, y]);
        let text = format!("{} {unit}", number(value));
        drawing.text(text.trim_end(), [at[0] + length + 12.0, y], SMALL, INK, Align::Left);
    }
}

/// A dark arrow in a light one, to be seen on dark and light colours.
pub(super) fn haloed(drawing: &mut Drawing, from: [f64; 2], to: [f64; 2]) {
    /// Pixels by which the halo is wider, and by which its tip is longer so that it is as wide there.
    const WIDER: f64 = 1.2;
    const LONGER: f64 = 2.6 * WIDER;
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    if length.is_nan() || length <= 1.0 {
        return;
    }
    let (ex, ey, head) = (dx / length, dy / length, (0.6 * length).min(10.0));
    let tail = [from[0] - WIDER * ex, from[1] - WIDER * ey];
    let tip = [to[0] + LONGER * ex, to[1] + LONGER * ey];
    drawing.arrow(tail, tip, 2.0 + 2.0 * WIDER, head + WIDER + LONGER, [255, 255, 255]);
    drawing.arrow(from, to, 2.0, head, INK);
}

/// The coordinate of a point of the grid that starts at `from`.
fn grid(from: f64, i: usize) -> f64 {
    from + SPACING * (i as f64 + 0.5)
}

/// Calls `f` with the number, the depth and the weights of the corners for each point of the grid in a triangle.
fn sample(corners: [Vec3; 3], area: Area, mut f: impl FnMut((usize, usize), f64, [f64; 3])) {
    let [a, b, c] = corners;
    let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if !(twice.is_finite() && twice != 0.0) {
        return;
    }
    let span = |k: usize, from: f64, to: f64| {
        let [low, high] = [a[k].min(b[k]).min(c[k]).max(from), a[k].max(b[k]).max(c[k]).min(to)];
        let [low, high] = [low, high].map(|v| (v - from) / SPACING - 0.5);
        if low <= high { low.ceil().max(0.0) as usize..(high + 1.0).floor().max(0.0) as usize } else { 0..0 }
    };
    for i in span(0, area.left, area.right) {
        for j in span(1, area.top, area.bottom) {
            let (x, y) = (grid(area.left, i) - a[0], grid(area.top, j) - a[1]);
            let wb = (x * (c[1] - a[1]) - y * (c[0] - a[0])) / twice;
            let wc = (y * (b[0] - a[0]) - x * (b[1] - a[1])) / twice;
            let wa = 1.0 - wb - wc;
            if wa.min(wb).min(wc) >= -1e-9 {
                f((i, j), wa * a[2] + wb * b[2] + wc * c[2], [wa, wb, wc]);
            }
        }
    }
}
