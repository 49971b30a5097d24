//! Contact that changes from step to step on several ranks, against the same case on one: laws that depend on time or on an array,
//! points and supports that begin or end with a step, strength that is lost.

use std::path::Path;

use stiction::Status;
use stiction::io::case::Case;
use stiction::io::vtu::{Array, Grid, write};
use stiction::mesh::{Block, BlockElement, block};
use stiction_fixtures::case_run::solved_case;

use super::ranks::{agrees_case, case_of, on_ranks, refusal};
use super::ranks_files::{folder, killed_when, passes, solved, without_costs};

const STEEL: &str = "[materials.steel]\nyoung = 2e11\npoisson = 0.3\n";
const STEPS: &str = "[[step]]\nname = \"press\"\nuntil = 1\nincrements = 2\n[[step]]\nname = \"pull\"\nuntil = 2\nincrements = 2\n\
                     [[step]]\nname = \"rest\"\nuntil = 3\n";

/// A brick that is pressed on a plane, then pulled along it, with what else the case has.
fn brick(element: &str, contact: &str, more: &str) -> String {
    let cells = if element == "tet10" { "[8, 3, 3]" } else { "[18, 6, 6]" };
    format!(
        "[mesh]\nblock = {{ size = [3, 1, 1], cells = {cells}, element = \"{element}\" }}\n{STEEL}\
         [[fix]]\non = \"x-min\"\n[[load]]\non = \"z-max\"\ntraction = [\"2e6*max(0, t - 1)*(2.6 - t)\", 0, \"-1e7*min(t, 1)\"]\n\
         [[contact]]\nname = \"floor\"\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         {contact}\n{more}{STEPS}"
    )
}

/// The last answer and the normal force and the counts of every step.
fn steps_agree(case: &Case, sizes: &[usize]) {
    agrees_case(case, sizes);
    let (outcome, _) = solved_case(case);
    let expected: Vec<_> = outcome.steps.iter().map(|step| &step.answer.contact).collect();
    let largest = expected.iter().fold(0.0, |most: f64, contact| most.max(contact.normal_force.abs()));
    assert!(expected.len() > 2 && largest > 0.0);
    for &size in sizes {
        let found = on_ranks(case, size).1.steps;
        assert_eq!(found.len(), expected.len());
        for (step, expected) in found.iter().zip(&expected) {
            let (a, b) = (step.answer.contact.normal_force, expected.normal_force);
            assert!((a - b).abs() <= 1e-9 * largest, "{size} ranks at t = {}: {a} {b}", step.t);
            assert_eq!(
                (step.answer.contact.points, step.answer.contact.open),
                (expected.points, expected.open),
                "{size} ranks"
            );
        }
    }
}

/// The same from the files of a run that was killed after two increments, on other ranks.
fn goes_on(case: &Case, name: &str) {
    let whole = folder(name);
    let expected = solved(case, 3, &whole, false);
    passes(&whole);
    for size in [3, 2] {
        let part = folder(&format!("{name}-{size}"));
        // Lost strength takes more than one solve of an increment.
        killed_when(case, 3, &part, false, &|_| part.join("step-0002-0000.npz").exists());
        let found = solved(case, size, &part, true);
        passes(&part);
        if size == 3 {
            assert_eq!(without_costs(&found.steps), without_costs(&expected.steps));
        }
        for (a, b) in found.steps.iter().zip(&expected.steps) {
            let (a, b) = (&a.answer.contact, &b.answer.contact);
            assert!((a.normal_force - b.normal_force).abs() <= 1e-9 * b.normal_force.abs().max(1e6), "{a:?} {b:?}");
            assert_eq!((a.open, a.points), (b.open, b.points));
        }
    }
}

#[test]
fn friction_that_changes_with_time_is_the_same_on_ranks() {
    let law = "friction = { coulomb = \"0.4 - 0.05*t*(1 + 0.2*x)\" }";
    steps_agree(&case_of(&brick("hex8", law, ""), "1e-10"), &[1, 2, 4]);
    let negative = "friction = { coulomb = \"1.5 - t\" }";
    let case = case_of(&brick("hex8", negative, ""), "1e-8");
    let error = refusal(&case, 3, None);
    assert!(error.what.contains("coefficient of friction") && error.place.starts_with("case.toml:"), "{error}");
}

