//! The shipped cases: every number that `cases/*/expect.toml` states, with its source. What was obtained is kept for the
//! verification manual: `tmp/obtained/NAME.json` in the target folder.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use stiction::fem::{Solid, von_mises};
use stiction::friction::Status;
use stiction::io::case;
use stiction::run::{Origin, Outcome, Prepared, Settings, Step, prepare, solve, solve_steps, summary};

const CASES: [&str; 15] = [
    "block",
    "brick",
    "cattaneo",
    "cone",
    "cylinder",
    "greco",
    "hertz",
    "joint",
    "lug",
    "mindlin",
    "patch",
    "pretension",
    "rings",
    "several",
    "slide",
];

#[test]
fn pushed_blocks_obey_their_closed_forms() {
    run_case("block");
}

#[test]
fn the_brick_agrees_with_two_independent_programs() {
    run_case("brick");
}

#[test]
fn the_cylinder_agrees_with_hertz_and_nafems() {
    run_case("cylinder");
}

#[test]
fn a_cone_from_a_file_presses_as_in_the_closed_form() {
    run_case("cone");
}

#[test]
fn a_body_that_may_stick_slip_or_open_is_found_in_all_three_states() {
    run_case("several");
}

#[test]
fn the_shrink_fit_agrees_with_lame() {
    run_case("rings");
}

#[test]
fn a_linear_displacement_passes_a_slope_between_two_meshes() {
    run_case("patch");
}

#[test]
fn a_sheared_block_sticks_up_to_the_limit_of_friction() {
    run_case("slide");
}

#[test]
fn the_forces_in_the_bolted_joint_balance() {
    run_case("joint");
}

#[test]
fn a_bolt_tightened_by_force_clamps_by_that_force() {
    run_case("pretension");
}

#[test]
fn the_plate_agrees_with_the_published_displacements() {
    run_case("greco");
}

#[test]
fn the_block_on_a_ball_agrees_with_hertz() {
    run_case("hertz");
}

#[test]
fn the_pin_carries_what_pulls_the_lug() {
    run_case("lug");
}

#[test]
fn the_block_pushed_to_and_fro_on_a_ball_agrees_with_mindlin() {
    run_case("mindlin");
}

#[test]
fn two_cylinders_sheared_to_and_fro_agree_with_cattaneo() {
    run_case("cattaneo");
}

#[test]
fn no_case_is_left_out() {
    let entries = std::fs::read_dir(folder("")).unwrap().map(|e| e.unwrap()).filter(|e| e.path().is_dir());
    let mut found: Vec<String> = entries.map(|e| e.file_name().into_string().unwrap()).collect();
    found.sort();
    assert_eq!(found, CASES);
}

/// Where the edge of contact lies within a cell makes each single error jump, so each is the root mean square over
/// three depths of pressing.
#[test]
fn the_errors_of_hertz_fall_with_the_cells() {
    const MEASURES: [&str; 4] = ["radius_error", "centre_error", "peak_error", "pressure_error"];
    let measure = |n: f64| {
        // The same map from the unit cube to the graded block on every grid.
        let grading = 32f64.powf((n - 1.0) / n);
        let mut squares = [0.0; 4];
        for depth in [0.8e-3, 1.0e-3, 1.2e-3] {
            let cells = format!("mesh.block.cells=[{n}, {n}, {n}]");
            let set = [cells, format!("mesh.block.grading={:?}", [grading; 3]), format!("fix.2.value=-{depth}")];
            let solved = Solved::new(&folder("hertz").join("hertz.toml"), &set);
            MEASURES.iter().zip(&mut squares).for_each(|(name, s)| *s += solved.hertz(name).powi(2) / 3.0);
        }
        squares.map(f64::sqrt)
    };
    let errors = [5.0, 10.0, 20.0].map(measure);
    println!("{MEASURES:?}");
    errors.iter().for_each(|e| println!("{e:.4?}"));
    for pair in errors.windows(2) {
        assert!((0..4).all(|i| pair[1][i] < 0.6 * pair[0][i]), "{errors:?}");
    }
    assert!(errors[2].iter().zip([0.01, 0.01, 0.03, 0.06]).all(|(e, bound)| *e < bound), "{errors:?}");
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases").join(name)
}

