//! Refinement on several ranks against the same case on one.

use std::path::{Path, PathBuf};

use super::*;
use crate::fem::Field;
use crate::io::case;
use crate::io::folder;
use crate::ranks::threads;
use crate::run::ranks::{ForPeople, check, write_on_ranks};
use crate::run::results::Origin;
use crate::run::whole::solve_case;

const STEEL: &str = "[materials.steel]\nyoung = 21.19e10\npoisson = 0.277\nexpansion = 12e-6\n";

fn case_of(text: &str) -> Case {
    let set = [("solver.tolerance".to_string(), "1e-10".to_string())];
    case::parse(text, "case.toml", &set).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The brick, pressed at one end and lifted at the other.
fn brick(accuracy: &str) -> Case {
    case_of(&format!(
        "[mesh]\nblock = {{ size = [3, 1, 1], cells = [6, 2, 2], element = \"hex8\" }}\n{STEEL}\
         [[fix]]\non = \"x-min\"\n[[load]]\non = \"x-max\"\ntraction = [0, 0, 1e6]\n\
         [[load]]\non = \"z-max\"\ntraction = [0, 0, \"-2/3*1e6*(3 - x)\"]\n\
         [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {{ coulomb = 0.35 }}\n[accuracy]\n{accuracy}\n"
    ))
}

/// A block on a softer one, which is warm and drawn together as bolts are, with a plane of symmetry and an obstacle that moves against
/// its side.
fn blocks(accuracy: &str) -> Case {
    case_of(&format!(
        "[mesh.parts.a]\nblock = {{ size = [1, 0.5, 0.5], cells = [3, 2, 2], element = \"hex8\" }}\nmove = [0.2, 0, 1]\n\
         [mesh.parts.b]\nblock = {{ size = [1.5, 0.6, 1], cells = [4, 2, 3], element = \"hex8\" }}\n{STEEL}\
         on = \"a\"\n[materials.soft]\nyoung = 7e10\npoisson = 0.3\nexpansion = 1e-5\non = \"b\"\n\
         [[fix]]\non = \"b.z-min\"\n[[fix]]\non = \"a.z-max\"\nvalue = [4e-5, 0, -1e-4]\n\
         [[fix]]\non = [\"a.y-min\", \"b.y-min\"]\ncondition = \"symmetry\"\n\
         [[load]]\non = \"b\"\ntemperature = 20\n[[bolt]]\non = \"b\"\naxis = [0, 0, 1]\nshortening = 2e-5\n\
         [[contact]]\nname = \"blocks\"\non = \"a.z-min\"\nagainst = \"b.z-max\"\nfriction = {{ coulomb = 0.3 }}\n\
         [[contact]]\nname = \"wall\"\non = {{ box = [[1.5, 0, 0.4], [1.5, 0.6, 1]] }}\nfriction = \"none\"\n\
         against = {{ plane = {{ point = [1.5, 0, 0], normal = [-1, 0, 0] }}, motion = [-1e-5, 0, 0] }}\n[accuracy]\n{accuracy}\n"
    ))
}

/// A block that a reference point presses and turns.
fn led(accuracy: &str) -> Case {
    case_of(&format!(
        "[mesh]\nblock = {{ size = [3, 1, 1], cells = [6, 2, 2], element = \"hex8\" }}\n{STEEL}\
         [[fix]]\non = \"x-min\"\n[[coupling]]\non = {{ box = [[1, 0, 1], [3, 1, 1]] }}\nkind = \"distributing\"\npoint = [2, 0.5, 1]\n\
         motion = {{ z = -1e-6 }}\nforce = [1e5, 5e4, 0]\nmoment = [1e5, 0, 0]\n\
         [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {{ coulomb = 0.35 }}\n[accuracy]\n{accuracy}\n"
    ))
}

/// The bolted joint of `cases/joint` with its load steps.
fn bolted(accuracy: &[(&str, &str)]) -> Case {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/joint/joint.toml");
    let set = [("solver.tolerance", "1e-10")];
    let set: Vec<(String, String)> = set.iter().chain(accuracy).map(|(k, v)| (k.to_string(), v.to_string())).collect();
    case::read(path, &set).unwrap_or_else(|error| panic!("{error}"))
}

fn empty(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("stiction-refine-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

/// On ranks, with the levels kept in a folder, where the answer is written and judged.
fn on_ranks(case: &Case, size: usize, most: usize, folder: &Path, resume: bool) -> Result<RankedAnswer, Error> {
    let keep = Keep { folder: folder.to_path_buf(), resume, tell: |_| {} };
    let accuracy = case.accuracy.unwrap();
    let mut all = threads(size, |ranks| {
        let mut found = refined((case, &accuracy), &ranks, Some(&keep), &mut |_| ControlFlow::Continue(()), most)?;
        write_on_ranks(&mut found, folder, &Origin::default(), ForPeople::default(), &*ranks)?;
        Ok(found)
    });
    let same = |found: &Result<RankedAnswer, Error>| match (found, &all[0]) {
        (Ok(found), Ok(first)) => found.summary.accuracy == first.summary.accuracy,
        (Err(found), Err(first)) => found == first,
        _ => false,
    };
    assert!(all.iter().all(same));
    if all[0].is_ok() {
        let checked = check(folder).unwrap_or_else(|error| panic!("{error}"));
        assert!(checked.passed(), "{:?} {:?}", checked.differences, checked.files);
    }
    all.swap_remove(0)
}

fn on_one(case: &Case, folder: &Path) -> (Sequence, AccuracyRecord) {
    let plan = Plan { folder: Some(folder), ..Plan::default() };
    let (_, outcome, _) = solve_case(case, &plan, &Stop::never(), None, &mut |_| ControlFlow::Continue(())).unwrap();
    (kept_levels(folder).unwrap().unwrap().1, outcome.accuracy.unwrap())
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-6 * b.abs()
}

/// The same levels, marks, errors, values and displacements, whichever levels rank 0 solves alone.
fn agrees(case: &Case, name: &str, sizes: &[usize], limits: &[usize]) {
    let (serial, record) = {
        let folder = empty(&format!("{name}-one"));
        on_one(case, &folder)
    };
    assert!(serial.levels.len() >= 3, "{record:?}");
    for (&size, &most) in sizes.iter().flat_map(|size| limits.iter().map(move |most| (size, most))) {
        let at = format!("{name}, {size} ranks, alone up to {most}");
        let folder = empty(&format!("{name}-{size}-{most}"));
        let answer = on_ranks(case, size, most, &folder, false).unwrap_or_else(|error| panic!("{at}: {error}"));
        let found = kept_levels(&folder).unwrap().unwrap().1;
        assert_eq!(found.marked, serial.marked, "{at}");
        assert_eq!(found.levels.len(), serial.levels.len(), "{at}");
        for (a, b) in found.levels.iter().zip(&serial.levels) {
            assert_eq!((a.cells, a.unknowns, a.points), (b.cells, b.unknowns, b.points), "{at}");
            assert!(close(a.error, b.error), "{at}: {} {}", a.error, b.error);
            for ((name, a), (other, b)) in a.values.0.iter().zip(&b.values.0) {
                assert!(name == other && close(*a, *b), "{at}: {name} {a} {b}");
            }
        }
        let largest = serial.displacement.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let apart = |(a, b): (&f64, &f64)| (a - b).abs();
        let worst = found.displacement.iter().zip(&serial.displacement).map(apart).fold(0.0, f64::max);
        assert!(found.displacement.len() == serial.displacement.len() && worst <= 1e-6 * largest, "{at}: {worst:e}");
        let summary = &answer.summary;
        let reached = summary.accuracy.as_ref().unwrap();
        assert_eq!((reached.reached, &reached.ended), (record.reached, &record.ended), "{at}");
        assert!(summary.answer.status == Status::Solved && summary.answer.certificate.passed, "{at}: {summary}");
        // That of a level is the largest of all load steps.
        let (error, largest_error) =
            (summary.answer.discretisation_error.unwrap(), serial.levels.last().unwrap().error);
        assert!(close(error, largest_error) || !case.steps.is_empty() && error < largest_error, "{at}: {error}");
        let worst = answer.displacements().iter().fold(0.0, |worst: f64, (node, u)| {
            (0..3).map(|c| (u[c] - serial.displacement[3 * *node as usize + c]).abs()).fold(worst, f64::max)
        });
        assert!(worst <= 1e-6 * largest, "{at}: {worst:e}");
        let text = summary.to_string();
        assert!(text.contains("accuracy") && text.contains("within"), "{text}");
        assert_eq!(summary.found_by_first(), most == usize::MAX && case.steps.is_empty(), "{at}");
        let cells = folder::read_text(&folder.join("result.pvtu")).unwrap();
        assert!(cells.contains("\"error\""), "{cells}");
    }
}

#[test]
fn the_brick_is_refined_on_ranks_as_on_one() {
    agrees(&brick("energy = \"6%\""), "brick", &[2, 3], &[0, 2000, usize::MAX]);
}

#[test]
fn two_bodies_are_refined_on_ranks_as_on_one() {
    agrees(&blocks("energy = \"12%\"\nforces = \"20%\""), "blocks", &[2], &[0, 3000]);
}

#[test]
fn a_block_led_at_a_point_is_refined_on_ranks_as_on_one() {
    agrees(&led("energy = \"12%\""), "led", &[2], &[0, 2000, usize::MAX]);
}

#[test]
fn a_bolted_joint_is_refined_on_ranks_as_on_one() {
    agrees(&bolted(&[("accuracy.energy", "30%")]), "bolted", &[3], &[0]);
}

#[test]
fn a_bolted_joint_is_refined_by_rank_0_alone_as_on_one() {
    agrees(&bolted(&[("accuracy.energy", "30%")]), "bolted-alone", &[3], &[usize::MAX]);
}

#[test]
fn levels_end_early_on_ranks_as_on_one() {
    agrees(&brick("energy = \"1%\"\nmax_unknowns = 4000"), "early", &[2], &[0, 2000]);
}

/// Of a run on three ranks that ends early another goes on on two; goals may change.
#[test]
fn levels_go_on_on_other_ranks() {
    for most in [0, 2000] {
        let [part, whole] = ["part", "whole"].map(|name| empty(&format!("resume-{most}-{name}")));
        let short = on_ranks(&brick("energy = \"6%\"\nmax_unknowns = 2500"), 3, most, &part, false).unwrap();
        let levels = kept_levels(&part).unwrap().unwrap().1.levels.len();
        assert!(!short.summary.accuracy.unwrap().reached && levels >= 1);
        let found = on_ranks(&brick("energy = \"6%\""), 2, most, &part, true).unwrap();
        let expected = on_ranks(&brick("energy = \"6%\""), 2, most, &whole, false).unwrap();
        let [found, expected] = [found, expected].map(|answer| answer.summary.accuracy.unwrap());
        assert!(found.reached && expected.reached && found.levels.len() > levels);
        assert_eq!(found.levels.len(), expected.levels.len());
        for (a, b) in found.levels.iter().zip(&expected.levels) {
            assert!((a.cells, a.unknowns) == (b.cells, b.unknowns) && close(a.error, b.error), "{a:?} {b:?}");
        }
        let other = blocks("energy = \"6%\"");
        let error = on_ranks(&other, 2, most, &part, true).map(|_| ()).unwrap_err();
        assert!(error.what.contains("another case"), "{error}");
    }
}

#[test]
fn an_error_on_a_level_is_that_of_all_ranks() {
    let mut case = brick("energy = \"6%\"");
    case.fixes[0].value[0] = Some(Field::Constant(100.0));
    for most in [0, usize::MAX] {
        let error = on_ranks(&case, 2, most, &empty("travel"), false).map(|_| ()).unwrap_err();
        assert!(error.what.contains("travel farther"), "{most}: {error}");
    }
    // A mesh that rank 0 has solved alone has to be divided for its files.
    let mut few = brick("energy = \"50%\"\nmax_unknowns = 100");
    if let MeshSource::Block(block) = &mut few.mesh.source {
        block.cells = [1; 3];
    }
    let error = on_ranks(&few, 40, usize::MAX, &empty("few"), false).map(|_| ()).unwrap_err();
    assert!(error.remedy.contains("fewer ranks"), "{error}");
}
