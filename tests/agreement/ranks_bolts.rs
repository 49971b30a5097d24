//! Bolts on several ranks against the same case on one: cuts and parts that are drawn together lie on several ranks.

use std::path::Path;

use super::ranks::{agrees_case, on_ranks};
use stiction::friction::Status;
use stiction::io::case::{self, Case};
use stiction_fixtures::case_run::solved_case;

/// The joint of `cases/pretension`, whose bolt and plate float, with some values changed.
pub(super) fn joint(set: &[(&str, &str)]) -> Case {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/pretension/pretension.toml");
    let fixed = [("solver.tolerance", "1e-10"), ("solver.path", "'multigrid'")];
    let set: Vec<(String, String)> = fixed.iter().chain(set).map(|(k, v)| (k.to_string(), v.to_string())).collect();
    case::read(path, &set).unwrap_or_else(|e| panic!("{e}"))
}

/// Force and shortening after each step, from the record of a serial run and of ranks.
pub(super) fn bolts_agree(case: &Case, sizes: &[usize], accuracy: f64) {
    let (outcome, _) = solved_case(case);
    let expected: Vec<[f64; 2]> =
        outcome.steps.iter().map(|s| [s.answer.bolts[0].force, s.answer.bolts[0].shortening]).collect();
    assert!(expected.len() > 1 && expected[0][0] > 0.0, "{expected:?}");
    for &size in sizes {
        let (_, summary) = on_ranks(case, size);
        assert_eq!(summary.steps.len(), expected.len());
        for (step, [force, shortening]) in summary.steps.iter().zip(&expected) {
            let found = &step.answer.bolts[0];
            assert!((found.force - force).abs() <= accuracy * expected[0][0], "{size} ranks: {found:?} {force}");
            assert!((found.shortening - shortening).abs() <= accuracy * shortening.abs(), "{found:?} {shortening}");
        }
        assert_eq!(summary.answer.bolts, summary.steps.last().unwrap().answer.bolts);
    }
}

#[test]
fn a_bolt_tightened_by_force_and_locked_is_the_same_on_ranks() {
    let case = joint(&[]);
    agrees_case(&case, &[1, 2, 3, 4]);
    bolts_agree(&case, &[1, 4], 1e-8);
}

/// The parts are drawn together as rigid ones before the bolt bears.
#[test]
fn a_clearance_is_closed_on_ranks() {
    let case = joint(&[("contact.1.gap", "3")]);
    // The parts move by a hundred times what the bolt is strained by.
    bolts_agree(&case, &[2, 3], 1e-7);
}

#[test]
fn a_bolt_by_its_shortening_is_the_same_on_ranks() {
    let bolt = "{ on = 'bolt', axis = [0, 0, 1], shortening = '0.03*min(t, 1)' }";
    let case = joint(&[("bolt.0", bolt)]);
    agrees_case(&case, &[2, 4]);
    bolts_agree(&case, &[3], 1e-8);
}

/// A column whose loose part a bolt holds, under a ceiling or free above: what the load has more than the bolt the ceiling bears, and where
/// nothing does there is no equilibrium (statics of the two parts).
fn column(load: f64, force: f64, has_ceiling: bool) -> Case {
    let ceiling = "[[contact]]\non = \"z-max\"\nfriction = \"none\"\n\
                   against = { plane = { point = [0, 0, 3], normal = [0, 0, -1] } }\n";
    let text = format!(
        "[mesh]\nblock = {{ size = [1, 1, 3], cells = [4, 4, 12], element = \"hex8\" }}\n\
         [materials.steel]\nyoung = 200e3\npoisson = 0.3\n[[fix]]\non = \"z-min\"\n\
         [[load]]\non = \"z-max\"\ntraction = [0, 0, {load}]\n\
         [[bolt]]\non = \"body\"\naxis = [0, 0, 1]\npoint = [0.5, 0.5, 1.6]\nforce = {force}\n{}",
        if has_ceiling { ceiling } else { "" }
    );
    case::parse(&text, "case.toml", &[]).unwrap()
}

#[test]
fn what_a_bolt_cannot_hold_has_no_equilibrium_on_ranks() {
    for size in [1, 2, 3] {
        for force in [4.0, 0.0] {
            let (_, summary) = on_ranks(&column(10.0, force, true), size);
            let pressed = summary.answer.contact.normal_force;
            assert_eq!(summary.answer.status, Status::Solved, "{size} ranks, {force}");
            assert!((pressed - 10.0 + force).abs() < 1e-5, "{size} ranks, {force}: {pressed}");
            assert!((summary.answer.bolts[0].force - force).abs() < 1e-5, "{size} ranks: {:?}", summary.answer.bolts);
        }
        for (load, force, has_ceiling, how) in
            [(10.0, 20.0, true, "they come together"), (10.0, 4.0, false, "they part")]
        {
            let (_, summary) = on_ranks(&column(load, force, has_ceiling), size);
            let told = summary.to_string();
            assert!(summary.answer.status == Status::NoEquilibrium && told.contains(how), "{size} ranks: {told}");
            assert_eq!(summary.answer.bolts[0].shortening, 0.0);
        }
    }
}
