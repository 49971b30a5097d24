//! `on`: which part of the body is meant.

use super::data::Region;
use super::source::{Source, Spot};
use super::tree::Node;
use super::view::{View, vector};
use crate::Error;

/// The region under `on`, if the table has one.
pub(super) fn region(table: &View) -> Result<Option<Region>, Error> {
    region_at(table, "on")
}

/// The region under `key`, if the table has one.
pub(super) fn region_at(table: &View, key: &str) -> Result<Option<Region>, Error> {
    let Some(node) = table.given(key) else {
        return Ok(None);
    };
    if let Some(corners) = node.get("box") {
        let corner = |i: usize| corners.items().get(i).map_or([f64::NAN; 3], vector);
        let (min, max) = (corner(0), corner(1));
        if (0..3).any(|i| min[i] > max[i]) {
            let what = format!("the box from {min:?} to {max:?} is empty");
            return Err(table.source.spot(&corners.at).error(what, "give the lowest corner first, then the highest"));
        }
        return Ok(Some(Region::Box { min, max }));
    }
    if let Some(point) = node.get("point") {
        return Ok(Some(Region::Point(vector(point))));
    }
    Ok(Some(Region::Groups(groups(table.source, node))))
}

/// The region under `on` of something that acts on a surface or a volume.
pub(super) fn extended_region(table: &View, what: &str) -> Result<Option<Region>, Error> {
    match region(table)? {
        Some(Region::Point(_)) => {
            let what = format!("{what} acts on a surface or volume, and a point has neither");
            Err(table.error("on", what, "give a group, or a { box = ... } around the faces"))
        }
        region => Ok(region),
    }
}

/// The names under `on`, each with its place.
pub(super) fn groups(source: &Source, node: &Node) -> Vec<(String, Spot)> {
    let one = |node: &Node| node.text().map(|name| (name.to_string(), source.spot(&node.at)));
    one(node).into_iter().chain(node.items().iter().filter_map(one)).collect()
}
