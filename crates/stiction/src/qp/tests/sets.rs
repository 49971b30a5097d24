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
            b: b.clone(),
            sets: (0..m).map(disc).collect(),
        });
        let ellipse = |j| PointSet::HalfLineAndEllipse { radii: [radius, 0.3 * radius], angle: 0.01 * j as f64 };
        cases.push(Case {
            name: format!("half space, ellipses {radius}"),
            a: half_space(side),
            b,
            sets: (0..m).map(ellipse).collect(),
        });
    }
    cases
}

fn run(case: &Case, settings: &SetSettings, relative: f64) -> SetSolution {
    let mut operator = |x: &[f64]| case.a.times(x);
    let problem = SetProblem { operator: &mut operator, b: &case.b, largest_eigenvalue: None, preconditioner: None };
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

fn flat() -> SetSettings {
    SetSettings { follow_boundaries: false, ..SetSettings::default() }
}

#[test]
fn the_optimality_conditions_hold_with_and_without_following_boundaries() {
    for case in cases() {
        let curved = run(&case, &SetSettings::default(), 1e-11);
        let plain = run(&case, &flat(), 1e-11);
        for s in [&curved, &plain] {
            assert_eq!(s.status, QpStatus::Solved, "{} {:?}", case.name, s.counts);
            let left = residual(&case, &s.x);
            assert!(left < 1e-9 * norm(&case.b), "{}: {left}", case.name);
        }
        // |x - y| <= 2 tolerance / smallest eigenvalue, which is above 1e-3.
        assert!(apart(&curved.x, &plain.x) < 1e-7 * norm(&case.b), "{}", case.name);
    }
}

#[test]
fn accelerated_gradients_find_the_same_point() {
    for case in cases() {
        let curved = run(&case, &SetSettings::default(), 1e-11);
        let (weight, zero) = (vec![1.0; case.sets.len()], vec![0.0; case.b.len()]);
        let other = accelerated_gradient(|x| case.a.times(x), &case.b, &case.sets, &weight, &zero, &zero, 3000);
        assert!(apart(&curved.x, &other.x) < 1e-7 * norm(&case.b), "{}", case.name);
    }
}

#[test]
fn following_the_boundary_saves_products_where_pairs_move_along_it() {
    for case in cases().iter().filter(|c| c.name.starts_with("half") && !c.name.ends_with("0.02")) {
        let curved = run(case, &SetSettings::default(), 1e-8).counts;
        let plain = run(case, &flat(), 1e-8).counts;
        assert!(2 * curved.products < plain.products, "{}: {curved:?} {plain:?}", case.name);
        assert!(curved.products < 130, "{}: {curved:?}", case.name);
    }
}

#[test]
fn no_step_raises_the_objective() {
    for case in cases() {
        for settings in [SetSettings::default(), flat()] {
            let mut values = Vec::new();
            let mut operator = |x: &[f64]| case.a.times(x);
            let problem =
                SetProblem { operator: &mut operator, b: &case.b, largest_eigenvalue: None, preconditioner: None };
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
        for settings in [SetSettings::default(), flat()] {
            let original = run(&case, &settings, 1e-8);
            let a = Dense(case.a.0.iter().map(|row| times(c, row)).collect());
            let softer = Case { name: String::new(), a, b: times(c, &case.b), sets: case.sets.clone() };
            assert_eq!(run(&softer, &settings, 1e-8).counts, original.counts, "{}", case.name);
            let wider = |set: &PointSet| match *set {
                PointSet::HalfLineAndDisc { radius } => PointSet::HalfLineAndDisc { radius: s * radius },
                PointSet::HalfLineAndEllipse { radii, angle } => {
                    PointSet::HalfLineAndEllipse { radii: [s * radii[0], s * radii[1]], angle }
                }
                PointSet::Free => PointSet::Free,
            };
            let sets = case.sets.iter().map(wider).collect();
            let larger = Case { name: String::new(), a: case.a.clone(), b: times(s, &case.b), sets };
            assert_eq!(run(&larger, &settings, 1e-8).counts, original.counts, "{}", case.name);
        }
    }
}

#[test]
fn a_disc_and_the_ellipse_with_equal_axes_are_the_same_problem() {
    for case in cases() {
        let Some(PointSet::HalfLineAndDisc { radius }) = case.sets.first().copied() else { continue };
        let round = |j| PointSet::HalfLineAndEllipse { radii: [radius; 2], angle: 0.3 * j as f64 };
        let sets = (0..case.sets.len()).map(round).collect();
        let other = Case { name: case.name.clone(), a: case.a.clone(), b: case.b.clone(), sets };
        let (x, y) = (run(&case, &SetSettings::default(), 1e-11).x, run(&other, &SetSettings::default(), 1e-11).x);
        assert!(apart(&x, &y) < 1e-7 * norm(&case.b), "{}", case.name);
    }
}

#[test]
fn sets_without_extent_strips_and_free_triples_are_solved_together() {
    let m = 40;
    let mut numbers = Numbers::new(31);
    let a = Dense::with_spectrum(&spread(3 * m, 1e-2, 1.0), &mut numbers);
    let b = numbers.vector(3 * m);
    let radii = [[0.0, 0.0], [0.0, 0.5], [0.5, 0.0], [0.4, f64::INFINITY], [0.3, 0.6]];
    let set = |j: usize| match j % 7 {
        5 => PointSet::Free,
        6 => PointSet::HalfLineAndDisc { radius: 0.0 },
        k => PointSet::HalfLineAndEllipse { radii: radii[k], angle: 0.4 * j as f64 },
    };
    let case = Case { name: "mixed".into(), a, b, sets: (0..m).map(set).collect() };
    for settings in [SetSettings::default(), flat()] {
        let s = run(&case, &settings, 1e-11);
        assert_eq!(s.status, QpStatus::Solved, "{settings:?} {:?}", s.counts);
        assert!(residual(&case, &s.x) < 1e-10, "{}", residual(&case, &s.x));
    }
}

#[test]
fn segments_alone_are_bounds_in_turned_coordinates() {
    let (m, angle) = (30, 0.6f64);
    let mut numbers = Numbers::new(41);
    let a = Dense::with_spectrum(&spread(3 * m, 1e-2, 1.0), &mut numbers);
    let b = numbers.vector(3 * m);
    let sets = vec![PointSet::HalfLineAndEllipse { radii: [0.7, 0.0], angle }; m];
    let case = Case { name: "segments".into(), a: a.clone(), b: b.clone(), sets };
    let (s, c) = angle.sin_cos();
    let turn = |sign: f64, x: &[f64]| -> Vec<f64> {
        let pair = |j: usize| (x[m + j], x[2 * m + j]);
        let first = (0..m).map(|j| c * pair(j).0 + sign * s * pair(j).1);
        let second = (0..m).map(|j| c * pair(j).1 - sign * s * pair(j).0);
        x[..m].iter().copied().chain(first).chain(second).collect()
    };
    let one = |normal: f64, along: f64| -> Vec<f64> {
        (0..3 * m)
            .map(|k| {
                if k < m {
                    normal
                } else if k < 2 * m {
                    along
                } else {
                    0.0
                }
            })
            .collect()
    };
    let bounds = Bounds { lower: one(0.0, -0.7), upper: one(f64::INFINITY, 0.7) };
    let (mut operator, turned) = (|x: &[f64]| turn(1.0, &a.times(&turn(-1.0, x))), turn(1.0, &b));
    let problem = BoundProblem {
        operator: &mut operator,
        b: &turned,
        bounds: &bounds,
        largest_eigenvalue: None,
        preconditioner: None,
    };
    let method = BoundMethod::Mprgp(MprgpSettings::default());
    let expected = minimize_in_bounds(problem, &vec![0.0; 3 * m], &method, 1e-11, 9999, &mut |_, _| false);
    for settings in [SetSettings::default(), flat()] {
        let ours = run(&case, &settings, 1e-12);
        assert_eq!((ours.status, expected.status), (QpStatus::Solved, QpStatus::Solved));
        assert!(apart(&turn(1.0, &ours.x), &expected.x) < 1e-8, "{:?}", ours.counts);
        assert!(ours.counts.cg_steps > ours.counts.gradient_steps, "{:?}", ours.counts);
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
        let problem = SetProblem { operator, b: &case.b, largest_eigenvalue: None, preconditioner: None };
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
        SetProblem { operator: &mut operator, b: &case.b, largest_eigenvalue: None, preconditioner: Some(&apply) };
    let tolerance = 1e-9 * norm(&case.b);
    let (settings, start) = (SetSettings::default(), vec![0.0; 3 * m]);
    let with = minimize_in_sets(problem, &case.sets, &start, &settings, tolerance, 9999, &mut |_, _| false);
    let without = run(&case, &settings, 1e-9);
    assert!(with.status == QpStatus::Solved && without.status == QpStatus::Solved);
    assert!(with.counts.products < without.counts.products, "{:?} {:?}", with.counts, without.counts);
    assert!(apart(&with.x, &without.x) < 1e-6);
}
