use super::iteration::Iterate;

/// Thresholds of the iteration. Residuals are violations of balance and law over the load.
struct Threshold;

impl Threshold {
    /// Above this residual, over the contact forces, the active sets are far from the final ones: the Coulomb coupling is left out,
    /// fewer directions are kept and floating bodies are balanced. A coupled step takes the present sets for the final ones and cycles
    /// more easily. Over a load that is in balance with itself, as that of a bolt or of a temperature, the residual says nothing: the
    /// first load step of a flange with eight bolts takes 70 cycles by the contact forces, 138 by the load, on which its sets cycle.
    /// 1000 random cases take 20 979, 20 957 and 21 226 cycles with 0.07, 0.1 and 0.14.
    const FAR: f64 = 0.1;
    /// Above this residual sets that do not settle are cycling; below it they chatter.
    const SWINGING: f64 = 0.05;
    /// A run that begins at an answer below this residual begins nearby: load steps of eleven assemblies begin at 0.0003 to 0.2 (0.5
    /// where the load doubles), what knows nothing of the answer above 0.9.
    const NEARBY: f64 = 0.3;
    /// Cycles over which a residual above [`Self::SWINGING`] has to fall to [`Self::GAIN`] times the best one before; otherwise the active sets
    /// are cycling. A prototype with a patience of four, on bricks of 42 000 unknowns with four loads from four starts each,
    /// converges in all 16 runs with the resets and in 12 without.
    const PATIENCE: usize = 15;
    const GAIN: f64 = 0.7;
    /// Below this residual slip reversals are the chattering of single points, a few per cent smaller each cycle, which costs
    /// ten to thirty cycles; above it the body oscillates as a whole. Measured on pressed bricks of hexahedra without a coarser
    /// block: 24, 29, 28 and 51 cycles at 38, 46, 54 and 58 cells across become 21, 19, 20 and 21.
    const CHATTERING: f64 = 0.3;
    /// Cycles without a halving of the best residual after which the Coulomb coupling is left out again.
    const SLOW: usize = 12;
    /// Cycles without a halving of the best residual that count as a failure.
    const HOPELESS: usize = 60;
}

/// What the monitor says of the iteration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    Progress,
    /// The active sets are cycling.
    Cycling,
    /// The residual is not a number, or has not fallen for many cycles.
    Failed,
}

/// The monitor of a run: its residuals, the best iterate, and the detection of cycling.
#[derive(Debug, Clone, Default)]
pub(super) struct Monitor {
    /// The residual at each cycle.
    residuals: Vec<f64>,
    /// The same over the contact forces.
    of_contact: Vec<f64>,
    best: Option<(f64, Iterate)>,
    /// Cycles at the last reset.
    last_reset: usize,
    /// Resets since the run began.
    pub resets: usize,
}

impl Monitor {
    /// Takes the violation of balance and law over the load, and over the contact forces.
    pub(super) fn record(&mut self, residual: f64, of_contact: f64) {
        self.residuals.push(residual);
        self.of_contact.push(of_contact);
    }

    /// Removes the last residual, which was computed from inaccurate forces.
    pub(super) fn retract(&mut self) {
        self.residuals.pop();
        self.of_contact.pop();
    }

    /// Whether the last residual says that the active sets are far from the final ones.
    pub(super) fn is_far(&self) -> bool {
        self.of_contact.last().is_some_and(|&last| last > Threshold::FAR)
    }

    /// Whether the last residual is larger than that at the beginning.
    pub(super) fn has_grown(&self) -> bool {
        self.residuals.last() > self.residuals.first()
    }

    /// Whether slip reversals are those of single points.
    pub(super) fn is_chattering(&self) -> bool {
        self.residuals.last().is_some_and(|&last| last <= Threshold::CHATTERING)
    }

    /// Whether steps may use the Coulomb coupling; `given` if the run began at displacements that were given, such as
    /// the answer of the load step before, `slides` if nothing but friction that slips holds a floating body.
    pub(super) fn is_coupled(&self, given: bool, slides: bool) -> bool {
        let is_nearby = given && self.of_contact.first().is_some_and(|&first| first <= Threshold::NEARBY);
        (is_nearby || slides || !self.is_far()) && !self.is_slow()
    }

    /// Whether the residual has not fallen for some cycles.
    pub(super) fn is_slow(&self) -> bool {
        self.without_halving(Threshold::SLOW)
    }

    /// Judges the last residual, which is that of `iterate` after `cycles`, and keeps the best iterate.
    pub(super) fn assess(&mut self, iterate: &Iterate, cycles: usize) -> Verdict {
        let Some(&residual) = self.residuals.last() else { return Verdict::Progress };
        if self.best.as_ref().is_none_or(|(least, _)| residual < *least) {
            self.best = Some((residual, iterate.clone()));
        }
        if !residual.is_finite() || self.without_halving(Threshold::HOPELESS) {
            Verdict::Failed
        } else if self.is_cycling(residual, cycles) {
            Verdict::Cycling
        } else {
            Verdict::Progress
        }
    }

