//! The estimate of the discretisation error on several ranks, beside that of the whole mesh.

use std::fs;
use std::ops::ControlFlow;

use stiction::run::{ForPeople, Settings, discretisation_error, prepare, solve, solve_steps};

use super::ranks::{case_of, on_ranks};
use super::ranks_bolts::joint;
use super::ranks_files::{folder, solved_for};

/// Two materials, one of them heated in its upper half, pressed together.
fn heated(element: &str) -> String {
    format!(
        "[mesh.parts.a]\nblock = {{ size = [2, 1, 1], cells = [8, 4, 4], element = \"{element}\" }}\n\
         [mesh.parts.b]\nblock = {{ size = [2.2, 1, 0.5], cells = [7, 4, 3], element = \"{element}\" }}\nmove = [0, 0, -0.5]\n\
         [materials.steel]\non = \"a\"\nyoung = 2e11\npoisson = 0.3\nexpansion = 1e-5\n\
         [materials.brass]\non = \"b\"\nyoung = 1e11\npoisson = 0.34\nexpansion = 2e-5\n\
         [[fix]]\non = \"b.z-min\"\n[[fix]]\non = \"a.x-min\"\ncomponents = \"xy\"\n\
         [[load]]\non = {{ box = [[0, 0, 0.5], [2, 1, 1]] }}\ntemperature = \"40*x\"\n\
         [[load]]\non = \"a.z-max\"\ntraction = [2e5, 0, \"-3e6*(2 - x)\"]\n\
         [[contact]]\non = \"a.z-min\"\nagainst = \"b.z-max\"\nfriction = {{ coulomb = 0.3 }}\n"
    )
}

/// On one rank it is the same; on three, polynomials at the boundary that need cells beyond those of a rank differ (`tet10`: 0.33 %).
#[test]
fn several_ranks_estimate_the_error_of_one_machine() {
    let of_heat = ["tet4", "hex8", "tet10", "hex20"].map(|element| (element, case_of(&heated(element), "1e-10")));
    for (name, case) in of_heat.into_iter().chain([("bolt", joint(&[]))]) {
        let mut prepared = prepare(&case).unwrap();
        let (settings, go_on) = (Settings::of(&case.solver), &mut |_: &_| ControlFlow::Continue(()));
        let outcome = match case.steps.is_empty() {
            true => solve(&prepared, &settings, go_on).unwrap(),
            false => solve_steps(&mut prepared, &settings, None, &mut |_, _| Ok(()), go_on).unwrap(),
        };
        let expected = discretisation_error(&prepared, &outcome.solution.u).relative();
        for (size, apart) in [(1, 1e-8), (3, 5e-3)] {
            let (_, summary) = on_ranks(&case, size);
            let found = summary.answer.discretisation_error.unwrap();
            assert!(
                expected > 0.01 && (found - expected).abs() <= apart * expected,
                "{name}: {found} {expected} on {size}"
            );
        }
    }
}

/// The picture of the error, the field of the cells and the printed line.
#[cfg(all(feature = "plots", feature = "report"))]
#[test]
fn the_error_is_shown() {
    let case = case_of(&heated("tet4"), "1e-10");
    let home = folder("error");
    let wanted = ForPeople { pictures: true, report: true };
    let summary = solved_for(wanted, &case, 3, &home, false);
    let printed = summary.to_string();
    assert!(printed.contains("the error of the stresses in the mean is estimated at"), "{printed}");
    assert!(fs::read(home.join("error.png")).unwrap().len() > 10_000);
    let piece = fs::read(home.join("result-0002.vtu")).unwrap();
    assert!(piece.windows(12).any(|text| text == b"Name=\"error\""));
}
