//! A short run of the campaign of faults; the long one is `bench/campaigns/faults`.
#![cfg(target_os = "linux")]

use std::path::Path;

use serde_json::Value;

use crate::folder::Folder;
use stiction_fixtures::{faults, tamper};

#[test]
fn what_a_disturbed_run_leaves_is_true_or_refused_and_the_next_run_ends_with_the_same_bits() {
    let report = faults::campaign(Path::new(env!("CARGO_BIN_EXE_stiction")), 1, 24);
    assert!(report.findings.is_empty(), "{:#?}", report.findings);
    // Most of them are disturbed indeed.
    let well: usize = report.runs.iter().filter(|(kind, _)| kind.ends_with("exit 0")).map(|(_, number)| number).sum();
    assert!(well < 12, "{:#?}", report.runs);
}

/// A power cut between the last step and the summary: nothing is left to solve, and its iterations are told.
#[test]
fn a_run_resumed_after_its_last_step_tells_what_that_step_told() {
    let folder = Folder::new("resumed-at-the-end", &tamper::stepped_case());
    let solve = ["solve", "case.toml", "-o", "r", "--no-report"];
    folder.run(&solve).ends(0, &[]);
    let picture = std::fs::read(folder.at("r/convergence.png")).unwrap();
    let told = |summary: &Value| {
        let counts = ["iterations", "products", "solves", "coulomb_products"].map(|key| summary["counts"][key].clone());
        // Estimates need the factor, which nothing else asks for then.
        assert!(summary["coulomb"].is_object() && summary["counts"]["coulomb_products"].as_u64() > Some(0));
        (counts, ["status", "certificate", "coulomb"].map(|key| summary[key].clone()))
    };
    let before = told(&folder.summary("r"));
    assert!(before.0[0].as_u64() > Some(0), "{before:#?}");
    for name in ["summary.json", "SHA256SUMS", "convergence.png"] {
        std::fs::remove_file(folder.at("r").join(name)).unwrap();
    }
    folder.run(&[&solve[..], &["--resume"]].concat()).ends(0, &[]);
    assert_eq!(told(&folder.summary("r")), before);
    assert!(std::fs::read(folder.at("r/convergence.png")).unwrap() == picture, "another picture of convergence");
}

/// The block lifts off in the second case: there is no friction to draw.
#[test]
fn pictures_of_an_earlier_result_do_not_stay_beside_another() {
    let folder = Folder::new("stale-pictures", crate::folder::CASE);
    folder.run(&["solve", "case.toml", "-o", "r", "--no-report"]).ends(0, &[]);
    assert!(folder.exists("r/shear.png"));
    folder.write("r/own.png", "a picture of the user");
    folder.write("case.toml", tamper::stepped_case());
    folder.run(&["solve", "case.toml", "-o", "r", "--no-report"]).ends(0, &[]);
    assert!(!folder.exists("r/shear.png") && folder.exists("r/own.png"));
    folder.run(&["check", "r"]).ends(0, &[]);
}
