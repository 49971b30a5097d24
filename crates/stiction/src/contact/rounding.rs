//! Distances that the coordinates do not resolve.

use crate::mesh::v3::V3;

/// Of the largest coordinate. Each coordinate is known to half a unit in the last place, after a turn to two; a gap weighs several.
const UNITS: f64 = 16.0 * f64::EPSILON;

/// Of a prescribed displacement: components are written with seven digits or more.
const DIGITS: f64 = 1e-6;

/// Whether a node at this distance from an obstacle is led into it by a motion `towards` it, part of one of this `size`; lengths. What
/// a node on a slope enters by the last digits of its components is none.
pub(crate) fn is_led_into(distance: f64, towards: f64, size: f64) -> bool {
    let rounding = DIGITS * size;
    towards > rounding && towards - distance > rounding
}

/// A distance between places, zero where it is no more than rounding of their coordinates leaves; lengths. Such gaps of surfaces that
/// touch would be closed one by one: under loads that deform a body less than they are, few nodes carry it.
pub(super) fn resolved(distance: f64, places: impl IntoIterator<Item = V3>) -> f64 {
    let largest = places.into_iter().flatten().fold(0.0, |largest: f64, coordinate| largest.max(coordinate.abs()));
    if distance.abs() <= UNITS * largest { 0.0 } else { distance }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_led_along_a_slope_in_seven_digits_does_not_enter_it_and_one_led_into_it_does() {
        let (normal, along) = ([0.0, -0.5, 0.75f64.sqrt()], [0.0, 0.001732051, 0.001]);
        let towards = |u: [f64; 3]| -(0..3).map(|c| normal[c] * u[c]).sum::<f64>();
        let size = 0.002;
        // 1e-10 of rounding in 0.002.
        assert!(towards(along) > 1e-11 && !is_led_into(0.0, towards(along), size));
        assert!(is_led_into(0.0, towards([0.0, 0.001733, 0.001]), size));
        // From above it comes to lie on the slope, or enters; one that is inside already is led out of it, or along.
        assert!(!is_led_into(1e-3, 1e-3, size) && is_led_into(1e-3, 1.01e-3, size));
        assert!(!is_led_into(-1e-3, -1e-4, size) && !is_led_into(-1e-3, 0.0, size));
    }
}
