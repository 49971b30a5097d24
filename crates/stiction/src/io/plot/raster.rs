//! Triangles and lines with depth: of all that covers a sub-pixel, the nearest is seen.

use std::ops::Range;

use super::camera::Area;
use super::color::Rgb;
use super::drawing::Drawing;

/// Sub-pixels a pixel, in each direction.
pub(super) const FINE: usize = 2;

/// A weight may be this much below zero: it closes the seam between neighbours that rounding would leave.
const SLACK: f64 = 1e-9;

/// Sub-pixels of a part of a picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Image {
    /// Column and row of its upper left corner, pixels.
    pub at: [usize; 2],
    /// Sub-pixels of a row.
    pub width: usize,
    /// Rows of red, green, blue and an opacity that is always full.
    pub pixels: Vec<[u8; 4]>,
}

impl Image {
    /// Columns and rows of sub-pixels.
    pub(super) fn size(&self) -> [usize; 2] {
        [self.width, self.pixels.len() / self.width.max(1)]
    }

    /// The sub-pixels as a PNG file.
    pub(super) fn png(&self) -> Vec<u8> {
        let (mut bytes, [width, height]) = (Vec::new(), self.size());
        let written = super::encode(&mut bytes, [width as u32, height as u32], &rgb(&self.pixels));
        debug_assert!(written.is_ok(), "memory takes every byte");
        bytes
    }
}

/// Red, green and blue of each pixel.
pub(super) fn rgb(pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut colors = vec![[0; 3]; pixels.len()];
    colors.iter_mut().zip(pixels).for_each(|(color, &[r, g, b, _])| *color = [r, g, b]);
    colors.into_flattened()
}

/// A pixel of this colour.
pub(super) fn opaque([r, g, b]: Rgb) -> [u8; 4] {
    [r, g, b, 255]
}

/// A picture with the depth of what it shows. Points are `[x, y, depth]` in pixels, larger depth nearer.
pub(super) struct Raster {
    image: Image,
    depth: Vec<f32>,
    /// Columns and rows of sub-pixels that may be drawn on.
    clip: [Range<usize>; 2],
}

impl Raster {
    /// A white picture for this area of a drawing; it begins at a whole pixel, and nothing is drawn beside the area.
    pub(super) fn new(drawing: &Drawing, area: Area) -> Self {
        let span = |low: f64, high: f64, end: usize| {
            // One pixel at least, also where the area is no number.
            let start = low.floor().min(end as f64 - 1.0).max(0.0);
            let size = (high.ceil().min(end as f64) - start).max(1.0);
            let sub_pixels = |v: f64| ((v - start).clamp(0.0, size) * FINE as f64).round() as usize;
            (start as usize, sub_pixels(start + size), sub_pixels(low)..sub_pixels(high))
        };
        let (left, width, columns) = span(area.left, area.right, drawing.width);
        let (top, height, rows) = span(area.top, area.bottom, drawing.height);
        let image = Image { at: [left, top], width, pixels: vec![[255; 4]; width * height] };
        Raster { image, depth: vec![f32::NEG_INFINITY; width * height], clip: [columns, rows] }
    }

    /// What was drawn.
    pub(super) fn image(self) -> Image {
        self.image
    }

    /// Place in sub-pixels of the image, `offset` before its centre; the depth stays.
    fn place(&self, [x, y, depth]: [f64; 3], offset: f64) -> [f64; 3] {
        let [left, top] = self.image.at.map(|at| at as f64);
        [(x - left) * FINE as f64 - offset, (y - top) * FINE as f64 - offset, depth]
    }

