//! `[[step]]`: the time axis.

use super::data::StepSpec;
use super::view::View;
use crate::Error;

/// All steps; their times ascend and their names differ.
pub(super) fn steps(case: &View) -> Result<Vec<StepSpec>, Error> {
    let mut steps: Vec<StepSpec> = Vec::new();
    for (i, (_, table)) in case.tables("step").iter().enumerate() {
        let until = table.number("until");
        let begin = steps.last().map_or(0.0, |step| step.until);
        if until <= begin {
            let what = format!("this step ends at t = {until}, but it begins at t = {begin}, where the last one ended");
            return Err(table.error("until", what, format!("give a time after {begin}: `until` is no duration")));
        }
        let name = match table.given("name") {
            Some(_) => table.text("name"),
            None => format!("step {}", i + 1),
        };
        if steps.iter().any(|other| other.name == name) {
            let key = if table.given("name").is_some() { "name" } else { "until" };
            let remedy = "give this one another name: contacts, supports and bolts refer to steps by their names";
            return Err(table.error(key, format!("two steps are called {name:?}"), remedy));
        }
        steps.push(StepSpec { name, until, increments: table.count("increments"), spot: table.spot() });
    }
    Ok(steps)
}
