//! `[[fix]]`, `[[spring]]` and `[[load]]`: what acts on the body.

use super::data::{Beginning, CYLINDRICAL, FixSpec, LoadKind, LoadSpec, NodalSpec, Region, SpringSpec, StepSpec};
use super::during::During;
use super::read_bolt::during;
use super::read_contact::direction;
use super::read_region::{extended_region, region};
use super::source::At;
use super::tree::{Node, Value};
use super::view::View;
use crate::Error;
use crate::fem::{Axes, Field, frame};
use crate::io::expression::{VARIABLES, compile};

/// One `[[fix]]`.
pub(super) fn fix(table: &View, steps: &[StepSpec]) -> Result<FixSpec, Error> {
    let during = during(table, steps)?;
    let beginning = match table.given("condition").and_then(|node| node.text()) {
        None => Beginning::Led,
        Some("as-it-stands") => {
            let why = "stands beside condition = \"as-it-stands\", which holds the nodes where they are";
            table.refuse(&["value"], why, ", or `condition`")?;
            Beginning::Stays
        }
        Some("at-once") => Beginning::AtOnce,
        Some(_) => return symmetry(table, during),
    };
    if beginning != Beginning::Led && during.from.is_none_or(|from| from == 0) {
        let what = "nothing has moved yet where the first step begins";
        return Err(table.error("condition", what, "add from = \"STEP\" with a later step"));
    }
    let axes = axes(table)?;
    let letters = if matches!(axes, Axes::Cylinder { .. }) { CYLINDRICAL } else { ["x", "y", "z"] };
    let components = components(table, letters)?;
    let names = || components.iter().map(|&c| letters[c]).collect::<Vec<_>>().join(", ");
    let mut value = [None, None, None];
    for &c in &components {
        value[c] = Some(Field::Constant(0.0));
    }
    if let Some(node) = table.given("value") {
        let entries = match &node.value {
            Value::List(items) => items.as_slice(),
            _ => std::slice::from_ref(node),
        };
        if entries.len() != components.len() {
            let (given, held) = (entries.len(), components.len());
            let what = format!("`value` has {given} of the {held} components that are held ({})", names());
            return Err(table.error("value", what, format!("give a list with one entry for each of {}", names())));
        }
        for (&c, entry) in components.iter().zip(entries) {
            value[c] = Some(field(table, entry, &VARIABLES)?);
        }
    }
    let on = region(table)?.unwrap_or(Region::Groups(Vec::new()));
    Ok(FixSpec { on, value, axes, symmetry: false, beginning, during, spot: table.spot() })
}

/// What the components count along.
fn axes(table: &View) -> Result<Axes, Error> {
    if let Some(cylinder) =
        table.table("axes").filter(|_| table.given("axes").is_some_and(|node| node.items().is_empty()))
    {
        return Ok(Axes::Cylinder { point: cylinder.vector("point"), axis: direction(&cylinder, "axis")? });
    }
    if table.given("axes").is_none() {
        return Ok(Axes::Global);
    }
    let frame = frame(table.vectors("axes"));
    frame.map(Axes::Turned).map_err(|what| table.error("axes", what, "give two directions that are not parallel"))
}

/// A plane of symmetry; which component it holds, the faces will say.
fn symmetry(table: &View, during: During) -> Result<FixSpec, Error> {
    let why = "stands beside condition = \"symmetry\", which holds the normal of the faces at zero";
    table.refuse(&["components", "value", "axes"], why, ", or `condition`")?;
    let on = extended_region(table, "symmetry")?.unwrap_or(Region::Groups(Vec::new()));
    let (value, axes, spot) = ([None, None, None], Axes::Global, table.spot());
    Ok(FixSpec { on, value, axes, symmetry: true, beginning: Beginning::Led, during, spot })
}

/// One `[[spring]]`.
pub(super) fn spring(table: &View) -> Result<SpringSpec, Error> {
    let (normal, tangential) = (table.number("normal"), table.number("tangential"));
    if normal + tangential == 0.0 {
        let what = "this [[spring]] has no stiffness";
        return Err(table.error("", what, "add normal = 5e7, tangential = 1e7, or both"));
    }
    let on = extended_region(table, "a spring")?.unwrap_or(Region::Groups(Vec::new()));
    Ok(SpringSpec { on, normal, tangential, spot: table.spot() })
}

/// The components named by `letters`, in their order; all if none are.
fn components(table: &View, letters: [&str; 3]) -> Result<Vec<usize>, Error> {
    if table.given("components").is_none() {
        return Ok(vec![0, 1, 2]);
    }
    let text = table.text("components");
    let mut components = Vec::new();
    for c in text.chars() {
        match letters.iter().position(|name| name.starts_with(c)) {
            Some(i) if !components.contains(&i) => components.push(i),
            found => {
                let what = match found {
                    Some(_) => format!("`components` names {c} twice"),
                    None => format!("`components` contains {c:?}"),
                };
                let [first, _, third] = letters;
                let remedy = format!("write some of {}, as in components = \"{first}{third}\"", letters.join(", "));
                return Err(table.error("components", what, remedy));
            }
        }
    }
    Ok(components)
}

