//! Arrows over a map of a surface.

use std::collections::BTreeMap;

use super::camera::{Camera, Vec3, add, area_vector, dot, norm};
use super::canvas::{Align, Canvas};
use super::color::INK;
use super::decor::SMALL;
use super::ticks::{number, round_down};

/// Pixels between neighbouring arrows, and of the longest.
const SPACING: f64 = 44.0;
const LONGEST: f64 = 46.0;

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

    /// Draws one arrow for each small square of the picture, at the vertex nearest to the middle of it.
    pub(super) fn draw(&self, canvas: &mut Canvas, camera: &Camera, points: &[Vec3], vectors: &[Vec3], front: &[bool]) {
        let mut chosen: BTreeMap<(i64, i64), (f64, usize)> = BTreeMap::new();
        for (i, &p) in points.iter().enumerate() {
            let [x, y, _] = camera.project(p);
            // Comparisons with NaN are false: missing vectors are left out.
            let long = norm(vectors[i]) > 0.03 * self.largest;
            if !(long && front[i] && x.is_finite() && y.is_finite()) {
                continue;
            }
            let cell = ((x / SPACING).floor(), (y / SPACING).floor());
            let away = (x / SPACING - cell.0 - 0.5).hypot(y / SPACING - cell.1 - 0.5);
            let best = chosen.entry((cell.0 as i64, cell.1 as i64)).or_insert((away, i));
            if away < best.0 {
                *best = (away, i);
            }
        }
        for &(_, i) in chosen.values() {
            let [x, y, _] = camera.project(points[i]);
            let factor = 0.5 * LONGEST / self.largest;
            let (dx, dy) = (factor * dot(camera.axes[0], vectors[i]), -factor * dot(camera.axes[1], vectors[i]));
            haloed(canvas, [x - dx, y - dy], [x + dx, y + dy]);
        }
    }

    /// An arrow of round length with its value, its label above.
    pub(super) fn reference(&self, canvas: &mut Canvas, at: [f64; 2], label: &str, unit: &str) {
        let value = round_down(self.largest);
        let length = LONGEST * value / self.largest;
        let room = canvas.width as f64 - at[0] - 15.0;
        canvas.text(&Canvas::fitting(label, SMALL, room), at, SMALL, INK, Align::Left);
        let y = at[1] + 34.0;
        haloed(canvas, [at[0], y], [at[0] + length, y]);
        let text = format!("{} {unit}", number(value));
        canvas.text(text.trim_end(), [at[0] + length + 12.0, y], SMALL, INK, Align::Left);
    }
}

/// A dark arrow in a light one, to be seen on dark and light colours.
fn haloed(canvas: &mut Canvas, from: [f64; 2], to: [f64; 2]) {
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
    canvas.arrow(tail, tip, 2.0 + 2.0 * WIDER, head + WIDER + LONGER, [255, 255, 255]);
    canvas.arrow(from, to, 2.0, head, INK);
}

/// Which vertices lie on the side of the surface that the observer sees; all of them if there are no faces.
pub(super) fn facing(points: &[Vec3], faces: &[&[u32]], toward: Vec3) -> Vec<bool> {
    let mut normals = vec![[0.0; 3]; points.len()];
    for face in faces {
        let area = area_vector(points, face);
        face.iter().for_each(|&n| normals[n as usize] = add(normals[n as usize], 1.0, area));
    }
    let total = normals.iter().fold([0.0; 3], |sum, &n| add(sum, 1.0, n));
    // A map may be seen from behind, as the underside of a body seen from above.
    let side = if dot(total, toward) < 0.0 { -1.0 } else { 1.0 };
    // Arrows at a grazing angle would crowd along the silhouette.
    normals.iter().map(|&n| faces.is_empty() || side * dot(n, toward) > 0.25 * norm(n)).collect()
}
