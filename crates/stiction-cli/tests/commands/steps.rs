//! Load steps from the command line: files, the check of every step, and going on after an interruption.

use crate::folder::{CASE, Folder};
use serde_json::Value;

/// The block of all tests, pressed on in two increments and then lifted at its end in some more.
fn stepped(increments: usize) -> String {
    let steps = format!(
        "[[step]]\nname = \"press\"\nuntil = 1\nincrements = 2\n[[step]]\nname = \"lift\"\nuntil = 2\nincrements = {increments}\n"
    );
    CASE.replace("(3 - x)\"", "(3 - x)*min(t, 1)\"")
        .replace("traction = [0, 0, 1e6]", "traction = [0, 0, \"2e6*(t - 1)*(t - 0.5)\"]")
        + &steps
}

#[test]
fn every_step_has_its_files_and_its_check() {
    let folder = Folder::new("steps", &stepped(3));
    let run = folder.run(&["solve", "case.toml"]);
    run.ends(0, &["step   5", "t = 2"]);
    assert!(run.out.contains("5 steps to t = 2") && run.out.contains("dissipated"), "{run:#?}");
    let names = folder.names_in("case-results");
    for name in ["result.pvd", "result-0001.vtu", "contact-0005.vtu", "step-0005.npz", "history.png", "problem.npz"] {
        assert!(names.iter().any(|n| n == name), "{name} {names:?}");
    }
    assert!(!names.iter().any(|n| n == "result.vtu" || n.ends_with(".part") || n.contains("0006")), "{names:?}");
    let pvd = std::fs::read_to_string(folder.path.join("case-results/contact.pvd")).unwrap();
    assert!(
        pvd.matches("<DataSet").count() == 5 && pvd.contains("timestep=\"2.0\" file=\"contact-0005.vtu\""),
        "{pvd}"
    );
    let summary = folder.summary("case-results");
    let steps = summary["steps"].as_array().unwrap();
    let named: Vec<_> = steps.iter().map(|s| (s["name"].as_str().unwrap(), s["t"].as_f64().unwrap())).collect();
    assert_eq!((named[0], named[1], named[4]), (("press", 0.5), ("press", 1.0), ("lift", 2.0)));
    // The summary speaks of the last step.
    assert!(summary["contact"] == steps[4]["contact"] && summary["balance"] == steps[4]["balance"]);
    // Half the pressing of 3 MN, and no lift yet.
    assert!((steps[0]["load"][2].as_f64().unwrap() + 1.5e6).abs() < 1.0);
    let log = std::fs::read_to_string(folder.path.join("case-results/log.jsonl")).unwrap();
    let last: Value = serde_json::from_str(log.lines().last().unwrap()).unwrap();
    assert_eq!(last["step"], 5);
    // Put together from the texts of its steps, the list is as if it had been written at once.
    let list = std::fs::read_to_string(folder.path.join("case-results/steps.json")).unwrap();
    let read: Value = serde_json::from_str(&list).unwrap();
    assert_eq!((format!("{read:#}\n"), read["steps"].as_array().unwrap().len()), (list, 5));
    let check = folder.run(&["check", "case-results"]);
    check.ends(0, &[]);
    assert!(check.out.matches("worst measure").count() == 5 && check.out.contains("passed"), "{check:#?}");

    // Solved without steps, nothing of them stays.
    folder.write("case.toml", CASE);
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    let names = folder.names_in("case-results");
    assert!(!names.iter().any(|n| n.contains("0001") || n.contains("pvd") || n == "steps.json"), "{names:?}");
    folder.run(&["check", "case-results"]).ends(0, &[]);
    folder.run(&["solve", "case.toml", "--resume"]).ends(2, &["no load steps", "without --resume"]);
}

/// A step that solves its own problem perfectly, but not the one that its predecessor left to it.
#[test]
fn a_step_that_forgets_its_predecessor_fails_its_check() {
    let folder = Folder::new("forgets", &stepped(2));
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    let results = folder.path.join("case-results");
    let problem = stiction::io::problem::read_problem(&results.join("problem.npz")).unwrap().0;
    let (n, m, p) = (problem.unknowns(), problem.points(), problem.labels.supports.as_ref().unwrap().load.len());
    let path = results.join("step-0003.npz");
    let right = stiction::io::step::read_step(&path, n, p, m).unwrap();
    // Points in contact slide a little further than reported: the law is still obeyed where the reference moves along.
    let mut wrong = right.clone();
    wrong.slip_reference.iter_mut().for_each(|s| *s += 1e-9);
    stiction::io::step::write_step(&path, &wrong).unwrap();
    let check = folder.run(&["check", "case-results"]);
    check.ends(1, &[]);
    assert!(check.out.contains("slip reference: recorded"), "{check:#?}");
    wrong = right.clone();
    wrong.energy[2] *= 2.0;
    wrong.support_free_load[5] += 1.0;
    stiction::io::step::write_step(&path, &wrong).unwrap();
    let check = folder.run(&["check", "case-results"]);
    check.ends(1, &[]);
    assert!(check.out.contains("load: recorded"), "{check:#?}");
    stiction::io::step::write_step(&path, &right).unwrap();
    folder.run(&["check", "case-results"]).ends(0, &[]);
    let path = results.join("summary.json");
    let mut summary = folder.summary("case-results");
    let dissipation = summary["steps"][2]["balance"]["dissipation"].as_f64().unwrap();
    summary["steps"][2]["balance"]["dissipation"] = (1.01 * dissipation).into();
    std::fs::write(&path, summary.to_string()).unwrap();
    let check = folder.run(&["check", "case-results"]);
    check.ends(1, &[]);
    assert!(check.out.contains("dissipation: recorded"), "{check:#?}");
}

