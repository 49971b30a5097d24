//! `[[cyclic]]`.

use super::data::{CyclicSpec, Region};
use super::read_contact::direction;
use super::read_region::{region, region_at};
use super::view::View;
use crate::Error;

/// One `[[cyclic]]`.
pub(super) fn cyclic(table: &View) -> Result<CyclicSpec, Error> {
    let or_none = |region: Option<Region>| region.unwrap_or(Region::Groups(Vec::new()));
    Ok(CyclicSpec {
        on: or_none(region(table)?),
        against: or_none(region_at(table, "against")?),
        sectors: table.count("sectors"),
        axis: direction(table, "axis")?,
        point: table.vector("point"),
        search: table.given("search").map(|_| table.number("search")),
        spot: table.spot(),
    })
}
