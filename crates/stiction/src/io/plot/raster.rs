//! Triangles and lines with depth: of all that covers a sub-pixel, the nearest is seen.

use std::ops::Range;

use super::camera::Area;
use super::color::{Rgb, mix};
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
    /// Rows of red, green and blue.
    pub rgb: Vec<u8>,
}

impl Image {
    /// Columns and rows of sub-pixels.
    pub(super) fn size(&self) -> [usize; 2] {
        [self.width, self.rgb.len() / (3 * self.width).max(1)]
    }

    /// The sub-pixels as a PNG file.
    pub(super) fn png(&self) -> Vec<u8> {
        let (mut bytes, [width, height]) = (Vec::new(), self.size());
        let written = super::encode(&mut bytes, [width as u32, height as u32], &self.rgb);
        debug_assert!(written.is_ok(), "memory takes every byte");
        bytes
    }
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
        let image = Image { at: [left, top], width, rgb: vec![255; 3 * width * height] };
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

    /// Draws a triangle; `color` is asked with the weights of the three corners. A corner that is not finite draws
    /// nothing.
    pub(super) fn triangle(&mut self, corners: [[f64; 3]; 3], color: impl Fn([f64; 3]) -> Rgb) {
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
        // The weights of b and c are linear: their slopes along a row are the same for all rows.
        let slopes = [(c[1] - a[1]) / area, (a[1] - b[1]) / area];
        let depths = [b[2] - a[2], c[2] - a[2]];
        let deeper = slopes[0] * depths[0] + slopes[1] * depths[1];
        let roots = Roots::new(slopes);
        for y in span(1) {
            let down = y as f64 - a[1];
            let starts = [
                (-a[0] * (c[1] - a[1]) - down * (c[0] - a[0])) / area,
                (a[0] * (b[1] - a[1]) + down * (b[0] - a[0])) / area,
            ];
            let depth = a[2] + starts[0] * depths[0] + starts[1] * depths[1];
            let row = roots.within(columns.clone(), starts);
            let places = y * width + row.start..y * width + row.end;
            let pixels = self.depth[places.clone()].iter_mut().zip(self.image.rgb.as_chunks_mut().0[places].iter_mut());
            for (x, (nearest, pixel)) in row.zip(pixels) {
                // Most of what lies behind is left here.
                let depth = (depth + deeper * x as f64) as f32;
                if depth <= *nearest {
                    continue;
                }
                let [wb, wc] = [0, 1].map(|k| starts[k] + slopes[k] * x as f64);
                let wa = 1.0 - wb - wc;
                if wa.min(wb).min(wc) >= -SLACK {
                    *nearest = depth;
                    *pixel = color([wa, wb, wc]);
                }
            }
        }
    }

    /// Draws a line `width` sub-pixels wide over what it is not hidden by; `opacity` in 0..1.
    pub(super) fn line(&mut self, a: [f64; 3], b: [f64; 3], width: usize, color: Rgb, opacity: f64) {
        /// Pixels by which a line lies nearer than its surface, which it would otherwise sink into by rounding.
        const LIFT: f32 = 2.0;
        if a.iter().chain(&b).any(|x| x.abs() > 1e5 || x.is_nan()) {
            return;
        }
        let width_of_row = self.image.width;
        let [columns, rows] = self.clip.clone().map(|r| r.start as f64..r.end as f64);
        let offset = 0.5 * (width as f64 - 1.0) + 0.5;
        let [a, b] = [a, b].map(|p| self.place(p, offset));
        let steps = (b[0] - a[0]).abs().max((b[1] - a[1]).abs()).ceil().max(1.0);
        for i in 0..=steps as usize {
            let t = i as f64 / steps;
            let [x, y, depth] = [0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]));
            let (x, y) = (x + 0.5, y + 0.5);
            for (dx, dy) in (0..width).flat_map(|dx| (0..width).map(move |dy| (dx, dy))) {
                let (x, y) = (x + dx as f64, y + dy as f64);
                if !columns.contains(&x) || !rows.contains(&y) {
                    continue;
                }
                let place = y as usize * width_of_row + x as usize;
                if depth as f32 + LIFT >= self.depth[place] {
                    let pixel = &mut self.image.rgb[3 * place..3 * place + 3];
                    let mixed = mix([pixel[0], pixel[1], pixel[2]], color, opacity);
                    pixel.copy_from_slice(&mixed);
                }
            }
        }
    }
}

