//! Couplings and linear equations on several ranks, against the same case on one: all nodes that they join are those of one rank.

use stiction::run::{CouplingState, coupling_states, prepare};
use stiction_fixtures::case_run::solved_case;

use super::ranks::{agrees_case, case_of, on_ranks, refusal, serial_cycles};
use super::ranks_files::{folder, killed_when, passes, solved, without_costs};

const STEEL: &str = "[materials.steel]\nyoung = 2e11\npoisson = 0.3\n";
const FLOOR: &str = "[[contact]]\non = \"z-min\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n";

/// A block on a plane.
fn block(cells: [usize; 3], element: &str, friction: &str, rest: &str) -> String {
    format!(
        "[mesh]\nblock = {{ size = [2, 1.5, 1], cells = {cells:?}, element = \"{element}\" }}\n{STEEL}{FLOOR}\
         friction = {{ coulomb = {friction} }}\n{rest}"
    )
}

fn numbers(state: &CouplingState) -> Vec<f64> {
    [state.displacement, state.rotation, state.force, state.moment].concat()
}

/// Of each kind of number, motions and forces, to this part of the largest.
fn states_agree(found: &[CouplingState], expected: &[CouplingState], accuracy: f64) {
    assert_eq!(found.len(), expected.len());
    let largest = |part: std::ops::Range<usize>| {
        let all = expected.iter().flat_map(|state| numbers(state)[part.clone()].to_vec());
        all.fold(0.0, |most: f64, v| if v.abs() > most { v.abs() } else { most })
    };
    let scales = [largest(0..6), largest(6..12)];
    for (a, b) in found.iter().zip(expected) {
        assert_eq!(a.name, b.name);
        for (k, (x, y)) in numbers(a).into_iter().zip(numbers(b)).enumerate() {
            let near = (x - y).abs() <= accuracy * scales[k / 6] || x.is_nan() && y.is_nan();
            assert!(near, "{a:?} {b:?}");
        }
    }
}

/// Displacements, resultants, motions of reference points and what acts there, of every step.
fn agrees(text: &str, sizes: &[usize]) {
    let case = case_of(text, "1e-10");
    agrees_case(&case, sizes);
    let (outcome, prepared) = solved_case(&case);
    let expected = coupling_states(&prepared, &outcome);
    let rough = case_of(text, "1e-8");
    let serial = if case.steps.is_empty() { serial_cycles(&rough) } else { 0 };
    for &size in sizes {
        let summary = on_ranks(&case, size).1;
        assert!(!summary.found_by_first());
        states_agree(&summary.answer.couplings, &expected, 1e-7);
        for (step, expected) in summary.steps.iter().zip(&outcome.steps) {
            states_agree(&step.answer.couplings, &expected.answer.couplings, 1e-6);
        }
        if case.steps.is_empty() {
            let cycles = on_ranks(&rough, size).1.answer.counts.cycles;
            // On so few nodes most of them are beside those that the coupling joins, which are those of one rank.
            assert!(cycles as f64 <= 1.5 * serial as f64, "{cycles} cycles on {size} ranks, {serial} on one");
            assert!(size > 1 || cycles == serial, "{cycles} {serial}");
        }
    }
}

/// Pressed and turned at a point above it.
#[test]
fn a_block_that_a_rigid_coupling_presses_and_turns_is_the_same_on_ranks() {
    let coupling = "[[coupling]]\nname = \"grip\"\non = \"z-max\"\npoint = [1.1, 0.8, 2]\nforce = [8e4, 2e4, -1e6]\nmoment = [1e4, -2e4, 5e4]\n";
    for element in ["hex8", "tet4"] {
        agrees(&block([12, 9, 6], element, "0.4", coupling), &[1, 2, 3, 4]);
    }
    // Nothing else holds it; here an end does.
    let held = coupling.replace("\"z-max\"", "{ box = [[1, 0, 1], [2, 1.5, 1]] }") + "[[fix]]\non = \"x-min\"\n";
    agrees(&block([12, 9, 6], "hex8", "0.4", &held), &[2, 4]);
    agrees(&block([12, 9, 6], "hex8", "0.4", &(held + "components = \"x\"\n")), &[3]);
}

