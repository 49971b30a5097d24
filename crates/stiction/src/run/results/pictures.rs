//! The pictures of a result.

use std::path::Path;

use super::accuracy_text;
use super::beside::beside;
use super::fields::{BodyFields, Side, SurfaceFields};
use crate::Error;
use crate::accuracy::Estimate;
use crate::io::plot::{
    ConvergencePoint, DeformedPlot, HistoryPanel, MapValues, MapVectors, SurfaceMap, convergence, deformed, history,
    surface_map,
};
use crate::io::units::Units;
use crate::mesh::{Face, Mesh};
use crate::run::pose::Prepared;
use crate::run::solve::{Outcome, StepRecord};

/// Draws all pictures and returns their names.
pub(crate) fn write(
    folder: &Path,
    prepared: &Prepared,
    outcome: &Outcome,
    body: &BodyFields,
    surfaces: &[SurfaceFields],
) -> Result<Vec<String>, Error> {
    let units = Units::of(prepared.facts.units.as_deref());
    let mesh = &prepared.mesh;
    let borders: Vec<Vec<u32>> = mesh.faces.iter().map(Face::border).collect();
    let faces: Vec<&[u32]> = borders.iter().map(Vec::as_slice).collect();
    let title = &prepared.facts.title;
    let plot = DeformedPlot {
        points: &mesh.nodes,
        faces: &faces,
        displacement: &body.displacement,
        title,
        unit_label: units.length,
        scale: None,
    };
    let slaves: Vec<&SurfaceFields> = surfaces.iter().filter(|s| s.side == Side::Slave).collect();
    let of_surface = |surface: &SurfaceFields| {
        let suffix = if slaves.len() > 1 { format!("-{}", file_name(&slaves, surface.pair)) } else { String::new() };
        maps(folder, title, &suffix, surface, &units)
    };
    let mut files = vec!["deformed.png".to_string()];
    let error = node_error(mesh, body, outcome);
    let draw_body = || {
        deformed(&plot)?.0.write_png(&folder.join("deformed.png"))?;
        error.as_ref().map_or(Ok(()), |error| error_map(folder, prepared, outcome, &faces, error))
    };
    // The body takes about as long as a contact surface.
    let (drawn, of_surfaces) =
        beside(draw_body, || surfaces.iter().map(of_surface).collect::<Vec<Result<Vec<String>, Error>>>());
    drawn?;
    files.extend(error.map(|_| ERROR.to_string()));
    for names in of_surfaces {
        files.extend(names?);
    }
    if prepared.facts.points > 0 {
        let points: Vec<ConvergencePoint> = (outcome.solution.history.iter())
            .map(|p| ConvergencePoint { iteration: p.iteration, products: p.products, residual: p.residual })
            .collect();
        let tolerance = outcome.solution.certificate.tolerance;
        convergence(&points, tolerance, title).write_png(&folder.join("convergence.png"))?;
        files.push("convergence.png".into());
    }
    if !outcome.steps.is_empty() {
        forces_over_time(folder, title, &outcome.steps, units.force)?;
        files.push("history.png".into());
    }
    Ok(files)
}

/// The picture of the error.
const ERROR: &str = "error.png";
/// It shows errors up to so many times the mean one: at edges they are many times that.
const SHOWN: f64 = 4.0;

/// The estimated error at each node, percent: the mean of its cells, cut off at what is shown. `None` without any error.
fn node_error(mesh: &Mesh, body: &BodyFields, outcome: &Outcome) -> Option<Vec<f64>> {
    let most = 100.0 * SHOWN * outcome.estimate.as_ref()?.relative();
    let cells = mesh.cells.iter().flat_map(|block| block.nodes.chunks_exact(block.kind.nodes()));
    let mut sums = vec![[0.0, 0.0]; mesh.nodes.len()];
    for (nodes, &error) in cells.zip(&body.error) {
        for &node in nodes {
            let [sum, count] = &mut sums[node as usize];
            *sum += 100.0 * f64::from(error);
            *count += 1.0;
        }
    }
    (most > 0.0).then(|| sums.iter().map(|[sum, count]| (sum / count).min(most)).collect())
}

/// Where the mesh is too coarse, over the boundary.
fn error_map(
    folder: &Path,
    prepared: &Prepared,
    outcome: &Outcome,
    faces: &[&[u32]],
    error: &[f64],
) -> Result<(), Error> {
    let mean = outcome.estimate.as_ref().map_or(0.0, Estimate::relative);
    let [mean, most] = [mean, SHOWN * mean].map(accuracy_text::percent);
    let map = SurfaceMap {
        points: &prepared.mesh.nodes,
        faces,
        values: MapValues::Scalar(error),
        vectors: None,
        focus: None,
        title: &format!("{}: estimated error, {mean} in the mean, cut off at {most}", prepared.facts.title),
        label: "Error",
        unit_label: "%",
        length_label: Units::of(prepared.facts.units.as_deref()).length,
    };
    surface_map(&map)?.write_png(&folder.join(ERROR))
}

