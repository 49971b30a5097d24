//! A picture under way: pixels, lines, texts. Coordinates are pixels of the finished picture, from its top left corner.

use std::path::Path;

use plotters::backend::{BitMapBackend, DrawingBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, IntoFont, RGBColor, ShapeStyle, TextStyle, register_font};

use super::color::Rgb;
use crate::Error;
use crate::io::replace::replace;

/// Sub-pixels a pixel, in each direction: everything is drawn this much larger, then averaged.
pub(super) const FINE: usize = 2;

const FONT: &str = "stiction";

/// Which point of a text lies at its coordinates, across.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    Left,
    Center,
    Right,
}

pub(super) struct Canvas {
    /// Size of the finished picture.
    pub width: usize,
    pub height: usize,
    /// Sub-pixels in rows, three bytes each.
    pub fine: Vec<u8>,
}

impl Canvas {
    /// Half the width of an arrow's head over its length.
    pub(super) const HEAD: f64 = 0.42;

    /// A white picture.
    pub(super) fn new(width: usize, height: usize) -> Self {
        let font = register_font(FONT, FontStyle::Normal, include_bytes!("../../../assets/DejaVuSans-subset.ttf"));
        debug_assert!(font.is_ok(), "the font is part of the program");
        Canvas { width, height, fine: vec![255; width * height * 3 * FINE * FINE] }
    }

    /// Drawing into memory cannot fail; the results that `plotters` returns are those of files and windows.
    fn backend(&mut self) -> BitMapBackend<'_> {
        let size = ((self.width * FINE) as u32, (self.height * FINE) as u32);
        BitMapBackend::with_buffer(&mut self.fine, size)
    }

    pub(super) fn line(&mut self, a: [f64; 2], b: [f64; 2], width: f64, color: Rgb) {
        let stroke_width = (width * FINE as f64).round().max(1.0) as u32;
        if let (Some(a), Some(b)) = (fine(a), fine(b)) {
            let _ = self.backend().draw_line(a, b, &ShapeStyle { stroke_width, ..filled(color) });
        }
    }

    /// A filled polygon.
    pub(super) fn polygon(&mut self, corners: &[[f64; 2]], color: Rgb) {
        if let Some(corners) = corners.iter().map(|&p| fine(p)).collect::<Option<Vec<_>>>() {
            let _ = self.backend().fill_polygon(corners, &filled(color));
        }
    }

    /// A filled rectangle from its top left corner `a` to its bottom right corner `b`, both inclusive.
    pub(super) fn rectangle(&mut self, a: [f64; 2], b: [f64; 2], color: Rgb) {
        if let (Some(a), Some(b)) = (fine(a), fine(b)) {
            let _ = self.backend().draw_rect(a, b, &filled(color), true);
        }
    }

    /// The outline of a rectangle.
    pub(super) fn frame(&mut self, a: [f64; 2], b: [f64; 2], width: f64, color: Rgb) {
        let corners = [a, [b[0], a[1]], b, [a[0], b[1]], a];
        corners.windows(2).for_each(|w| self.line(w[0], w[1], width, color));
    }

    pub(super) fn disc(&mut self, center: [f64; 2], radius: f64, color: Rgb) {
        if let Some(center) = fine(center) {
            let _ = self.backend().draw_circle(center, (radius * FINE as f64).round() as u32, &filled(color), true);
        }
    }

    /// An arrow with a filled head of length `head`.
    pub(super) fn arrow(&mut self, from: [f64; 2], to: [f64; 2], width: f64, head: f64, color: Rgb) {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = dx.hypot(dy);
        if !(length.is_finite() && length > 0.5) {
            return;
        }
        let e = [dx / length, dy / length];
        let back = [to[0] - head * e[0], to[1] - head * e[1]];
        let side = |s: f64| [back[0] - s * head * e[1], back[1] + s * head * e[0]];
        self.line(from, back, width, color);
        self.polygon(&[to, side(Self::HEAD), side(-Self::HEAD)], color);
    }

    /// One line of text whose lines would be `size` pixels apart; capitals and digits are centred on the height of `at`.
    pub(super) fn text(&mut self, text: &str, at: [f64; 2], size: f64, color: Rgb, align: Align) {
        let across = match align {
            Align::Left => HPos::Left,
            Align::Center => HPos::Center,
            Align::Right => HPos::Right,
        };
        let color = RGBColor(color[0], color[1], color[2]);
        let style =
            TextStyle::from((FONT, size * FINE as f64).into_font()).color(&color).pos(Pos::new(across, VPos::Center));
        // The backend centres the box of the line, which lies higher than its digits.
        if let Some(at) = fine([at[0], at[1] + 0.2 * size]) {
            let _ = self.backend().draw_text(text, &style, at);
        }
    }

    /// The length of a text.
    pub(super) fn text_width(text: &str, size: f64) -> f64 {
        let font = (FONT, size * FINE as f64).into_font();
        font.box_size(text).map_or(0.0, |(width, _)| f64::from(width) / FINE as f64)
    }

    /// A text shortened to `width` by an ellipsis.
    pub(super) fn fitting(text: &str, size: f64, width: f64) -> String {
        if Self::text_width(text, size) <= width {
            return text.to_string();
        }
        let mut kept: Vec<char> = text.chars().collect();
        while !kept.is_empty() && Self::text_width(&kept.iter().collect::<String>(), size) > width - size {
            kept.pop();
        }
        kept.iter().collect::<String>().trim_end().to_string() + "…"
    }

    /// The finished pixels in rows, three bytes each.
    pub(super) fn pixels(&self) -> Vec<u8> {
        const { assert!(FINE == 2, "the sums below are those of four sub-pixels") };
        let row = self.width * FINE * 3;
        let mut pixels = Vec::with_capacity(self.width * self.height * 3);
        for rows in self.fine.chunks_exact(row * FINE) {
            let (upper, lower) = rows.split_at(row);
            for (a, b) in upper.as_chunks::<6>().0.iter().zip(lower.as_chunks::<6>().0) {
                let sum = |c: usize| u16::from(a[c]) + u16::from(a[c + 3]) + u16::from(b[c]) + u16::from(b[c + 3]);
                pixels.extend_from_slice(&[0, 1, 2].map(|c| ((sum(c) + 2) / 4) as u8));
            }
        }
        pixels
    }

    /// Writes the picture as PNG.
    pub(super) fn write(&self, path: &Path) -> Result<(), Error> {
        let pixels = self.pixels();
        replace(path, |file| {
            let mut encoder = png::Encoder::new(file, self.width as u32, self.height as u32);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            encoder.set_compression(png::Compression::Fast);
            // Trying all filters on each row costs more than the compression.
            encoder.set_filter(png::Filter::Up);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&pixels)?;
            writer.finish()?;
            Ok(())
        })
    }
}