/// Runs a case with every variant its list of expectations names, and keeps the numbers; all failures are reported
/// together.
fn run_case(name: &str) {
    let text = std::fs::read_to_string(folder(name).join("expect.toml")).unwrap();
    let expected: toml::Table = text.parse().unwrap();
    let (mut failures, mut runs) = (String::new(), Vec::new());
    for run in expected["run"].as_array().unwrap() {
        let set: Vec<String> = list(run, "set").iter().map(|v| v.as_str().unwrap().to_string()).collect();
        let solved = Solved::new(&folder(name).join(format!("{name}.toml")), &set);
        let mut values = Vec::new();
        for expect in list(run, "expect") {
            let found = solved.found(expect);
            if let Err(message) = judge(found, expect) {
                failures += &format!("{name} {set:?}: {message}\n");
            }
            values.push(json!({ "expect": expect, "found": found }));
        }
        let facts = ["dofs", "dual_dofs", "path", "status"].map(|key| (key.to_string(), solved.summary[key].clone()));
        runs.push(json!({ "set": set, "facts": serde_json::Map::from_iter(facts), "values": values }));
    }
    let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join("obtained");
    std::fs::create_dir_all(&kept).unwrap();
    let record = json!({ "case": name, "expect": text, "runs": runs });
    std::fs::write(kept.join(format!("{name}.json")), format!("{record:#}\n")).unwrap();
    assert!(failures.is_empty(), "\n{failures}");
}

/// Whether a number is what is expected of it, and else what it should be.
fn judge(found: f64, expect: &toml::Value) -> Result<(), String> {
    let source = expect["source"].as_str().unwrap();
    let fail = |wanted: String| Err(format!("{found:e} for {expect}, which is to be {wanted} ({source})"));
    if let Some(value) = expect.get("value").map(number) {
        let allowed = match (expect.get("rel"), expect.get("abs")) {
            (Some(rel), None) => number(rel) * value.abs(),
            (None, Some(abs)) => number(abs),
            (None, None) => 0.0, // a count
            _ => panic!("{expect} has both rel and abs"),
        };
        if (found - value).abs() <= allowed { Ok(()) } else { fail(format!("{value:e} within {allowed:e}")) }
    } else {
        let low = expect.get("above").map_or(f64::NEG_INFINITY, number);
        let high = expect.get("below").map_or(f64::INFINITY, number);
        assert!(low.is_finite() || high.is_finite(), "{expect} expects nothing");
        if found > low && found < high { Ok(()) } else { fail(format!("between {low:e} and {high:e}")) }
    }
}

fn list<'a>(value: &'a toml::Value, key: &str) -> &'a [toml::Value] {
    value.get(key).map_or(&[], |v| v.as_array().unwrap())
}

/// A number of an expectation; TOML distinguishes 1 and 1.0.
fn number(value: &toml::Value) -> f64 {
    value.as_float().or(value.as_integer().map(|i| i as f64)).unwrap()
}

struct Solved {
    prepared: Prepared,
    outcome: Outcome,
    summary: Value,
    /// Multipliers at the end of each load step.
    steps: Vec<Vec<f64>>,
}

impl Solved {
    /// Solves a case, which must be certified.
    fn new(path: &Path, set: &[String]) -> Solved {
        let pair = |s: &String| s.split_once('=').map(|(k, v)| (k.to_string(), v.to_string())).unwrap();
        let case = case::read(path, &set.iter().map(pair).collect::<Vec<_>>()).unwrap_or_else(|e| panic!("{e}"));
        let mut prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
        let (settings, mut steps) = (Settings::of(&case.solver), Vec::new());
        let mut go_on = |_: &_| ControlFlow::Continue(());
        let mut keep = |_: &Prepared, step: &Step| {
            steps.push(step.outcome.solution.lambda.clone());
            Ok(())
        };
        let outcome = if case.steps.is_empty() {
            solve(&prepared, &settings, &mut go_on)
        } else {
            solve_steps(&mut prepared, &settings, None, &mut keep, &mut go_on)
        };
        let outcome = outcome.unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(outcome.solution.status, Status::Solved, "{path:?} {set:?}");
        // No body of them lies in another.
        let overlaps = outcome.steps.iter().flat_map(|step| &step.answer.overlaps).collect::<Vec<_>>();
        assert!(outcome.overlaps.is_empty() && overlaps.is_empty(), "{:?} {overlaps:?}", outcome.overlaps);
        let summary = serde_json::from_str(&summary(&prepared, &outcome, &Origin::default())).unwrap();
        Solved { prepared, outcome, summary, steps }
    }