    /// Counts a reset of the active sets.
    pub(super) fn reset(&mut self, cycles: usize) {
        self.resets += 1;
        self.last_reset = cycles;
    }

    /// Another run begins after `cycles`.
    pub(super) fn restart(&mut self, cycles: usize) {
        *self = Monitor { last_reset: cycles, ..Monitor::default() };
    }

    /// The iterate with the least residual. The last one of a failed run is of no use: bodies that no active constraint
    /// supports move away ever faster.
    pub(super) fn take_best(&mut self) -> Option<Iterate> {
        self.best.take().map(|(_, iterate)| iterate)
    }

    fn without_halving(&self, cycles: usize) -> bool {
        let Some(before) = self.residuals.len().checked_sub(cycles) else { return false };
        least(&self.residuals[before..]) > 0.5 * least(&self.residuals[..before])
    }

    fn is_cycling(&self, residual: f64, cycles: usize) -> bool {
        let Some(before) = self.residuals.len().checked_sub(Threshold::PATIENCE) else { return false };
        let best = least(&self.residuals[..before]);
        cycles - self.last_reset > Threshold::PATIENCE
            && residual > Threshold::SWINGING
            && residual > Threshold::GAIN * best
    }
}

fn least(residuals: &[f64]) -> f64 {
    residuals.iter().fold(f64::INFINITY, |a, &b| a.min(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdicts(monitor: &mut Monitor, residuals: impl IntoIterator<Item = f64>) -> Vec<Verdict> {
        let assess = |(cycle, residual): (usize, f64)| {
            monitor.record(residual, residual);
            // The iterate carries the residual, which identifies the best one.
            monitor.assess(&Iterate { u: vec![[residual; 3]], ..Iterate::default() }, cycle)
        };
        residuals.into_iter().enumerate().map(assess).collect()
    }

    #[test]
    fn residuals_that_alternate_are_cycling_after_the_patience_and_again_after_a_reset() {
        let alternating = |cycles: usize| (0..cycles).map(|i| 0.4 + 0.1 * (i % 2) as f64);
        let mut monitor = Monitor::default();
        let found = verdicts(&mut monitor, alternating(Threshold::PATIENCE + 2));
        let (last, before) = found.split_last().unwrap();
        assert!(*last == Verdict::Cycling && before.iter().all(|v| *v == Verdict::Progress), "{found:?}");
        monitor.reset(Threshold::PATIENCE + 1);
        assert_eq!(monitor.assess(&Iterate::default(), 2 * Threshold::PATIENCE + 1), Verdict::Progress);
        assert_eq!(monitor.assess(&Iterate::default(), 2 * Threshold::PATIENCE + 2), Verdict::Cycling);
        // Close to the solution a residual that alternates is no reason for a reset, but it is one for failure in the end.
        let near = verdicts(&mut Monitor::default(), alternating(Threshold::HOPELESS + 2).map(|r| 0.05 * r));
        assert!(near.iter().rev().skip(2).all(|v| *v == Verdict::Progress), "{near:?}");
        assert_eq!(*near.last().unwrap(), Verdict::Failed);
    }

    #[test]
    fn the_best_iterate_is_the_one_with_the_least_residual() {
        let mut monitor = Monitor::default();
        assert!(!monitor.is_far() && !monitor.is_chattering() && !monitor.has_grown());
        let found = verdicts(&mut monitor, [0.5, 0.15, 0.02, 0.3]);
        assert!(found.iter().all(|v| *v == Verdict::Progress) && monitor.is_far() && monitor.is_chattering());
        assert!(!monitor.has_grown());
        verdicts(&mut monitor, [0.6]);
        assert!(monitor.has_grown());
        assert_eq!(monitor.take_best().unwrap().u, [[0.02; 3]]);
        assert_eq!(verdicts(&mut monitor, [f64::NAN]), [Verdict::Failed]);
    }

    #[test]
    fn how_far_the_sets_are_is_a_matter_of_the_contact_forces_and_not_of_a_load_that_balances_itself() {
        let mut monitor = Monitor::default();
        monitor.record(1e-4 * Threshold::FAR, 2.0 * Threshold::FAR);
        assert!(monitor.is_far() && !monitor.is_coupled(false, false));
        monitor.record(1e-5 * Threshold::FAR, 0.5 * Threshold::FAR);
        assert!(!monitor.is_far() && monitor.is_coupled(false, false));
    }

    #[test]
    fn a_run_that_is_far_is_coupled_only_if_it_began_near_at_given_displacements_or_slides() {
        let coupled = |first: f64, given: bool, slides: bool| {
            let mut monitor = Monitor::default();
            [first, 4.0 * Threshold::FAR].into_iter().for_each(|residual| monitor.record(f64::NAN, residual));
            monitor.is_coupled(given, slides)
        };
        let near = 0.5 * Threshold::NEARBY;
        let found = [coupled(near, true, false), coupled(near, false, false), coupled(3.0 * near, true, false)];
        assert_eq!(found, [true, false, false]);
        assert!(coupled(3.0 * near, false, true));
    }
}
