use super::super::*;
use super::*;
use crate::linalg::norm;

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
fn the_optimality_conditions_hold_whatever_the_settings() {
    for seed in 0..8 {
        let (a, b, bounds) = mixed(60, 1e3, seed);
        let mut first: Option<Vec<f64>> = None;
        for method in variants() {
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
    for method in variants() {
        let s = solve(&a, &b, &free(50), &method, 1e-10);
        let c = s.counts;
        assert!(s.status == QpStatus::Solved && c.cg_steps <= 8, "{method:?} {c:?}");
        assert!(c.expansions == 0 && c.gradient_steps == 0, "{c:?}");
        assert!(c.products <= c.estimation + c.cg_steps + 2, "{c:?}");
    }
}

#[test]
fn scaling_the_operator_or_the_unknowns_changes_no_count() {
    // Powers of two, so that scaling commutes with rounding.
    let (a, b, bounds) = mixed(40, 1e4, 11);
    let times = |factor: f64, v: &[f64]| -> Vec<f64> { v.iter().map(|v| v * factor).collect() };
    let (c, s) = (2f64.powi(-27), 2f64.powi(13));
    let scaled = Dense(a.0.iter().map(|row| times(c, row)).collect());
    let wider = Bounds { lower: times(s, &bounds.lower), upper: times(s, &bounds.upper) };
    for method in variants() {
        let original = solve(&a, &b, &bounds, &method, 1e-9);
        let softer = solve(&scaled, &times(c, &b), &bounds, &method, 1e-9 * c);
        assert!(softer.counts == original.counts && softer.x == original.x, "{method:?}");
        let larger = solve(&a, &times(s, &b), &wider, &method, 1e-9 * s);
        assert!(larger.counts == original.counts && larger.x == times(s, &original.x), "{method:?}");
    }
}

#[test]
fn bounds_that_hold_without_force_are_found() {
    // The unconstrained minimiser lies on some of the bounds: their multipliers vanish.
    let mut numbers = Numbers::new(21);
    let a = Dense::with_spectrum(&spread(40, 0.01, 1.0), &mut numbers);
    let x = numbers.vector(40);
    let b = a.times(&x);
    let lower = x.iter().enumerate().map(|(i, x)| if i % 2 == 0 { *x } else { x - 1.0 }).collect();
    let upper = x.iter().enumerate().map(|(i, x)| if i % 3 == 0 { *x } else { x + 1.0 }).collect();
    let bounds = Bounds { lower, upper };
    for method in variants() {
        let s = solve(&a, &b, &bounds, &method, 1e-11);
        let apart: Vec<f64> = s.x.iter().zip(&x).map(|(s, x)| s - x).collect();
        assert!(s.status == QpStatus::Solved && norm(&apart) <= 1e-9, "{method:?} {:?}", s.counts);
    }
}

#[test]
fn fixed_entries_cost_one_product() {
    let mut numbers = Numbers::new(2);
    let a = Dense::with_spectrum(&spread(10, 0.1, 1.0), &mut numbers);
    let values = numbers.vector(10);
    let bounds = Bounds { lower: values.clone(), upper: values.clone() };
    for method in variants() {
        let s = solve(&a, &[1.0; 10], &bounds, &method, 0.0);
        assert!(s.status == QpStatus::Solved && s.x == values && s.counts.products == 1 + s.counts.estimation);
    }
    let none = Bounds { lower: Vec::new(), upper: Vec::new() };
    for method in variants() {
        assert_eq!(solve(&Dense(Vec::new()), &[], &none, &method, 0.0).status, QpStatus::Solved);
    }
}

#[test]
fn a_tolerance_below_rounding_ends_as_stalled_near_the_best_that_can_be() {
    for seed in 0..4 {
        let (a, b, bounds) = mixed(60, 1e6, seed);
        for method in variants() {
            let s = solve(&a, &b, &bounds, &method, 0.0);
            assert!(
                matches!(s.status, QpStatus::Stalled | QpStatus::Solved),
                "{method:?} {:?} {:?}",
                s.status,
                s.counts
            );
            // |A| = 1; what sums of 60 products round to.
            let rounding = 60.0 * f64::EPSILON * (norm(&s.x) + norm(&b));
            assert!(violation(&a, &b, &bounds, &s.x) < rounding, "{method:?} {}", violation(&a, &b, &bounds, &s.x));
        }
    }
}

#[test]
fn what_cannot_be_solved_is_said_and_not_looped_over() {
    let n = 12;
    let (a, b, bounds) = mixed(n, 10.0, 4);
    for method in variants() {
        let run =
            |operator: &mut dyn FnMut(&[f64]) -> Vec<f64>, b: &[f64], bounds: &Bounds, start: f64, limit: usize| {
                let problem = Program { operator, b, largest_eigenvalue: None, preconditioner: None };
                minimize_in_bounds(problem, bounds, &vec![start; n], &method, 1e-10, limit, &mut |_, _| false)
            };
        let good = &mut |x: &[f64]| a.times(x);
        assert_eq!(run(good, &b, &free(n), f64::NAN, 99).status, QpStatus::NotFinite);
        assert_eq!(run(good, &[f64::INFINITY; 12], &bounds, 0.0, 99).status, QpStatus::NotFinite);
        assert_eq!(run(good, &b, &bounds, 0.0, 0).status, QpStatus::Limit);
        let short = run(good, &b, &free(n), 0.0, 4);
        assert!(short.status == QpStatus::Limit && short.counts.products == 4);
        let crossed = Bounds { lower: vec![1.0; n], upper: vec![0.0; n] };
        assert_eq!(run(good, &b, &crossed, 0.0, 99).status, QpStatus::Empty);
        assert!(crossed.validate().is_err() && bounds.validate().is_ok());
        assert_eq!(run(&mut |_| vec![f64::NAN; n], &b, &bounds, 0.0, 99).status, QpStatus::NotFinite);
        assert_eq!(run(&mut |x| x.to_vec()[1..].to_vec(), &b, &bounds, 0.0, 99).status, QpStatus::NotFinite);
        let negative = &mut |x: &[f64]| x.iter().map(|x| -x).collect();
        assert_eq!(run(negative, &b, &free(n), 0.0, 99).status, QpStatus::Indefinite);
        assert_eq!(run(&mut |x| vec![0.0; x.len()], &b, &free(n), 0.0, 99).status, QpStatus::Indefinite);
    }
}

#[test]
fn the_caller_can_end_the_iteration_and_gets_what_it_was_shown() {
    let (a, b, mut bounds) = mixed(40, 1e3, 8);
    // Room for many free entries, so that the way to the solution is long.
    bounds.lower.iter_mut().for_each(|l| *l -= 20.0);
    for method in variants() {
        let mut operator = |x: &[f64]| a.times(x);
        let problem = Program { operator: &mut operator, b: &b, largest_eigenvalue: None, preconditioner: None };
        let mut shown = Vec::new();
        let s = minimize_in_bounds(problem, &bounds, &[0.0; 40], &method, 1e-12, 9999, &mut |x, measure| {
            shown = x.to_vec();
            measure < 1e-3
        });
        assert_eq!((s.status, s.x == shown), (QpStatus::Interrupted, true), "{method:?} {:?}", s.counts);
        assert!(s.measure < 1e-3, "{method:?} {}", s.measure);
        assert!(violation(&a, &b, &bounds, &s.x) < 1.1e-3);
    }
}

#[test]
fn an_eigenvalue_far_too_small_costs_steps_but_not_the_solution() {
    let (a, b, bounds) = mixed(40, 100.0, 6);
    let mut operator = |x: &[f64]| a.times(x);
    let problem = Program { operator: &mut operator, b: &b, largest_eigenvalue: Some(1e-3), preconditioner: None };
    let settings = MprgpSettings::default();
    let s = minimize_in_bounds(problem, &bounds, &[0.0; 40], &settings, 1e-10, 9999, &mut |_, _| false);
    assert!(s.status == QpStatus::Solved && violation(&a, &b, &bounds, &s.x) < 1e-9, "{:?}", s.counts);
}

#[test]
fn a_diagonal_on_the_face_cures_a_diagonal_scaling() {
    let (a, b, bounds) = mixed(60, 10.0, 14);
    let scale: Vec<f64> = (0..60).map(|i| 10f64.powf(1.5 * (i as f64).sin())).collect();
    let rows = a.0.iter().zip(&scale);
    let bad = Dense(rows.map(|(row, r)| row.iter().zip(&scale).map(|(a, s)| a * r * s).collect()).collect());
    let apply = |r: &[f64], _: &[bool]| -> Vec<f64> { r.iter().enumerate().map(|(i, r)| r / bad.0[i][i]).collect() };
    for method in variants() {
        let products = |preconditioner: Option<&Preconditioner>| {
            let mut operator = |x: &[f64]| bad.times(x);
            let problem = Program { operator: &mut operator, b: &b, largest_eigenvalue: None, preconditioner };
            let s = minimize_in_bounds(problem, &bounds, &[0.0; 60], &method, 1e-9, 99_999, &mut |_, _| false);
            assert!(
                s.status == QpStatus::Solved && violation(&bad, &b, &bounds, &s.x) < 1e-8,
                "{method:?} {:?}",
                s.counts
            );
            s.counts.products - s.counts.estimation
        };
        let (without, with) = (products(None), products(Some(&apply)));
        assert!(2 * with < without, "{method:?}: {with} {without}");
    }
}
