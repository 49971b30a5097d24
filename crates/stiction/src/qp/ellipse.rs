/// Ratio of the semi-axes below which the shorter one is taken for zero: its square would underflow.
const DEGENERATE: f64 = 1e-150;
/// Newton steps on the secular equation; ten are rarely needed.
const MAX_STEPS: usize = 60;

/// The point of the ellipse `(x/a)^2 + (y/b)^2 <= 1` nearest to `[x, y]`; `a` and `b` in `[0, inf]`.
///
/// Outside, it is `(a^2 x / (a^2 + t), b^2 y / (b^2 + t))` with the root `t > 0` of the secular equation
/// `|(a x / (a^2 + t), b y / (b^2 + t))| = 1`. Newton's method is applied to the inverse of the left side, which is
/// concave and nearly linear in `t`, so that it climbs to the root from below (Moré & Sorensen 1983, SIAM J. Sci.
/// Stat. Comput. 4, use this for trust regions); bounds on the root guard against rounding.
pub(super) fn nearest_in_ellipse([a, b]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    let largest = a.max(b);
    if a.min(b) <= DEGENERATE * largest || !largest.is_finite() {
        // A point, a segment or a strip: the axes do not see each other.
        return [x.max(-a).min(a), y.max(-b).min(b)];
    }
    // In units of the longer axis, so that no square overflows.
    let (p, q) = ([a / largest, b / largest], [x / largest, y / largest]);
    let c = [p[0] * q[0], p[1] * q[1]];
    let level = |t: f64| (c[0] / (p[0] * p[0] + t)).hypot(c[1] / (p[1] * p[1] + t));
    if level(0.0) <= 1.0 {
        return [x, y];
    }
    let p2 = [p[0] * p[0], p[1] * p[1]];
    let mut lower = (c[0].abs() - p2[0]).max(c[1].abs() - p2[1]).max(0.0);
    let mut upper = c[0].hypot(c[1]);
    let mut t = lower;
    for _ in 0..MAX_STEPS {
        let value = level(t);
        if value > 1.0 {
            lower = t
        } else {
            upper = t
        }
        let weights = [c[0] / (p2[0] + t), c[1] / (p2[1] + t)];
        let slope = (weights[0] * weights[0] / (p2[0] + t) + weights[1] * weights[1] / (p2[1] + t)) / value;
        let mut next = t + value * (value - 1.0) / slope;
        if !(next >= lower && next <= upper) {
            next = 0.5 * (lower + upper);
        }
        if (next - t).abs() <= 2.0 * f64::EPSILON * next {
            break;
        }
        t = next;
    }
    let nearest = [x * (p2[0] / (p2[0] + t)), y * (p2[1] / (p2[1] + t))];
    // Rounding in `t` must not leave the point outside.
    let scale = (nearest[0] / a).hypot(nearest[1] / b).max(1.0);
    [nearest[0] / scale, nearest[1] / scale]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squared distance from `[x, y]` to the nearest of many points of the boundary.
    fn sampled([a, b]: [f64; 2], [x, y]: [f64; 2]) -> f64 {
        let points = (0..200_000).map(|k| (k as f64 * std::f64::consts::TAU / 200_000.0).sin_cos());
        points.map(|(s, c)| (a * c - x).hypot(b * s - y)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn nothing_on_the_boundary_is_nearer_and_projecting_again_changes_nothing() {
        for radii in [[1.0, 1.0], [3.0, 1.0], [0.02, 5.0], [1e6, 2e6]] {
            for k in 0..40 {
                let (s, c) = (0.3 + k as f64).sin_cos();
                let far = 1.2 + 3.0 * ((k * k) as f64).sin().abs();
                let point = [far * radii[0] * c, far * radii[1] * s];
                let near = nearest_in_ellipse(radii, point);
                let level = (near[0] / radii[0]).hypot(near[1] / radii[1]);
                assert!((level - 1.0).abs() < 1e-14, "{radii:?} {point:?} {level}");
                let distance = (near[0] - point[0]).hypot(near[1] - point[1]);
                let best = sampled(radii, point);
                assert!(distance <= best + 1e-14 * radii[0].max(radii[1]), "{distance} {best}");
                assert!(best - distance < 1e-6 * radii[0].max(radii[1]));
                let again = nearest_in_ellipse(radii, near);
                let moved = (again[0] - near[0]).hypot(again[1] - near[1]);
                assert!(moved <= 4e-16 * radii[0].max(radii[1]), "{moved}");
            }
        }
    }

    #[test]
    fn the_way_to_the_point_is_along_the_normal() {
        for (radii, point) in [([2.0, 0.3], [1.0, 4.0]), ([1e-9, 1.0], [1.0, 1e-12]), ([1.0, 1e-7], [1e5, 1e5])] {
            let [x, y] = nearest_in_ellipse(radii, point);
            let normal = [x / (radii[0] * radii[0]), y / (radii[1] * radii[1])];
            let way = [point[0] - x, point[1] - y];
            let turn = (normal[0] * way[1] - normal[1] * way[0]) / (normal[0].hypot(normal[1]) * way[0].hypot(way[1]));
            assert!(turn.abs() < 1e-8, "{radii:?} {point:?}: {x} {y} {turn}");
            assert!(normal[0] * way[0] + normal[1] * way[1] > 0.0);
        }
    }

    #[test]
    fn degenerate_axes_leave_a_point_a_segment_or_a_strip() {
        assert_eq!(nearest_in_ellipse([0.0, 0.0], [3.0, -4.0]), [0.0, 0.0]);
        assert_eq!(nearest_in_ellipse([0.0, 2.0], [3.0, -4.0]), [0.0, -2.0]);
        assert_eq!(nearest_in_ellipse([2.0, 0.0], [1.0, -4.0]), [1.0, 0.0]);
        assert_eq!(nearest_in_ellipse([2.0, f64::INFINITY], [3.0, -4.0]), [2.0, -4.0]);
        assert_eq!(nearest_in_ellipse([1.0, 2.0], [0.5, -1.0]), [0.5, -1.0]);
        assert_eq!(nearest_in_ellipse([1.0, 2.0], [0.0, -7.0]), [0.0, -2.0]);
    }
}
