//! Drawings as SVG 1.1, complete in themselves: no style sheet, no font file.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::color::Rgb;
use super::drawing::{Align, Drawing, Shape, Stroke};
use super::font::{EM, MIDDLE};

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
        Shape::Image(image) => format!(
            "<image width=\"100%\" height=\"100%\" xlink:href=\"data:image/png;base64,{}\"/>\n",
            STANDARD.encode(image.png())
        ),
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

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::super::raster::Raster;
    use super::*;

    #[test]
    fn shapes_become_elements_and_texts_cannot_break_out() {
        let mut drawing = Drawing::new(200, 100);
        drawing.image(Raster::new(&drawing).image());
        drawing.polygon(vec![[0.0, 0.0], [10.0, 0.0], [0.0, 10.5]], [255, 0, 16], None);
        drawing.line(vec![[1.0, 2.0], [f64::NAN, 0.0], [3.0, 4.0]], 2.0, [0, 0, 0]);
        drawing.arrow([0.0, 0.0], [50.0, 0.0], 1.0, 10.0, [0, 0, 0]);
        drawing.arrow([5.0, 5.0], [5.0, 5.0], 1.0, 10.0, [0, 0, 0]);
        drawing.disc([7.0, 8.5], 2.0, [0, 0, 255]);
        drawing.text("a < b & \"c\"", [20.0, 50.0], 20.0, [0, 0, 0], Align::Center);
        let svg = text(&drawing);
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
        assert!(svg.contains("<polygon points=\"0,0 10,0 0,10.5\" fill=\"#ff0010\""), "{svg}");
        assert!(svg.contains("points=\"1,2 3,4\"") && svg.contains("a &lt; b &amp; \"c\"</text>"), "{svg}");
        // The line ends where the head begins, whose corners are 0.42 of its length off the line.
        assert!(svg.contains("points=\"0,0 40,0\"") && svg.contains("points=\"50,0 40,4.2 40,-4.2\""), "{svg}");
        assert!(svg.contains("<circle cx=\"7\" cy=\"8.5\" r=\"2\" fill=\"#0000ff\"/>"), "{svg}");
        // What a PNG file begins with.
        assert!(svg.contains("base64,iVBORw0KGgo"), "{svg}");
        assert_eq!(svg.matches("<polygon").count(), 2);
        assert!(!svg.contains("NaN"));
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([number(3.0), number(0.126), number(-2.5), number(100.0)], ["3", "0.13", "-2.5", "100"]);
    }
}
