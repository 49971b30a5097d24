//! The certificate accepts exact answers, in all units and where quantities vanish, and refuses them with one number wrong.

use std::ops::ControlFlow;
use std::path::Path;

use stiction::certificate::{Certificate, certify};
use stiction::contact::{ContactProblem, Friction, Obstacle, SurfaceFriction};
use stiction::friction::{Multigrid, Solution, Status, solve_multigrid};
use stiction::io::problem::write_solution;
use stiction::linalg::{Csr, SymmetricCsr};
use stiction::mesh::BlockElement;
use stiction::run::{Origin, Settings, check, prepare};
use stiction_fixtures::*;

const TOLERANCE: f64 = 1e-8;
/// Springs of the node, and the force that presses it on the plane.
const SPRING: f64 = 1000.0;
const PRESS: f64 = 10.0;
const COEFFICIENT: f64 = 0.3;

/// Lengths and forces of one old unit in new ones.
const UNITS: [[f64; 2]; 6] = [[1.0, 1.0], [1e-12, 1e9], [1e9, 1e-12], [1e-12, 1e-12], [1e9, 1e9], [39.37, 0.2248]];

/// One node on three equal springs above the plane z = 0, which it touches.
fn node(f: [f64; 3], law: Friction, [length, force]: [f64; 2]) -> ContactProblem {
    let k: Vec<_> = (0..3).map(|i| (i, i, SPRING * force / length)).collect();
    let k = SymmetricCsr::from_full(&Csr::from_triplets(3, 3, &k), "K").unwrap();
    let b = Csr::from_triplets(3, 3, &[(0, 2, -1.0), (1, 0, 1.0), (2, 1, 1.0)]);
    let law = match law {
        Friction::Given { slip_bound } => Friction::Given { slip_bound: slip_bound * force },
        other => other,
    };
    let mut problem = ContactProblem::from_matrices(k, f.map(|f| f * force).to_vec(), b, vec![0.0], vec![law]);
    problem.elastic.node_of = Some(vec![0; 3]);
    problem.validate().unwrap();
    problem
}

/// What the node does under a force of `along` beside the pressing one: it sticks up to the limit and slips beyond it.
fn exact(along: f64, [length, force]: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
    let friction = along.min(COEFFICIENT * PRESS);
    (vec![(along - friction) / SPRING * length, 0.0, 0.0], vec![PRESS * force, friction * force, 0.0])
}

fn finite(c: &Certificate) -> bool {
    c.measures().iter().all(|(_, value)| value.is_finite() && *value >= 0.0) && c.worst.is_finite()
}

#[track_caller]
fn assert_passed(problem: &ContactProblem, u: &[f64], lambda: &[f64]) {
    let c = certify(problem, u, lambda, TOLERANCE);
    assert!(c.passed && finite(&c), "{:?} of {u:?} {lambda:?}", c.measures());
}

/// Each number of the answer in turn, off by a millionth of `length` or `force`, either way, is refused.
fn assert_each_number_counts(problem: &ContactProblem, u: &[f64], lambda: &[f64], [length, force]: [f64; 2]) {
    assert_passed(problem, u, lambda);
    for part in [1e-6, -1e-6] {
        for i in 0..u.len() {
            let mut wrong = u.to_vec();
            wrong[i] += part * length;
            let c = certify(problem, &wrong, lambda, TOLERANCE);
            assert!(!c.passed && finite(&c), "u[{i}] by {part:e}: {:?}", c.measures());
        }
        for i in 0..lambda.len() {
            let mut wrong = lambda.to_vec();
            wrong[i] += part * force;
            let c = certify(problem, u, &wrong, TOLERANCE);
            assert!(!c.passed && finite(&c), "lambda[{i}] by {part:e}: {:?}", c.measures());
        }
    }
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |a: f64, v| a.max(v.abs()))
}

fn by_multigrid(problem: &ContactProblem, tolerance: f64) -> Solution {
    let mut multigrid = Multigrid::new(problem).unwrap();
    solve_multigrid(problem, &mut multigrid, &settings(tolerance), &mut |_| ControlFlow::Continue(()))
}

