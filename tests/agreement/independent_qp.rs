//! Quadratic programs over bounds and discs, solved again by Clarabel as cone programs.

use stiction::qp::*;

use crate::cone_program::{Cones, dot, objective, times};

/// Numbers in `(-1, 1)`, the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

/// `G G' / n + shift`, symmetric positive definite.
fn random_matrix(n: usize, shift: f64, numbers: &mut Numbers) -> Vec<Vec<f64>> {
    let g: Vec<Vec<f64>> = (0..n).map(|_| numbers.vector(n)).collect();
    let entry = |i: usize, j: usize| dot(&g[i], &g[j]) / n as f64 + if i == j { shift } else { 0.0 };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

fn agree(a: &[Vec<f64>], b: &[f64], ours: &[f64], theirs: &[f64], shift: f64, what: &str) {
    let (f, g) = (objective(a, b, ours), objective(a, b, theirs));
    assert!((f - g).abs() < 1e-9 * g.abs(), "{what}: {f} {g}");
    let d: Vec<f64> = ours.iter().zip(theirs).map(|(x, y)| x - y).collect();
    // 1/2 shift |x - y|^2 is at most the difference of the objectives, up to what Clarabel is outside by.
    assert!(0.5 * shift * dot(&d, &d) < 1e-8 * g.abs(), "{what}: {}", dot(&d, &d).sqrt());
}

#[test]
fn clarabel_finds_the_same_minimum_within_bounds() {
    for seed in 0..6 {
        let (n, shift, mut numbers) = (50, 0.01, Numbers(seed));
        let a = random_matrix(n, shift, &mut numbers);
        let b: Vec<f64> = numbers.vector(n).iter().map(|b| 3.0 * b).collect();
        let lower: Vec<f64> = (0..n).map(|i| if i % 4 == 0 { f64::NEG_INFINITY } else { numbers.next() }).collect();
        let upper = (0..n)
            .map(|i| match i % 5 {
                0 => f64::INFINITY,
                _ => lower[i].max(-1.0) + 0.6 * (1.0 + numbers.next()),
            })
            .collect();
        let bounds = Bounds { lower, upper };
        let mut cones = Cones::default();
        for i in 0..n {
            if bounds.lower[i].is_finite() {
                cones.nonnegative(-bounds.lower[i], &[(i, -1.0)]);
            }
            if bounds.upper[i].is_finite() {
                cones.nonnegative(bounds.upper[i], &[(i, 1.0)]);
            }
        }
        let (theirs, _) = cones.minimum(&a, &b, 1e-12);
        for step in [1.9, 1.0] {
            let settings = MprgpSettings { step, ..MprgpSettings::default() };
            let mut operator = |x: &[f64]| times(&a, x);
            let problem = Program { operator: &mut operator, b: &b, largest_eigenvalue: None, preconditioner: None };
            let ours = minimize_in_bounds(problem, &bounds, &vec![0.0; n], &settings, 1e-10, 5000, &mut |_, _| false);
            assert_eq!(ours.status, QpStatus::Solved);
            let held = ours.x.iter().zip(&bounds.lower).filter(|(x, l)| x == l).count();
            assert!(held > 3, "the bounds must matter: {held}");
            agree(&a, &b, &ours.x, &theirs, shift, &format!("{seed} {settings:?}"));
        }
    }
}

#[test]
fn clarabel_finds_the_same_minimum_over_discs() {
    for seed in 0..6 {
        let (m, shift, mut numbers) = (25, 0.01, Numbers(seed + 100));
        let a = random_matrix(3 * m, shift, &mut numbers);
        let b: Vec<f64> = numbers.vector(3 * m).iter().map(|b| 3.0 * b).collect();
        let sets: Vec<PointSet> = (0..m)
            .map(|j| match j % 5 {
                0 => PointSet::Free,
                _ => PointSet::HalfLineAndDisc { radius: 1.0 + numbers.next() },
            })
            .collect();
        let mut cones = Cones::default();
        for (j, set) in sets.iter().enumerate() {
            let PointSet::HalfLineAndDisc { radius } = *set else { continue };
            cones.nonnegative(0.0, &[(j, -1.0)]);
            cones.disc(1.0, &[(m + j, -1.0 / radius)], &[(2 * m + j, -1.0 / radius)]);
        }
        let (theirs, _) = cones.minimum(&a, &b, 1e-12);
        for step in [1.9, 1.0] {
            let mut operator = |x: &[f64]| times(&a, x);
            let problem = Program { operator: &mut operator, b: &b, largest_eigenvalue: None, preconditioner: None };
            let settings = SetSettings { step, ..SetSettings::default() };
            let start = vec![0.0; 3 * m];
            let ours = minimize_in_sets(problem, &sets, &start, &settings, 1e-10, 20_000, &mut |_, _| false);
            assert_eq!(ours.status, QpStatus::Solved, "{:?}", ours.counts);
            agree(&a, &b, &ours.x, &theirs, shift, &format!("{seed} {step}"));
        }
    }
}
