//! What stands beside a picture: title, colour bar, legend, triad of axes.

use super::camera::{Area, Camera};
use super::color::{INK, OUTSIDE, Paint, Rgb, STATUS, viridis};
use super::drawing::{Align, Drawing};
use super::font;
use super::ticks::{ten_to, ticks};

/// Heights of texts, pixels.
const TITLE: f64 = 36.0;
pub(super) const BODY: f64 = 24.0;
pub(super) const SMALL: f64 = 22.0;

const MARGIN: f64 = 40.0;
const QUIET: Rgb = [95, 95, 95];

/// Title and, under it, a quieter line.
pub(super) fn heading(drawing: &mut Drawing, title: &str, subtitle: &str) {
    let width = drawing.width as f64 - 2.0 * MARGIN;
    drawing.text(&font::fitting(title, TITLE, width), [MARGIN, 42.0], TITLE, INK, Align::Left);
    drawing.text(&font::fitting(subtitle, BODY, width), [MARGIN, 82.0], BODY, QUIET, Align::Left);
}

/// `label [10⁻³ m]`, without what is empty.
pub(super) fn with_unit(label: &str, exponent: i32, unit: &str) -> String {
    let factor = if exponent == 0 { String::new() } else { ten_to(exponent) };
    let inside = [factor.as_str(), unit].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(" ");
    if inside.is_empty() { label.to_string() } else { format!("{label} [{inside}]").trim_start().to_string() }
}

/// The colour bar or legend at the top of `area`; returns where it ends, pixels from the top.
pub(super) fn key(drawing: &mut Drawing, area: Area, paint: Paint, label: &str, unit: &str) -> f64 {
    match paint {
        Paint::Scalar { range, .. } => color_bar(drawing, area, range, label, unit),
        Paint::Status(status) => legend(drawing, area, status),
    }
}

fn color_bar(drawing: &mut Drawing, area: Area, [low, high]: [f64; 2], label: &str, unit: &str) -> f64 {
    const WIDTH: f64 = 30.0;
    const STRIPES: usize = 200;
    let Area { left, top, right, bottom } = area;
    let count = ((bottom - top) / 90.0).clamp(2.0, 8.0) as usize;
    let ticks = ticks(low, high, count);
    let room = right - left;
    drawing.text(&font::fitting(label, BODY, room), [left, top + 12.0], BODY, INK, Align::Left);
    drawing.text(&with_unit("", ticks.exponent, unit), [left, top + 42.0], SMALL, INK, Align::Left);
    let (first, last) = (top + 70.0, bottom - 8.0);
    for i in 0..STRIPES {
        let [from, to] = [i, i + 1].map(|i| i as f64 / STRIPES as f64);
        let color = viridis(1.0 - 0.5 * (from + to));
        // Each reaches below the next, which lies on it: no seam shows between them.
        let [y, end] = [from, (to + 1.0 / STRIPES as f64).min(1.0)].map(|t| first + t * (last - first));
        drawing.polygon(vec![[left, y], [left + WIDTH, y], [left + WIDTH, end], [left, end]], color, None);
    }
    drawing.frame([left, first], [left + WIDTH, last], 1.0, INK);
    for (value, text) in ticks.marks {
        let y = last - (value - low) / (high - low) * (last - first);
        drawing.line(vec![[left + WIDTH, y], [left + WIDTH + 8.0, y]], 1.0, INK);
        drawing.text(&text, [left + WIDTH + 15.0, y], SMALL, INK, Align::Left);
    }
    bottom
}

fn legend(drawing: &mut Drawing, area: Area, status: &[u8]) -> f64 {
    let entries = states(status);
    let count = entries.len();
    for (i, (name, color)) in entries.into_iter().enumerate() {
        let y = area.top + 16.0 + 40.0 * i as f64;
        let (left, right, top, bottom) = (area.left, area.left + 30.0, y - 12.0, y + 12.0);
        drawing.polygon(vec![[left, top], [right, top], [right, bottom], [left, bottom]], color, Some(INK));
        drawing.text(name, [area.left + 44.0, y], BODY, INK, Align::Left);
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
pub(super) fn triad(drawing: &mut Drawing, camera: &Camera) {
    const LENGTH: f64 = 62.0;
    const COLORS: [Rgb; 3] = [[192, 57, 43], [39, 128, 74], [41, 98, 174]];
    let origin = [MARGIN + 50.0, drawing.height as f64 - MARGIN - 50.0];
    let [right, up, toward] = camera.axes;
    // Farther axes first, nearer ones over them.
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| toward[a].total_cmp(&toward[b]));
    for axis in order {
        let (dx, dy) = (LENGTH * right[axis], -LENGTH * up[axis]);
        let tip = [origin[0] + dx, origin[1] + dy];
        let length = dx.hypot(dy);
        drawing.arrow(origin, tip, 3.0, (0.6 * length).min(14.0), COLORS[axis]);
        // An axis that points at the observer has no room for its name.
        if length > 10.0 {
            let name = [tip[0] + 15.0 * dx / length, tip[1] + 15.0 * dy / length];
            drawing.text(["x", "y", "z"][axis], name, BODY, COLORS[axis], Align::Center);
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
