//! Interfaces that yield, and interfaces that carry a stress before anything is loaded: closed forms on both paths.

use std::ops::ControlFlow;

use stiction::certificate::certify;
use stiction::friction::{PointState, Status};
use stiction::io::case;
use stiction::linalg::Stop;
use stiction::run::{Plan, Settings, Stage, prepare, solve, solve_case, totals};
use stiction_fixtures::case_run::{at, block, is, solved};

const YOUNG: f64 = 2000.0;
const SHEAR: f64 = YOUNG / 2.0;
const PATHS: [&str; 3] = ["dense", "solves", "multigrid"];
const FLOOR: &str = "against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n";

/// A column of unit area under uniform pressure and shear.
fn loads(top: &str, sides: &[&str], [sigma, tau]: [f64; 2]) -> String {
    let on = |side: &str| sides.iter().map(|part| format!("\"{part}{side}\"")).collect::<Vec<_>>().join(", ");
    format!(
        "[materials.soft]\nyoung = {YOUNG}\npoisson = 0\n[[load]]\non = \"{top}\"\ntraction = [{tau}, 0, {}]\n\
         [[load]]\non = [{}]\ntraction = [0, 0, {tau}]\n[[load]]\non = [{}]\ntraction = [0, 0, {}]\n",
        -sigma,
        on("x-max"),
        on("x-min"),
        -tau
    )
}

fn solver(path: &str) -> String {
    format!("[solver]\npath = \"{path}\"\ntolerance = 1e-10\n")
}

/// Column and layer in series: `u = sigma (H/E + 1/k_n)` and `tau (H/G + 1/k_t)`, on an obstacle; contact alone holds the
/// column. From a gasket far softer than the column to one far stiffer.
#[test]
fn a_column_on_a_layer_moves_as_both_in_series() {
    let (sigma, tau) = (2.0, 0.7);
    for element in ["element = \"hex8\"", "element = \"tet4\"", "element = \"hex20\"", "element = \"tet10\""] {
        for (normal, tangential) in [(30.0, 11.0), (4e4, 1e3), (1e8, 3e7)] {
            for path in PATHS {
                let text = block([1.0; 3], [2, 2, 2], element)
                    + &loads("z-max", &[""], [sigma, tau])
                    + "[[contact]]\non = \"z-min\"\nfriction = { coulomb = 0.5 }\n"
                    + FLOOR
                    + &format!("stiffness = {{ normal = {normal}, tangential = {tangential} }}\n")
                    + &solver(path);
                let run = solved(&text);
                for x in [[0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.5, 0.5, 1.0]] {
                    let [ux, uy, uz] = at(&run, x);
                    is(uz, -sigma * (1.0 / YOUNG + 1.0 / normal), uz);
                    is(ux, tau * (1.0 / SHEAR + 1.0 / tangential), ux);
                    is(uy, 0.0, uz);
                }
                let problem = &run.1.problem;
                for (force, area) in run.0.solution.lambda.iter().zip(&problem.labels.area) {
                    is(*force, sigma * area, sigma);
                }
                assert!(run.0.solution.states.iter().all(|&state| state == PointState::Stick));
            }
        }
    }
}

/// The same between two bodies whose meshes do not match, and bonded by a soft glue in tension.
#[test]
fn two_columns_with_a_layer_between_them_move_as_all_three_in_series() {
    let part = |name: &str, cells: [usize; 3], z: f64| {
        let mesh = block([1.0; 3], cells, "element = \"hex8\"");
        mesh.replacen("[mesh]", &format!("[mesh.parts.{name}]"), 1) + &format!("move = [0, 0, {z}]\n")
    };
    let (normal, tangential) = (500.0, 200.0);
    for (friction, sigma) in
        [("{ coulomb = 0.5 }", 2.0), ("\"bonded\"", -2.0), ("{ coulomb = 0.1, cohesion = 1.5, tension = 3 }", -2.0)]
    {
        let tau = 0.7;
        for path in PATHS {
            let text = part("low", [2, 2, 2], 0.0)
                + &part("high", [3, 3, 2], 1.0)
                + &loads("high.z-max", &["low.", "high."], [sigma, tau])
                + "[[fix]]\non = \"low.z-min\"\n[[contact]]\non = \"high.z-min\"\nagainst = \"low.z-max\"\n"
                + &format!("friction = {friction}\nstiffness = {{ normal = {normal}, tangential = {tangential} }}\n")
                + &solver(path);
            let run = solved(&text);
            let [ux, _, uz] = at(&run, [1.0, 0.0, 2.0]);
            is(uz, -sigma * (2.0 / YOUNG + 1.0 / normal), 10.0 * uz);
            is(ux, tau * (2.0 / SHEAR + 1.0 / tangential), 10.0 * ux);
        }
    }
}

