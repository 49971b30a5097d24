//! What is said of a case and of its answer on several ranks against what is said on one: the facts, the notes, the warnings, what
//! passes through.

use std::ops::ControlFlow;

use super::ranks::{case_of, on_ranks};
use stiction::Status;
use stiction::io::case::Case;
use stiction::linalg::Stop;
use stiction::run::{AnswerRecord, BalanceRecord, Origin, Plan, Summary, solve_case, summary};
use stiction_fixtures::folder::Folder;

/// The summary of one machine, which solves again where contact turns up beyond `search`.
fn serial(case: &Case) -> Summary {
    let go_on = &mut |_: stiction::run::Stage| ControlFlow::Continue(());
    let (prepared, outcome, _) = solve_case(case, &Plan::default(), &Stop::never(), None, go_on).unwrap();
    serde_json::from_str(&summary(&prepared, &outcome, &Origin::default())).unwrap()
}

/// The rows with one of these labels.
fn of<'a>(rows: &'a [stiction::run::Row], labels: &[&str]) -> Vec<&'a stiction::run::Row> {
    rows.iter().filter(|row| labels.contains(&row.label.as_str())).collect()
}

/// Compares all that is said, and returns it as one text.
fn says_the_same(text: &str, sizes: &[usize]) -> (String, Summary) {
    let case = case_of(text, "1e-10");
    let expected = serial(&case);
    let mut last = None;
    for &size in sizes {
        let (_, found) = on_ranks(&case, size);
        assert_eq!(found.problem, expected.problem, "{size} ranks");
        assert_eq!(found.answer.status, expected.answer.status, "{size} ranks: {:?}", found.report);
        let deformation = |rows: &[stiction::run::Row]| {
            // Bodies that are moved alone have that of rounding.
            of(rows, &["deformation"]).into_iter().filter(|row| !row.value.contains("e-")).cloned().collect::<Vec<_>>()
        };
        assert_eq!(deformation(&found.report), deformation(&expected.report), "{size} ranks");
        // Bodies that are moved have several nodes that are moved as far.
        let farthest = |rows| of(rows, &["displacement"])[0].value.split(" at (").next().map(str::to_string);
        assert_eq!(farthest(&found.report), farthest(&expected.report), "{size} ranks");
        let labels = ["contact", "bolt", "reference", "warning", "uniqueness"];
        assert_eq!(of(&found.report, &labels), of(&expected.report, &labels), "{size} ranks");
        let words = |rows: &[stiction::run::Row]| rows.iter().map(|row| row.label.clone()).collect::<Vec<_>>();
        assert_eq!(words(&found.report), words(&expected.report), "{size} ranks");
        let more = |rows: &[stiction::run::Row]| of(rows, &["status"])[0].more.clone();
        assert_eq!(more(&found.report), more(&expected.report), "{size} ranks");
        assert_eq!(found.answer.overlaps.len(), expected.answer.overlaps.len());
        for (found, expected) in found.answer.overlaps.iter().zip(&expected.answer.overlaps) {
            assert_eq!((found.kind, &found.contact), (expected.kind, &expected.contact));
            // Of two places that lie as deep in each other either may be the first.
            let sorted = |list: &[String]| {
                let mut list = list.to_vec();
                list.sort();
                list
            };
            assert_eq!(sorted(&found.bodies), sorted(&expected.bodies));
            assert_eq!(sorted(&found.groups), sorted(&expected.groups));
            assert!((found.depth - expected.depth).abs() <= 1e-6 * expected.depth, "{found:?} {expected:?}");
        }
        for (found, expected) in found.answer.pairs.iter().zip(&expected.answer.pairs) {
            assert_eq!((&found.name, found.totals.points), (&expected.name, expected.totals.points));
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * b.abs().max(1e-12);
            assert!(near(found.totals.normal_force, expected.totals.normal_force), "{found:?} {expected:?}");
            assert!(near(found.totals.max_other_pressure, expected.totals.max_other_pressure));
            let (a, b) = (found.micromotion.map(|of| of.p90), expected.micromotion.map(|of| of.p90));
            assert!(
                a.zip(b).is_none_or(|(a, b)| (a - b).abs() <= 1e-6 * b + 1e-12) && a.is_some() == b.is_some(),
                "{found:?} {expected:?}"
            );
        }
        sums_are_the_same(&found, &expected);
        last = Some(found);
    }
    let all = expected.problem.iter().chain(&expected.report);
    (all.map(|row| format!("{}: {}\n", row.label, row.line())).collect(), last.unwrap())
}

