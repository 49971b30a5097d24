//! What a value of a deck does over the load steps.

use std::collections::HashMap;

/// Most ramps and jumps of a value: its expression has to stay readable.
pub(super) const MOST_TURNS: usize = 50;

/// How a value of a step is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Course {
    /// On a line from what it was.
    Ramp,
    /// At once.
    Instant,
    /// Times an amplitude, by its number. In later steps that do not name it the value stays, unless the amplitude runs through all
    /// steps.
    Amplitude(usize),
    /// Times an amplitude that begins anew with each step: temperatures.
    Anew(usize),
    /// It stays where it is.
    Stays,
    /// It ends with the step before.
    Ends,
}

/// Steps in a row in which a displacement is prescribed, by their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Span {
    pub first: usize,
    /// None goes on to the end.
    pub last: Option<usize>,
    /// Whether it is held where it stands when they begin.
    pub stays: bool,
    /// Whether it has its value at once when they begin, not on a line.
    pub at_once: bool,
}

/// A value that a step gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Change {
    step: usize,
    /// Bits of the number.
    value: u64,
    course: Course,
}

/// Values over the steps, each kept once.
#[derive(Default)]
pub(super) struct Histories {
    list: Vec<Vec<Change>>,
    known: HashMap<Vec<Change>, u32>,
}

/// A function of time on straight lines.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Amplitude {
    /// Time and value.
    pub points: Vec<[f64; 2]>,
    /// Whether its time runs through all steps.
    pub total: bool,
}

impl Amplitude {
    fn at(&self, t: f64) -> f64 {
        let after = self.points.partition_point(|p| p[0] < t);
        match (after.checked_sub(1).map(|i| self.points[i]), self.points.get(after)) {
            (Some([t0, v0]), Some(&[t1, v1])) => v0 + (v1 - v0) * ((t - t0) / (t1 - t0)),
            (Some([_, v]), None) | (None, Some(&[_, v])) => v,
            (None, None) => 1.0,
        }
    }
}

impl Histories {
    /// The history `old` with the value that `step` gives; with `add` it is added to one that the same step has given.
    /// `None` where values of one step cannot be added, as their courses differ.
    pub(super) fn change(
        &mut self,
        old: Option<u32>,
        step: usize,
        value: f64,
        course: Course,
        add: bool,
    ) -> Option<u32> {
        let mut changes = old.map_or(Vec::new(), |id| self.list[id as usize].clone());
        let mut change = Change { step, value: value.to_bits(), course };
        if let Some(last) = changes.pop_if(|last| last.step == step) {
            let before = f64::from_bits(last.value);
            if add && before != 0.0 {
                if last.course != course {
                    return None;
                }
                change.value = (before + value).to_bits();
            }
        }
        changes.push(change);
        let next = self.list.len() as u32;
        let id = *self.known.entry(changes.clone()).or_insert(next);
        if id == next {
            self.list.push(changes);
        }
        Some(id)
    }

    /// The step that changed a history last.
    pub(super) fn last_step(&self, id: u32) -> usize {
        self.list[id as usize].last().map_or(0, |change| change.step)
    }

    /// The steps in which what this history prescribes holds.
    pub(super) fn spans(&self, id: u32) -> Vec<Span> {
        let mut spans: Vec<Span> = Vec::new();
        for change in &self.list[id as usize] {
            let (first, stays) = (change.step, change.course == Course::Stays);
            let open = spans.last_mut().filter(|span| span.last.is_none());
            // What is led away from where it stays is held anew.
            let goes_on = open.as_ref().is_some_and(|span| change.course != Course::Ends && !stays && !span.stays);
            if goes_on {
                continue;
            }
            if let Some(open) = open {
                match first.checked_sub(1).filter(|_| first > open.first) {
                    Some(last) => open.last = Some(last),
                    None => {
                        spans.pop();
                    }
                }
            }
            if change.course != Course::Ends {
                let at_once = !stays && change.course != Course::Ramp;
                spans.push(Span { first, last: None, stays, at_once });
            }
        }
        spans
    }

