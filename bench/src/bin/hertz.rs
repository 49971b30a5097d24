//! Linear against quadratic elements on Hertz's contact: unknowns for a given accuracy.
//!
//! Usage: `cargo run --release -p stiction-bench --bin hertz`; `docs/hertz.md` has what it gave. The block of `cases/hertz` (a quarter,
//! edges of ten contact radii, cells graded to the ball by the same map on every grid) at four depths. Errors are root mean
//! squares over the depths against the limit of the same block: Hertz's half space is another problem. The limit of force
//! and contact radius (from the second moment of the nodal forces) is the mean of the finest grids of hex8 and hex20; the
//! pressures are held, in L2 over the contact, against Hertz's semi-ellipsoid of the computed force.

use std::error::Error;
use std::ops::ControlFlow;

use stiction::io::case;
use stiction::run::{Settings, prepare, solve};

/// Where the edge of contact lies within a cell makes single errors jump.
const DEPTHS: [f64; 4] = [0.7e-3, 0.85e-3, 1.0e-3, 1.15e-3];
const RADIUS: f64 = 10.0;
/// `E / (1 - ν²)` of the steel below.
const STIFFNESS: f64 = 210e3 / 0.91;
/// Last cell over the first in the limit of many cells.
const GRADING: f64 = 32.0;
const ACCURACIES: [f64; 4] = [0.02, 0.01, 0.005, 0.003];

/// Elements, cells down over cells along the contact surface, and the latter.
const GRIDS: [(&str, f64, &[usize]); 6] = [
    ("hex8", 1.0, &[5, 6, 8, 10, 12, 16, 20, 24, 40]),
    ("hex8", 0.5, &[6, 8, 10, 12, 16, 20, 24, 32]),
    ("hex20", 1.0, &[4, 5, 6, 8, 10, 12, 14, 20]),
    ("hex20", 0.5, &[4, 6, 8, 10, 12, 14, 16]),
    ("tet4", 1.0, &[8, 12, 16, 24, 32, 40]),
    ("tet10", 1.0, &[4, 5, 6, 7, 8, 10, 12]),
];

/// A grid solved at all depths.
struct Solved {
    unknowns: usize,
    force: [f64; 4],
    radius: [f64; 4],
    /// Relative error of the pressure.
    pressure: [f64; 4],
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut families = Vec::new();
    for (element, down, grids) in GRIDS {
        let runs: Result<Vec<Solved>, Box<dyn Error>> = grids.iter().map(|&n| run(element, down, n)).collect();
        families.push((element, down, grids, runs?));
    }
    let finest = [0, 2].map(|family: usize| &families[family].3[families[family].3.len() - 1]);
    let limit = |of: fn(&Solved) -> &[f64; 4]| -> [f64; 4] {
        std::array::from_fn(|k| 0.5 * (of(finest[0])[k] + of(finest[1])[k]))
    };
    let limits = [limit(|s| &s.force), limit(|s| &s.radius)];
    let apart = [rms(&finest[0].force, &finest[1].force), rms(&finest[0].radius, &finest[1].radius)];
    println!(
        "The finest grids are {:.2} % apart in force and {:.2} % in radius.\n",
        100.0 * apart[0],
        100.0 * apart[1]
    );
    println!("| element | cells | unknowns | force | radius | pressure |\n|---|--:|--:|--:|--:|--:|");
    let mut curves = Vec::new();
    for (element, down, grids, runs) in &families {
        let error = |s: &Solved| [rms(&s.force, &limits[0]), rms(&s.radius, &limits[1]), rms_of(&s.pressure)];
        let errors: Vec<[f64; 3]> = runs.iter().map(error).collect();
        for ((&n, s), e) in grids.iter().zip(runs).zip(&errors) {
            let [force, radius, pressure] = e.map(|e| 100.0 * e);
            let cells = format!("{n} x {n} x {:.0}", cells_down(*down, n));
            println!("| {element} | {cells} | {} | {force:.2} % | {radius:.2} % | {pressure:.1} % |", s.unknowns);
        }
        curves.push(runs.iter().map(|s| s.unknowns as f64).zip(errors).collect::<Vec<_>>());
    }
    for (measure, name) in ["force", "radius"].iter().enumerate() {
        println!("\n| {name} to | hex8 | hex20 | ratio | tet4 | tet10 | ratio |\n|--:|--:|--:|--:|--:|--:|--:|");
        for accuracy in ACCURACIES {
            let at = |k: usize| needed(&curves[k], measure, accuracy);
            // Each kind of hexahedra with the depth of its cells that suits it better.
            let better = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
            let [a, b, c, d] = [better(at(0), at(1)), better(at(2), at(3)), at(4), at(5)];
            let (p, q) = (ratio_of(b, a), ratio_of(d, c));
            let [a, b, c, d] = [a, b, c, d].map(|n| n.map_or("-".to_string(), |n| format!("{n:.0}")));
            println!("| {:.1} % | {a} | {b} | {p} | {c} | {d} | {q} |", 100.0 * accuracy);
        }
    }
    Ok(())
}