fn forces_over_time(folder: &Path, title: &str, steps: &[StepRecord], unit_label: &str) -> Result<(), Error> {
    // The body begins at rest.
    let curve = |value: &dyn Fn(&StepRecord) -> f64| -> Vec<f64> {
        std::iter::once(0.0).chain(steps.iter().map(value)).collect()
    };
    let friction = |c: usize| curve(&|step| step.answer.contact.tangential_force[c]);
    let times = curve(&|step| step.t);
    let mut forces = vec![("normal", curve(&|step| step.answer.contact.normal_force))];
    let largest = |values: &[f64]| values.iter().fold(0.0f64, |largest, v| largest.max(v.abs()));
    let negligible = 1e-9 * forces.iter().map(|(_, values)| largest(values)).sum::<f64>();
    let components = ["friction x", "friction y", "friction z"].into_iter().zip((0..3).map(friction));
    forces.extend(components.filter(|(_, values)| largest(values) > negligible));
    let energies = vec![
        ("work", curve(&|step| step.balance.work)),
        ("elastic", curve(&|step| step.balance.elastic)),
        ("dissipated", curve(&|step| step.balance.dissipation)),
    ];
    let panels = [
        HistoryPanel { label: "Force of contact on the body", unit_label, curves: forces },
        HistoryPanel { label: "Energy since the start", unit_label: "", curves: energies },
    ];
    let count = format!("{} load steps", steps.len());
    history(&times, &panels, title, &count).write_png(&folder.join("history.png"))
}

fn maps(folder: &Path, title: &str, suffix: &str, s: &SurfaceFields, units: &Units) -> Result<Vec<String>, Error> {
    let faces: Vec<&[u32]> = s.borders.iter().map(Vec::as_slice).collect();
    let shear: Vec<f64> = s.shear.iter().map(|t| (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt()).collect();
    // No state of the legend stands for points that are not in contact at all.
    let status: Vec<u8> = s.status.iter().map(|&state| u8::try_from(state).unwrap_or(u8::MAX)).collect();
    let of_pair = if suffix.is_empty() { String::new() } else { format!(", {}", s.name) };
    let arrows = MapVectors { values: &s.shear, label: "Shear on counterpart", unit_label: units.stress };
    let pressure = MapValues::Scalar(&s.pressure);
    let pictures = match s.side {
        Side::Slave => vec![
            ("pressure", "contact pressure", "Pressure", pressure, None),
            ("shear", "shear traction on the counterpart", "Shear traction", MapValues::Scalar(&shear), Some(arrows)),
            ("status", "state of contact", "", MapValues::Status(&status), None),
        ],
        // The word comes first: no name of a pair can make this the name of another picture.
        Side::Master => vec![
            ("master-pressure", "contact pressure on the master", "Pressure", pressure, None),
            (
                "master-shear",
                "shear traction, master's side",
                "Shear traction",
                MapValues::Scalar(&shear),
                Some(arrows),
            ),
        ],
    };
    let touching: Vec<bool> = match s.side {
        Side::Slave => s.status.iter().map(|&state| state > 0).collect(),
        Side::Master => s.lambda.iter().map(|force| force.iter().any(|&f| f != 0.0)).collect(),
    };
    let mut files = Vec::new();
    for (name, subject, label, values, vectors) in pictures {
        if name.ends_with("shear") && !shear.iter().any(|&t| t > 0.0) {
            continue;
        }
        let title = format!("{title}{of_pair}: {subject}");
        let map = SurfaceMap {
            points: &s.points,
            faces: &faces,
            values,
            vectors,
            focus: Some(&touching),
            title: &title,
            label,
            unit_label: units.stress,
            length_label: units.length,
        };
        let file = format!("{name}{suffix}.png");
        surface_map(&map)?.write_png(&folder.join(&file))?;
        files.push(file);
    }
    Ok(files)
}

/// The name of a pair as part of a file name, different for each pair.
fn file_name(surfaces: &[&SurfaceFields], number: usize) -> String {
    let plain = |s: &SurfaceFields| -> String {
        s.name.chars().take(60).map(|c| if c.is_alphanumeric() || c == '-' || c == '_' { c } else { '_' }).collect()
    };
    let own = plain(surfaces[number]);
    // File systems may not tell upper from lower case.
    let same = |s: &&SurfaceFields| plain(s).to_lowercase() == own.to_lowercase();
    if surfaces.iter().copied().filter(same).count() > 1 { format!("{own}-{}", number + 1) } else { own }
}