/// Energies, and forces of loads and supports, of the answer and of each load step.
fn sums_are_the_same(found: &Summary, expected: &Summary) {
    let steps = found.steps.iter().map(|step| &step.answer).zip(expected.steps.iter().map(|step| &step.answer));
    for (found, expected) in std::iter::once((&found.answer, &expected.answer)).chain(steps) {
        let of = |answer: &AnswerRecord| [answer.load, answer.reaction].concat();
        // Where bodies are moved and nothing resists, supports have the rounding of what stiff cells exert.
        let least = expected.contact.normal_force.abs().max(0.1 * expected.displacement_max);
        let force = of(expected).iter().fold(least, |most, force| most.max(force.abs()));
        for (a, b) in of(found).iter().zip(of(expected)) {
            assert!((a - b).abs() <= 1e-6 * force, "{:?} {:?}", of(found), of(expected));
        }
        let energy = expected.energy.abs().max(force * expected.displacement_max);
        assert!((found.energy - expected.energy).abs() <= 1e-6 * energy, "{} {}", found.energy, expected.energy);
        assert_eq!((found.dofs, found.dual_dofs, found.path), (expected.dofs, expected.dual_dofs, expected.path));
        assert_eq!((&found.method, &found.coulomb, &found.sliding), (&expected.method, &None, &None));
        let errors = [found, expected].map(|answer| answer.discretisation_error);
        // At borders of ranks some polynomials are made of fewer cells, which tells on meshes as coarse as these.
        let near = errors[0].zip(errors[1]).is_none_or(|(a, b)| (a - b).abs() <= 0.03 * b);
        assert!(near && errors[0].is_some() == errors[1].is_some(), "{errors:?}");
    }
    assert_eq!(found.steps.len(), expected.steps.len());
    assert_eq!(found.balance, found.steps.last().map(|last| last.balance));
    for (a, b) in found.steps.iter().zip(&expected.steps) {
        assert_eq!((a.step, &a.name, a.t, a.dt), (b.step, &b.name, b.t, b.dt));
        let of =
            |BalanceRecord { work, elastic, dissipation, drift }: BalanceRecord| [work, elastic, dissipation, drift];
        let rounding = b.answer.displacement_max.powi(2);
        let most = of(b.balance).iter().fold(rounding, |most, energy| most.max(energy.abs()));
        for (found, expected) in of(a.balance).iter().zip(of(b.balance)) {
            assert!((found - expected).abs() <= 1e-6 * most, "{:?} {:?}", a.balance, b.balance);
        }
    }
}

fn has(text: &str, words: &[&str]) {
    words.iter().for_each(|word| assert!(text.contains(word), "{word}: {text}"));
}

const LOW: &str = "[mesh.parts.a]\nblock = { size = [10, 10, 10], cells = [5, 4, 4], element = \"hex8\" }\n";

/// Two blocks, the upper one so far above the lower one.
fn two(apart: f64, more: &str) -> String {
    format!(
        "title = \"Two blocks\"\nunits = \"mm, N, MPa\"\n{LOW}[mesh.parts.b]\n\
         block = {{ size = [10, 10, 10], cells = [3, 4, 3], element = \"tet4\", split = \"six\", origin = [0, 0, {}] }}\n\
         [materials.s]\non = \"a\"\nyoung = 1000\npoisson = 0.3\nexpansion = 1e-5\n[materials.r]\non = \"b\"\nyoung = 1100\npoisson = 0.495\ndensity = 1e-9\n\
         [[fix]]\non = \"a.z-min\"\n{more}",
        10.0 + apart
    )
}

const DOWN: &str = "[[fix]]\non = \"b.z-max\"\nvalue = [0.01, 0, \"-0.05 - 0.01*x\"]\n";
const PAIR: &str = "[[contact]]\non = \"b.z-min\"\nagainst = \"a.z-max\"\nfriction = { coulomb = 0.3 }\n";

