//! A surface in a box with axes on three sides, as a drawing: few faces, from back to front.

use super::camera::{Area, Camera, Vec3, add, area_vector, dot, unit};
use super::color::{INK, Rgb, range_of, viridis};
use super::decor::{self, BODY, SMALL, with_unit};
use super::drawing::{Align, Drawing};
use super::scene::Surface;
use super::ticks::ticks;
use crate::Error;

/// One of the three axes of a [`SpacePlot`].
#[derive(Debug, Clone, Copy)]
pub struct Axis<'a> {
    /// Text at the axis.
    pub label: &'a str,
    /// Unit of the numbers; may be empty.
    pub unit_label: &'a str,
    /// What the box shows, `low < high`.
    pub low: f64,
    /// The largest value.
    pub high: f64,
    /// Length of the box along this axis; only its ratio to the others matters.
    pub length: f64,
}

/// What colours the faces.
#[derive(Debug, Clone, Copy)]
pub enum FaceColors<'a> {
    /// One colour, red, green and blue.
    Plain([u8; 3]),
    /// A finite number a point: the colour of a face is that of its mean on the scale of all.
    Values(&'a [f64]),
}

/// What a picture of a surface in a box shows.
#[derive(Debug, Clone, Copy)]
pub struct SpacePlot<'a> {
    /// Coordinates in the units of the axes.
    pub points: &'a [[f64; 3]],
    /// Points of each face, three or more.
    pub faces: &'a [&'a [u32]],
    /// Colours of the faces.
    pub colors: FaceColors<'a>,
    /// The axes.
    pub axes: [Axis<'a>; 3],
    /// Heading of the picture.
    pub title: &'a str,
    /// Second line of the heading.
    pub subtitle: &'a str,
}

const WALL: Rgb = [246, 246, 246];
const GRID: Rgb = [222, 222, 222];
const EDGE: Rgb = [70, 70, 70];
/// Where the observer stands: in front, to the right, above.
const TOWARD: Vec3 = [0.75, -1.0, 0.62];

/// Draws the picture. Faces are sorted by the depth of their centres, which suits small faces of surfaces that do not
/// pass through each other.
///
/// # Errors
/// If a face has fewer than three points or one that does not exist.
pub fn space(plot: &SpacePlot) -> Result<Drawing, Error> {
    Surface { points: plot.points, faces: plot.faces }.validate()?;
    let mut drawing = Drawing::new(1400, 860);
    let frame = Box3::new(plot.axes);
    frame.walls(&mut drawing);
    let placed: Vec<Vec3> = plot.points.iter().map(|&p| frame.place(p)).collect();
    faces(&mut drawing, plot, &frame, &placed);
    for axis in 0..3 {
        frame.axis(&mut drawing, axis);
    }
    decor::heading(&mut drawing, plot.title, plot.subtitle);
    Ok(drawing)
}

fn faces(drawing: &mut Drawing, plot: &SpacePlot, frame: &Box3, placed: &[Vec3]) {
    let toward = frame.camera.axes[2];
    let lamp = unit(add(toward, 0.7, frame.camera.axes[1]));
    let range = match plot.colors {
        FaceColors::Values(values) => range_of(values),
        FaceColors::Plain(_) => [0.0, 1.0],
    };
    let depth = |face: &[u32]| face.iter().map(|&n| dot(toward, placed[n as usize])).sum::<f64>() / face.len() as f64;
    let drawable = |face: &&&[u32]| face.iter().all(|&n| placed[n as usize].iter().all(|x| x.is_finite()));
    let mut order: Vec<(f64, &[u32])> = plot.faces.iter().filter(drawable).map(|face| (depth(face), *face)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, face) in order {
        let normal = unit(area_vector(placed, face));
        let light = 0.75 + 0.25 * dot(normal, lamp).abs();
        let color = match plot.colors {
            FaceColors::Plain(color) => color,
            FaceColors::Values(values) => {
                let mean = face.iter().map(|&n| values[n as usize]).sum::<f64>() / face.len() as f64;
                viridis((mean - range[0]) / (range[1] - range[0]))
            }
        };
        let corners = face.iter().map(|&n| frame.pixel(placed[n as usize])).collect();
        drawing.polygon(corners, color.map(|c| (f64::from(c) * light) as u8), Some(EDGE));
    }
}

/// The box of the axes, its corner `low` at the origin of the scene.
struct Box3<'a> {
    axes: [Axis<'a>; 3],
    size: Vec3,
    camera: Camera,
}

