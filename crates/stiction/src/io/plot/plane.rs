//! The plane of a flat map and its axes.

use super::camera::{self, Area, Camera, Vec3, cross, dot};
use super::color::INK;
use super::decor::{BODY, SMALL, with_unit};
use super::drawing::{Align, Drawing};
use super::ticks::{number, ticks};

/// The plane of a flat map.
pub(super) struct Plane {
    /// To the right, up, towards the observer.
    pub axes: [Vec3; 3],
    names: [&'static str; 2],
    /// A map of x, y and z keeps their values; on an oblique plane lengths count from the surface's corner.
    absolute: bool,
    /// What the reader must know of the view; may be empty.
    pub note: String,
}

impl Plane {
    /// The plane across `normal`, a unit vector.
    pub(super) fn along(normal: Vec3) -> Plane {
        /// Cosine of 10 degrees: within that the map is easier to read in the axes of the model.
        const ALIGNED: f64 = 0.985;
        const X: Vec3 = [1.0, 0.0, 0.0];
        const Y: Vec3 = [0.0, 1.0, 0.0];
        const Z: Vec3 = [0.0, 0.0, 1.0];
        let aligned = [(Z, X, Y, ["x", "y"]), (Y, X, Z, ["x", "z"]), (X, Y, Z, ["y", "z"])];
        for (along, right, up, names) in aligned {
            if dot(normal, along).abs() >= ALIGNED {
                let axes = [right, up, cross(right, up)];
                return Plane { axes, names, absolute: true, note: String::new() };
            }
        }
        let [a, b, c] = normal.map(|x| number((x * 100.0).round() / 100.0));
        let note = format!("seen along the normal ({a}, {b}, {c})");
        Plane { axes: Camera::upright(normal), names: ["s", "t"], absolute: false, note }
    }

    /// Least and largest coordinates along both axes, length.
    pub(super) fn bounds(&self, points: &[Vec3]) -> [[f64; 2]; 2] {
        let turned = points.iter().map(|&p| self.axes.map(|e| dot(e, p)));
        let [low, high] = camera::bounds(turned).unwrap_or([[0.0; 3]; 2]);
        [[low[0], high[0]], [low[1], high[1]]]
    }
}

/// The frame around what is shown.
pub(super) fn frame(camera: &Camera, extent: [[f64; 2]; 2]) -> Area {
    const AROUND: f64 = 10.0;
    let [left, right] = extent[0].map(|v| camera.place(0, v));
    let [bottom, top] = extent[1].map(|v| camera.place(1, v));
    Area { left: left - AROUND, top: top - AROUND, right: right + AROUND, bottom: bottom + AROUND }
}

/// A frame around the surface with marks in units of length.
pub(super) fn axes(drawing: &mut Drawing, camera: &Camera, plane: &Plane, extent: [[f64; 2]; 2], unit_label: &str) {
    let Area { left, top, right, bottom } = frame(camera, extent);
    drawing.frame([left, top], [right, bottom], 1.0, INK);
    let lengths = [right - left, bottom - top];
    for axis in 0..2 {
        let zero = if plane.absolute { 0.0 } else { extent[axis][0] };
        let [low, high] = extent[axis].map(|v| v - zero);
        let ticks = ticks(low, high, (lengths[axis] / [110.0, 80.0][axis]).clamp(2.0, 9.0) as usize);
        let label = with_unit(plane.names[axis], ticks.exponent, unit_label);
        for (value, text) in ticks.marks {
            let at = camera.place(axis, value + zero);
            if axis == 0 {
                drawing.line(vec![[at, bottom], [at, bottom + 8.0]], 1.0, INK);
                drawing.text(&text, [at, bottom + 24.0], SMALL, INK, Align::Center);
            } else {
                drawing.line(vec![[left - 8.0, at], [left, at]], 1.0, INK);
                drawing.text(&text, [left - 14.0, at], SMALL, INK, Align::Right);
            }
        }
        let (at, align) = if axis == 0 {
            ([0.5 * (left + right), bottom + 58.0], Align::Center)
        } else {
            ([left, top - 20.0], Align::Left)
        };
        drawing.text(&label, at, BODY, INK, align);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_keep_the_axes_of_the_model_where_they_can() {
        let names = |normal| Plane::along(normal).names;
        assert_eq!(names([0.0, 0.0, -1.0]), ["x", "y"]);
        assert_eq!(names([0.0, 0.99, 0.1]), ["x", "z"]);
        assert_eq!(names([-1.0, 0.0, 0.0]), ["y", "z"]);
        let oblique = Plane::along([0.6, 0.0, 0.8]);
        assert!(oblique.names == ["s", "t"] && oblique.note.contains("(0.6, 0, 0.8)"));
    }
}
