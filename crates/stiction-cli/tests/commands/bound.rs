//! `[accuracy] proven = true`: a bound of the error in report, summary and result.vtu.

use stiction::certificate::{BoundClaim, BoundFields};
use stiction::io::bound::{read_bound, write_bound};

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
        let checked = folder.run(&["check", "case-results"]);
        checked.ends(0, &[]);
        assert!(checked.out.contains("the bound of the discretisation error is proven"), "{checked:#?}");
    }
}

#[test]
fn a_bound_without_its_proof_does_not_pass() {
    let quadratic = CASE.replace("element = \"hex8\"", "element = \"tet10\"");
    let folder = Folder::new("bound-wrong", &(quadratic + PROVEN));
    folder.run(&["solve", "case.toml"]).ends(0, &[]);
    let file = folder.path.join("case-results/bound.npz");
    let (fields, claim) = read_bound(&file).unwrap();
    let judged = |fields: &BoundFields, claim: &BoundClaim, says: &str| {
        write_bound(&file, fields, claim).unwrap();
        let run = folder.run(&["check", "case-results"]);
        run.ends(1, &[]);
        assert!(run.out.contains(says), "{says}: {run:#?}");
    };
    let mut wrong = fields.clone();
    wrong.stress[3].iter_mut().flatten().for_each(|stress| stress[0] *= 1.0 + 1e-4);
    judged(&wrong, &claim, "continuity across faces");
    // The file and the summary have to say the same.
    let half = BoundClaim { error: 0.5 * claim.error, ..claim };
    judged(&fields, &half, "bound.npz: bound of the error missed");
    std::fs::write(&file, b"not an archive").unwrap();
    folder.run(&["check", "case-results"]).ends(2, &["bound.npz", "solve the case again"]);
    std::fs::remove_file(&file).unwrap();
    folder.run(&["check", "case-results"]).ends(2, &["bound.npz"]);
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
