//! Files of discrete problems: written, read back, damaged, and solved as the finite-element side solves them.

use std::ops::ControlFlow;

use stiction::contact::{Friction, SurfaceFriction};
use stiction::discrete::{Bilateral, DiscreteProblem, Equalities, GlobalProblem, LocalProblem};
use stiction::discrete::{Form, Settings, Status, condense};
use stiction::dual::Form as DualForm;
use stiction::io::fclib_write::{State, write};
use stiction::io::{Contents, fclib};
use stiction::linalg::Csr;
use stiction::mesh::BlockElement;
use stiction::run::algebraic;
use stiction_fixtures::folder::Folder;
use stiction_fixtures::{BrickLoad, brick, dual_of, settings};

fn small(dimension: usize) -> DiscreteProblem {
    let size = 2 * dimension;
    let w: Vec<(usize, usize, f64)> = (0..size)
        .flat_map(|i| {
            (0..size).map(move |j| (i, j, if i == j { 2.0 } else { 0.1 * (i as f64 - 2.0 * j as f64).sin() }))
        })
        .collect();
    DiscreteProblem::Local(LocalProblem {
        dimension,
        W: Csr::from_triplets(size, size, &w),
        q: (0..size).map(|i| (1.7 * i as f64).sin() - 0.6).collect(),
        mu: vec![0.3, 0.7],
        bilateral: None,
    })
}

fn with_equations() -> [DiscreteProblem; 2] {
    let DiscreteProblem::Local(local) = small(3) else { unreachable!() };
    let v = Csr::from_triplets(6, 1, &[(0, 0, 0.3), (4, 0, -0.2)]);
    let r = Csr::from_triplets(1, 1, &[(0, 0, 1.5)]);
    let global = GlobalProblem {
        dimension: 3,
        M: Csr::from_triplets(3, 3, &[(0, 0, 2.0), (1, 1, 3.0), (2, 2, 1.0), (0, 1, 0.5), (1, 0, 0.5)]),
        H: Csr::from_triplets(3, 3, &[(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0)]),
        f: vec![-1.0, 0.4, 0.2],
        w: vec![0.1, 0.0, 0.0],
        mu: vec![0.4],
        equalities: Some(Equalities { G: Csr::from_triplets(3, 1, &[(2, 0, 1.0)]), b: vec![0.3] }),
    };
    let local = LocalProblem { bilateral: Some(Bilateral { V: v, R: r, s: vec![0.25] }), ..local };
    [DiscreteProblem::Local(local), DiscreteProblem::Global(global)]
}

#[test]
fn a_file_read_back_is_what_was_written() {
    let folder = Folder::new("fclib-back");
    let file = folder.at("problem.hdf5");
    for problem in [small(2), small(3)].into_iter().chain(with_equations()) {
        let size = problem.dimension() * problem.points();
        let state = |x: f64| State { r: vec![x; size], u: vec![2.0 * x; size], ..State::default() };
        write(&file, &problem, Some(&state(1.5)), &[state(0.25), state(-3.0)]).unwrap();
        let read = fclib::read(&file).unwrap();
        assert_eq!(read.problem, problem);
        assert_eq!(read.solution, Some(vec![1.5; size]));
        assert_eq!(read.guesses, [vec![0.25; size], vec![-3.0; size]]);
        write(&file, &problem, None, &[]).unwrap();
        assert_eq!(fclib::read(&file).unwrap(), Contents { problem, solution: None, guesses: Vec::new() });
    }
}

#[test]
fn what_is_damaged_is_named() {
    let folder = Folder::new("fclib-named");
    let file = folder.at("problem.hdf5");
    let DiscreteProblem::Local(local) = small(3) else { unreachable!() };
    let mut cases = vec![
        (LocalProblem { mu: vec![0.3; 3], ..local.clone() }, "q: 6 where 9 are needed"),
        (LocalProblem { mu: vec![0.3, -0.1], ..local.clone() }, "mu[1] is -0.1"),
        (LocalProblem { q: vec![f64::NAN; 6], ..local.clone() }, "q[0] is NaN"),
        (LocalProblem { dimension: 5, ..local.clone() }, "fclib_local/spacedim: it is 5"),
    ];
    let mut outside = local.clone();
    outside.W.column[5] = 77;
    cases.push((outside, "fclib_local/W: entry (0, 77) lies outside 6 x 6"));
    let mut short = local;
    short.W.start[6] = 99;
    cases.push((short, "fclib_local/W: pointer 6 of its rows is 99"));
    for (problem, words) in cases {
        write(&file, &DiscreteProblem::Local(problem), None, &[]).unwrap();
        let error = fclib::read(&file).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("named"), "{error}");
    }
    std::fs::write(&file, "no hdf5").unwrap();
    assert!(fclib::read(&file).unwrap_err().to_string().contains("HDF5"));
}

