use super::V3;
use super::measures::Measures;
use super::settings::{Counts, Progress, Settings, Solution, Status};
use crate::friction::law::nearest_in_cone;
use crate::linalg::{Watch, norm};

/// Impulses in the units of the problem, with their velocities and measures.
#[derive(Debug, Clone)]
pub(super) struct Judged {
    pub r: Vec<f64>,
    pub u: Vec<f64>,
    pub measures: Measures,
}

/// Thresholds of the end of an iteration, by problems whose impulses exceed their velocities by 1e8 and more.
struct Threshold;

impl Threshold {
    /// `r - P(r - û)` is not computed more accurately than to so many last digits of `r`.
    const LAST_DIGITS: f64 = 16.0;
    /// Steps that may still gain on rounding.
    const PATIENCE_AT_ROUNDING: usize = 5;
    /// Rounds of the methods without Newton steps that count as one proximal step.
    const ROUNDS: usize = 10;
}

/// Follows an iteration: judges its impulses on the problem as it was given, keeps the best, reports to the observer.
pub(super) struct Monitor<'a> {
    pub mu: &'a [f64],
    /// Judges scaled impulses within the cones.
    pub judge: &'a dyn Fn(&[V3]) -> Judged,
    /// Euclidean norm of `q` in the units of the problem.
    pub size_of_q: f64,
    pub settings: &'a Settings,
    pub observer: &'a mut Watch<'a, Progress>,
    pub counts: Counts,
    pub history: Vec<Progress>,
    pub best: Option<Judged>,
    pub at_rounding: usize,
}

impl Monitor<'_> {
    /// Judges `r`; how the iteration ends, if it does here. `parameter` is for the record.
    pub(super) fn ends(&mut self, r: &[V3], parameter: f64) -> Option<Status> {
        let admissible: Vec<V3> = r.iter().zip(self.mu).map(|(r, &mu)| nearest_in_cone(mu, *r)).collect();
        let seen = (self.judge)(&admissible);
        let residual = seen.measures.worst();
        if self.best.as_ref().is_none_or(|b| residual < b.measures.worst()) {
            self.best = Some(seen);
        }
        let Counts { iterations, newton_steps, .. } = self.counts;
        let progress = Progress { iteration: iterations, residual, parameter, newton_steps };
        self.history.push(progress);
        if residual <= self.settings.tolerance {
            return Some(Status::Solved);
        }
        if self.best.as_ref().is_some_and(|b| self.is_rounding(b)) {
            self.at_rounding += 1;
            if self.at_rounding > Threshold::PATIENCE_AT_ROUNDING {
                return Some(Status::Rounding);
            }
        }
        let rounds = if self.settings.method.is_newton() { 1 } else { Threshold::ROUNDS };
        if iterations >= self.settings.max_iterations.saturating_mul(rounds) {
            return Some(Status::MaxIterations);
        }
        (self.observer)(&progress).is_break().then_some(Status::Interrupted)
    }

    /// The largest of the measures where the iteration is.
    pub(super) fn residual(&self) -> f64 {
        self.history.last().map_or(f64::INFINITY, |p| p.residual)
    }

    /// Whether only `|F(1)| / |q|` exceeds the tolerance, by no more than the last digits of `r`.
    fn is_rounding(&self, judged: &Judged) -> bool {
        let m = &judged.measures;
        m.by_largest.max(m.invariant) <= self.settings.tolerance
            && m.by_velocity * self.size_of_q <= Threshold::LAST_DIGITS * f64::EPSILON * norm(&judged.r)
    }

    /// The best that was seen.
    pub(super) fn solution(mut self, status: Status) -> Solution {
        let zero = vec![[0.0; 3]; self.mu.len()];
        let Judged { r, u, measures } = self.best.take().unwrap_or_else(|| (self.judge)(&zero));
        Solution { status, r, u, measures, counts: self.counts, history: self.history }
    }
}
