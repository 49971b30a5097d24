//! The directions along which the components of prescribed displacements count.

use crate::mesh::v3::{V3, cross, dot, norm, scale, sub};

/// A radius below this part of the distance from the given point is none: it has no direction.
const ON_AXIS: f64 = 1e-9;

/// Three orthonormal directions at each place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Axes {
    /// Along x, y, z.
    #[default]
    Global,
    /// The same ones everywhere.
    Turned([V3; 3]),
    /// Radial, tangential and axial, right-handed in this order, about the line through `point` along the unit vector `axis`.
    Cylinder {
        /// A point of the line, length.
        point: V3,
        /// Unit vector along it.
        axis: V3,
    },
}

impl Axes {
    /// Direction `c` (0 to 2) at the place `x`; `None` where it is not determined: the first two of a cylinder on its axis.
    ///
    /// # Panics
    /// If `c` is larger than 2.
    pub fn direction(&self, c: usize, x: V3) -> Option<V3> {
        match self {
            Axes::Global => Some([0, 1, 2].map(|k| f64::from(u8::from(k == c)))),
            Axes::Turned(axes) => Some(axes[c]),
            Axes::Cylinder { axis, .. } if c == 2 => Some(*axis),
            Axes::Cylinder { point, axis } => {
                let from = sub(x, *point);
                let out = sub(from, scale(dot(from, *axis), *axis));
                let radius = norm(out);
                if radius.is_nan() || radius <= ON_AXIS * norm(from) {
                    return None;
                }
                let radial = scale(1.0 / radius, out);
                Some(if c == 0 { radial } else { cross(*axis, radial) })
            }
        }
    }
}
