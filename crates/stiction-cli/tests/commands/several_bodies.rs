//! Shipped cases with contact between bodies: both ways of solving them agree, and what cannot rest says how it leaves.

use std::ops::ControlFlow;
use std::path::Path;

use crate::folder::Folder;
use stiction::friction::Status;
use stiction::io::case;
use stiction::linalg::norm;
use stiction::run::{Prepared, Settings, Step, prepare, solve, solve_steps};

/// Displacements and multipliers at the end of the case, solved by one path and by no other.
fn solved(name: &str, path: &str) -> (Vec<f64>, Vec<f64>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../cases/{name}/{name}.toml"));
    let case = case::read(&file, &[("solver.path".to_string(), path.to_string())]).unwrap_or_else(|e| panic!("{e}"));
    let mut prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let settings = Settings::of(&case.solver);
    let mut go_on = |_: &_| ControlFlow::Continue(());
    let mut keep = |_: &Prepared, step: &Step| {
        assert_eq!(format!("{:?}", step.outcome.solution.path).to_lowercase(), path, "{name}");
        Ok(())
    };
    let outcome = if case.steps.is_empty() {
        solve(&prepared, &settings, &mut go_on)
    } else {
        solve_steps(&mut prepared, &settings, None, &mut keep, &mut go_on)
    };
    let outcome = outcome.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(outcome.solution.status, Status::Solved, "{name} {path}");
    assert_eq!(format!("{:?}", outcome.solution.path).to_lowercase(), path, "{name}");
    (outcome.solution.u, outcome.solution.lambda)
}

/// Largest difference in the norm of the whole, relative.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    norm(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>()) / norm(b)
}

#[test]
fn both_paths_agree_between_bodies() {
    for name in ["cylinder", "joint", "patch", "rings", "slide"] {
        let [(u, lambda), (v, other)] = ["multigrid", "solves"].map(|path| solved(name, path));
        let differences = [apart(&u, &v), apart(&lambda, &other)];
        println!("{name}: {} unknowns, {:.1e} and {:.1e} apart", u.len(), differences[0], differences[1]);
        assert!(differences.iter().all(|&d| d < 1e-6), "{name}: {differences:?}");
    }
}

/// The limit is τ = F p at t = 2; just beyond it the upper block leaves along the shear.
#[test]
fn a_block_sheared_beyond_friction_is_told_to_slide_away() {
    let text = include_str!("../../../../cases/slide/slide.toml");
    let folder = Folder::new("slide", text);
    for path in ["solves", "multigrid"] {
        let path = format!("solver.path={path}");
        folder.run(&["solve", "case.toml", "--set", &path, "--set", "step.1.until=1.99999"]).ends(0, &[]);
        let run = folder.run(&["solve", "case.toml", "--set", &path, "--set", "step.1.until=2.00001"]);
        run.ends(1, &["no equilibrium", "at t = 2.0000", "body \"high\": translation along x"]);
        assert!(folder.summary("case-results")["status"] != "solved");
    }
}

/// On a slope of tanθ = 0.3 the upper part slides down along `(-1, 0, -0.3)` where F is less.
#[test]
fn a_body_on_too_steep_a_slope_is_told_to_slide_down() {
    let folder = Folder::new("slope", "");
    let case = concat!(env!("CARGO_MANIFEST_DIR"), "/../../cases/patch/patch.toml");
    for path in ["solves", "multigrid"] {
        let path = format!("solver.path={path}");
        let solve = |f: &str| {
            let friction = format!("contact.0.friction.coulomb={f}");
            folder.run(&["solve", case, "-o", "out", "--set", &path, "--set", &friction])
        };
        solve("0.3001").ends(0, &[]);
        solve("0.2999").ends(1, &["no equilibrium", "body \"high\": translation along (-0.957826, 0, -0.287348)"]);
    }
}

