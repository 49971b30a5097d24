//! The pictures of a result.

use std::path::Path;

use super::accuracy_text;
use super::beside::beside;
use super::fields::{BodyFields, Side, SurfaceFields};
use crate::Error;
use crate::accuracy::Estimate;
use crate::friction::Progress;
use crate::io::plot::{
    ConvergencePoint, DeformedPlot, HistoryPanel, MapValues, MapVectors, SurfaceMap, convergence, deformed, history,
    surface_map,
};
use crate::io::units::Units;
use crate::mesh::v3::V3;
use crate::mesh::{Face, Mesh};
use crate::run::pose::Prepared;
use crate::run::solve::{BalanceRecord, Outcome, Totals};

/// What the pictures show of an answer.
pub(crate) struct Shown<'a> {
    pub title: &'a str,
    pub units: Units<'a>,
    /// Places of nodes, length; the faces of the boundary, each by its border; and displacements, length.
    pub points: &'a [V3],
    pub borders: &'a [Vec<u32>],
    pub displacement: &'a [V3],
    /// The estimated error at each node, percent, and in the mean, a part of one; none without an estimate or any error.
    pub error: Option<(Vec<f64>, f64)>,
    pub surfaces: &'a [SurfaceFields],
    /// The residual after each iteration and the tolerance; none without contact.
    pub convergence: Option<(&'a [Progress], f64)>,
    /// The end of each increment: time, forces, and energies where they are known.
    pub steps: Vec<(f64, &'a Totals, Option<&'a BalanceRecord>)>,
}

/// Draws all pictures of an answer and returns their names.
pub(crate) fn write(
    folder: &Path,
    prepared: &Prepared,
    outcome: &Outcome,
    body: &BodyFields,
    surfaces: &[SurfaceFields],
) -> Result<Vec<String>, Error> {
    let mesh = &prepared.mesh;
    let borders: Vec<Vec<u32>> = mesh.faces.iter().map(Face::border).collect();
    let mean = outcome.estimate.as_ref().map(Estimate::relative);
    let error = mean.and_then(|mean| Some((node_error(mesh, &body.error, mean)?, mean)));
    let has_contact = prepared.facts.points > 0;
    let shown = Shown {
        title: &prepared.facts.title,
        units: Units::of(prepared.facts.units.as_deref()),
        points: &mesh.nodes,
        borders: &borders,
        displacement: &body.displacement,
        error,
        surfaces,
        convergence: has_contact.then_some((&outcome.solution.history[..], outcome.solution.certificate.tolerance)),
        steps: outcome.steps.iter().map(|step| (step.t, &step.answer.contact, Some(&step.balance))).collect(),
    };
    draw(folder, &shown)
}

/// Draws all pictures and returns their names.
///
/// # Errors
/// If a file cannot be written, or a place is no number.
pub(crate) fn draw(folder: &Path, shown: &Shown) -> Result<Vec<String>, Error> {
    let Shown { title, units, surfaces, .. } = shown;
    let faces: Vec<&[u32]> = shown.borders.iter().map(Vec::as_slice).collect();
    let plot = DeformedPlot {
        points: shown.points,
        faces: &faces,
        displacement: shown.displacement,
        title,
        unit_label: units.length,
        scale: None,
    };
    let slaves: Vec<&SurfaceFields> = surfaces.iter().filter(|s| s.side == Side::Slave).collect();
    let of_surface = |surface: &SurfaceFields| {
        let suffix = if slaves.len() > 1 { format!("-{}", file_name(&slaves, surface.pair)) } else { String::new() };
        maps(folder, title, &suffix, surface, units)
    };
    let mut files = vec!["deformed.png".to_string()];
    let draw_body = || {
        deformed(&plot)?.0.write_png(&folder.join("deformed.png"))?;
        shown.error.as_ref().map_or(Ok(()), |error| error_map(folder, shown, &faces, error))
    };
    // The body takes about as long as a contact surface.
    let (drawn, of_surfaces) =
        beside(draw_body, || surfaces.iter().map(of_surface).collect::<Vec<Result<Vec<String>, Error>>>());
    drawn?;
    files.extend(shown.error.as_ref().map(|_| ERROR.to_string()));
    for names in of_surfaces {
        files.extend(names?);
    }
    if let Some((history, tolerance)) = shown.convergence {
        let points: Vec<ConvergencePoint> = (history.iter())
            .map(|p| ConvergencePoint { iteration: p.iteration, products: p.products, residual: p.residual })
            .collect();
        convergence(&points, tolerance, title).write_png(&folder.join("convergence.png"))?;
        files.push("convergence.png".into());
    }
    if !shown.steps.is_empty() {
        forces_over_time(folder, shown)?;
        files.push("history.png".into());
    }
    Ok(files)
}

