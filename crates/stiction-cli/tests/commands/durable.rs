//! Power cuts, runs that were killed, two runs in one folder, output that cannot be written.
#![cfg(target_os = "linux")]

use std::collections::BTreeSet;
use std::fs::{self, OpenOptions};
use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};

use crate::folder::{CASE, Folder, Run};

/// Tells in which order names are given and taken and files are synced; fails the sync of one file.
const SHIM: &str = r#"
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

static void say(const char *what, const char *path) {
    char line[8192];
    int length = snprintf(line, sizeof line, "%s %s\n", what, path);
    int log = open(getenv("SHIM_LOG"), O_WRONLY | O_APPEND | O_CREAT, 0600);
    if (log >= 0 && write(log, line, length) == length) close(log);
}

int fsync(int fd) {
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    path[length < 0 ? 0 : length] = 0;
    const char *bad = getenv("SHIM_FAILS");
    if (bad && strstr(path, bad)) { errno = EIO; return -1; }
    long done = syscall(SYS_fsync, fd);
    say("sync", path);
    return done;
}

int rename(const char *from, const char *to) {
    say("part", from);
    say("name", to);
    return renameat(AT_FDCWD, from, AT_FDCWD, to);
}

int unlink(const char *path) {
    int done = unlinkat(AT_FDCWD, path, 0);
    if (done == 0) say("remove", path);
    return done;
}
"#;

/// A solve under the shim, and what that saw: what was done and to which file, of a path only the last part.
fn watched(folder: &Folder, arguments: &[&str], fails: Option<&str>) -> (Run, Vec<(String, String)>) {
    let (source, shim, log) = (folder.write("shim.c", SHIM), folder.at("shim.so"), folder.at("shim.log"));
    let made = Command::new("cc").args(["-shared", "-fPIC", "-o"]).args([&shim, &source]).status().unwrap();
    assert!(made.success());
    let _ = fs::remove_file(&log);
    let mut command = folder.command(arguments);
    command.env("LD_PRELOAD", &shim).env("SHIM_LOG", &log);
    if let Some(name) = fails {
        command.env("SHIM_FAILS", name);
    }
    let run = Run::of(command.output().unwrap());
    let text = fs::read_to_string(&log).unwrap_or_default();
    let line = |line: &str| {
        let (what, path) = line.split_once(' ').unwrap();
        (what.to_string(), path.rsplit('/').next().unwrap().to_string())
    };
    (run, text.lines().map(line).collect())
}

/// Asserts that a power cut at any moment leaves no file `commit` that names what is not on the disk, and returns how often
/// it was written. It names the files of which `of_it` is true.
fn commits(log: &[(String, String)], commit: &str, of_it: fn(&str) -> bool) -> usize {
    let is = |k: usize, what: &str, name: &str| log.get(k).is_some_and(|l| l.0 == what && l.1 == name);
    // Files, and names of files, that a power cut may take.
    let (mut contents, mut names, mut parts) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    let mut count = 0;
    for (k, (what, name)) in log.iter().enumerate() {
        match what.as_str() {
            "name" if name == commit => {
                assert!(contents.is_empty() && names.is_empty(), "{contents:?} {names:?} {log:#?}");
                assert!(parts.contains(&log[k - 1].1) && is(k + 1, "sync", "case-results"), "{log:#?}");
                count += 1;
            }
            "name" if of_it(name) => {
                // What was synced under its temporary name has its contents on the disk.
                if !parts.contains(&log[k - 1].1) {
                    contents.insert(name);
                }
                names.insert(name);
            }
            "remove" if name == commit => assert!(is(k + 1, "sync", "case-results"), "{log:#?}"),
            "sync" if name == "case-results" => names.clear(),
            "sync" => {
                contents.remove(name);
                parts.insert(name.clone());
            }
            _ => {}
        }
    }
    count
}

fn steps() -> String {
    CASE.to_string() + "\n[[step]]\nname = \"press\"\nuntil = 1\nincrements = 3\n"
}

#[test]
fn a_power_cut_leaves_no_list_of_files_that_are_not_on_the_disk() {
    let folder = Folder::new("power-cut", &steps());
    let solve = ["solve", "case.toml", "--no-report"];
    let of_step = |name: &str| name.contains("-000");
    for _ in 0..2 {
        let (run, log) = watched(&folder, &solve, None);
        run.ends(0, &[]);
        assert_eq!(commits(&log, "steps.json", of_step), 3);
        assert_eq!(commits(&log, "summary.json", |name| name != "steps.json" && !name.contains("probe")), 1);
        assert!(log.iter().any(|(what, name)| what == "sync" && name == "step-0002.npz"), "{log:#?}");
    }
    // The last step is not solved, and only the summary names it.
    let unsolved = [&solve[..], &["--set", "solver.max_iterations=1"]].concat();
    let (run, log) = watched(&folder, &unsolved, None);
    run.ends(1, &["the tolerance was not reached"]);
    assert_eq!(commits(&log, "summary.json", |name| name != "steps.json" && !name.contains("probe")), 1);
    folder.write("case.toml", CASE);
    for _ in 0..2 {
        let (run, log) = watched(&folder, &solve, None);
        run.ends(0, &[]);
        assert_eq!(commits(&log, "summary.json", |name| !name.contains("probe")), 1);
        assert!(log.iter().any(|(what, name)| what == "sync" && name == "problem.npz"), "{log:#?}");
    }
}

