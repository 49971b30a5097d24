//! `[[coupling]]`.

use super::data::{CouplingSpec, Region, StepSpec};
use super::read_body::{field, fields};
use super::read_bolt::during;
use super::read_region::region;
use super::view::View;
use crate::Error;
use crate::fem::Field;

/// All couplings; their names differ.
pub(super) fn couplings(case: &View, steps: &[StepSpec]) -> Result<Vec<CouplingSpec>, Error> {
    let mut couplings: Vec<CouplingSpec> = Vec::new();
    for (i, (_, table)) in case.tables("coupling").iter().enumerate() {
        let coupling = coupling(table, i, steps)?;
        if couplings.iter().any(|other| other.name == coupling.name) {
            let what = format!("two couplings are called {:?}", coupling.name);
            return Err(table.error("name", what, "give this one another name, as in name = \"grip\""));
        }
        couplings.push(coupling);
    }
    Ok(couplings)
}

fn coupling(table: &View, i: usize, steps: &[StepSpec]) -> Result<CouplingSpec, Error> {
    let on = region(table)?.unwrap_or(Region::Groups(Vec::new()));
    let name = match (&on, table.given("name")) {
        (_, Some(_)) => table.text("name"),
        (Region::Groups(groups), None) => groups.iter().map(|g| g.0.as_str()).collect::<Vec<_>>().join("+"),
        _ => format!("coupling {}", i + 1),
    };
    let distributing = table.text("kind") == "distributing";
    if distributing {
        table.refuse(&["components"], "is for kind = \"rigid\": a mean motion has all components", "")?;
    }
    let mut components = [true; 3];
    if table.given("components").is_some() {
        let text = table.text("components");
        if let Some(c) = text.chars().find(|c| !"xyz".contains(*c)) {
            return Err(table.error("components", format!("{c:?} is no component"), "give some of x, y, z"));
        }
        components = ['x', 'y', 'z'].map(|c| text.contains(c));
    }
    let motion = prescribed(table, "motion")?;
    let rotation = prescribed(table, "rotation")?;
    let all = |key: &str| match table.given(key) {
        Some(node) => fields(table, node, &["t"]),
        None => Ok([0.0; 3].map(Field::Constant)),
    };
    let (force, moment) = (all("force")?, all("moment")?);
    let prescribes = motion.iter().chain(&rotation).any(Option::is_some);
    if !prescribes {
        table.refuse(&["from", "until"], "says when `motion` and `rotation` hold, of which there is none", "")?;
    }
    let (during, spot) = (during(table, steps)?, table.spot());
    let point = table.vector("point");
    Ok(CouplingSpec { name, on, point, distributing, components, motion, rotation, force, moment, during, spot })
}

fn prescribed(table: &View, key: &str) -> Result<[Option<Field>; 3], Error> {
    let Some(inner) = table.table(key) else { return Ok([None, None, None]) };
    let one = |name: &str| inner.given(name).map(|node| field(&inner, node, &["t"])).transpose();
    Ok([one("x")?, one("y")?, one("z")?])
}