/// Once plates, head and nut all slide, the load is 0.3 + 0.15 of the clamping force, and no more is carried.
#[test]
fn the_bolted_joint_carries_what_friction_gives() {
    let folder = Folder::new("joint", "");
    let case = concat!(env!("CARGO_MANIFEST_DIR"), "/../../cases/joint/joint.toml");
    for path in ["solves", "multigrid"] {
        let path = format!("solver.path={path}");
        let load = "load.0.force=['2800*max(t - 1, 0)', 0, 0]";
        let run = folder.run(&["solve", case, "-o", "out", "--set", &path, "--set", load]);
        run.ends(
            1,
            &["of the last step that was solved friction resists at most", "body \"high\": translation along x"],
        );
        let summary = folder.summary("out");
        let solved = |step: &&serde_json::Value| step["status"] == "solved";
        let steps = summary["steps"].as_array().unwrap();
        let last = steps.iter().rev().find(solved).unwrap();
        let limit = 0.45 * last["pairs"][1]["normal_force"].as_f64().unwrap();
        let share = last["load"][0].as_f64().unwrap() / limit;
        println!("{path}: {share} of {limit}");
        // The shortest increment is 22 N, 0.008 of the limit.
        assert!(share > 0.98 && share < 1.0, "{share} of {limit}");
        // The plate slides, and the bolt beside it or with it: either takes 0.3 + 0.15 of what clamps.
        let sliding = &summary["sliding"];
        let of = |key: &str| sliding[key].as_f64().unwrap();
        assert!((of("friction") - limit).abs() < 1e-6 * limit, "{sliding} {limit}");
        // No cycles bring to rest what the loads overcome: a third of what the settings allow has to be enough to see it.
        // The counts are those of all attempts at the step.
        let cycles = summary["counts"]["cycles"].as_u64().unwrap();
        let attempts = steps[steps.len() - 1]["attempts"].as_u64().unwrap();
        assert!(cycles <= 333 * attempts, "{cycles} in {attempts} attempts");
        let pull = steps[steps.len() - 1]["load"][0].as_f64().unwrap();
        assert!((of("load") - pull).abs() < 1e-9 * pull && pull > 0.99 * limit, "{sliding} {pull}");
        let motion = sliding["motion"].as_str().unwrap();
        assert!(motion.contains("body \"high\"") && motion.contains("translation along x"), "{motion}");
        // What is reported of the step that failed is not where the plate went when nothing held it.
        let failed = 0.45 * steps[steps.len() - 1]["pairs"][1]["normal_force"].as_f64().unwrap();
        assert!(failed > 0.5 * limit && failed < 2.0 * limit, "{failed}");
    }
}

/// A soft pad and a lid that lie loose on a plate; `push` is the traction on top of the lid.
fn loose_stack(fixes: &str, push: &str, friction: f64) -> String {
    let block = |name: &str, size: &str, cells: &str, z: f64| {
        format!(
            "[mesh.parts.{name}]\nblock = {{ size = [{size}], cells = [{cells}], element = \"hex8\" }}\nmove = [0, 0, {z}]\n"
        )
    };
    let contact = |name: &str, on: &str, against: &str| {
        format!(
            "[[contact]]\nname = \"{name}\"\non = \"{on}\"\nagainst = \"{against}\"\nfriction = {{ coulomb = {friction} }}\n"
        )
    };
    [
        "title = \"A pad between a plate and a lid\"\n".into(),
        block("plate", "30, 20, 6", "6, 4, 2", 0.0),
        block("pad", "20, 20, 1", "10, 10, 1", 6.0),
        block("lid", "30, 20, 4", "9, 6, 1", 7.0),
        "[materials.steel]\non = [\"plate\", \"lid\"]\nyoung = 210e3\npoisson = 0.3\n".into(),
        "[materials.fibre]\non = \"pad\"\nyoung = 800\npoisson = 0.25\n".into(),
        format!("[[fix]]\non = \"plate.z-min\"\n{fixes}"),
        format!("[[load]]\non = \"lid.z-max\"\ntraction = {push}\n"),
        contact("lower", "pad.z-min", "plate.z-max"),
        contact("upper", "pad.z-max", "lid.z-min"),
    ]
    .concat()
}

