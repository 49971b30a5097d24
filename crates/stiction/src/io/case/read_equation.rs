//! `[[equation]]`.

use super::data::{EquationSpec, Region, TermSpec};
use super::read_body::field;
use super::read_contact::direction;
use super::read_region::region;
use super::view::View;
use crate::Error;
use crate::fem::Field;

/// One `[[equation]]`.
pub(super) fn equation(table: &View) -> Result<EquationSpec, Error> {
    let terms: Vec<TermSpec> = table.tables("terms").iter().map(|(_, view)| term(view)).collect::<Result<_, _>>()?;
    if terms.is_empty() {
        let remedy = "write terms = [{ on = .., along = \"x\", factor = 1 }, ..]";
        return Err(table.error("terms", "this equation has no terms", remedy));
    }
    let value = table.given("value").map_or(Ok(Field::Constant(0.0)), |node| field(table, node, &["t"]))?;
    Ok(EquationSpec { terms, value, spot: table.spot() })
}

fn term(view: &View) -> Result<TermSpec, Error> {
    let axis = view
        .given("along")
        .and_then(|node| node.text())
        .and_then(|name| ["x", "y", "z"].iter().position(|n| *n == name));
    let along = match axis {
        Some(axis) => [0, 1, 2].map(|c| f64::from(u8::from(c == axis))),
        None => direction(view, "along")?,
    };
    let factor = view.number("factor");
    if factor == 0.0 {
        return Err(view.error("factor", "this term has the factor zero", "take the term out"));
    }
    Ok(TermSpec { on: region(view)?.unwrap_or(Region::Groups(Vec::new())), along, factor, spot: view.spot() })
}
