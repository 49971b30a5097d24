//! `--accuracy` from the command line: levels, files, ends, load steps.

use crate::folder::{CASE, Folder};

const STEPS: &str = "\n[[step]]\nname = \"half\"\nuntil = 0.5\n[[step]]\nname = \"whole\"\nuntil = 1\n";

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
    let stepped = CASE.replace("traction = [0, 0, 1e6]", "traction = [0, 0, \"1e6*t\"]") + STEPS;
    let folder = Folder::new("accuracy-steps", &stepped);
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
    folder.run(&["solve", "case.toml", "--accuracy", "2"]).ends(2, &["accuracy.energy", "0.02 is 2 %"]);
    folder.run(&["solve", "case.toml", "--accuracy", "good"]).ends(2, &["`energy` is \"good\"", "energy = \"2%\""]);
    folder.run(&["solve", "case.toml", "--accuracy", "80%"]).ends(2, &["0.01 % to 50 %"]);
    let elastic = CASE[..CASE.find("[[contact]]").unwrap()].to_string() + "[accuracy]\npressure = 0.05\n";
    let without = Folder::new("accuracy-elastic", &elastic);
    without.run(&["solve", "case.toml"]).ends(2, &["`pressure`", "no contact", "ask for `energy`"]);
    let small = ["solve", "case.toml", "--accuracy", "5%", "--set", "accuracy.max_unknowns=900"];
    folder.run(&small).ends(2, &["[mesh]", "the first mesh has", "more than `max_unknowns`", "coarser"]);
    let both = ["solve", "case.toml", "--accuracy", "5%", "--starts", "3"];
    folder.run(&both).ends(2, &["one answer of Newton's method", "`starts`"]);
    folder.run(&["solve", "case.toml", "--accuracy", "5%", "--resume"]).ends(2, &["--resume"]);
}
