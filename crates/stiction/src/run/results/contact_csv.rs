//! `contact.csv`: a line for each node of the contact surfaces, with the units in its head.

use std::array::from_fn;
use std::fmt::Write as _;
use std::path::Path;

use super::fields::{Side, SurfaceFields};
use super::fretting::{FIGURES, Fretting, PointStep, point_steps, tension_along};
use crate::Error;
use crate::io::folder;
use crate::io::units::Units;
use crate::mesh::v3::norm;
use crate::run::pose::Prepared;
use crate::run::solve::Outcome;
use crate::run::solve::quantities::stress_at;

/// The file of an answer without load steps.
pub(crate) const CONTACT_CSV: &str = "contact.csv";

/// Columns that are always there: name and unit.
const COLUMNS: [(&str, Unit); 23] = [
    ("pair", Unit::None),
    ("side", Unit::None),
    ("node", Unit::None),
    ("status", Unit::None),
    ("x", Unit::Length),
    ("y", Unit::Length),
    ("z", Unit::Length),
    ("area", Unit::Area),
    ("gap", Unit::Length),
    ("pressure", Unit::Stress),
    ("shear_x", Unit::Stress),
    ("shear_y", Unit::Stress),
    ("shear_z", Unit::Stress),
    ("slip_x", Unit::Length),
    ("slip_y", Unit::Length),
    ("slip_z", Unit::Length),
    ("slid_x", Unit::Length),
    ("slid_y", Unit::Length),
    ("slid_z", Unit::Length),
    ("force_x", Unit::Force),
    ("force_y", Unit::Force),
    ("force_z", Unit::Force),
    ("name", Unit::None),
];

/// Columns of load steps, before the name.
const FRETTING: [(&str, Unit); FIGURES] = [
    ("tension", Unit::Stress),
    ("step_work", Unit::Work),
    ("work", Unit::Work),
    ("path", Unit::Length),
    ("slip_amplitude", Unit::Length),
    ("shear_amplitude", Unit::Stress),
    ("max_shear", Unit::Stress),
    ("max_tension", Unit::Stress),
    ("ruiz_1", Unit::Work),
    ("ruiz_2", Unit::WorkStress),
    ("wear", Unit::Length),
    (STEP_PRESSED, Unit::Work),
];

/// The column of pressure times slip in the step.
const STEP_PRESSED: &str = "step_pressed";

#[derive(Clone, Copy, PartialEq)]
enum Unit {
    None,
    Length,
    Area,
    Force,
    Stress,
    Work,
    WorkStress,
}

impl Unit {
    fn label(self, units: &Units) -> String {
        let Units { length, force, stress } = *units;
        if length.is_empty() {
            return match self {
                Unit::None => String::new(),
                Unit::Length => " [length]".into(),
                Unit::Area => " [length^2]".into(),
                Unit::Force => " [force]".into(),
                Unit::Stress => " [stress]".into(),
                Unit::Work => " [stress length]".into(),
                Unit::WorkStress => " [stress^2 length]".into(),
            };
        }
        match self {
            Unit::None => String::new(),
            Unit::Length => format!(" [{length}]"),
            Unit::Area => format!(" [{length}^2]"),
            Unit::Force => format!(" [{force}]"),
            Unit::Stress => format!(" [{stress}]"),
            Unit::Work => format!(" [{stress} {length}]"),
            Unit::WorkStress => format!(" [{stress}^2 {length}]"),
        }
    }
}

/// The largest tension along the surface at each node of the surfaces; NaN where no point is.
pub(crate) fn tensions(prepared: &Prepared, outcome: &Outcome, surfaces: &[SurfaceFields]) -> Vec<f64> {
    let is_point = |s: &SurfaceFields, at: usize| s.side == Side::Slave && s.status[at] >= 0;
    let mut wanted = vec![false; prepared.mesh.nodes.len()];
    for s in surfaces {
        (0..s.nodes.len()).filter(|&at| is_point(s, at)).for_each(|at| wanted[s.nodes[at] as usize] = true);
    }
    let stress = stress_at(prepared, &outcome.solution.u, &wanted);
    let of = |s: &SurfaceFields, at: usize| match is_point(s, at) {
        true => tension_along(&stress[s.nodes[at] as usize], s.normal[at]),
        false => f64::NAN,
    };
    surfaces.iter().flat_map(|s| (0..s.nodes.len()).map(move |at| of(s, at))).collect()
}

