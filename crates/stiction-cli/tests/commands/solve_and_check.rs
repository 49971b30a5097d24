//! The whole way: solve, look at the files, check them.

use crate::folder::{CASE, Folder};
use serde_json::Value;

const FILES: [&str; 16] = [
    "SHA256SUMS",
    "case.toml",
    "contact.csv",
    "contact.vtu",
    "convergence.png",
    "deformed.png",
    "error.png",
    "log.jsonl",
    "pressure.png",
    "problem.npz",
    "report.html",
    "result.vtu",
    "shear.png",
    "solution.npz",
    "status.png",
    "summary.json",
];

#[test]
fn a_solved_case_passes_its_check_until_a_number_is_changed() {
    let folder = Folder::new("check", CASE);
    let run = folder.run(&["solve", "case.toml"]);
    run.ends(0, &[]);
    assert!(run.out.contains("certificate  passed") && run.out.contains("uniqueness is not proved"), "{run:#?}");
    assert_eq!(folder.names_in("case-results"), FILES);
    let check = folder.run(&["check", "case-results"]);
    check.ends(0, &[]);
    assert!(check.out.contains("passed"), "{check:#?}");

    let path = folder.path.join("case-results/solution.npz");
    let mut bytes = std::fs::read(&path).unwrap();
    // The numbers of the first array begin behind its header of 128 bytes: halve one of them.
    let start = bytes.windows(6).position(|w| w == b"\x93NUMPY").unwrap() + 128;
    let at = start + 8 * 30;
    let value = f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    assert!(value != 0.0);
    bytes[at..at + 8].copy_from_slice(&(0.5 * value).to_le_bytes());
    std::fs::write(&path, &bytes).unwrap();
    // The archive's own checksum notices first.
    folder.run(&["check", "case-results"]).ends(2, &["solution.npz"]);
}

#[test]
fn a_changed_result_in_a_sound_file_fails_its_check() {
    let folder = Folder::new("changed", CASE);
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    let results = folder.path.join("case-results");
    let problem = stiction::io::problem::read_problem(&results.join("problem.npz")).unwrap().0;
    let (mut u, lambda) = stiction::io::problem::read_solution(&results.join("solution.npz"), &problem).unwrap();
    u[30] *= 1.0 + 1e-5;
    stiction::io::problem::write_solution(&results.join("solution.npz"), &u, &lambda).unwrap();
    let check = folder.run(&["check", "case-results"]);
    check.ends(1, &[]);
    assert!(check.out.contains("exceeds the tolerance") && check.out.contains("failed"), "{check:#?}");
}

#[test]
fn a_summary_that_claims_something_else_fails_its_check() {
    let folder = Folder::new("claim", CASE);
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    let path = folder.path.join("case-results/summary.json");
    let mut summary = folder.summary("case-results");
    let force = summary["contact"]["normal_force"].as_f64().unwrap();
    summary["contact"]["normal_force"] = (1.1 * force).into();
    std::fs::write(&path, summary.to_string()).unwrap();
    let check = folder.run(&["check", "case-results"]);
    check.ends(1, &[]);
    assert!(check.out.contains("summary.json says normal force"), "{check:#?}");
    std::fs::write(&path, "{").unwrap();
    folder.run(&["check", "case-results"]).ends(2, &["summary.json"]);
    std::fs::remove_file(folder.path.join("case-results/problem.npz")).unwrap();
    folder.run(&["check", "case-results"]).ends(2, &["problem.npz"]);
}

#[test]
fn damaged_results_are_refused() {
    let folder = Folder::new("damaged", CASE);
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    let path = folder.path.join("case-results/problem.npz");
    let whole = std::fs::read(&path).unwrap();
    for length in [0, 1, 100, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&path, &whole[..length]).unwrap();
        folder.run(&["check", "case-results"]).ends(2, &["problem.npz", "remedy: "]);
    }
}

