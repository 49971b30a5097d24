//! `--accuracy` from the command line: levels, files, ends, load steps.

use crate::folder::{CASE, Folder};

const STEPS: &str = "\n[[step]]\nname = \"half\"\nuntil = 0.5\n[[step]]\nname = \"whole\"\nuntil = 1\n";

fn stepped() -> String {
    CASE.replace("traction = [0, 0, 1e6]", "traction = [0, 0, \"1e6*t\"]") + STEPS
}

#[test]
fn the_files_are_those_of_the_last_mesh_and_the_summary_has_all() {
    let folder = Folder::new("accuracy", CASE);
    let run = folder.run(&["solve", "case.toml", "--accuracy", "5%"]);
    run.ends(0, &[]);
    for what in ["mesh  1", "mesh  3", "reached on mesh", "energy norm", "normal force", "within"] {
        assert!(run.out.contains(what), "{what}: {run:#?}");
    }
    let summary = folder.summary("case-results");
    let accuracy = &summary["accuracy"];
    assert_eq!((accuracy["reached"].as_bool(), accuracy["goals"][0]["asked"].as_f64()), (Some(true), Some(0.05)));
    let levels = accuracy["levels"].as_array().unwrap();
    let last = levels.last().unwrap();
    assert!(last["error"].as_f64().unwrap() <= 0.05 && levels[0]["error"].as_f64().unwrap() > 0.05, "{levels:?}");
    assert_eq!(last["unknowns"], summary["dofs"]);
    assert!(summary["overrides"][0].as_str().unwrap().contains("accuracy.energy"));
    let mesh = stiction::io::vtu_read::read(&folder.path.join("case-results/result.vtu"), 1.0).unwrap().0;
    assert_eq!(mesh.cell_count() as u64, last["cells"].as_u64().unwrap());
    assert!(std::fs::read_to_string(folder.path.join("case-results/report.html")).unwrap().contains("Error bar"));
    folder.run(&["check", "case-results"]).ends(0, &[]);
}

#[test]
fn what_is_not_reached_is_said_and_the_files_are_there() {
    let folder = Folder::new("accuracy-short", CASE);
    let run = folder.run(&["solve", "case.toml", "--accuracy", "0.5%", "--set", "accuracy.max_unknowns=5000"]);
    run.ends(1, &["the accuracy was not reached", "`max_unknowns`"]);
    assert!(run.out.contains("NOT REACHED") && run.out.contains("unknowns are needed"), "{run:#?}");
    let accuracy = &folder.summary("case-results")["accuracy"];
    assert!(accuracy["needed_unknowns"].as_f64().unwrap() > 5000.0, "{accuracy}");
    folder.run(&["check", "case-results"]).ends(0, &[]);
}

#[test]
fn load_steps_are_solved_on_one_mesh_from_the_beginning() {
    let folder = Folder::new("accuracy-steps", &stepped());
    let run = folder.run(&["solve", "case.toml", "--accuracy", "8%"]);
    run.ends(0, &[]);
    let summary = folder.summary("case-results");
    let cells = summary["accuracy"]["levels"].as_array().unwrap().last().unwrap()["cells"].as_u64().unwrap();
    for step in ["result-0001.vtu", "result-0002.vtu"] {
        let mesh = stiction::io::vtu_read::read(&folder.path.join("case-results").join(step), 1.0).unwrap().0;
        assert_eq!(mesh.cell_count() as u64, cells);
    }
    assert!(!folder.path.join("case-results/level").exists());
    folder.run(&["check", "case-results"]).ends(0, &[]);
}