#[test]
fn the_case_and_its_notes_are_told_on_ranks_as_on_one() {
    let loads = "[[load]]\non = \"b.x-max\"\nforce = [1, 0.5, -2]\n[[load]]\ngravity = [0, 0, -9810]\n\
                 [[load]]\non = \"b.y-max\"\ntraction = [0, 0, \"-0.1*x\"]\n[[load]]\ntemperature = \"0.1*z\"\non = \"a\"\n\
                 [[spring]]\non = \"b.x-min\"\nnormal = 3\ntangential = 1\n";
    let (said, _) = says_the_same(&two(-0.01, &format!("{DOWN}{loads}{PAIR}")), &[2, 3]);
    has(
        &said,
        &["the meshes overlap by up to 0.01", "tetrahedra lock", "gravity on volume", "temperature from", "title"][..4],
    );
    // Contacts that share nodes and faces, and a node for the body that nothing else holds.
    let wall = "[[contact]]\nname = \"wall\"\non = [\"b.z-min\", \"b.y-min\"]\nfriction = \"none\"\n\
                against = { plane = { point = [0, -0.001, 0], normal = [0, 1, 0] }, motion = [0, 0.0005, 0] }\n";
    let (said, _) = says_the_same(&two(0.0, &format!("{DOWN}{PAIR}{wall}")), &[2, 4]);
    has(&said, &["are fixed and carry no contact force", "look away from the obstacle", "before its obstacle moves"]);
}

#[test]
fn what_leaves_the_linear_theory_is_told_on_ranks_as_on_one() {
    let turned = "[[fix]]\non = \"b.z-max\"\nvalue = [\"-0.15*(y - 5)\", \"0.15*(x - 5)\", -1]\n";
    let (said, _) = says_the_same(&two(0.0, &format!("{turned}{PAIR}")), &[3]);
    has(&said, &["the linear theory is left: rotation of", "the linear theory is left: strain of", "of a face"]);
    let steps = "[[step]]\nuntil = 1\nincrements = 2\n";
    let turned = turned.replace("-1]", "\"-t\"]");
    let (said, _) = says_the_same(&two(0.0, &format!("{turned}{PAIR}{steps}")), &[2]);
    has(&said, &["at t = 1, more than 5"]);
}

#[test]
fn a_couple_that_is_lost_is_told_on_ranks_as_on_one() {
    for law in ["friction = \"bonded\"", "friction = { coulomb = 0.5 }\ngap = \"closed\""] {
        let pull = "[[load]]\non = \"b.z-max\"\nforce = [10, 0, -100]\n";
        let pair = format!("[[contact]]\nname = \"c\"\non = \"b.z-min\"\nagainst = \"a.z-max\"\n{law}\n");
        let (said, _) = says_the_same(&two(2.0, &format!("{pull}{pair}")), &[1, 3]);
        has(&said, &["the couple", "mesh the surfaces where they touch"]);
    }
}

#[test]
fn surfaces_that_meet_beyond_search_are_solved_again_on_ranks() {
    for steps in ["", "[[step]]\nuntil = 1\nincrements = 3\n"] {
        let down = "[[fix]]\non = \"b.z-max\"\nvalue = [0, 0, \"-6*t - 0.01*x\"]\n";
        let (said, found) = says_the_same(&two(4.0, &format!("{down}{PAIR}{steps}")), &[2]);
        has(&said, &["`search` is", "strain of"]);
        assert!(found.answer.status == Status::Solved && found.ended_short().is_none());
    }
}

#[test]
fn surfaces_that_no_search_finds_are_no_answer_on_ranks() {
    let aside = |moved: &str, more: &str| {
        two(4.0, &format!("[[fix]]\non = \"b.z-max\"\nvalue = {moved}\n{PAIR}{more}"))
            .replace("origin = [0, 0", "origin = [30, 0")
    };
    for steps in ["", "[[step]]\nuntil = 1\nincrements = 3\n"] {
        // Tilted, so that one place is deepest.
        let [back, down] = ["\"-(30 + 0.02*y)*t - 0.01\"", "\"-(6 + 0.01*x + 0.003*y)*t\""];
        let (said, found) = says_the_same(&aside(&format!("[{back}, 0, {down}]"), steps), &[2]);
        has(&said, &["without a contact point: before the load nothing lies opposite there"]);
        assert_eq!(found.answer.status, Status::PassesThrough);
        has(&found.ended_short().unwrap(), &["the files hold bodies that pass through each other"]);
    }
    // What nobody has named is a warning, of a body and of a wall. Twisted, so that one place turns most.
    let wall = "[[contact]]\nname = \"wall\"\non = \"a.x-max\"\nfriction = \"none\"\n\
                against = { plane = { point = [12, 0, 0], normal = [-1, 0, 0] } }\n";
    let text = two(4.0, &format!("[[fix]]\non = \"b.z-max\"\nvalue = [6, 0, \"-4 - 0.1*x - 0.002*x*y\"]\n{wall}"));
    let (said, _) = says_the_same(&text, &[3]);
    has(
        &said,
        &["deep in body", "no contact is named: name the two surfaces", "deep in the obstacle of contact \"wall\""],
    );
}

