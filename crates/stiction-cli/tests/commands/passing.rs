//! Bodies that pass through each other: solved again with contact there, refused, or warned of.

use crate::folder::Folder;
use serde_json::Value;

/// Two blocks 4 apart, the upper one `aside` beside the lower one and moved.
fn blocks(aside: f64, moved: &str, more: &str) -> String {
    format!(
        "[mesh.parts.a]\nblock = {{ size = [10, 10, 10], cells = [3, 3, 3], element = \"hex8\" }}\n\
         [mesh.parts.b]\nblock = {{ size = [10, 10, 10], cells = [2, 2, 2], element = \"hex8\", origin = [{aside}, 0, 14] }}\n\
         [materials.s]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = \"a.z-min\"\n[[fix]]\non = \"b.z-max\"\nvalue = {moved}\n{more}"
    )
}

const PAIR: &str = "[[contact]]\non = \"b.z-min\"\nagainst = \"a.z-max\"\nfriction = { coulomb = 0.3 }\n";
const STEPS: &str = "[[step]]\nuntil = 1\nincrements = 3\n";

fn solve(folder: &Folder, more: &[&str]) -> crate::folder::Run {
    let mut arguments = vec!["solve", "case.toml", "-o", "r", "--progress", "none"];
    arguments.extend(more);
    folder.run(&arguments)
}

fn normal_force(summary: &Value) -> f64 {
    summary["contact"]["normal_force"].as_f64().unwrap()
}

#[test]
fn surfaces_that_meet_beyond_search_are_solved_again_with_contact_there() {
    let folder = Folder::new("passing-again", &blocks(0.0, "[0, 0, -6]", PAIR));
    let run = solve(&folder, &[]);
    run.ends(0, &[]);
    for word in ["pass through each other by 2 at", "set search = 6", "solved again", "`search` is 6 now"] {
        assert!(run.out.contains(word), "{word}: {}", run.out);
    }
    let found = folder.summary("r");
    assert!(found["status"] == "solved" && found["overlaps"].as_array().unwrap().is_empty());
    folder.run(&["check", "r"]).ends(0, &[]);
    folder.write("case.toml", blocks(0.0, "[0, 0, -6]", &format!("{PAIR}search = 8\n")));
    let run = solve(&folder, &[]);
    run.ends(0, &[]);
    assert!(!run.out.contains("solved again"), "{}", run.out);
    let by_hand = normal_force(&folder.summary("r"));
    assert!(by_hand > 1e4 && (normal_force(&found) / by_hand - 1.0).abs() < 1e-8);
}

#[test]
fn load_steps_begin_anew_and_are_resumed_with_the_larger_search() {
    let folder = Folder::new("passing-steps", &blocks(0.0, "[0, 0, \"-6*t\"]", &format!("{PAIR}{STEPS}")));
    let run = solve(&folder, &[]);
    run.ends(0, &[]);
    assert!(run.out.contains("solved again"), "{}", run.out);
    let found = folder.summary("r");
    assert_eq!(found["steps"].as_array().unwrap().len(), 3);
    let run = solve(&folder, &["--resume"]);
    run.ends(0, &[]);
    assert!(run.out.contains("resuming after step 3") && !run.out.contains("solved again"), "{}", run.out);
    folder.run(&["check", "r"]).ends(0, &[]);
    assert!((normal_force(&folder.summary("r")) / normal_force(&found) - 1.0).abs() < 1e-8);
}

/// From beside the lower block to above it and down: nothing lies opposite before the load.
#[test]
fn surfaces_that_no_search_finds_end_with_one() {
    for steps in ["", STEPS] {
        let folder = Folder::new(
            &format!("passing-aside-{}", steps.len()),
            &blocks(30.0, "[\"-30*t\", 0, \"-6*t\"]", &format!("{PAIR}{steps}")),
        );
        let run = solve(&folder, &[]);
        run.ends(1, &["contact \"b.z-min\"", "2 deep", "without a contact point", "pass through each other"]);
        let check = folder.run(&["check", "r"]);
        check.ends(1, &[]);
        assert!(check.out.contains("surfaces pass through each other"), "{}", check.out);
        let summary = folder.summary("r");
        assert_eq!(summary["status"], "passes_through");
        let overlap = &summary["overlaps"][0];
        assert_eq!((&overlap["kind"], &overlap["contact"]), (&"out_of_reach".into(), &"b.z-min".into()));
        assert!((overlap["depth"].as_f64().unwrap() - 2.0).abs() < 1e-9, "{overlap}");
        let report = std::fs::read_to_string(folder.path.join("r/report.html")).unwrap();
        assert!(report.contains("Not solved: surfaces pass through each other"));
    }
}

#[test]
fn bodies_that_nobody_named_are_warned_of() {
    let folder = Folder::new("passing-unnamed", &blocks(0.0, "[0, 0, -6]", ""));
    let run = solve(&folder, &[]);
    run.ends(0, &[]);
    for word in ["warning", "2 deep in body", "no contact is named", "\"a.z-max\"", "\"b.z-min\""] {
        assert!(run.out.contains(word), "{word}: {}", run.out);
    }
    let overlap = &folder.summary("r")["overlaps"][0];
    assert!(overlap["kind"] == "unnamed" && (overlap["depth"].as_f64().unwrap() - 2.0).abs() < 1e-9, "{overlap}");
    let report = std::fs::read_to_string(folder.path.join("r/report.html")).unwrap();
    assert!(report.contains("no contact is named"));
}
