//! Ctrl-C and SIGTERM: what there is of a solution is kept, and nothing else is left.
#![cfg(target_os = "linux")]

use std::io::{BufRead as _, BufReader, Read as _};
use std::os::unix::process::ExitStatusExt as _;
use std::process::{Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::folder::{CASE, Folder};

/// How a solve ended that got `signal` so many milliseconds after it said `word`, what it said from then on, and when.
fn signal_after(
    folder: &Folder,
    options: &[&str],
    word: &str,
    milliseconds: u64,
    signal: &str,
) -> (ExitStatus, String, Duration) {
    let arguments = [&["solve", "case.toml", "--progress", "plain", "--no-report"][..], options].concat();
    let mut child = folder.command(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains(word) {
        line.clear();
        assert!(lines.read_line(&mut line).unwrap() > 0, "it ended before it said {word}");
    }
    sleep(Duration::from_millis(milliseconds));
    let sent = Command::new("sh").args(["-c", &format!("kill -{signal} {}", child.id())]).status().unwrap();
    assert!(sent.success());
    let begin = Instant::now();
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
    (child.wait().unwrap(), rest, begin.elapsed())
}

/// More digits than there are: left alone it would go on for long.
const EXACT: &str = "solver.tolerance=1e-12";

#[test]
fn an_interrupted_solve_keeps_its_last_step() {
    let folder = Folder::new("interrupt", &CASE.replace("[9, 3, 3]", "[48, 16, 16]"));
    let options = ["--set", "solver.path=solves", "--set", EXACT];
    let (status, rest, _) = signal_after(&folder, &options, "newton  ", 0, "INT");
    assert_eq!(status.code(), Some(130), "{rest}");
    assert!(rest.contains("interrupted"), "{rest}");
    let summary = folder.summary("case-results");
    assert_eq!(summary["status"], "interrupted");
    assert_eq!(summary["certificate"]["passed"], false);
    folder.run(&["check", "case-results"]).ends(1, &[]);
}

/// Signals at moments of a solve that has no solution yet: nothing is left of it but the case.
fn leaves_nothing(name: &str, case: &str, options: &[&str], moments: &[(&str, u64)]) {
    let folder = Folder::new(name, case);
    for (k, &(word, milliseconds)) in moments.iter().enumerate() {
        let signal = ["TERM", "INT"][k % 2];
        let (status, rest, took) = signal_after(&folder, options, word, milliseconds, signal);
        let what =
            format!("{signal} {milliseconds} ms after {word}, ended in {took:?} by {:?}: {rest}", status.signal());
        assert_eq!(status.code(), Some(130), "{what}");
        assert!(rest.contains("interrupted"), "{what}");
        // Machines that have other work to do are slow: what cannot be stopped takes minutes.
        assert!(took < Duration::from_secs(20), "{what}");
        if !rest.contains("newton  ") && !rest.contains("multigrid  ") {
            assert_eq!(folder.names(), ["case.toml"], "{what}");
        } else if folder.exists("case-results") {
            assert_eq!(folder.summary("case-results")["status"], "interrupted", "{what}");
            std::fs::remove_dir_all(folder.path.join("case-results")).unwrap();
        }
    }
}

/// A cube, whose factor takes seconds.
fn cube() -> String {
    CASE.replace("[9, 3, 3]", "[30, 30, 30]")
}

#[test]
fn a_direct_solve_that_is_stopped_before_its_iteration_leaves_nothing() {
    let ordering = [0, 0, 20, 40, 80, 160].map(|milliseconds| ("ordering", milliseconds));
    let factorising = [0, 50, 300].map(|milliseconds| ("factorising", milliseconds));
    let moments = [&[("reading", 0)][..], &ordering, &factorising].concat();
    leaves_nothing("stop-direct", &cube(), &["--set", "solver.path=solves", "--set", EXACT], &moments);
}

#[test]
fn a_set_up_of_multigrid_that_is_stopped_leaves_nothing() {
    let moments = [0, 30, 100].map(|milliseconds| ("setting up", milliseconds));
    leaves_nothing("stop-multigrid", &cube(), &["--set", "solver.path=multigrid", "--set", EXACT], &moments);
}

#[test]
fn a_first_load_step_that_is_stopped_leaves_nothing() {
    let steps = "\n[[step]]\nname = \"press\"\nuntil = 1\n";
    let moments = [("ordering", 20), ("factorising", 100)];
    leaves_nothing("stop-step", &(cube() + steps), &["--set", "solver.path=solves", "--set", EXACT], &moments);
}