#[test]
fn obstacles_between_the_nodes_of_a_face_are_named_on_ranks() {
    for steps in ["", "[[step]]\nuntil = 1\nincrements = 2\n"] {
        let (said, _) = says_the_same(
            &format!(
                "[mesh]\nblock = {{ size = [24, 24, 12], cells = [8, 8, 4], element = \"tet4\" }}\n[materials.s]\nyoung = 2e5\npoisson = 0.3\n\
                 [[fix]]\non = \"z-min\"\n[[contact]]\nname = \"ball\"\non = \"z-max\"\nfriction = \"none\"\n\
                 against = {{ sphere = {{ center = [10.9, 10.2, 20], radius = 8 }}, motion = [0, 0, \"-0.1*t\"] }}\n{steps}"
            ),
            &[1, 3],
        );
        has(&said, &["between its nodes", "ball"]);
    }
}

#[test]
fn how_loads_carry_a_body_away_is_told_on_ranks_as_on_one() {
    let up = "[[load]]\non = \"b.z-max\"\nforce = [0, 0, 1]\n";
    let (said, found) = says_the_same(&two(0.0, &format!("{up}{PAIR}")), &[2]);
    has(&said, &["the loads carry away", "remedy:"]);
    assert_eq!(found.answer.status, Status::NoEquilibrium);
    has(&found.ended_short().unwrap(), &["there is no equilibrium, the loads carry away"]);
}

/// A plate lies loose between another one and one that comes down on it: it is named for the time before it is pressed, and where the
/// loads of the last step are gone, the others are not.
#[test]
fn a_body_that_nothing_holds_in_some_steps_is_named_on_ranks_as_on_one() {
    let plate = |name: &str, z: f64| {
        format!(
            "[mesh.parts.{name}]\nblock = {{ size = [4, 4, 1], cells = [4, 4, 1], element = \"hex8\", origin = [0, 0, {z}] }}\n"
        )
    };
    let contact = |on: &str, against: &str| {
        format!("[[contact]]\non = \"{on}\"\nagainst = \"{against}\"\nfriction = {{ coulomb = 0.3 }}\n")
    };
    let text = [plate("a", 0.0), plate("b", 1.0), plate("c", 2.1)].concat()
        + "[materials.m]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = \"a.z-min\"\n\
           [[fix]]\non = \"c.z-max\"\nvalue = [0, 0, \"-0.3*min(t, 2.2 - t)\"]\n"
        + &contact("b.z-min", "a.z-max")
        + &contact("c.z-min", "b.z-max")
        + "[[step]]\nuntil = 1\nincrements = 4\n[[step]]\nuntil = 2\nincrements = 2\n";
    let case = case_of(&text, "1e-8");
    let warnings = |rows: &[stiction::run::Row]| {
        of(rows, &["warning"])
            .into_iter()
            .filter(|row| row.value.contains("nothing holds"))
            .cloned()
            .collect::<Vec<_>>()
    };
    let expected = serial(&case);
    let unheld: Vec<&[String]> = expected.steps.iter().map(|step| &step.answer.unheld[..]).collect();
    let loose = ["b".to_string()];
    assert_eq!(unheld, [&loose[..], &[], &[], &[], &[], &loose]);
    let [warning] = &warnings(&expected.report)[..] else { panic!("{:?}", expected.report) };
    assert!(warning.value.contains("nothing holds body \"b\" at t = 0.25 and in 1 more increment:"), "{warning:?}");
    for size in [1, 2, 4] {
        let found = on_ranks(&case, size).1;
        assert_eq!(warnings(&found.report), std::slice::from_ref(warning), "{size} ranks");
    }
}