    /// What an expectation speaks of: a key of the summary (with another added, `plus`, or over
    /// another, `per`), a nodal value, a measure of Hertz's contact of a ball or along a line, or of Mindlin.
    fn found(&self, expect: &toml::Value) -> f64 {
        let text = |key: &str| expect.get(key).map(|v| v.as_str().unwrap());
        if let Some(name) = text("hertz") {
            return self.hertz(name);
        }
        let step = || expect.get("step").map_or(0, |s| s.as_integer().unwrap() as usize);
        if let Some(name) = text("mindlin") {
            return self.mindlin(name, step());
        }
        if let Some(name) = text("cone") {
            return self.cone(name, step());
        }
        if let Some(name) = text("cattaneo") {
            return self.cattaneo(name, step());
        }
        if let Some(name) = text("line") {
            return self.line(name);
        }
        if let Some(key) = text("key") {
            let sum = self.key(key) + text("plus").map_or(0.0, |key| self.key(key));
            return sum / text("per").map_or(1.0, |key| self.key(key));
        }
        let at: Vec<f64> = expect["at"].as_array().unwrap().iter().map(number).collect();
        let distance = |x: &[f64; 3]| (0..3).map(|c| (x[c] - at[c]).abs()).fold(0.0, f64::max);
        let nodes = &self.prepared.mesh.nodes;
        let node = (0..nodes.len()).min_by(|&i, &j| distance(&nodes[i]).total_cmp(&distance(&nodes[j]))).unwrap();
        assert!(distance(&nodes[node]) < 1e-9, "no node at {at:?}");
        match text("field").unwrap() {
            "displacement" => {
                let u = stiction::fem::full_displacement(&self.prepared.model, &self.outcome.solution.u);
                u[3 * node + expect["component"].as_integer().unwrap() as usize]
            }
            "pressure" => {
                let point = self.nodes().iter().position(|&n| n == node).unwrap();
                self.outcome.solution.lambda[point] / self.prepared.problem.labels.area[point]
            }
            other => panic!("no field {other}"),
        }
    }

    /// A number of the summary by its path, or one that follows from the matrices.
    fn key(&self, path: &str) -> f64 {
        if let Some(component) = path.strip_prefix("contact_force.") {
            return self.contact_force()[component.parse::<usize>().unwrap()];
        }
        let value = path.split('.').fold(&self.summary, |value, key| match key.parse::<usize>() {
            Ok(i) => &value[i],
            Err(_) => &value[key],
        });
        value.as_f64().unwrap_or_else(|| panic!("the summary has no number {path}"))
    }

    /// The force of the obstacle on the body, `-Bᵀ lambda` summed over all nodes.
    fn contact_force(&self) -> [f64; 3] {
        let (problem, dofs) = (&self.prepared.problem, &self.prepared.model.dofs);
        let lambda = &self.outcome.solution.lambda;
        let free = problem.contact.B.transpose_times(lambda).into_iter().zip(&dofs.free);
        let held =
            problem.labels.supports.as_ref().unwrap().B.transpose_times(lambda).into_iter().zip(&dofs.prescribed);
        let mut sum = [0.0; 3];
        free.chain(held).for_each(|(force, dof)| sum[*dof as usize % 3] -= force);
        sum
    }

    /// The node of each contact point.
    fn nodes(&self) -> Vec<usize> {
        let contacts = self.prepared.facts.contacts.iter();
        contacts.flat_map(|contact| contact.surface.nodes.iter().map(|&node| node as usize)).collect()
    }

    /// The cylinder on the block against Hertz at the computed force, of which half is in the model: `half_width` from the
    /// second moment of the pressure, `sum(l x²) = 1/4 b² sum(l)` for a semi-ellipse, and its relative error; the error of
    /// the greatest pressure.
    fn line(&self, name: &str) -> f64 {
        let (m, lambda) = (self.prepared.problem.points(), &self.outcome.solution.lambda);
        let half: f64 = lambda[..m].iter().sum();
        let compliance = 0.91 / 210e3 + 0.91 / 70e3;
        let exact = (4.0 * 2.0 * half * 50.0 * compliance / std::f64::consts::PI).sqrt();
        let greatest = 2.0 * 2.0 * half / (std::f64::consts::PI * exact);
        let x = |j: usize| self.prepared.mesh.nodes[self.nodes()[j]][0];
        let width = 2.0 * ((0..m).map(|j| lambda[j] * x(j).powi(2)).sum::<f64>() / half).sqrt();
        match name {
            "half_width" => width,
            "width_error" => width / exact - 1.0,
            "peak_error" => self.key("contact.max_pressure") / greatest - 1.0,
            other => panic!("no measure {other}"),
        }
    }