/// The node of which an exact answer was once refused: lengths were divided by its displacement, which is rounding.
#[test]
fn a_node_below_at_and_above_the_limit_of_friction_is_judged_right() {
    let law = Friction::Coulomb { coefficient: COEFFICIENT };
    let limit = COEFFICIENT * PRESS;
    for units in UNITS {
        let scale = [units[0] * PRESS / SPRING, units[1] * PRESS];
        for along in [2.9, limit * (1.0 - 1e-12), limit, limit * (1.0 + 1e-12), 3.1] {
            let problem = node([along, 0.0, -PRESS], law, units);
            let (u, lambda) = exact(along, units);
            assert_each_number_counts(&problem, &u, &lambda, scale);
            // What rounding leaves of a displacement that vanishes.
            let moved: Vec<f64> = u.iter().zip([3e-16, -2e-16, 1e-16]).map(|(u, r)| u + r * scale[0]).collect();
            assert_each_number_counts(&problem, &moved, &lambda, scale);
        }
    }
}

#[test]
fn both_paths_solve_the_node_below_at_and_above_the_limit() {
    let law = Friction::Coulomb { coefficient: COEFFICIENT };
    let limit = COEFFICIENT * PRESS;
    for units in UNITS {
        let scale = [units[0] * PRESS / SPRING, units[1] * PRESS];
        for along in [0.0, 2.9, limit * (1.0 - 1e-12), limit, limit * (1.0 + 1e-12), 3.1] {
            let problem = node([along, 0.0, -PRESS], law, units);
            let (u, lambda) = exact(along, units);
            for s in [attempt(&problem, &settings(TOLERANCE)), by_multigrid(&problem, TOLERANCE)] {
                assert_eq!(s.status, Status::Solved, "{along} {units:?} {:?}", s.certificate.measures());
                let off = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0, |w: f64, (a, b)| w.max((a - b).abs()));
                assert!(off(&s.u, &u) <= 1e-7 * scale[0], "{:?} {u:?}", s.u);
                assert!(off(&s.lambda, &lambda) <= 1e-7 * scale[1], "{:?} {lambda:?}", s.lambda);
                assert_each_number_counts(&problem, &s.u, &s.lambda, scale);
            }
        }
    }
}

#[test]
fn a_node_that_is_only_pressed_does_not_move_under_any_law() {
    let laws = [
        Friction::None,
        Friction::Coulomb { coefficient: 0.0 },
        Friction::Coulomb { coefficient: 1e-12 },
        Friction::Coulomb { coefficient: 3.0 },
        Friction::Given { slip_bound: 0.0 },
        Friction::Given { slip_bound: 1.0 },
        Friction::Limited { coefficient: 0.3, limit: 0.0 },
        Friction::Bonded,
    ];
    for units in UNITS {
        let scale = [units[0] * PRESS / SPRING, units[1] * PRESS];
        for law in laws {
            let problem = node([0.0, 0.0, -PRESS], law, units);
            assert_each_number_counts(&problem, &[0.0; 3], &[scale[1], 0.0, 0.0], scale);
            // Without friction the tangents of another frame leave rounding, which is no error.
            assert_passed(&problem, &[0.0; 3], &[scale[1], 1e-16 * scale[1], -1e-16 * scale[1]]);
            for s in [attempt(&problem, &settings(TOLERANCE)), by_multigrid(&problem, TOLERANCE)] {
                assert_eq!(s.status, Status::Solved, "{law:?} {units:?} {:?}", s.certificate.measures());
            }
        }
    }
}

#[test]
fn friction_that_differs_by_direction_may_vanish_across() {
    let law = Friction::Coulomb { coefficient: COEFFICIENT };
    for units in UNITS {
        let scale = [units[0] * PRESS / SPRING, units[1] * PRESS];
        for across in [0.0, 1e-12, 0.5] {
            let mut problem = node([2.9, 1.0, -PRESS], law, units);
            problem.contact.orthotropy = Some(vec![across]);
            if across == 0.5 {
                // Both forces together are within the ellipse: it sticks.
                problem.elastic.f[1] = 0.3 * units[1];
                let lambda = [PRESS, 2.9, 0.3].map(|l| l * units[1]);
                assert_each_number_counts(&problem, &[0.0; 3], &lambda, scale);
            }
            if across == 0.0 {
                // Across nothing holds it.
                let lambda = [PRESS, 2.9, 0.0].map(|l| l * units[1]);
                assert_each_number_counts(&problem, &[0.0, 1.0 / SPRING * units[0], 0.0], &lambda, scale);
            }
            let s = attempt(&problem, &settings(TOLERANCE));
            assert_eq!(s.status, Status::Solved, "{across} {:?}", s.certificate.measures());
        }
    }
}

