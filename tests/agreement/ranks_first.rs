//! What a case asks for that rank 0 alone can do: the ranks judge its answers and write them, and the judge of files finds each.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::{fs, iter};

use stiction::io::case::{self, Case};
use stiction::ranks::threads;
use stiction::run::{check, solve_on_ranks};

use super::ranks_files::{folder, passes, solved};

/// Case `name` of those that are shipped, with further settings.
fn shipped(name: &str, set: &[(&str, &str)]) -> Case {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../cases/{name}/{name}.toml"));
    let set: Vec<(String, String)> = set.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect();
    case::read(&path, &set).unwrap()
}

/// The three solutions that the head of `cases/several/several.toml` derives: open, sticking with the pressure 1, slipping with the
/// pressure `1 - s l`, `s l = (F - q) / (F - k)`, `k² = (1 - ν) / ν`.
#[test]
fn ranks_write_all_solutions_that_rank_0_finds() {
    let case = shipped("several", &[]);
    let folder = folder("several");
    let summary = solved(&case, 3, &folder, false);
    assert!(summary.found_by_first() && summary.answer.certificate.passed);
    let found = summary.answer.solutions.as_ref().expect("further solutions were asked for");
    let mut forces: Vec<f64> = found.distinct.iter().map(|solution| solution.normal_force).collect();
    forces.sort_by(f64::total_cmp);
    let [open, slip, stick] = forces[..] else { panic!("{forces:?}") };
    let expected = 1.0 - (2.0 - 1.8) / (2.0 - (0.7f64 / 0.3).sqrt());
    assert!(open.abs() < 1e-9 * stick && (slip / stick - expected).abs() < 1e-7, "{forces:?}: {expected}");
    assert!(found.distinct.iter().all(|solution| solution.worst <= 1e-11), "{found:?}");
    assert!(summary.report.iter().any(|row| row.label == "solutions" && row.value.starts_with("3 from 8 starts")));
    passes(&folder);
    // A judge that did not look at the third solution would not miss it.
    let third = folder.join("solution-0003-0001.npz");
    let (second, whole) = (folder.join("solution-0002-0001.npz"), fs::read(&third).unwrap());
    fs::copy(&second, &third).unwrap();
    let checked = check(&folder).unwrap();
    assert!(
        checked.differences.iter().any(|(what, ..)| what == "worst measure of solution 3"),
        "{:?}",
        checked.differences
    );
    fs::remove_file(&third).unwrap();
    assert!(check(&folder).unwrap_err().to_string().contains("solution-0003-0001.npz"));
    fs::write(&third, whole).unwrap();
    passes(&folder);
    // A run that looks for none leaves none.
    solved(&shipped("several", &[("solver.starts", "1")]), 2, &folder, false);
    assert!(!second.exists() && !third.exists());
    passes(&folder);
}

/// A path that ranks do not have, against the path that they have.
#[test]
fn a_path_of_one_machine_is_that_of_rank_0() {
    let case = shipped("brick", &[("solver.path", "\"dense\""), ("mesh.block.cells", "[6, 2, 2]")]);
    let folder = folder("dense");
    let summary = solved(&case, 2, &folder, false);
    assert!(summary.found_by_first() && summary.answer.certificate.passed && summary.answer.solutions.is_none());
    passes(&folder);
    let multigrid = shipped("brick", &[("mesh.block.cells", "[6, 2, 2]"), ("solver.tolerance", "1e-10")]);
    let together =
        threads(2, |ranks| solve_on_ranks(&multigrid, &ranks, &mut |_| ControlFlow::Continue(())).unwrap().summary);
    assert!(!together[0].found_by_first());
    let force = |summary: &stiction::run::Summary| summary.answer.contact.normal_force;
    assert!((force(&summary) / force(&together[0]) - 1.0).abs() < 1e-7);
}

/// What rank 0 is too small for is refused at every rank, with what it takes.
#[test]
fn what_rank_0_alone_can_do_is_refused_on_large_meshes() {
    let large = ("mesh.block.cells", "[72, 24, 24]");
    for (set, what) in iter::zip(
        [("solver.starts", "3"), ("solver.path", "\"dense\""), ("solver.method", "\"msa1\"")],
        [
            "further solutions (solver.starts) with ",
            "multigrid (solver.path) with ",
            "the default one (solver.method) with ",
        ],
    ) {
        let case = shipped("brick", &[large, set]);
        for error in threads(2, |ranks| {
            solve_on_ranks(&case, &ranks, &mut |_| ControlFlow::Continue(())).err().expect("too large").to_string()
        }) {
            assert!(error.contains(what) && error.contains("takes 100000"), "{error}");
        }
    }
}