    /// Relative errors against Hertz at the computed force; the model is a quarter of the block.
    ///
    /// The radius is that of the semi-ellipsoid of pressure with the same second moment, `sum(l r²) = 2/5 a² sum(l)`;
    /// the number of points in contact would only know it to a cell. The peak is that of the semi-ellipsoid on the
    /// contact circle which comes nearest to the computed pressures; `centre_error` takes the point on the axis.
    fn hertz(&self, name: &str) -> f64 {
        let (radius, young, poisson) = (10.0, 210e3, 0.3f64);
        let problem = &self.prepared.problem;
        let (m, lambda, share) = (problem.points(), &self.outcome.solution.lambda, &problem.labels.unity_sum);
        let nodes = self.nodes();
        let x = |j: usize| self.prepared.mesh.nodes[nodes[j]];
        let r2 = |j: usize| x(j)[0].powi(2) + x(j)[1].powi(2);
        // what each point stands for, and the forces that act at the nodes: those of a point in the middle of an edge
        // of a quadratic face act at the ends as well
        let area: Vec<f64> = (0..m).map(|j| problem.labels.area[j] * share[j]).collect();
        let pressure = |j: usize| lambda[j] / problem.labels.area[j];
        let quarter: f64 = (0..m).map(|j| lambda[j] * share[j]).sum();
        let moment: f64 = self.nodal_forces().iter().map(|(x, force)| force * (x[0].powi(2) + x[1].powi(2))).sum();
        let sum = |term: &dyn Fn(usize) -> f64| (0..m).map(term).sum::<f64>();
        let a = (3.0 * 4.0 * quarter * radius * (1.0 - poisson * poisson) / (4.0 * young)).cbrt();
        let p0 = 3.0 * 4.0 * quarter / (2.0 * std::f64::consts::PI * a * a);
        let shape = |j: usize| (1.0 - r2(j) / (a * a)).max(0.0).sqrt();
        let norm2 = sum(&|j| area[j] * shape(j).powi(2));
        match name {
            "radius_error" => (2.5 * moment / quarter).sqrt() / a - 1.0,
            "area_error" => {
                let touching = sum(&|j| if lambda[j] > 0.0 { area[j] } else { 0.0 });
                (4.0 * touching / std::f64::consts::PI).sqrt() / a - 1.0
            }
            "peak_error" => sum(&|j| area[j] * pressure(j) * shape(j)) / norm2 / p0 - 1.0,
            "centre_error" => {
                let centre = (0..m).min_by(|&i, &j| r2(i).total_cmp(&r2(j))).unwrap();
                pressure(centre) / p0 - 1.0
            }
            "pressure_error" => (sum(&|j| area[j] * (pressure(j) / p0 - shape(j)).powi(2)) / norm2).sqrt(),
            // Below the centre the greatest shear stress is 0.31 p0, and both horizontal stresses are equal.
            "mises_error" => {
                let Prepared { mesh, materials, material_of_cell, model, .. } = &self.prepared;
                let u = stiction::fem::full_displacement(model, &self.outcome.solution.u);
                let stress = stiction::fem::cell_stress(&Solid { mesh, materials, material_of_cell }, &u, &[]);
                stress.iter().map(von_mises).fold(0.0, f64::max) / (2.0 * 0.31 * p0) - 1.0
            }
            other => panic!("no measure {other}"),
        }
    }

