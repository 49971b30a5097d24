//! `stiction::solve`, the way in for matrices: what it finds without any mesh, and what it refuses.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use stiction::contact::SurfaceFriction;
use stiction::linalg::Stop;
use stiction::mesh::BlockElement;
use stiction::{
    ContactProblem, Csr, Friction, Kept, PointState, Settings, SolveEvent, SolverPath, Status, SymmetricCsr, solve,
    solve_with_kept,
};

use stiction_fixtures::{BrickLoad, brick, distance};

/// A node on three springs of 1000, pressed by 10 on a plane below, coefficient 0.3, pulled along it.
fn node(pull: f64) -> ContactProblem {
    let k = Csr::from_triplets(3, 3, &[(0, 0, 1e3), (1, 1, 1e3), (2, 2, 1e3)]);
    let b = Csr::from_triplets(3, 3, &[(0, 2, -1.0), (1, 0, 1.0), (2, 1, 1.0)]);
    let k = SymmetricCsr::from_full(&k, "K").unwrap();
    ContactProblem::from_matrices(k, vec![pull, 0.0, -10.0], b, vec![0.0], vec![Friction::Coulomb { coefficient: 0.3 }])
}

fn pressed() -> ContactProblem {
    brick(6, BlockElement::Tet4Six, BrickLoad::Press, SurfaceFriction::Coulomb(0.35)).pose().problem
}

#[test]
fn a_node_on_springs_slips_beyond_the_limit_of_friction_as_the_closed_form_says() {
    let solution = solve(&node(4.0), &Settings::default()).unwrap();
    assert_eq!((solution.status, solution.states[0]), (Status::Solved, PointState::Slip));
    assert!(distance(&solution.lambda, &[10.0, 3.0, 0.0]) < 1e-9, "{:?}", solution.lambda);
    assert!(distance(&solution.u, &[1e-3, 0.0, 0.0]) < 1e-9, "{:?}", solution.u);
}

/// Of two nodes the second is held where it overlaps: its normal row is empty, as elimination leaves it.
#[test]
fn an_overlap_that_nothing_can_part_is_no_problem_to_solve() {
    let two = |overlap: f64| {
        let mut problem = node(1.0);
        problem.contact.B = Csr::from_triplets(6, 3, &[(0, 2, -1.0), (2, 0, 1.0), (4, 1, 1.0)]);
        problem.contact.gap = vec![0.0, -overlap];
        problem.contact.slip_reference = vec![0.0; 4];
        problem.contact.friction = vec![problem.contact.friction[0]; 2];
        (problem.labels.area, problem.labels.unity_sum) = (vec![1.0; 2], vec![1.0; 2]);
        problem.labels.pairs[0].points = 0..2;
        solve(&problem, &Settings::default())
    };
    let error = two(1e-3).unwrap_err();
    assert_eq!(error.what, "contact.gap[1]: contact point 1 is held and overlaps by 0.001");
    assert!(error.remedy.contains("give it a gap of at least 0"), "{error}");
    // What rounding leaves of a gap is none.
    assert_eq!(two(1e-16).unwrap().status, Status::Solved);
    assert_eq!(two(-1e-3).unwrap().status, Status::Solved);
}

#[test]
fn bare_matrices_and_a_posed_problem_have_the_same_solution_on_every_path() {
    let posed = pressed();
    let first = solve(&posed, &Settings { tolerance: 1e-10, ..Settings::default() }).unwrap();
    let (elastic, contact) = (posed.elastic.clone(), posed.contact.clone());
    let bare = ContactProblem::from_matrices(elastic.K, elastic.f, contact.B, contact.gap, contact.friction);
    for (problem, path) in [
        (&bare, SolverPath::Auto),
        (&bare, SolverPath::Dense),
        (&bare, SolverPath::Solves),
        (&posed, SolverPath::Multigrid),
    ] {
        let found = solve(problem, &Settings { tolerance: 1e-10, path, ..Settings::default() }).unwrap();
        assert_eq!(found.status, Status::Solved, "{path:?}");
        assert!(path == SolverPath::Auto || found.path == path, "{path:?} {:?}", found.path);
        assert!(distance(&found.u, &first.u) < 1e-8 && distance(&found.lambda, &first.lambda) < 1e-7, "{path:?}");
    }
}

#[test]
fn what_is_kept_serves_the_next_load_and_counts_begin_anew() {
    let (mut problem, mut kept, mut factorised) = (pressed(), Kept::default(), 0);
    (problem.labels.supports, problem.labels.bodies) = (None, None); // supports repeat the load
    let settings = Settings { path: SolverPath::Dense, ..Settings::default() };
    let mut counts = Vec::new();
    for factor in [1.0, 1.0, 1.5] {
        problem.elastic.f.iter_mut().for_each(|f| *f *= factor);
        let mut observer = |event: &SolveEvent| {
            factorised += usize::from(matches!(event, SolveEvent::Factorising { .. }));
            ControlFlow::Continue(())
        };
        let solution = solve_with_kept(&problem, &settings, &mut kept, &mut observer).unwrap();
        assert_eq!(solution.status, Status::Solved);
        counts.push(solution.counts);
    }
    assert_eq!(factorised, 1);
    assert_eq!(counts[0], counts[1]);
}

