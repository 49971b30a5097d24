//! The result folder.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::beside::beside;
use super::contact_csv::{CONTACT_CSV, read_figures, write_csv};
use super::fields::{BodyFields, Side, SurfaceFields, body};
use super::fretting::{FrettingRecord, records};
use super::masters::pair_fields;
use super::step_file::{csv_name, remove_steps, step_sums};
use super::summary::Summary;
use super::sums::{self, SUMS, Sums};
use super::{Ahead, REPORT, json, pictures};
use crate::Error;
use crate::contact::{ContactSurface, Counterpart, Obstacle};
use crate::friction::{Phase, Progress};
use crate::io::bound::write_bound;
use crate::io::pieces::is_piece;
use crate::io::units::Units;
use crate::io::vtu::{self, Array, EncodedGrid, Grid};
use crate::io::{checksum, folder, machine, problem};
use crate::run::pose::memory::output_fits;
use crate::run::pose::{Prepared, stopwatch};
use crate::run::solve::Outcome;

pub use crate::io::folder::writable;

/// Where a case came from: its text and the options that changed it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Origin {
    /// The case file, if it is one; it is not replaced by its copy where it lies in the result folder itself.
    pub path: Option<PathBuf>,
    /// The case file as it was read.
    pub case_text: String,
    /// Keys and values.
    pub overrides: Vec<(String, String)>,
    /// The command that was given, if it was one.
    pub command: Option<String>,
}

impl Origin {
    /// Whether the case is this file itself.
    pub(crate) fn is_at(&self, path: &Path) -> bool {
        self.path.as_ref().is_some_and(|own| folder::same(own, path))
    }

    /// The options as they were given.
    pub(crate) fn overrides(&self) -> Vec<String> {
        self.overrides.iter().map(|(key, value)| format!("{key}={value}")).collect()
    }
}

/// Writes all files of a result into `folder`, which is created, and returns their names.
///
/// Each file is whole or absent, and `summary.json` comes last, after the checksums of all and when the others are on the
/// disk: a folder that has one is
/// complete. `outcome` learns how long it took.
///
/// # Errors
/// If a file cannot be written.
pub fn write(prepared: &Prepared, outcome: &mut Outcome, origin: &Origin, folder: &Path) -> Result<Vec<String>, Error> {
    write_with(prepared, outcome, origin, folder, Ahead::default())
}

/// The same after [`solve_writing`](super::solve_writing) into the same folder.
///
/// # Errors
/// If a file cannot or could not be written.
pub fn write_with(
    prepared: &Prepared,
    outcome: &mut Outcome,
    origin: &Origin,
    folder: &Path,
    mut ahead: Ahead,
) -> Result<Vec<String>, Error> {
    let mut lap = stopwatch();
    drop(ahead.room.take());
    output_fits(&prepared.mesh, ahead.pictures)?;
    folder::create(folder)?;
    withdraw_result(folder)?;
    // That of an earlier run would tell of other numbers.
    folder::remove(&folder.join(REPORT))?;
    let stepped = !outcome.steps.is_empty();
    if !stepped {
        remove_steps(folder)?;
    }
    if stepped || prepared.surfaces.is_empty() {
        folder::remove(&folder.join(CONTACT_CSV))?;
    }
    let (body, surfaces) = (body(prepared, outcome), pair_fields(prepared, outcome));
    // The largest file, without steps: its checksum is taken while the others are written, by a thread outside rayon.
    let file = folder.join(PROBLEM);
    let tolerance = outcome.solution.certificate.tolerance;
    match ahead.problem.take() {
        Some(written) => written?.commit()?,
        None => problem::write_problem(&file, &prepared.problem, tolerance)?,
    }
    // Pictures and numbers take about as long, and neither needs the other.
    let (outcome_so_far, with_pictures) = (&*outcome, ahead.pictures);
    let draw = || match with_pictures {
        true => pictures::write(folder, prepared, outcome_so_far, &body, &surfaces),
        false => Ok(Vec::new()),
    };
    let write = || write_numbers(prepared, outcome_so_far, origin, folder, ahead, &body, &surfaces);
    let (of_problem, (drawn, written)) = beside(|| sums::of_file(folder, PROBLEM), || beside(draw, write));
    let mut files = written?;
    let pictures = drawn?;
    files.extend(pictures.iter().cloned());
    let mut sums = if stepped { step_sums(folder)? } else { Sums::new() };
    sums.insert(PROBLEM.into(), of_problem?);
    let mut rest = sums::written(folder, &pictures)?;
    rest.retain(|name| !sums.contains_key(name));
    sums.extend(sums::of_files(folder, &rest)?);
    folder::sync(folder, &files)?;
    outcome.seconds.output = outcome.seconds.output + lap();
    outcome.peak_memory = machine::peak_memory().or(outcome.peak_memory);
    let fretting = fretting(folder, outcome, &surfaces);
    let summary = Summary { pictures, fretting, ..Summary::of(prepared, outcome, origin) };
    let text = json::text(&summary);
    sums.insert("summary.json".into(), checksum::of_text(&text));
    sums::write(folder, &sums)?;
    folder::write_text_durably(&folder.join("summary.json"), &text)?;
    files.extend(["summary.json", SUMS].map(String::from));
    for name in &mut files {
        if let Some(steps) = name.strip_suffix(".pvd") {
            *name = format!("{name} with {steps}-0001.vtu ...");
        }
    }
    Ok(files)
}