    /// A quarter of a block on a shallow cone after step `step` (from 1), relative errors. The contact radius is that of
    /// the pressure `p_m arcosh(a/r)` with the same second moment, `sum(l r²) = 1/3 a² sum(l)`.
    fn cone(&self, name: &str, step: usize) -> f64 {
        let (young, poisson, slope) = (210e3, 0.3f64, 0.02);
        let mean = 0.5 * slope * young / (1.0 - poisson * poisson);
        let (m, nodes, l) = (self.prepared.problem.points(), self.nodes(), &self.steps[step - 1]);
        let r2 = |j: usize| self.prepared.mesh.nodes[nodes[j]][..2].iter().map(|x| x * x).sum::<f64>();
        let force: f64 = l[..m].iter().sum();
        let radius = (3.0 * (0..m).map(|j| l[j] * r2(j)).sum::<f64>() / force).sqrt();
        let (area, shape) = (&self.prepared.problem.labels.area, |j: usize| (radius / r2(j).sqrt()).max(1.0).acosh());
        match name {
            "mean_error" => 4.0 * force / (std::f64::consts::PI * radius * radius) / mean - 1.0,
            // Beside the tip, where the pressure has no bound.
            "pressure_error" => {
                let beside = || (0..m).filter(|&j| r2(j) > 0.0);
                let off: f64 = beside().map(|j| area[j] * (l[j] / area[j] / mean - shape(j)).powi(2)).sum();
                (off / beside().map(|j| area[j] * shape(j).powi(2)).sum::<f64>()).sqrt()
            }
            other => panic!("no measure {other}"),
        }
    }

    /// Places of nodes and the force each exerts on the obstacle, along z.
    fn nodal_forces(&self) -> Vec<([f64; 3], f64)> {
        let Prepared { mesh, model, problem, .. } = &self.prepared;
        let (m, mut lambda) = (problem.points(), self.outcome.solution.lambda.clone());
        lambda[m..].fill(0.0);
        let forces = problem.contact.B.transpose_times(&lambda).into_iter().zip(&model.dofs.free);
        let along = forces.filter(|(_, dof)| *dof % 3 == 2);
        along.map(|(f, &dof)| (mesh.nodes[dof as usize / 3], -f)).collect()
    }

    /// Measures of the half block pushed along x on a ball, after step `step` (from 1).
    ///
    /// What friction lacks to its bound, `F l_n - l_x`, is a semi-ellipsoid on the circle that sticks: its second moment
    /// gives the radius as that of the pressure gives the radius of contact.
    fn mindlin(&self, name: &str, step: usize) -> f64 {
        let (coefficient, radius, young, poisson) = (0.3, 10.0, 210e3, 0.49f64);
        let (m, area, nodes) = (self.prepared.problem.points(), &self.prepared.problem.labels.area, self.nodes());
        let r2 = |j: usize| {
            let x = self.prepared.mesh.nodes[nodes[j]];
            x[0].powi(2) + x[1].powi(2)
        };
        let entry = |step: usize| &self.summary["steps"][step - 1];
        let number = |value: &Value| value.as_f64().unwrap();
        let normal = |step| number(&entry(step)["contact"]["normal_force"]);
        // Friction as a force on the body points against the push.
        let ratio = |step| -number(&entry(step)["contact"]["tangential_force"][0]) / (coefficient * normal(step));
        let contact_radius =
            |step| (3.0 * 2.0 * normal(step) * radius * (1.0 - poisson * poisson) / (4.0 * young)).cbrt();
        match name {
            "load" => ratio(step),
            "stick_radius" => {
                let l = &self.steps[step - 1];
                let sum = |term: &dyn Fn(usize) -> f64| (0..m).map(term).sum::<f64>();
                let squared = |force: &dyn Fn(usize) -> f64| sum(&|j| force(j) * r2(j)) / sum(force);
                (squared(&|j| coefficient * l[j] - l[m + j]) / squared(&|j| l[j])).sqrt()
            }
            "stick_area" => {
                let contact = &entry(step)["contact"];
                let (stick, slip) = (number(&contact["stick_area"]), number(&contact["slip_area"]));
                (stick / (stick + slip)).sqrt()
            }
            "traction_error" => {
                let (l, a) = (&self.steps[step - 1], contact_radius(step));
                let c = a * (1.0 - ratio(step)).cbrt();
                let most = coefficient * 3.0 * 2.0 * normal(step) / (2.0 * std::f64::consts::PI * a * a);
                let shape = |j: usize, r: f64| r / a * (1.0 - r2(j) / (r * r)).max(0.0).sqrt();
                let exact = |j: usize| most * (shape(j, a) - shape(j, c));
                let square = |f: &dyn Fn(usize) -> f64| (0..m).map(|j| area[j] * f(j).powi(2)).sum::<f64>();
                (square(&|j| l[m + j] / area[j] - exact(j)) / square(&exact)).sqrt()
            }
            "loop_error" => {
                // Steps 4 and 20 are the ends of the cycle.
                let dissipation = |step| number(&entry(step)["balance"]["dissipation"]);
                let (limit, q) = (coefficient * 2.0 * normal(20), ratio(20));
                let shear = young / (2.0 * (1.0 + poisson));
                let bracket = 1.0 - (1.0 - q).powf(5.0 / 3.0) - 5.0 / 6.0 * q * (1.0 + (1.0 - q).powf(2.0 / 3.0));
                let exact = 0.9 * limit * limit * (2.0 - poisson) / (contact_radius(20) * shear) * bracket;
                2.0 * (dissipation(20) - dissipation(4)) / exact - 1.0
            }
            other => panic!("no measure {other}"),
        }
    }

