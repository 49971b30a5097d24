//! The paper's six figures: the first two sketches, the others from our own solution on partition 2.

use std::ops::ControlFlow;

use super::model::{Brick, Law, brick};
use super::study::Figure;
use super::{sketches, study};
use stiction::Error;
use stiction::fem::full_displacement;
use stiction::io::plot::{Axis, FaceColors, SpacePlot, space};
use stiction::run::{Outcome, Prepared, Settings, solve};

/// The largest displacement is drawn with this length, in the unit of the brick.
const SHOWN_DISPLACEMENT: f64 = 0.15;

/// The brick of the figures: the fitted loads, so that the forces are those behind the tables.
pub const DRAWN: Brick = Brick { partition: 2, parity: 0, load: 4.0 };

/// A figure, and the certified solution it needs.
pub fn figure(number: usize, solution: &mut Option<Solved>) -> Result<Option<Figure>, Error> {
    let drawn = match number {
        1 => sketches::polygon(),
        2 => sketches::section(),
        3..=6 => from_solution(number, needed(solution)?)?,
        _ => return Ok(None),
    };
    Ok(Some(drawn))
}

/// The brick with Coulomb friction, solved by Newton's method.
#[derive(Debug)]
pub struct Solved {
    pub prepared: Prepared,
    pub outcome: Outcome,
}

fn needed(solution: &mut Option<Solved>) -> Result<&Solved, Error> {
    if solution.is_none() {
        let prepared = brick(DRAWN, Law::Coulomb)?;
        let settings = Settings::of(&stiction::io::case::SolverSpec::default());
        let outcome = solve(&prepared, &settings, &mut |_| ControlFlow::Continue(()))?;
        *solution = Some(Solved { prepared, outcome });
    }
    solution.as_ref().ok_or_else(|| Error::new("figures", "there is no solution to draw", ""))
}

fn from_solution(number: usize, solved: &Solved) -> Result<study::Figure, Error> {
    match number {
        3 => mesh(&solved.prepared),
        4 => deformed(solved),
        5 => forces(5, solved, "Normal", "λν", |[normal, _, _]| normal),
        _ => forces(6, solved, "Tangential", "|λt|", |[_, t1, t2]| t1.hypot(t2)),
    }
}

/// The axes of the brick.
fn axes(height: f64) -> [Axis<'static>; 3] {
    let axis = |label, high, length| Axis { label, unit_label: "m", low: 0.0, high, length };
    [axis("x₁", 3.0, 3.0), axis("x₂", 1.0, 1.0), axis("x₃", height, height)]
}

fn mesh(prepared: &Prepared) -> Result<Figure, Error> {
    let mesh = &prepared.mesh;
    let faces: Vec<&[u32]> = mesh.faces.iter().map(|face| face.nodes()).collect();
    let title = "The partition into finite elements";
    let cells = mesh.cell_count();
    let subtitle =
        format!("{cells} tetrahedra, {} unknowns, {} contact points", prepared.facts.unknowns, prepared.facts.points);
    let colors = FaceColors::Plain([214, 226, 240]);
    let plot = SpacePlot { points: &mesh.nodes, faces: &faces, colors, axes: axes(1.0), title, subtitle: &subtitle };
    let caption = "Partition 2: 24 x 8 x 8 cubes, each of five tetrahedra (parity 0).".to_string();
    Ok(Figure { number: 3, title: title.into(), caption, drawing: space(&plot)? })
}

fn deformed(solved: &Solved) -> Result<Figure, Error> {
    let Solved { prepared, outcome } = solved;
    let u = full_displacement(&prepared.model, &outcome.solution.u);
    let sizes: Vec<f64> =
        u.as_chunks().0.iter().map(|u: &[f64; 3]| u.iter().map(|c| c * c).sum::<f64>().sqrt()).collect();
    let largest = sizes.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let factor = 10.0 * (0.1 * SHOWN_DISPLACEMENT / largest).round();
    let moved = prepared.mesh.nodes.iter().zip(u.as_chunks().0);
    let moved: Vec<[f64; 3]> = moved.map(|(x, u): (_, &[f64; 3])| [0, 1, 2].map(|c| x[c] + factor * u[c])).collect();
    let faces: Vec<&[u32]> = prepared.mesh.faces.iter().map(|face| face.nodes()).collect();
    let title = "The deformed body";
    let subtitle = format!("displacements times {factor:.0}; the largest is {largest:.4e} m; colour: displacement");
    let plot = SpacePlot {
        points: &moved,
        faces: &faces,
        colors: FaceColors::Values(&sizes),
        axes: axes(1.2),
        title,
        subtitle: &subtitle,
    };
    let caption = format!("Partition 2, parity 0, Coulomb friction 0.35; {}", provenance(outcome));
    Ok(Figure { number: 4, title: title.into(), caption, drawing: space(&plot)? })
}

/// A force a node over the contact surface, drawn up to the end of the paper's axis where it fits there.
fn forces(number: usize, solved: &Solved, kind: &str, symbol: &str, of: fn([f64; 3]) -> f64) -> Result<Figure, Error> {
    let Prepared { mesh, problem, facts, surfaces, .. } = &solved.prepared;
    let missing = || Error::new("figures", "the brick has no contact surface", "");
    let (surface, contact) = surfaces.first().zip(facts.contacts.first()).ok_or_else(missing)?;
    let nodes = mesh.face_nodes(&surface.faces);
    let local = |node: &u32| nodes.partition_point(|other| other < node);
    // The paper draws the contact nodes, which the clamped ones are not.
    let mut values = vec![f64::NAN; nodes.len()];
    for (j, node) in contact.surface.nodes.iter().enumerate() {
        let lambda = problem.rows(j).map(|row| problem.labels.unity_sum[j] * solved.outcome.solution.lambda[row]);
        values[local(node)] = of(lambda);
    }
    let largest = values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let top = 2e4 * (largest / 2e4).ceil().max(1.0);
    let points: Vec<[f64; 3]> =
        nodes.iter().zip(&values).map(|(&n, &v)| [mesh.nodes[n as usize][0], mesh.nodes[n as usize][1], v]).collect();
    let shown: Vec<f64> = values.iter().map(|v| if v.is_finite() { *v } else { 0.0 }).collect();
    let corners = |&face: &u32| mesh.faces[face as usize].nodes().iter().map(|node| local(node) as u32).collect();
    let faces: Vec<Vec<u32>> = surface.faces.iter().map(corners).collect();
    let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    let force = Axis { label: symbol, unit_label: "N", low: 0.0, high: top, length: 1.0 };
    let [x, y, _] = axes(1.0);
    let title = format!("{kind} contact stress");
    let subtitle = format!("force a node; largest {largest:.4e} N");
    let colors = FaceColors::Values(&shown);
    let plot =
        SpacePlot { points: &points, faces: &faces, colors, axes: [x, y, force], title: &title, subtitle: &subtitle };
    let caption = format!(
        "Partition 2, parity 0, Coulomb friction 0.35, as nodal forces (the multipliers of the paper) with the fitted \
         loads (4 times the printed ones; forces are in proportion); {}. The paper's axis ends at 1e5.",
        provenance(&solved.outcome)
    );
    Ok(Figure {
        number,
        title: format!("The distribution of the {} contact stress", kind.to_lowercase()),
        caption,
        drawing: space(&plot)?,
    })
}

fn provenance(outcome: &Outcome) -> String {
    let c = &outcome.solution.certificate;
    let passed = if c.passed { "passed" } else { "NOT passed" };
    format!("solved by Newton's method on the disc, certificate {passed} (worst measure {:.1e})", c.worst)
}
