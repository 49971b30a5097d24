//! Complete decks as the command reads them.

use crate::folder::{CASE, Folder};

const STEPS: &str = include_str!("../../../../tests/data/decks/steps.inp");
const PRESS: &str = include_str!("../../../../tests/data/decks/press.inp");
const MATERIALS: &str = include_str!("../../../../tests/data/decks/materials.inp");

#[test]
fn a_deck_and_the_case_that_new_writes_of_it_have_the_same_answer_to_the_last_bit() {
    for (name, text) in [("press", PRESS), ("materials", MATERIALS)] {
        let folder = Folder::new(&format!("deck-{name}"), CASE);
        folder.write("model.inp", text);
        folder.run(&["solve", "model.inp", "-o", "direct", "--no-pictures", "--no-report"]).ends(0, &[]);
        folder.run(&["check", "direct"]).ends(0, &[]);
        let new = folder.run(&["new", "written", "--from", "model.inp"]);
        new.ends(0, &[]);
        assert!(new.out.contains("note: changes nothing here") || name != "press", "{new:#?}");
        folder.run(&["solve", "written/case.toml", "-o", "through", "--no-pictures", "--no-report"]).ends(0, &[]);
        let bytes = |results: &str| std::fs::read(folder.path.join(results).join("solution.npz")).unwrap();
        assert!(bytes("direct") == bytes("through"), "{name}");
        // Neither writes over files that are there.
        folder.run(&["new", "written", "--from", "model.inp"]).ends(2, &["exists already"]);
    }
}

#[test]
fn a_deck_takes_the_options_of_a_case_and_its_errors_name_their_line() {
    let folder = Folder::new("deck-options", CASE);
    folder.write("model.inp", PRESS);
    let run = folder.run(&["solve", "model.inp", "--set", "load.0.pressure=20", "--no-pictures", "--no-report"]);
    run.ends(0, &[]);
    let force = folder.summary("model-results")["pairs"][0]["normal_force"].as_f64().unwrap();
    assert!((force - 20.0).abs() < 1e-9 * 20.0, "{force}");
    assert!(run.out.contains("contact is solved hard"), "{run:#?}");
    folder.write("steps.inp", STEPS.replace("*CLEARANCE, SLAVE=Shigh", "*CLEARANCE, SLAVE=Snone"));
    folder.run(&["solve", "steps.inp"]).ends(2, &["steps.inp, line", "*CLEARANCE", "remedy"]);
    folder.run(&["solve", "none.inp"]).ends(2, &["none.inp", "cannot be read"]);
}
