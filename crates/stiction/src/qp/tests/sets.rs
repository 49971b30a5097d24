use super::super::*;
use super::*;
use crate::linalg::{dot, norm};

/// Three fields on a grid of `side^2` points, each with the kernel `1 / sqrt(distance^2 + 1/4)`, which is positive
/// definite (an inverse multiquadric) and falls like that of an elastic half space.
fn half_space(side: usize) -> Dense {
    let m = side * side;
    let entry = |i: usize, j: usize| {
        let (dx, dy) = ((i % side) as f64 - (j % side) as f64, (i / side) as f64 - (j / side) as f64);
        1.0 / (dx * dx + dy * dy + 0.25).sqrt()
    };
    Dense(
        (0..3 * m)
            .map(|i| (0..3 * m).map(|j| if i / m == j / m { entry(i % m, j % m) } else { 0.0 }).collect())
            .collect(),
    )
}

struct Case {
    name: String,
    a: Dense,
    b: Vec<f64>,
    sets: Vec<PointSet>,
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (seed, radius) in [(1, 0.3), (2, 1.0), (3, 3.0)] {
        let mut numbers = Numbers::new(seed);
        let a = Dense::with_spectrum(&spread(120, 1e-3, 1.0), &mut numbers);
        let b = numbers.vector(120);
        let disc = |_| PointSet::HalfLineAndDisc { radius };
        cases.push(Case { name: format!("random, discs {radius}"), a, b, sets: (0..40).map(disc).collect() });
    }
    for radius in [0.02, 0.1, 0.5] {
        let (mut numbers, side) = (Numbers::new(9), 12);
        let m = side * side;
        let b: Vec<f64> = (0..3 * m)
            .map(|k| {
                let x = (k % m % side) as f64 / side as f64;
                if k < m { 2.0 - 3.0 * x } else { 1.5 - 2.0 * x * (k / m) as f64 + 0.2 * numbers.next() }
            })
            .collect();
        let disc = |_| PointSet::HalfLineAndDisc { radius };
        cases.push(Case {
            name: format!("half space, discs {radius}"),
            a: half_space(side),
            b,
            sets: (0..m).map(disc).collect(),
        });
    }
    cases
}

fn run(case: &Case, settings: &SetSettings, relative: f64) -> QpSolution {
    let mut operator = |x: &[f64]| case.a.times(x);
    let problem = Program { operator: &mut operator, b: &case.b, largest_eigenvalue: None, preconditioner: None };
    let start = vec![0.0; case.b.len()];
    minimize_in_sets(problem, &case.sets, &start, settings, relative * norm(&case.b), 50_000, &mut |_, _| false)
}

/// `x - P(x - g)`, zero at the solution and there only.
fn residual(case: &Case, x: &[f64]) -> f64 {
    let gradient: Vec<f64> = case.a.times(x).iter().zip(&case.b).map(|(a, b)| a - b).collect();
    let mut moved: Vec<f64> = x.iter().zip(&gradient).map(|(x, g)| x - g).collect();
    project(&case.sets, &mut moved);
    norm(&moved.iter().zip(x).map(|(m, x)| m - x).collect::<Vec<_>>())
}

fn apart(x: &[f64], y: &[f64]) -> f64 {
    norm(&x.iter().zip(y).map(|(x, y)| x - y).collect::<Vec<_>>())
}

#[test]
fn the_optimality_conditions_hold() {
    for case in cases() {
        let found = run(&case, &SetSettings::default(), 1e-11);
        assert_eq!(found.status, QpStatus::Solved, "{} {:?}", case.name, found.counts);
        let left = residual(&case, &found.x);
        assert!(left < 1e-9 * norm(&case.b), "{}: {left}", case.name);
    }
}

#[test]
fn following_the_boundary_keeps_products_few_where_pairs_move_along_it() {
    for case in cases().iter().filter(|c| c.name.starts_with("half") && !c.name.ends_with("0.02")) {
        let counts = run(case, &SetSettings::default(), 1e-8).counts;
        assert!(counts.products < 130, "{}: {counts:?}", case.name);
    }
}

#[test]
fn no_step_raises_the_objective() {
    for case in cases() {
        for settings in [SetSettings::default(), SetSettings { step: 1.0, ..SetSettings::default() }] {
            let mut values = Vec::new();
            let mut operator = |x: &[f64]| case.a.times(x);
            let problem =
                Program { operator: &mut operator, b: &case.b, largest_eigenvalue: None, preconditioner: None };
            let start: Vec<f64> = case.b.iter().map(|b| -5.0 * b).collect();
            let tolerance = 1e-6 * norm(&case.b);
            minimize_in_sets(problem, &case.sets, &start, &settings, tolerance, 5000, &mut |x, _| {
                values.push(0.5 * dot(x, &case.a.times(x)) - dot(x, &case.b));
                false
            });
            let scale = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            assert!(values.len() > 5 && values.windows(2).all(|v| v[1] <= v[0] + 1e-14 * scale), "{}", case.name);
        }
    }
}