/// How far along a row the three weights vanish for one at its start, with the opposite sign: one over their slopes.
struct Roots([f64; 3]);

impl Roots {
    /// `slopes` are those of two of them, all three sum up to one.
    fn new(slopes: [f64; 2]) -> Self {
        Roots([slopes[0], slopes[1], -slopes[0] - slopes[1]].map(|slope| 1.0 / slope))
    }

    /// The part of a row in which no weight is negative, and a sub-pixel more at both ends: it only spares work.
    fn within(&self, columns: Range<usize>, starts: [f64; 2]) -> Range<usize> {
        let starts = [starts[0], starts[1], 1.0 - starts[0] - starts[1]];
        let (mut low, mut high) = (columns.start as f64, columns.end as f64);
        for (start, inverse) in starts.iter().zip(self.0) {
            // Along rows on which a weight does not change the root lies nowhere: it is infinite or no number.
            let root = -start * inverse;
            if inverse.is_infinite() {
            } else if inverse > 0.0 {
                low = low.max(root - 1.0);
            } else {
                high = high.min(root + 2.0);
            }
        }
        if low < high { low as usize..high as usize } else { 0..0 }
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
        raster.image().rgb
    }

    fn at_depth(d: f64) -> [[f64; 3]; 3] {
        [[10.0, 10.0, d], [90.0, 10.0, d], [10.0, 90.0, d]]
    }

    #[test]
    fn the_nearest_triangle_is_seen_whatever_the_order() {
        let draw = |list: &[(f64, Rgb)]| {
            drawn(100, |raster| list.iter().for_each(|&(d, color)| raster.triangle(at_depth(d), |_| color)))
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
        let half = covered(&|raster| raster.triangle(at_depth(0.0), |_| BLUE));
        assert!((half - 0.32).abs() < 0.005, "{half}");
        let whole = covered(&|raster| {
            raster.triangle(at_depth(0.0), |_| BLUE);
            raster.triangle([[90.0, 90.0, 0.0], [90.0, 10.0, 0.0], [10.0, 90.0, 0.0]], |_| BLUE);
        });
        assert!((whole - 0.64).abs() < 1e-12, "{whole}");
    }

    #[test]
    fn corners_interpolate_their_numbers() {
        let pixels = drawn(100, |raster| raster.triangle(at_depth(0.0), |w| w.map(|w| (255.0 * w).round() as u8)));
        let [a, b, c] = [0, 1, 2].map(|k| f64::from(pixels[3 * (60 * 200 + 100) + k]) / 255.0);
        // The centre of the sub-pixel is (50.25, 30.25): 40.25 / 80 towards the second corner, 20.25 / 80 to the third.
        assert!((b - 40.25 / 80.0).abs() < 0.01 && (c - 20.25 / 80.0).abs() < 0.01 && (a + b + c - 1.0).abs() < 0.01);
    }

    #[test]
    fn what_is_no_triangle_draws_nothing() {
        let pixels = drawn(10, |raster| {
            raster.triangle([[f64::NAN, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], |_| RED);
            raster.triangle([[1.0, 1.0, 0.0]; 3], |_| RED);
            raster.triangle([[-90.0, -90.0, 0.0], [-80.0, -90.0, 0.0], [-90.0, -80.0, 0.0]], |_| RED);
            raster.line([f64::INFINITY, 0.0, 0.0], [1.0, 1.0, 1.0], 1, RED, 1.0);
        });
        assert!(pixels.iter().all(|&c| c == 255));
    }

    #[test]
    fn lines_behind_a_surface_are_hidden() {
        let pixels = drawn(100, |raster| {
            raster.triangle(at_depth(50.0), |_| BLUE);
            raster.line([20.0, 20.0, 0.0], [20.0, 60.0, 0.0], 2, RED, 1.0);
            raster.line([30.0, 20.0, 50.0], [30.0, 60.0, 50.0], 2, RED, 1.0);
        });
        let red = |x: usize| pixels[3 * (80 * 200 + x)];
        assert!((38..=41).all(|x| red(x) == 0) && (59..=60).all(|x| red(x) > 0));
    }
}