#[test]
fn friction_by_an_array_is_the_same_on_ranks() {
    let [size, origin, grading] = [[3.0, 1.0, 1.0], [0.0; 3], [1.0; 3]];
    let mesh = block(&Block { size, origin, grading, cells: [18, 6, 6], element: BlockElement::Hex8 }).unwrap();
    let of_points: Vec<f64> = mesh.nodes.iter().map(|x| 0.1 + 0.1 * x[0] * x[1]).collect();
    let of_cells: Vec<f64> = (0..mesh.cell_count()).map(|cell| 0.1 + 0.05 * (cell % 4) as f64).collect();
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("ranks-friction.vtu");
    write(&path, &Grid::from_mesh(&mesh), &[Array::scalar("mu", &of_points)], &[Array::scalar("nu", &of_cells)])
        .unwrap();
    for law in [
        "{ array = \"mu\" }",
        "{ array = \"nu\" }",
        "[{ array = \"mu\" }, { array = \"nu\" }], direction = [1, 0.3, 0]",
    ] {
        let text = format!(
            "[mesh]\nfile = {path:?}\n{STEEL}[[fix]]\non = {{ box = [[0, 0, 0], [0, 1, 1]] }}\n\
             [[load]]\non = {{ box = [[0, 0, 1], [3, 1, 1]] }}\ntraction = [2e6, 3e5, \"-1e7*x\"]\n\
             [[contact]]\non = {{ box = [[0, 0, 0], [3, 1, 0]] }}\nfriction = {{ coulomb = {law} }}\n\
             against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n"
        );
        agrees_case(&case_of(&text, "1e-10"), &[1, 4]);
    }
}

/// A wall at the end, a clamp that is bonded where it stands when it is put in, and a floor that is away for a step.
fn with_periods(element: &str) -> Case {
    let more = "[[contact]]\nname = \"wall\"\non = { box = [[3, 0, 0.2], [3, 1, 1]] }\nfriction = { coulomb = 0.2 }\nuntil = \"pull\"\n\
                against = { plane = { point = [3.000002, 0, 0], normal = [-1, 0, 0] } }\n\
                [[contact]]\nname = \"clamp\"\non = { box = [[0, 1, 0.2], [2.7, 1, 1]] }\nfriction = \"bonded\"\nfrom = \"pull\"\n\
                against = { plane = { point = [0, 1.001, 0], normal = [0, -1, 0] } }\n";
    case_of(&brick(element, "friction = { coulomb = 0.3 }\nwithout = [\"pull\"]", more), "1e-10")
}

#[test]
fn contacts_that_begin_or_end_with_a_step_are_the_same_on_ranks() {
    steps_agree(&with_periods("hex8"), &[1, 2, 4]);
    steps_agree(&with_periods("tet10"), &[3]);
    goes_on(&with_periods("hex8"), "periods");
}

#[test]
fn a_contact_that_is_bonded_at_first_is_the_same_on_ranks() {
    let law = "friction = { coulomb = 0.05 }\nbonded_until = \"pull\"";
    let case = case_of(&brick("hex8", law, ""), "1e-10");
    steps_agree(&case, &[1, 3]);
    goes_on(&case, "bonded-until");
}

/// A support that is let go, one that leads its nodes to a value and one that keeps them where they stand.
fn with_supports(element: &str) -> Case {
    let more = "[[fix]]\non = { box = [[3, 0, 0.1], [3, 0.9, 0.9]] }\nvalue = [\"1e-5*t\", 0, 0]\nuntil = \"press\"\n\
                [[fix]]\non = { box = [[0, 1, 0.1], [3, 1, 0.9]] }\ncomponents = \"y\"\nvalue = \"2e-5\"\nfrom = \"pull\"\n\
                [[fix]]\non = \"z-max\"\ncomponents = \"xz\"\ncondition = \"as-it-stands\"\nfrom = \"rest\"\n";
    case_of(&brick(element, "friction = { coulomb = 0.3 }", more), "1e-10")
}

#[test]
fn supports_that_begin_or_end_with_a_step_are_the_same_on_ranks() {
    steps_agree(&with_supports("hex8"), &[1, 2, 4]);
    goes_on(&with_supports("hex8"), "supports");
}

