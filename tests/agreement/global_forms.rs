//! Global problems with `W` formed and with velocities kept; bilateral constraints that repeat; guesses.

use std::ops::ControlFlow;

use stiction::contact::SurfaceFriction;
use stiction::discrete::{Bilateral, DiscreteProblem, Equalities, GlobalProblem, LocalProblem};
use stiction::discrete::{Form, Method, Settings, Solution, Status, prepare};
use stiction::io::Contents;
use stiction::linalg::norm;
use stiction::mesh::BlockElement;
use stiction::run::algebraic::{self, Answer};
use stiction_fixtures::piles::{dense, global_of, two_bodies};
use stiction_fixtures::{BrickLoad, brick};

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let change: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    norm(&change) / norm(b).max(f64::MIN_POSITIVE)
}

fn elastic(cells: usize, element: BlockElement, load: BrickLoad, mu: f64) -> GlobalProblem {
    global_of(&brick(cells, element, load, SurfaceFriction::Coulomb(mu)).pose().problem)
}

fn answer(problem: GlobalProblem, form: Form, method: Method) -> Answer {
    let contents = Contents { problem: DiscreteProblem::Global(problem), solution: None, guesses: Vec::new() };
    contents.problem.validate().unwrap();
    let settings = Settings { method, ..Settings::default() };
    algebraic::answer(&contents, &settings, form, &mut |_| ControlFlow::Continue(())).unwrap()
}

#[test]
fn an_elastic_body_has_the_same_answer_condensed_and_sparse() {
    for (element, load, mu) in [
        (BlockElement::Hex8, BrickLoad::Lift, 0.35),
        (BlockElement::Tet4Six, BrickLoad::Press, 0.1),
        (BlockElement::Hex8, BrickLoad::Press, 0.0),
    ] {
        let problem = elastic(6, element, load, mu);
        assert!(problem.f.len() > 2000, "{}", problem.f.len());
        let [condensed, sparse] = [Form::Condensed, Form::Sparse].map(|f| answer(problem.clone(), f, Method::Auto));
        assert!(condensed.passed() && sparse.passed());
        assert!(condensed.entries.is_some() && sparse.entries.is_none());
        // The same iterates but for rounding.
        assert_eq!(condensed.solution.counts, sparse.solution.counts);
        assert!(apart(&sparse.solution.r, &condensed.solution.r) < 1e-9);
        assert!(apart(&sparse.recovered.v, &condensed.recovered.v) < 1e-9);
        // The local flexibilities come from two roads: entries of W, and the inverse on the pattern of the factor.
        let problem = DiscreteProblem::Global(problem);
        let forms = [Form::Condensed, Form::Sparse].map(|form| prepare(&problem, form, Method::Auto).unwrap());
        let rest = vec![0.0; condensed.solution.r.len()];
        let measures = forms.each_ref().map(|form| form.measures(&rest, &form.recover(&rest).u));
        let [a, b] = measures.map(|m| m.all().map(|m| m.1));
        assert!(a[2] > 0.1 && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-9 * a.abs()), "{a:?} {b:?}");
    }
}

#[test]
fn the_cheaper_form_is_taken() {
    // 216 points on one body: 46 656 dense blocks, against one sparse factor a Newton step.
    let large = DiscreteProblem::Global(elastic(8, BlockElement::Hex8, BrickLoad::Lift, 0.35));
    assert!(prepare(&large, Form::Auto, Method::Auto).unwrap().condensed().is_none());
    // Sweeps need W.
    let small = DiscreteProblem::Global(elastic(3, BlockElement::Hex8, BrickLoad::Lift, 0.35));
    for (form, method) in [(Form::Auto, Method::Auto), (Form::Sparse, Method::GaussSeidel)] {
        assert!(prepare(&small, form, method).unwrap().condensed().is_some());
    }
}

#[test]
fn every_method_finds_the_elastic_body_in_both_forms() {
    let problem = elastic(3, BlockElement::Tet4Six, BrickLoad::Press, 0.2);
    let wanted = answer(problem.clone(), Form::Condensed, Method::Newton);
    for method in Method::ALL {
        for form in [Form::Condensed, Form::Sparse] {
            let found = answer(problem.clone(), form, method);
            assert!(found.passed(), "{method:?} {form:?} {:?}", found.measures);
            assert!(apart(&found.solution.r, &wanted.solution.r) < 1e-5, "{method:?} {form:?}");
        }
    }
}

/// Two bodies on a line, tied by `v1 = v2`; the ties twice, once times three.
fn tied(repeated: bool, wrong: f64) -> GlobalProblem {
    let ties = if repeated { 6 } else { 3 };
    let factor = |k: usize| if k < 3 { 1.0 } else { 3.0 };
    let tie = |i: usize, k: usize| match i {
        _ if i == k % 3 => factor(k),
        _ if i == k % 3 + 3 => -factor(k),
        _ => 0.0,
    };
    let b = (0..ties).map(|k| 0.3 * factor(k) + if k == 4 { wrong } else { 0.0 }).collect();
    GlobalProblem { equalities: Some(Equalities { G: dense(6, ties, tie), b }), ..two_bodies() }
}

