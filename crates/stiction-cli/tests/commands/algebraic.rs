//! `stiction algebraic`.

use crate::folder::{CASE, Folder};
use stiction::discrete::{DiscreteProblem, LocalProblem};
use stiction::io::fclib_write::{State, write};
use stiction::linalg::Csr;

/// A point of unit compliance that meets the obstacle with velocity 1 and slides with `push`, friction 0.3.
fn point(compliance: f64, push: f64) -> DiscreteProblem {
    let w = [(0, 0, compliance), (1, 1, 1.0), (2, 2, 1.0)];
    DiscreteProblem::Local(LocalProblem {
        dimension: 3,
        W: Csr::from_triplets(3, 3, &w),
        q: vec![-1.0, push, 0.0],
        mu: vec![0.3],
        bilateral: None,
    })
}

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name, CASE);
    write(&folder.path.join("slip.hdf5"), &point(1.0, 2.0), None, &[]).unwrap();
    let lie = State { r: vec![0.0; 3], ..State::default() };
    write(&folder.path.join("stick.hdf5"), &point(1.0, 0.1), Some(&lie), &[]).unwrap();
    // Nothing stops this point: there is no solution.
    write(&folder.path.join("lost.hdf5"), &point(0.0, 0.1), None, &[]).unwrap();
    folder
}

#[test]
fn one_file_is_solved_judged_and_written() {
    let folder = folder("algebraic-one");
    let run = folder.run(&["algebraic", "slip.hdf5", "-o", "out"]);
    run.ends(0, &[]);
    for word in ["1 contacts in 3 dimensions", "solved", "by velocity", "by largest", "invariant", "bipotential gap"] {
        assert!(run.out.contains(word), "{word}: {}", run.out);
    }
    assert_eq!(folder.names_in("out"), ["slip.solution.hdf5", "slip.summary.json"]);
    // What was written is read again, and its solution is one: (1, -0.3, 0) by hand.
    let again = folder.run(&["algebraic", "out/slip.solution.hdf5"]);
    again.ends(0, &[]);
    assert!(again.out.contains("what the file calls a solution is one"), "{}", again.out);
    let r = stiction::io::fclib::read(&folder.path.join("out/slip.solution.hdf5")).unwrap().solution.unwrap();
    assert!(r.iter().zip([1.0, -0.3, 0.0]).all(|(a, b)| (a - b).abs() < 1e-7), "{r:?}");
    let text = std::fs::read_to_string(folder.path.join("out/slip.summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(summary["status"], "solved");
    assert!(summary["certificate"]["by_velocity"].as_f64().unwrap() <= 1e-8);
}

#[test]
fn many_files_make_a_table_and_the_worst_decides() {
    let folder = folder("algebraic-many");
    let run = folder.run(&["algebraic", "slip.hdf5", "stick.hdf5"]);
    run.ends(0, &[]);
    assert_eq!(run.out.lines().count(), 3, "{}", run.out);
    assert!(run.out.lines().skip(1).all(|line| line.ends_with("solved")));
    let run = folder.run(&["algebraic", "lost.hdf5", "slip.hdf5", "-o", "out"]);
    run.ends(1, &[]);
    assert!(run.out.contains("max iterations") && run.out.contains("solved"), "{}", run.out);
    assert_eq!(folder.names_in("out").len(), 4);
    let run = folder.run(&["algebraic", "case.toml", "slip.hdf5"]);
    run.ends(2, &["case.toml", "HDF5"]);
    assert!(run.out.contains("solved"));
}

#[test]
fn a_claimed_solution_is_reported_and_not_trusted() {
    let run = folder("algebraic-claim").run(&["algebraic", "stick.hdf5"]);
    run.ends(0, &[]);
    assert!(run.out.contains("what the file calls a solution is none"), "{}", run.out);
}

#[test]
fn what_cannot_be_used_ends_with_two_and_writes_nothing() {
    let folder = folder("algebraic-bad");
    folder.run(&["algebraic", "none.hdf5", "-o", "out"]).ends(2, &["none.hdf5"]);
    folder.run(&["algebraic", "slip.hdf5", "--tolerance=-1"]).ends(2, &["between 0 and 1"]);
    folder.run(&["algebraic"]).ends(2, &["FILES"]);
    folder.run(&["algebraic", "slip.hdf5", "--method", "simplex"]).ends(2, &["simplex", "gauss-seidel"]);
    folder.run(&["algebraic", "slip.hdf5", "--form", "dense"]).ends(2, &["dense", "condensed"]);
    assert!(!folder.exists("out"));
}

#[test]
fn the_method_is_a_choice_and_is_told() {
    let folder = folder("algebraic-method");
    for (method, told) in [
        ("newton", "Newton steps"),
        ("gauss-seidel", "sweeps"),
        ("gradient", "gradient steps"),
        ("admm", "alternations"),
    ] {
        let run = folder.run(&["algebraic", "slip.hdf5", "--method", method]);
        run.ends(0, &[]);
        assert!(run.out.contains(told), "{method}: {}", run.out);
    }
}

#[test]
fn a_guess_is_told_with_its_residual() {
    let folder = folder("algebraic-guess");
    let guess = |r: [f64; 3]| State { r: r.to_vec(), ..State::default() };
    write(&folder.path.join("guess.hdf5"), &point(1.0, 2.0), None, &[guess([9.0, 9.0, 9.0]), guess([1.0, -0.3, 0.0])])
        .unwrap();
    let run = folder.run(&["algebraic", "guess.hdf5"]);
    run.ends(0, &[]);
    assert!(run.out.contains("guesses      2: started from number 2"), "{}", run.out);
}
