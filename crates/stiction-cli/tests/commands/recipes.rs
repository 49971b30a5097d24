//! The cases to start from: each is solved as it is written by `stiction new`, certified, and held against statics or a
//! closed form.

use std::f64::consts::PI;

use crate::folder::{CASE, Folder, Run};
use serde_json::Value;
use stiction::io::case::templates;

/// The recipe solved with some values changed: how the command ended, and its summary.
fn solve(name: &str, set: &[String]) -> (Run, Value) {
    let folder = Folder::new(&format!("recipe-{name}-{}", set.len()), CASE);
    folder.run(&["new", "a", "--from", name]).ends(0, &[]);
    let mut arguments = vec!["solve", "a/case.toml", "-o", "r", "--progress", "none", "--no-report"];
    set.iter().for_each(|set| arguments.extend(["--set", set]));
    (folder.run(&arguments), folder.summary("r"))
}

/// The same, solved and certified in every step.
fn certified(name: &str, set: &[String]) -> Value {
    let (run, summary) = solve(name, set);
    run.ends(0, &[]);
    let steps = summary["steps"].as_array().map_or(&[][..], Vec::as_slice);
    let apart = |entry: &Value| entry["overlaps"].as_array().is_some_and(Vec::is_empty);
    let good = |entry: &Value| entry["status"] == "solved" && entry["certificate"]["passed"] == true && apart(entry);
    assert!(good(&summary) && steps.iter().all(good), "{name}");
    summary
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[track_caller]
fn near(value: f64, expected: f64, part: f64) {
    assert!((value / expected - 1.0).abs() <= part, "{value} is not {expected} within {part} of it");
}

fn pair<'a>(summary: &'a Value, name: &str) -> &'a Value {
    summary["pairs"].as_array().unwrap().iter().find(|pair| pair["name"] == name).unwrap()
}

/// The component of the contact force on a body.
fn contact_on(summary: &Value, body: &str, component: usize) -> f64 {
    let bodies = summary["bodies"].as_array().unwrap();
    number(&bodies.iter().find(|b| b["name"] == body).unwrap()["contact"][component])
}

#[test]
fn every_recipe_without_a_test_of_its_own_is_certified() {
    const OWN: [&str; 9] =
        ["press-fit", "flange", "bearing-seat", "wedge", "punch", "foundation", "gasket", "pad", "die"];
    let names: Vec<&str> = templates().iter().map(|t| t.name).collect();
    assert!(OWN.iter().all(|name| names.contains(name)));
    for name in names.iter().filter(|name| !OWN.contains(name)) {
        certified(name, &[]);
    }
}

/// Lamé's pressure of two rings in plane stress, without friction that would hinder them from changing their length.
/// Facets of the two meshes cross one another.
#[test]
fn the_press_fit_holds_with_lame() {
    let smooth = certified("press-fit", &["contact.0.friction=\"none\"".to_string()]);
    let rough = certified("press-fit", &[]);
    let (a, b, c, young, poisson, delta) = (10.0f64, 20.0f64, 40.0f64, 210e3, 0.3, 0.02);
    let hub = ((c * c + b * b) / (c * c - b * b) + poisson) / young;
    let shaft = ((b * b + a * a) / (b * b - a * a) - poisson) / young;
    let pressure = delta / (b * (hub + shaft));
    let force = pressure * b * 10.0 * PI / 2.0;
    near(number(&smooth["contact"]["normal_force"]), force, 3e-3);
    // Between plane stress and plane strain, which is stiffer by 1 / (1 - nu^2).
    let ratio = number(&rough["contact"]["normal_force"]) / force;
    assert!((1.0..1.1).contains(&ratio), "{ratio}");
}

