//! A picture as a list of shapes, from back to front: written as PNG or, with the same shapes, as SVG.

use std::path::Path;

pub use super::canvas::Align;
use super::canvas::Canvas;
use super::color::Rgb;
use super::svg;
use crate::Error;
use crate::io::replace::replace;

/// Shapes on white. Coordinates, widths and sizes are pixels from the top left corner; colours are red, green, blue.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    pub width: usize,
    pub height: usize,
    pub(super) shapes: Vec<Shape>,
}

/// A line's colour and width, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub color: Rgb,
    pub width: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// A filled polygon with or without its outline.
    Polygon {
        corners: Vec<[f64; 2]>,
        fill: Rgb,
        edge: Option<Stroke>,
    },
    /// A line through all points.
    Line {
        points: Vec<[f64; 2]>,
        stroke: Stroke,
    },
    Arrow {
        from: [f64; 2],
        to: [f64; 2],
        stroke: Stroke,
        head: f64,
    },
    /// One line of text, as [`Canvas::text`] takes it.
    Text {
        text: String,
        at: [f64; 2],
        size: f64,
        color: Rgb,
        align: Align,
    },
}

impl Drawing {
    /// An empty picture.
    pub fn new(width: usize, height: usize) -> Self {
        Drawing { width, height, shapes: Vec::new() }
    }

    /// A filled polygon, with an outline of one pixel if `edge` is a colour.
    pub fn polygon(&mut self, corners: Vec<[f64; 2]>, fill: [u8; 3], edge: Option<[u8; 3]>) {
        let edge = edge.map(|color| Stroke { color, width: 1.0 });
        self.shapes.push(Shape::Polygon { corners, fill, edge });
    }

    /// A line through all points.
    pub fn line(&mut self, points: Vec<[f64; 2]>, width: f64, color: [u8; 3]) {
        self.shapes.push(Shape::Line { points, stroke: Stroke { color, width } });
    }

    /// An arrow with a filled head of length `head`.
    pub fn arrow(&mut self, from: [f64; 2], to: [f64; 2], width: f64, head: f64, color: [u8; 3]) {
        self.shapes.push(Shape::Arrow { from, to, stroke: Stroke { color, width }, head });
    }

    /// One line of text whose lines would be `size` apart, centred on the height of `at`.
    pub fn text(&mut self, text: &str, at: [f64; 2], size: f64, color: [u8; 3], align: Align) {
        self.shapes.push(Shape::Text { text: text.to_string(), at, size, color, align });
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
    /// If the file cannot be written.
    pub fn write_png(&self, path: &Path) -> Result<(), Error> {
        let mut canvas = Canvas::new(self.width, self.height);
        for shape in &self.shapes {
            match shape {
                Shape::Polygon { corners, fill, edge } => {
                    canvas.polygon(corners, *fill);
                    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
                    if let Some(edge) = edge {
                        ends.for_each(|(&a, &b)| canvas.line(a, b, edge.width, edge.color));
                    }
                }
                Shape::Line { points, stroke } => {
                    points.windows(2).for_each(|p| canvas.line(p[0], p[1], stroke.width, stroke.color));
                }
                Shape::Arrow { from, to, stroke, head } => canvas.arrow(*from, *to, stroke.width, *head, stroke.color),
                Shape::Text { text, at, size, color, align } => canvas.text(text, *at, *size, *color, *align),
            }
        }
        canvas.write(path)
    }
}
