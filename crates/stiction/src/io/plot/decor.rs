//! What stands beside a picture: title, colour bar, legend, triad of axes.

use super::camera::{Area, Camera};
use super::canvas::{Align, Canvas};
use super::color::{INK, OUTSIDE, Paint, Rgb, STATUS, viridis};
use super::ticks::{ten_to, ticks};

/// Heights of texts, pixels.
pub(super) const TITLE: f64 = 36.0;
pub(super) const BODY: f64 = 24.0;
pub(super) const SMALL: f64 = 22.0;

const MARGIN: f64 = 40.0;
const QUIET: Rgb = [95, 95, 95];

/// Title and, under it, a quieter line.
pub(super) fn heading(canvas: &mut Canvas, title: &str, subtitle: &str) {
    let width = canvas.width as f64 - 2.0 * MARGIN;
    canvas.text(&Canvas::fitting(title, TITLE, width), [MARGIN, 42.0], TITLE, INK, Align::Left);
    canvas.text(&Canvas::fitting(subtitle, BODY, width), [MARGIN, 82.0], BODY, QUIET, Align::Left);
}

/// `label [10⁻³ m]`, without what is empty.
pub(super) fn with_unit(label: &str, exponent: i32, unit: &str) -> String {
    let factor = if exponent == 0 { String::new() } else { ten_to(exponent) };
    let inside = [factor.as_str(), unit].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(" ");
    if inside.is_empty() { label.to_string() } else { format!("{label} [{inside}]").trim_start().to_string() }
}

/// The colour bar or legend at the top of `area`; returns where it ends, pixels from the top.
pub(super) fn key(canvas: &mut Canvas, area: Area, paint: Paint, label: &str, unit: &str) -> f64 {
    match paint {
        Paint::Scalar { range, .. } => color_bar(canvas, area, range, label, unit),
        Paint::Status(status) => legend(canvas, area, status),
    }
}

fn color_bar(canvas: &mut Canvas, area: Area, [low, high]: [f64; 2], label: &str, unit: &str) -> f64 {
    const WIDTH: f64 = 30.0;
    let Area { left, top, right, bottom } = area;
    let count = ((bottom - top) / 90.0).clamp(2.0, 8.0) as usize;
    let ticks = ticks(low, high, count);
    let room = right - left;
    canvas.text(&Canvas::fitting(label, BODY, room), [left, top + 12.0], BODY, INK, Align::Left);
    canvas.text(&with_unit("", ticks.exponent, unit), [left, top + 42.0], SMALL, INK, Align::Left);
    let (first, last) = (top + 70.0, bottom - 8.0);
    let rows = (2.0 * (last - first)) as usize;
    for i in 0..rows {
        let y = first + 0.5 * i as f64;
        let color = viridis(1.0 - (i as f64 + 0.5) / rows as f64);
        canvas.line([left, y], [left + WIDTH, y], 0.5, color);
    }
    canvas.frame([left, first], [left + WIDTH, last], 1.0, INK);
    for (value, text) in ticks.marks {
        let y = last - (value - low) / (high - low) * (last - first);
        canvas.line([left + WIDTH, y], [left + WIDTH + 8.0, y], 1.0, INK);
        canvas.text(&text, [left + WIDTH + 15.0, y], SMALL, INK, Align::Left);
    }
    bottom
}

fn legend(canvas: &mut Canvas, area: Area, status: &[u8]) -> f64 {
    let entries = states(status);
    let count = entries.len();
    for (i, (name, color)) in entries.into_iter().enumerate() {
        let y = area.top + 16.0 + 40.0 * i as f64;
        canvas.rectangle([area.left, y - 12.0], [area.left + 30.0, y + 12.0], color);
        canvas.frame([area.left, y - 12.0], [area.left + 30.0, y + 12.0], 1.0, INK);
        canvas.text(name, [area.left + 44.0, y], BODY, INK, Align::Left);
    }
    area.top + 16.0 + 40.0 * count as f64
}

/// The states that occur, with their colours.
fn states(status: &[u8]) -> Vec<(&'static str, Rgb)> {
    let known = (0..).zip(STATUS).filter(|(state, _)| status.contains(state)).map(|(_, entry)| entry);
    let outside = status.iter().any(|&s| usize::from(s) >= STATUS.len()).then_some(OUTSIDE);
    known.chain(outside).collect()
}

/// The directions of x, y and z, in the lower left corner.
pub(super) fn triad(canvas: &mut Canvas, camera: &Camera) {
    const LENGTH: f64 = 62.0;
    const COLORS: [Rgb; 3] = [[192, 57, 43], [39, 128, 74], [41, 98, 174]];
    let origin = [MARGIN + 50.0, canvas.height as f64 - MARGIN - 50.0];
    let [right, up, toward] = camera.axes;
    // Farther axes first, nearer ones over them.
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| toward[a].total_cmp(&toward[b]));
    for axis in order {
        let (dx, dy) = (LENGTH * right[axis], -LENGTH * up[axis]);
        let tip = [origin[0] + dx, origin[1] + dy];
        let length = dx.hypot(dy);
        canvas.arrow(origin, tip, 3.0, (0.6 * length).min(14.0), COLORS[axis]);
        // An axis that points at the observer has no room for its name.
        if length > 10.0 {
            let name = [tip[0] + 15.0 * dx / length, tip[1] + 15.0 * dy / length];
            canvas.text(["x", "y", "z"][axis], name, BODY, COLORS[axis], Align::Center);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_legend_names_the_states_that_occur() {
        let names = |status: &[u8]| states(status).into_iter().map(|s| s.0).collect::<Vec<_>>();
        assert_eq!(names(&[2, 0, 2]), ["open", "slip"]);
        assert_eq!(names(&[1, 255, 1]), ["stick", "held"]);
        assert!(names(&[]).is_empty());
    }
}
