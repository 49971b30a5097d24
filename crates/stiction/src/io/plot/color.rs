//! Colours: one perceptually uniform map for numbers, one palette for the state of a contact point.

use std::sync::LazyLock;

pub(super) type Rgb = [u8; 3];

pub(super) const INK: Rgb = [34, 34, 34];
pub(super) const GRID: Rgb = [225, 225, 225];
/// Where there is no number.
pub(super) const MISSING: Rgb = [200, 200, 200];

/// Viridis (S. van der Walt, N. Smith, CC0), at 33 equidistant places.
#[rustfmt::skip]
const VIRIDIS: [Rgb; 33] = [
    [68, 1, 84], [71, 13, 96], [72, 24, 106], [72, 35, 116], [71, 45, 123], [69, 55, 129], [66, 64, 134],
    [62, 73, 137], [59, 82, 139], [55, 91, 141], [51, 99, 141], [47, 107, 142], [44, 114, 142], [41, 122, 142],
    [38, 130, 142], [35, 137, 142], [33, 145, 140], [31, 152, 139], [31, 160, 136], [34, 167, 133], [40, 174, 128],
    [50, 182, 122], [63, 188, 115], [78, 195, 107], [94, 201, 98], [112, 207, 87], [132, 212, 75], [152, 216, 62],
    [173, 220, 48], [194, 223, 35], [216, 226, 25], [236, 229, 27], [253, 231, 37],
];

/// The colour of `t` in 0..1; what lies outside takes the colour of the nearer end.
pub(super) fn viridis(t: f64) -> Rgb {
    if t.is_nan() {
        return MISSING;
    }
    let at = t.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let i = (at as usize).min(VIRIDIS.len() - 2);
    mix(VIRIDIS[i], VIRIDIS[i + 1], at - i as f64)
}

/// Open, stick and slip: distinct to colour-blind readers and in print (Okabe and Ito).
pub(super) const STATUS: [(&str, Rgb); 3] =
    [("open", [222, 222, 222]), ("stick", [0, 114, 178]), ("slip", [230, 159, 0])];

/// Vertices in none of these states, such as nodes of a contact surface that are held.
pub(super) const OUTSIDE: (&str, Rgb) = ("held", [140, 120, 140]);

/// `a` at `t = 0`, `b` at `t = 1`.
pub(super) fn mix(a: Rgb, b: Rgb, t: f64) -> Rgb {
    // Rounded by hand: this runs for every sub-pixel, and the conversion cuts off.
    std::array::from_fn(|c| (f64::from(a[c]) + t * (f64::from(b[c]) - f64::from(a[c])) + 0.5) as u8)
}

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
    fn the_map_runs_from_dark_violet_to_yellow_and_grows_lighter() {
        assert_eq!(viridis(0.0), [68, 1, 84]);
        assert_eq!(viridis(1.0), [253, 231, 37]);
        assert_eq!((viridis(-3.0), viridis(f64::INFINITY)), (viridis(0.0), viridis(1.0)));
        assert_eq!(viridis(f64::NAN), MISSING);
        // Rec. 709 luma; uniform lightness is what the map is chosen for.
        let luma = |c: Rgb| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]);
        let steps: Vec<f64> = (0..=64).map(|i| luma(viridis(f64::from(i) / 64.0))).collect();
        assert!(steps.windows(2).all(|w| w[1] > w[0]));
    }

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