#[test]
fn a_node_that_is_lifted_has_no_force() {
    for units in UNITS {
        for law in
            [Friction::None, Friction::Coulomb { coefficient: COEFFICIENT }, Friction::Coulomb { coefficient: 0.0 }]
        {
            let problem = node([1.0, -2.0, PRESS], law, units);
            let u = [1.0, -2.0, PRESS].map(|f| f / SPRING * units[0]);
            assert_each_number_counts(&problem, &u, &[0.0; 3], [units[0] * PRESS / SPRING, units[1] * PRESS]);
            // No contact force is larger than what rounding has left of it, and it is no tension.
            assert_passed(&problem, &u, &[-1e-17 * PRESS * units[1], 0.0, 0.0]);
            for s in [attempt(&problem, &settings(TOLERANCE)), by_multigrid(&problem, TOLERANCE)] {
                assert_eq!(s.status, Status::Solved, "{law:?} {units:?} {:?}", s.certificate.measures());
                assert_eq!(s.lambda, [0.0; 3]);
            }
        }
    }
}

/// Zero load is an equilibrium, and what is wrong where nothing has a scale has a measure that is a number.
#[test]
fn a_problem_without_load_has_the_answer_zero() {
    let press = || brick(2, BlockElement::Hex8, BrickLoad::Press, SurfaceFriction::Coulomb(0.35));
    let mut unloaded = press();
    unloaded.loads.clear();
    let law = Friction::Coulomb { coefficient: COEFFICIENT };
    for problem in [node([0.0; 3], law, [1.0, 1.0]), unloaded.pose().problem] {
        let (u, lambda) = (vec![0.0; problem.unknowns()], vec![0.0; 3 * problem.points()]);
        let c = certify(&problem, &u, &lambda, TOLERANCE);
        assert!(c.passed && c.measures().iter().all(|(_, value)| *value == 0.0), "{:?}", c.measures());
        for s in [attempt(&problem, &settings(TOLERANCE)), by_multigrid(&problem, TOLERANCE)] {
            assert_eq!(s.status, Status::Solved, "{:?}", s.certificate.measures());
            assert!(s.u.iter().chain(&s.lambda).all(|x| *x == 0.0));
        }
        assert_each_number_counts(&problem, &u, &lambda, [1.0, 1.0]);
    }
    // The answer to a load is none to no load, and no displacement is none to an overlap.
    let (loaded, none) = (press().pose().problem, unloaded.pose().problem);
    let s = solved(&loaded, TOLERANCE);
    let c = certify(&none, &s.u, &s.lambda, TOLERANCE);
    assert!(!c.passed && finite(&c), "{:?}", c.measures());
    let mut overlapping = none;
    overlapping.contact.gap.fill(-1e-3);
    let (u, lambda) = (vec![0.0; overlapping.unknowns()], vec![0.0; 3 * overlapping.points()]);
    let c = certify(&overlapping, &u, &lambda, TOLERANCE);
    assert!(c.penetration == 1.0 && finite(&c), "{:?}", c.measures());
}

/// A body that nothing holds or loads may be anywhere above the plane, at rest or travelled.
#[test]
fn a_loose_body_without_load_rests_wherever_it_is() {
    let case = block_of([2.0, 1.0, 1.0], [4, 2, 2], BlockElement::Hex8, 2.1e11, 0.3);
    let p = case.contact("z-min", FLOOR, SurfaceFriction::Coulomb(0.3)).pose().problem;
    let motions = p.elastic.near_kernel.as_ref().unwrap();
    // Each of them keeps the body on or above the plane.
    for travel in [[0.1, -0.2, 0.0], [0.0, 0.0, 1e-9], [3.0, -7.0, 2.0]] {
        let u: Vec<f64> = motions.iter().map(|row| (0..3).map(|c| row[c] * travel[c]).sum()).collect();
        assert_passed(&p, &u, &vec![0.0; 3 * p.points()]);
        // A millionth of the travel is a strain that needs forces.
        let mut bent = u.clone();
        bent[7] += 1e-6 * largest(&u);
        assert!(!certify(&p, &bent, &vec![0.0; 3 * p.points()], TOLERANCE).passed);
    }
}

/// The bricks whose normals are not along their planes of symmetry.
const SLANTED: [&str; 2] = ["quarter", "quarter, 0"];