/// Cells along z.
fn cells_down(down: f64, n: usize) -> f64 {
    (down * n as f64).round()
}

fn rms_of(values: &[f64; 4]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / 4.0).sqrt()
}

fn ratio_of(quadratic: Option<f64>, linear: Option<f64>) -> String {
    quadratic.zip(linear).map_or("-".into(), |(q, l)| format!("{:.2}", q / l))
}

fn rms(values: &[f64; 4], limit: &[f64; 4]) -> f64 {
    (values.iter().zip(limit).map(|(v, l)| (v / l - 1.0).powi(2)).sum::<f64>() / 4.0).sqrt()
}

/// Unknowns from which on the error stays below `accuracy`, on the line through the logarithms around it.
fn needed(curve: &[(f64, [f64; 3])], measure: usize, accuracy: f64) -> Option<f64> {
    let last = curve.iter().rposition(|(_, error)| error[measure] > accuracy)?;
    let ((n0, e0), (n1, e1)) = (&curve[last], curve.get(last + 1)?);
    let share = (e0[measure] / accuracy).ln() / (e0[measure] / e1[measure]).ln();
    Some((n0.ln() + share * (n1 / n0).ln()).exp())
}

fn run(element: &str, down: f64, n: usize) -> Result<Solved, Box<dyn Error>> {
    let mut solved = Solved { unknowns: 0, force: [0.0; 4], radius: [0.0; 4], pressure: [0.0; 4] };
    for (k, depth) in DEPTHS.into_iter().enumerate() {
        let nz = cells_down(down, n);
        let [grading, gz] = [n as f64, nz].map(|n| GRADING.powf((n - 1.0) / n));
        let split = if element.starts_with("tet") { ", split = \"six\"" } else { "" };
        let text = format!(
            "[mesh]\nblock = {{ size = [1, 1, 1], cells = [{n}, {n}, {nz}], element = \"{element}\"{split}, \
             grading = [{grading}, {grading}, {gz}] }}\n[materials.steel]\nyoung = 210e3\npoisson = 0.3\n\
             [[fix]]\non = \"x-min\"\ncomponents = \"x\"\n[[fix]]\non = \"y-min\"\ncomponents = \"y\"\n\
             [[fix]]\non = \"z-max\"\ncomponents = \"z\"\nvalue = -{depth}\n[[contact]]\non = \"z-min\"\n\
             against = {{ sphere = {{ center = [0, 0, -10], radius = 10 }} }}\nfriction = \"none\"\n"
        );
        let case = case::parse(&text, "hertz.toml", &[])?;
        let prepared = prepare(&case)?;
        let outcome = solve(&prepared, &Settings::of(&case.solver), &mut |_| ControlFlow::Continue(()))?;
        if !outcome.solution.certificate.passed {
            return Err(format!("{element} {n} at depth {depth} is not certified").into());
        }
        let (problem, dofs) = (&prepared.problem, &prepared.model.dofs);
        let m = problem.points();
        let mut lambda = outcome.solution.lambda;
        lambda[m..].fill(0.0);
        let nodal = problem.contact.B.transpose_times(&lambda);
        let (mut force, mut moment) = (0.0, 0.0);
        for (f, &dof) in nodal.iter().zip(&dofs.free).filter(|(_, dof)| *dof % 3 == 2) {
            let x = prepared.mesh.nodes[dof as usize / 3];
            force -= f;
            moment -= f * (x[0] * x[0] + x[1] * x[1]);
        }
        let a = (3.0 * 4.0 * force * RADIUS / (4.0 * STIFFNESS)).cbrt();
        let greatest = 3.0 * 4.0 * force / (2.0 * std::f64::consts::PI * a * a);
        let nodes = &prepared.facts.contacts[0].surface.nodes;
        let (mut off, mut all) = (0.0, 0.0);
        for (j, &node) in nodes.iter().enumerate() {
            let x = prepared.mesh.nodes[node as usize];
            let wanted = (1.0 - (x[0] * x[0] + x[1] * x[1]) / (a * a)).max(0.0).sqrt();
            let area = problem.labels.area[j] * problem.labels.unity_sum[j];
            off += area * (lambda[j] / problem.labels.area[j] / greatest - wanted).powi(2);
            all += area * wanted * wanted;
        }
        solved.pressure[k] = f64::sqrt(off / all);
        (solved.unknowns, solved.force[k], solved.radius[k]) =
            (problem.unknowns(), force, (2.5 * moment / force).sqrt());
    }
    eprintln!("{element} {n}: {} unknowns, force {:.6?}, radius {:.6?}", solved.unknowns, solved.force, solved.radius);
    Ok(solved)
}