/// Half a bush without friction on half a pin, of a mesh or of triangles: what is said of it, its numbers among them.
#[test]
fn what_facets_alone_hold_is_named_on_ranks_as_on_one() {
    let ring = |name: &str, radii: [f64; 2], cells: usize| {
        format!(
            "[mesh.parts.{name}]\nring = {{ radii = {radii:?}, height = 4, degrees = 180, cells = [2, {cells}, 1], element = \"hex8\" }}\n"
        )
    };
    let bush = ring("bush", [10.001, 14.0], 19);
    let pin = ring("pin", [5.0, 10.0], 24);
    let acts = "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n[[load]]\non = \"bush.outer\"\npressure = 10\n\
                [[load]]\non = \"bush.end\"\nforce = [0, \"0.001*t\", 0]\n[[fix]]\non = \"bush.z-min\"\ncomponents = \"z\"\n";
    let meshed = "[[fix]]\non = \"pin.inner\"\n[[contact]]\non = \"bush.inner\"\nagainst = \"pin.outer\"\n";
    let steps = "[[step]]\nname = \"turn\"\nuntil = 1\nincrements = 2\n";
    let shaft = Folder::new("facets-of-a-shaft");
    let at = |k: usize, z: f64| {
        let angle = std::f64::consts::TAU * k as f64 / 24.0;
        format!("vertex {:?} {:?} {z:?}\n", 10.0 * angle.cos(), 10.0 * angle.sin())
    };
    let facet =
        |corners: [String; 3]| format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", corners.concat());
    let panel = |k: usize| {
        facet([at(k, -1.0), at(k + 1, -1.0), at(k + 1, 5.0)]) + &facet([at(k, -1.0), at(k + 1, 5.0), at(k, 5.0)])
    };
    let panels: String = (0..24).map(panel).collect();
    shaft.write("shaft.stl", format!("solid shaft\n{panels}endsolid shaft\n"));
    let of_triangles =
        format!("[[contact]]\non = \"bush.inner\"\nagainst = {{ surface = {:?} }}\n", shaft.at("shaft.stl").display());
    let none = "friction = \"none\"\n";
    let held = "[[fix]]\non = \"bush.start\"\ncomponents = \"y\"\n";
    for (text, named) in [
        (format!("{bush}{pin}{acts}{meshed}{none}"), true),
        (format!("{bush}{pin}{acts}{meshed}{none}{steps}"), true),
        (format!("{bush}{acts}{of_triangles}{none}"), true),
        (format!("{bush}{pin}{acts}{meshed}{none}{held}"), false),
        (format!("{bush}{pin}{acts}{meshed}friction = {{ coulomb = 0.3 }}\n"), false),
    ] {
        let case = case_of(&text, "1e-10");
        let said = |rows: &[stiction::run::Row]| {
            let facets = of(rows, &["warning"]).into_iter().filter(|row| row.value.contains("than the facets"));
            facets.cloned().collect::<Vec<_>>()
        };
        let expected = serial(&case);
        assert_eq!(said(&expected.report).len(), usize::from(named), "{text}");
        for size in [1, 2, 4] {
            let found = on_ranks(&case, size).1;
            assert_eq!(said(&found.report), said(&expected.report), "{size} ranks: {text}");
            let steps = || found.steps.iter().zip(&expected.steps);
            assert!(steps().all(|(a, b)| a.answer.held_by_facets.is_some() == b.answer.held_by_facets.is_some()));
            assert_eq!(found.answer.held_by_facets.is_some(), expected.answer.held_by_facets.is_some());
        }
    }
}

/// Every rank knows the contact points of all: statics is not left to rank 0, which does not pose what is as large as this.
#[test]
fn statics_says_on_ranks_what_it_says_on_one_at_any_size() {
    let large = |load: &str, law: &str| {
        format!(
            "[mesh.parts.a]\nblock = {{ size = [3, 1, 1], cells = [33, 12, 12], element = \"hex8\" }}\n\
             [mesh.parts.b]\nblock = {{ size = [3, 1, 0.5], cells = [31, 11, 6], element = \"hex8\", origin = [0, 0, -0.5] }}\n\
             [materials.steel]\nyoung = 2e11\npoisson = 0.3\n[[fix]]\non = \"b.z-min\"\n\
             [[load]]\non = \"a.z-max\"\ntraction = {load}\n\
             [[contact]]\non = \"a.z-min\"\nagainst = \"b.z-max\"\nfriction = {law}\n"
        )
    };
    let coulomb = "{ coulomb = 0.35 }";
    // Pushed along and lifted off.
    let (said, found) = says_the_same(&large("[5e5, 0, -1e6]", coulomb), &[1, 3]);
    has(&said, &["translation along x", "it slides", "friction holds at most 0.35 x 3e6"]);
    assert!(found.answer.status == Status::NoEquilibrium && found.answer.dofs > 20_000, "{found}");
    let (said, _) = says_the_same(&large("[0, 0, 1e6]", coulomb), &[3]);
    has(&said, &["it lifts off", "translation along z"]);
    // Where the axis is differs by rounding.
    let turned = on_ranks(&case_of(&large("[0, \"-3e6*(x - 1.5)\", -1e6]", coulomb), "1e-8"), 2).1;
    has(
        &turned.to_string(),
        &["rotation about the axis along (0, 0, -1)", "it slides: none of its 442 contact points"],
    );
}
