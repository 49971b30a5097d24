//! Colours that pictures and the report share.

/// Red, green, blue.
pub(crate) type Rgb = [u8; 3];

/// Where there is no number.
pub(crate) const MISSING: Rgb = [200, 200, 200];

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
pub(crate) fn viridis(t: f64) -> Rgb {
    if t.is_nan() {
        return MISSING;
    }
    let at = t.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let i = (at as usize).min(VIRIDIS.len() - 2);
    mix(VIRIDIS[i], VIRIDIS[i + 1], at - i as f64)
}

/// Open, stick and slip: distinct to colour-blind readers and in print (Okabe and Ito).
pub(crate) const STATUS: [(&str, Rgb); 3] =
    [("open", [222, 222, 222]), ("stick", [0, 114, 178]), ("slip", [230, 159, 0])];

/// Vertices in none of these states, such as nodes of a contact surface that are held.
pub(crate) const OUTSIDE: (&str, Rgb) = ("held", [140, 120, 140]);

/// `a` at `t = 0`, `b` at `t = 1`.
fn mix(a: Rgb, b: Rgb, t: f64) -> Rgb {
    // Rounded by hand, as the conversion cuts off.
    std::array::from_fn(|c| (f64::from(a[c]) + t * (f64::from(b[c]) - f64::from(a[c])) + 0.5) as u8)
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
}
