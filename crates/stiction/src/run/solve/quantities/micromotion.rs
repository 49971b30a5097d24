//! How far surfaces slide: percentiles over their area.

use serde::{Deserialize, Serialize};

use crate::run::pose::Prepared;
use crate::run::solve::Outcome;

/// Percentiles over the area of a pair, of what its points have slid since the start, whether they touch or not; length.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Micromotion {
    /// Half of the area slides no farther.
    pub p50: f64,
    /// 90 % of it.
    pub p90: f64,
    /// 95 % of it.
    pub p95: f64,
    /// All of it.
    pub max: f64,
}

/// How far each contact point has slid over its counterpart since the start, length.
pub(super) fn slides(prepared: &Prepared, outcome: &Outcome) -> Vec<f64> {
    let problem = &prepared.problem;
    let (m, before) = (problem.points(), &prepared.loading.slid);
    let gap_and_slip = problem.gap_and_slip(&outcome.solution.u);
    let slid = |j: usize| {
        let along = [before[j] - gap_and_slip[m + j], before[m + j] - gap_and_slip[2 * m + j]];
        along[0].hypot(along[1]) / problem.labels.unity_sum[j]
    };
    (0..m).map(slid).collect()
}

/// The percentiles of each pair; none of a pair without points.
pub(crate) fn micromotions(prepared: &Prepared, outcome: &Outcome) -> Vec<Option<Micromotion>> {
    let (slides, labels) = (slides(prepared, outcome), &prepared.problem.labels);
    let of_pair = |points: std::ops::Range<usize>| {
        percentiles(points.map(|j| (slides[j], labels.area[j] * labels.unity_sum[j])).collect())
    };
    labels.pairs.iter().take(prepared.surfaces.len()).map(|pair| of_pair(pair.points.clone())).collect()
}

/// Of slides with their areas.
pub(crate) fn percentiles(mut all: Vec<(f64, f64)>) -> Option<Micromotion> {
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = all.iter().map(|of| of.1).sum();
    let max = all.last()?.0;
    let at = |part: f64| {
        let mut area = 0.0;
        let reached = all.iter().find(|of| {
            area += of.1;
            // The sum of equal areas is off by rounding.
            area >= part * whole * (1.0 - 1e-12)
        });
        reached.map_or(max, |of| of.0)
    };
    Some(Micromotion { p50: at(0.5), p90: at(0.9), p95: at(0.95), max })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_count_area_and_not_points() {
        // 0 to 99 with an area each, and many without any at the top.
        let even: Vec<(f64, f64)> = (0..100).map(|i| (f64::from(i), 0.1)).collect();
        let wanted = Micromotion { p50: 49.0, p90: 89.0, p95: 94.0, max: 99.0 };
        assert_eq!(percentiles(even), Some(wanted));
        let heavy = [(1.0, 8.9), (2.0, 0.1), (3.0, 1.0)];
        assert_eq!(percentiles(heavy.to_vec()), Some(Micromotion { p50: 1.0, p90: 2.0, p95: 3.0, max: 3.0 }));
        assert_eq!(percentiles(Vec::new()), None);
    }
}