/// A bar that is stretched and let go goes back to where it was, whoever holds its end.
#[test]
fn a_bar_that_is_let_go_springs_back_on_ranks() {
    let text = format!(
        "[mesh]\nblock = {{ size = [3, 1, 1], cells = [9, 3, 3], element = \"hex8\" }}\n{STEEL}\
         [[fix]]\non = \"x-min\"\n[[fix]]\non = {{ box = [[3, 0, 0.1], [3, 1, 1]] }}\nvalue = [\"0.03*min(t, 1)\", 0, 0]\nuntil = \"stretch\"\n\
         [[contact]]\non = \"z-min\"\nfriction = \"none\"\nagainst = {{ plane = {{ point = [0, 0, -1], normal = [0, 0, 1] }} }}\n\
         [[step]]\nname = \"stretch\"\nuntil = 1\n[[step]]\nname = \"free\"\nuntil = 2\n"
    );
    let case = case_of(&text, "1e-10");
    for size in [1, 4] {
        let (u, summary) = on_ranks(&case, size);
        assert!(summary.answer.status == stiction::Status::Solved && summary.steps.len() == 2);
        assert!(u.iter().flatten().all(|u| u.abs() < 1e-9 * 0.03), "{size} ranks");
    }
}

/// Two blocks that are glued together, with meshes of their own; the top of one is tilted, so that the glue tears from one end.
fn glued(lost: &str, element: &str) -> Case {
    let text = format!(
        "[mesh.parts.a]\nblock = {{ size = [3, 1, 1], cells = [9, 4, 3], element = \"{element}\" }}\n\
         [mesh.parts.b]\nblock = {{ size = [3.2, 1, 0.5], cells = [8, 3, 2], element = \"hex8\" }}\nmove = [0, 0, -0.5]\n{STEEL}\
         [[fix]]\non = \"a.z-max\"\nvalue = [\"2e-6*t\", 0, \"3e-6*t*(x - 0.5)\"]\n[[fix]]\non = \"b.z-min\"\n\
         [[contact]]\non = \"a.z-min\"\nagainst = \"b.z-max\"\n\
         friction = {{ coulomb = 0.5, cohesion = 8e5, tension = 4e5, cohesion_lost = \"{lost}\" }}\n\
         [[step]]\nuntil = 1\nincrements = 2\n[[step]]\nuntil = 2\nincrements = 2\n"
    );
    case_of(&text, "1e-10")
}

#[test]
fn cohesion_and_tensile_strength_are_the_same_on_ranks() {
    steps_agree(&glued("never", "hex8"), &[1, 2, 4]);
    steps_agree(&glued("never", "tet4"), &[3]);
}

#[test]
fn strength_that_is_lost_is_lost_on_all_ranks_and_stays_lost_when_they_go_on() {
    let case = glued("on slip", "hex8");
    steps_agree(&case, &[1, 2, 4]);
    // It tears in every step.
    let open: Vec<usize> = on_ranks(&case, 2).1.steps.iter().map(|step| step.answer.contact.open).collect();
    assert!(open.len() == 4 && open[0] > 0 && open[0] < open[1] && open[1] < open[2], "{open:?}");
    goes_on(&case, "torn");
}