    /// Draws a triangle; `color` is asked with what its corners' `values` come to in between. A corner that is not finite
    /// draws nothing.
    pub(super) fn triangle(&mut self, corners: [[f64; 3]; 3], values: [f64; 3], color: impl Fn(f64) -> [u8; 4]) {
        if corners.as_flattened().iter().any(|x| !x.is_finite()) {
            return;
        }
        let width = self.image.width;
        // Centres of sub-pixels lie at whole numbers.
        let [a, b, c] = corners.map(|p| self.place(p, 0.5));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let span = |k: usize| {
            let Range { start, end } = self.clip[k].clone();
            let low = a[k].min(b[k]).min(c[k]).ceil().max(start as f64);
            let high = a[k].max(b[k]).max(c[k]).floor().min(end as f64 - 1.0);
            // An empty span, also where the triangle lies beside the picture.
            if low <= high { low as usize..high as usize + 1 } else { 0..0 }
        };
        let columns = span(0);
        // The weights of b and c are linear: their slopes along a row and down a column are the same everywhere.
        let inverse = 1.0 / area;
        let along = [(c[1] - a[1]) * inverse, (a[1] - b[1]) * inverse];
        let downward = [(a[0] - c[0]) * inverse, (b[0] - a[0]) * inverse];
        let edges = Edges::new(along);
        // What the corners say where a row starts, and its slope along it.
        let between = |at: [f64; 3], starts: [f64; 2]| {
            let [b, c] = [at[1] - at[0], at[2] - at[0]];
            [at[0] + starts[0] * b + starts[1] * c, along[0] * b + along[1] * c]
        };
        for y in span(1) {
            let down = y as f64 - a[1];
            let starts = [0, 1].map(|k| down * downward[k] - a[0] * along[k]);
            let row = edges.within(columns.clone(), starts);
            let [depth, deeper] = between([a[2], b[2], c[2]], starts);
            let [value, change] = between(values, starts);
            // Counted as a number beside the places: the conversion of each would take longer than all else.
            let mut x = row.start as f64;
            let places = y * width + row.start..y * width + row.end;
            for (nearest, pixel) in self.depth[places.clone()].iter_mut().zip(&mut self.image.pixels[places]) {
                let depth = (depth + deeper * x) as f32;
                if depth > *nearest {
                    *nearest = depth;
                    *pixel = color(value + change * x);
                }
                x += 1.0;
            }
        }
    }

    /// Draws a line `width` sub-pixels wide over what it is not hidden by; `opacity` in 0..1.
    pub(super) fn line(&mut self, a: [f64; 3], b: [f64; 3], width: i32, color: Rgb, opacity: f64) {
        /// Pixels by which a line lies nearer than its surface, which it would otherwise sink into by rounding.
        const LIFT: f32 = 2.0;
        /// Pixels.
        const FAR: f64 = 1e6;
        if a.iter().chain(&b).any(|x| x.abs() > 0.1 * FAR || x.is_nan()) {
            return;
        }
        let width_of_row = self.image.width;
        let [columns, rows] = self.clip.clone().map(|clip| clip.start as i32..clip.end as i32);
        let offset = 0.5 * f64::from(width);
        let cover = (256.0 * opacity).round() as i32;
        let [a, b] = [a, b].map(|p| self.place(p, offset));
        let steps = (b[0] - a[0]).abs().max((b[1] - a[1]).abs()).ceil().max(1.0);
        let step: [f64; 3] = [0, 1, 2].map(|k| (b[k] - a[k]) / steps);
        for i in 0..=steps as i32 {
            let [x, y, depth] = [0, 1, 2].map(|k| a[k] + f64::from(i) * step[k]);
            // Cut off to the nearest whole number, also below zero.
            let [left, top] = [x, y].map(|v| (v + (0.5 + FAR)) as i32 - FAR as i32);
            for y in top.max(rows.start)..(top + width).min(rows.end) {
                for x in left.max(columns.start)..(left + width).min(columns.end) {
                    let place = y as usize * width_of_row + x as usize;
                    if depth as f32 + LIFT >= self.depth[place] {
                        let pixel = &mut self.image.pixels[place];
                        for (part, &new) in pixel.iter_mut().zip(&color) {
                            *part = ((i32::from(*part) * (256 - cover) + i32::from(new) * cover + 128) >> 8) as u8;
                        }
                    }
                }
            }
        }
    }
}

/// Where the weights of a triangle vanish along its rows.
struct Edges {
    /// How each of the three weights changes from one sub-pixel to the next, as one over it.
    inverse: [f64; 3],
}

impl Edges {
    /// `slopes` are those of two of them, all three sum up to one.
    fn new(slopes: [f64; 2]) -> Self {
        Edges { inverse: [slopes[0], slopes[1], -slopes[0] - slopes[1]].map(|slope| 1.0 / slope) }
    }