#[test]
fn goals_without_sense_are_refused() {
    let folder = Folder::new("accuracy-bad", CASE);
    folder.run(&["solve", "case.toml", "--accuracy", "2"]).ends(2, &["--accuracy 2", "did you mean 2%?", "0.02"]);
    folder.run(&["solve", "case.toml", "--accuracy", "good"]).ends(2, &["`energy` is \"good\"", "energy = \"2%\""]);
    folder.run(&["solve", "case.toml", "--accuracy", "80%"]).ends(2, &["0.01 % to 50 %"]);
    let elastic = CASE[..CASE.find("[[contact]]").unwrap()].to_string() + "[accuracy]\npressure = 0.05\n";
    let without = Folder::new("accuracy-elastic", &elastic);
    without.run(&["solve", "case.toml"]).ends(2, &["`pressure`", "no contact", "ask for `energy`"]);
    let small = ["solve", "case.toml", "--accuracy", "5%", "--set", "accuracy.max_unknowns=900"];
    folder.run(&small).ends(2, &["[mesh]", "the first mesh has", "more than `max_unknowns`", "coarser"]);
    let both = ["solve", "case.toml", "--accuracy", "5%", "--starts", "3"];
    folder.run(&both).ends(2, &["one answer of Newton's method", "`starts`"]);
}

/// Unknowns, estimate and values of each level: what a resumed run has to share with one that was not interrupted.
fn levels(folder: &Folder, results: &str) -> Vec<serde_json::Value> {
    let levels = folder.summary(results)["accuracy"]["levels"].as_array().unwrap().clone();
    levels.iter().map(|level| serde_json::json!([level["unknowns"], level["error"], level["values"]])).collect()
}

#[test]
fn a_run_goes_on_after_its_last_mesh() {
    for (name, case, end, stricter) in
        [("accuracy-resume", CASE.to_string(), "4%", "2.5%"), ("accuracy-resume-steps", stepped(), "7%", "4%")]
    {
        let folder = Folder::new(name, &case);
        let whole = ["solve", "case.toml", "--accuracy", end, "-o", "whole"];
        folder.run(&whole).ends(0, &[]);
        let limit = ["solve", "case.toml", "--accuracy", end, "-o", "part", "--set", "accuracy.max_unknowns=6000"];
        folder.run(&limit).ends(1, &["`max_unknowns`"]);
        let before = levels(&folder, "part").len();
        let resumed = folder.run(&["solve", "case.toml", "--accuracy", end, "-o", "part", "--resume"]);
        resumed.ends(0, &[]);
        assert!(resumed.out.contains(&format!("resuming after mesh {before} with")), "{resumed:#?}");
        assert!(!resumed.out.contains(&format!("mesh {before:>2}  ")), "{resumed:#?}");
        assert!(before < levels(&folder, "whole").len());
        assert_eq!(levels(&folder, "whole"), levels(&folder, "part"));
        folder.run(&["check", "part"]).ends(0, &[]);
        // A stricter goal goes on from there.
        let on = folder.run(&["solve", "case.toml", "--accuracy", stricter, "-o", "whole", "--resume"]);
        on.ends(0, &[]);
        assert!(levels(&folder, "whole").len() > levels(&folder, "part").len());
    }
}

#[test]
fn only_levels_of_the_same_case_are_gone_on_from() {
    let folder = Folder::new("accuracy-resume-other", CASE);
    folder.run(&["solve", "case.toml", "--accuracy", "6%"]).ends(0, &[]);
    let again = |more: [&str; 2]| {
        folder.run(&["solve", "case.toml", "--accuracy", "5%", "--resume", "-o", "case-results", more[0], more[1]])
    };
    again(["--set", "load.1.traction=[0, 0, 2e6]"]).ends(2, &["another case", "-o DIR"]);
    again(["--set", "mesh.block.cells=[8, 3, 3]"]).ends(2, &["another case"]);
    again(["--set", "accuracy.element=tet4"]).ends(2, &["another case"]);
    let file = folder.path.join("case-results/refinement.npz");
    let mut bytes = std::fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&file, bytes).unwrap();
    again(["--threads", "2"]).ends(2, &["refinement.npz", "without --resume"]);
    std::fs::remove_file(&file).unwrap();
    let anew = again(["--threads", "2"]);
    anew.ends(0, &[]);
    assert!(anew.out.contains("nothing to resume in case-results"), "{anew:#?}");
    // Without an accuracy the levels are those of another run.
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    assert!(!file.exists());
}