/// What friction has done to each pair, from the file of the last load step.
fn fretting(folder: &Path, outcome: &Outcome, surfaces: &[SurfaceFields]) -> Vec<FrettingRecord> {
    let last = csv_name(outcome.steps.len());
    if outcome.steps.is_empty() || surfaces.is_empty() {
        return Vec::new();
    }
    // Steps that are in no folder, as those of another program, have none.
    read_figures(&folder.join(last)).map_or(Vec::new(), |figures| records(surfaces, &figures))
}

/// The file of solution number `number`, from 2.
pub(crate) fn other_solution(number: usize) -> String {
    format!("solution-{number}.npz")
}

/// Whether a file of this name holds a solution beside the answer.
pub(crate) fn is_other_solution(name: &str) -> bool {
    let number = name.strip_prefix("solution-").and_then(|rest| rest.strip_suffix(".npz"));
    number.and_then(|number| number.parse().ok()).is_some_and(|number| name == other_solution(number))
}

/// Makes an earlier result in the folder none: first its summary goes, then its pictures and other solutions, which the next
/// one need not replace, and the list that names them.
pub(crate) fn withdraw_result(folder: &Path) -> Result<(), Error> {
    folder::withdraw(&folder.join("summary.json"))?;
    remove_listed(folder, &[])?;
    folder::remove(&folder.join(BOUND))?;
    folder::withdraw(&folder.join(SUMS))?;
    remove_pieces(folder, &|_| true)
}

/// Removes the pictures, other solutions and `more` that the list of an earlier result names. A list that cannot be read names none.
pub(crate) fn remove_listed(folder: &Path, more: &[&str]) -> Result<(), Error> {
    let listed = sums::read(folder).ok().flatten().unwrap_or_default();
    let goes = |name: &&String| name.ends_with(".png") || is_other_solution(name) || more.contains(&&name[..]);
    let named = listed.keys().filter(goes);
    named.map(|name| folder.join(name)).try_for_each(|path| folder::remove(&path))
}

/// Removes what a run on several ranks has left beside the files that others write too, as far as `which` says so.
pub(crate) fn remove_pieces(folder: &Path, which: &dyn Fn(&str) -> bool) -> Result<(), Error> {
    // Load steps count from 1.
    let first = ["result-0000.vtu", "contact-0000.vtu"];
    let pieces = |name: &String| is_piece(name) || PVTU.contains(&&name[..]) || first.contains(&&name[..]);
    let names = folder::names(folder)?.into_iter().filter(pieces).filter(|name| which(name));
    names.map(|name| folder.join(name)).try_for_each(|path| folder::remove(&path))
}

/// The files that name the pieces of a run on several ranks.
pub(crate) const PVTU: [&str; 2] = ["result.pvtu", "contact.pvtu"];

/// The file of what proves a bound.
pub(crate) const BOUND: &str = "bound.npz";
/// The obstacles that are surfaces of triangles.
pub(crate) const OBSTACLES: &str = "obstacles.vtu";
/// The copy of the case.
pub(crate) const CASE: &str = "case.toml";
/// The file of the problem.
const PROBLEM: &str = "problem.npz";

