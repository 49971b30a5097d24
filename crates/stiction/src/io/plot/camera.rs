//! Where the observer stands, and small vector arithmetic.

pub(super) use crate::mesh::v3::{V3 as Vec3, cross, dot, norm};

/// `a + s b`.
pub(super) fn add(a: Vec3, s: f64, b: Vec3) -> Vec3 {
    std::array::from_fn(|k| a[k] + s * b[k])
}

/// The unit vector along `a`; zero where `a` has no direction.
pub(super) fn unit(a: Vec3) -> Vec3 {
    // Divided by its largest component first, so that squares neither overflow nor vanish.
    let largest = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return [0.0; 3];
    }
    let a = a.map(|x| x / largest);
    a.map(|x| x / norm(a))
}

/// Twice the area of a polygon along its normal (Newell), length squared.
pub(super) fn area_vector(points: &[Vec3], face: &[u32]) -> Vec3 {
    let first = points[face[0] as usize];
    let edge = |i: usize| add(points[face[i] as usize], -1.0, first);
    (1..face.len() - 1).fold([0.0; 3], |sum, i| add(sum, 1.0, cross(edge(i), edge(i + 1))))
}

/// Smallest and largest coordinates of the finite points, length; `None` without any.
pub(super) fn bounds(points: impl IntoIterator<Item = Vec3>) -> Option<[Vec3; 2]> {
    points.into_iter().filter(|p| p.iter().all(|x| x.is_finite())).fold(None, |bounds, p| {
        let [low, high] = bounds.unwrap_or([p, p]);
        Some([std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))])
    })
}

/// A rectangle of the picture, pixels from its top left corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Area {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Area {
    /// With room for the width of lines along its edges.
    pub(super) fn with_lines(self) -> Area {
        const ROOM: f64 = 4.0;
        let Area { left, top, right, bottom } = self;
        Area { left: left - ROOM, top: top - ROOM, right: right + ROOM, bottom: bottom + ROOM }
    }
}

/// A parallel projection.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    /// Unit vectors: to the right of the picture, up, and towards the observer.
    pub axes: [Vec3; 3],
    /// Pixels a length.
    pub scale: f64,
    /// The point (in `axes`) shown at `center`.
    middle: Vec3,
    /// Pixels.
    center: [f64; 2],
}

impl Camera {
    /// The axes of an observer in direction `toward` who holds z upright.
    pub(super) fn upright(toward: Vec3) -> [Vec3; 3] {
        let toward = unit(toward);
        let across = cross([0.0, 0.0, 1.0], toward);
        // Seen from straight above there is no upright z; then y points up.
        let right = if norm(across) > 1e-6 { unit(across) } else { [1.0, 0.0, 0.0] };
        [right, cross(toward, right), toward]
    }

    /// A diagonal view on the larger sides of a box of the given size.
    pub(super) fn diagonal(size: Vec3) -> Vec3 {
        if size[0] >= size[1] { [0.5, -1.0, 0.55] } else { [1.0, -0.5, 0.55] }
    }

    /// Fits the points into an area of the picture.
    pub(super) fn fit(axes: [Vec3; 3], points: impl IntoIterator<Item = Vec3>, area: Area) -> Camera {
        let turned = points.into_iter().map(|p| axes.map(|e| dot(e, p)));
        let [low, high] = bounds(turned).unwrap_or([[0.0; 3]; 2]);
        let (width, height) = (area.right - area.left, area.bottom - area.top);
        let scale = (width / (high[0] - low[0])).min(height / (high[1] - low[1]));
        Camera {
            axes,
            // A single point fits at any scale.
            scale: if scale.is_finite() { scale } else { 1.0 },
            middle: std::array::from_fn(|k| 0.5 * (low[k] + high[k])),
            center: [0.5 * (area.left + area.right), 0.5 * (area.top + area.bottom)],
        }
    }

    /// Picture coordinates and depth of a point, pixels.
    pub(super) fn project(&self, p: Vec3) -> Vec3 {
        let at = |k: usize| self.scale * (dot(self.axes[k], p) - self.middle[k]);
        [self.center[0] + at(0), self.center[1] - at(1), at(2)]
    }

    /// Pixel (across for `axis` 0, down for 1) at which the coordinate along that axis is `value`, length.
    pub(super) fn place(&self, axis: usize, value: f64) -> f64 {
        let sign = if axis == 0 { 1.0 } else { -1.0 };
        self.center[axis] + sign * self.scale * (value - self.middle[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_right_handed_with_z_up_and_nearer_is_deeper() {
        for size in [[3.0, 1.0, 1.0], [1.0, 3.0, 1.0]] {
            let [right, up, toward] = Camera::upright(Camera::diagonal(size));
            assert!(norm(add(cross(right, up), -1.0, toward)) < 1e-12);
            assert!(up[2] > 0.5 && right[2].abs() < 1e-12);
            let area = Area { left: 0.0, top: 0.0, right: 100.0, bottom: 100.0 };
            let camera = Camera::fit([right, up, toward], [[0.0; 3], size], area);
            assert!(camera.project([0.0, 0.0, 1.0])[1] < camera.project([0.0; 3])[1]);
            assert!(camera.project(toward)[2] > camera.project([0.0; 3])[2]);
        }
        assert_eq!(Camera::upright([0.0, 0.0, 2.0])[1], [0.0, 1.0, 0.0]);
    }

    #[test]
    fn points_without_extent_are_centred() {
        let area = Area { left: 0.0, top: 0.0, right: 100.0, bottom: 50.0 };
        let camera = Camera::fit(Camera::upright([0.0, 0.0, 1.0]), [[7.0, 8.0, 9.0], [f64::NAN; 3]], area);
        assert_eq!(camera.project([7.0, 8.0, 9.0]), [50.0, 25.0, 0.0]);
    }
}