/// Beyond the bound of friction the layer keeps its elastic shear and the rest is slip.
#[test]
fn slip_is_what_the_layer_does_beyond_its_elastic_shear() {
    let (sigma, friction, tangential, slip) = (2.0, 0.25, 50.0, 0.01);
    let tau = friction * sigma;
    for path in PATHS {
        let moved = [slip + tau * (1.0 / SHEAR + 1.0 / tangential), -sigma * (1.0 / YOUNG + 1.0 / 100.0)];
        let sides = loads("z-max", &[""], [sigma, tau]).replacen("[[load]]", "[[fix]]", 1);
        let traction = format!("traction = [{tau}, 0, {}]", -sigma);
        let sides = sides.replacen(&traction, &format!("value = [{}, 0, {}]", moved[0], moved[1]), 1);
        let text = block([1.0; 3], [2, 2, 2], "element = \"hex8\"")
            + &sides
            + &format!("[[contact]]\non = \"z-min\"\nfriction = {{ coulomb = {friction} }}\n")
            + FLOOR
            + &format!("stiffness = {{ normal = 100, tangential = {tangential} }}\n")
            + &solver(path);
        let run = solved(&text);
        let (problem, s) = (&run.1.problem, &run.0.solution);
        let (m, v) = (problem.points(), problem.gap_and_slip(&s.u));
        for j in 0..m {
            is(v[m + j].hypot(v[2 * m + j]), slip, slip);
            is(s.lambda[j], sigma * problem.labels.area[j], sigma);
        }
        assert!(s.states.iter().all(|&state| state == PointState::Slip));
    }
}

/// A layer that is not loaded leaves no trace: an open point is where its node is.
#[test]
fn an_open_point_of_a_layer_is_where_its_node_is() {
    for path in PATHS {
        let text = block([1.0; 3], [2, 2, 2], "element = \"hex8\"")
            + "[materials.soft]\nyoung = 2000\npoisson = 0\n[[fix]]\non = \"z-max\"\nvalue = [0, 0, 1e-3]\n\
               [[contact]]\non = \"z-min\"\nfriction = { coulomb = 0.5 }\nstiffness = { normal = 100 }\n"
            + FLOOR
            + &solver(path);
        let run = solved(&text);
        let v = run.1.problem.gap_and_slip(&run.0.solution.u);
        v[..run.1.problem.points()].iter().for_each(|&gap| is(gap, 1e-3, 1e-3));
        assert!(run.0.solution.lambda.iter().all(|&force| force == 0.0));
    }
}

#[test]
fn an_answer_of_a_layer_stiffer_by_a_millionth_is_refused() {
    let text = |normal: f64, tangential: f64| {
        block([1.0; 3], [2, 2, 2], "element = \"hex8\"")
            + &loads("z-max", &[""], [2.0, 0.7])
            + "[[contact]]\non = \"z-min\"\nfriction = { coulomb = 0.5 }\n"
            + FLOOR
            + &format!("stiffness = {{ normal = {normal}, tangential = {tangential} }}\n")
            + &solver("dense")
    };
    let run = solved(&text(500.0, 200.0));
    let problem = &run.1.problem;
    let passes = |u: &[f64], lambda: &[f64]| certify(problem, u, lambda, 1e-8).passed;
    assert!(passes(&run.0.solution.u, &run.0.solution.lambda));
    for (normal, tangential) in [(500.0 * (1.0 + 1e-6), 200.0), (500.0, 200.0 * (1.0 + 1e-6))] {
        let other = solved(&text(normal, tangential)).0.solution;
        assert!(!passes(&other.u, &other.lambda), "{normal} {tangential}");
    }
    let most = run.0.solution.u.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    for i in 0..run.0.solution.u.len() {
        let mut u = run.0.solution.u.clone();
        u[i] += 1e-6 * most;
        assert!(!passes(&u, &run.0.solution.lambda), "displacement {i}");
    }
}

