//! How many unknowns a goal takes, from the levels so far.

/// Least and largest power of the number of unknowns with which errors fall: a singularity at an edge on linear cells, smooth
/// solutions on quadratic ones.
const RATES: [f64; 2] = [0.15, 0.7];
/// Levels the rate is fitted to.
const LEVELS: usize = 3;

/// Unknowns at which the error is expected to be `goal`: the line through the last levels in logarithms. `None` with fewer than two
/// levels, or where an error is zero.
pub(super) fn unknowns_for(unknowns: &[usize], error: &[f64], goal: f64) -> Option<f64> {
    let from = unknowns.len().saturating_sub(LEVELS);
    let points: Vec<[f64; 2]> =
        unknowns[from..].iter().zip(&error[from..]).map(|(&n, e)| [(n as f64).ln(), e.ln()]).collect();
    let count = points.len() as f64;
    if points.len() < 2 || points.iter().any(|point| !point[1].is_finite()) {
        return None;
    }
    let mean = |c: usize| points.iter().map(|point| point[c]).sum::<f64>() / count;
    let [x, y] = [mean(0), mean(1)];
    let along: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    let slope = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum::<f64>() / along;
    let rate = if slope.is_finite() { -slope } else { 0.0 }.clamp(RATES[0], RATES[1]);
    let (&last, &error) = unknowns.last().zip(error.last())?;
    Some(last as f64 * (error / goal).powf(1.0 / rate).max(1.0))
}

#[cfg(test)]
mod tests {
    use super::unknowns_for;

    #[test]
    fn a_power_law_is_continued() {
        let unknowns = [1000, 2000, 4000];
        let error = unknowns.map(|n| 3.0 * (n as f64).powf(-0.5));
        let needed = unknowns_for(&unknowns, &error, 0.01).unwrap_or(0.0);
        assert!((needed / 90_000.0 - 1.0).abs() < 1e-9, "{needed}");
        assert_eq!(unknowns_for(&unknowns, &error, 1.0), Some(4000.0));
    }

    #[test]
    fn errors_that_do_not_fall_are_expected_to_fall_slowly() {
        let needed = unknowns_for(&[1000, 2000], &[0.1, 0.2], 0.1).unwrap_or(0.0);
        assert!((needed / (2000.0 * 2f64.powf(1.0 / 0.15)) - 1.0).abs() < 1e-9, "{needed}");
        assert_eq!(unknowns_for(&[1000], &[0.1], 0.05), None);
        assert_eq!(unknowns_for(&[1000, 2000], &[0.1, 0.0], 0.05), None);
    }
}