/// Each byte of a small file changed and each length cut: an error or another problem, never a panic.
#[test]
fn damaged_files_do_no_harm() {
    let folder = Folder::new("fclib-damaged");
    let file = folder.at("problem.hdf5");
    let [_, global] = with_equations();
    write(&file, &global, None, &[]).unwrap();
    let bytes = std::fs::read(&file).unwrap();
    let mut refused = 0;
    for at in 0..bytes.len() {
        for change in [0x01u8, 0x80, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] ^= change;
            refused += usize::from(fclib::parse(damaged).is_err());
        }
        if at % 7 == 0 {
            refused += usize::from(fclib::parse(bytes[..at].to_vec()).is_err());
        }
    }
    assert!(refused > bytes.len() / 7, "{refused} of {}", bytes.len());
}

/// The problem in units of velocity in which impulses and velocities are of like size; the impulses stay.
fn balanced(mut problem: GlobalProblem) -> GlobalProblem {
    let stiffness = problem.M.max_abs();
    problem.M.value.iter_mut().for_each(|k| *k /= stiffness);
    problem.w.iter_mut().for_each(|w| *w *= stiffness);
    problem
}

#[test]
fn the_brick_written_to_a_file_and_read_back_has_the_same_answer() {
    let folder = Folder::new("fclib-brick");
    let file = folder.at("problem.hdf5");
    for (load, coefficient) in [(BrickLoad::Lift, 0.35), (BrickLoad::Press, 0.35), (BrickLoad::Press, 0.0)] {
        let friction = if coefficient > 0.0 { SurfaceFriction::Coulomb(coefficient) } else { SurfaceFriction::None };
        let problem = brick(4, BlockElement::Tet4Six, load, friction).pose().problem;
        let dual = dual_of(&problem, DualForm::Auto);
        let own = stiction::friction::solve(&problem, &dual, &settings(1e-10), &mut |_| ControlFlow::Continue(()));
        let written = GlobalProblem::of(&problem).unwrap();
        let stiffness = written.M.max_abs();
        // In N and m impulses are 1e8 times the velocities: what depends on the units may then end at rounding.
        for (form, unit) in [(written.clone(), 1.0), (balanced(written), stiffness)] {
            write(&file, &DiscreteProblem::Global(form), None, &[]).unwrap();
            let contents = algebraic::read(&file).unwrap();
            let settings = Settings { tolerance: 1e-11, ..Settings::default() };
            let answer =
                algebraic::answer(&contents, &settings, Form::Auto, &mut |_| ControlFlow::Continue(())).unwrap();
            let ended = answer.solution.status;
            assert!(ended == Status::Solved || unit == 1.0 && ended == Status::Rounding, "{ended:?}");
            assert_eq!(answer.passed(), ended == Status::Solved);
            assert!(answer.measures.invariant <= 1e-11 && answer.recovered.equilibrium <= 1e-11);
            assert_same(&own, problem.points(), &answer, unit);
        }
    }
}

fn answer(contents: &Contents) -> algebraic::Answer {
    algebraic::answer(contents, &Settings::default(), Form::Auto, &mut |_| ControlFlow::Continue(())).unwrap()
}

#[track_caller]
fn assert_same(own: &stiction::friction::Solution, m: usize, answer: &algebraic::Answer, unit: f64) {
    let size = |x: &[f64]| x.iter().fold(0.0f64, |a, x| a.max(x.abs()));
    for (i, r) in answer.solution.r.iter().enumerate() {
        let lambda = own.lambda[i % 3 * m + i / 3];
        assert!((r - lambda).abs() < 1e-6 * size(&own.lambda), "{i}: {r} {lambda}");
    }
    assert!(answer.recovered.v.iter().zip(&own.u).all(|(v, u)| (v / unit - u).abs() < 1e-6 * size(&own.u)));
}

#[test]
fn laws_the_format_does_not_know_are_refused() {
    let posed = brick(2, BlockElement::Hex8, BrickLoad::Lift, SurfaceFriction::None).pose();
    for law in [Friction::Bonded, Friction::Given { slip_bound: 1.0 }] {
        let mut problem = posed.problem.clone();
        problem.contact.friction[3] = law;
        assert!(GlobalProblem::of(&problem).unwrap_err().to_string().contains("point 3"));
    }
}

#[test]
fn what_a_file_calls_a_solution_is_judged_and_not_used() {
    let DiscreteProblem::Local(local) = small(3) else { unreachable!() };
    let contents =
        |solution| Contents { problem: DiscreteProblem::Local(local.clone()), solution, guesses: Vec::new() };
    let plain = answer(&contents(None));
    let lied = answer(&contents(Some(vec![0.0; 6])));
    let told = answer(&contents(Some(plain.solution.r.clone())));
    assert!(plain.claimed.is_none() && plain.passed());
    assert_eq!((&lied.solution.r, &told.solution.r), (&plain.solution.r, &plain.solution.r));
    assert!(lied.claimed.unwrap().worst() > 0.1 && told.claimed.unwrap().worst() <= 1e-8);
    assert!(condense(&contents(None).problem).is_ok());
}