/// Statics: each interface carries all of the load, whatever is between. The pad is 260 times softer than what it lies
/// between, and thin: a point's stiffness is that of the pad, and small differences of the forces on its faces bend it.
#[test]
fn a_soft_pad_between_loose_bodies_carries_the_load_on_both_paths() {
    let symmetry = "[[fix]]\non = [\"plate.x-min\", \"pad.x-min\", \"lid.x-min\"]\ncomponents = \"x\"\n\
                    [[fix]]\non = [\"plate.y-min\", \"pad.y-min\", \"lid.y-min\"]\ncomponents = \"y\"\n";
    // Normal and tangential force on the pad from below; supports of the planes of symmetry share in the second.
    let guided = (loose_stack(symmetry, "[0, 0, \"-0.3*x\"]", 0.3), 0.3 * 450.0 * 20.0, None);
    let free = (loose_stack("", "[2, -1, \"-5 - 0.3*x\"]", 0.5), 5.0 * 600.0 + 2700.0, Some([-1200.0, 600.0]));
    let laws: [&[&str]; 5] = [
        &[],
        &["contact.0.friction=none", "contact.1.friction=none"],
        &["contact.0.friction=bonded", "contact.1.friction=none"],
        &["contact.0.friction=bonded"],
        &["contact.1.friction=bonded"],
    ];
    for (number, (text, normal, tangential)) in [guided, free].into_iter().enumerate() {
        let folder = Folder::new(&format!("loose-{number}"), &text);
        for law in laws {
            if tangential.is_some() && law.contains(&"contact.1.friction=none") {
                continue; // Nothing would hold the lid.
            }
            let told = ["solves", "dense", "multigrid"].map(|path| {
                let path = format!("solver.path={path}");
                let mut arguments = vec!["solve", "case.toml", "-o", "out", "--set", &path];
                law.iter().for_each(|law| arguments.extend(["--set", law]));
                folder.run(&arguments).ends(0, &[]);
                let summary = folder.summary("out");
                for (pair, sign) in [(0, 1.0), (1, -1.0)] {
                    let forces = &summary["pairs"][pair];
                    let of = |value: &serde_json::Value| value.as_f64().unwrap();
                    assert!((of(&forces["normal_force"]) - normal).abs() < 1e-6 * normal, "{law:?} {path} {forces:#}");
                    for (c, expected) in tangential.iter().flatten().enumerate() {
                        let error = of(&forces["tangential_force"][c]) - sign * expected;
                        assert!(error.abs() < 1e-6 * normal, "{law:?} {path} {forces:#}");
                    }
                }
                let steps = summary["counts"]["iterations"].as_u64().unwrap();
                assert!(path.ends_with("multigrid") || steps <= 45, "{law:?} {path} {steps}");
                summary["displacement_max"].as_f64().unwrap()
            });
            assert!(told.iter().all(|u| (u - told[0]).abs() < 1e-6 * told[0]), "{law:?} {told:?}");
        }
    }
}

/// The low block is held at its foot and moved on the half `x <= 15` of its top, where the high block carries the contact
/// points then. What presses is what the high block's support takes, and the files of all steps say the same.
#[test]
fn a_slave_prescribed_in_part_is_solved_and_checked_in_load_steps() {
    let block = |name: &str, cells: &str, element: &str, z: f64| {
        format!(
            "[mesh.parts.{name}]\nblock = {{ size = [30, 20, 10], cells = [{cells}], element = \"{element}\" }}\nmove = [0, 0, {z}]\n"
        )
    };
    let text = [
        block("low", "12, 8, 4", "hex8", 0.0),
        block("high", "7, 5, 3", "tet4", 10.5),
        "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n".into(),
        "[[fix]]\non = \"low.z-min\"\n".into(),
        "[[fix]]\non = { box = [[-1, -1, 9.9], [15.1, 30, 10.1]] }\nvalue = [0, 0, \"1e-3*t\"]\n".into(),
        "[[fix]]\non = \"high.z-max\"\nvalue = [0, 0, \"-2e-3*t\"]\n".into(),
        "[[contact]]\nname = \"joint\"\non = \"low.z-max\"\nagainst = \"high.z-min\"\ngap = \"closed\"\nslave = \"on\"\n".into(),
        "friction = { coulomb = 0.2 }\n[[step]]\nuntil = 2\nincrements = 2\n".into(),
    ]
    .concat();
    let folder = Folder::new("held-in-part", &text);
    let told = ["solves", "multigrid"].map(|path| {
        let path = format!("solver.path={path}");
        folder.run(&["solve", "case.toml", "-o", "out", "--set", &path]).ends(0, &[]);
        folder.run(&["check", "out"]).ends(0, &[]);
        let summary = folder.summary("out");
        let of = |value: &serde_json::Value| value.as_f64().unwrap();
        let normal = of(&summary["contact"]["normal_force"]);
        let high = summary["bodies"].as_array().unwrap().iter().find(|body| body["name"] == "high").unwrap();
        assert!((of(&high["support"][2]) + normal).abs() < 1e-6 * normal, "{high} {normal}");
        for step in summary["steps"].as_array().unwrap() {
            let pairs = [0, 1].map(|pair| of(&step["pairs"][pair]["normal_force"]));
            assert!(pairs.iter().all(|force| *force > 0.2 * normal / 2.0), "{pairs:?}");
        }
        normal
    });
    assert!((told[0] - told[1]).abs() < 1e-6 * told[0], "{told:?}");
}