/// What a summary says without what differs from run to run.
fn numbers(mut summary: Value) -> Value {
    let map = summary.as_object_mut().unwrap();
    for key in ["seconds", "cpu_seconds", "peak_memory_bytes", "command"] {
        map.remove(key);
    }
    summary
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let folder = Folder::new("threads", &CASE.replace("[9, 3, 3]", "[18, 6, 6]"));
    for threads in ["1", "2"] {
        folder.run(&["solve", "case.toml", "--threads", threads, "-o", threads]).ends(0, &[]);
    }
    assert_eq!(numbers(folder.summary("1")), numbers(folder.summary("2")));
    for name in ["solution.npz", "problem.npz", "result.vtu", "contact.vtu", "pressure.png"] {
        let read = |threads: &str| std::fs::read(folder.path.join(threads).join(name)).unwrap();
        assert!(read("1") == read("2"), "{name}");
    }
}

#[test]
fn json_is_all_that_stands_on_standard_output() {
    let folder = Folder::new("json", CASE);
    let run = folder.run(&["solve", "case.toml", "--json", "--progress", "none", "-o", "a/b"]);
    run.ends(0, &["uniqueness"]);
    let printed: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(printed, folder.summary("a/b"));
    assert_eq!(printed["status"], "solved");
    assert!(printed["seconds"]["total"].as_f64().unwrap() > 0.0);
    let contact = &printed["contact"];
    let count = |name: &str| contact[name].as_u64().unwrap();
    assert_eq!(count("open") + count("stick") + count("slip"), count("points"));
    let force = |name: &str, i: usize| printed[name][i].as_f64().unwrap();
    // Loads, supports, and the obstacle that pushes up with the sum of lambda_n.
    let balance = force("load", 2) + force("reaction", 2) + contact["normal_force"].as_f64().unwrap();
    assert!(balance.abs() < 1e-6 * force("load", 2).abs(), "{balance}");
    let along = force("reaction", 0) + contact["tangential_force"][0].as_f64().unwrap();
    assert!(along.abs() < 1e-6 * force("load", 2).abs(), "friction on the body is balanced by the support: {along}");
}

#[test]
fn an_iteration_that_ends_short_says_so_and_keeps_its_files() {
    let folder = Folder::new("short", CASE);
    let run = folder.run(&["solve", "case.toml", "--set", "solver.max_iterations=2"]);
    run.ends(1, &["tolerance was not reached"]);
    assert!(run.out.contains("NOT PASSED"), "{run:#?}");
    let summary = folder.summary("case-results");
    assert_eq!(summary["status"], "max_iterations");
    assert_eq!(summary["certificate"]["passed"], false);
    assert_eq!(folder.names_in("case-results"), FILES);
    folder.run(&["check", "case-results"]).ends(1, &[]);
    let case = std::fs::read_to_string(folder.path.join("case-results/case.toml")).unwrap();
    assert!(case.starts_with(CASE) && case.contains("# --set solver.max_iterations=2"));
}

#[test]
fn a_method_is_chosen_told_and_judged_by_the_same_certificate() {
    let folder = Folder::new("method", CASE);
    let run = folder.run(&["solve", "case.toml", "-o", "cfs2", "--method", "cfs2", "--set", "solver.squares=3"]);
    run.ends(1, &["tolerance was not reached"]);
    // Three squares make a polygon of 12 sides that reaches sec(15 degrees) - 1 = 3.5 % beyond the disc.
    for words in ["cfs2, 3 squares (star)", "converged by its own rule", "12 sides", "3.5276 %", "method = \"newton\""]
    {
        assert!(run.out.contains(words), "{words} {run:#?}");
    }
    let summary = folder.summary("cfs2");
    assert_eq!((&summary["status"], &summary["method"]), (&"uncertified".into(), &"cfs2".into()));
    assert_eq!(summary["method_details"]["end"], "converged");
    let count = |name: &str| summary["counts"][name].as_u64().unwrap();
    assert!(count("iterations") > 2 && count("cg_steps") > 10 && count("products") > 3 * count("cg_steps"));
    assert_eq!(folder.names_in("cfs2"), FILES);
    folder.run(&["check", "cfs2"]).ends(1, &[]);

    let discs = ["solve", "case.toml", "-o", "discs", "--method", "msa1", "--set", "solver.inner=discs"];
    folder.run(&discs).ends(0, &[]);
    folder.run(&["check", "discs"]).ends(0, &[]);
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    let force = |folder_name: &str| folder.summary(folder_name)["contact"]["normal_force"].as_f64().unwrap();
    assert!((force("discs") / force("case-results") - 1.0).abs() < 1e-6);
    assert_eq!(folder.summary("case-results")["method"], "newton");

    folder.run(&["solve", "case.toml", "--method", "alg2"]).ends(2, &["given friction", "coulomb", "msa1"]);
    folder.run(&["solve", "case.toml", "--method", "alg3"]).ends(2, &["--method alg3", "alg2"]);
}

