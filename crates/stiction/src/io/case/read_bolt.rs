//! `[[bolt]]`.

use super::data::{BoltSpec, Region, StepSpec, Tightening};
use super::during::During;
use super::nearest::nearest;
use super::read_body::of_time;
use super::read_contact::direction;
use super::read_region::extended_region;
use super::view::View;
use crate::Error;

/// The bolts. Where one is tightened by force and there are no load steps, one step is added: its shortening is found
/// along the way.
pub(super) fn bolts(case: &View, steps: &mut Vec<StepSpec>) -> Result<Vec<BoltSpec>, Error> {
    let mut bolts: Vec<BoltSpec> = Vec::new();
    for (_, table) in &case.tables("bolt") {
        let bolt = bolt(table, steps)?;
        if bolts.iter().any(|other| other.name == bolt.name) {
            let what = format!("there are two bolts called {:?}", bolt.name);
            return Err(table.error("name", what, "give each bolt a `name` of its own"));
        }
        bolts.push(bolt);
    }
    let by_force = bolts.iter().find(|bolt| matches!(bolt.by, Tightening::Force(_)));
    if let (Some(bolt), true) = (by_force, steps.is_empty()) {
        steps.push(StepSpec { name: "step 1".into(), until: 1.0, increments: 1, spot: bolt.spot.clone() });
    }
    Ok(bolts)
}

fn bolt(table: &View, steps: &[StepSpec]) -> Result<BoltSpec, Error> {
    let on = extended_region(table, "a bolt")?.unwrap_or(Region::Groups(Vec::new()));
    let name = match (table.given("name"), &on) {
        (Some(_), _) => table.text("name"),
        (None, Region::Groups(groups)) => groups.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", "),
        (None, _) => "bolt".into(),
    };
    let axis = table.given("axis").map(|_| direction(table, "axis")).transpose()?;
    let point = table.given("point").map(|_| table.vector("point"));
    let by = match table.given("force") {
        Some(_) => Tightening::Force(of_time(table, "force")?),
        None => Tightening::Shortening(of_time(table, "shortening")?),
    };
    Ok(BoltSpec { name, on, axis, point, by, lock: step_named(table, "lock", steps)?, spot: table.spot() })
}

/// The steps that `from` and `until` name.
pub(super) fn during(table: &View, steps: &[StepSpec]) -> Result<During, Error> {
    let (from, until) = (step_named(table, "from", steps)?, step_named(table, "until", steps)?);
    match (from, until) {
        (Some(from), Some(until)) if until < from => {
            let what = format!("{:?} comes before {:?}", steps[until].name, steps[from].name);
            Err(table.error("until", what, "name the same step in `until` or a later one"))
        }
        _ => Ok(During { from, until }),
    }
}

/// The place of the step that a key names.
pub(super) fn step_named(table: &View, key: &str, steps: &[StepSpec]) -> Result<Option<usize>, Error> {
    table.given(key).and_then(|node| node.text()).map(|name| step_called(table, key, name, steps)).transpose()
}

/// The place of the step of this name, which `key` gives.
pub(super) fn step_called(table: &View, key: &str, name: &str, steps: &[StepSpec]) -> Result<usize, Error> {
    if let Some(step) = steps.iter().position(|step| step.name == name) {
        return Ok(step);
    }
    let what = format!("there is no step called {name:?}");
    if steps.is_empty() {
        return Err(table.error(key, what, format!("add [[step]] with that name, or take `{key}` out")));
    }
    let names = || steps.iter().map(|step| step.name.as_str());
    let guess = nearest(name, names()).map_or(String::new(), |guess| format!("did you mean {guess:?}? "));
    Err(table.error(key, what, format!("{guess}the steps are {}", names().collect::<Vec<_>>().join(", "))))
}
