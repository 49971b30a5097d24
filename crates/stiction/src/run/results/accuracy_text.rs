//! How accurate an answer is, in words.

use super::rows::Rows;
use crate::io::text::number;
use crate::run::solve::{AccuracyRecord, BoundRecord, GoalRecord, LARGEST_PRESSURE, LevelRecord, ValueRecord};

/// Bars of values below this part of them are printed as such a part.
const SMALLEST: f64 = 1e-6;

/// What an estimate is said to be of.
pub(in crate::run) const ESTIMATED: &str = "the error of the stresses in the mean is estimated at";

/// What the sequence of meshes has reached, and its values.
pub(in crate::run) fn rows(rows: &mut Rows, accuracy: &AccuracyRecord) {
    let goals: Vec<String> = accuracy.goals.iter().map(|of| goal(of, &accuracy.values)).collect();
    let verdict = if accuracy.reached { "reached" } else { "NOT REACHED" };
    let last = accuracy.levels.last().map_or(0, |level| level.level + 1);
    rows.add("accuracy", format!("{verdict} on mesh {last}: {}", goals.join(", ")));
    if let Some(why) = &accuracy.ended {
        let needed = accuracy.needed_unknowns.map(|needed| format!("; {} unknowns are needed", rounded(needed)));
        rows.more(format!("refinement ended: {why}{}", needed.unwrap_or_default()));
    }
    // Those of earlier load steps where a goal is one of values, which it is of.
    let of_values = accuracy.goals.iter().any(|goal| goal.name != "energy");
    let shown = accuracy.values.iter().filter(|value| of_values || value.t.is_none());
    shown.for_each(|value| rows.more(with_bar(value)));
    accuracy.warnings.iter().for_each(|warning| rows.add("warning", warning.clone()));
}

/// The bound of the error, or why there is none.
pub(super) fn bound(rows: &mut Rows, bound: &BoundRecord) {
    let BoundRecord { standing, reason, error, mean_error, .. } = bound;
    match (error, mean_error, reason) {
        (Some(error), Some(mean), _) => rows.add(
            "bound",
            format!(
                "{standing}: the error of the stresses in the mean is at most {}, of the mean stress {}",
                percent(*error),
                percent(*mean)
            ),
        ),
        (.., Some(reason)) => rows.add("bound", format!("none: {reason}")),
        _ => rows.add("bound", format!("{standing}, and above all stress there is: the mesh is too coarse")),
    }
}

/// A goal and what was reached.
fn goal(goal: &GoalRecord, values: &[ValueRecord]) -> String {
    let mut peaks = values.iter().filter(|value| value.name.starts_with(LARGEST_PRESSURE)).peekable();
    if goal.name == "pressure" && peaks.peek().is_some() && peaks.all(|peak| peak.value.is_none()) {
        return "pressure grows without bound and is no goal".into();
    }
    let reached = goal.reached.map_or("not known yet".to_string(), percent);
    let name = if goal.name == "energy" { "energy norm" } else { &goal.name };
    format!("{name} {reached} ({} asked)", percent(goal.asked))
}

/// A value and its bar.
pub(super) fn with_bar(ValueRecord { name, value, bar, .. }: &ValueRecord) -> String {
    match (value, bar) {
        (None, _) => format!("{name}: grows without bound as the mesh is refined, it has no value"),
        (Some(value), None) => format!("{name} {}, error not known", number(*value)),
        (Some(value), Some(bar)) if *value != 0.0 => {
            format!("{name} {} within {}", number(*value), percent((bar / value.abs()).max(SMALLEST)))
        }
        (Some(value), Some(bar)) => format!("{name} {} within {}", number(*value), number(*bar)),
    }
}

/// A level in one line.
pub fn level(level: &LevelRecord) -> String {
    let LevelRecord { unknowns, points, error, bound, iterations, cpu_seconds, .. } = level;
    let bound = bound.map_or(String::new(), |bound| format!("  bound {}", percent(bound)));
    format!(
        "mesh {:>2}  {unknowns:>8} unknowns  {points:>6} points  error {:>7}  iterations {iterations:>3}  {cpu_seconds:.2} s{bound}",
        level.level + 1,
        percent(*error),
    )
}

/// A part of one with two digits.
pub(in crate::run) fn percent(part: f64) -> String {
    let percent = 100.0 * part;
    let digits = (1.0 - percent.abs().log10().floor()).clamp(0.0, 8.0);
    if percent == 0.0 || !percent.is_finite() {
        format!("{percent} %")
    } else {
        format!("{percent:.*} %", digits as usize)
    }
}

/// Two digits.
fn rounded(count: f64) -> String {
    if count >= 1e9 {
        "more than a thousand million".into()
    } else if count >= 1e6 {
        format!("about {:.1} million", count / 1e6)
    } else {
        format!("about {:.0} 000", (count / 1000.0).max(1.0))
    }
}
