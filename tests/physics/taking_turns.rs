//! Contacts of one surface that hold in other load steps: at any time a node meets what holds then. What is right is said by statics, by
//! one contact whose law changes with time, by the case with the contacts of a step alone, and by the other order of the contacts.

use std::ops::ControlFlow;

use stiction::fem::full_displacement;
use stiction::friction::SolverPath;
use stiction::io::case;
use stiction::run::{Settings, prepare, solve_steps};
use stiction_fixtures::case_run::{displacement, solved};

const STEPS: &str = "[[step]]\nname = \"one\"\nuntil = 1\n[[step]]\nname = \"two\"\nuntil = 2\n";
const STEEL: &str = "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n";

/// What a step ends with.
struct Stage {
    u: Vec<[f64; 3]>,
    /// The name and the normal force of each contact.
    forces: Vec<(String, f64)>,
    path: SolverPath,
}

/// All steps of a case, each certified.
fn stages(text: &str) -> Vec<Stage> {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let mut found = Vec::new();
    let settings = Settings::of(&case.solver);
    let outcome = solve_steps(
        &mut prepared,
        &settings,
        None,
        &mut |prepared, step| {
            let solution = &step.outcome.solution;
            assert!(step.finished && solution.certificate.passed, "{:?}", solution.status);
            let u = full_displacement(&prepared.model, &solution.u).as_chunks().0.to_vec();
            let problem = &prepared.problem;
            let force = |j: usize| problem.labels.unity_sum[j] * solution.lambda[j];
            let forces = problem.labels.pairs.iter();
            let forces = forces.map(|pair| (pair.name.clone(), pair.points.clone().map(force).sum())).collect();
            found.push(Stage { u, forces, path: solution.path });
            Ok(())
        },
        &mut |_| ControlFlow::Continue(()),
    );
    outcome.unwrap_or_else(|e| panic!("{e}"));
    found
}

#[track_caller]
fn same(a: &[[f64; 3]], b: &[[f64; 3]]) {
    let largest = a.iter().flatten().fold(0.0, |most: f64, c| c.abs().max(most));
    let apart = a.iter().flatten().zip(b.iter().flatten()).fold(0.0, |most: f64, (a, b)| (a - b).abs().max(most));
    assert!(a.len() == b.len() && apart <= 1e-7 * largest, "{apart:e} of {largest:e}");
}

#[track_caller]
fn presses(stage: &Stage, wanted: &[(&str, f64)]) {
    for (name, force) in wanted {
        let (_, found) = stage.forces.iter().find(|(pair, _)| pair == name).unwrap();
        assert!((found - force).abs() <= 1e-6 * force.abs().max(1.0), "{name}: {found} where {force} is wanted");
    }
}

fn part(name: &str, size: [f64; 3], at: [f64; 3], cells: [usize; 3], element: &str) -> String {
    format!(
        "[mesh.parts.{name}]\nblock = {{ size = {size:?}, origin = {at:?}, cells = {cells:?}, element = \"{element}\" }}\n"
    )
}

fn contact(name: &str, against: &str, friction: &str, during: &str) -> String {
    format!("[[contact]]\nname = \"{name}\"\non = \"b.z-min\"\nagainst = {against}\nfriction = {friction}\n{during}\n")
}

const PLATE: &str = "\"a.z-max\"";
const COULOMB: &str = "{ coulomb = 0.3 }";
const ONE: &str = "until = \"one\"";
const TWO: &str = "from = \"two\"";

/// Two contacts in both orders: the stages are the same.
fn in_turn(bodies: &str, contacts: [&str; 2], path: &str) -> Vec<Stage> {
    let [a, b] = contacts;
    let [found, other] = [[a, b], [b, a]]
        .map(|[first, second]| stages(&format!("{bodies}{first}{second}{STEPS}[solver]\npath = \"{path}\"\n")));
    found.iter().zip(&other).for_each(|(a, b)| same(&a.u, &b.u));
    found
}

const PATHS: [&str; 3] = ["dense", "solves", "multigrid"];

/// A beam that is clamped at one end rests on a plate, without friction at first and with friction from step two on: one contact with
/// a coefficient by time, or two contacts.
#[test]
fn two_contacts_in_turn_are_one_whose_law_changes() {
    for element in ["hex8", "tet10"] {
        let bodies = part("a", [30.0, 30.0, 10.0], [0.0; 3], [3, 3, 2], element)
            + &part("b", [30.0, 20.0, 5.0], [10.0, 5.0, 10.0], [6, 4, 1], element)
            + STEEL
            + "[[fix]]\non = \"a.z-min\"\n[[fix]]\non = \"b.x-max\"\n[[load]]\non = \"b.z-max\"\nforce = [\"-200*t\", 0, -1000]\n";
        let one = contact("both", PLATE, "{ coulomb = \"0.3 * max(t - 1, 0)\" }", "");
        let wanted = stages(&format!("{bodies}{one}{STEPS}"));
        for path in PATHS {
            let contacts = [contact("first", PLATE, "\"none\"", ONE), contact("then", PLATE, COULOMB, TWO)];
            let found = in_turn(&bodies, [&contacts[0], &contacts[1]], path);
            for (stage, wanted) in found.iter().zip(&wanted) {
                same(&stage.u, &wanted.u);
                assert_eq!(stage.path == SolverPath::Multigrid, path == "multigrid");
            }
            let [force_1, force_2] = [0, 1].map(|k| wanted[k].forces[0].1);
            presses(&found[0], &[("first", force_1), ("then", 0.0)]);
            presses(&found[1], &[("first", 0.0), ("then", force_2)]);
        }
    }
}

