//! Ctrl-C keeps the last finished step.
#![cfg(target_os = "linux")]

use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Command, Stdio};

use crate::folder::{CASE, Folder};

#[test]
fn an_interrupted_solve_keeps_its_last_step() {
    let folder = Folder::new("interrupt", &CASE.replace("[9, 3, 3]", "[48, 16, 16]"));
    let options = ["--progress", "plain", "--set", "solver.path=solves", "--set", "solver.tolerance=1e-12"];
    let arguments = [&["solve", "case.toml"][..], &options].concat();
    let mut child = folder.command(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("newton  ") {
        line.clear();
        assert!(lines.read_line(&mut line).unwrap() > 0, "it ended before its first iteration");
    }
    let sent = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap();
    assert!(sent.success());
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest}");
    assert!(rest.contains("interrupted"), "{rest}");
    let summary = folder.summary("case-results");
    assert_eq!(summary["status"], "interrupted");
    assert_eq!(summary["certificate"]["passed"], false);
    folder.run(&["check", "case-results"]).ends(1, &[]);
}
