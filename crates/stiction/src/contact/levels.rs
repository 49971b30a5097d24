//! Parts of a counterpart that lie beside one another on different levels.

use crate::mesh::v3::{V3, dot, sub};

/// Levels that are closer than this part of a face's size are one: elastic strains close it.
const STRAINED: f64 = 1e-3;

/// A part of a surface: a point of it and its unit normal.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Level {
    pub point: V3,
    pub normal: V3,
}

impl Level {
    /// Whether this part lies beyond a step down from `upper`: behind the plane of that part, which lies in front of its own. Parts of
    /// one curved or inclined surface are each behind the plane of the other one, or in it. `size` is the length of a face.
    pub(super) fn is_step_down_from(&self, upper: &Level, size: f64) -> bool {
        let down = sub(upper.point, self.point);
        dot(down, upper.normal).min(dot(down, self.normal)) > STRAINED * size
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::v3::unit;

    #[test]
    fn a_step_is_one_at_any_inclination_and_a_bend_is_none() {
        let level = |point: V3, normal: V3| Level { point, normal: unit(normal).unwrap() };
        for tilt in [0.0, 0.3, -0.3] {
            let normal = [-tilt, 0.0, 1.0];
            let at = |x: f64, down: f64| level([x, 0.0, tilt * x - down], normal);
            assert!(at(1.0, 0.01).is_step_down_from(&at(-1.0, 0.0), 1.0));
            assert!(!at(-1.0, 0.0).is_step_down_from(&at(1.0, 0.01), 1.0));
            assert!(!at(1.0, 0.0).is_step_down_from(&at(-1.0, 0.0), 1.0));
        }
        // On a cylinder of radius 5, outside and inside.
        let on_cylinder = |angle: f64, sign: f64| {
            let (sine, cosine) = angle.sin_cos();
            level([5.0 * sine, 0.0, sign * 5.0 * cosine], [sign * sine, 0.0, cosine])
        };
        for sign in [1.0, -1.0] {
            let [a, b] = [-0.05, 0.15].map(|angle| on_cylinder(angle, sign));
            assert!(!a.is_step_down_from(&b, 1.0) && !b.is_step_down_from(&a, 1.0));
        }
    }
}