/// A block without supports of 1000 N stands on a plate, then on another one 0.01 lower, or on an obstacle there, or the other way about:
/// each carries it in its step.
#[test]
fn a_block_stands_on_one_thing_after_the_other() {
    let low = "{ plane = { point = [0, 0, 9.99], normal = [0, 0, 1] } }";
    for path in ["solves", "multigrid"] {
        for (first, then) in [(PLATE, "\"c.z-max\""), (PLATE, low), ("\"c.z-max\"", low), (low, PLATE)] {
            // What comes first is where the block is meshed.
            let up = if first == PLATE { 0.0 } else { -0.01 };
            let bodies = part("a", [30.0, 30.0, 10.0], [0.0; 3], [3, 3, 2], "hex8")
                + &part("c", [30.0, 30.0, 10.0], [0.0, 0.0, -0.01], [3, 3, 2], "hex8")
                + &part("b", [20.0, 20.0, 5.0], [5.0, 5.0, 10.0 + up], [4, 4, 1], "hex8")
                + STEEL
                + "[[fix]]\non = [\"a.z-min\", \"c.z-min\"]\n[[load]]\non = \"b.z-max\"\nforce = [0, 0, -1000]\n";
            let contacts = [contact("first", first, COULOMB, ONE), contact("then", then, COULOMB, TWO)];
            let found = in_turn(&bodies, [&contacts[0], &contacts[1]], path);
            presses(&found[0], &[("first", 1000.0), ("then", 0.0)]);
            presses(&found[1], &[("first", 0.0), ("then", 1000.0)]);
        }
    }
}

/// A beam that is glued to a plate and comes loose: by `bonded_until`, or by a bonded contact and one with friction after it.
#[test]
fn glue_and_friction_in_turn_are_a_contact_that_is_bonded_until_a_step() {
    let bodies = part("a", [30.0, 30.0, 10.0], [0.0; 3], [3, 3, 2], "hex8")
        + &part("b", [30.0, 20.0, 5.0], [10.0, 5.0, 10.0], [6, 4, 1], "hex8")
        + STEEL
        + "[[fix]]\non = \"a.z-min\"\n[[fix]]\non = \"b.x-max\"\n[[load]]\non = \"b.z-max\"\nforce = [-300, 100, -1000]\n";
    let one = contact("both", PLATE, COULOMB, "bonded_until = \"one\"");
    let wanted = stages(&format!("{bodies}{one}{STEPS}"));
    for path in PATHS {
        let contacts = [contact("first", PLATE, "\"bonded\"", ONE), contact("then", PLATE, COULOMB, TWO)];
        let found = in_turn(&bodies, [&contacts[0], &contacts[1]], path);
        found.iter().zip(&wanted).for_each(|(stage, wanted)| same(&stage.u, &wanted.u));
    }
}

/// A block on two plates side by side, of which one holds at all times and the other in one step: each step is the case with the contacts
/// that hold then, as is known of contact without friction. Some nodes of the block meet both plates, and are of one contact at a time;
/// beside them points stand for other areas in the step in which neighbours are lost.
#[test]
fn where_times_overlap_each_step_has_the_contacts_that_hold_in_it() {
    for element in ["hex8", "tet10"] {
        let bodies = part("a", [20.0, 30.0, 10.0], [0.0; 3], [4, 4, 2], element)
            + &part("c", [20.0, 30.0, 10.0], [20.5, 0.0, 0.0], [4, 4, 2], element)
            + &part("b", [34.0, 20.0, 5.0], [2.0, 5.0, 10.0], [7, 4, 1], element)
            + STEEL
            + "[[fix]]\non = [\"a.z-min\", \"c.z-min\"]\n[[fix]]\non = [\"b.x-min\", \"b.x-max\"]\ncomponents = \"xy\"\n\
               [[load]]\non = \"b.z-max\"\nforce = [0, 0, -1000]\nabout = [14, 15, 15]\n";
        let plates = [("left", PLATE, ""), ("right", "\"c.z-max\"", TWO)];
        let of = |(name, against, during): (&str, &str, &str)| {
            contact(name, against, "\"none\"", &format!("{during}\nslave = \"on\""))
        };
        let alone = solved(&(bodies.clone() + &of(plates[0])));
        let both = solved(&(bodies.clone() + &plates.map(|(name, against, _)| of((name, against, ""))).concat()));
        for path in PATHS {
            let found = in_turn(&bodies, [&of(plates[0]), &of(plates[1])], path);
            same(&found[0].u, &displacement(&alone));
            same(&found[1].u, &displacement(&both));
            presses(&found[0], &[("left", 1000.0), ("right", 0.0)]);
            assert!(found[1].forces.iter().all(|(_, force)| *force > 100.0));
        }
    }
}