#[test]
fn a_prescribed_motion_in_load_steps_is_the_same_on_ranks() {
    let coupling = "[[coupling]]\non = \"z-max\"\npoint = [1, 0.75, 1]\nmotion = { x = \"1e-6*t^2\", z = \"-1e-5*min(t, 1)\" }\n\
                    rotation = { z = \"1e-6*max(t - 1, 0)\" }\nforce = [0, \"1e5*t\", 0]\n";
    let steps = "[[step]]\nname = \"press\"\nuntil = 1\n[[step]]\nname = \"turn\"\nuntil = 2\nincrements = 2\n";
    agrees(&block([12, 9, 6], "hex8", "0.3", &format!("{coupling}{steps}")), &[2, 3, 4]);
}

#[test]
fn a_distributing_coupling_is_the_same_on_ranks() {
    let coupling = |more: &str| {
        let fix = "[[fix]]\non = \"x-min\"\ncomponents = \"xy\"\n";
        format!(
            "{fix}[[coupling]]\non = {{ box = [[0.5, 0, 1], [2, 1.5, 1]] }}\nkind = \"distributing\"\npoint = [1.3, 0.8, 1]\n{more}"
        )
    };
    let forced = "force = [8e4, 2e4, -1e6]\nmoment = [0, 5e4, 4e4]\n";
    agrees(&block([12, 9, 6], "hex8", "0.3", &coupling(forced)), &[2, 3, 4]);
    let turned = "motion = { z = -1e-5 }\nrotation = { x = 2e-6, y = 0 }\nforce = [8e4, 0, 0]\n";
    agrees(&block([12, 9, 6], "hex8", "0.3", &coupling(turned)), &[1, 2, 3, 4]);
}

/// Lifted by the mean of its top a block hangs on one equation: along the five motions that this leaves it stays where it was, on any number
/// of ranks.
#[test]
fn a_block_that_hangs_on_one_equation_stays_where_it_was() {
    let mean = |name: &str, rest: &str| {
        format!(
            "[[coupling]]\nname = \"{name}\"\non = \"z-max\"\nkind = \"distributing\"\npoint = [1, 0.75, 1]\n{rest}"
        )
    };
    let lifted = mean("press", "motion = { x = \"4e-6*t\", z = \"-1e-5*t\" }\nuntil = \"press\"\n")
        + &mean("lift", "motion = { z = \"1e-4*(t-1)\" }\nfrom = \"lift\"\nuntil = \"lift\"\n")
        + &mean("again", "motion = { x = \"1e-5*(t-2)\", z = \"-2e-4*(t-2)\" }\nfrom = \"again\"\n")
        + "[[step]]\nname = \"press\"\nuntil = 1\n[[step]]\nname = \"lift\"\nuntil = 2\n[[step]]\nname = \"again\"\nuntil = 3\n";
    let text = block([12, 9, 6], "hex8", "0.3", &lifted);
    let case = case_of(&text, "1e-10");
    let (outcome, _) = solved_case(&case);
    for size in [1, 2, 3] {
        let steps = on_ranks(&case, size).1.steps;
        for (step, expected) in steps.iter().zip(&outcome.steps) {
            for (a, b) in step.answer.couplings.iter().zip(&expected.answer.couplings) {
                let [a, b] = [a, b].map(|state| [state.displacement, state.rotation].concat());
                assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 1e-12), "{size} ranks: {a:?} {b:?}");
            }
        }
        assert!(steps[1].answer.contact.normal_force == 0.0 && steps[2].answer.contact.normal_force > 1.0);
        let motions: Vec<_> = steps.iter().map(|step| step.answer.adrift.as_ref().map(|it| it.motions)).collect();
        assert_eq!(motions, [None, Some(5), None], "{size} ranks");
    }
}