/// Bricks under several laws, and a quarter of one with empty rows of `B`.
fn bricks() -> Vec<(&'static str, ContactProblem)> {
    let of = |element, load, law| brick(2, element, load, law).pose().problem;
    let quarter = block_of([1.0, 1.0, 0.5], [3, 3, 2], BlockElement::Hex8, 2.1e11, 0.3)
        .fix("x-min", [Some(0.0), None, None])
        .fix("y-min", [None, Some(0.0), None])
        .fix("z-max", [None, None, Some(-1e-4)]);
    let slanted = Obstacle::Plane { point: [1.0, 1.0, 0.0], normal: [-1e-4, -1e-4, 1.0] };
    let mut orthotropic = of(BlockElement::Hex8, BrickLoad::Press, SurfaceFriction::Coulomb(0.35));
    orthotropic.contact.orthotropy = Some(vec![0.4; orthotropic.points()]);
    vec![
        ("lift", of(BlockElement::Tet4Six, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35))),
        ("press", of(BlockElement::Hex8, BrickLoad::Press, SurfaceFriction::Coulomb(0.35))),
        ("much friction", of(BlockElement::Hex8, BrickLoad::Press, SurfaceFriction::Coulomb(2.0))),
        ("no friction", of(BlockElement::Tet4Six, BrickLoad::Press, SurfaceFriction::None)),
        ("coefficient 0", of(BlockElement::Tet4Six, BrickLoad::Lift, SurfaceFriction::Coulomb(0.0))),
        ("given", of(BlockElement::Hex8, BrickLoad::Lift, SurfaceFriction::GivenForce(1.3e4))),
        ("bonded", of(BlockElement::Hex8, BrickLoad::Lift, SurfaceFriction::Bonded)),
        ("orthotropic", orthotropic),
        ("quarter, sticks", quarter.clone().contact("z-min", FLOOR, SurfaceFriction::Coulomb(2.0)).pose().problem),
        ("quarter", quarter.clone().contact("z-min", slanted.clone(), SurfaceFriction::Coulomb(0.2)).pose().problem),
        ("quarter, 0", quarter.contact("z-min", slanted, SurfaceFriction::Coulomb(0.0)).pose().problem),
    ]
}

#[test]
fn one_number_off_by_a_millionth_is_refused_on_both_paths() {
    for (name, problem) in bricks() {
        let mut answers = vec![("direct", attempt(&problem, &settings(1e-10)))];
        // Multigrid is for normals along the planes of symmetry.
        if !SLANTED.contains(&name) {
            answers.push(("multigrid", by_multigrid(&problem, 1e-10)));
        }
        for (path, s) in answers {
            assert_eq!(s.status, Status::Solved, "{name} {path} {:?}", s.certificate.measures());
            println!("{name} {path}: {} unknowns, {} points", problem.unknowns(), problem.points());
            assert_each_number_counts(&problem, &s.u, &s.lambda, [largest(&s.u), largest(&s.lambda)]);
        }
    }
}

/// One cell that sticks under a prescribed displacement: no free node moves and no force works.
const ONE_CELL: &str = r#"
[mesh]
block = { size = [10, 10, 10], cells = [1, 1, 1], element = "hex8" }
[materials.s]
young = 210e3
poisson = 0.3
[[fix]]
on = "z-max"
value = [0, 0, -1e-3]
[[contact]]
on = "z-min"
against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = { coulomb = 1 }
"#;

/// A quarter model whose corner, on both planes of symmetry, stays open: a point without tangents.
const OPEN_CORNER: &str = r#"
[mesh]
block = { size = [20, 20, 10], cells = [3, 3, 2], element = "hex8" }
[materials.s]
young = 210e3
poisson = 0.3
[[fix]]
on = "x-min"
condition = "symmetry"
[[fix]]
on = "y-min"
condition = "symmetry"
[[fix]]
on = "z-max"
components = "z"
value = -1e-3
[[contact]]
on = "z-min"
against = { plane = { point = [20, 20, 0], normal = [-1e-4, -1e-4, 1] } }
friction = LAW
"#;

/// A loose block between two others: it lies on one and the other does not reach it, so that its forces are rounding.
const LOOSE: &str = r#"
[mesh.parts.a]
block = { size = [10, 10, 5], cells = [2, 2, 1], element = "hex8" }
[mesh.parts.b]
block = { size = [10, 10, 5], cells = [3, 3, 1], element = "hex8", origin = [0, 0, 5] }
[mesh.parts.c]
block = { size = [10, 10, 5], cells = [2, 2, 1], element = "hex8", origin = [0, 0, 10.001] }
[materials.s]
young = 210e3
poisson = 0.3
[[fix]]
on = "a.z-min"
[[fix]]
on = "c.z-max"
value = [1e-4, 2e-4, -0.0005]
[[contact]]
on = "b.z-min"
against = "a.z-max"
friction = { coulomb = 0.3 }
[[contact]]
on = "c.z-min"
against = "b.z-max"
friction = { coulomb = 0.3 }
"#;

