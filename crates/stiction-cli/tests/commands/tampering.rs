//! Result folders that somebody or something has changed: `check` notices, and `--resume` builds on no damaged step.

use std::path::{Path, PathBuf};

use crate::folder::{CASE, Folder, Run};
use serde_json::Value;
use stiction::io::{problem, step};
use stiction_fixtures::tamper;

/// Changes the file, checks, and puts it back.
fn check_after(folder: &Folder, name: &str, change: &dyn Fn(&Path)) -> Run {
    let path = folder.path.join("r").join(name);
    let whole = std::fs::read(&path).unwrap();
    change(&path);
    assert!(std::fs::read(&path).ok().is_none_or(|bytes| bytes != whole), "{name} is as it was");
    let run = folder.run(&["check", "r"]);
    std::fs::write(&path, whole).unwrap();
    run
}

/// The file is named and the check fails with exit code 1.
#[track_caller]
fn assert_named(run: &Run, name: &str, what: &str) {
    run.ends(1, &[]);
    assert!(run.out.contains(&format!("{name} is {what}")) && run.out.contains("failed"), "{name} {run:#?}");
}

fn with_json(path: &Path, change: &dyn Fn(&mut Value)) {
    let mut value: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    change(&mut value);
    std::fs::write(path, format!("{value:#}\n")).unwrap();
}

fn scale(value: &mut Value) {
    *value = (value.as_f64().unwrap() * (1.0 + 2e-6)).into();
}

/// What is done to a part of a file.
type Change<T> = fn(&mut T);
/// A file, what is done to it, words of the warning, and what is said of the step to go on from.
type Damage<'a> = (&'a str, fn(&Path), &'a [&'a str], &'a str);

const CHANGED: &str = "changed since it was written";

#[test]
fn every_change_of_a_summary_is_noticed() {
    let folder = Folder::new("tamper-summary", CASE);
    folder.run(&["solve", "case.toml", "-o", "r"]).ends(0, &[]);
    let changes: [(&str, Change<Value>); 5] = [
        ("status", |summary| summary["status"] = "stalled".into()),
        ("reaction", |summary| scale(&mut summary["reaction"][2])),
        ("pairs", |summary| scale(&mut summary["pairs"][0]["normal_force"])),
        ("displacement", |summary| scale(&mut summary["displacement_max"])),
        ("words", |summary| summary["report"][0]["value"] = "solved at once".into()),
    ];
    for (what, change) in changes {
        let run = check_after(&folder, "summary.json", &|path| with_json(path, &change));
        assert_named(&run, "summary.json", CHANGED);
        assert!(run.out.contains("solves its problem"), "{what} {run:#?}");
    }
    folder.run(&["check", "r"]).ends(0, &[]);
}

/// The certificate of what the step before has left passes, and knows nothing of the force that a bolt was to have.
#[test]
fn a_run_that_has_found_no_answer_fails() {
    let case = "[mesh]\nblock = { size = [1, 1, 3], cells = [2, 2, 6], element = \"hex8\" }\n\
                [materials.steel]\nyoung = 2e5\npoisson = 0.3\n[[fix]]\non = \"z-min\"\n[[load]]\non = \"z-max\"\npressure = 10\n\
                [[bolt]]\non = \"body\"\naxis = [0, 0, 1]\npoint = [0.5, 0.5, 1.6]\nforce = 0\n";
    let folder = Folder::new("tamper-none", case);
    folder.run(&["solve", "case.toml", "-o", "r"]).ends(1, &["there is no equilibrium", "the parts of bolt \"body\""]);
    let run = folder.run(&["check", "r"]);
    run.ends(1, &[]);
    assert!(run.out.contains("the status no_equilibrium") && run.out.contains("has found no answer"), "{run:#?}");
}