/// A joint that carries `sigma_0` and `tau_0` beforehand holds nothing new without a load. Unloaded by `d`, it slips exactly
/// where `tau_0 > c + F (sigma_0 - d)`.
#[test]
fn a_stressed_joint_slips_when_its_pressure_is_relieved_enough() {
    let (sigma, tau, cohesion, friction) = (3.0, 0.9, 0.1, 0.4);
    let text = |relieved: f64, path: &str| {
        block([1.0; 3], [2, 2, 2], "element = \"hex8\"")
            + "[materials.soft]\nyoung = 2000\npoisson = 0\n"
            + &format!("[[load]]\non = \"z-max\"\ntraction = [0, 0, {relieved}]\n")
            + &format!("[[contact]]\non = \"z-min\"\nfriction = {{ coulomb = {friction}, cohesion = {cohesion} }}\n")
            + &format!("initial_stress = [0, -7, {}, 0, {tau}, \"5*x\"]\n", -sigma)
            + FLOOR
            + &solver(path)
    };
    let most = sigma - (tau - cohesion) / friction;
    for path in PATHS {
        for relieved in [0.0, 0.5 * most, 0.9999 * most] {
            let run = solved(&text(relieved, path));
            let (problem, s) = (&run.1.problem, &run.0.solution);
            let m = problem.points();
            is(at(&run, [0.5, 0.5, 1.0])[2], relieved / YOUNG, 1e-3);
            for j in 0..m {
                let area = problem.labels.area[j];
                is(s.lambda[j], (sigma - relieved) * area, 1.0);
                is(s.lambda[m + j].hypot(s.lambda[2 * m + j]), tau * area, 1.0);
            }
            // The body pushes the floor along x, and the floor it back.
            is(stiction::run::totals(&run.1, &run.0).tangential_force[0], -tau, 1.0);
        }
        let case = case::parse(&text(1.0001 * most, path), "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
        let prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
        let found = solve(&prepared, &Settings::of(&case.solver), &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(found.solution.status, Status::NoEquilibrium, "{path}");
    }
}

/// A stamp that is moved as a whole presses its gasket by stiffness times depth: by a coupling, which the refusal of a prescribed
/// displacement names.
#[test]
fn a_rigid_stamp_presses_a_layer_by_its_depth() {
    let stamp = |held: &str, steps: &str| {
        format!(
            "{}[materials.soft]\nyoung = {YOUNG}\npoisson = 0.3\n{held}[[contact]]\non = \"z-min\"\n{FLOOR}friction = \"none\"\n\
             stiffness = {{ normal = 500 }}\n{steps}",
            block([2.0, 2.0, 1.0], [2, 2, 1], "element = \"hex8\"")
        )
    };
    let all = "on = { box = [[0, 0, 0], [2, 2, 1]] }\n";
    for steps in ["", "[[step]]\nuntil = 1\n"] {
        let held = format!(
            "[[fix]]\n{all}components = \"z\"\nvalue = [-0.01]\n[[fix]]\non = \"x-min\"\ncomponents = \"xy\"\n"
        );
        let error = refused_at(&stamp(&held, steps));
        assert!(error.contains("into the obstacle") && error.contains("[[coupling]]"), "{error}");
        let motion = "motion = { x = 0, y = 0, z = -0.01 }\nrotation = { x = 0, y = 0, z = 0 }\npoint = [1, 1, 0]\nname = \"stamp\"\n";
        let run = solved(&stamp(&format!("[[coupling]]\n{all}{motion}kind = \"rigid\"\n"), steps));
        is(totals(&run.1, &run.0).normal_force, 500.0 * 0.01 * 4.0, 20.0);
    }
}

/// What is wrong with a case, wherever it is found.
fn refused_at(text: &str) -> String {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let go_on = &mut |_: Stage| ControlFlow::Continue(());
    solve_case(&case, &Plan::default(), &Stop::never(), None, go_on).map(|_| ()).unwrap_err().to_string()
}
