//! Strength of interfaces beside friction: cohesion and tension cut-off, kept or lost, on both paths.

use std::ops::ControlFlow;

use stiction::certificate::certify;
use stiction::contact::Friction;
use stiction::friction::{PointState, Status};
use stiction::io::case;
use stiction::run::{Outcome, Prepared, Settings, prepare, solve, totals};
use stiction_fixtures::case_run::{block, is, solved};

const YOUNG: f64 = 2000.0;
const SHEAR: f64 = YOUNG / 2.0;
const PATHS: [&str; 3] = ["dense", "solves", "multigrid"];

/// The floor under a block, with the law of friction.
fn floor(friction: &str) -> String {
    format!(
        "[[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {friction}\n"
    )
}

/// A unit cube without lateral contraction whose top moves by `top` along x and z, with the shear tractions `tau` on its
/// sides that keep uniform shear in balance.
fn cube(top: [f64; 2], tau: f64, friction: &str, path: &str) -> String {
    let [x, z] = top;
    block([1.0; 3], [2, 2, 3], "element = \"hex8\"")
        + &format!(
            "[materials.soft]\nyoung = {YOUNG}\npoisson = 0\n[[fix]]\non = \"z-max\"\nvalue = [{x}, 0, {z}]\n\
             [[load]]\non = \"x-max\"\ntraction = [0, 0, {tau}]\n[[load]]\non = \"x-min\"\ntraction = [0, 0, {}]\n\
             [solver]\npath = \"{path}\"\ntolerance = 1e-10\n",
            -tau
        )
        + &floor(friction)
}

/// Pressure and shear at each point, and its gap and slip.
fn states((outcome, prepared): &(Outcome, Prepared)) -> Vec<[f64; 4]> {
    let (problem, s) = (&prepared.problem, &outcome.solution);
    let (m, v) = (problem.points(), problem.gap_and_slip(&s.u));
    let area = &problem.labels.area;
    let shear = |x: &[f64], j: usize| x[m + j].hypot(x[2 * m + j]);
    (0..m).map(|j| [s.lambda[j] / area[j], shear(&s.lambda, j) / area[j], v[j], shear(&v, j)]).collect()
}

#[test]
fn with_cohesion_nothing_is_said_to_be_known_of_other_solutions() {
    for path in PATHS {
        let (outcome, prepared) = solved(&cube([0.0, -1.0 / YOUNG], 0.0, "{ coulomb = 0.5, cohesion = 0.3 }", path));
        let report = stiction::run::report(&prepared, &outcome).to_string();
        assert!(report.contains("a solution; nothing is known of others with cohesion"), "{path}: {report}");
        let (outcome, prepared) = solved(&cube([0.0, -1.0 / YOUNG], 0.0, "{ coulomb = 0.5 }", path));
        assert!(!stiction::run::report(&prepared, &outcome).to_string().contains("cohesion"), "{path}");
    }
}

