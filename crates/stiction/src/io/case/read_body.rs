//! `[[fix]]` and `[[load]]`: what acts on the body.

use super::data::{FixSpec, LoadKind, LoadSpec, Region};
use super::read_region::{extended_region, region};
use super::source::At;
use super::tree::{Node, Value};
use super::view::View;
use crate::Error;
use crate::fem::Field;
use crate::io::expression::{VARIABLES, compile};

/// One `[[fix]]`.
pub(super) fn fix(table: &View) -> Result<FixSpec, Error> {
    let components = components(table)?;
    let names = || components.iter().map(|&c| VARIABLES[c]).collect::<Vec<_>>().join(", ");
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
    Ok(FixSpec { on, value, spot: table.spot() })
}

/// The components named, in their order.
fn components(table: &View) -> Result<Vec<usize>, Error> {
    let text = table.text("components");
    let mut components = Vec::new();
    for c in text.chars() {
        match ['x', 'y', 'z'].iter().position(|&name| name == c) {
            Some(i) if !components.contains(&i) => components.push(i),
            found => {
                let what = match found {
                    Some(_) => format!("`components` names {c} twice"),
                    None => format!("`components` contains {c:?}"),
                };
                return Err(table.error("components", what, "write some of x, y, z, as in components = \"xz\""));
            }
        }
    }
    Ok(components)
}

/// One `[[load]]`.
pub(super) fn load(table: &View) -> Result<LoadSpec, Error> {
    let (key, kind) = if let Some(node) = table.given("traction") {
        ("traction", LoadKind::Traction(fields(table, node, &VARIABLES)?))
    } else if let Some(node) = table.given("pressure") {
        ("pressure", LoadKind::Pressure(field(table, node, &VARIABLES)?))
    } else if let Some(node) = table.given("force") {
        // A total has no position.
        ("force", LoadKind::Force(fields(table, node, &["t"])?))
    } else if let Some(node) = table.given("gravity") {
        ("gravity", LoadKind::Gravity(fields(table, node, &VARIABLES)?))
    } else {
        return Err(table.error("", "this [[load]] has no value", "add a traction, pressure, force or gravity"));
    };
    let on = extended_region(table, key)?;
    if on.is_none() && key != "gravity" {
        return Err(table.error(key, format!("this {key} does not say where it acts"), "add on = \"z-max\""));
    }
    Ok(LoadSpec { on, kind, spot: table.spot() })
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
