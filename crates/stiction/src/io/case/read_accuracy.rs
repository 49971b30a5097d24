//! `[accuracy]`: how accurate the answer has to be.

use super::data::{AccuracySpec, SolverSpec};
use super::spec::PART;
use super::view::View;
use crate::Error;
use crate::friction::Method;

/// The goals of a case, if it has some. Forces are those of contacts and bolts, pressures of contacts only.
pub(super) fn accuracy(
    case: &View,
    solver: &SolverSpec,
    has_contact: bool,
    has_bolts: bool,
) -> Result<Option<AccuracySpec>, Error> {
    let Some(table) = case.table("accuracy") else { return Ok(None) };
    if solver.method.method != Method::Newton || solver.starts.is_some() {
        let what = "meshes are refined for one answer of Newton's method";
        return Err(table.spot().error(what, "take out [accuracy], or `method` and `starts` under [solver]"));
    }
    let [energy, forces, displacement, pressure] =
        ["energy", "forces", "displacement", "pressure"].map(|key| goal(&table, key));
    for (key, has_values, of) in
        [("forces", has_contact || has_bolts, "neither contact nor a bolt"), ("pressure", has_contact, "no contact")]
    {
        if table.given(key).is_some() && !has_values {
            return Err(table.error(
                key,
                format!("`{key}` is asked for, and the case has {of}"),
                "ask for `energy` or `displacement`",
            ));
        }
    }
    let mut spec = AccuracySpec {
        energy: energy?,
        forces: forces?,
        displacement: displacement?,
        pressure: pressure?,
        max_unknowns: table.given("max_unknowns").map(|_| table.count("max_unknowns")),
        quadratic: table.text("element") == "tet10",
        proven: table.flag("proven"),
    };
    let goals = [spec.energy, spec.forces, spec.displacement, spec.pressure];
    // Who asks for meshes of a kind or size asks for refinement.
    let only_proven = spec.proven && ["max_unknowns", "element"].iter().all(|key| table.given(key).is_none());
    if goals.iter().all(Option::is_none) && !only_proven {
        spec.energy = Some(USUAL);
    }
    Ok(Some(spec))
}

/// Goal in the energy norm where none is given.
const USUAL: f64 = 0.05;

/// The goal under `key` as a part of one.
fn goal(table: &View, key: &str) -> Result<Option<f64>, Error> {
    let Some(node) = table.given(key) else { return Ok(None) };
    if let Some(part) = node.number() {
        return Ok(Some(part));
    }
    let text = node.text().unwrap_or_default();
    let percent = text.trim().strip_suffix('%').and_then(|number| number.trim().parse::<f64>().ok());
    match percent.map(|percent| percent / 100.0).filter(|part| PART.contain(*part)) {
        Some(part) => Ok(Some(part)),
        None => {
            let what = format!("`{key}` is {text:?}, which is no accuracy from 0.01 % to 50 %");
            Err(table.error(key, what, format!("write {key} = \"2%\"")))
        }
    }
}