/// `[[2, 0.5], [0.5, 1]]` at one point in the plane: from FCLib, dense and sparse NumPy arrays and Matrix Market text.
#[test]
fn the_same_problem_from_every_kind_of_file_is_the_same() {
    use stiction::io::npz::{self, Array, Data};
    let folder = Folder::new("arrays");
    std::fs::create_dir_all(folder.at("text")).unwrap();
    let wanted = DiscreteProblem::Local(LocalProblem {
        dimension: 2,
        W: Csr::from_triplets(2, 2, &[(0, 0, 2.0), (0, 1, 0.5), (1, 0, 0.5), (1, 1, 1.0)]),
        q: vec![-1.0, 0.25],
        mu: vec![0.3],
        bilateral: None,
    });
    write(&folder.at("a.hdf5"), &wanted, None, &[]).unwrap();
    let dense = Array { shape: vec![2, 2], data: Data::F64(vec![2.0, 0.5, 0.5, 1.0].into()) };
    let vectors = [("q", Array::f64(&[-1.0, 0.25])), ("friction", Array::f64(&[0.3]))];
    npz::write(&folder.at("b.npz"), &[&[("W", dense)], &vectors[..]].concat()).unwrap();
    let sparse = [
        ("W_data", Array::f64(&[0.5, 2.0, 0.5, 1.0])),
        ("W_indices", Array::usize(&[1, 0, 0, 1])),
        ("W_indptr", Array::usize(&[0, 2, 4])),
        ("W_shape", Array::usize(&[2, 2])),
    ];
    npz::write(&folder.at("c.npz"), &[&sparse[..], &vectors[..]].concat()).unwrap();
    let text = |name: &str, text: &str| std::fs::write(folder.at("text").join(name), text).unwrap();
    text("W.mtx", "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 2\n2 1 .5\n2 2 1\n");
    text("q.mtx", "%%MatrixMarket matrix array real general\n2 1\n-1\n0.25\n");
    text("mu.mtx", "%%MatrixMarket matrix array real general\n1 1\n0.3\n");
    for name in ["a.hdf5", "b.npz", "c.npz", "text"] {
        assert_eq!(algebraic::read(&folder.at(name)).unwrap().problem, wanted, "{name}");
    }
    let error = algebraic::read(&folder.at("text/W.mtx")).unwrap_err().to_string();
    assert!(error.contains("folder"), "{error}");
    text("q.mtx", "%%MatrixMarket matrix array real general\n3 1\n-1\n0.25\n1\n");
    assert!(algebraic::read(&folder.at("text")).unwrap_err().to_string().contains("W: 2 where 3 are needed"));
}

#[test]
fn matrices_of_the_finite_element_side_are_a_global_problem() {
    use stiction::io::npz::{self, Array, Data};
    let posed = brick(1, BlockElement::Hex8, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35)).pose();
    let p = &posed.problem;
    let dense = |a: &Csr| {
        let values = (0..a.rows).flat_map(|i| (0..a.cols).map(move |j| a.entry(i, j))).collect();
        Array { shape: vec![a.rows, a.cols], data: Data::F64(values) }
    };
    let folder = Folder::new("posed");
    let file = folder.at("problem.npz");
    let coefficients = vec![0.35; p.points()];
    let arrays = [
        ("K", dense(&p.elastic.K.full())),
        ("B", dense(&p.contact.B)),
        ("f", Array::f64(&p.elastic.f)),
        ("gap", Array::f64(&p.contact.gap)),
        ("mu", Array::f64(&coefficients)),
    ];
    npz::write(&file, &arrays).unwrap();
    let read = algebraic::read(&file).unwrap();
    let own =
        stiction::friction::solve(p, &dual_of(p, DualForm::Auto), &settings(1e-10), &mut |_| ControlFlow::Continue(()));
    let found = answer(&read);
    assert!(found.measures.invariant <= 1e-8);
    assert_same(&own, p.points(), &found, 1.0);
}

#[test]
fn rolling_friction_and_foreign_files_are_refused() {
    for (group, words) in [("fclib_global_rolling", "rolling friction"), ("something", "neither fclib_local")] {
        let mut file = hdf5_pure::FileBuilder::new();
        let mut rolling = file.create_group(group);
        rolling.create_dataset("spacedim").with_i32_data(&[5]);
        file.add_group(rolling.finish());
        let error = fclib::parse(file.finish().unwrap()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