/// What is not solved is no solution, and nothing is said of others.
#[test]
fn nothing_is_said_of_other_solutions_where_none_is_found() {
    for path in PATHS {
        let text = cube([0.01, -1.0 / YOUNG], 0.0, "{ coulomb = 0.5, cohesion = 0.3 }", path);
        let case = case::parse(&text, "case.toml", &[]).unwrap();
        let prepared = prepare(&case).unwrap();
        let mut settings = Settings::of(&case.solver);
        settings.solver.max_iterations = 1;
        let outcome = solve(&prepared, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(outcome.solution.status, Status::MaxIterations, "{path}");
        let report = stiction::run::report(&prepared, &outcome).to_string();
        assert!(report.contains("NOT SOLVED") && !report.contains("a solution"), "{path}: {report}");
    }
}

/// Slides under `c + F p` at any pressure, pulls up to the cut-off included, and sticks just below.
#[test]
fn a_block_slides_at_cohesion_and_friction_and_sticks_just_below() {
    let law = "{ coulomb = 0.5, cohesion = 0.3, tension = 0.4 }";
    for pressure in [1.0, 0.01, -0.1, -0.25] {
        let strength = 0.3 + 0.5 * pressure;
        for path in PATHS {
            let slip = 1e-4;
            let top = [slip + strength / SHEAR, -pressure / YOUNG];
            let run = solved(&cube(top, strength, law, path));
            for [normal, shear, gap, slid] in states(&run) {
                is(normal, pressure, 1.0);
                is(shear, strength, 1.0);
                is(gap, 0.0, slip);
                is(slid, slip, slip);
            }
            assert!(run.0.solution.states.iter().all(|&state| state == PointState::Slip), "{path}");
            let below = 0.9999 * strength;
            let run = solved(&cube([below / SHEAR, top[1]], below, law, path));
            assert!(run.0.solution.states.iter().all(|&state| state == PointState::Stick), "{path}");
            states(&run).iter().for_each(|state| is(state[1], below, 1.0));
        }
    }
}

/// A block pulled up holds to the cut-off, or to the apex of the cone where that is nearer; beyond it opens under that pull,
/// and carries no shear.
#[test]
fn a_block_pulled_up_holds_to_its_tensile_strength() {
    for (law, strength) in [
        ("{ coulomb = 0.5, cohesion = 0.3, tension = 0.4 }", 0.4),
        ("{ coulomb = 0.5, cohesion = 0.15, tension = 0.4 }", 0.3),
        ("{ coulomb = 0, cohesion = 0.3, tension = 7 }", 7.0),
        ("{ coulomb = 0.5, cohesion = 0.3 }", 0.0),
    ] {
        for path in PATHS {
            let pull = 0.999 * strength;
            if pull > 0.0 {
                let run = solved(&cube([0.0, pull / YOUNG], 0.0, law, path));
                states(&run).iter().for_each(|state| is(state[0], -pull, 1.0));
                states(&run).iter().for_each(|state| is(state[2], 0.0, 1e-3));
            }
            let beyond = strength / YOUNG + 1e-3;
            let run = solved(&cube([1e-3, beyond], 0.0, law, path));
            for [normal, shear, gap, _] in states(&run) {
                is(normal, -strength, 1.0);
                is(shear, 0.0, 1.0);
                is(gap, 1e-3, 1e-3);
            }
        }
    }
}

/// Cohesion by an expression is that at each point.
#[test]
fn cohesion_depends_on_the_place_as_told() {
    let straight = "[[fix]]\non = { box = [[-1, -1, -1], [2, 2, 2]] }\ncomponents = \"y\"\n";
    let law = |law: &str| cube([1e-2, -1.0 / YOUNG], 0.8, law, "dense") + straight;
    let run = solved(&law("{ coulomb = 0.5, cohesion = \"0.3 + 0.1*x\" }"));
    let problem = &run.1.problem;
    for (j, &node) in run.1.facts.contacts[0].surface.nodes.iter().enumerate() {
        let cohesion = 0.3 + 0.1 * run.1.mesh.nodes[node as usize][0];
        is(problem.contact.friction[j].strength()[0], cohesion * problem.labels.area[j], 1.0);
    }
    // All points slide along x: the sum of shears is that of the strengths.
    let all = totals(&run.1, &run.0);
    let strengths: f64 = run.1.problem.contact.friction.iter().map(|law| law.strength()[0]).sum();
    is(-all.tangential_force[0], strengths + 0.5 * all.normal_force, 1.0);
}

/// A flat block under its weight `W`, pushed by a body force: rests just below `F W + c A`, and slides away just above.
#[test]
fn a_block_under_its_weight_slides_away_at_friction_and_cohesion_together() {
    let (weight, cohesion, friction, area) = (3.0, 0.2, 0.4, 8.0);
    let limit = friction * weight + cohesion * area;
    for path in ["dense", "multigrid"] {
        for (factor, rests) in [(0.998, true), (1.001, false)] {
            let gravity = [factor * limit, 0.0, -weight].map(|force| force / (area * 0.25));
            let text = block([4.0, 2.0, 0.25], [8, 4, 1], "element = \"hex8\"")
                + "[materials.soft]\nyoung = 1e5\npoisson = 0.3\ndensity = 1\n"
                + &format!("[[load]]\ngravity = {gravity:?}\n[solver]\npath = \"{path}\"\n")
                + &floor(&format!("{{ coulomb = {friction}, cohesion = {cohesion} }}"));
            if rests {
                let run = solved(&text);
                let all = totals(&run.1, &run.0);
                assert!((all.normal_force - weight).abs() < 1e-7 * weight);
                assert!((all.tangential_force[0] + factor * limit).abs() < 1e-7 * limit);
                continue;
            }
            let case = case::parse(&text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
            let prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
            let found = solve(&prepared, &Settings::of(&case.solver), &mut |_| ControlFlow::Continue(())).unwrap();
            assert_eq!(found.solution.status, Status::NoEquilibrium, "{path}");
        }
    }
}

/// Every number of an answer, and every number of the law, matters by a millionth.
#[test]
fn answers_wrong_by_a_millionth_are_refused() {
    let strength = 0.3 + 0.5 * -0.1;
    let law = "{ coulomb = 0.5, cohesion = 0.3, tension = 0.4 }";
    let slides = solved(&cube([1e-4 + strength / SHEAR, 0.1 / YOUNG], strength, law, "dense"));
    let opens = solved(&cube([0.0, 0.4 / YOUNG + 1e-4], 0.0, law, "dense"));
    for (outcome, prepared) in [&slides, &opens] {
        let (problem, s) = (&prepared.problem, &outcome.solution);
        let passes = |u: &[f64], lambda: &[f64]| certify(problem, u, lambda, 1e-8).passed;
        assert!(passes(&s.u, &s.lambda));
        let most = |x: &[f64]| x.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        for sign in [1e-6, -1e-6] {
            for i in 0..s.lambda.len() {
                let mut lambda = s.lambda.clone();
                lambda[i] += sign * most(&s.lambda);
                assert!(!passes(&s.u, &lambda), "multiplier {i} {sign}");
            }
            for i in 0..s.u.len() {
                let mut u = s.u.clone();
                u[i] += sign * most(&s.u);
                assert!(!passes(&u, &s.lambda), "displacement {i} {sign}");
            }
        }
    }
    // The answers are those of their strengths and of no others.
    let other = |(outcome, prepared): &(Outcome, Prepared), change: &dyn Fn(&mut [f64; 3])| {
        let mut problem = prepared.problem.clone();
        for law in &mut problem.contact.friction {
            let Friction::Cohesive { coefficient, cohesion, tension } = *law else { panic!("{law:?}") };
            let mut numbers = [coefficient, cohesion, tension];
            change(&mut numbers);
            let [coefficient, cohesion, tension] = numbers;
            *law = Friction::Cohesive { coefficient, cohesion, tension };
        }
        certify(&problem, &outcome.solution.u, &outcome.solution.lambda, 1e-8).passed
    };
    assert!(other(&slides, &|_| {}) && other(&opens, &|_| {}));
    for factor in [1.0 + 1e-6, 1.0 - 1e-6] {
        assert!(!other(&slides, &|law| law[0] *= factor), "coefficient");
        assert!(!other(&slides, &|law| law[1] *= factor), "cohesion");
        assert!(!other(&opens, &|law| law[2] *= factor), "tension");
    }
}

/// The strength presses what solvers see together; the answer is still held against the loads.
#[test]
fn a_strength_far_above_the_loads_costs_no_digits() {
    for path in PATHS {
        let law = "{ coulomb = 0, cohesion = 1e5, tension = 1e5 }";
        let text = cube([0.0, 1e-3], 0.0, law, path).replacen("tolerance = 1e-10", "tolerance = 1e-8", 1);
        states(&solved(&text)).iter().for_each(|state| is(state[0], -1e-3 * YOUNG, 20.0));
    }
}