/// Statics: the joint is pressed by the bolt less what the pipe pulls; friction in horizontal joints carries nothing of
/// it. A clearance is a rigid displacement: it costs shortening and no force.
#[test]
fn the_flange_is_pressed_by_its_bolt_less_the_pull() {
    let bolt = |step: &Value, key: &str| number(&step["bolts"][0][key]);
    let [open, closed] = [&[][..], &["contact.0.gap='closed'".to_string()]].map(|set| certified("flange", set));
    for (step, pull) in open["steps"].as_array().unwrap().iter().zip([0.0, 4e3, 8e3]) {
        let force = bolt(step, "force");
        near(number(&pair(step, "joint")["normal_force"]), force - pull, 1e-8);
        near(number(&pair(step, "under head")["normal_force"]), force, 1e-8);
        near(number(&pair(step, "under nut")["normal_force"]), force, 1e-8);
    }
    for (open, closed) in open["steps"].as_array().unwrap().iter().zip(closed["steps"].as_array().unwrap()) {
        near(bolt(open, "force"), bolt(closed, "force"), 1e-6);
        near(bolt(open, "shortening") - bolt(closed, "shortening"), 0.3, 1e-6);
    }
    near(bolt(&open["steps"][0], "force"), 20e3, 1e-6);
    // The joint gives way to the pull before the bolt does; where it opens it gives way no more.
    let [first, all] = [1, 2].map(|step| bolt(&open["steps"][step], "force") - 20e3);
    assert!(first > 0.0 && first < 0.05 * 4e3 && all - first > 2.0 * first && all < 0.2 * 8e3, "{first} {all}");
    let held = certified("flange", &["bolt.0.lock='pull'".to_string()]);
    near(number(&pair(&held, "joint")["normal_force"]), 12e3, 1e-6);
    near(bolt(&held, "force"), 20e3, 1e-6);
}

/// The resultant of `p cos` over a half of the bore; chords of three degrees are shorter than their arcs by 1e-4.
#[test]
fn the_housing_carries_what_the_balls_press() {
    let summary = certified("bearing-seat", &[]);
    near(contact_on(&summary, "housing", 1), -30.0 * 30.0 * 12.0 * PI / 4.0, 2e-3);
    near(contact_on(&summary, "housing", 1), number(&summary["load"][1]), 1e-8);
}

/// The limit of a wedge, `F/G = (tan a + mu) / (1 - mu tan a)`: 0.20202 and 0.306122 for `tan a = 0.1`.
#[test]
fn the_wedge_sticks_below_its_limit_and_leaves_above() {
    for (slope, friction, known) in [(0.1, 0.1, Some(0.20202)), (0.1, 0.2, Some(0.306122)), (0.25, 0.4, None)] {
        let limit = (slope + friction) / (1.0 - friction * slope);
        known.inspect(|known| near(limit, *known, 1e-5));
        let set = |ratio: f64| {
            vec![
                format!("load.0.gravity=['{}*9810', 0, -9810]", ratio * limit),
                format!("contact.0.friction.coulomb={friction}"),
                format!("mesh.turn.degrees=-{}", f64::atan(slope).to_degrees()),
                format!("contact.0.against.plane.normal=[-{slope}, 0, 1]"),
            ]
        };
        let below = certified("wedge", &set(0.999));
        // The normal force has no choice: G cos a + F sin a.
        let weight = 60.0 * 40.0 * 10.0 * 7.85e-9 * 9810.0;
        let angle = f64::atan(slope);
        near(number(&below["contact"]["normal_force"]), weight * (angle.cos() + 0.999 * limit * angle.sin()), 1e-8);
        let (run, above) = solve("wedge", &set(1.001));
        run.ends(1, &["no equilibrium"]);
        assert_eq!(above["status"], "no_equilibrium");
    }
}

/// R. B. King, Int. J. Solids Structures 23 (1987) 1657: a flat square punch on a half space. The block ends where a
/// half space still moves by `P (1 + nu) (3 - 2 nu) / (2 pi E z)` under the force P (Boussinesq, on the axis). The
/// foot seems larger by half a cell at its edge, which two grids in the same map take out.
#[test]
fn the_punch_meets_the_force_of_a_square_on_a_half_space() {
    let (young, poisson, depth, push) = (210e3, 0.3, 20.0, 0.01);
    let half_space = 1.012 * 2.0 / PI.sqrt() * young / (1.0 - poisson * poisson) * 2.0 * push;
    let missing = half_space * (1.0 + poisson) * (3.0 - 2.0 * poisson) / (2.0 * PI * young * depth);
    let expected = half_space / 4.0 / (1.0 - missing / push);
    let force = |cells: [usize; 3]| {
        let grading = |ratio: f64, n: usize, own: usize| {
            let (n, own) = (n as f64, own as f64);
            ratio.powf((own - 1.0) / own * n / (n - 1.0))
        };
        let [along, down] = [grading(137.798, 18, cells[0]), grading(0.01, 16, cells[2])];
        let set = [
            "contact.0.friction.coulomb=0".to_string(),
            format!("mesh.block.cells={cells:?}"),
            format!("mesh.block.grading=[{along}, {along}, {down}]"),
        ];
        number(&certified("punch", &set)["contact"]["normal_force"])
    };
    let (coarse, fine) = (force([18, 18, 16]), force([36, 36, 32]));
    println!("expected {expected}, got {coarse}, {fine} and in the limit {}", 2.0 * fine - coarse);
    assert!(coarse > fine && fine > expected);
    near(2.0 * fine - coarse, expected, 0.03);
    let rough = number(&certified("punch", &[])["contact"]["normal_force"]);
    assert!(rough > coarse && rough < 1.03 * coarse, "friction holds the surface a little: {rough}");
}