/// The figures of all nodes of the surfaces, one after the other; `tension` at all of them. NaN where no point is.
pub(crate) fn figures_of(
    prepared: &Prepared,
    surfaces: &[SurfaceFields],
    of: &Fretting,
    tension: &[f64],
) -> Vec<[f64; FIGURES]> {
    let wear = |s: &SurfaceFields| prepared.facts.contacts.get(s.pair).and_then(|contact| contact.wear);
    let places = surfaces.iter().flat_map(|s| (0..s.nodes.len()).map(move |at| (s, at)));
    let figures = |(place, (s, at)): (usize, (&SurfaceFields, usize))| {
        let known = s.side == Side::Slave && s.status[at] >= 0;
        if known { of.at(place).figures(tension[place], wear(s)) } else { [f64::NAN; FIGURES] }
    };
    places.enumerate().map(figures).collect()
}

/// Writes the file in these units; of load steps with the figures of all nodes.
pub(crate) fn write_csv(
    path: &Path,
    units: &Units,
    surfaces: &[SurfaceFields],
    figures: Option<&[[f64; FIGURES]]>,
) -> Result<(), Error> {
    let (name, own) = COLUMNS.split_last().unwrap_or((&("name", Unit::None), &[]));
    let more: &[(&str, Unit)] = if figures.is_some() { &FRETTING } else { &[] };
    let columns = own.iter().chain(more).chain([name]);
    let head: Vec<String> = columns.map(|(name, unit)| quoted(&format!("{name}{}", unit.label(units)))).collect();
    let mut text = head.join(",") + "\n";
    let mut figures = figures.map(|figures| figures.iter());
    for surface in surfaces {
        for at in 0..surface.nodes.len() {
            line(&mut text, surface, at);
            figures.iter_mut().filter_map(Iterator::next).for_each(|figures| numbers(&mut text, figures));
            text += &quoted(&surface.name);
            text.push('\n');
        }
    }
    folder::write_text(path, &text)
}

fn line(text: &mut String, s: &SurfaceFields, at: usize) {
    let side = i32::from(s.side == Side::Master);
    let _ = write!(text, "{},{side},{},{},", s.pair, s.nodes[at], s.status[at]);
    numbers(text, &s.points[at]);
    numbers(text, &[s.area[at], s.gap[at], s.pressure[at]]);
    [s.shear[at], s.slip[at], s.slid[at], s.lambda[at]].iter().for_each(|vector| numbers(text, vector));
}

/// Numbers with all their digits, nothing where there is none; each with a comma behind it.
fn numbers(text: &mut String, values: &[f64]) {
    for &value in values {
        let _ = match value {
            0.0 => write!(text, "0,"),
            value if value.is_finite() => write!(text, "{value:e},"),
            _ => write!(text, ","),
        };
    }
}

/// A field that may hold commas and quotes (RFC 4180); it stays on its line.
fn quoted(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

/// Adds the step that a file holds to what its points have been through.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn replay(path: &Path, fretting: &mut Fretting) -> Result<(), Error> {
    let text = folder::read_text(path)?;
    let mut lines = text.lines();
    let has_pressed = lines.next().is_some_and(|head| head.contains(STEP_PRESSED));
    fretting.add(lines.map(|line| point_step(line, has_pressed)));
    Ok(())
}

/// The figures of each node that the file of a load step holds; NaN where there are none.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn read_figures(path: &Path) -> Result<Vec<[f64; FIGURES]>, Error> {
    let of_line = |line: &str| {
        let mut fields = line.split(',').skip(COLUMNS.len() - 1);
        from_fn(|_| fields.next().and_then(|field| field.parse().ok()).unwrap_or(f64::NAN))
    };
    Ok(folder::read_text(path)?.lines().skip(1).map(of_line).collect())
}

/// What a line says of its point. Files of earlier versions do not have the column of pressure times slip.
fn point_step(line: &str, has_pressed: bool) -> Option<PointStep> {
    let mut fields = line.split(',');
    let mut whole = || fields.next()?.parse::<i32>().ok();
    let (_pair, side, _node, status) = (whole()?, whole()?, whole()?, whole()?);
    let values: Vec<f64> = fields.take(18 + FIGURES).map(|field| field.parse().unwrap_or(f64::NAN)).collect();
    let three = |at: usize| Some([*values.get(at)?, *values.get(at + 1)?, *values.get(at + 2)?]);
    let known = side == 0 && status >= 0;
    let (tension, work) = (*values.get(18)?, *values.get(19)?);
    let (shear, slip, slid) = (three(6)?, three(9)?, three(12)?);
    let pressed = if has_pressed { *values.get(17 + FIGURES)? } else { *values.get(5)? * norm(slip) };
    known.then_some(PointStep { work, pressed, shear, slip, slid, tension, touching: status > 0 })
}

/// Adds the step at whose end the surfaces are like this.
pub(crate) fn advance(fretting: &mut Fretting, surfaces: &[SurfaceFields], tension: &[f64]) {
    fretting.add(point_steps(surfaces, tension));
}
