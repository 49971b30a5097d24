//! How the residual fell.

use super::camera::Area;
use super::color::{GRID, INK, Rgb};
use super::decor::{self, BODY, SMALL, with_unit};
use super::drawing::{Align, Drawing};
use super::ticks::{grouped, number, ten_to, ticks};

/// The state of a solution after an iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvergencePoint {
    /// Number of the iteration.
    pub iteration: usize,
    /// Products with the operator so far.
    pub products: usize,
    /// Relative residual, > 0; what is not is left out.
    pub residual: f64,
}

const LINE: Rgb = [0, 92, 158];
const LIMIT: Rgb = [192, 57, 43];

/// Draws the residual, on a logarithmic scale, against the products with the operator. `tolerance` is drawn
/// as a line if it is positive.
pub fn convergence(points: &[ConvergencePoint], tolerance: f64, title: &str) -> Drawing {
    let mut drawing = Drawing::new(1400, 900);
    let area = Area { left: 130.0, top: 160.0, right: 1350.0, bottom: 800.0 };
    let shown: Vec<&ConvergencePoint> = points.iter().filter(|p| p.residual.is_finite() && p.residual > 0.0).collect();
    let limit = Some(tolerance).filter(|t| t.is_finite() && *t > 0.0);
    let tens: Vec<f64> = shown.iter().map(|p| p.residual).chain(limit).map(f64::log10).collect();
    let low = tens.iter().copied().reduce(f64::min).map_or(-1, |t| (t - 0.1).floor() as i32);
    let high = tens.iter().copied().reduce(f64::max).map_or(0, |t| t.ceil() as i32).max(low + 1);
    let most = shown.iter().map(|p| p.products).max().unwrap_or(0).max(1) as f64;
    let x = |products: f64| area.left + (area.right - area.left) * products / (1.02 * most);
    let y = |ten: f64| area.bottom - (area.bottom - area.top) * (ten - f64::from(low)) / f64::from(high - low);

    for ten in decades(low, high) {
        let at = y(f64::from(ten));
        drawing.line(vec![[area.left, at], [area.right, at]], 1.0, GRID);
        drawing.text(&ten_to(ten), [area.left - 14.0, at], SMALL, INK, Align::Right);
    }
    let across = ticks(0.0, 1.02 * most, 8);
    for (value, text) in &across.marks {
        // There is no half product.
        if value.fract() == 0.0 {
            drawing.line(vec![[x(*value), area.top], [x(*value), area.bottom]], 1.0, GRID);
            drawing.text(whole(text), [x(*value), area.bottom + 24.0], SMALL, INK, Align::Center);
        }
    }
    drawing.frame([area.left, area.top], [area.right, area.bottom], 1.0, INK);
    if let Some(limit) = limit {
        let at = y(limit.log10());
        let dash = 14.0;
        let dashes = ((area.right - area.left) / (2.0 * dash)).ceil() as usize;
        for i in 0..dashes {
            let from = area.left + 2.0 * dash * i as f64;
            drawing.line(vec![[from, at], [(from + dash).min(area.right), at]], 2.0, LIMIT);
        }
        let text = format!("tolerance {}", number(limit));
        // Beside the falling residual, which ends at the lower right.
        drawing.text(&text, [area.left + 14.0, at - 18.0], SMALL, LIMIT, Align::Left);
    }
    let place = |p: &ConvergencePoint| [x(p.products as f64), y(p.residual.log10())];
    drawing.line(shown.iter().map(|p| place(p)).collect(), 2.5, LINE);
    // Markers that would cover each other say nothing that the line does not.
    let radius = if shown.len() < 100 { 5.0 } else { 3.0 };
    if shown.len() < 250 {
        shown.iter().for_each(|p| drawing.disc(place(p), radius, LINE));
    }
    drawing.text("Relative residual", [area.left, area.top - 24.0], BODY, INK, Align::Left);
    let label = with_unit("Products with the operator, in total", across.exponent, "");
    drawing.text(&label, [0.5 * (area.left + area.right), area.bottom + 66.0], BODY, INK, Align::Center);
    decor::heading(&mut drawing, title, &summary(points));
    drawing
}

/// The powers of ten from `low` to `high` that are marked: all, or the multiples of the least step that leaves few.
fn decades(low: i32, high: i32) -> impl Iterator<Item = i32> {
    const MOST: i32 = 12; // labels on the axis that do not crowd it
    let every = (high - low + MOST - 1) / MOST;
    (low..=high).filter(move |ten| ten % every.max(1) == 0)
}

/// `5` for `5.0`.
fn whole(text: &str) -> &str {
    text.strip_suffix(".0").unwrap_or(text)
}

fn summary(points: &[ConvergencePoint]) -> String {
    let Some(last) = points.last() else { return "no iterations".to_string() };
    let (iterations, products) = (grouped(last.iteration), grouped(last.products));
    format!("{iterations} iterations  ·  {products} products  ·  residual {}", number(last.residual))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marked_decades_are_all_or_round_and_within_the_axis() {
        let marks = |low, high| decades(low, high).collect::<Vec<_>>();
        assert_eq!(marks(-9, 1), (-9..=1).collect::<Vec<_>>());
        assert_eq!(marks(-13, 2), [-12, -10, -8, -6, -4, -2, 0, 2]);
        assert_eq!(marks(-20, 5), [-18, -15, -12, -9, -6, -3, 0, 3]);
        assert_eq!(marks(-301, 0).len(), 12);
    }
}