#[test]
fn files_that_are_missing_changed_or_unknown_are_named() {
    let folder = Folder::new("tamper-files", CASE);
    folder.run(&["solve", "case.toml", "-o", "r"]).ends(0, &[]);
    for name in ["result.vtu", "contact.vtu", "log.jsonl", "case.toml", "pressure.png", "report.html"] {
        let grow = |path: &Path| std::fs::write(path, [std::fs::read(path).unwrap(), vec![b' ']].concat()).unwrap();
        assert_named(&check_after(&folder, name, &grow), name, CHANGED);
        let remove = |path: &Path| std::fs::remove_file(path).unwrap();
        assert_named(&check_after(&folder, name, &remove), name, "missing");
    }
    // A line that is gone does not free its file.
    let without = |path: &Path| {
        let text = std::fs::read_to_string(path).unwrap();
        let kept = text.lines().filter(|line| !line.ends_with("  result.vtu"));
        std::fs::write(path, kept.map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    };
    assert_named(&check_after(&folder, "SHA256SUMS", &without), "result.vtu", "not listed in SHA256SUMS");
    // Files of other programs are nobody's business.
    folder.write("r/notes.txt", "looks good");
    folder.run(&["check", "r"]).ends(0, &[]);
    // The report is written again, and its checksum with it.
    let report = folder.path.join("r/report.html");
    std::fs::write(&report, "nothing").unwrap();
    assert_named(&folder.run(&["check", "r"]), "report.html", CHANGED);
    folder.run(&["report", "r"]).ends(0, &[]);
    folder.run(&["check", "r"]).ends(0, &[]);
    // An answer that cannot be read at all is told together with every other file that differs.
    std::fs::write(&report, "nothing").unwrap();
    let damaged = check_after(&folder, "solution.npz", &|path| std::fs::write(path, "PK").unwrap());
    damaged.ends(2, &["solution.npz", "report.html is changed", "remedy: "]);
    let damaged = check_after(&folder, "SHA256SUMS", &|path| std::fs::write(path, "../../etc/passwd\n").unwrap());
    damaged.ends(2, &["SHA256SUMS", "line 1", "remedy: "]);
    let gone = check_after(&folder, "SHA256SUMS", &|path| std::fs::remove_file(path).unwrap());
    gone.ends(2, &["no SHA256SUMS", "solve the case again"]);
}

/// An independent program finds the checksums right.
#[cfg(target_os = "linux")]
#[test]
fn sha256sum_reads_the_list() {
    let folder = Folder::new("tamper-sha256sum", &tamper::stepped_case());
    folder.run(&["solve", "case.toml", "-o", "r"]).ends(0, &[]);
    let mut command = std::process::Command::new("sha256sum");
    let checked = command.args(["--check", "--strict", "SHA256SUMS"]).current_dir(folder.path.join("r")).output();
    let Ok(checked) = checked else { return }; // no such program here
    assert!(checked.status.success(), "{checked:?}");
    let said = String::from_utf8(checked.stdout).unwrap();
    assert_eq!(said.lines().count() + 1, folder.names_in("r").len(), "every file but the list itself: {said}");
}

#[test]
fn no_number_of_supports_may_be_missing() {
    let folder = Folder::new("tamper-nan", &tamper::stepped_case());
    folder.run(&["solve", "case.toml", "-o", "r"]).ends(0, &[]);
    let path = folder.path.join("r/problem.npz");
    let right = problem::read_problem(&path).unwrap();
    let changes: [(&str, Change<stiction::contact::Supports>); 6] = [
        ("load", |s| s.load[1] = f64::NAN),
        ("free_load", |s| s.free_load[1] = f64::INFINITY),
        ("displacement", |s| s.displacement[0] = f64::NAN),
        ("rigid", |s| s.rigid[0][5] = f64::NAN),
        ("support_K_own", |s| s.K_own.value[0] = f64::NAN),
        ("support_B", |s| s.B.value.iter_mut().for_each(|v| *v = f64::NAN)),
    ];
    for (what, change) in changes {
        let mut wrong = right.0.clone();
        let supports = wrong.labels.supports.as_mut().unwrap();
        if what == "support_B" && supports.B.value.is_empty() {
            continue;
        }
        change(supports);
        assert!(wrong.validate().is_err(), "{what}");
        let run = check_after(&folder, "problem.npz", &|path| problem::write_problem(path, &wrong, right.1).unwrap());
        run.ends(2, &["problem.npz", "remedy: "]);
    }
    let mut wrong = right.0.clone();
    wrong.labels.bodies.as_mut().unwrap().list[0].centre[1] = f64::NAN;
    assert!(wrong.validate().unwrap_err().what.contains("bodies"));
    let sizes = (right.0.unknowns(), right.0.labels.supports.as_ref().unwrap().load.len(), right.0.points());
    let of_step = step::read_step(&folder.path.join("r/step-0002.npz"), sizes.0, sizes.1, sizes.2).unwrap();
    let changes: [(&str, Change<step::StepFile>); 4] = [
        ("support_load", |s| s.support_load[0] = f64::NAN),
        ("support_displacement", |s| s.support_displacement[0] = f64::NAN),
        ("motion", |s| s.motion[3] = f64::NAN),
        ("energy", |s| s.energy[1] = f64::NEG_INFINITY),
    ];
    for (what, change) in changes {
        let mut wrong = of_step.clone();
        change(&mut wrong);
        let run = check_after(&folder, "step-0002.npz", &|path| step::write_step(path, &wrong).unwrap());
        run.ends(2, &["step-0002.npz", what, "remedy: "]);
    }
}

/// A few changes of every kind; the campaign in `bench/campaigns` makes thousands.
#[test]
fn no_changed_number_and_no_swapped_step_goes_unnoticed() {
    for (name, case, count) in [("static", CASE.to_string(), 150), ("stepped", tamper::stepped_case(), 250)] {
        let folder = Folder::new(name, &case);
        let results: PathBuf = folder.path.join("r");
        folder.run(&["solve", "case.toml", "-o", "r"]).ends(0, &[]);
        let report = tamper::campaign(&results, 7, count);
        assert!(report.unnoticed.is_empty(), "{report:#?}");
        let kinds: Vec<&str> = report.changes.keys().map(String::as_str).collect();
        let wanted: &[&str] = match name {
            "static" => {
                &["SHA256SUMS", "contact.vtu", "log.jsonl", "problem.npz", "result.vtu", "solution.npz", "summary.json"]
            }
            _ => &["contact.vtu", "result.vtu", "step.npz", "steps.json", "summary.json", "swapped steps"],
        };
        assert!(wanted.iter().all(|kind| kinds.contains(kind)), "{kinds:?}");
        // All was put back.
        folder.run(&["check", "r"]).ends(0, &[]);
    }
}

/// Damage to an earlier step, to the last one, and to the list: resumed from the last whole step, with the same bits.
#[test]
fn a_run_is_resumed_from_its_last_whole_step() {
    let folder = Folder::new("tamper-resume", &tamper::stepped_case());
    let one_thread = ["solve", "case.toml", "-o", "r", "--threads", "1", "--progress", "none"];
    folder.run(&one_thread).ends(0, &[]);
    let numbers = |name: &str| [".npz", ".vtu", ".csv", ".pvd"].iter().any(|ending| name.ends_with(ending));
    let files = || -> Vec<(String, Vec<u8>)> {
        let names = folder.names_in("r").into_iter().filter(|name| numbers(name));
        names.map(|name| (name.clone(), std::fs::read(folder.path.join("r").join(name)).unwrap())).collect()
    };
    let undisturbed = files();
    let grow = |path: &Path| std::fs::write(path, [std::fs::read(path).unwrap(), vec![b' ']].concat()).unwrap();
    let swap = |path: &Path| {
        let other = path.with_file_name("step-0001.npz");
        let [a, b] = [path, &other].map(|path| std::fs::read(path).unwrap());
        std::fs::write(path, b).unwrap();
        std::fs::write(other, a).unwrap();
    };
    let remove = |path: &Path| std::fs::remove_file(path).unwrap();
    let list = |path: &Path| with_json(path, &|list| scale(&mut list["steps"][3]["record"]["energy"]));
    let head = |path: &Path| with_json(path, &|list| list["fingerprint"] = "0123456789abcdef".into());
    let nothing = |_: &Path| {};
    let damages: [Damage; 10] = [
        ("step-0005.npz", grow, &["step-0005.npz of step 5 is changed", "end of step 4"], "after step 4"),
        ("step-0002.npz", grow, &["step-0002.npz of step 2 is changed", "end of step 1"], "after step 1"),
        ("result-0003.vtu", grow, &["result-0003.vtu of step 3", "end of step 2"], "after step 2"),
        ("contact-0005.vtu", remove, &["contact-0005.vtu of step 5 is missing", "end of step 4"], "after step 4"),
        ("step-0001.npz", grow, &["of step 1", "no step before it is whole"], "nothing to resume"),
        ("step-0003.npz", swap, &["of step 1", "no step before it is whole"], "nothing to resume"),
        ("steps.json", list, &["the list of finished steps says of step 4", "end of step 3"], "after step 3"),
        ("steps.json", head, &["the head of the list", "no step"], "nothing to resume"),
        ("result.pvd", grow, &[], "after step 5"),
        ("log.jsonl", nothing, &[], "after step 5"),
    ];
    for (name, damage, warned, resumed) in damages {
        damage(&folder.path.join("r").join(name));
        // A crash leaves no summary.
        std::fs::remove_file(folder.path.join("r/summary.json")).unwrap();
        let run = folder.run(&[&one_thread[..], &["--resume"]].concat());
        run.ends(0, warned);
        assert!(run.out.contains(resumed) && run.err.contains("warning") != warned.is_empty(), "{name} {run:#?}");
        for ((file, bytes), (wanted_file, wanted)) in files().into_iter().zip(&undisturbed) {
            assert!(file == *wanted_file && bytes == *wanted, "after damage to {name} {file} differs");
        }
        folder.run(&["check", "r"]).ends(0, &[]);
    }
    // What is no list at all is refused, as before.
    folder.write("r/steps.json", "{");
    folder.run(&[&one_thread[..], &["--resume"]].concat()).ends(2, &["steps.json", "without --resume"]);
}