#[test]
fn the_ground_carries_weight_and_wind_until_the_block_slides() {
    let summary = certified("foundation", &[]);
    near(number(&summary["contact"]["normal_force"]), 2.4e-9 * 9810.0 * 2000f64.powi(3) + 100e3, 1e-8);
    near(number(&summary["contact"]["tangential_force"][0]), -40e3, 1e-6);
    let (run, summary) = solve("foundation", &["load.2.force=[150e3, 0, 0]".to_string()]);
    run.ends(1, &["no equilibrium"]);
    assert!(summary["escape_mode"].as_str().unwrap().contains("block"), "{summary}");
}

/// Statics again; loads over arcs are those over chords.
#[test]
fn the_gasket_keeps_the_bolts_less_the_pressure() {
    let summary = certified("gasket", &[]);
    let force = number(&pair(&summary, "lower face")["normal_force"]);
    near(force, 60e3 - 0.5 * PI / 4.0 * (55.0 * 55.0 - 10.0 * 10.0), 2e-3);
    near(force, -number(&summary["load"][2]), 1e-8);
}

/// The same with the cylinder that the triangles of the nose stand for; dragged on, all slips.
#[test]
fn a_die_from_a_file_presses_and_drags_like_the_cylinder_it_was_made_from() {
    let cylinder = "contact.0.against={ cylinder = { point = [20, 0, 40], axis = [0, 1, 0], radius = 30 }, \
                    motion = ['0.05*max(0, t - 1)', 0, '-0.1*min(t, 1)'] }";
    let (file, round) = (certified("die", &[]), certified("die", &[cylinder.to_string()]));
    for (file, round) in file["steps"].as_array().unwrap().iter().zip(round["steps"].as_array().unwrap()) {
        let [file, round] = [file, round].map(|step| &step["contact"]);
        near(number(&file["normal_force"]), number(&round["normal_force"]), 1e-4);
        let along = |contact: &Value| number(&contact["tangential_force"][0]) / number(&contact["normal_force"]);
        assert!((along(file) - along(round)).abs() < 1e-5);
    }
    let last = &file["contact"];
    assert!(last["stick"] == 0 && file["steps"][0]["contact"]["stick"] != 0);
    near(number(&last["tangential_force"][0]), 0.2 * number(&last["normal_force"]), 5e-3);
}

/// A recipe brings the files it names, and none of them is written over another.
#[test]
fn a_recipe_with_a_surface_leaves_files_of_others_alone() {
    let folder = Folder::new("recipe-files", CASE);
    std::fs::create_dir(folder.path.join("a")).unwrap();
    folder.write("a/die.stl", "mine");
    folder.run(&["new", "a", "--from", "die"]).ends(2, &["die.stl", "exists already", "another folder"]);
    assert_eq!(std::fs::read_to_string(folder.path.join("a/die.stl")).unwrap(), "mine");
    assert!(!folder.path.join("a/case.toml").exists());
}

/// Where all points slip, friction is the coefficient times the pressing force.
#[test]
fn the_pad_slides_at_its_coefficient_of_friction() {
    let summary = certified("pad", &[]);
    let contact = &summary["contact"];
    near(number(&contact["normal_force"]), 5.0 * 40.0 * 20.0, 1e-8);
    near(number(&contact["tangential_force"][0]), 0.35 * 4000.0, 1e-3);
    assert_eq!(contact["stick"], 0);
    // On the way there it sticks in part.
    let slips: Vec<f64> = summary["steps"].as_array().unwrap().iter().map(|s| number(&s["contact"]["slip"])).collect();
    assert!(slips.is_sorted() && slips[1] < slips[8], "{slips:?}");
}