#[test]
fn cases_whose_answers_vanish_are_certified() {
    case_run::solved(ONE_CELL);
    case_run::solved(LOOSE);
    let without = case_run::solved(&OPEN_CORNER.replace("LAW", "\"none\"")).0.solution;
    for law in ["{ coulomb = 0 }", "{ coulomb = 1e-12 }"] {
        let with = case_run::solved(&OPEN_CORNER.replace("LAW", law)).0.solution;
        assert!(distance(&with.lambda, &without.lambda) < 1e-7, "{law}");
    }
    case_run::solved(&OPEN_CORNER.replace("LAW", "{ coulomb = [0.3, 0.1], direction = [1, 0, 0] }"));
}

/// The same refusals from the files of a result folder.
#[test]
fn the_check_of_a_folder_refuses_one_number_off_by_a_millionth() {
    for (name, text) in
        [("one-cell", ONE_CELL.into()), ("open-corner", OPEN_CORNER.replace("LAW", "{ coulomb = 0.2 }"))]
    {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("exact-answers-{name}"));
        let _ = std::fs::remove_dir_all(&folder);
        let case = stiction::io::case::parse(&text, "case.toml", &[]).unwrap();
        let prepared = prepare(&case).unwrap();
        let settings = Settings::of(&case.solver);
        let mut outcome = stiction::run::solve(&prepared, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
        stiction::run::write(&prepared, &mut outcome, &Origin::default(), &folder).unwrap();
        assert!(check(&folder).unwrap().passed());
        let (u, lambda) = (&outcome.solution.u, &outcome.solution.lambda);
        // The displacements of the points that stick vanish: what is prescribed and the forces say how far is far.
        let (length, force) = (1e-3, largest(lambda));
        let file = folder.join("solution.npz");
        for i in 0..u.len() + lambda.len() {
            let (mut wrong_u, mut wrong_lambda) = (u.clone(), lambda.clone());
            match i.checked_sub(u.len()) {
                None => wrong_u[i] += 1e-6 * length,
                Some(j) => wrong_lambda[j] += 1e-6 * force,
            }
            write_solution(&file, &wrong_u, &wrong_lambda).unwrap();
            let checked = check(&folder).unwrap();
            assert!(!checked.certificate.passed && !checked.passed(), "{name} {i}: {:?}", checked.certificate);
        }
        write_solution(&file, u, lambda).unwrap();
        assert!(check(&folder).unwrap().passed());
    }
}

/// Nothing is loaded and nothing touches but by rounding: block c moves as a whole, a and b rest. Reactions on c are rounding
/// of its stiffness, far larger than the rounding of the heights at which a and b meet, and a holds that force with no
/// stiffness in motion of its own.
#[test]
fn bodies_that_nothing_loads_are_in_balance() {
    let text = r#"
        mesh.parts.a.block = { size = [8, 50, 20], cells = [2, 2, 3], element = "tet10" }
        mesh.parts.b.block = { size = [5.781454949080084, 46.684325750289034, 2.3999999999999986], cells = [4, 4, 4], element = "hex8", origin = [1.5256458968490627, 1.7053946118295693, 20], grading = [0.5, 1, 3] }
        mesh.parts.c.block = { size = [3.6692994351712556, 44.33690816435416, 12], cells = [3, 3, 4], element = "hex8", origin = [2.536817337377045, 1.9751315207195523, 22.40009710551972], grading = [3, 1, 3] }
        materials.a = { on = "a", young = 5252.896313242924, poisson = 0 }
        materials.b = { on = "b", young = 46414.49353689401, poisson = 0.4 }
        materials.c = { on = "c", young = 18601.795258235095, poisson = 0 }
        fix = [{ on = "b.x-min" }, { on = "c.z-max", value = [1.6992422609111727e-4, 6.912004364443106e-5, -6.952731855069025e-5] }]
        contact = [
            { on = "a.z-min", against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }, friction = { coulomb = 1.8347134237031324 } },
            { on = "b.z-min", against = "a.z-max", friction = "none" },
            { on = "c.z-min", against = "b.z-max", friction = "none" },
        ]
    "#;
    let outcome = stiction_fixtures::random_case::outcome(text);
    assert!(outcome.is_ok(), "{outcome:?}");
}
