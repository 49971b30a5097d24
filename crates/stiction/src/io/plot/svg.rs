//! Drawings as SVG 1.1, complete in themselves: no style sheet, no font file.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::color::Rgb;
use super::drawing::{Align, Drawing, Shape, Stroke};
use super::font::{EM, MIDDLE};
use super::raster::FINE;
use crate::io::text::escaped;

/// The text of the file.
pub(super) fn text(drawing: &Drawing) -> String {
    let (w, h) = (drawing.width, drawing.height);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
         font-family=\"'DejaVu Sans', Verdana, sans-serif\" stroke-linejoin=\"round\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n"
    );
    drawing.shapes.iter().for_each(|s| svg += &shape(s));
    svg + "</svg>\n"
}

fn shape(shape: &Shape) -> String {
    match shape {
        Shape::Image(image) => {
            let ([x, y], [w, h]) = (image.at, image.size().map(|size| size / FINE));
            let png = STANDARD.encode(image.png());
            format!(
                "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" xlink:href=\"data:image/png;base64,{png}\"/>\n"
            )
        }
        Shape::Polygon { corners, fill, edge } => {
            format!("<polygon points=\"{}\" fill=\"{}\" {}/>\n", points(corners), hex(*fill), stroked(*edge))
        }
        Shape::Line { points: p, stroke } => {
            format!("<polyline points=\"{}\" fill=\"none\" {}/>\n", points(p), stroked(*stroke))
        }
        Shape::Disc { center, radius, color } => {
            let [x, y, r] = [center[0], center[1], *radius].map(number);
            format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" fill=\"{}\"/>\n", hex(*color))
        }
        Shape::Text { text, at, size, color, align } => {
            let anchor = match align {
                Align::Left => "start",
                Align::Center => "middle",
                Align::Right => "end",
            };
            let (em, color) = (EM * size, hex(*color));
            format!(
                "<text x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"{color}\" text-anchor=\"{anchor}\">{}</text>\n",
                number(at[0]),
                number(at[1] + MIDDLE * em),
                number(em),
                escaped(text)
            )
        }
    }
}

fn points(points: &[[f64; 2]]) -> String {
    points.iter().map(|p| format!("{},{}", number(p[0]), number(p[1]))).collect::<Vec<_>>().join(" ")
}

/// Two decimals are a hundredth of a pixel.
fn number(x: f64) -> String {
    let text = format!("{x:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

fn stroked(stroke: Stroke) -> String {
    format!("stroke=\"{}\" stroke-width=\"{}\"", hex(stroke.color), number(stroke.width))
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