#[test]
fn constraints_that_repeat_are_left_out_and_counted() {
    let single = answer(tied(false, 0.0), Form::Condensed, Method::Auto);
    assert_eq!((single.dropped, single.passed()), (0, true));
    for form in [Form::Condensed, Form::Sparse] {
        let found = answer(tied(true, 0.0), form, Method::Auto);
        assert!(found.passed() && found.dropped == 3, "{} {:?}", found.dropped, found.measures);
        // v1 - v2 = -0.3, and the impulses of a mass of 3 on the table.
        let v = &found.recovered.v;
        assert!((0..3).all(|i| (v[i] - v[i + 3] + 0.3).abs() < 1e-12), "{v:?}");
        assert!(apart(&found.solution.r, &single.solution.r) < 1e-7);
        assert_eq!(found.recovered.l.len(), 6);
        assert!(found.recovered.l[3..].iter().all(|l| *l == 0.0));
    }
    let contents = Contents { problem: DiscreteProblem::Global(tied(true, 1e-3)), solution: None, guesses: Vec::new() };
    let ended = algebraic::answer(&contents, &Settings::default(), Form::Auto, &mut |_| ControlFlow::Continue(()));
    let error = ended.unwrap_err().to_string();
    assert!(error.contains("bilateral constraint 4 contradicts"), "{error}");
}

#[test]
fn repeated_bilateral_rows_of_a_local_problem_are_left_out() {
    let with = |ties: usize, wrong: f64| {
        let factor = |k: usize| if k == 0 { 1.0 } else { -2.0 };
        DiscreteProblem::Local(LocalProblem {
            dimension: 3,
            W: dense(3, 3, |i, j| if i == j { 2.0 } else { 0.1 }),
            q: vec![-1.0, 0.7, -0.2],
            mu: vec![0.4],
            bilateral: Some(Bilateral {
                V: dense(3, ties, |i, k| factor(k) * [0.3, 0.2, -0.1][i]),
                R: dense(ties, ties, |k, l| 0.5 * factor(k) * factor(l)),
                s: (0..ties).map(|k| 0.25 * factor(k) + k as f64 * wrong).collect(),
            }),
        })
    };
    let run = |problem: &DiscreteProblem| {
        let prepared = prepare(problem, Form::Auto, Method::Auto).unwrap();
        let found: Solution = prepared.solve(&Settings::default(), &mut |_| ControlFlow::Continue(())).unwrap();
        (found.r.clone(), prepared.recover(&found.r), prepared.dropped())
    };
    let (wanted, _, none) = run(&with(1, 0.0));
    let (found, recovered, dropped) = run(&with(2, 0.0));
    assert_eq!((none, dropped), (0, 1));
    assert!(apart(&found, &wanted) < 1e-7 && recovered.equilibrium < 1e-12 && recovered.l.len() == 2);
    assert!(prepare(&with(2, 0.1), Form::Auto, Method::Auto).unwrap_err().to_string().contains("contradicts"));
}

#[test]
fn a_guess_is_a_start_and_never_trusted() {
    let problem = elastic(4, BlockElement::Hex8, BrickLoad::Lift, 0.35);
    let from = |guesses: Vec<Vec<f64>>| {
        let problem = DiscreteProblem::Global(problem.clone());
        let contents = Contents { problem, solution: None, guesses };
        let settings = Settings::default();
        algebraic::answer(&contents, &settings, Form::Auto, &mut |_| ControlFlow::Continue(())).unwrap()
    };
    let plain = from(Vec::new());
    let exact = plain.solution.r.clone();
    assert!(plain.guess.is_none() && plain.solution.counts.newton_steps > 3);
    // The solution itself, behind rubbish: judged, chosen, and done.
    let rubbish = |x: f64| exact.iter().enumerate().map(|(i, _)| x * (i as f64 * 1.3).sin()).collect::<Vec<f64>>();
    let told = from(vec![rubbish(1e3), exact.clone()]);
    assert_eq!(told.guess.unwrap().chosen.unwrap().0, 2);
    assert!(told.passed() && told.solution.counts.newton_steps <= 1, "{:?}", told.solution.counts);
    // A guess one per cent off saves steps.
    let near = from(vec![exact.iter().map(|r| 1.01 * r).collect()]);
    assert!(near.passed() && near.solution.counts.newton_steps < plain.solution.counts.newton_steps);
    for nonsense in [rubbish(1e3), rubbish(1e12), vec![f64::NAN; exact.len()], vec![1e300; exact.len()]] {
        let found = from(vec![nonsense]);
        assert!(found.passed(), "{:?} {:?}", found.guess, found.measures);
        assert!(apart(&found.solution.r, &exact) < 1e-6);
        assert_eq!(found.guess.unwrap().guesses, 1);
    }
    assert_eq!(from(vec![vec![f64::NAN; exact.len()]]).guess.unwrap().chosen, None);
    assert_eq!(plain.solution.status, Status::Solved);
}
