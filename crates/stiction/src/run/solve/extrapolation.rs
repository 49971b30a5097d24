//! Where a load step begins: the answers of the steps before it, extrapolated as far as what acts follows the same polynomial.

/// Answers that are kept to extrapolate from.
pub(crate) const KEPT: usize = 3;

/// What acts counts as met at this part of it.
const MET: f64 = 1e-12;

/// How far what acts is from an extrapolation, and what acts: squares of the load and of the gaps.
pub(crate) type Away = [[f64; 2]; 2];

/// The weights of answers at `times` in the one at `t`: those of the polynomial through the last ones, of the least degree that meets
/// what acts best; `away` tells how far a polynomial is from it. Loads that grow in proportion are met at once as long as no point
/// changes its state. No degree is taken that is farther than the one before in loads or gaps.
pub(crate) fn weights(times: &[f64], t: f64, away: &mut dyn FnMut(&[f64]) -> Away) -> Vec<f64> {
    let mut left = |weights: &[f64]| {
        let [away, acting] = away(weights);
        [0, 1].map(|k| if away[k] <= MET * MET * acting[k] { 0.0 } else { away[k] })
    };
    let mut best = polynomial(times, 1, t);
    let mut nearest = left(&best);
    for count in 2..=times.len() {
        let next = polynomial(times, count, t);
        let here = left(&next);
        let is_nearer = (0..2).all(|k| here[k] <= nearest[k]) && here != nearest;
        if !is_nearer {
            break;
        }
        (best, nearest) = (next, here);
    }
    best
}

/// The weights of all values in the polynomial through the last `count` at `t`.
fn polynomial(times: &[f64], count: usize, t: f64) -> Vec<f64> {
    let first = times.len() - count;
    let weight = |i: usize| -> f64 {
        let others = (first..times.len()).filter(|&j| j != i);
        others.map(|j| (t - times[j]) / (times[i] - times[j])).product()
    };
    (0..times.len()).map(|i| if i < first { 0.0 } else { weight(i) }).collect()
}

/// The sum of `values` with these weights, which add up to one: what does not change stays to the last digit.
pub(crate) fn extrapolated(values: &[&[f64]], weights: &[f64]) -> Vec<f64> {
    let Some((last, before)) = values.split_last() else { return Vec::new() };
    let mut sum = last.to_vec();
    for (values, weight) in before.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        sum.iter_mut().zip(*values).zip(*last).for_each(|((sum, value), last)| *sum += weight * (value - last));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value at 5 from those at 2, 3 and 4, and the degree that was taken.
    fn next(path: impl Fn(f64) -> f64) -> (f64, usize) {
        let times = [2.0, 3.0, 4.0];
        let values = times.map(&path);
        let all: Vec<&[f64]> = values.iter().map(std::slice::from_ref).collect();
        let now = path(5.0);
        let mut away = |weights: &[f64]| {
            let off = extrapolated(&all, weights)[0] - now;
            [[off * off, 0.0], [now * now, 0.0]]
        };
        let weights = weights(&times, 5.0, &mut away);
        let count = weights.iter().filter(|weight| **weight != 0.0).count();
        (extrapolated(&all, &weights)[0], count - 1)
    }

    #[test]
    fn a_polynomial_is_met_by_one_of_its_degree_and_a_jump_by_none() {
        assert_eq!(next(|_| 7.0), (7.0, 0));
        assert_eq!(next(|t| 7.0 - 3.0 * t), (-8.0, 1));
        let (value, degree) = next(|t| t * t - t);
        assert!((value - 20.0).abs() < 1e-12 && degree == 2);
        // From a ramp to a load that stands, the last answer is as good as any.
        assert_eq!(next(|t| t.min(4.0)), (4.0, 0));
    }
}