/// All but the problem, the pictures and the summary.
fn write_numbers(
    prepared: &Prepared,
    outcome: &Outcome,
    origin: &Origin,
    folder: &Path,
    ahead: Ahead,
    body: &BodyFields,
    surfaces: &[SurfaceFields],
) -> Result<Vec<String>, Error> {
    let stepped = !outcome.steps.is_empty();
    let mut files = Vec::new();
    let names: &[&str] = if surfaces.is_empty() { &["result"] } else { &["result", "contact"] };
    if stepped {
        // The files of the steps are there already.
        files.extend(names.iter().map(|name| format!("{name}.pvd")));
    } else {
        let grid = ahead.grid.map_or_else(|| encoded(prepared, true), Ok)?;
        write_body(&folder.join("result.vtu"), prepared, &grid, body)?;
        if !surfaces.is_empty() {
            write_contact(&folder.join("contact.vtu"), surfaces, false)?;
            write_csv(&folder.join(CONTACT_CSV), &Units::of(prepared.facts.units.as_deref()), surfaces, None)?;
            files.push(CONTACT_CSV.into());
        }
        files.extend(names.iter().map(|name| format!("{name}.vtu")));
    }
    if write_obstacles(&folder.join(OBSTACLES), &prepared.surfaces)? {
        files.push(OBSTACLES.into());
    }
    let solution = &outcome.solution;
    problem::write_solution(&folder.join("solution.npz"), &solution.u, &solution.lambda)?;
    for (number, other) in (1..).zip(outcome.solutions.iter().flat_map(|found| &found.distinct)).skip(1) {
        let name = other_solution(number);
        problem::write_solution(&folder.join(&name), &other.u, &other.lambda)?;
        files.push(name);
    }
    if let Some(Ok(bound)) = &outcome.bound {
        write_bound(&folder.join(BOUND), &bound.fields, &bound.claim())?;
        files.push(BOUND.into());
    }
    if !stepped {
        folder::write_text(&folder.join("log.jsonl"), &log(outcome, None))?;
    }
    files.extend([PROBLEM, "solution.npz", "log.jsonl"].map(String::from));
    let copy = folder.join(CASE);
    if !origin.is_at(&copy) {
        folder::write_text(&copy, &case(origin))?;
        files.push(CASE.into());
    }
    Ok(files)
}

/// The mesh as files of the body have it, encoded by the threads of rayon or by the caller alone.
pub(crate) fn encoded(prepared: &Prepared, by_threads: bool) -> Result<EncodedGrid, Error> {
    EncodedGrid::new(&Grid::from_mesh(&prepared.mesh), by_threads)
}

pub(crate) fn write_body(path: &Path, prepared: &Prepared, grid: &EncodedGrid, body: &BodyFields) -> Result<(), Error> {
    let material: Vec<i32> = prepared.material_of_cell.iter().map(|&m| m as i32).collect();
    let mut cells = vec![
        Array::tensor("stress", &body.stress),
        Array::single("von_mises", &body.von_mises),
        Array::integer("material", &material),
    ];
    if !body.error.is_empty() {
        cells.push(Array::single("error", &body.error));
    }
    if !body.mean_stress.is_empty() {
        cells.push(Array::tensor("mean_stress", &body.mean_stress));
    }
    vtu::write_encoded(
        path,
        grid,
        &[Array::vector("displacement", &body.displacement), Array::vector("reaction", &body.reaction)],
        &cells,
    )
}

/// The obstacles that are surfaces of triangles, where they are before they move; false if there are none.
pub(crate) fn write_obstacles(path: &Path, of: &[ContactSurface]) -> Result<bool, Error> {
    let mut surfaces = Vec::new();
    for (number, surface) in (0..).zip(of) {
        if let Counterpart::Obstacle(Obstacle::Surface(triangles)) = &surface.against {
            surfaces.push((number, triangles));
        }
    }
    let points: Vec<[f64; 3]> = surfaces.iter().flat_map(|(_, s)| s.points().iter().copied()).collect();
    let mut grid = Grid::new(&points);
    let (mut first, mut pair) = (0, Vec::new());
    for (number, surface) in &surfaces {
        surface.triangles().iter().for_each(|t| grid.push(vtu::TRIANGLE, &t.map(|point| first + point)));
        pair.extend(std::iter::repeat_n(*number, surface.points().len()));
        first += surface.points().len() as u32;
    }
    if surfaces.is_empty() {
        return folder::remove(path).map(|()| false);
    }
    vtu::write(path, &grid, &[Array::integer("pair", &pair)], &[]).map(|()| true)
}