    /// The part of a row in which no weight is negative, two of which have the values `starts` at its start.
    fn within(&self, columns: Range<usize>, starts: [f64; 2]) -> Range<usize> {
        let (mut low, mut high) = (columns.start as f64, columns.end as f64 - 1.0);
        for (start, inverse) in [starts[0], starts[1], 1.0 - starts[0] - starts[1]].iter().zip(self.inverse) {
            let over = start + SLACK;
            if inverse.is_infinite() {
                // The row runs along an edge, on one side of it.
                if over < 0.0 {
                    return 0..0;
                }
            } else if inverse > 0.0 {
                low = low.max(-over * inverse);
            } else {
                high = high.min(-over * inverse);
            }
        }
        // Rounded by hand: the functions for it are calls.
        let first = low as i32;
        let first = first + i32::from(f64::from(first) < low);
        if f64::from(first) <= high { first as usize..(high as i32) as usize + 1 } else { 0..0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Rgb = [255, 0, 0];
    const BLUE: Rgb = [0, 0, 255];

    /// The sub-pixels of a square picture.
    fn drawn(side: usize, draw: impl Fn(&mut Raster)) -> Vec<u8> {
        let (whole, end) = (Drawing::new(side, side), side as f64);
        let mut raster = Raster::new(&whole, Area { left: 0.0, top: 0.0, right: end, bottom: end });
        draw(&mut raster);
        rgb(&raster.image().pixels)
    }

    fn at_depth(d: f64) -> [[f64; 3]; 3] {
        [[10.0, 10.0, d], [90.0, 10.0, d], [10.0, 90.0, d]]
    }

    #[test]
    fn the_nearest_triangle_is_seen_whatever_the_order() {
        let draw = |list: &[(f64, Rgb)]| {
            drawn(100, |raster| {
                list.iter().for_each(|&(d, color)| raster.triangle(at_depth(d), [0.0; 3], |_| opaque(color)))
            })
        };
        let near_first = draw(&[(2.0, RED), (1.0, BLUE)]);
        assert!(near_first == draw(&[(1.0, BLUE), (2.0, RED)]));
        assert_eq!(near_first[3 * (40 * 200 + 40)..][..3], RED);
    }

    #[test]
    fn a_triangle_covers_its_area_and_neighbours_leave_no_seam() {
        let covered = |draw: &dyn Fn(&mut Raster)| {
            drawn(100, draw).chunks_exact(3).filter(|p| **p == BLUE).count() as f64 / 40_000.0
        };
        // Half of an 80 x 80 square in a picture of 100 x 100.
        let half = covered(&|raster| raster.triangle(at_depth(0.0), [0.0; 3], |_| opaque(BLUE)));
        assert!((half - 0.32).abs() < 0.005, "{half}");
        let whole = covered(&|raster| {
            raster.triangle(at_depth(0.0), [0.0; 3], |_| opaque(BLUE));
            raster.triangle([[90.0, 90.0, 0.0], [90.0, 10.0, 0.0], [10.0, 90.0, 0.0]], [0.0; 3], |_| opaque(BLUE));
        });
        assert!((whole - 0.64).abs() < 1e-12, "{whole}");
    }

    #[test]
    fn corners_interpolate_their_numbers() {
        let weight = |corner: usize| {
            let values = std::array::from_fn(|k| if k == corner { 1.0 } else { 0.0 });
            let pixels =
                drawn(100, |raster| raster.triangle(at_depth(0.0), values, |w| [(255.0 * w).round() as u8, 0, 0, 255]));
            f64::from(pixels[3 * (60 * 200 + 100)]) / 255.0
        };
        let [a, b, c] = [0, 1, 2].map(weight);
        // The centre of the sub-pixel is (50.25, 30.25): 40.25 / 80 towards the second corner, 20.25 / 80 to the third.
        assert!((b - 40.25 / 80.0).abs() < 0.01 && (c - 20.25 / 80.0).abs() < 0.01 && (a + b + c - 1.0).abs() < 0.01);
    }

    #[test]
    fn what_is_no_triangle_draws_nothing() {
        let pixels = drawn(10, |raster| {
            raster.triangle([[f64::NAN, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], [0.0; 3], |_| opaque(RED));
            raster.triangle([[1.0, 1.0, 0.0]; 3], [0.0; 3], |_| opaque(RED));
            raster.triangle([[-90.0, -90.0, 0.0], [-80.0, -90.0, 0.0], [-90.0, -80.0, 0.0]], [0.0; 3], |_| opaque(RED));
            raster.line([f64::INFINITY, 0.0, 0.0], [1.0, 1.0, 1.0], 1, RED, 1.0);
        });
        assert!(pixels.iter().all(|&c| c == 255));
    }

    #[test]
    fn lines_behind_a_surface_are_hidden() {
        let pixels = drawn(100, |raster| {
            raster.triangle(at_depth(50.0), [0.0; 3], |_| opaque(BLUE));
            raster.line([20.0, 20.0, 0.0], [20.0, 60.0, 0.0], 2, RED, 1.0);
            raster.line([30.0, 20.0, 50.0], [30.0, 60.0, 50.0], 2, RED, 1.0);
        });
        let red = |x: usize| pixels[3 * (80 * 200 + x)];
        assert!((38..=41).all(|x| red(x) == 0) && (59..=60).all(|x| red(x) > 0));
    }
}