#[test]
fn a_case_without_contact_is_solved() {
    let (case, _) = CASE.split_once("[[contact]]").unwrap();
    let folder = Folder::new("free", case);
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    assert_eq!(folder.names_in("case-results").len(), 10);
    assert_eq!(folder.summary("case-results")["dual_dofs"], 0);
    folder.run(&["check", "case-results"]).ends(0, &[]);
    for method in ["alg1", "smalbe", "discs", "cfs2"] {
        folder.run(&["solve", "case.toml", "--method", method]).ends(0, &[]);
    }
}

#[test]
fn the_energy_counts_prescribed_displacements() {
    let case = r#"
        [mesh]
        block = { size = [3, 2, 1], cells = [3, 2, 2] }
        [materials.steel]
        young = 2e11
        poisson = 0.3
        [[fix]]
        on = "x-min"
        components = "x"
        [[fix]]
        on = "y-min"
        components = "y"
        [[fix]]
        on = "z-min"
        components = "z"
        [[fix]]
        on = "x-max"
        components = "x"
        value = [3e-3]
        [[load]]
        on = "x-max"
        traction = [5e7, 0, 0]
    "#;
    let folder = Folder::new("energy", case);
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    // A bar in uniaxial tension stores 1/2 E A L eps^2; the load does work on its end, where that is prescribed.
    let wanted = 0.5 * 2e11 * 2.0 * 3.0 * 1e-3 * 1e-3 - 5e7 * 2.0 * 3e-3;
    let found = folder.summary("case-results")["energy"].as_f64().unwrap();
    assert!((found - wanted).abs() < 1e-9 * wanted.abs(), "{found} instead of {wanted}");
}

#[test]
fn several_pairs_are_told_apart() {
    let second = "[[contact]]\non = \"y-max\"\nagainst = { plane = { point = [0, 1, 0], normal = [0, -1, 0] } }\n\
                  friction = \"none\"\n";
    let folder = Folder::new("pairs", &format!("{CASE}\n{second}"));
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    let summary = folder.summary("case-results");
    let of_pair = |i: usize, name: &str| summary["pairs"][i][name].as_f64().unwrap();
    assert_eq!(summary["pairs"][1]["name"], "y-max");
    let sum = of_pair(0, "normal_force") + of_pair(1, "normal_force");
    assert!((sum - summary["contact"]["normal_force"].as_f64().unwrap()).abs() < 1e-9 * sum);
    assert!(folder.exists("case-results/pressure-y-max.png") && !folder.exists("case-results/pressure.png"));
}

