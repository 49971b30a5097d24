//! Case files: from TOML to a checked [`Case`], with errors that show the line.
//!
//! The way through: `tree` parses with places, `set` applies overrides, `check` holds the tree against the keys of
//! `spec`, and the `read_*` files turn what has passed into the plain data of `data`. To add a key, add a line to
//! `spec` and read it; the validation, the messages and the JSON schema follow.

mod check;
mod data;
mod during;
mod kind;
mod nearest;
mod read_accuracy;
mod read_body;
mod read_bolt;
mod read_contact;
mod read_coupling;
mod read_cyclic;
mod read_equation;
mod read_mesh;
mod read_region;
mod read_solver;
mod read_step;
mod schema;
mod set;
mod source;
mod spec;
mod templates;
#[cfg(test)]
mod tests;
mod tree;
mod view;

use std::fs::File;
use std::io::Read;
use std::path::Path;

pub use data::*;
pub use during::During;
pub use nearest::nearest;
pub use schema::schema;
pub use source::Spot;
pub use templates::{Template, templates};

use crate::Error;
use source::{At, Source};
use view::View;

/// Bytes of a case file. Its tree takes up to 560 times as much (keys of many dots); the shipped cases have one to three thousand.
const LARGEST: u64 = 100 << 10;

/// Reads the case file at `path`. Each override is a dotted path and a value: `("contact.0.friction.coulomb", "0.2")`.
///
/// # Errors
/// If the file cannot be read, or a key is unknown, missing or out of range: with line, column and the nearest valid name.
pub fn read(path: impl AsRef<Path>, overrides: &[(String, String)]) -> Result<Case, Error> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let mut bytes = Vec::new();
    let opened = File::open(path).and_then(|file| file.take(LARGEST + 1).read_to_end(&mut bytes));
    opened.map_err(|error| {
        Error::new(
            &name,
            format!("the case file cannot be read: {error}"),
            "check the path, or start with `stiction new`",
        )
    })?;
    if bytes.len() as u64 > LARGEST {
        let what = format!("the case file has more than {} kB", LARGEST >> 10);
        return Err(Error::new(name, what, "give a case file; meshes and fields have files of their own"));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(&error.as_bytes()[..good]).into_owned();
        let spot = Source { name: &name, text: &text, overrides: &[], marks: &[] }.spot(&At::File(good..good));
        spot.error("the case file is not UTF-8 text from here on", "save it as UTF-8 in your editor")
    })?;
    interpret(&text, &name, overrides, path.parent().unwrap_or(Path::new("")), &[])
}

/// Reads a case from its text; `name` stands for the file in messages, and mesh files stay relative as they are.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, name: &str, overrides: &[(String, String)]) -> Result<Case, Error> {
    interpret(text, name, overrides, Path::new(""), &[])
}

/// The same of a text that was made: errors stand at the places that its tables come from, each given with the byte its
/// table begins at.
pub(in crate::io) fn parse_marked(
    text: &str,
    name: &str,
    overrides: &[(String, String)],
    marks: &[(usize, Spot)],
) -> Result<Case, Error> {
    interpret(text, name, overrides, Path::new(""), marks)
}

fn interpret(
    text: &str,
    name: &str,
    overrides: &[(String, String)],
    folder: &Path,
    marks: &[(usize, Spot)],
) -> Result<Case, Error> {
    // Some editors put a byte order mark first; it must not shift the columns.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let source = Source { name, text, overrides, marks };
    let mut root = tree::parse(&source)?;
    set::apply(&source, &mut root)?;
    check::check(&source, &root, &spec::CASE)?;
    let case = View { source: &source, rules: &spec::CASE, node: &root };
    let mut steps = read_step::steps(&case)?;
    let contacts = read_contact::contacts(&case, folder, &steps)?;
    let solver = read_solver::solver(&case, &contacts)?;
    let bolts = read_bolt::bolts(&case, &mut steps)?;
    let case = Case {
        title: title(&case),
        units: case.given("units").map(|_| case.text("units")),
        mesh: read_mesh::mesh(&case, folder)?,
        materials: read_mesh::materials(&case)?,
        fixes: each(&case, "fix", |table| read_body::fix(table, &steps))?,
        springs: each(&case, "spring", read_body::spring)?,
        loads: each(&case, "load", read_body::load)?,
        accuracy: read_accuracy::accuracy(&case, &solver, !contacts.is_empty(), !bolts.is_empty())?,
        equations: each(&case, "equation", read_equation::equation)?,
        cyclic: each(&case, "cyclic", read_cyclic::cyclic)?,
        couplings: read_coupling::couplings(&case, &steps)?,
        bolts,
        contacts,
        solver,
        steps,
        notes: Vec::new(),
    };
    weighs_something(&case)?;
    no_refined_points(&case)?;
    Ok(case)
}

fn each<T>(case: &View, key: &str, read: impl Fn(&View) -> Result<T, Error>) -> Result<Vec<T>, Error> {
    case.tables(key).iter().map(|(_, table)| read(table)).collect()
}

fn title(case: &View) -> String {
    match case.given("title") {
        Some(_) => case.text("title"),
        None => Path::new(case.source.name).file_stem().map_or(String::new(), |s| s.to_string_lossy().into_owned()),
    }
}

/// Under forces at nodes the energy grows without end as the mesh is refined.
fn no_refined_points(case: &Case) -> Result<(), Error> {
    if !case.accuracy.as_ref().is_some_and(AccuracySpec::refines) {
        return Ok(());
    }
    if let Some(load) = case.loads.iter().find(|load| load.kind.at_nodes()) {
        let what = "a force at a node has no answer that a finer mesh would come nearer to";
        return Err(load.spot.error(what, "give the load as a force on faces, or leave [accuracy] out"));
    }
    let rigid = case.couplings.iter().find(|coupling| !coupling.distributing).map(|coupling| &coupling.spot);
    if let Some(spot) = rigid {
        let what = "a rigid coupling acts by forces at nodes, whose error is not estimated";
        return Err(spot.error(what, "give kind = \"distributing\", or leave [accuracy] out"));
    }
    if let Some(cyclic) = case.cyclic.first() {
        let what = "the cuts of a cyclic symmetry would not match on a refined mesh";
        return Err(cyclic.spot.error(what, "refine the mesh where it is made, or leave [accuracy] out"));
    }
    match case.equations.first() {
        Some(equation) => {
            let what =
                "an equation acts by forces at nodes, which have no answer that a finer mesh would come nearer to";
            Err(equation.spot.error(what, "leave [accuracy] out"))
        }
        None => Ok(()),
    }
}

/// Gravity or rotation of bodies without mass does nothing, which nobody means.
fn weighs_something(case: &Case) -> Result<(), Error> {
    let name = |load: &LoadSpec| match load.kind {
        LoadKind::Gravity(_) => Some("gravity"),
        LoadKind::Rotation { .. } => Some("rotation"),
        _ => None,
    };
    let on_mass = case.loads.iter().find_map(|load| name(load).map(|name| (load, name)));
    match on_mass {
        Some((load, name)) if case.materials.iter().all(|spec| spec.material.density == 0.0) => {
            let what = format!("{name} acts on nothing: no material has a density");
            Err(load.spot.error(what, "add density = ... to a material"))
        }
        _ => Ok(()),
    }
}