/// The nodes of the top, as regions of one node each.
fn top(cells: [usize; 3]) -> Vec<String> {
    let of = |k: usize| (k % (cells[0] + 1), k / (cells[0] + 1));
    let place = |(i, j): (usize, usize)| {
        let at = |k: usize, cells: usize, size: f64| size * k as f64 / cells as f64;
        format!("{{ point = [{}, {}, 1] }}", at(i, cells[0], 2.0), at(j, cells[1], 1.5))
    };
    (0..(cells[0] + 1) * (cells[1] + 1)).map(|k| place(of(k))).collect()
}

/// The displacements of all nodes of a list along z are the same; `fan` measures them from the first, a chain each from the one before.
fn level(nodes: &[String], fan: bool) -> String {
    let pair = |k: usize| (&nodes[k], &nodes[if fan { 0 } else { k - 1 }]);
    let equation = |(a, b): (&String, &String)| {
        format!("[[equation]]\nterms = [{{ on = {a}, along = \"z\" }}, {{ on = {b}, along = \"z\", factor = -1 }}]\n")
    };
    (1..nodes.len()).map(pair).map(equation).collect()
}

#[test]
fn equations_that_keep_a_top_level_are_the_same_on_ranks() {
    let load =
        "[[fix]]\non = \"x-min\"\ncomponents = \"y\"\n[[load]]\non = \"z-max\"\ntraction = [1e5, 0, \"-1e6*x\"]\n";
    let cells = [8, 6, 4];
    for fan in [true, false] {
        agrees(&block(cells, "hex8", "0.4", &(load.to_string() + &level(&top(cells), fan))), &[2, 3, 4]);
    }
    // One that the sum over all nodes of a face keeps.
    let sum = "[[equation]]\nterms = [{ on = \"x-max\", along = [1, 0, 0.5] }]\nvalue = \"1e-4*t\"\n";
    let steps = "[[step]]\nuntil = 1\nincrements = 2\n";
    let inside = block(cells, "hex8", "0.4", &(load.to_string() + sum))
        .replace("\"z-min\"", "{ box = [[0, 0, 0], [1.75, 1.5, 0]] }");
    agrees(&inside, &[3]);
    agrees(&(inside + steps), &[4]);
}

/// Two blocks side by side on a floor, one beside the other, with meshes of their own.
fn two_blocks(element: &str, rest: &str) -> String {
    let cells = if element == "tet10" { ["[4, 3, 3]", "[3, 4, 3]"] } else { ["[8, 6, 6]", "[6, 8, 5]"] };
    format!(
        "[mesh.parts.a]\nblock = {{ size = [1, 1, 1], cells = {}, element = \"{element}\" }}\n\
         [mesh.parts.b]\nblock = {{ size = [1.2, 1.2, 0.8], cells = {}, element = \"{element}\" }}\nmove = [-0.1, -0.1, -0.8]\n{STEEL}\
         [[fix]]\non = \"b.z-min\"\n[[contact]]\non = \"a.z-min\"\nagainst = \"b.z-max\"\nfriction = {{ coulomb = 0.4 }}\n{rest}",
        cells[0], cells[1]
    )
}

#[test]
fn an_equation_that_joins_two_bodies_is_the_same_on_ranks() {
    let rest = "[[load]]\non = \"a.z-max\"\ntraction = [1e5, 0, -2e6]\n\
                [[equation]]\nterms = [{ on = \"a.x-max\", along = \"y\" }, { on = { box = [[-0.1, -0.1, -0.7], [-0.1, 1.1, -0.3]] }, along = \"x\", factor = -2 }]\n\
                value = 1e-6\n";
    let text = two_blocks("hex8", rest);
    agrees(&text.replace("\"a.x-max\"", "{ box = [[1, 0, 0.3], [1, 1, 1]] }"), &[2, 3, 4]);
    // With nodes that are measured from those they touch, which may be another rank's.
    agrees(&text, &[1, 2, 3, 4]);
}

