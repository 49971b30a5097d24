//! Distances that the coordinates do not resolve.

use crate::mesh::v3::V3;

/// Of the largest coordinate. Each coordinate is known to half a unit in the last place, after a turn to two; a gap weighs several.
const UNITS: f64 = 16.0 * f64::EPSILON;

/// A distance between places, zero where it is no more than rounding of their coordinates leaves; lengths. Such gaps of surfaces that
/// touch would be closed one by one: under loads that deform a body less than they are, few nodes carry it.
pub(super) fn resolved(distance: f64, places: impl IntoIterator<Item = V3>) -> f64 {
    let largest = places.into_iter().flatten().fold(0.0, |largest: f64, coordinate| largest.max(coordinate.abs()));
    if distance.abs() <= UNITS * largest { 0.0 } else { distance }
}
