//! Cases solved from their text.

use std::ops::ControlFlow;

use stiction::fem::{Solid, cell_stress, full_displacement};
use stiction::io::case::{self, Case};
use stiction::run::{Outcome, Prepared, Settings, prepare, solve, solve_steps};

/// A certified answer; the second entry of the pair is the case on its mesh.
pub fn solved(text: &str) -> (Outcome, Prepared) {
    solved_case(&case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}")))
}

/// The same of a case that is read already.
pub fn solved_case(case: &Case) -> (Outcome, Prepared) {
    let mut prepared = prepare(case).unwrap_or_else(|e| panic!("{e}"));
    let settings = Settings::of(&case.solver);
    let go_on = &mut |_: &stiction::run::Event| ControlFlow::Continue(());
    let outcome = if case.steps.is_empty() {
        solve(&prepared, &settings, go_on)
    } else {
        solve_steps(&mut prepared, &settings, None, &mut |_, _| Ok(()), go_on)
    };
    let outcome = outcome.unwrap_or_else(|e| panic!("{e}"));
    assert!(outcome.solution.certificate.passed, "{:?}", outcome.solution.certificate);
    (outcome, prepared)
}

pub fn refused(text: &str) -> String {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let error = prepare(&case).map(|_| ()).unwrap_err();
    assert!(!error.remedy.is_empty() && error.place.starts_with("case.toml:"), "{error}");
    error.to_string()
}

pub fn displacement(run: &(Outcome, Prepared)) -> Vec<[f64; 3]> {
    full_displacement(&run.1.model, &run.0.solution.u).as_chunks().0.to_vec()
}

/// Displacement of the node nearest to `x`.
pub fn at(run: &(Outcome, Prepared), x: [f64; 3]) -> [f64; 3] {
    let square = |y: &[f64; 3]| (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f64>();
    let nodes = run.1.mesh.nodes.iter().zip(displacement(run));
    nodes.min_by(|a, b| square(a.0).total_cmp(&square(b.0))).unwrap().1
}

pub fn stress(run: &(Outcome, Prepared)) -> Vec<[f64; 6]> {
    let Prepared { mesh, materials, material_of_cell, loading, model, .. } = &run.1;
    let u = full_displacement(model, &run.0.solution.u);
    cell_stress(&Solid { mesh, materials, material_of_cell }, &u, &loading.initial.strain)
}

pub fn is(value: f64, wanted: f64, scale: f64) {
    assert!((value - wanted).abs() <= 1e-9 * scale.abs(), "{value} where {wanted} is wanted");
}

pub fn block(size: [f64; 3], cells: [usize; 3], element: &str) -> String {
    format!("[mesh]\nblock = {{ size = {size:?}, cells = {cells:?}, {element} }}\n")
}

/// Planes of symmetry on the three low sides.
pub const CORNER: &str = "[[fix]]\non = \"x-min\"\ncondition = \"symmetry\"\n[[fix]]\non = \"y-min\"\ncondition = \"symmetry\"\n\
                      [[fix]]\non = \"z-min\"\ncondition = \"symmetry\"\n";

/// A block on a plane with sticking, slipping and opening points.
pub const CASE: &str = r#"
title = "Block"
units = "m, N, Pa"

[mesh]
block = { size = [3, 1, 1], cells = [9, 3, 3], element = "hex8" }

[materials.steel]
young = 21.19e10
poisson = 0.277

[[fix]]
on = "x-min"

[[load]]
on = "z-max"
traction = [0, 0, "-2/3*1e6*(3 - x)"]

[[load]]
on = "x-max"
traction = [0, 0, 1e6]

[[contact]]
on = "z-min"
against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = { coulomb = 0.35 }
"#;