/// A glue that tears at a known pull: the body hangs on it up to its strength, and falls off beyond.
#[test]
fn a_glued_block_carries_its_strength_and_no_more_on_ranks() {
    let text = |pull: f64, lost: &str| {
        format!(
            "[mesh]\nblock = {{ size = [1, 1, 1], cells = [4, 4, 4], element = \"hex8\" }}\n\
             [materials.soft]\nyoung = 2000\npoisson = 0\n[[fix]]\non = \"z-max\"\nvalue = [0, 0, \"{pull}*t\"]\n\
             [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
             friction = {{ coulomb = 0.5, cohesion = 1.2, tension = 0.4, cohesion_lost = \"{lost}\" }}\n\
             [[step]]\nuntil = 1\nincrements = 2\n"
        )
    };
    // The stress is Young's modulus times the pull.
    for (pull, lost, expected) in
        [(1.9e-4, "never", -0.38), (1.9e-4, "on slip", -0.38), (2.1e-4, "never", -0.4), (2.1e-4, "on slip", 0.0)]
    {
        for size in [1, 3] {
            let force = on_ranks(&case_of(&text(pull, lost), "1e-10"), size).1.answer.contact.normal_force;
            assert!((force - expected).abs() < 1e-8, "{lost}, {pull}, {size} ranks: {force}");
        }
    }
}

/// Friction of 300 holds a block that was held from above before, until it is pushed by more.
#[test]
fn a_body_that_nothing_holds_any_more_has_no_equilibrium_on_ranks() {
    let text = |push: &str| {
        format!(
            "[mesh]\nblock = {{ size = [10, 10, 5], cells = [6, 6, 4], element = \"hex8\" }}\n\
             [materials.s]\nyoung = 1e5\npoisson = 0.3\n[[load]]\non = \"z-max\"\npressure = 10\n\
             [[load]]\non = \"z-max\"\nforce = [\"{push}*max(t - 1, 0)\", 0, 0]\n\
             [[fix]]\non = \"z-max\"\ncomponents = \"xy\"\nuntil = \"a\"\n[[contact]]\non = \"z-min\"\n\
             against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\nfriction = {{ coulomb = 0.3 }}\n\
             [[step]]\nname = \"a\"\nuntil = 1\n[[step]]\nname = \"b\"\nuntil = 2\nincrements = 2\n"
        )
    };
    let held = on_ranks(&case_of(&text("290"), "1e-8"), 3).1;
    assert_eq!((held.answer.status, held.steps.len()), (Status::Solved, 3));
    let gone = on_ranks(&case_of(&text("2000"), "1e-8"), 3).1;
    let last = gone.steps.last().unwrap().t;
    assert!(gone.answer.status != Status::Solved && (1.15..1.17).contains(&last), "{:?} at {last}", gone.answer.status);
}

/// The same two faces named by two contacts that hold one after the other: points of both are on one node.
#[test]
fn contacts_that_take_turns_on_one_surface_are_refused_at_their_line() {
    let with = |law: &str| {
        let more = "[[contact]]\nname = \"then\"\non = \"z-min\"\nfriction = { coulomb = 0.2 }\nfrom = \"pull\"\n\
                    against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n";
        refusal(&case_of(&brick("hex8", law, more), "1e-8"), 3, None)
    };
    let error = with("friction = { coulomb = 0.3 }\nuntil = \"press\"");
    assert!(error.what.contains("nodes in common") && error.remedy.contains("stiction solve"), "{error}");
    assert!(error.place.starts_with("case.toml:"), "{error}");
}

/// Multigrid wants a node for each point; on one machine there is the factor.
#[test]
fn supports_by_time_that_share_nodes_with_contacts_or_one_another_are_refused_at_their_line() {
    let with_contact = "[[fix]]\non = \"x-max\"\nfrom = \"pull\"\n";
    let of_other_steps = "[[fix]]\non = { box = [[3, 0, 0.5], [3, 1, 1]] }\ncomponents = \"x\"\nuntil = \"press\"\n\
                          [[fix]]\non = { box = [[2.5, 1, 0.5], [3, 1, 1]] }\ncomponents = \"y\"\nfrom = \"rest\"\n";
    for more in [with_contact, of_other_steps] {
        let case = case_of(&brick("hex8", "friction = { coulomb = 0.3 }", more), "1e-8");
        let error = refusal(&case, 3, None);
        assert!(error.what.contains("support that begins or ends with a step"), "{error}");
        assert!(error.place.starts_with("case.toml:") && error.remedy.contains("stiction solve"), "{error}");
        assert!(error.excerpt.contains("[[fix]]"), "{error}");
    }
}

#[test]
fn a_body_whose_load_is_taken_off_is_at_rest_on_ranks() {
    let text = "[mesh]\nblock = { size = [2, 2, 1], cells = [8, 8, 4], element = \"hex8\" }\n[materials.m]\nyoung = 1e3\npoisson = 0.3\n\
                [[fix]]\non = { point = [0, 0, 0] }\ncomponents = \"xy\"\n[[fix]]\non = { point = [2, 0, 0] }\ncomponents = \"y\"\n\
                [[load]]\non = \"z-max\"\npressure = \"t*(2 - t)\"\n[[contact]]\non = \"z-min\"\nfriction = { coulomb = 0.3 }\n\
                against = { plane = { point = [0, 0, -0.001], normal = [0, 0, 1] } }\n[[step]]\nuntil = 2\nincrements = 2\n";
    for size in [1, 3] {
        let (u, summary) = on_ranks(&case_of(text, "1e-9"), size);
        assert!(
            summary.answer.status == Status::Solved && summary.answer.certificate.passed && !summary.found_by_first()
        );
        assert!(
            (summary.steps[0].answer.contact.normal_force - 4.0).abs() < 1e-7
                && summary.answer.contact.normal_force == 0.0
        );
        // It lies on the plane, as near to where the pressed nodes were as one that is not strained.
        let is_there = |u: &[f64; 3]| u[0].abs() < 1e-5 && u[1].abs() < 1e-5 && (u[2] + 0.001).abs() < 1e-5;
        assert!(u.iter().all(is_there), "{size} ranks");
        assert!(summary.answer.counts.cycles < 150, "{} cycles", summary.answer.counts.cycles);
    }
}
