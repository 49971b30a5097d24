//! How far an answer leaves the linear theory, on deformations that are known.

use stiction::run::{self, Outcome, Prepared, Smallness};
use stiction_fixtures::case_run::*;

const MATERIAL: &str = "[materials.m]\nyoung = 1000\npoisson = 0.3\n";
const ELEMENTS: [&str; 4] = ["element = \"hex8\"", "element = \"tet4\"", "element = \"tet10\"", "element = \"hex20\""];

fn measured(run: &(Outcome, Prepared)) -> Smallness {
    run.0.smallness.clone().unwrap()
}

/// The warnings of the report about what is not small.
fn warnings(run: &(Outcome, Prepared)) -> Vec<String> {
    let rows = run::report(&run.1, &run.0).rows;
    let left = rows.into_iter().filter(|row| row.label == "warning" && row.value.contains("linear theory"));
    left.map(|row| row.value).collect()
}

#[test]
fn a_bar_pulled_by_a_known_strain_has_that_strain_and_no_rotation() {
    for element in ELEMENTS {
        for (strain, small) in [(0.04, true), (0.06, false), (-0.06, false)] {
            let pull = format!("[[fix]]\non = \"x-max\"\ncomponents = \"x\"\nvalue = [{}]\n", 4.0 * strain);
            let text = format!("{}{MATERIAL}{CORNER}{pull}", block([4.0, 1.0, 1.0], [4, 2, 2], element));
            let run = solved(&text);
            let of = measured(&run);
            is(of.strain, f64::abs(strain), strain);
            is(of.rotation, 0.0, 1.0);
            is(of.strain_volume, if small { 0.0 } else { 1.0 }, 1.0);
            assert_eq!((of.small, of.slip, of.slip_pair.clone()), (small, 0.0, None), "{of:?}");
            let warnings = warnings(&run);
            assert_eq!(warnings.len(), usize::from(!small), "{warnings:?}");
            assert!(small || warnings[0].contains("strain of 6.0 % at"), "{warnings:?}");
        }
    }
}

#[test]
fn a_rigid_rotation_of_the_supports_is_measured_by_its_angle() {
    for element in ELEMENTS {
        for (degrees, small) in [(4.0f64, true), (6.0, false), (120.0, false)] {
            let (c, s) = (degrees.to_radians().cos() - 1.0, degrees.to_radians().sin());
            let value = format!("[\"{c} * x - {s} * y\", \"{s} * x + {c} * y\", 0]");
            let sides = "[\"x-min\", \"x-max\", \"y-min\", \"y-max\", \"z-min\", \"z-max\"]";
            let fix = format!("[[fix]]\non = {sides}\nvalue = {value}\n");
            let run = solved(&format!("{}{MATERIAL}{fix}", block([2.0, 1.0, 1.0], [3, 3, 3], element)));
            let of = measured(&run);
            is(of.rotation, degrees, degrees);
            is(of.rotation_volume, if small { 0.0 } else { 1.0 }, 1.0);
            // What the linear theory takes a rotation for.
            // Twice the same principal value: its digits are half of those there are.
            assert!((of.strain + c).abs() <= 1e-7, "{of:?}");
            assert_eq!(of.small, small, "{of:?}");
            let warnings = warnings(&run);
            assert_eq!(warnings.iter().any(|w| w.contains(&format!("rotation of {degrees} degrees"))), !small);
        }
    }
}

/// A block on another one, or on a plane, pressed and shifted by `shift` without friction: all of it slides by that.
fn shifted(shift: &str, against: &str, more: &str) -> (Outcome, Prepared) {
    let blocks = "[mesh.parts.a]\nblock = { size = [10, 10, 10], cells = [2, 2, 2], element = \"hex8\" }\n\
        [mesh.parts.b]\nblock = { size = [10, 10, 10], cells = [5, 5, 3], element = \"hex8\", origin = [0, 0, 10] }\n";
    let fixes = format!(
        "[[fix]]\non = \"a.z-min\"\n[[fix]]\non = \"b.z-max\"\nvalue = [{shift}, 0, -0.01]\n\
         [[contact]]\non = \"b.z-min\"\nagainst = {against}\nfriction = \"none\"\n"
    );
    let material = "[materials.m]\nyoung = 1000\npoisson = 0\n";
    solved(&format!("{blocks}{material}{fixes}{more}"))
}

#[test]
fn a_block_that_slides_by_a_known_slip_is_measured_over_its_smaller_faces() {
    // The smaller faces are 2 wide.
    for (shift, small) in [(0.3, true), (0.5, false)] {
        let steps = "[[step]]\nuntil = 1\nincrements = 2\n";
        let at_once = shifted(&shift.to_string(), "\"a.z-max\"", "");
        let in_steps = shifted(&format!("\"{shift} * t\""), "\"a.z-max\"", steps);
        for run in [at_once, in_steps] {
            let of = measured(&run);
            is(of.slip, shift, 1.0);
            is(of.slip_over_face, shift / 2.0, 1.0);
            assert_eq!(of.small, small, "{of:?}");
            let warnings = warnings(&run);
            assert_eq!(warnings.iter().any(|w| w.contains("slides by 25 % of a face")), !small, "{warnings:?}");
        }
    }
}

#[test]
fn a_slide_along_a_plane_is_no_departure_from_the_theory() {
    let run = shifted("3", "{ plane = { point = [0, 0, 10], normal = [0, 0, 1] } }", "");
    let of = measured(&run);
    is(of.slip, 3.0, 1.0);
    assert!(of.small && of.slip_over_face == 0.0, "{of:?}");
    assert_eq!(warnings(&run), [""; 0]);
}

/// What a load step leaves the theory by is said though the last one is small again.
#[test]
fn the_warning_names_the_load_step_in_which_a_limit_is_exceeded() {
    let pull = "[[fix]]\non = \"x-max\"\ncomponents = \"x\"\nvalue = [\"0.08 * t * (2 - t)\"]\n[[step]]\nuntil = 2\nincrements = 2\n";
    let text = format!("{}{MATERIAL}{CORNER}{pull}", block([1.0; 3], [2; 3], ELEMENTS[0]));
    let run = solved(&text);
    assert!(measured(&run).small);
    let warnings = warnings(&run);
    assert!(
        warnings.len() == 1 && warnings[0].contains("strain of 8.0 %") && warnings[0].contains("t = 1"),
        "{warnings:?}"
    );
}
