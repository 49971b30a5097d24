//! The length of a step at which a convex energy is least, where its slope is a sum over ranks.

use crate::ranks::Halo;

/// Lengths that are tried at once: the message to the other ranks costs the same for one and for all of them.
const PARTS: usize = 16;
/// Longest step over that of the quadratic model, a power of two.
const LONGEST: f64 = 64.0;
/// Most messages; each after the first divides the interval by [`PARTS`].
const MESSAGES: usize = 7;

/// The length of a step at which an energy is least, over that of the quadratic model. `slope` is the part of this rank in the slope of
/// the energy along the step, which does not fall with the length.
///
/// The zero of the slope is enclosed until its values at both ends are at most `enough` times that at the beginning; between them it is
/// taken as linear.
pub(super) fn least_along(halo: &Halo, slope: impl Fn(f64) -> f64, enough: f64) -> f64 {
    let at = |lengths: &[f64]| {
        let mut slopes: Vec<f64> = lengths.iter().map(|&t| slope(t)).collect();
        halo.sum(&mut slopes);
        slopes
    };
    // Most are a little longer than one.
    let doubled = std::iter::successors(Some(4.0), |t| (*t < LONGEST).then_some(2.0 * t));
    let mut lengths: Vec<f64> = (0..=PARTS).map(|k| 2.0 * k as f64 / PARTS as f64).chain(doubled).collect();
    let mut slopes = at(&lengths);
    if slopes[0].is_nan() {
        return 1.0;
    }
    if slopes[0] >= 0.0 {
        return 0.0;
    }
    let enough = enough * slopes[0].abs();
    let mut messages = 1;
    loop {
        let Some(end) = slopes.iter().skip(1).position(|slope| *slope >= 0.0) else { return LONGEST };
        let ([low, high], [before, after]) = ([lengths[end], lengths[end + 1]], [slopes[end], slopes[end + 1]]);
        if after.max(-before) <= enough || messages == MESSAGES {
            return low + before / (before - after) * (high - low);
        }
        lengths = (0..=PARTS).map(|k| low + (high - low) * k as f64 / PARTS as f64).collect();
        slopes = at(&lengths);
        messages += 1;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::ranks::{Counted, Ranks, threads};

    /// The slope of an energy with a kink in its slope at 1.3; it is zero at 4/3.
    fn kinked(t: f64) -> f64 {
        0.5 * t - 1.0 + 10.0 * (t - 1.3).max(0.0)
    }

    #[test]
    fn the_zero_of_the_slope_is_found_or_the_longest_step_is_taken() {
        let alone = Halo::alone(1);
        assert!((least_along(&alone, kinked, 1e-9) - 4.0 / 3.0).abs() < 1e-9);
        // A linear slope takes no second message.
        assert!((least_along(&alone, |t| t - 1.06, 0.5) - 1.06).abs() < 1e-12);
        assert!((least_along(&alone, |t| 0.025 * t - 1.0, 1e-6) - 40.0).abs() < 1e-3);
        assert_eq!(least_along(&alone, |t| 0.01 * t - 1.0, 1e-6), LONGEST);
        assert_eq!(least_along(&alone, |t| t, 0.1), 0.0);
        assert_eq!(least_along(&alone, |_| f64::NAN, 0.1), 1.0);
    }

    /// All ranks find what one finds from the sum of their slopes, in one message for each division of the interval.
    #[test]
    fn ranks_find_the_zero_of_their_sum() {
        let found = threads(3, |ranks| {
            let counted = Arc::new(Counted::new(ranks));
            let ranks: Arc<dyn Ranks> = counted.clone();
            let part = f64::from(ranks.rank() as u32) / 3.0;
            let halo = Halo::divided(&ranks, 1, Vec::new());
            let before = counted.traffic().sums;
            let found = least_along(&halo, |t| part * kinked(t), 0.1);
            (found, counted.traffic().sums - before)
        });
        let alone = least_along(&Halo::alone(1), kinked, 0.1);
        for (length, sums) in found {
            assert!((length - alone).abs() < 1e-12, "{length} and {alone}");
            assert!((1..=3).contains(&sums), "{sums} sums");
        }
    }
}
