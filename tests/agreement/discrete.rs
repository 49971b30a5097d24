//! Discrete problems with friction: constructed solutions, invariance, degenerate points, the way from and to files.

use std::ops::ControlFlow;

use proptest::prelude::*;
use stiction::discrete::{Bilateral, DiscreteProblem, Equalities, GlobalProblem, LocalProblem};
use stiction::discrete::{Form, Method, Settings, Solution, Status, condense, prepare, solve};
use stiction::discrete::{Measures, measure};
use stiction::linalg::{Csr, norm};
use stiction_fixtures::piles::{Normals, dense, pile, two_bodies};

fn run(problem: &LocalProblem) -> Solution {
    DiscreteProblem::Local(problem.clone()).validate().unwrap();
    solve(problem, &Settings::default(), &mut |_| ControlFlow::Continue(())).unwrap()
}

fn local(w: Csr, q: Vec<f64>, mu: Vec<f64>) -> LocalProblem {
    LocalProblem { dimension: 3, W: w, q, mu, bilateral: None }
}

/// Recomputes the velocities and the traces: nothing of the solver's.
fn judge(problem: &LocalProblem, r: &[f64]) -> Measures {
    let d = problem.dimension;
    let mut u = problem.W.times(r);
    u.iter_mut().zip(&problem.q).for_each(|(u, q)| *u += q);
    let trace = |a: usize| (d * a..d * (a + 1)).map(|i| problem.W.entry(i, i)).sum();
    let traces: Vec<f64> = (0..problem.mu.len()).map(trace).collect();
    measure(d, &problem.mu, &traces, &problem.q, r, &u)
}

/// Impulse and velocity of a point in one of the states of the law, degenerate ones included; `x` in 0..1.
fn lawful(kind: u32, mu: f64, x: [f64; 4]) -> ([f64; 3], [f64; 3]) {
    let angle = 6.3 * x[0];
    let (e, n) = ([angle.cos(), angle.sin()], 0.2 + x[1]);
    let inside = 0.9 * mu * n * x[2];
    match kind {
        0 => ([0.0; 3], [0.2 + x[1], x[2] - 0.5, x[3] - 0.5]),
        1 => ([n, inside * e[0], inside * e[1]], [0.0; 3]),
        2 => ([n, mu * n * e[0], mu * n * e[1]], [0.0, -(0.1 + x[3]) * e[0], -(0.1 + x[3]) * e[1]]),
        // At the edge of the cone without slip, no impulse without distance, and no impulse but slip.
        3 => ([n, mu * n * e[0], mu * n * e[1]], [0.0; 3]),
        4 => ([0.0; 3], [0.0; 3]),
        _ => ([0.0; 3], [0.0, x[2] - 0.5, x[3] - 0.5]),
    }
}

/// `W = A A'` of the given rank with a solution chosen beforehand; `compliance` is added to the diagonal.
fn constructed(points: &[(u32, f64, [f64; 4])], a: &[f64], rank: usize, compliance: f64) -> (LocalProblem, Vec<f64>) {
    let size = 3 * points.len();
    let w = dense(size, size, |i, j| {
        let product: f64 = (0..rank).map(|k| a[i * rank + k] * a[j * rank + k]).sum();
        product / rank as f64 + if i == j { compliance } else { 0.0 }
    });
    let (mut r, mut u) = (Vec::new(), Vec::new());
    for &(kind, mu, x) in points {
        let (ra, ua) = lawful(kind, mu, x);
        r.extend(ra);
        u.extend(ua);
    }
    let q = w.times(&r).iter().zip(&u).map(|(w, u)| u - w).collect();
    (local(w, q, points.iter().map(|p| p.1).collect()), r)
}

fn points(kinds: u32) -> impl Strategy<Value = Vec<(u32, f64, [f64; 4])>> {
    prop::collection::vec((0..kinds, 0.0..1.0f64, prop::array::uniform4(0.0..1.0f64)), 1..12)
}