/// The surfaces of all pairs one after the other, of each the slave (`side` 0) and then the master (1); a node of two
/// surfaces stands there twice. With load steps `slid` is
/// what each point has slid since the start, `slip` what it has in the step.
pub(crate) fn write_contact(path: &Path, surfaces: &[SurfaceFields], stepped: bool) -> Result<(), Error> {
    let points: Vec<[f64; 3]> = surfaces.iter().flat_map(|s| s.points.iter().copied()).collect();
    let mut grid = Grid::new(&points);
    let (mut first, mut pair, mut side) = (0, Vec::new(), Vec::new());
    for surface in surfaces {
        for face in &surface.faces {
            let nodes: Vec<u32> = face.iter().map(|node| first + node).collect();
            grid.push(vtu::face_code(nodes.len()), &nodes);
        }
        first += surface.points.len() as u32;
        pair.extend(std::iter::repeat_n(surface.pair as i32, surface.points.len()));
        side.extend(std::iter::repeat_n(i32::from(surface.side == Side::Master), surface.points.len()));
    }
    let scalars = |of: fn(&SurfaceFields) -> &Vec<f64>| surfaces.iter().flat_map(of).copied().collect::<Vec<f64>>();
    let vectors = |of: fn(&SurfaceFields) -> &Vec<[f64; 3]>| surfaces.iter().flat_map(of).copied().collect::<Vec<_>>();
    let integers = |of: fn(&SurfaceFields) -> &Vec<i32>| surfaces.iter().flat_map(of).copied().collect::<Vec<i32>>();
    let (pressure, gap) = (scalars(|s| &s.pressure), scalars(|s| &s.gap));
    let [shear, slip, slid, lambda] =
        [vectors(|s| &s.shear), vectors(|s| &s.slip), vectors(|s| &s.slid), vectors(|s| &s.lambda)];
    let (status, nodes) = (integers(|s| &s.status), integers(|s| &s.nodes));
    let mut arrays = vec![
        Array::scalar("pressure", &pressure),
        Array::vector("shear_traction", &shear),
        Array::vector("slip", &slip),
        Array::scalar("gap", &gap),
        Array::integer("status", &status),
        Array::vector("lambda", &lambda),
        Array::integer("pair", &pair),
        Array::integer("side", &side),
        Array::integer("node", &nodes),
    ];
    let cohesion = scalars(|s| &s.cohesion);
    if cohesion.iter().any(|value| value.is_finite()) {
        arrays.push(Array::scalar("cohesion", &cohesion));
    }
    if stepped {
        arrays.push(Array::vector("slid", &slid));
    }
    vtu::write(path, &grid, &arrays, &[])
}

/// One line an iteration, with the number of its load step if there are any; `seconds` run since its start.
pub(crate) fn log(outcome: &Outcome, number: Option<usize>) -> String {
    let line = |(progress, &seconds): (&Progress, &f64)| {
        let Progress { phase, iteration, residual, products, open, stick, slip } = *progress;
        let mut line = json!({
            "iteration": iteration, "phase": phase, "residual": residual, "products": products,
            "open": open, "stick": stick, "slip": slip, "seconds": seconds,
        });
        if let Some(number) = number {
            line["step"] = number.into();
        }
        format!("{line}\n")
    };
    outcome.solution.history.iter().zip(&outcome.times).map(line).collect()
}

/// What logs call a kind of iteration.
pub fn phase_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Newton => "newton",
        Phase::Gradient => "gradient",
        Phase::FixedPoint => "fixed point",
        Phase::Proximal => "proximal",
        Phase::Uzawa => "uzawa",
        Phase::Multigrid => "multigrid",
    }
}

/// The case file, with the options that changed it as comments.
pub(crate) fn case(origin: &Origin) -> String {
    let mut text = origin.case_text.clone();
    for (number, (key, value)) in origin.overrides.iter().enumerate() {
        if number == 0 {
            text += "\n# Solved with these options, which are not part of the text above:\n";
        }
        text += &format!("# --set {key}={}\n", value.replace(['\n', '\r'], " "));
    }
    text
}