impl<'a> Box3<'a> {
    fn new(axes: [Axis<'a>; 3]) -> Self {
        let size = axes.map(|a| a.length);
        let area = Area { left: 150.0, top: 130.0, right: 1320.0, bottom: 740.0 };
        let corners = (0..8).map(|c| [0, 1, 2].map(|k| if c >> k & 1 == 1 { size[k] } else { 0.0 }));
        Box3 { axes, size, camera: Camera::fit(Camera::upright(TOWARD), corners, area) }
    }

    /// A point in units of the axes, in the scene.
    fn place(&self, p: Vec3) -> Vec3 {
        std::array::from_fn(|k| {
            let Axis { low, high, length, .. } = self.axes[k];
            length * (p[k] - low) / (high - low)
        })
    }

    fn pixel(&self, p: Vec3) -> [f64; 2] {
        let [x, y, _] = self.camera.project(p);
        [x, y]
    }

    /// The coordinate of the wall across axis `k` that lies behind the scene, and of the one in front of it.
    fn back(&self, k: usize) -> f64 {
        if TOWARD[k] > 0.0 { 0.0 } else { self.size[k] }
    }

    fn front(&self, k: usize) -> f64 {
        self.size[k] - self.back(k)
    }

    /// Marks along an axis: place in the scene and text, and the power of ten taken out.
    fn marks(&self, k: usize) -> (Vec<(f64, String)>, i32) {
        let Axis { low, high, length, .. } = self.axes[k];
        let count = if length > 2.0 { 6 } else { 4 };
        let found = ticks(low, high, count);
        let at = |value: f64| length * (value - low) / (high - low);
        (found.marks.into_iter().map(|(value, text)| (at(value), text)).collect(), found.exponent)
    }

    /// The three walls behind the surface with lines at the marks.
    fn walls(&self, drawing: &mut Drawing) {
        for k in 0..3 {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            let at = |x: f64, y: f64| {
                let mut p = [0.0; 3];
                (p[k], p[a], p[b]) = (self.back(k), x, y);
                self.pixel(p)
            };
            let (wide, high) = (self.size[a], self.size[b]);
            drawing.polygon(vec![at(0.0, 0.0), at(wide, 0.0), at(wide, high), at(0.0, high)], WALL, Some(GRID));
            for (x, _) in self.marks(a).0 {
                drawing.line(vec![at(x, 0.0), at(x, high)], 1.0, GRID);
            }
            for (y, _) in self.marks(b).0 {
                drawing.line(vec![at(0.0, y), at(wide, y)], 1.0, GRID);
            }
        }
    }

    /// Numbers and name along the edge of the box that nothing hides.
    fn axis(&self, drawing: &mut Drawing, k: usize) {
        let along = |t: f64| {
            let mut p = match k {
                0 => [0.0, self.front(1), 0.0],
                1 => [self.front(0), 0.0, 0.0],
                // Upright at the left end of the picture.
                _ => [self.back(0), self.front(1), 0.0],
            };
            p[k] = t;
            self.pixel(p)
        };
        let [start, end] = [along(0.0), along(self.size[k])];
        drawing.line(vec![start, end], 1.5, INK);
        // Away from the middle of the box.
        let (middle, center) = (along(0.5 * self.size[k]), self.pixel(self.size.map(|s| 0.5 * s)));
        let across = if k == 2 { [-1.0, 0.0] } else { away([start, end], middle, center) };
        let beside = |p: [f64; 2], d: f64| [p[0] + d * across[0], p[1] + d * across[1]];
        let align = match () {
            () if across[0] < -0.5 => Align::Right,
            () if across[0] > 0.5 => Align::Left,
            () => Align::Center,
        };
        let (marks, exponent) = self.marks(k);
        for (t, text) in marks {
            let p = along(t);
            drawing.line(vec![p, beside(p, 8.0)], 1.0, INK);
            // Where the first two axes meet, the first has its last number already.
            if k == 1 && t == 0.0 {
                continue;
            }
            drawing.text(&text, beside(p, 24.0), SMALL, INK, align);
        }
        let name = with_unit(self.axes[k].label, exponent, self.axes[k].unit_label);
        if k == 2 {
            drawing.text(&name, [end[0] - 60.0, end[1] - 36.0], BODY, INK, Align::Left);
        } else {
            drawing.text(&name, beside(middle, 66.0), BODY, INK, align);
        }
    }
}

/// The unit vector across the line `ends` that leads from `center` to the side of `middle`.
fn away([a, b]: [[f64; 2]; 2], middle: [f64; 2], center: [f64; 2]) -> [f64; 2] {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
    let normal = [-dy / length, dx / length];
    let outward = (middle[0] - center[0]) * normal[0] + (middle[1] - center[1]) * normal[1];
    if outward < 0.0 { normal.map(|x| -x) } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::plot::drawing::Shape;

    fn axis(high: f64) -> Axis<'static> {
        Axis { label: "x", unit_label: "m", low: 0.0, high, length: 1.0 }
    }

    #[test]
    fn nearer_faces_come_later_and_cover_the_farther() {
        let square = |y: f64| [[0.0, y, 0.0], [1.0, y, 0.0], [1.0, y, 1.0], [0.0, y, 1.0]];
        let points = [square(0.1), square(0.9)].concat();
        let faces: [&[u32]; 2] = [&[0, 1, 2, 3], &[4, 5, 6, 7]];
        let values = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        let colors = FaceColors::Values(&values);
        let plot = SpacePlot { points: &points, faces: &faces, colors, axes: [axis(1.0); 3], title: "", subtitle: "" };
        let drawn = space(&plot).unwrap();
        let edged = drawn.shapes.iter().filter_map(|s| match s {
            Shape::Polygon { fill, edge, .. } if edge.color == EDGE => Some(*fill),
            _ => None,
        });
        let fills: Vec<Rgb> = edged.collect();
        // The observer stands at low y; the far square has the map's yellow end, the near one the violet end.
        assert!(fills.len() == 2 && fills[0][0] > 150 && fills[1][0] < 80, "{fills:?}");
    }

    #[test]
    fn faces_without_a_number_are_left_out_and_wrong_ones_refused() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, f64::NAN], [0.0, 1.0, 0.0]];
        let draw = |faces: &[&[u32]]| {
            let colors = FaceColors::Plain([200; 3]);
            space(&SpacePlot { points: &points, faces, colors, axes: [axis(1.0); 3], title: "", subtitle: "" })
        };
        let count = |faces: &[&[u32]]| draw(faces).unwrap().shapes.len();
        assert_eq!(count(&[&[0, 1, 2]]), count(&[]));
        assert_eq!(count(&[&[0, 1, 3]]), count(&[]) + 1);
        assert!(draw(&[&[0, 1, 4]]).is_err() && draw(&[&[0, 1]]).is_err());
    }
}