/// How far impulses and velocities are from the law as it is written: no cone, no projection. Each number is counted in
/// the largest of its kind.
fn off_the_law(problem: &LocalProblem, r: &[f64]) -> f64 {
    let d = problem.dimension;
    let mut u = problem.W.times(r);
    u.iter_mut().zip(&problem.q).for_each(|(u, q)| *u += q);
    let largest = |x: &[f64]| x.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let stiffest = (0..r.len()).map(|i| problem.W.entry(i, i)).fold(0.0, f64::max);
    let velocity = largest(&u).max(largest(&problem.q));
    let impulse = largest(r).max(velocity / stiffest);
    let at = |(j, mu): (usize, &f64)| {
        let (r, u) = (&r[d * j..d * (j + 1)], &u[d * j..d * (j + 1)]);
        let (friction, slip) = (norm(&r[1..]), norm(&u[1..]));
        let work: f64 = r[1..].iter().zip(&u[1..]).map(|(r, u)| r * u).sum();
        let forces = (-r[0]).max(friction - mu * r[0]) / impulse;
        let works = (r[0] * u[0]).abs().max((work + mu * r[0].max(0.0) * slip).abs()) / (impulse * velocity);
        forces.max(-u[0] / velocity).max(works)
    };
    problem.mu.iter().enumerate().map(at).fold(0.0, f64::max)
}

/// The answer without impulse, which the cone test of a coefficient that vanishes once took the pull for.
/// No solver goes on from something else than what it was given.
#[test]
fn a_start_that_does_not_fit_is_refused_by_name() {
    let w = dense(3, 3, |i, j| f64::from(i == j));
    let problem = local(w, vec![-1.0, 0.0, 0.0], vec![0.5]);
    let from = |start: &[f64]| {
        let settings = Settings { start: Some(start.to_vec()), ..Settings::default() };
        solve(&problem, &settings, &mut |_| ControlFlow::Continue(()))
    };
    assert_eq!(from(&[1.0, 0.0, 0.0]).unwrap().r, [1.0, 0.0, 0.0]);
    let short = from(&[1.0]).unwrap_err().to_string();
    assert!(short.contains("settings: `start` has 1 numbers where 3 are needed") && short.contains("(d m)"), "{short}");
    let infinite = from(&[1.0, f64::INFINITY, 0.0]).unwrap_err().to_string();
    assert!(infinite.contains("`start`[1] is inf"), "{infinite}");
}

