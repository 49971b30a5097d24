//! Colours: one perceptually uniform map for numbers, one palette for the state of a contact point.

use std::sync::LazyLock;

pub(super) use crate::io::look::{MISSING, OUTSIDE, Rgb, STATUS, viridis};

pub(super) const INK: Rgb = [34, 34, 34];
pub(super) const GRID: Rgb = [225, 225, 225];
/// What gives each vertex its colour.
#[derive(Clone, Copy)]
pub(super) enum Paint<'a> {
    /// Interpolated between the vertices; `range` is what the ends of the map stand for.
    Scalar { values: &'a [f64], range: [f64; 2] },
    /// 0 open, 1 stick, 2 slip, anything else none of them; each place takes the state of its nearest vertex.
    Status(&'a [u8]),
}

/// The map at equidistant places, each the colour of its place: looking it up costs less than mixing.
pub(super) static MAP: LazyLock<[Rgb; MAP_STEPS + 1]> =
    LazyLock::new(|| std::array::from_fn(|i| viridis(i as f64 / MAP_STEPS as f64)));

pub(super) const MAP_STEPS: usize = 1024;

impl Paint<'_> {
    /// The place of a vertex on the map, in 0..1; NaN without a number.
    pub(super) fn place(&self, node: usize) -> f64 {
        match self {
            // An infinite value has no colour either, and must not become that of the end of the map.
            Paint::Scalar { values, range: [low, high] } if values[node].is_finite() => {
                (values[node] - low) / (high - low)
            }
            _ => f64::NAN,
        }
    }

    /// The colour of a vertex.
    pub(super) fn vertex(&self, node: usize) -> Rgb {
        match self {
            Paint::Scalar { .. } => viridis(self.place(node)),
            Paint::Status(status) => STATUS.get(usize::from(status[node])).map_or(OUTSIDE.1, |s| s.1),
        }
    }
}

/// The range of the finite values, from zero if they have one sign; never empty.
pub(super) fn range_of(values: &[f64]) -> [f64; 2] {
    let finite = values.iter().copied().filter(|v| v.is_finite());
    let [low, high] = finite.fold([0.0f64, 0.0f64], |[low, high], v| [low.min(v), high.max(v)]);
    if !(high - low).is_finite() {
        return [low / 4.0, high / 4.0];
    }
    // The map of zeros is the map's low end, not a division by zero.
    if high > low { [low, high] } else { [0.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_start_at_zero_and_skip_what_is_no_number() {
        assert_eq!(range_of(&[2.0, f64::NAN, 5.0, f64::INFINITY]), [0.0, 5.0]);
        assert_eq!(range_of(&[-2.0, 5.0]), [-2.0, 5.0]);
        assert_eq!(range_of(&[-3.0]), [-3.0, 0.0]);
        assert_eq!((range_of(&[]), range_of(&[0.0, 0.0])), ([0.0, 1.0], [0.0, 1.0]));
        let [low, high] = range_of(&[-f64::MAX, f64::MAX]);
        assert!((high - low).is_finite());
    }
}