#[test]
fn scaling_the_operator_or_the_unknowns_changes_no_count() {
    let (c, s) = (2f64.powi(-27), 2f64.powi(13));
    let times = |factor: f64, v: &[f64]| -> Vec<f64> { v.iter().map(|v| v * factor).collect() };
    for case in cases() {
        for settings in [SetSettings::default(), SetSettings { step: 1.0, ..SetSettings::default() }] {
            let original = run(&case, &settings, 1e-8);
            let a = Dense(case.a.0.iter().map(|row| times(c, row)).collect());
            let softer = Case { name: String::new(), a, b: times(c, &case.b), sets: case.sets.clone() };
            assert_eq!(run(&softer, &settings, 1e-8).counts, original.counts, "{}", case.name);
            let wider = |set: &PointSet| match *set {
                PointSet::HalfLineAndDisc { radius } => PointSet::HalfLineAndDisc { radius: s * radius },
                PointSet::Free => PointSet::Free,
            };
            let sets = case.sets.iter().map(wider).collect();
            let larger = Case { name: String::new(), a: case.a.clone(), b: times(s, &case.b), sets };
            assert_eq!(run(&larger, &settings, 1e-8).counts, original.counts, "{}", case.name);
        }
    }
}

#[test]
fn sets_without_extent_without_bound_and_free_triples_are_solved_together() {
    let m = 40;
    let mut numbers = Numbers::new(31);
    let a = Dense::with_spectrum(&spread(3 * m, 1e-2, 1.0), &mut numbers);
    let b = numbers.vector(3 * m);
    let set = |j: usize| match j % 4 {
        0 => PointSet::Free,
        k => PointSet::HalfLineAndDisc { radius: [0.0, 0.5, f64::INFINITY][k - 1] },
    };
    let case = Case { name: "mixed".into(), a, b, sets: (0..m).map(set).collect() };
    for settings in [SetSettings::default(), SetSettings { step: 1.0, ..SetSettings::default() }] {
        let s = run(&case, &settings, 1e-11);
        assert_eq!(s.status, QpStatus::Solved, "{settings:?} {:?}", s.counts);
        assert!(residual(&case, &s.x) < 1e-10, "{}", residual(&case, &s.x));
    }
}

#[test]
fn without_constraints_the_steps_are_those_of_conjugate_gradients() {
    let mut numbers = Numbers::new(3);
    let spectrum: Vec<f64> = (0..60).map(|i| 1.0 + (i % 7) as f64).collect();
    let case = Case {
        name: "free".into(),
        a: Dense::with_spectrum(&spectrum, &mut numbers),
        b: numbers.vector(60),
        sets: vec![PointSet::Free; 20],
    };
    let c = run(&case, &SetSettings::default(), 1e-11).counts;
    assert!(c.cg_steps <= 8 && c.products <= c.estimation + c.cg_steps + 2, "{c:?}");
}

#[test]
fn what_cannot_be_solved_is_said_and_not_looped_over() {
    let case = &cases()[0];
    let solve = |operator: &mut dyn FnMut(&[f64]) -> Vec<f64>, sets: &[PointSet], tolerance: f64, limit: usize| {
        let problem = Program { operator, b: &case.b, largest_eigenvalue: None, preconditioner: None };
        let start = vec![0.0; case.b.len()];
        minimize_in_sets(problem, sets, &start, &SetSettings::default(), tolerance, limit, &mut |_, _| false)
    };
    let good = &mut |x: &[f64]| case.a.times(x);
    let bad = vec![PointSet::HalfLineAndDisc { radius: -1.0 }; case.sets.len()];
    assert_eq!(solve(good, &bad, 1e-9, 99).status, QpStatus::Empty);
    assert_eq!(solve(good, &case.sets, 1e-9, 5).status, QpStatus::Limit);
    assert_eq!(solve(&mut |x| vec![f64::NAN; x.len()], &case.sets, 1e-9, 99).status, QpStatus::NotFinite);
    let free = vec![PointSet::Free; case.sets.len()];
    assert_eq!(solve(&mut |x| vec![0.0; x.len()], &free, 1e-9, 99).status, QpStatus::Indefinite);
    let exact = solve(good, &case.sets, 0.0, 50_000);
    assert!(matches!(exact.status, QpStatus::Stalled | QpStatus::Solved), "{:?} {:?}", exact.status, exact.counts);
    assert!(residual(case, &exact.x) < 1e-13 * norm(&case.b), "{}", residual(case, &exact.x));
}

#[test]
fn a_diagonal_on_the_face_cures_a_diagonal_scaling() {
    let (m, mut numbers) = (30, Numbers::new(17));
    let good = Dense::with_spectrum(&spread(3 * m, 0.1, 1.0), &mut numbers);
    let scale: Vec<f64> = (0..3 * m).map(|i| 10f64.powf((i as f64).sin())).collect();
    let rows = good.0.iter().zip(&scale);
    let a = Dense(rows.map(|(row, r)| row.iter().zip(&scale).map(|(a, s)| a * r * s).collect()).collect());
    let sets = vec![PointSet::HalfLineAndDisc { radius: 0.5 }; m];
    let case = Case { name: "scaled".into(), b: numbers.vector(3 * m), a, sets };
    let apply = |r: &[f64], _: &[bool]| -> Vec<f64> { r.iter().enumerate().map(|(i, r)| r / case.a.0[i][i]).collect() };
    let mut operator = |x: &[f64]| case.a.times(x);
    let problem =
        Program { operator: &mut operator, b: &case.b, largest_eigenvalue: None, preconditioner: Some(&apply) };
    let tolerance = 1e-9 * norm(&case.b);
    let (settings, start) = (SetSettings::default(), vec![0.0; 3 * m]);
    let with = minimize_in_sets(problem, &case.sets, &start, &settings, tolerance, 9999, &mut |_, _| false);
    let without = run(&case, &settings, 1e-9);
    assert!(with.status == QpStatus::Solved && without.status == QpStatus::Solved);
    assert!(with.counts.products < without.counts.products, "{:?} {:?}", with.counts, without.counts);
    assert!(apart(&with.x, &without.x) < 1e-6);
}