#[test]
fn a_file_that_cannot_be_synced_is_an_error_and_named_by_nothing() {
    let folder = Folder::new("sync-fails", CASE);
    let (run, _) = watched(&folder, &["solve", "case.toml"], Some("problem.npz"));
    run.ends(2, &["problem.npz", "cannot write this file", "remedy: check the folder and the disk"]);
    assert!(!folder.exists("case-results/summary.json"));
    folder.write("case.toml", steps());
    let (run, _) = watched(&folder, &["solve", "case.toml"], Some("step-0002.npz"));
    run.ends(2, &["step-0002.npz", "cannot write this file"]);
    let state = fs::read_to_string(folder.at("case-results/steps.json")).unwrap();
    let state: serde_json::Value = serde_json::from_str(&state).unwrap();
    assert!(state["steps"].as_array().unwrap().len() == 1 && !folder.exists("case-results/summary.json"));
    // Once the disk is whole again.
    let run = folder.run(&["solve", "case.toml", "--resume"]);
    run.ends(0, &[]);
    assert!(run.out.contains("resuming after step 1"), "{run:#?}");
    folder.run(&["check", "case-results"]).ends(0, &[]);
}

/// A run that is still at work, and has taken its folder.
fn long(folder: &Folder, options: &[&str]) -> Child {
    folder.write("long.toml", CASE.replace("[9, 3, 3]", "[48, 16, 16]"));
    let arguments = ["solve", "long.toml", "-o", "case-results", "--progress", "plain", "--set"];
    let arguments = [&arguments[..], &["solver.tolerance=1e-12", "--set", "solver.path=solves"], options].concat();
    let mut child = folder.command(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("reading") {
        line.clear();
        assert!(lines.read_line(&mut line).unwrap() > 0, "it ended before it began");
    }
    // The rest is read, so that nothing waits for it.
    std::thread::spawn(move || std::io::copy(&mut lines, &mut std::io::sink()));
    child
}

const LOCK: &str = "case-results/.stiction-lock";

#[test]
fn a_folder_belongs_to_one_run_as_long_as_that_lives() {
    let folder = Folder::new("two-runs", CASE);
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    assert!(!folder.exists(LOCK));
    let mut first = long(&folder, &[]);
    let owner = format!("process {} on ", first.id());
    let words = ["case-results: another run (", &owner, "started 20", "wait until it has ended", "-o DIR"];
    folder.run(&["solve", "case.toml"]).ends(2, &words);
    folder.run(&["report", "case-results"]).ends(2, &words);
    folder.write("steps.toml", steps());
    folder.run(&["solve", "steps.toml", "-o", "case-results", "--resume"]).ends(2, &words);
    // Elsewhere there is room.
    folder.run(&["solve", "case.toml", "-o", "other"]).ends(0, &[]);
    assert!(first.try_wait().unwrap().is_none(), "the first run has ended too early for this test");
    first.kill().unwrap();
    first.wait().unwrap();

    // What it has left is no obstacle.
    assert!(folder.exists(LOCK));
    let run = folder.run(&["solve", "case.toml"]);
    run.ends(0, &["note: case-results: a run before this one (", &owner, "was killed", "taken over"]);
    assert!(!folder.exists(LOCK));
    let run = folder.run(&["report", "case-results"]);
    assert!(run.code == Some(0) && run.err.is_empty(), "{run:#?}");
    // A report of nothing makes no folder.
    folder.run(&["report", "none"]).ends(2, &["none", "summary.json"]);
    assert!(!folder.exists("none"));
}

#[test]
fn half_files_of_a_killed_run_are_removed_by_the_next_one() {
    let folder = Folder::new("parts", CASE);
    fs::create_dir(folder.at("case-results")).unwrap();
    let others = [".film.mp4.17.part", "result.vtu.17.part"];
    for name in [&others[..], &[".result.vtu.17.part", ".steps.json.4194304.part", ".step-0001.npz.17.part"]].concat() {
        folder.write(&format!("case-results/{name}"), "half");
    }
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    let mut parts = folder.names_in("case-results");
    parts.retain(|name| name.ends_with(".part"));
    assert_eq!(parts, others);
}

#[test]
fn output_that_cannot_be_written_is_an_error() {
    let folder = Folder::new("full", CASE);
    folder.write("cubes.msh", crate::folder::two_cubes());
    let solve: &[&str] = &["solve", "case.toml"];
    let json = ["solve", "case.toml", "--json"];
    let others: [&[&str]; 6] = [
        &["check", "case-results"],
        &["report", "case-results"],
        &["mesh", "info", "cubes.msh"],
        &["schema"],
        &["new", "--list"],
        &["--help"],
    ];
    for arguments in [solve, &json].into_iter().chain(others) {
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let run = Run::of(folder.command(arguments).stdout(full).output().unwrap());
        run.ends(2, &["error: standard output", "No space left", "remedy: make room"]);
        // A reader that has gone away has had enough.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let run = Run::of(folder.command(arguments).stdout(writer).output().unwrap());
        assert!(run.code == Some(0) && !run.err.contains("standard output"), "{arguments:?} {run:#?}");
    }
    // The results are whole.
    folder.run(&["check", "case-results"]).ends(0, &[]);
}
