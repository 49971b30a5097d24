//! The time axis of the load steps, and how an increment that cannot be solved is halved.

use crate::io::case::StepSpec;

/// An increment is divided into so many parts at most, a power of two.
pub(crate) const PARTS: usize = 1 << MOST_HALVINGS;
/// Halvings of an increment before a step is given up.
pub(crate) const MOST_HALVINGS: usize = 6;

/// Where on the axis the next solve begins, and how far it reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Position {
    /// Index into the steps of the case; their number at the end of the axis.
    pub step: usize,
    /// Increments of the step that are done.
    pub increment: usize,
    /// Parts of the present increment that are done, < `PARTS`.
    pub part: usize,
    /// Parts the next solve takes, a power of two that divides `part`.
    pub size: usize,
}

impl Position {
    pub(crate) fn start() -> Self {
        Position { step: 0, increment: 0, part: 0, size: PARTS }
    }

    /// From what a file holds; `None` if it is no place on the axis of `steps`.
    pub(crate) fn read([step, increment, part, size]: [usize; 4], steps: &[StepSpec]) -> Option<Self> {
        let inside = match steps.get(step) {
            Some(spec) => increment < spec.increments,
            None => step == steps.len() && increment == 0 && part == 0,
        };
        let divides = size.is_power_of_two() && part.is_multiple_of(size) && part + size <= PARTS;
        (inside && divides).then_some(Position { step, increment, part, size })
    }

    pub(crate) fn write(&self) -> [usize; 4] {
        [self.step, self.increment, self.part, self.size]
    }

    /// Begin and end of the next solve; `None` at the end of the axis.
    pub(crate) fn span(&self, steps: &[StepSpec]) -> Option<[f64; 2]> {
        let spec = steps.get(self.step)?;
        let begin = if self.step == 0 { 0.0 } else { steps[self.step - 1].until };
        let parts = (spec.increments * PARTS) as f64;
        let time = |part: usize| {
            let done = self.increment * PARTS + part;
            // The end of a step is hit to the last digit.
            if done == spec.increments * PARTS {
                spec.until
            } else {
                begin + (spec.until - begin) * (done as f64 / parts)
            }
        };
        Some([time(self.part), time(self.part + self.size)])
    }

    /// After a solve that succeeded; the next one is twice as long where the axis allows it.
    pub(crate) fn advance(self, steps: &[StepSpec]) -> Self {
        let part = self.part + self.size;
        if part < PARTS {
            let double = part.is_multiple_of(2 * self.size);
            return Position { part, size: if double { 2 * self.size } else { self.size }, ..self };
        }
        let last = steps.get(self.step).is_none_or(|spec| self.increment + 1 >= spec.increments);
        let (step, increment) = if last { (self.step + 1, 0) } else { (self.step, self.increment + 1) };
        Position { step, increment, part: 0, size: (2 * self.size).min(PARTS) }
    }

    /// After a solve that failed: half as far, or `None` if that was the shortest.
    pub(crate) fn halve(self) -> Option<Self> {
        (self.size > 1).then_some(Position { size: self.size / 2, ..self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::case::parse;

    fn steps() -> Vec<StepSpec> {
        let text = "[mesh]\nblock = { size = [1, 1, 1], cells = [1, 1, 1] }\n[materials.a]\nyoung = 1\npoisson = 0\n\
                    [[step]]\nuntil = 0.3\nincrements = 3\n[[step]]\nuntil = 1\n";
        parse(text, "case", &[]).unwrap().steps
    }

    /// All solves fail whose length exceeds `longest`; begins and ends of those that do not.
    fn walk(longest: f64) -> (Vec<[f64; 2]>, usize) {
        let (steps, mut at, mut done, mut failed) = (steps(), Position::start(), Vec::new(), 0);
        while let Some([a, b]) = at.span(&steps) {
            assert_eq!(Position::read(at.write(), &steps), Some(at));
            if b - a > longest {
                at = at.halve().unwrap();
                failed += 1;
            } else {
                done.push([a, b]);
                at = at.advance(&steps);
            }
        }
        assert_eq!(Position::read(at.write(), &steps), Some(at));
        (done, failed)
    }

    #[test]
    fn the_axis_is_walked_without_gaps_and_ends_are_exact() {
        let (done, failed) = walk(1.0);
        assert_eq!(
            (done.iter().map(|s| s[1]).collect::<Vec<_>>(), failed),
            (vec![0.3 / 3.0, 0.3 * (2.0 / 3.0), 0.3, 1.0], 0)
        );
        for longest in [0.2, 0.05, 0.02] {
            let (done, _) = walk(longest);
            assert!(done.windows(2).all(|w| w[0][1] == w[1][0]));
            assert!(done[0][0] == 0.0 && done.iter().any(|s| s[1] == 0.3) && done.last().unwrap()[1] == 1.0);
            assert!(done.iter().all(|s| s[1] > s[0] && s[1] - s[0] <= longest));
        }
    }

    #[test]
    fn short_steps_grow_back() {
        let steps = steps();
        let mut at = Position::start().halve().and_then(Position::halve).unwrap();
        let mut sizes = Vec::new();
        while at.increment < 2 {
            sizes.push(PARTS / at.size);
            at = at.advance(&steps);
        }
        // Two quarters, then a half; the next increment at once.
        assert_eq!(sizes, [4, 4, 2, 1]);
        let shortest = (0..MOST_HALVINGS).fold(Position::start(), |at, _| at.halve().unwrap());
        assert_eq!(shortest.halve(), None);
        assert_eq!(Position::read([0, 3, 0, 64], &steps), None);
        assert_eq!(Position::read([0, 0, 1, 2], &steps), None);
        assert_eq!(Position::read([3, 0, 0, 64], &steps), None);
    }
}
