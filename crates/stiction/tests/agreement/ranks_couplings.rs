//! Couplings and linear equations on several ranks, against the same case on one: all nodes that they join are those of one rank.

use stiction::io::case::{self, Case};
use stiction::run::{CouplingState, coupling_states, prepare};
use stiction_fixtures::case_run::solved_case;

use super::ranks::{agrees_case, case_of, on_ranks, refusal, serial_cycles};
use super::ranks_files::{folder, killed_when, passes, solved};

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

/// Displacements, resultants, motions of reference points and what acts there, of every step; the cycles hardly grow.
fn agrees(text: &str, sizes: &[usize]) {
    let case = case_of(text, "1e-10");
    agrees_case(&case, sizes);
    let (outcome, prepared) = solved_case(&case);
    let expected = coupling_states(&prepared, &outcome);
    let rough = case_of(text, "1e-8");
    let serial = if case.steps.is_empty() { serial_cycles(&prepare(&rough).unwrap()) } else { 0 };
    for &size in sizes {
        let summary = on_ranks(&case, size).1;
        assert!(!summary.found_by_first);
        states_agree(&summary.couplings, &expected, 1e-7);
        for (step, expected) in summary.steps.iter().zip(&outcome.steps) {
            states_agree(&step.couplings, &expected.answer.couplings, 1e-6);
        }
        if case.steps.is_empty() {
            let cycles = on_ranks(&rough, size).1.counts.iterations;
            let most = (serial + 2).max(serial * 115 / 100);
            println!("{size} ranks: {cycles} cycles, {serial} on one");
            assert!(cycles <= most, "{cycles} cycles on {size} ranks, {serial} on one");
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
        format!("{fix}[[coupling]]\non = {{ box = [[0.5, 0, 1], [2, 1.5, 1]] }}\nkind = \"distributing\"\npoint = [1.3, 0.8, 1]\n{more}")
    };
    let forced = "force = [8e4, 2e4, -1e6]\nmoment = [0, 5e4, 4e4]\n";
    agrees(&block([12, 9, 6], "hex8", "0.3", &coupling(forced)), &[2, 3, 4]);
    let turned = "motion = { z = -1e-5 }\nrotation = { x = 2e-6, y = 0 }\nforce = [8e4, 0, 0]\n";
    agrees(&block([12, 9, 6], "hex8", "0.3", &coupling(turned)), &[2, 3, 4]);
}