#[test]
fn a_stop_at_an_iteration_is_a_status() {
    for path in [SolverPath::Dense, SolverPath::Multigrid] {
        let settings = Settings { path, ..Settings::default() };
        let mut observer = |event: &SolveEvent| match event {
            SolveEvent::Iteration(progress) if progress.iteration > 0 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let solution = solve_with_kept(&pressed(), &settings, &mut Kept::default(), &mut observer).unwrap();
        assert_eq!(solution.status, Status::Interrupted, "{path:?}");
    }
}

#[test]
fn a_stop_is_answered_by_no_fallback() {
    for questions in (0..60).chain((60..400).step_by(20)) {
        let asked = AtomicUsize::new(0);
        let stop = Stop::when(move || asked.fetch_add(1, Ordering::Relaxed) >= questions);
        let settings = Settings { path: SolverPath::Dense, tolerance: 1e-12, stop, ..Settings::default() };
        let Ok(solution) = solve(&pressed(), &settings) else { continue };
        // A system that is stopped within gives a step of no use, which is no reason for gradient steps.
        assert_eq!(solution.counts.restarts, 0, "after {questions}");
        assert!(matches!(solution.status, Status::Interrupted | Status::Solved), "after {questions}");
    }
}

#[test]
fn a_start_that_the_path_cannot_use_is_refused_and_auto_takes_the_path_that_can() {
    let problem = pressed();
    let with = |path, start: bool, displacement: bool| Settings {
        path,
        start: start.then(|| vec![0.0; 3 * problem.points()]),
        start_displacement: displacement.then(|| vec![0.0; problem.unknowns()]),
        ..Settings::default()
    };
    for (path, start, displacement, named) in [
        (SolverPath::Multigrid, true, false, "`start` holds multipliers"),
        (SolverPath::Multigrid, true, true, "`start` holds multipliers"),
        (SolverPath::Dense, false, true, "`start_displacement` is for multigrid"),
        (SolverPath::Solves, false, true, "`start_displacement` is for multigrid"),
    ] {
        let error = solve(&problem, &with(path, start, displacement)).unwrap_err().to_string();
        assert!(error.contains(named) && error.contains("; give `start"), "{path:?}: {error}");
    }
    let taken = |start, displacement| solve(&problem, &with(SolverPath::Auto, start, displacement)).unwrap().path;
    assert_eq!(taken(false, true), SolverPath::Multigrid);
    assert_ne!(taken(true, false), SolverPath::Multigrid);
    assert_eq!(taken(true, true), taken(false, false));
    // Beside multipliers a factor takes from them where floating bodies are.
    assert_eq!(solve(&problem, &with(SolverPath::Solves, true, true)).unwrap().path, SolverPath::Solves);
    // Where the only path that could use it is none for the problem, the start is not left unused.
    let mut bare = problem.clone();
    (bare.elastic.node_of, bare.elastic.near_kernel) = (None, None);
    let error = solve(&bare, &with(SolverPath::Auto, false, true)).unwrap_err().to_string();
    assert!(error.contains("`start_displacement` is a start for multigrid alone"), "{error}");
}

/// Each mistake with a word of the message that names it.
#[test]
fn what_cannot_be_solved_is_named_by_its_argument() {
    type Mistake = fn(&mut ContactProblem, &mut Settings);
    let mistakes: [(&str, Mistake); 25] = [
        ("elastic.K has the diagonal entry", |p, _| {
            *std::sync::Arc::make_mut(&mut p.elastic.K).entry_mut(1, 1).unwrap() = -1.0
        }),
        ("rows of elastic.K", |p, _| p.elastic.f.push(0.0)),
        ("elastic.f[2] is NaN", |p, _| p.elastic.f[2] = f64::NAN),
        ("rows of contact.B", |p, _| p.contact.gap.push(0.0)),
        ("columns of contact.B", |p, _| p.contact.B.cols = 7),
        ("contact.B", |p, _| p.contact.B.column[0] = 9),
        ("contact.gap[0] is inf", |p, _| p.contact.gap[0] = f64::INFINITY),
        ("contact.slip_reference", |p, _| p.contact.slip_reference.clear()),
        ("contact.friction", |p, _| p.contact.friction.clear()),
        ("coefficient of point 0 is -0.3", |p, _| {
            p.contact.friction[0] = Friction::Coulomb { coefficient: -0.3 };
        }),
        ("contact.orthotropy[0]", |p, _| p.contact.orthotropy = Some(vec![1.5])),
        ("labels.area", |p, _| p.labels.area.push(1.0)),
        ("labels.area[0] is NaN", |p, _| p.labels.area[0] = f64::NAN),
        ("labels.unity_sum", |p, _| p.labels.unity_sum.clear()),
        ("labels.pairs", |p, _| p.labels.pairs.clear()),
        ("elastic.node_of", |p, _| p.elastic.node_of = Some(vec![0])),
        ("do not follow one another", |p, _| p.elastic.node_of = Some(vec![4, 2, 4])),
        ("elastic.near_kernel[1]", |p, _| {
            p.elastic.near_kernel = Some(vec![[0.0; 6], [f64::NAN; 6], [0.0; 6]]);
        }),
        ("`elastic.node_of` is missing", |p, _| {
            (p.elastic.node_of, p.elastic.middles) = (None, Some(vec![[1, 0, 2]]));
        }),
        ("node 1 is in the middle of two edges", |p, _| {
            p.elastic.node_of = Some(vec![0; 3]);
            p.elastic.middles = Some(vec![[1, 0, 2], [1, 3, 4]]);
        }),
        ("an end of the edge of node 3", |p, _| {
            p.elastic.node_of = Some(vec![0; 3]);
            p.elastic.middles = Some(vec![[1, 0, 2], [3, 1, 4]]);
        }),
        ("`tolerance` is 0", |_, s| s.tolerance = 0.0),
        ("`tolerance` is NaN", |_, s| s.tolerance = f64::NAN),
        ("`start` has 1 numbers where 3 are needed", |_, s| s.start = Some(vec![1.0])),
        ("`start_displacement`[0] is inf", |_, s| s.start_displacement = Some(vec![f64::INFINITY; 3])),
    ];
    for (named, mistake) in mistakes {
        let (mut problem, mut settings) = (node(1.0), Settings::default());
        mistake(&mut problem, &mut settings);
        let error = solve(&problem, &settings).expect_err(named).to_string();
        assert!(error.contains(named) && error.contains("; "), "{named}: {error}");
    }
}

#[test]
fn a_stiffness_that_is_not_positive_definite_is_an_error() {
    let indefinite = [(0, 0, 1.0), (0, 1, 2.0), (1, 0, 2.0), (1, 1, 1.0), (2, 2, 1.0)];
    let mut problem = node(1.0);
    problem.elastic.K = SymmetricCsr::from_full(&Csr::from_triplets(3, 3, &indefinite), "K").unwrap().into();
    let error = solve(&problem, &Settings::default()).unwrap_err().to_string();
    assert!(error.contains("positive"), "{error}");
}

#[test]
fn too_little_memory_is_reported_with_the_argument_that_limits_it() {
    for path in [SolverPath::Dense, SolverPath::Multigrid] {
        let settings = Settings { path, memory_limit: Some(1000), ..Settings::default() };
        let error = solve(&pressed(), &settings).unwrap_err().to_string();
        assert!(error.contains("settings.memory_limit") && !error.contains("[solver]"), "{error}");
    }
}

#[test]
fn numbers_at_the_ends_of_their_range_are_no_panic() {
    let values = [0.0, -0.0, 1e-320, 1e-300, 1e-30, 1.0, 1e30, 1e300, f64::MAX];
    let laws = [
        Friction::None,
        Friction::Bonded,
        Friction::Given { slip_bound: f64::MAX },
        Friction::Coulomb { coefficient: f64::MAX },
        Friction::Limited { coefficient: 1e300, limit: 1e-300 },
    ];
    for (i, &a) in values.iter().enumerate() {
        for (j, &b) in values.iter().enumerate() {
            let mut problem = node(a);
            problem.elastic.f[2] = -b;
            problem.contact.gap[0] = values[(i + j) % values.len()];
            problem.contact.friction[0] = laws[(i + 3 * j) % laws.len()];
            for path in [SolverPath::Dense, SolverPath::Solves, SolverPath::Multigrid] {
                // A certificate that passes is of finite numbers; all else is an error or another status.
                if let Ok(solution) = solve(&problem, &Settings { path, max_iterations: 30, ..Settings::default() }) {
                    let finite = solution.u.iter().chain(&solution.lambda).all(|x| x.is_finite());
                    assert!(finite || solution.status != Status::Solved, "{a} {b} {path:?}");
                }
            }
        }
    }
}

#[test]
fn a_problem_without_contact_points_is_one_elastic_solve() {
    let k = SymmetricCsr::from_full(&Csr::from_triplets(2, 2, &[(0, 0, 4.0), (1, 1, 2.0)]), "K").unwrap();
    let problem = ContactProblem::from_matrices(k, vec![8.0, 1.0], Csr::zero(0, 2), vec![], vec![]);
    let solution = solve(&problem, &Settings::default()).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert!(distance(&solution.u, &[2.0, 0.5]) < 1e-14, "{:?}", solution.u);
}