/// Equal within the tolerance of the certificate: the last digits of a factorisation depend on where the allocator puts
/// its arrays, and steps start from the ones before them.
fn assert_close(a: &Value, b: &Value) {
    match (a, b) {
        (Value::Array(x), Value::Array(y)) => {
            assert_eq!(x.len(), y.len());
            x.iter().zip(y).for_each(|(x, y)| assert_close(x, y));
        }
        (Value::Object(x), Value::Object(y)) => {
            assert!(x.keys().eq(y.keys()));
            x.values().zip(y.values()).for_each(|(x, y)| assert_close(x, y));
        }
        (Value::Number(x), Value::Number(y)) => {
            let (x, y) = (x.as_f64().unwrap(), y.as_f64().unwrap());
            assert!((x - y).abs() <= 1e-8 * x.abs().max(y.abs()).max(1.0), "{x} and {y}");
        }
        _ => assert_eq!(a, b),
    }
}

#[cfg(target_os = "linux")]
mod interrupted {
    use std::io::{BufRead as _, BufReader, Read as _};
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::{Command, ExitStatus, Stdio};

    use super::*;

    /// Sends `signal` once step 3 is finished; how the command ended, and what it said from then on.
    fn signal_after_step_3(folder: &Folder, signal: &str) -> (ExitStatus, String) {
        let arguments = ["solve", "case.toml", "--progress", "plain"];
        let mut child = folder.command(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains("step   3  t =") {
            line.clear();
            assert!(lines.read_line(&mut line).unwrap() > 0, "it ended before its third step");
        }
        let sent = Command::new("sh").args(["-c", &format!("kill -{signal} {}", child.id())]).status().unwrap();
        assert!(sent.success());
        let mut rest = String::new();
        lines.read_to_string(&mut rest).unwrap();
        (child.wait().unwrap(), rest)
    }

    /// All that tells the answers of two runs apart, seconds and memory left out.
    fn answers(summary: &Value) -> Value {
        let keys = ["t", "status", "certificate", "contact", "energy", "reaction", "balance"];
        let steps = summary["steps"].as_array().unwrap();
        steps.iter().map(|step| keys.iter().map(|key| step[key].clone()).collect::<Value>()).collect()
    }

    #[test]
    fn a_killed_run_is_resumed_as_if_nothing_had_happened() {
        let folder = Folder::new("killed", &stepped(40));
        folder.run(&["solve", "case.toml", "-o", "whole"]).ends(0, &[]);
        let (status, _) = signal_after_step_3(&folder, "KILL");
        assert_eq!(status.signal(), Some(9));
        assert!(!folder.exists("case-results/summary.json"));
        folder.run(&["check", "case-results"]).ends(2, &["has not ended", "--resume"]);
        folder
            .run(&["solve", "case.toml", "-o", "case-results", "--resume", "--set", "contact.0.friction.coulomb=0.3"])
            .ends(2, &["steps.json", "another case"]);
        // How the case is solved may change.
        let options = ["solve", "case.toml", "--resume", "--set", "solver.max_iterations=80"];
        let run = folder.run(&options);
        run.ends(0, &[]);
        assert!(run.out.contains("resuming after step"), "{run:#?}");
        assert!(!run.err.contains("step   3  t ="), "{run:#?}");
        let (whole, resumed) = (folder.summary("whole"), folder.summary("case-results"));
        assert_close(&answers(&resumed), &answers(&whole));
        folder.run(&["check", "case-results"]).ends(0, &[]);
        // Every step has its lines in the log, once.
        let log = std::fs::read_to_string(folder.path.join("case-results/log.jsonl")).unwrap();
        let lines: Vec<Value> = log.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert!(lines.windows(2).all(|w| w[0]["step"].as_u64() <= w[1]["step"].as_u64()));
        let steps: std::collections::BTreeSet<_> = lines.iter().map(|line| line["step"].as_u64().unwrap()).collect();
        assert_eq!(steps.len(), 42);
    }

    #[test]
    fn ctrl_c_keeps_the_last_finished_step_and_a_resumed_run_ends() {
        let folder = Folder::new("stopped", &stepped(40));
        let (status, rest) = signal_after_step_3(&folder, "INT");
        assert_eq!(status.code(), Some(130), "{rest}");
        let summary = folder.summary("case-results");
        let steps = summary["steps"].as_array().unwrap();
        assert!(summary["status"] == "interrupted" && steps.len() >= 3 && steps.len() < 42);
        assert!(steps.iter().all(|step| step["status"] == "solved"));
        // What is kept is a finished step, and judged as such.
        folder.run(&["check", "case-results"]).ends(0, &[]);
        folder.run(&["solve", "case.toml", "--resume"]).ends(0, &[]);
        assert_eq!(folder.summary("case-results")["steps"].as_array().unwrap().len(), 42);
        folder.run(&["check", "case-results"]).ends(0, &[]);
        // Resumed once more, there is nothing left to do.
        let run = folder.run(&["solve", "case.toml", "--resume"]);
        run.ends(0, &[]);
        assert!(run.out.contains("resuming after step 42") && !run.err.contains("newton"), "{run:#?}");
    }
}