#[test]
fn a_coupling_on_one_of_two_bodies_is_the_same_on_ranks() {
    let coupling =
        "[[coupling]]\non = \"a.z-max\"\npoint = [0.6, 0.5, 1.5]\nforce = [1e5, 0, -1e6]\nmoment = [0, 0, 2e4]\n";
    for element in ["hex8", "tet10"] {
        agrees(&two_blocks(element, coupling), &[2, 4]);
        agrees(
            &two_blocks(element, &(coupling.to_string() + "kind = \"distributing\"\nmotion = { z = -1e-5 }\n"))
                .replace("-1e6]", "0]"),
            &[3],
        );
    }
}

#[test]
fn couplings_that_share_nodes_are_the_same_on_ranks() {
    let two = "[[coupling]]\nname = \"a\"\non = \"z-max\"\npoint = [1.1, 0.8, 2]\nforce = [0, 0, -1e6]\ncomponents = \"z\"\n\
               [[coupling]]\nname = \"b\"\non = { box = [[2, 0, 0.5], [2, 1.5, 1]] }\npoint = [2, 0.75, 0.75]\nforce = [1e5, 0, 0]\nkind = \"distributing\"\n\
               motion = { y = 1e-6 }\n";
    agrees(&block([12, 9, 6], "hex8", "0.4", two), &[1, 2, 3, 4]);
    // Of those that prescribe means none follows from another.
    let means =
        two.replace("force = [0, 0, -1e6]\ncomponents = \"z\"", "motion = { z = -1e-5 }\nkind = \"distributing\"");
    agrees(&block([12, 9, 6], "hex8", "0.4", &means), &[1, 2, 3, 4]);
    // As two rigid bodies with common nodes each follows the other.
    let rigid = block([12, 9, 6], "hex8", "0.4", &two.replace("kind = \"distributing\"\n", ""));
    let error = refusal(&case_of(&rigid, "1e-8"), 3, None);
    assert!(error.what.contains("follow from the other") && error.excerpt.contains("[[coupling]]"), "{error}");
}

/// One rank has the nodes of all but the floor and what is inside.
#[test]
fn a_coupling_over_most_of_the_boundary_is_the_same_on_ranks() {
    let coupling = "[[coupling]]\non = [\"x-min\", \"x-max\", \"y-min\", \"y-max\", \"z-max\"]\npoint = [1.1, 0.8, 2]\n\
                    force = [8e4, 2e4, -1e6]\nmoment = [1e4, -2e4, 5e4]\n";
    let text = block([12, 9, 8], "hex8", "0.4", coupling)
        .replace("on = \"z-min\"", "on = { box = [[0.3, 0.3, 0], [1.7, 1.3, 0]] }");
    agrees(&text, &[2, 3, 4]);
}

#[test]
fn what_contradicts_or_repeats_is_the_same_error_on_all_ranks() {
    let coupling = |x: &str| {
        format!("[[coupling]]\nname = {x:?}\non = \"z-max\"\npoint = [1, 0.75, 1]\nmotion = {{ x = \"{x}\" }}\n")
    };
    let steps = "[[step]]\nuntil = 1\nincrements = 2\n";
    let terms = "[[equation]]\nterms = [{ on = \"x-max\", along = \"y\" }]\n";
    for more in [
        coupling("0") + &coupling("1e-6*t") + steps,
        coupling("0") + "[[fix]]\non = \"z-max\"\ncomponents = \"x\"\nvalue = 1e-6\n",
        terms.repeat(2),
        coupling("0").replace("motion = { x = \"0\" }", "force = [\"1/(t - 0.5)\", 0, 0]") + steps,
        coupling("0").replace("\"z-max\"", "{ point = [0, 0, 1] }").replace("motion = { x", "rotation = { x"),
    ] {
        let case = case_of(&block([6, 4, 3], "hex8", "0.4", &more), "1e-8");
        let expected = prepare(&case).map(|_| ()).unwrap_err();
        assert_eq!(refusal(&case, 3, None), expected, "{more}");
    }
}