fn filled(color: Rgb) -> ShapeStyle {
    ShapeStyle { color: RGBColor(color[0], color[1], color[2]).to_rgba(), filled: true, stroke_width: 1 }
}

/// Sub-pixel coordinates; `None` for what is no point of any picture.
fn fine(p: [f64; 2]) -> Option<(i32, i32)> {
    let near = |x: f64| (x.abs() < 1e4).then(|| (x * FINE as f64).round() as i32);
    Some((near(p[0])?, near(p[1])?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_have_ink_and_long_ones_are_shortened() {
        let mut canvas = Canvas::new(200, 40);
        canvas.text("λ 10⁻³", [100.0, 20.0], 24.0, [0, 0, 0], Align::Center);
        assert!(canvas.pixels().iter().any(|&c| c < 64));
        let short = Canvas::fitting("a rather long title of a picture", 24.0, 120.0);
        assert!(short.ends_with('…') && Canvas::text_width(&short, 24.0) <= 120.0, "{short}");
        assert_eq!(Canvas::fitting("short", 24.0, 120.0), "short");
    }

    #[test]
    fn what_lies_far_outside_is_not_drawn() {
        let mut canvas = Canvas::new(20, 20);
        canvas.line([f64::NAN, 0.0], [5.0, 5.0], 1.0, [0, 0, 0]);
        canvas.line([-1e300, 0.0], [5.0, f64::INFINITY], 1.0, [0, 0, 0]);
        canvas.disc([1e9, 0.0], 3.0, [0, 0, 0]);
        assert!(canvas.pixels().iter().all(|&c| c == 255));
    }
}
