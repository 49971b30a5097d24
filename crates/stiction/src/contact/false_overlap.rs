//! Weighted gaps of surfaces that do not overlap.
//!
//! Dual functions are negative in places: of surfaces that curve away from one another the weighted gap is less than any gap there. Where
//! they touch in the middle of an edge between quadratic faces, or between two nodes of a linear face, it is `-h²/(12 R)`, with the length
//! `h` of the edge and the relative radius `R`: they would repel one another before they touch. Where a face sees an edge of the other body it
//! may be less by the size of the face: bodies that are apart would press one another.
//!
//! In a contact wider than `h` the weighted gap is the right one, and such a node, at the middle, is left a little behind: of a ring of hexahedra
//! with 20 nodes pressed on a block (`tests/physics/touching.rs`) the largest pressure is 2 % less where the contact is five faces wide, 0.3 % where
//! it is ten. To widen all gaps around by as much keeps the curvature, but takes 12 to 20 % of the force from a contact as wide as a face.

/// An overlap of the meshes takes so many times itself from what a gap is widened by: where it is about as large as what the dual functions
/// add, as on facets of a shaft in its hub, gaps are the means that they are.
const REAL: f64 = 2.0;

/// The weighted gap without an overlap that the surfaces do not have, and no less than the distance where they have none; `least` is the
/// least distance where its function does not vanish, times the sum of the weights. Both are lengths, negative where surfaces overlap.
pub(super) fn without_false_overlap(gap: f64, least: f64) -> f64 {
    gap.max(if least > 0.0 { least } else { REAL * least })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The weighted gap at the middle of an edge, and the least distance, where a parabola touches there or overlaps.
    fn parabola(h: f64, radius: f64, overlap: f64) -> [f64; 2] {
        let at_ends = h * h / (8.0 * radius) - overlap;
        [(-overlap - 0.2 * (at_ends + at_ends)) / 0.6, -overlap]
    }

    #[test]
    fn surfaces_that_touch_have_no_weighted_overlap_and_those_that_overlap_keep_theirs() {
        let (h, radius) = (1.0, 20.0);
        let [touching, _] = parabola(h, radius, 0.0);
        let added = h * h / (12.0 * radius);
        assert!((touching + added).abs() < 1e-15, "{touching}");
        let found = [0.0, 0.2, 0.5, 0.9].map(|part| {
            let [gap, least] = parabola(h, radius, part * added);
            without_false_overlap(gap, least)
        });
        assert!(found[0] == 0.0 && found.is_sorted_by(|a, b| a > b), "{found:?}");
        let [gap, least] = parabola(h, radius, 1.1 * added);
        assert_eq!(without_false_overlap(gap, least), gap);
        assert_eq!(without_false_overlap(0.3, 0.1), 0.3);
        // Apart by a distance they are as they were where they touched.
        let [apart, least] = parabola(h, radius, -0.3);
        assert!(apart < 0.3 && without_false_overlap(apart, least) == 0.3);
    }
}
