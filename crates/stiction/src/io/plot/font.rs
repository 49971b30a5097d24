//! Outlines and lengths of texts in the font that is part of the program.

use std::sync::LazyLock;

use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// Height of the letters (em) over the distance of the lines of DejaVu Sans: 2048 over 1901 + 483 units.
pub(super) const EM: f64 = 0.859;
/// From the middle of capitals and digits down to the base line, in em: half of 1493 / 2048.
pub(super) const MIDDLE: f64 = 0.364;

static FACE: LazyLock<Face> = LazyLock::new(|| {
    let bytes = include_bytes!("../../../assets/DejaVuSans-subset.ttf");
    Face::parse(bytes, 0).expect("the font is part of the program")
});

/// The glyph of a letter and how far it moves on, in units of the font; where the font lacks it an empty box, for white
/// space the space.
fn glyph(letter: char) -> (GlyphId, f64) {
    let space = || letter.is_whitespace().then(|| FACE.glyph_index(' ')).flatten();
    let glyph = FACE.glyph_index(letter).or_else(space).unwrap_or(GlyphId(0));
    (glyph, f64::from(FACE.glyph_hor_advance(glyph).unwrap_or(0)))
}

/// Pixels a unit of the font where lines are `size` pixels apart.
fn scale(size: f64) -> f64 {
    EM * size / f64::from(FACE.units_per_em())
}

/// The length of a text whose lines are `size` apart, in the unit of `size`.
pub(super) fn width(text: &str, size: f64) -> f64 {
    scale(size) * text.chars().map(|letter| glyph(letter).1).sum::<f64>()
}

/// A text shortened to `room` by an ellipsis.
pub(super) fn fitting(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_string();
    }
    let mut used = 0.0;
    let fits = |letter: &char| {
        used += scale(size) * glyph(*letter).1;
        used <= room - size
    };
    text.chars().take_while(fits).collect::<String>().trim_end().to_string() + "…"
}

/// The outline of a text that begins at `start` on the base line, pixels; `None` if it has no ink.
pub(super) fn outline(text: &str, size: f64, start: [f64; 2]) -> Option<Path> {
    let scale = scale(size);
    let mut pen = Pen { path: PathBuilder::new(), start, scale };
    for letter in text.chars() {
        let (glyph, advance) = glyph(letter);
        FACE.outline_glyph(glyph, &mut pen);
        pen.start[0] += scale * advance;
    }
    pen.path.finish()
}

/// Draws glyphs from where the next one begins.
struct Pen {
    path: PathBuilder,
    start: [f64; 2],
    scale: f64,
}

impl Pen {
    /// A point of the glyph in the picture.
    fn at(&self, x: f32, y: f32) -> [f32; 2] {
        [self.start[0] + self.scale * f64::from(x), self.start[1] - self.scale * f64::from(y)].map(|v| v as f32)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ([x1, y1], [x, y]) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ([x1, y1], [x2, y2], [x, y]) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_as_long_as_their_letters_and_long_ones_are_shortened() {
        // DejaVu Sans: all digits are 1303 units wide.
        assert!((width("0123", 2384.0) / (4.0 * 1303.0) - 1.0).abs() < 1e-3);
        let bounds = outline("10", 100.0, [7.0, 50.0]).unwrap().bounds();
        assert!(bounds.left() > 7.0 && f64::from(bounds.right()) < 7.0 + width("10", 100.0), "{bounds:?}");
        // Digits stand on the base line and are about as high as capitals.
        assert!((f64::from(bounds.top()) - (50.0 - 200.0 * EM * MIDDLE)).abs() < 3.0, "{bounds:?}");
        assert!(bounds.bottom() < 53.0 && outline(" ", 20.0, [0.0; 2]).is_none());
        let short = fitting("a rather long title of a picture", 24.0, 120.0);
        assert!(short.ends_with('…') && width(&short, 24.0) <= 120.0, "{short}");
        assert_eq!(fitting("short", 24.0, 120.0), "short");
    }

    #[test]
    fn the_font_has_what_the_pictures_write() {
        let letters = "aZ09 .,:;()[]/+−×·–…∞°%⁻⁰¹²³⁴⁵⁶⁷⁸⁹₁₂₃₄λαΓΩπ\u{2009}";
        letters.chars().for_each(|letter| assert!(glyph(letter).0 != GlyphId(0), "{letter}"));
    }
}
