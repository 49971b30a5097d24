//! Curves over time, one panel below the other.

use super::camera::Area;
use super::color::{GRID, INK, Rgb};
use super::decor::{self, BODY, SMALL, with_unit};
use super::drawing::{Align, Drawing};
use super::font;
use super::ticks::ticks;

/// Curves that share an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryPanel<'a> {
    /// What the axis shows.
    pub label: &'a str,
    /// Unit at the vertical axis.
    pub unit_label: &'a str,
    /// Name and values, one for each time; what is not finite is left out.
    pub curves: Vec<(&'a str, Vec<f64>)>,
}

const COLORS: [Rgb; 4] = [[0, 92, 158], [192, 57, 43], [39, 125, 67], [125, 82, 160]];

/// Draws the panels over the times, which ascend. At most four curves a panel are distinguished by colour.
pub fn history(times: &[f64], panels: &[HistoryPanel], title: &str, subtitle: &str) -> Drawing {
    const HEIGHT: f64 = 380.0;
    const BETWEEN: f64 = 90.0;
    let count = panels.len().max(1) as f64;
    let mut drawing = Drawing::new(1400, (170.0 + count * (HEIGHT + BETWEEN) + 20.0) as usize);
    let [first, last] = range(times.iter().copied());
    for (number, panel) in panels.iter().enumerate() {
        let top = 170.0 + number as f64 * (HEIGHT + BETWEEN);
        let area = Area { left: 130.0, top, right: 1350.0, bottom: top + HEIGHT };
        draw(&mut drawing, area, times, [first, last], panel);
    }
    let middle = [740.0, drawing.height as f64 - 40.0];
    drawing.text(&with_unit("Time t", ticks(first, last, 8).exponent, ""), middle, BODY, INK, Align::Center);
    decor::heading(&mut drawing, title, subtitle);
    drawing
}

/// Least and greatest finite value and zero, never the same.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = values.filter(|v| v.is_finite()).fold([0.0f64; 2], |[low, high], v| [low.min(v), high.max(v)]);
    if low < high { [low, high] } else { [low, low + 1.0] }
}

fn draw(drawing: &mut Drawing, area: Area, times: &[f64], [first, last]: [f64; 2], panel: &HistoryPanel) {
    let [low, high] = range(panel.curves.iter().flat_map(|(_, values)| values.iter().copied()));
    // The curves keep off the frame.
    let (low, high) = (if low < 0.0 { low - 0.05 * (high - low) } else { low }, high + 0.05 * (high - low));
    let x = |t: f64| area.left + (area.right - area.left) * (t - first) / (last - first);
    let y = |v: f64| area.bottom - (area.bottom - area.top) * (v - low) / (high - low);
    for (t, text) in ticks(first, last, 8).marks {
        drawing.line(vec![[x(t), area.top], [x(t), area.bottom]], 1.0, GRID);
        drawing.text(&text, [x(t), area.bottom + 24.0], SMALL, INK, Align::Center);
    }
    let up = ticks(low, high, 7);
    for (v, text) in &up.marks {
        let color = if *v == 0.0 { INK } else { GRID };
        drawing.line(vec![[area.left, y(*v)], [area.right, y(*v)]], 1.0, color);
        drawing.text(text, [area.left - 14.0, y(*v)], SMALL, INK, Align::Right);
    }
    drawing.frame([area.left, area.top], [area.right, area.bottom], 1.0, INK);
    let heading = with_unit(panel.label, up.exponent, panel.unit_label);
    drawing.text(&heading, [area.left, area.top - 24.0], BODY, INK, Align::Left);
    let mut right = area.right;
    for (number, (name, values)) in panel.curves.iter().enumerate().rev() {
        let color = COLORS[number % COLORS.len()];
        drawing.text(name, [right, area.top - 24.0], SMALL, color, Align::Right);
        right -= font::width(name, SMALL) + 30.0;
        let shown: Vec<[f64; 2]> =
            times.iter().zip(values).filter(|(_, v)| v.is_finite()).map(|(&t, &v)| [x(t), y(v)]).collect();
        // Markers that would cover each other say nothing that the line does not.
        if shown.len() < 100 {
            shown.iter().for_each(|&p| drawing.disc(p, 4.0, color));
        }
        drawing.line(shown, 2.5, color);
    }
}

#[cfg(test)]
mod tests {
    use super::range;

    #[test]
    fn ranges_hold_zero_and_are_never_empty() {
        assert_eq!(range([3.0, f64::NAN, -1.0].into_iter()), [-1.0, 3.0]);
        assert_eq!(range([3.0, 2.0].into_iter()), [0.0, 3.0]);
        assert_eq!(range(std::iter::empty()), [0.0, 1.0]);
    }
}
