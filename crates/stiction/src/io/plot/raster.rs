//! Triangles and lines with depth: of all that covers a sub-pixel, the nearest is seen.

use std::ops::Range;

use super::camera::Area;
use super::canvas::{Canvas, FINE};
use super::color::{Rgb, mix};

/// A weight may be this much below zero: it closes the seam between neighbours that rounding would leave.
const SLACK: f64 = 1e-9;

/// The picture with the depth of what it shows. Points are `[x, y, depth]` in pixels, larger depth nearer.
pub(super) struct Raster<'a> {
    canvas: &'a mut Canvas,
    depth: Vec<f32>,
    /// Columns and rows of sub-pixels that may be drawn on.
    clip: [Range<usize>; 2],
}

impl<'a> Raster<'a> {
    pub(super) fn new(canvas: &'a mut Canvas) -> Self {
        let depth = vec![f32::NEG_INFINITY; canvas.width * canvas.height * FINE * FINE];
        let clip = [0..canvas.width * FINE, 0..canvas.height * FINE];
        Raster { canvas, depth, clip }
    }

    /// Draws on nothing but this area from now on.
    pub(super) fn clip(&mut self, area: Area) {
        let inside = |low: f64, high: f64, end: usize| {
            let [low, high] = [low, high].map(|v| (v * FINE as f64).round().clamp(0.0, end as f64) as usize);
            low..high
        };
        let (width, height) = self.size();
        self.clip = [inside(area.left, area.right, width), inside(area.top, area.bottom, height)];
    }

    /// Size in sub-pixels.
    fn size(&self) -> (usize, usize) {
        (self.canvas.width * FINE, self.canvas.height * FINE)
    }

    /// Draws a triangle; `color` is asked with the weights of the three corners. A corner that is not finite draws
    /// nothing.
    pub(super) fn triangle(&mut self, corners: [[f64; 3]; 3], color: impl Fn([f64; 3]) -> Rgb) {
        if corners.as_flattened().iter().any(|x| !x.is_finite()) {
            return;
        }
        let (width, _) = self.size();
        // Centres of sub-pixels lie at whole numbers.
        let [a, b, c] = corners.map(|p| [p[0] * FINE as f64 - 0.5, p[1] * FINE as f64 - 0.5, p[2]]);
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
        let roots = Roots::new(slopes);
        for y in span(1) {
            let down = y as f64 - a[1];
            let starts = [
                (-a[0] * (c[1] - a[1]) - down * (c[0] - a[0])) / area,
                (a[0] * (b[1] - a[1]) + down * (b[0] - a[0])) / area,
            ];
            for x in roots.within(columns.clone(), starts) {
                let [wb, wc] = [0, 1].map(|k| starts[k] + slopes[k] * x as f64);
                let wa = 1.0 - wb - wc;
                if wa.min(wb).min(wc) < -SLACK {
                    continue;
                }
                let depth = (wa * a[2] + wb * b[2] + wc * c[2]) as f32;
                let place = y * width + x;
                if depth > self.depth[place] {
                    self.depth[place] = depth;
                    self.canvas.fine[3 * place..3 * place + 3].copy_from_slice(&color([wa, wb, wc]));
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
        let (width_of_row, _) = self.size();
        let [columns, rows] = self.clip.clone().map(|r| r.start as f64..r.end as f64);
        let offset = 0.5 * (width as f64 - 1.0) + 0.5;
        let [a, b] = [a, b].map(|p| [p[0] * FINE as f64 - offset, p[1] * FINE as f64 - offset, p[2]]);
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
                    let pixel = &mut self.canvas.fine[3 * place..3 * place + 3];
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

    fn at_depth(d: f64) -> [[f64; 3]; 3] {
        [[10.0, 10.0, d], [90.0, 10.0, d], [10.0, 90.0, d]]
    }

    #[test]
    fn the_nearest_triangle_is_seen_whatever_the_order() {
        let draw = |list: &[(f64, Rgb)]| {
            let mut canvas = Canvas::new(100, 100);
            let mut raster = Raster::new(&mut canvas);
            list.iter().for_each(|&(d, color)| raster.triangle(at_depth(d), |_| color));
            canvas.pixels()
        };
        let near_first = draw(&[(2.0, RED), (1.0, BLUE)]);
        assert!(near_first == draw(&[(1.0, BLUE), (2.0, RED)]));
        assert_eq!(near_first[3 * (20 * 100 + 20)..][..3], RED);
    }

    #[test]
    fn a_triangle_covers_its_area_and_neighbours_leave_no_seam() {
        let mut canvas = Canvas::new(100, 100);
        let mut raster = Raster::new(&mut canvas);
        raster.triangle(at_depth(0.0), |_| BLUE);
        let covered = |c: &Canvas| c.fine.chunks_exact(3).filter(|p| **p == BLUE).count() as f64 / 40_000.0;
        // Half of an 80 x 80 square in a picture of 100 x 100.
        assert!((covered(&canvas) - 0.32).abs() < 0.005, "{}", covered(&canvas));
        let mut raster = Raster::new(&mut canvas);
        raster.triangle([[90.0, 90.0, 0.0], [90.0, 10.0, 0.0], [10.0, 90.0, 0.0]], |_| BLUE);
        assert!((covered(&canvas) - 0.64).abs() < 1e-12, "{}", covered(&canvas));
    }

    #[test]
    fn corners_interpolate_their_numbers() {
        let mut canvas = Canvas::new(100, 100);
        let mut raster = Raster::new(&mut canvas);
        raster.triangle(at_depth(0.0), |w| w.map(|w| (255.0 * w).round() as u8));
        let pixels = canvas.pixels();
        let [a, b, c] = [0, 1, 2].map(|k| f64::from(pixels[3 * (30 * 100 + 50) + k]) / 255.0);
        // The centre of pixel (50, 30): (50.5 - 10) / 80 towards the second corner, (30.5 - 10) / 80 to the third.
        assert!((b - 40.5 / 80.0).abs() < 0.01 && (c - 20.5 / 80.0).abs() < 0.01 && (a + b + c - 1.0).abs() < 0.01);
    }

    #[test]
    fn what_is_no_triangle_draws_nothing() {
        let mut canvas = Canvas::new(10, 10);
        let mut raster = Raster::new(&mut canvas);
        raster.triangle([[f64::NAN, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], |_| RED);
        raster.triangle([[1.0, 1.0, 0.0]; 3], |_| RED);
        raster.triangle([[-90.0, -90.0, 0.0], [-80.0, -90.0, 0.0], [-90.0, -80.0, 0.0]], |_| RED);
        raster.line([f64::INFINITY, 0.0, 0.0], [1.0, 1.0, 1.0], 1, RED, 1.0);
        assert!(canvas.fine.iter().all(|&c| c == 255));
    }

    #[test]
    fn lines_behind_a_surface_are_hidden() {
        let mut canvas = Canvas::new(100, 100);
        let mut raster = Raster::new(&mut canvas);
        raster.triangle(at_depth(50.0), |_| BLUE);
        raster.line([20.0, 20.0, 0.0], [20.0, 60.0, 0.0], 2, RED, 1.0);
        raster.line([30.0, 20.0, 50.0], [30.0, 60.0, 50.0], 2, RED, 1.0);
        let red = |x: usize| canvas.pixels()[3 * (40 * 100 + x)];
        assert!(red(19) == 0 && red(20) == 0 && red(29) > 0 && red(30) > 0);
    }
}