/// Multigrid wants a node for each point; on one machine there is the factor.
#[test]
fn ties_that_share_nodes_with_contacts_or_change_with_a_step_are_refused_at_their_line() {
    let at_contact = "[[coupling]]\non = \"x-max\"\npoint = [2, 0, 0]\nforce = [1e5, 0, 0]\n";
    let in_time = "[[coupling]]\non = \"z-max\"\npoint = [2, 0, 0]\nforce = [0, 0, -1e5]\nmotion = { x = 0 }\nfrom = \"b\"\n\
                   [[step]]\nname = \"a\"\nuntil = 1\n[[step]]\nname = \"b\"\nuntil = 2\n";
    for more in [at_contact, in_time] {
        let error = refusal(&case_of(&block([6, 4, 3], "hex8", "0.4", more), "1e-8"), 3, None);
        assert!(error.what.contains("a coupling") && error.remedy.contains("stiction solve"), "{error}");
        assert!(error.excerpt.contains("[[coupling]]"), "{error}");
    }
}

/// Pressed, turned in the mean, and let go; supports that begin with a step are ties as well.
fn stepped() -> String {
    let rest = "[[coupling]]\nname = \"turn\"\non = { box = [[0.5, 0, 1], [2, 1.5, 1]] }\nkind = \"distributing\"\npoint = [1, 0.75, 1]\n\
                force = [\"4e4*t\", 0, \"-1e6*min(t, 1)\"]\nrotation = { z = \"4e-6*t\" }\nuntil = \"turn\"\n\
                [[coupling]]\nname = \"end\"\non = { box = [[2, 0, 0.3], [2, 1.5, 0.9]] }\npoint = [2, 0.75, 0.5]\nforce = [0, \"1e4*t\", 0]\n\
                [[fix]]\non = { box = [[0, 0, 0.3], [0, 1.5, 0.9]] }\ncomponents = \"y\"\ncondition = \"as-it-stands\"\nfrom = \"turn\"\n\
                [[step]]\nname = \"press\"\nuntil = 1\nincrements = 2\n[[step]]\nname = \"turn\"\nuntil = 2\nincrements = 2\n\
                [[step]]\nname = \"rest\"\nuntil = 3\n";
    block([12, 9, 6], "hex8", "0.3", rest)
}

#[test]
fn couplings_in_load_steps_go_on_on_other_ranks() {
    agrees(&stepped(), &[1, 2, 4]);
    let case = case_of(&stepped(), "1e-10");
    let whole = folder("couplings");
    let expected = solved(&case, 3, &whole, false);
    passes(&whole);
    for size in [3, 2] {
        let part = folder(&format!("couplings-{size}"));
        killed_when(&case, 3, &part, false, &|_| part.join("step-0003-0000.npz").exists());
        let found = solved(&case, size, &part, true);
        passes(&part);
        assert_eq!(found.steps.len(), expected.steps.len());
        for (a, b) in found.steps.iter().zip(&expected.steps) {
            states_agree(&a.answer.couplings, &b.answer.couplings, 1e-7);
        }
        assert!(size != 3 || without_costs(&found.steps) == without_costs(&expected.steps));
    }
}

#[test]
fn ranks_take_hardly_more_cycles_with_a_coupling() {
    let coupling =
        "[[coupling]]\non = \"z-max\"\npoint = [1.1, 0.8, 2]\nforce = [8e4, 2e4, -1e6]\nmoment = [1e4, -2e4, 5e4]\n";
    for element in ["tet4", "hex8"] {
        let case = case_of(&block([24, 18, 12], element, "0.4", coupling), "1e-8");
        let serial = serial_cycles(&case);
        for size in [1, 2, 4, 8] {
            let cycles = on_ranks(&case, size).1.answer.counts.cycles;
            let most = (serial + 2).max(serial * 115 / 100);
            assert!(cycles <= most, "{element}: {cycles} cycles on {size} ranks, {serial} on one");
            assert!(size > 1 || cycles == serial, "{cycles} {serial}");
        }
    }
}
