//! Drawings as pixels.

use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke as Pen, Transform};

use super::color::Rgb;
use super::drawing::{Align, Drawing, Shape, Stroke};
use super::font;
use super::raster::{self, Image};

/// The picture, opaque; `None` if it has no pixels or more than memory.
pub(super) fn pixels(drawing: &Drawing) -> Option<Pixmap> {
    let mut picture = Pixmap::new(u32::try_from(drawing.width).ok()?, u32::try_from(drawing.height).ok()?)?;
    picture.fill(Color::WHITE);
    drawing.shapes.iter().for_each(|shape| draw(&mut picture, shape));
    Some(picture)
}

/// Red, green and blue of each pixel, in rows.
pub(super) fn rgb(picture: &Pixmap) -> Vec<u8> {
    raster::rgb(picture.data().as_chunks().0)
}

fn draw(picture: &mut Pixmap, shape: &Shape) {
    match shape {
        Shape::Image(image) => copy(picture, image),
        Shape::Polygon { corners, fill, edge } => {
            let ring: Vec<[f64; 2]> = corners.iter().chain(&corners[..1]).copied().collect();
            let ring = crisp(&ring, edge.width).unwrap_or(ring);
            path(&ring, true).inspect(|path| ink(picture, path, *fill));
            stroke(picture, &ring, *edge);
        }
        Shape::Line { points, stroke: pen } => stroke(picture, points, *pen),
        Shape::Disc { center, radius, color } => {
            let [x, y] = center.map(|v| v as f32);
            PathBuilder::from_circle(x, y, *radius as f32).inspect(|path| ink(picture, path, *color));
        }
        Shape::Text { text, at, size, color, align } => {
            let length = font::width(text, *size);
            let left = match align {
                Align::Left => at[0],
                Align::Center => at[0] - 0.5 * length,
                Align::Right => at[0] - length,
            };
            // On a row of pixels letters have a sharp foot.
            let start = [left, (at[1] + font::MIDDLE * font::EM * size).round()];
            font::outline(text, *size, start).inspect(|path| ink(picture, path, *color));
        }
    }
}

/// A line `width` wide moved so that it fills whole pixels; `None` unless all its parts run along rows and columns.
fn crisp(points: &[[f64; 2]], width: f64) -> Option<Vec<[f64; 2]>> {
    let is_along = |w: &[[f64; 2]]| w[0][0] == w[1][0] || w[0][1] == w[1][1];
    let moved = || points.iter().map(|p| p.map(|v| (v - 0.5 * width).round() + 0.5 * width)).collect();
    (width.fract() == 0.0 && points.windows(2).all(is_along)).then(moved)
}

fn path(points: &[[f64; 2]], is_closed: bool) -> Option<tiny_skia::Path> {
    let mut path = PathBuilder::new();
    for (i, [x, y]) in points.iter().map(|p| p.map(|v| v as f32)).enumerate() {
        if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    if is_closed {
        path.close();
    }
    path.finish()
}

fn paint([r, g, b]: Rgb) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 255);
    paint
}

/// Fills a path.
fn ink(picture: &mut Pixmap, path: &tiny_skia::Path, color: Rgb) {
    picture.fill_path(path, &paint(color), FillRule::Winding, Transform::identity(), None);
}

fn stroke(picture: &mut Pixmap, points: &[[f64; 2]], stroke: Stroke) {
    let moved = crisp(points, stroke.width);
    // Half a width more at both ends fills their pixels.
    let line_cap = if moved.is_some() { LineCap::Square } else { LineCap::Butt };
    let pen = Pen { width: stroke.width as f32, line_cap, line_join: LineJoin::Round, ..Pen::default() };
    let is_closed = points.len() > 2 && points.first() == points.last();
    if let Some(path) = path(moved.as_deref().unwrap_or(points), is_closed) {
        picture.stroke_path(&path, &paint(stroke.color), &pen, Transform::identity(), None);
    }
}