    /// Measures of the two cylinders sheared along x, per millimetre of their length, after step `step` (from 1).
    ///
    /// What friction lacks to its bound is a semi-ellipse on the strip that sticks, `sum(l x²) = 1/4 c² sum(l)`.
    fn cattaneo(&self, name: &str, step: usize) -> f64 {
        let (coefficient, radius, young, poisson) = (0.3, 50.0, 210e3, 0.3f64);
        let combined = young / (2.0 * (1.0 - poisson * poisson));
        let (m, area, nodes) = (self.prepared.problem.points(), &self.prepared.problem.labels.area, self.nodes());
        let x = |j: usize| self.prepared.mesh.nodes[nodes[j]][0];
        let number = |value: &Value| value.as_f64().unwrap();
        let forces = |step: usize| &self.summary["steps"][step - 1]["contact"];
        let limit = |step| coefficient * number(&forces(step)["normal_force"]);
        // Friction as a force on the upper body points against what shears it.
        let ratio = |step| -number(&forces(step)["tangential_force"][0]) / limit(step);
        let half_width = |step| (4.0 * limit(step) / coefficient * radius / (std::f64::consts::PI * combined)).sqrt();
        let sum = |term: &dyn Fn(usize) -> f64| (0..m).map(term).sum::<f64>();
        match name {
            "half_width" => half_width(step),
            "load" => ratio(step),
            "stick" => {
                let l = &self.steps[step - 1];
                let squared = |force: &dyn Fn(usize) -> f64| sum(&|j| force(j) * x(j).powi(2)) / sum(force);
                (squared(&|j| coefficient * l[j] - l[m + j]) / squared(&|j| l[j])).sqrt()
            }
            // The part of `F p` that friction reaches: along +x on the way out, and on the way back, from `turned`
            // on, twice as much of it along -x on another strip.
            "traction_error" => {
                let (l, a, turned) = (&self.steps[step - 1], half_width(step), ratio(4));
                let most = limit(step) * 2.0 / (std::f64::consts::PI * a * a);
                let ellipse = |j: usize, c: f64| (c * c - x(j).powi(2)).max(0.0).sqrt();
                let beyond = |j: usize, q: f64| ellipse(j, a) - ellipse(j, a * (1.0 - q).sqrt());
                let back = (turned - ratio(step)) / 2.0;
                let exact = |j: usize| match step {
                    ..=4 => most * beyond(j, ratio(step)),
                    _ => most * (beyond(j, turned) - 2.0 * beyond(j, back)),
                };
                let square = |f: &dyn Fn(usize) -> f64| sum(&|j| area[j] * f(j).powi(2));
                (square(&|j| l[m + j] / area[j] - exact(j)) / square(&exact)).sqrt()
            }
            "loop_error" => {
                // Steps 4 and 20 are the ends of the cycle.
                let dissipation = |step: usize| number(&self.summary["steps"][step - 1]["balance"]["dissipation"]);
                let q = ratio(20);
                let bracket = 2.0 * (1.0 - q) * (1.0 - q).ln() + 2.0 * q - q * q;
                let exact = 2.0 * limit(20).powi(2) / (std::f64::consts::PI * combined) * bracket;
                (dissipation(20) - dissipation(4)) / exact - 1.0
            }
            other => panic!("no measure {other}"),
        }
    }
}
