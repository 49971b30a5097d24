//! Small dense problems with a reason for their answers.

mod bounds;
mod penalty;
mod sets;

use super::minimize_in_bounds;
use super::{Bounds, MprgpSettings, Program, QpSolution};

/// Numbers in `(-1, 1)` from a linear congruence: the same in every run.
pub(super) struct Numbers(u64);

impl Numbers {
    pub(super) fn new(seed: u64) -> Self {
        Numbers(seed.wrapping_mul(2).wrapping_add(0x9e37_79b9_7f4a_7c15))
    }

    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(super) fn vector(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

/// A dense symmetric matrix by rows.
#[derive(Clone)]
pub(super) struct Dense(pub Vec<Vec<f64>>);

impl Dense {
    /// With the given eigenvalues and an eigenbasis turned by random reflections.
    pub(super) fn with_spectrum(spectrum: &[f64], numbers: &mut Numbers) -> Dense {
        let n = spectrum.len();
        let mut a: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| if i == j { spectrum[i] } else { 0.0 }).collect()).collect();
        for _ in 0..3 {
            let v = numbers.vector(n);
            let length2: f64 = v.iter().map(|v| v * v).sum();
            let reflect = |a: &mut Vec<Vec<f64>>| {
                for row in a.iter_mut() {
                    let s = 2.0 * row.iter().zip(&v).map(|(a, v)| a * v).sum::<f64>() / length2;
                    row.iter_mut().zip(&v).for_each(|(a, v)| *a -= s * v);
                }
            };
            reflect(&mut a);
            a = transposed(&a);
            reflect(&mut a);
        }
        let t = transposed(&a);
        Dense(a.iter().zip(&t).map(|(r, c)| r.iter().zip(c).map(|(x, y)| 0.5 * (x + y)).collect()).collect())
    }

    pub(super) fn times(&self, x: &[f64]) -> Vec<f64> {
        self.0.iter().map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
    }
}

fn transposed(a: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..a.len()).map(|j| a.iter().map(|row| row[j]).collect()).collect()
}

/// Eigenvalues spread evenly in the logarithm from `smallest` to `largest`.
pub(super) fn spread(n: usize, smallest: f64, largest: f64) -> Vec<f64> {
    (0..n).map(|i| smallest * (largest / smallest).powf(i as f64 / (n - 1) as f64)).collect()
}

/// The settings by which bounds are tested: the default, and faces that are left sooner.
pub(super) fn variants() -> [MprgpSettings; 2] {
    [MprgpSettings::default(), MprgpSettings { proportion: 0.5, ..MprgpSettings::default() }]
}

pub(super) fn solve(a: &Dense, b: &[f64], bounds: &Bounds, settings: &MprgpSettings, tolerance: f64) -> QpSolution {
    let mut operator = |x: &[f64]| a.times(x);
    let problem = Program { operator: &mut operator, b, largest_eigenvalue: None, preconditioner: None };
    minimize_in_bounds(problem, bounds, &vec![0.0; b.len()], settings, tolerance, 20_000, &mut |_, _| false)
}