/// Each pixel the mean of four of the image.
fn copy(picture: &mut Pixmap, image: &Image) {
    let [left, top] = image.at;
    let rows = picture.width() as usize * 4;
    let below = picture.data_mut().chunks_exact_mut(rows).skip(top);
    for (to, from) in below.zip(image.pixels.chunks_exact(2 * image.width)) {
        let (upper, lower) = from.split_at(image.width);
        let pairs = upper.as_chunks().0.iter().zip(lower.as_chunks().0);
        for (pixel, (above, below)) in to.as_chunks_mut::<4>().0[left..].iter_mut().zip(pairs) {
            *pixel = mean([above, below]);
        }
    }
}

/// The mean of four pixels.
fn mean(of: [&[[u8; 4]; 2]; 2]) -> [u8; 4] {
    /// Every other byte: with the others apart four of each are added at once.
    const APART: u64 = 0x00ff_00ff_00ff_00ff;
    const HALF: u64 = 0x0002_0002;
    let words = of.map(|&[[a, b, c, d], [e, f, g, h]]| u64::from_le_bytes([a, b, c, d, e, f, g, h]));
    let [even, odd] = [0, 8].map(|shift| {
        let pairs = ((words[0] >> shift) & APART) + ((words[1] >> shift) & APART);
        ((pairs + (pairs >> 32) + HALF) >> 2) & APART
    });
    ((even | odd << 8) as u32).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Rgb = [0; 3];

    /// The blackness of each pixel, 0 to 255, and their sum in black pixels.
    fn drawn(width: usize, height: usize, draw: impl Fn(&mut Drawing)) -> (Vec<u8>, f64) {
        let mut drawing = Drawing::new(width, height);
        draw(&mut drawing);
        let ink: Vec<u8> = rgb(&pixels(&drawing).unwrap()).as_chunks::<3>().0.iter().map(|p| 255 - p[0]).collect();
        let sum = ink.iter().map(|&v| f64::from(v) / 255.0).sum();
        (ink, sum)
    }

    #[test]
    fn shapes_cover_their_areas() {
        let area = |draw: &dyn Fn(&mut Drawing)| drawn(100, 100, draw).1;
        let disc = area(&|d| d.disc([50.0, 50.0], 30.0, BLACK));
        assert!((disc / (900.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{disc}");
        let line = area(&|d| d.line(vec![[10.0, 10.0], [70.0, 90.0]], 4.0, BLACK));
        assert!((line / 400.0 - 1.0).abs() < 0.01, "{line}");
        // The shaft of 1 x 40 and a head 10 long and 8.4 wide, with an edge of a quarter of a pixel.
        let arrow = area(&|d| d.arrow([20.0, 50.0], [70.0, 50.0], 1.0, 10.0, BLACK));
        assert!((arrow - (40.0 + 42.0 + 8.0)).abs() < 4.0, "{arrow}");
    }

    #[test]
    fn lines_along_rows_and_columns_are_crisp() {
        for at in [20.0, 20.3, 20.5, 20.9] {
            let (ink, sum) = drawn(50, 50, |d| d.line(vec![[at, 10.0], [at, 30.0]], 1.0, BLACK));
            assert!(ink.iter().all(|&v| v == 0 || v > 250) && (sum - 21.0).abs() < 0.1, "{at}: {sum}");
        }
        let frame = |d: &mut Drawing| d.frame([10.2, 10.2], [30.2, 20.7], 2.0, BLACK);
        assert!(drawn(50, 50, frame).0.iter().filter(|&&v| v > 250).count() > 110);
    }

    #[test]
    fn texts_have_ink_where_they_stand() {
        let columns = |align: Align| {
            let (ink, _) = drawn(200, 40, |d| d.text("λ 10⁻³", [100.0, 20.0], 24.0, BLACK, align));
            assert!(ink.iter().any(|&v| v > 190));
            let used: Vec<usize> = (0..200).filter(|x| (0..40).any(|y| ink[200 * y + x] > 0)).collect();
            [used[0], used[used.len() - 1]]
        };
        let [left, center, right] = [Align::Left, Align::Center, Align::Right].map(columns);
        assert!(left[0] >= 99 && right[1] <= 101 && (center[0] + center[1]).abs_diff(200) < 6, "{center:?}");
    }

    #[test]
    fn a_picture_without_pixels_is_none() {
        assert!(pixels(&Drawing::new(0, 10)).is_none());
    }
}
