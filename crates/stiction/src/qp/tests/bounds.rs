use super::super::*;
use super::*;
use crate::linalg::{dot, norm};

fn free(n: usize) -> Bounds {
    Bounds { lower: vec![f64::NEG_INFINITY; n], upper: vec![f64::INFINITY; n] }
}

/// A problem whose solution has free entries, entries at both bounds, unbounded and fixed ones.
fn mixed(n: usize, condition: f64, seed: u64) -> (Dense, Vec<f64>, Bounds) {
    let mut numbers = Numbers::new(seed);
    let a = Dense::with_spectrum(&spread(n, 1.0 / condition, 1.0), &mut numbers);
    let b = numbers.vector(n);
    let mut bounds = Bounds { lower: numbers.vector(n), upper: vec![0.0; n] };
    for i in 0..n {
        bounds.upper[i] = bounds.lower[i] + 0.5 + 0.5 * numbers.next();
        match i % 7 {
            0 => bounds.lower[i] = f64::NEG_INFINITY,
            1 => bounds.upper[i] = f64::INFINITY,
            2 => bounds.upper[i] = bounds.lower[i],
            _ => {}
        }
    }
    (a, b, bounds)
}

/// The largest violation of the optimality conditions, from `A`, `b` and the bounds alone.
fn violation(a: &Dense, b: &[f64], bounds: &Bounds, x: &[f64]) -> f64 {
    let mut worst: f64 = 0.0;
    for (i, g) in a.times(x).iter().zip(b).map(|(a, b)| a - b).enumerate() {
        let (down, up) = (x[i] - bounds.lower[i], bounds.upper[i] - x[i]);
        worst = worst.max(-down).max(-up);
        // A positive slope must be held by the lower bound, a negative one by the upper bound.
        worst = worst.max(if g > 0.0 { g.min(down) } else { (-g).min(up) });
    }
    worst
}

#[test]
fn the_optimality_conditions_hold_and_all_methods_agree() {
    for seed in 0..8 {
        let (a, b, bounds) = mixed(60, 1e3, seed);
        let mut first: Option<Vec<f64>> = None;
        for method in methods() {
            let s = solve(&a, &b, &bounds, &method, 1e-12);
            assert_eq!(s.status, QpStatus::Solved, "{method:?} {:?}", s.counts);
            let worst = violation(&a, &b, &bounds, &s.x);
            assert!(worst < 1e-11, "{method:?}: {worst}");
            let reference = first.get_or_insert_with(|| s.x.clone());
            let apart: Vec<f64> = s.x.iter().zip(reference.iter()).map(|(x, y)| x - y).collect();
            // |x - y| <= 2 tolerance / smallest eigenvalue
            assert!(norm(&apart) <= 2e-9, "{method:?}: {}", norm(&apart));
        }
    }
}

#[test]
fn without_bounds_the_steps_are_those_of_conjugate_gradients() {
    // Seven distinct eigenvalues: conjugate gradients end after seven steps.
    let mut numbers = Numbers::new(3);
    let spectrum: Vec<f64> = (0..50).map(|i| 1.0 + (i % 7) as f64).collect();
    let a = Dense::with_spectrum(&spectrum, &mut numbers);
    let b = numbers.vector(50);
    for method in methods() {
        let s = solve(&a, &b, &free(50), &method, 1e-10);
        let c = s.counts;
        assert!(s.status == QpStatus::Solved && c.cg_steps <= 8, "{method:?} {c:?}");
        assert!(c.expansions == 0 && c.proportionings == 0, "{c:?}");
        assert!(c.products <= c.estimation + c.cg_steps + 2, "{c:?}");
        assert!(dot(&b, &b).sqrt() > 1.0);
    }
}
