//! A picture as a list of shapes, from back to front: written as PNG or, with the same shapes, as SVG.

use std::path::Path;

use super::color::Rgb;
use super::raster::Image;
use super::{encode, pixels, svg};
use crate::Error;
use crate::io::replace::replace;

/// Shapes on white. Coordinates, widths and sizes are pixels from the top left corner; colours are red, green, blue.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    pub(super) shapes: Vec<Shape>,
}

/// Which point of a text lies at its coordinates, across.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Its first.
    Left,
    /// Its middle.
    Center,
    /// Its last.
    Right,
}

/// A line's colour and width, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub color: Rgb,
    pub width: f64,
}

/// All coordinates are finite and at most [`FAR`].
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// Pixels, over all of the picture.
    Image(Image),
    /// A filled polygon of three or more corners with its outline.
    Polygon {
        corners: Vec<[f64; 2]>,
        fill: Rgb,
        edge: Stroke,
    },
    /// A line through all points, two or more.
    Line {
        points: Vec<[f64; 2]>,
        stroke: Stroke,
    },
    Disc {
        center: [f64; 2],
        radius: f64,
        color: Rgb,
    },
    /// One line of text, as [`Drawing::text`] takes it.
    Text {
        text: String,
        at: [f64; 2],
        size: f64,
        color: Rgb,
        align: Align,
    },
}

/// What lies farther off, pixels, is not drawn.
const FAR: f64 = 1e4;
/// Half the width of an arrow's head over its length.
const HEAD: f64 = 0.42;

/// Whether this is a point of any picture.
fn is_near(p: &[f64; 2]) -> bool {
    p.iter().all(|x| x.abs() < FAR)
}

impl Drawing {
    /// An empty picture.
    pub fn new(width: usize, height: usize) -> Self {
        Drawing { width, height, shapes: Vec::new() }
    }

    /// A filled polygon, with an outline of one pixel if `edge` is a colour.
    pub fn polygon(&mut self, corners: Vec<[f64; 2]>, fill: [u8; 3], edge: Option<[u8; 3]>) {
        // Without an outline neighbours would show the white between them where their edges are smoothed.
        let edge = edge.map_or(Stroke { color: fill, width: 0.5 }, |color| Stroke { color, width: 1.0 });
        if corners.len() > 2 && corners.iter().all(is_near) {
            self.shapes.push(Shape::Polygon { corners, fill, edge });
        }
    }

    /// A line through all points but those that are not finite.
    pub fn line(&mut self, mut points: Vec<[f64; 2]>, width: f64, color: [u8; 3]) {
        points.retain(is_near);
        if points.len() > 1 {
            self.shapes.push(Shape::Line { points, stroke: Stroke { color, width } });
        }
    }

    /// The outline of a rectangle with the corners `a` and `b`.
    pub fn frame(&mut self, a: [f64; 2], b: [f64; 2], width: f64, color: [u8; 3]) {
        self.line(vec![a, [b[0], a[1]], b, [a[0], b[1]], a], width, color);
    }

    /// A filled circle.
    pub fn disc(&mut self, center: [f64; 2], radius: f64, color: [u8; 3]) {
        if is_near(&center) {
            self.shapes.push(Shape::Disc { center, radius, color });
        }
    }

    /// An arrow with a filled head of length `head`; none if its ends are no more than half a pixel apart.
    pub fn arrow(&mut self, from: [f64; 2], to: [f64; 2], width: f64, head: f64, color: [u8; 3]) {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = dx.hypot(dy);
        if !(length.is_finite() && length > 0.5) {
            return;
        }
        let e = [dx / length, dy / length];
        let back = [to[0] - head * e[0], to[1] - head * e[1]];
        let side = |s: f64| [back[0] - s * head * e[1], back[1] + s * head * e[0]];
        self.line(vec![from, back], width, color);
        self.polygon(vec![to, side(HEAD), side(-HEAD)], color, None);
    }

    /// One line of text whose lines would be `size` apart; capitals and digits are centred on the height of `at`.
    pub fn text(&mut self, text: &str, at: [f64; 2], size: f64, color: [u8; 3], align: Align) {
        if is_near(&at) {
            self.shapes.push(Shape::Text { text: text.to_string(), at, size, color, align });
        }
    }

    /// Pixels of a surface, over all that was drawn before.
    pub(super) fn image(&mut self, image: Image) {
        self.shapes.push(Shape::Image(image));
    }

    /// The text of an SVG file.
    pub fn svg(&self) -> String {
        svg::text(self)
    }

    /// Writes the picture as SVG.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_svg(&self, path: &Path) -> Result<(), Error> {
        replace(path, |file| std::io::Write::write_all(file, self.svg().as_bytes()))
    }

    /// Writes the picture as PNG.
    ///
    /// # Errors
    /// If the file cannot be written, or the picture is empty or too large.
    pub fn write_png(&self, path: &Path) -> Result<(), Error> {
        let (width, height) = (self.width, self.height);
        let Some(picture) = pixels::pixels(self) else {
            let what = format!("a picture of {width} times {height} pixels cannot be drawn");
            return Err(Error::new(path.display().to_string(), what, "choose another size"));
        };
        replace(path, |file| Ok(encode(file, [picture.width(), picture.height()], &pixels::rgb(&picture))?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_far_outside_is_not_drawn() {
        let mut drawing = Drawing::new(20, 20);
        drawing.line(vec![[f64::NAN, 0.0], [5.0, 5.0]], 1.0, [0; 3]);
        drawing.line(vec![[-1e300, 0.0], [5.0, f64::INFINITY]], 1.0, [0; 3]);
        drawing.disc([1e9, 0.0], 3.0, [0; 3]);
        drawing.polygon(vec![[0.0, 0.0], [9.0, f64::NAN], [9.0, 9.0]], [0; 3], None);
        drawing.arrow([0.0, 0.0], [f64::INFINITY, 0.0], 1.0, 3.0, [0; 3]);
        drawing.text("far", [0.0, -1e12], 20.0, [0; 3], Align::Left);
        assert!(drawing.shapes.is_empty());
    }
}