#[test]
fn without_friction_nothing_pulls() {
    for mu in [0.0, 1e-300, 1e-12, 0.5] {
        for d in [2, 3] {
            let mut q = vec![0.0; d];
            q[0] = 1.0;
            let problem = LocalProblem {
                dimension: d,
                W: dense(d, d, |i, j| f64::from(i == j)),
                q,
                mu: vec![mu],
                bilateral: None,
            };
            for method in [Method::Auto, Method::Newton, Method::GaussSeidel, Method::Gradient, Method::Admm] {
                let settings = Settings { method, ..Settings::default() };
                let found = solve(&problem, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
                assert_eq!(found.status, Status::Solved, "{method:?} {mu} {d}");
                assert!(found.r.iter().all(|r| *r == 0.0), "{method:?} {mu} {d}: {:?}", found.r);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// Coefficients from zero on, in two and three dimensions: what is called solved obeys the law as it is written.
    #[test]
    fn what_is_solved_obeys_the_law_however_small_friction_is(
        d in 2..4usize,
        mu in prop::collection::vec(prop::sample::select(vec![0.0, 0.0, 1e-300, 1e-12, 1e-6, 0.1, 0.7, 3.0]), 1..8),
        q in prop::collection::vec(-1.0..1.0f64, 24),
        a in prop::collection::vec(-1.0..1.0f64, 24 * 24),
    ) {
        let size = d * mu.len();
        let w = dense(size, size, |i, j| {
            let product: f64 = (0..size).map(|k| a[i * size + k] * a[j * size + k]).sum();
            product / size as f64 + if i == j { 0.1 } else { 0.0 }
        });
        let problem = LocalProblem { dimension: d, W: w, q: q[..size].to_vec(), mu, bilateral: None };
        let found = run(&problem);
        prop_assert_eq!(found.status, Status::Solved);
        prop_assert!(off_the_law(&problem, &found.r) <= 1e-7, "{:?} {}", found.measures, off_the_law(&problem, &found.r));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn problems_with_a_chosen_solution_are_solved(p in points(6), a in prop::collection::vec(-1.0..1.0f64, 36 * 36)) {
        let size = 3 * p.len();
        let (problem, chosen) = constructed(&p, &a, size, 0.05);
        prop_assert!(judge(&problem, &chosen).worst() < 1e-12);
        let found = run(&problem);
        prop_assert_eq!(found.status, Status::Solved);
        prop_assert!(judge(&problem, &found.r).worst() <= 1e-8);
    }

    #[test]
    fn singular_problems_are_solved(p in points(3), a in prop::collection::vec(-1.0..1.0f64, 36 * 36)) {
        let (problem, chosen) = constructed(&p, &a, (3 * p.len()).div_ceil(2), 0.0);
        prop_assert!(judge(&problem, &chosen).worst() < 1e-12);
        let found = run(&problem);
        prop_assert_eq!(found.status, Status::Solved);
        prop_assert!(judge(&problem, &found.r).worst() <= 1e-8);
    }

    /// Far from singular and with little friction the law has one solution: it is the chosen one.
    #[test]
    fn where_only_one_solution_exists_it_is_found(
        p in points(6), a in prop::collection::vec(-1.0..1.0f64, 36 * 36), factor in -6..8i32,
    ) {
        let little: Vec<_> = p.iter().map(|&(kind, mu, x)| (kind, 0.1 * mu, x)).collect();
        let (mut problem, chosen) = constructed(&little, &a, 3 * p.len(), 1.0);
        // Other units of velocity.
        let unit = 10f64.powi(factor);
        problem.W.value.iter_mut().for_each(|w| *w *= unit);
        problem.q.iter_mut().for_each(|q| *q *= unit);
        let found = run(&problem);
        prop_assert_eq!(found.status, Status::Solved);
        let error: Vec<f64> = found.r.iter().zip(&chosen).map(|(a, b)| a - b).collect();
        prop_assert!(norm(&error) <= 1e-6 * norm(&chosen).max(norm(&problem.q) / unit), "{}", norm(&error));
    }

    #[test]
    fn units_and_the_order_of_points_change_nothing(
        p in points(3), a in prop::collection::vec(-1.0..1.0f64, 36 * 36), factors in prop::array::uniform2(-12..12i32),
    ) {
        let (problem, _) = constructed(&p, &a, 3 * p.len(), 0.2);
        let first = run(&problem);
        // Powers of two, so that not even rounding differs.
        let [of_velocity, of_impulse] = factors.map(|f| 2f64.powi(2 * f));
        let mut other = problem.clone();
        other.W.value.iter_mut().for_each(|w| *w *= of_velocity / of_impulse);
        other.q.iter_mut().for_each(|q| *q *= of_velocity);
        let loose = Settings { tolerance: 1e-5, ..Settings::default() };
        let settings = Settings { tolerance: 1e-8, ..loose.clone() };
        let changed = solve(&other, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
        let steps = |s: &Solution| s.history.iter().map(|p| (p.parameter, p.newton_steps)).collect::<Vec<_>>();
        let common = steps(&first).len().min(steps(&changed).len());
        prop_assert_eq!(&steps(&first)[..common], &steps(&changed)[..common]);

        let m = p.len();
        let reversed = |i: usize| 3 * (m - 1 - i / 3) + i % 3;
        let size = 3 * m;
        let w = dense(size, size, |i, j| problem.W.entry(reversed(i), reversed(j)));
        let q = (0..size).map(|i| problem.q[reversed(i)]).collect();
        let backwards = local(w, q, problem.mu.iter().rev().copied().collect());
        let found = run(&backwards);
        prop_assert_eq!(found.status, first.status);
        let r: Vec<f64> = (0..size).map(|i| found.r[reversed(i)]).collect();
        prop_assert!(judge(&problem, &r).worst() <= 1e-8);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn every_method_solves_what_is_far_from_singular(
        p in points(6), a in prop::collection::vec(-1.0..1.0f64, 36 * 36),
    ) {
        let little: Vec<_> = p.iter().map(|&(kind, mu, x)| (kind, 0.5 * mu, x)).collect();
        let (problem, _) = constructed(&little, &a, 3 * p.len(), 0.5);
        for method in Method::ALL {
            let settings = Settings { method, ..Settings::default() };
            let found = solve(&problem, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
            prop_assert_eq!(found.status, Status::Solved, "{:?}", method);
            prop_assert!(judge(&problem, &found.r).worst() <= 1e-8);
        }
    }

    /// Without friction nothing but normal impulses is left, also where points repeat and blocks vanish.
    #[test]
    fn without_friction_impulses_are_normal(
        p in points(3), a in prop::collection::vec(-1.0..1.0f64, 36 * 36), repeat in any::<bool>(), dead in any::<bool>(),
    ) {
        let smooth: Vec<_> = p.iter().map(|&(kind, _, x)| (kind, 0.0, x)).collect();
        let (mut problem, chosen) = constructed(&smooth, &a, 3 * p.len(), 0.1);
        prop_assert!(judge(&problem, &chosen).worst() < 1e-12);
        let size = 3 * p.len();
        let extra = 3 * (usize::from(repeat) + usize::from(dead));
        // The first point once more, and a point that no impulse moves and that opens.
        let at = |i: usize| match i {
            _ if i < size => Some(i),
            _ if repeat && i < size + 3 => Some(i - size),
            _ => None,
        };
        let entry = |i: usize, j: usize| at(i).zip(at(j)).map_or(0.0, |(i, j)| problem.W.entry(i, j));
        let w = dense(size + extra, size + extra, entry);
        let q = (0..size + extra).map(|i| at(i).map_or(0.5, |i| problem.q[i])).collect();
        problem = local(w, q, vec![0.0; p.len() + extra / 3]);
        let found = run(&problem);
        prop_assert_eq!(found.status, Status::Solved);
        prop_assert!(judge(&problem, &found.r).worst() <= 1e-8);
        prop_assert!(found.r.chunks(3).all(|r| r[1] == 0.0 && r[2] == 0.0 && r[0] >= 0.0));
    }

    /// Other tangents and other units at every point: impulses turn and scale with them.
    #[test]
    fn axes_and_units_of_single_points_change_nothing(
        p in points(6), a in prop::collection::vec(-1.0..1.0f64, 36 * 36),
        turns in prop::collection::vec((0.0..6.3f64, -4..5i32), 12),
    ) {
        let little: Vec<_> = p.iter().map(|&(kind, mu, x)| (kind, 0.1 * mu, x)).collect();
        let (problem, chosen) = constructed(&little, &a, 3 * p.len(), 1.0);
        let size = 3 * p.len();
        // W' = S T' W T S, q' = S T' q, r' = S⁻¹ T' r.
        let turn = dense(size, size, |i, j| {
            let (angle, power) = turns[i / 3];
            let (s, c) = angle.sin_cos();
            let t = [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]];
            if i / 3 == j / 3 { t[i % 3][j % 3] * 2f64.powi(power) } else { 0.0 }
        });
        let columns: Vec<Vec<f64>> = (0..size)
            .map(|j| {
                let unit: Vec<f64> = (0..size).map(|i| f64::from(u8::from(i == j))).collect();
                turn.times(&problem.W.times(&turn.transpose_times(&unit)))
            })
            .collect();
        let other = local(dense(size, size, |i, j| columns[j][i]), turn.times(&problem.q), problem.mu.clone());
        let found = run(&other);
        prop_assert_eq!(found.status, Status::Solved);
        // Back: r = T S r'.
        let r = turn.transpose_times(&found.r);
        let error: Vec<f64> = r.iter().zip(&chosen).map(|(a, b)| a - b).collect();
        prop_assert!(norm(&error) <= 1e-5 * norm(&chosen).max(norm(&problem.q)), "{}", norm(&error));
    }
}

#[test]
fn a_block_on_a_table_slips_just_above_the_friction_limit_and_sticks_just_below() {
    for (push, slips) in [(0.299, false), (0.301, true)] {
        let found = run(&local(dense(3, 3, |i, j| f64::from(u8::from(i == j))), vec![-1.0, push, 0.0], vec![0.3]));
        assert_eq!(found.status, Status::Solved);
        let wanted = if slips { [1.0, -0.3, 0.0] } else { [1.0, -push, 0.0] };
        assert!(found.r.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-8), "{:?}", found.r);
        assert_eq!(found.u[1].abs() > 1e-4, slips);
    }
}

#[test]
fn degenerate_points_are_no_obstacle() {
    let identity = |size: usize| dense(size, size, |i, j| f64::from(u8::from(i == j)));
    // Nothing moves and nothing presses; a point that only touches; no friction at all; a point that feels nothing.
    let cases = [
        local(identity(3), vec![0.0; 3], vec![0.5]),
        local(identity(3), vec![0.0, 1.0, 0.0], vec![0.5]),
        local(identity(3), vec![-1.0, 1.0, 2.0], vec![0.0]),
        local(dense(6, 6, |i, j| f64::from(u8::from(i == j && i < 3))), vec![-1., 0.2, 0., 1., 0.3, 0.], vec![0.5; 2]),
        // The same point three times: its impulse can be shared out in any way.
        local(dense(9, 9, |i, j| f64::from(u8::from(i % 3 == j % 3))), [-1.0, 3.0, 0.5].repeat(3), vec![0.4; 3]),
    ];
    for problem in cases {
        let found = run(&problem);
        assert_eq!(found.status, Status::Solved, "{problem:?}");
        assert!(judge(&problem, &found.r).worst() <= 1e-8);
    }
    let none = run(&local(Csr::zero(0, 0), Vec::new(), Vec::new()));
    assert_eq!((none.status, none.r.len()), (Status::Solved, 0));
}

#[test]
fn a_problem_without_solution_is_not_called_solved() {
    // The point approaches and no impulse can stop it.
    let found = run(&local(dense(3, 3, |i, j| f64::from(u8::from(i == j && i > 0))), vec![-1.0, 0.0, 0.0], vec![0.5]));
    assert_eq!(found.status, Status::MaxIterations);
    assert!(found.measures.worst() > 1e-3 && found.r.iter().all(|x| x.is_finite()));
    // Two points at one body that press against each other: W has no impulse that opens both.
    let w = dense(6, 6, |i, j| if i % 3 == j % 3 { if i == j { 1.0 } else { -1.0 } } else { 0.0 });
    let found = run(&local(w, vec![-1.0, 0.0, 0.0, -1.0, 0.0, 0.0], vec![0.5; 2]));
    assert_eq!(found.status, Status::MaxIterations);
}

#[test]
fn two_dimensions_are_three_with_nothing_in_the_third() {
    let a = [0.9, -0.3, 0.2, 0.5, 0.1, 0.8, -0.6, 0.3, -0.2, 0.4, 0.7, 0.1, 0.3, -0.5, 0.2, 0.9];
    let entry = |i: usize, j: usize| (0..4).map(|k| a[4 * i + k] * a[4 * j + k]).sum::<f64>();
    let q = [-1.0, 0.7, -0.4, -0.9];
    let mu = vec![0.3, 0.6];
    let flat = LocalProblem { dimension: 2, W: dense(4, 4, entry), q: q.to_vec(), mu: mu.clone(), bilateral: None };
    let at = |i: usize| (i % 3 < 2).then_some(2 * (i / 3) + i % 3);
    let w = dense(6, 6, |i, j| at(i).zip(at(j)).map_or(0.0, |(i, j)| entry(i, j)));
    let solid = local(w, (0..6).map(|i| at(i).map_or(0.0, |i| q[i])).collect(), mu);
    let (flat, solid) = (run(&flat), run(&solid));
    assert_eq!((flat.status, solid.status), (Status::Solved, Status::Solved));
    assert!((0..6).all(|i| (solid.r[i] - at(i).map_or(0.0, |i| flat.r[i])).abs() < 1e-7));
    assert!(flat.r.iter().any(|r| r.abs() > 0.1));
}

#[test]
fn bodies_tied_by_equations_move_as_one_body() {
    // v1 = v2 by equations is one body of mass 3: r_n = 5, friction 0.2 * 5 against the push (4, 0.5).
    let tie = dense(6, 3, |i, j| if i == j { 1.0 } else { -f64::from(u8::from(i == j + 3)) });
    let tied = GlobalProblem { equalities: Some(Equalities { G: tie, b: vec![0.0; 3] }), ..two_bodies() };
    let problem = DiscreteProblem::Global(tied);
    problem.validate().unwrap();
    let condensed = condense(&problem).unwrap();
    let found = run(&condensed.local);
    let back = condensed.recover(&problem, &found.r);
    let push = [4.0f64, 0.5];
    let length = push[0].hypot(push[1]);
    let wanted = [5.0, -push[0] / length, -push[1] / length];
    assert!(found.r.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-7), "{:?}", found.r);
    assert!(back.equilibrium < 1e-12);
    for i in 0..3 {
        let speed = if i == 0 { 0.0 } else { (push[i - 1] + wanted[i]) / 3.0 };
        assert!((back.v[i] - speed).abs() < 1e-7 && (back.v[i + 3] - speed).abs() < 1e-7, "{:?}", back.v);
    }
    // The same as a local problem with its bilateral part: V = H'M⁻¹G, R = G'M⁻¹G, s = G'M⁻¹f.
    let v = dense(3, 3, |i, j| if i == j { 0.5 } else { 0.0 });
    let r = dense(3, 3, |i, j| if i == j { 1.5 } else { 0.0 });
    let s = vec![-2.0 + 1.0, 0.5 - 3.0, -0.5];
    let free = condense(&DiscreteProblem::Global(two_bodies())).unwrap().local;
    let half = LocalProblem { bilateral: Some(Bilateral { V: v, R: r, s }), ..free };
    let problem = DiscreteProblem::Local(half);
    let condensed = condense(&problem).unwrap();
    let second = run(&condensed.local);
    let back = condensed.recover(&problem, &second.r);
    assert!(second.r.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-7), "{:?}", second.r);
    assert!(back.equilibrium < 1e-12 && judge(&condensed.local, &second.r).worst() <= 1e-8);
}

#[test]
fn masses_that_vanish_are_refused() {
    let light = GlobalProblem { M: dense(6, 6, |i, j| f64::from(u8::from(i == j && i > 0))), ..two_bodies() };
    let light = DiscreteProblem::Global(light);
    for form in [Form::Condensed, Form::Sparse] {
        let error = prepare(&light, form, Method::Auto).unwrap_err().to_string();
        assert!(error.contains("M is singular"), "{error}");
    }
}

#[test]
fn an_unsymmetric_mass_is_used_as_it_is() {
    let skew = |i: usize, j: usize| if i == j { 2.0 } else { 0.3 * (i as f64 - j as f64) / 6.0 };
    let problem = DiscreteProblem::Global(GlobalProblem { M: dense(6, 6, skew), ..two_bodies() });
    let condensed = condense(&problem).unwrap();
    let found = run(&condensed.local);
    let back = condensed.recover(&problem, &found.r);
    assert!(found.status == Status::Solved && back.equilibrium < 1e-13, "{}", back.equilibrium);
    // H is the identity on the first body: its velocities are those of the point.
    assert!((0..3).all(|i| (back.v[i] - found.u[i]).abs() < 1e-12));
}

#[test]
fn piles_with_much_friction_are_solved() {
    for (seed, mu) in [(1, 0.3), (2, 0.7), (3, 1.0), (4, 1.0), (5, 0.0)] {
        let problem = DiscreteProblem::Global(pile(30, 100, mu, Normals::Apart, seed));
        problem.validate().unwrap();
        let condensed = condense(&problem).unwrap();
        let found = run(&condensed.local);
        assert_eq!(found.status, Status::Solved, "{seed} {mu}: {:?}", found.measures);
        assert!(judge(&condensed.local, &found.r).worst() <= 1e-8);
        assert!(condensed.recover(&problem, &found.r).equilibrium < 1e-12);
    }
}