#[test]
fn the_commented_cases_solve() {
    let folder = Folder::new("templates", CASE);
    let list = folder.run(&["new", "--list"]);
    for name in list.out.lines().filter_map(|line| line.split_whitespace().next()) {
        folder.run(&["new", name, "--from", name]).ends(0, &[]);
        folder.run(&["solve", &format!("{name}/case.toml"), "-o", &format!("{name}-results")]).ends(0, &[]);
        folder.run(&["check", &format!("{name}-results")]).ends(0, &[]);
        // Each says how accurate its mesh is.
        let text = std::fs::read_to_string(folder.path.join(name).join("case.toml")).unwrap();
        let said = text.split("are off by about ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
        let estimated = 100.0 * folder.summary(&format!("{name}-results"))["discretisation_error"].as_f64().unwrap();
        let said: f64 = said.parse().unwrap();
        assert!((estimated / said - 1.0).abs() < 0.1, "{name}: {said} % is {estimated}");
    }
}

#[test]
fn the_comments_of_the_commented_cases_are_true() {
    let folder = Folder::new("comments", CASE);
    let states = |name: &str, set: &[&str]| {
        folder.run(&[&["solve", &format!("{name}/case.toml"), "-o", name][..], set].concat()).ends(0, &[]);
        let contact = folder.summary(name)["contact"].clone();
        let ratio = contact["tangential_force"][0].as_f64().unwrap() / contact["normal_force"].as_f64().unwrap();
        (["open", "stick", "slip"].map(|state| contact[state].as_u64().unwrap()), ratio)
    };
    for name in ["block", "brick", "sphere", "pair"] {
        folder.run(&["new", name, "--from", name]).ends(0, &[]);
    }
    let ([open, stick, slip], _) = states("block", &[]);
    assert!(open == 0 && stick > 0 && slip > 0, "the edges slip, the rest sticks");
    for (push, short) in [("3e-3", 0.02), ("1e-2", 0.001)] {
        let ([open, stick, _], ratio) = states("block", &["--set", &format!("fix.0.value=[{push}, 0, -2e-3]")]);
        assert!(open + stick == 0 && ratio > -0.3 && ratio < -0.3 * (1.0 - short), "{push}: all slip, {ratio}");
    }
    let ([open, stick, slip], _) = states("brick", &[]);
    assert!(stick == 0 && (3 * slip..4 * slip).contains(&open), "a quarter bears, or a little less: {slip} of {open}");
    let ([open, stick, slip], _) = states("sphere", &[]);
    assert!(open > 0 && stick > 0 && slip > 0, "a middle that sticks, a rim that slips, a gap");
    let ([open, _, slip], ratio) = states("pair", &[]);
    assert!(
        open == 0 && slip > 0 && ratio < 0.0 && ratio > -0.3,
        "the stamp is dragged back by no more than F: {ratio}"
    );
}

#[test]
fn contact_that_never_closes_is_said_so() {
    let folder = Folder::new("far", &CASE.replace("point = [0, 0, 0]", "point = [0, 0, -1]"));
    let run = folder.run(&["solve", "case.toml"]);
    run.ends(0, &[]);
    assert!(run.out.contains("no point is in contact"), "{run:#?}");
}

#[test]
fn a_case_in_its_own_result_folder_is_left_as_it_is() {
    let folder = Folder::new("own", CASE);
    folder.run(&["solve", "case.toml", "-o", ".", "--set", "solver.tolerance=1e-6"]).ends(0, &[]);
    assert_eq!(std::fs::read_to_string(folder.path.join("case.toml")).unwrap(), CASE);
    assert_eq!(folder.names(), FILES);
}

/// A block without any support, its weight and a push at the top, at rest on the floor.
const RESTING: &str = r#"
title = "Crate"
[mesh]
block = { size = [1, 1, 2], cells = [4, 4, 8], element = "hex8" }
[materials.wood]
young = 1e10
poisson = 0.3
density = 500
[[load]]
gravity = [0, 0, -9.81]
[[load]]
on = "z-max"
traction = [0, 1000, 0]
[[contact]]
on = "z-min"
against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = { coulomb = 0.6 }
"#;

#[test]
fn a_crate_rests_on_its_weight_alone() {
    let folder = Folder::new("resting", RESTING);
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    let summary = folder.summary("case-results");
    let weight = 9810.0;
    let close = |value: &Value, wanted: f64| (value.as_f64().unwrap() - wanted).abs() < 1e-8 * weight;
    assert!(close(&summary["contact"]["normal_force"], weight), "{summary:#}");
    let body = &summary["bodies"][0];
    assert_eq!((body["name"].as_str(), summary["bodies"].as_array().unwrap().len()), (Some("body"), 1));
    for (key, wanted) in [("load", [0.0, 1000.0, -weight]), ("contact", [0.0, -1000.0, weight]), ("support", [0.0; 3])]
    {
        assert!((0..3).all(|c| close(&body[key][c], wanted[c])), "{key} {body:#}");
    }
    assert!(body["moment_balance"].as_f64().unwrap() < 1e-8);
    folder.run(&["check", "case-results"]).ends(0, &[]);
    let told = std::fs::read_to_string(folder.path.join("case-results/summary.json")).unwrap();
    let mut changed = summary.clone();
    changed["bodies"][0]["contact"][1] = (-1100.0).into();
    std::fs::write(folder.path.join("case-results/summary.json"), changed.to_string()).unwrap();
    let check = folder.run(&["check", "case-results"]);
    check.ends(1, &[]);
    assert!(check.out.contains("contact y of body body") && !told.contains("no_equilibrium"), "{check:#?}");
}

#[test]
fn a_crate_that_cannot_rest_is_told_how_it_leaves() {
    let folder = Folder::new("leaving", RESTING);
    // It tips over at T = 9810 / 4 and slides at T = 0.6 * 9810; low friction slides first.
    let ends = |set: &[&str], motion: &str, facts: &[&str]| {
        let mut arguments = vec!["solve", "case.toml"];
        set.iter().for_each(|s| arguments.extend(["--set", s]));
        let run = folder.run(&arguments);
        run.ends(1, &["no equilibrium", motion]);
        assert!(run.out.contains("NOT SOLVED") && run.out.contains(motion), "{run:#?}");
        // What contact does, the forces and what to do; and no number that is none.
        for word in facts.iter().chain(&["remedy: "]) {
            assert!(run.out.contains(word), "{word}: {run:#?}");
        }
        run.ends(1, &facts[..facts.len() - 1]);
        assert!(!run.out.contains("e308"), "{run:#?}");
        assert!(!folder.run(&["check", "case-results"]).out.contains("e308"));
        assert!(!std::fs::read_to_string(folder.path.join("case-results/report.html")).unwrap().contains("e308\u{3c}"));
        let summary = folder.summary("case-results");
        assert_eq!(summary["status"], "no_equilibrium");
        assert!(summary["escape_mode"].as_str().unwrap().contains(motion));
        assert_eq!(summary["certificate"]["passed"], false);
    };
    folder.run(&["solve", "case.toml", "--set", "load.1.traction=[0, 2430, 0]"]).ends(0, &[]);
    ends(
        &["load.1.traction=[0, 2480, 0]"],
        "rotation about the axis along (-1, 0, 0) through (0.5, 1, 0)",
        &[
            "it tips over: 20 of its 25 contact points open",
            "push along the contact with 2480 and press on it with 9810: friction holds at most 0.6 x 9810 = 5886",
            "nearer to the contact",
        ],
    );
    ends(
        &["contact.0.friction.coulomb=0.1"],
        "the body: translation along y",
        &[
            "it slides: none of its 25 contact points opens",
            "the force (0, 1000, -9810)",
            "push along the contact with 1000 and press on it with 9810: friction holds at most 0.1 x 9810 = 981",
            "more friction",
        ],
    );
    ends(
        &["load.1.traction=[0, 0, 1e4]"],
        "the body: translation along z",
        &["it lifts off: all of its 25 contact points open", "the force (0, 0, 190)", "press it down"],
    );
    // Pulled up beside its middle it turns as well, which is no screw to a reader.
    ends(&["load.1.traction=[100, 200, \"1e4 + 1e3*x\"]"], "while it turns", &["it lifts off", "support"]);
    // Only Newton's method keeps the balance.
    folder.run(&["solve", "case.toml", "--method", "msa1"]).ends(2, &["held by contact alone", "newton"]);
}
