use std::sync::Arc;

use super::Triangles;
pub(super) use crate::mesh::v3::unit;
use crate::mesh::v3::{dot, norm, sub};

/// Which side of a curved obstacle the body is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    /// The body lies outside: a ball, a shaft.
    #[default]
    Outside,
    /// The body lies inside: a socket, a bore.
    Inside,
}

/// A rigid obstacle at rest. Directions need not have unit length.
#[derive(Debug, Clone, PartialEq)]
pub enum Obstacle {
    /// The half space behind the plane through `point`; `normal` points out of the obstacle, towards the body.
    Plane {
        /// A point of the plane, or of the axis, length.
        point: [f64; 3],
        /// Unit normal towards the body.
        normal: [f64; 3],
    },
    /// A sphere.
    Sphere {
        /// Its centre, length.
        center: [f64; 3],
        /// Its radius, length.
        radius: f64,
        /// Which side the body is on.
        side: Side,
    },
    /// An infinite circular cylinder around the line through `point` along `axis`.
    Cylinder {
        /// A point of the plane, or of the axis, length.
        point: [f64; 3],
        /// Unit direction of the axis.
        axis: [f64; 3],
        /// Its radius, length.
        radius: f64,
        /// Which side the body is on.
        side: Side,
    },
    /// A surface of triangles, open or closed.
    Surface(Arc<Triangles>),
}

impl Obstacle {
    /// The distance of `x` from the obstacle's surface (negative inside the obstacle) and the unit normal there, out
    /// of the obstacle. `None` where the normal is not defined: at a centre or on an axis; and beyond the border of an
    /// open surface, where nothing is met.
    pub fn distance(&self, x: [f64; 3]) -> Option<(f64, [f64; 3])> {
        let round = |from_axis: [f64; 3], radius: f64, side: Side| {
            let r = norm(from_axis);
            let normal = unit(from_axis)?;
            Some(match side {
                Side::Outside => (r - radius, normal),
                Side::Inside => (radius - r, normal.map(|c| -c)),
            })
        };
        match *self {
            Obstacle::Plane { point, normal } => {
                let n = unit(normal)?;
                Some((dot(sub(x, point), n), n))
            }
            Obstacle::Sphere { center, radius, side } => round(sub(x, center), radius, side),
            Obstacle::Cylinder { point, axis, radius, side } => {
                let a = unit(axis)?;
                let d = sub(x, point);
                let along = dot(d, a);
                round(sub(d, a.map(|c| c * along)), radius, side)
            }
            Obstacle::Surface(ref triangles) => triangles.distance(x, None),
        }
    }

    /// The same for a point of a body with this outward normal: where an obstacle is as near on several sides, the side
    /// that faces the body counts.
    pub fn distance_facing(&self, x: [f64; 3], outward: [f64; 3]) -> Option<(f64, [f64; 3])> {
        match self {
            Obstacle::Surface(triangles) => triangles.distance(x, Some(outward)),
            _ => self.distance(x),
        }
    }

    /// By how much its normals around the point that is nearest to `x` are off those of the surface that it stands for, radians: zero but for
    /// triangles.
    pub(crate) fn normal_error(&self, x: [f64; 3]) -> f64 {
        if let Obstacle::Surface(triangles) = self { triangles.normal_error(x) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_distances_and_normals_their_gradients() {
        let obstacles = [
            Obstacle::Plane { point: [0.0, 1.0, 0.0], normal: [1.0, 2.0, -2.0] },
            Obstacle::Sphere { center: [1.0, 0.0, -1.0], radius: 0.5, side: Side::Outside },
            Obstacle::Sphere { center: [1.0, 0.0, -1.0], radius: 5.0, side: Side::Inside },
            Obstacle::Cylinder { point: [0.0; 3], axis: [0.0, 3.0, 4.0], radius: 0.25, side: Side::Outside },
            Obstacle::Cylinder { point: [0.0; 3], axis: [0.0, 3.0, 4.0], radius: 9.0, side: Side::Inside },
        ];
        let x = [0.7, -0.3, 1.1];
        for obstacle in obstacles {
            let (gap, normal) = obstacle.distance(x).unwrap();
            assert!((norm(normal) - 1.0).abs() < 1e-14);
            for c in 0..3 {
                let mut moved = x;
                moved[c] += 1e-6;
                let slope = (obstacle.distance(moved).unwrap().0 - gap) / 1e-6;
                assert!((slope - normal[c]).abs() < 1e-5, "{obstacle:?}");
            }
            // One step of length `gap` against the normal lands on the surface.
            let foot = [0, 1, 2].map(|c| x[c] - gap * normal[c]);
            assert!(obstacle.distance(foot).unwrap().0.abs() < 1e-14);
        }
    }

    #[test]
    fn a_centre_has_no_normal() {
        let sphere = Obstacle::Sphere { center: [1.0; 3], radius: 1.0, side: Side::Inside };
        assert!(sphere.distance([1.0; 3]).is_none());
    }
}