    /// Time and value wherever it turns, from the value `start` on, for steps with these beginnings and ends. Two values
    /// at one time are a jump.
    pub(super) fn knots(&self, id: u32, start: f64, steps: &[[f64; 2]], amplitudes: &[Amplitude]) -> Vec<[f64; 2]> {
        let (mut knots, mut active): (Vec<[f64; 2]>, Option<(f64, usize)>) = (vec![[0.0, start]], None);
        let mut anew = false;
        for (number, &[begin, end]) in steps.iter().enumerate() {
            let now = knots.last().map_or(start, |knot| knot[1]);
            let change = self.list[id as usize].iter().find(|change| change.step == number);
            match change.map(|change| (f64::from_bits(change.value), change.course)) {
                Some((value, Course::Ramp)) => (active, knots) = (None, [knots, vec![[end, value]]].concat()),
                Some((value, Course::Instant)) => {
                    (active, knots) = (None, [knots, vec![[begin, value], [end, value]]].concat());
                }
                Some((value, course @ (Course::Amplitude(which) | Course::Anew(which)))) => {
                    active = Some((value, which));
                    anew = amplitudes[which].total || matches!(course, Course::Anew(_));
                }
                Some((_, Course::Stays | Course::Ends)) => {
                    active = None;
                    knots.push([end, now]);
                }
                None if active.is_some() && anew => {}
                None => {
                    active = None;
                    knots.push([end, now]);
                }
            }
            if let Some((value, which)) = active {
                let amplitude = &amplitudes[which];
                let from = if amplitude.total { 0.0 } else { begin };
                let inner = amplitude.points.iter().map(|p| p[0] + from).filter(|&t| begin < t && t < end);
                let times = std::iter::once(begin).chain(inner).chain([end]);
                knots.extend(times.map(|t| [t, value * amplitude.at(t - from)]));
            }
        }
        tidied(knots)
    }
}

/// Without points on a line through their neighbours, and without a jump at the beginning, where nothing is solved.
fn tidied(knots: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for knot in knots {
        if kept.last() == Some(&knot) {
            continue;
        }
        if let [.., [a, u], [b, v]] = kept[..] {
            // On one line, or both values there at one time.
            let flat = u == v && v == knot[1];
            if flat || a == b && b == knot[0] {
                kept.pop();
            }
        }
        if kept.last().is_some_and(|last| last[0] == 0.0 && knot[0] == 0.0) {
            kept.pop();
        }
        kept.push(knot);
    }
    kept
}

/// The value at the end, where a case has no load steps, or an expression in t.
pub(super) fn written(knots: &[[f64; 2]], single: bool) -> Value {
    let end = knots.last().copied().unwrap_or_default();
    if single || knots.iter().all(|knot| knot[1] == end[1]) {
        return Value::Number(end[1]);
    }
    let mut terms: Vec<(f64, String)> = Vec::new();
    if knots[0][1] != 0.0 {
        terms.push((knots[0][1], String::new()));
    }
    for pair in knots.windows(2) {
        let ([a, u], [b, v]) = (pair[0], pair[1]);
        let rise = v - u;
        let factor = match (a == b, a == 0.0, b == end[0]) {
            _ if rise == 0.0 => continue,
            (true, ..) => format!("min(max(-floor({a} - t), 0), 1)"),
            (false, true, true) if b == 1.0 => "t".to_string(),
            (false, true, true) => format!("t/{b}"),
            (false, true, false) if b == 1.0 => "min(t, 1)".into(),
            (false, true, false) => format!("min(t/{b}, 1)"),
            (false, false, true) if b - a == 1.0 => format!("max(t - {a}, 0)"),
            (false, false, true) => format!("max((t - {a})/({b} - {a}), 0)"),
            (false, false, false) if b - a == 1.0 => format!("min(max(t - {a}, 0), 1)"),
            (false, false, false) => format!("min(max((t - {a})/({b} - {a}), 0), 1)"),
        };
        terms.push((rise, factor));
    }
    let mut text = String::new();
    for (number, (rise, factor)) in terms.iter().enumerate() {
        let sign = match (number, *rise < 0.0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        let size = rise.abs();
        let product = if factor.is_empty() { format!("{size}") } else { format!("{size}*{factor}") };
        text += &format!("{sign}{product}");
    }
    Value::Expression(text)
}

/// A value of a case file.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Expression(String),
}

impl Value {
    /// The value times a factor.
    pub(super) fn times(self, factor: f64) -> Value {
        match self {
            value if factor == 1.0 => value,
            Value::Number(x) => Value::Number(x * factor),
            Value::Expression(text) => Value::Expression(format!("({text})*{factor}")),
        }
    }

    /// As TOML.
    pub(super) fn toml(&self) -> String {
        match self {
            Value::Number(x) => number(*x),
            Value::Expression(text) => format!("\"{text}\""),
        }
    }
}

/// A number as TOML, to the last bit.
pub(super) fn number(x: f64) -> String {
    let plain = format!("{}", x + 0.0);
    let short = format!("{:e}", x + 0.0);
    if short.len() < plain.len() { short } else { plain }
}