/// One `[[load]]`.
pub(super) fn load(table: &View) -> Result<LoadSpec, Error> {
    let (key, kind) = load_kind(table)?;
    if !["force", "moment"].contains(&key) {
        table.refuse(&["about"], &format!("is for a force or a moment, but the load is a {key}"), "")?;
    }
    let on = if kind.at_nodes() { region(table)? } else { extended_region(table, key)? };
    if on.is_none() && !kind.on_cells() && !kind.at_nodes() {
        return Err(table.error(key, format!("this {key} does not say where it acts"), "add on = \"z-max\""));
    }
    Ok(LoadSpec { on, kind, spot: table.spot() })
}

/// The value of a load and the key it stands under.
fn load_kind(table: &View) -> Result<(&'static str, LoadKind), Error> {
    // A total has no position.
    let total = |key: &str| match table.given(key) {
        Some(node) => fields(table, node, &["t"]),
        None => Ok([Field::Constant(0.0), Field::Constant(0.0), Field::Constant(0.0)]),
    };
    Ok(if let Some(node) = table.given("traction") {
        ("traction", LoadKind::Traction(fields(table, node, &VARIABLES)?))
    } else if let Some(node) = table.given("pressure") {
        ("pressure", LoadKind::Pressure(field(table, node, &VARIABLES)?))
    } else if table.given("moment").is_some() || table.given("about").is_some() && table.given("force").is_some() {
        let about = table.given("about").map(|_| table.vector("about"));
        let key = if table.given("force").is_some() { "force" } else { "moment" };
        (key, LoadKind::Resultant { force: total("force")?, moment: total("moment")?, about })
    } else if table.given("force").is_some() {
        ("force", LoadKind::Force(total("force")?))
    } else if let Some(node) = table.given("nodal") {
        ("nodal", LoadKind::Nodal(nodal(table, node)?))
    } else if let Some(liquid) = table.table("hydrostatic") {
        let (weight, up) = (liquid.number("weight"), direction(&liquid, "up")?);
        ("hydrostatic", LoadKind::Hydrostatic { weight, level: of_time(&liquid, "level")?, up })
    } else if let Some(node) = table.given("gravity") {
        ("gravity", LoadKind::Gravity(fields(table, node, &VARIABLES)?))
    } else if let Some(turn) = table.table("rotation") {
        let (axis, point) = (direction(&turn, "axis")?, turn.vector("point"));
        ("rotation", LoadKind::Rotation { axis, point, speed: of_time(&turn, "speed")? })
    } else if let Some(node) = table.given("temperature") {
        ("temperature", temperature(table, node)?)
    } else {
        return Err(table.error("", "this [[load]] has no value", "add a traction, pressure, force or gravity"));
    })
}

/// The components of a force at nodes.
fn nodal(table: &View, node: &Node) -> Result<[NodalSpec; 3], Error> {
    let component = |i: usize| -> Result<NodalSpec, Error> {
        let Some(item) = node.items().get(i) else { return Ok(NodalSpec::Field(Field::Constant(0.0))) };
        let Some(name) = item.get("array").and_then(Node::text) else {
            return Ok(NodalSpec::Field(field(table, item, &VARIABLES)?));
        };
        let ramp = item.get("ramp").map_or(Ok(Field::Constant(1.0)), |ramp| field(table, ramp, &["t"]))?;
        Ok(NodalSpec::Array { name: name.into(), ramp, spot: table.source.spot(&item.at) })
    };
    Ok([component(0)?, component(1)?, component(2)?])
}

fn temperature(table: &View, node: &Node) -> Result<LoadKind, Error> {
    match table.table("temperature").filter(|_| !node.entries().is_empty()) {
        Some(array) => {
            let (name, spot) = (array.text("array"), array.source.spot(&node.at));
            Ok(LoadKind::TemperatureArray { name, ramp: of_time(&array, "ramp")?, spot })
        }
        None => Ok(LoadKind::Temperature(field(table, node, &VARIABLES)?)),
    }
}

/// A number or an expression in t, 1 if it is not given.
pub(super) fn of_time(table: &View, key: &str) -> Result<Field, Error> {
    table.given(key).map_or(Ok(Field::Constant(1.0)), |node| field(table, node, &["t"]))
}

pub(super) fn fields(table: &View, node: &Node, allowed: &[&str]) -> Result<[Field; 3], Error> {
    let mut fields = [Field::Constant(0.0), Field::Constant(0.0), Field::Constant(0.0)];
    for (component, item) in fields.iter_mut().zip(node.items()) {
        *component = field(table, item, allowed)?;
    }
    Ok(fields)
}

pub(super) fn field(table: &View, node: &Node, allowed: &[&str]) -> Result<Field, Error> {
    let Some(text) = node.text() else {
        return Ok(Field::Constant(node.number().unwrap_or(f64::NAN)));
    };
    compile(text, allowed).map_err(|fault| {
        // Between plain quotes the fault itself can be marked; with escapes in the text only the whole.
        let at = match &node.at {
            At::File(span) if table.source.text.get(span.start + 1..span.end.saturating_sub(1)) == Some(text) => {
                At::File(span.start + 1 + fault.span.start..span.start + 1 + fault.span.end)
            }
            at => at.clone(),
        };
        table.source.spot(&at).error(fault.what, fault.remedy)
    })
}
