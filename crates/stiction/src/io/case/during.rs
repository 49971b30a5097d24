//! In which steps something holds.

use super::data::{ContactSpec, StepSpec};

/// The first and the last step in which something holds, by their places in `Case::steps`; `None` is the first and the
/// last of all.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct During {
    /// The first of them.
    pub from: Option<usize>,
    /// The last of them.
    pub until: Option<usize>,
}

impl During {
    /// Time after which it holds and until which, without bounds where it has none.
    pub fn period(&self, steps: &[StepSpec]) -> [f64; 2] {
        let end = |step: Option<usize>| step.and_then(|step| steps.get(step)).map(|step| step.until);
        let begin = end(self.from.and_then(|from| from.checked_sub(1)));
        let last = steps.len().checked_sub(1);
        let end = end(self.until.filter(|&until| Some(until) != last));
        [begin.unwrap_or(f64::NEG_INFINITY), end.unwrap_or(f64::INFINITY)]
    }
}

impl ContactSpec {
    /// The stretches of time in which it holds: after the first time of each, until the second, without bounds at both ends.
    pub fn periods(&self, steps: &[StepSpec]) -> Vec<[f64; 2]> {
        if self.without.is_empty() {
            return vec![self.during.period(steps)];
        }
        let mut periods: Vec<[f64; 2]> = Vec::new();
        for step in (0..steps.len()).filter(|step| !self.without.contains(step)) {
            let During { from: first, until: last } = self.during;
            if first.is_some_and(|first| step < first) || last.is_some_and(|last| step > last) {
                continue;
            }
            let [begin, end] = During { from: Some(step), until: Some(step) }.period(steps);
            match periods.last_mut().filter(|period| period[1] == begin) {
                Some(period) => period[1] = end,
                None => periods.push([begin, end]),
            }
        }
        periods
    }
}
