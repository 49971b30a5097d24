//! `[accuracy] proven = true`: a bound of the error in report, summary and result.vtu.

use crate::folder::{CASE, Folder};

const PROVEN: &str = "\n[accuracy]\nproven = true\n";

#[test]
fn a_bound_is_proven_on_the_mesh_of_the_case_and_without_friction_says_so() {
    let quadratic = CASE.replace("element = \"hex8\"", "element = \"tet10\"");
    assert_ne!(quadratic, CASE);
    for (case, standing) in
        [(quadratic.clone(), "proven at the friction limits found"), (frictionless(&quadratic), "proven")]
    {
        let folder = Folder::new("bound", &(case + PROVEN));
        let run = folder.run(&["solve", "case.toml"]);
        run.ends(0, &[]);
        assert!(run.out.contains(&format!("{standing}: the error of the stresses in the mean is at most")), "{run:#?}");
        let summary = folder.summary("case-results");
        let bound = &summary["bound"];
        assert_eq!(bound["standing"], standing);
        let [error, mean] = ["error", "mean_error"].map(|key| bound[key].as_f64().unwrap());
        // The estimate is of the error that is bounded, and good to a third on meshes like this.
        let estimate = summary["discretisation_error"].as_f64().unwrap();
        assert!(error > 0.7 * estimate && mean < error, "{bound}");
        let energy = bound["energy"].as_array().unwrap();
        assert!(energy[0].as_f64() < energy[1].as_f64(), "{bound}");
        assert!(summary.get("accuracy").is_none(), "nothing was refined");
        let fields = std::fs::read(folder.path.join("case-results/result.vtu")).unwrap();
        assert!(String::from_utf8_lossy(&fields).contains("mean_stress"));
        assert!(
            std::fs::read_to_string(folder.path.join("case-results/report.html"))
                .unwrap()
                .contains("of the mean stress")
        );
        folder.run(&["check", "case-results"]).ends(0, &[]);
    }
}

#[test]
fn where_there_is_no_proof_the_reason_stands_there() {
    let folder = Folder::new("bound-none", &(CASE.to_string() + PROVEN));
    let run = folder.run(&["solve", "case.toml"]);
    run.ends(0, &[]);
    assert!(run.out.contains("none: the mesh has hexahedra"), "{run:#?}");
    let bound = folder.summary("case-results")["bound"].clone();
    assert_eq!((bound["standing"].as_str(), bound.get("error")), (Some("none"), None));
}

/// The case with the friction taken out.
fn frictionless(case: &str) -> String {
    let lines = case.lines().map(|line| match line.starts_with("friction") {
        true => "friction = \"none\"".to_string(),
        false => line.to_string(),
    });
    lines.collect::<Vec<_>>().join("\n")
}