/// The picture of the error.
const ERROR: &str = "error.png";
/// It shows errors up to so many times the mean one: at edges they are many times that.
const SHOWN: f64 = 4.0;

/// The estimated error at each node, percent: the mean of those of its cells, parts of one, cut off at what is shown beside their mean
/// `mean`. `None` without any error.
pub(crate) fn node_error(mesh: &Mesh, of_cells: &[f32], mean: f64) -> Option<Vec<f64>> {
    let most = 100.0 * SHOWN * mean;
    let cells = mesh.cells.iter().flat_map(|block| block.nodes.chunks_exact(block.kind.nodes()));
    let mut sums = vec![[0.0, 0.0]; mesh.nodes.len()];
    for (nodes, &error) in cells.zip(of_cells) {
        for &node in nodes {
            let [sum, count] = &mut sums[node as usize];
            *sum += 100.0 * f64::from(error);
            *count += 1.0;
        }
    }
    (most > 0.0).then(|| sums.iter().map(|[sum, count]| (sum / count).min(most)).collect())
}

/// Where the mesh is too coarse, over the boundary.
fn error_map(folder: &Path, shown: &Shown, faces: &[&[u32]], (error, mean): &(Vec<f64>, f64)) -> Result<(), Error> {
    let [mean, most] = [*mean, SHOWN * mean].map(accuracy_text::percent);
    let map = SurfaceMap {
        points: shown.points,
        faces,
        values: MapValues::Scalar(error),
        vectors: None,
        focus: None,
        title: &format!("{}: estimated error, {mean} in the mean, cut off at {most}", shown.title),
        label: "Error",
        unit_label: "%",
        length_label: shown.units.length,
    };
    surface_map(&map)?.write_png(&folder.join(ERROR))
}

fn forces_over_time(folder: &Path, Shown { title, units, steps, .. }: &Shown) -> Result<(), Error> {
    // The body begins at rest.
    let curve = |value: &dyn Fn(&Totals) -> f64| -> Vec<f64> {
        std::iter::once(0.0).chain(steps.iter().map(|(_, contact, _)| value(contact))).collect()
    };
    let friction = |c: usize| curve(&|contact| contact.tangential_force[c]);
    let times: Vec<f64> = std::iter::once(0.0).chain(steps.iter().map(|(t, ..)| *t)).collect();
    let mut forces = vec![("normal", curve(&|contact| contact.normal_force))];
    let largest = |values: &[f64]| values.iter().fold(0.0f64, |largest, v| largest.max(v.abs()));
    let negligible = 1e-9 * forces.iter().map(|(_, values)| largest(values)).sum::<f64>();
    let components = ["friction x", "friction y", "friction z"].into_iter().zip((0..3).map(friction));
    forces.extend(components.filter(|(_, values)| largest(values) > negligible));
    let mut panels =
        vec![HistoryPanel { label: "Force of contact on the body", unit_label: units.force, curves: forces }];
    let balances: Option<Vec<&BalanceRecord>> = steps.iter().map(|(.., balance)| *balance).collect();
    if let Some(balances) = balances {
        let curve = |value: &dyn Fn(&BalanceRecord) -> f64| -> Vec<f64> {
            std::iter::once(0.0).chain(balances.iter().map(|balance| value(balance))).collect()
        };
        let curves = vec![
            ("work", curve(&|balance| balance.work)),
            ("elastic", curve(&|balance| balance.elastic)),
            ("dissipated", curve(&|balance| balance.dissipation)),
        ];
        panels.push(HistoryPanel { label: "Energy since the start", unit_label: "", curves });
    }
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
