//! The command where memory is short: an answer or an error within seconds, never a signal.
#![cfg(target_os = "linux")]

use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::{Command, Output};

use crate::folder::{CASE, Folder};

/// A shipped case under a limit on addresses in kilobytes.
fn limited(folder: &Folder, case: &str, kilobytes: usize) -> Output {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../cases/{case}/{case}.toml"));
    let solve = "ulimit -v $1 && exec \"$0\" solve \"$2\" -o \"$3\" --threads 2 --progress none";
    let mut command = Command::new("sh");
    command.args(["-c", solve, env!("CARGO_BIN_EXE_stiction"), &kilobytes.to_string()]);
    command.arg(case).arg(folder.at("results")).output().unwrap()
}

#[test]
fn a_run_in_little_memory_ends_with_an_answer_or_an_error() {
    for case in ["brick", "cylinder", "joint"] {
        let (mut answers, mut errors) = (0, 0);
        // Threads reserve up to 64 MB of addresses each when they meet in the allocator: up to 500 MB may end either way.
        for megabytes in [24, 32, 48, 80, 120, 140, 160, 180, 220, 300, 500, 800, 1200] {
            let folder = Folder::new("limited", CASE);
            let output = limited(&folder, case, 1000 * megabytes);
            let said = String::from_utf8_lossy(&output.stderr);
            let place = format!("{case} in {megabytes} MB: {:?}, {said}", output.status);
            assert_eq!(output.status.signal(), None, "{place}");
            match output.status.code() {
                Some(0) => answers += 1,
                Some(2) => {
                    assert!(said.contains("remedy:"), "{place}");
                    // Nothing that could be taken for a result.
                    assert!(!folder.exists("results/summary.json"), "{place}");
                    errors += 1;
                }
                _ => panic!("{place}"),
            }
        }
        assert!(answers >= 2 && errors >= 3, "{case}: {answers} answers, {errors} errors");
    }
}

#[test]
fn a_refusal_says_what_is_needed_what_there_is_and_what_sets_the_limit() {
    let folder = Folder::new("limited-message", CASE);
    let output = limited(&folder, "brick", 80_000);
    let said = String::from_utf8_lossy(&output.stderr);
    let parts = ["needs", "may be used", "`ulimit -v`", "brick.toml:", "remedy: coarsen the mesh"];
    assert!(output.status.code() == Some(2) && parts.iter().all(|part| said.contains(part)), "{said}");
}

#[test]
fn a_mesh_beyond_all_memory_is_refused_before_it_is_made() {
    let folder = Folder::new("far-too-large", CASE);
    let run = folder.run(&["solve", "case.toml", "--set", "mesh.block.cells=[900, 900, 900]"]);
    assert!(run.code == Some(2) && run.err.contains("unknowns needs"), "{}", run.err);
    assert!(run.err.contains("may be used"), "{}", run.err);
}

#[test]
fn what_no_path_can_solve_is_refused_by_its_counts_before_it_is_read_or_made() {
    let folder = Folder::new("by-counts", CASE);
    let solve = |cells: &str, path: &str, gigabytes: f64| {
        let mut all = vec!["solve".to_string(), "case.toml".into(), "--progress".into(), "plain".into()];
        let element = "mesh.block.element=hex8".to_string();
        let (cells, path) = (format!("mesh.block.cells={cells}"), format!("solver.path={path}"));
        for set in [element, cells, path, format!("solver.memory={gigabytes}")] {
            all.extend(["--set".into(), set]);
        }
        folder.run(&all.iter().map(String::as_str).collect::<Vec<&str>>())
    };
    let phases = ["ordering", "factorising", "setting up", "solving"];
    for (cells, path, memory, what) in [
        ("[320, 140, 140]", "auto", 15.0, "multigrid for at least"),
        ("[320, 140, 140]", "multigrid", 15.0, "multigrid for at least"),
        ("[320, 140, 140]", "solves", 100.0, "the Cholesky factor of at least"),
        ("[160, 80, 80]", "dense", 16.0, "the Cholesky factor of at least"),
    ] {
        let run = solve(cells, path, memory);
        run.ends(
            2,
            &[what, "may be used (`memory` under [solver])", "case.toml:", "remedy:", "coarsen the mesh to less than"],
        );
        assert!(!phases.iter().any(|phase| run.err.contains(phase)) && run.out.is_empty(), "{run:#?}");
        assert!(!folder.exists("case-results/summary.json"));
    }
    // What the factor is said to need after the unknowns have been ordered is enough, and less is not refused before that.
    let run = solve("[40, 20, 20]", "solves", 0.3);
    run.ends(2, &["ordering", "the Cholesky factor of"]);
    assert!(!run.err.contains("at least"), "{run:#?}");
    let needed =
        run.err.split("unknowns needs ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse::<f64>();
    solve("[40, 20, 20]", "solves", needed.unwrap() * if run.err.contains("GB and") { 1.02 } else { 1.02e-3 })
        .ends(0, &[]);
}
