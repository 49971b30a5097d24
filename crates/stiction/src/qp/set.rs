use super::ellipse::nearest_in_ellipse;

/// The admissible set of one triple `(x_0, x_1, x_2)` of a vector of length `3m`, stored as
/// `[all x_0; all x_1; all x_2]`. The set of a problem is the product over its triples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PointSet {
    /// `x_0 >= 0` and `|(x_1, x_2)| <= radius`.
    HalfLineAndDisc { radius: f64 },
    /// `x_0 >= 0` and `(x_1, x_2)` in the ellipse with the semi-axes `radii`, the first of them `angle` (radian) from
    /// the direction of `x_1` towards that of `x_2`. A zero leaves a segment or the origin, an infinity a strip.
    HalfLineAndEllipse { radii: [f64; 2], angle: f64 },
    /// No constraint.
    Free,
}

impl PointSet {
    /// The semi-axes of the pair's set and the direction (cosine and sine) of the first.
    pub(super) fn axes(&self) -> ([f64; 2], [f64; 2]) {
        match *self {
            PointSet::HalfLineAndDisc { radius } => ([radius; 2], [1.0, 0.0]),
            PointSet::HalfLineAndEllipse { radii, angle } => (radii, [angle.cos(), angle.sin()]),
            PointSet::Free => ([f64::INFINITY; 2], [1.0, 0.0]),
        }
    }

    /// Whether every radius is a number that is not negative and the angle is finite.
    pub fn is_valid(&self) -> bool {
        match *self {
            PointSet::HalfLineAndDisc { radius } => radius >= 0.0,
            PointSet::HalfLineAndEllipse { radii, angle } => radii.iter().all(|r| *r >= 0.0) && angle.is_finite(),
            PointSet::Free => true,
        }
    }
}

/// Components of `pair` along the first axis `(c, s)` and across it.
pub(super) fn into_axes([c, s]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [c * x + s * y, c * y - s * x]
}

/// The inverse of [`into_axes`].
pub(super) fn out_of_axes([c, s]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [c * x - s * y, c * y + s * x]
}

/// Euclidean projection of `x` (length `3m`) onto the product of `sets` (length `m`), in place.
pub fn project(sets: &[PointSet], x: &mut [f64]) {
    let m = sets.len();
    for (j, set) in sets.iter().enumerate() {
        match *set {
            PointSet::HalfLineAndDisc { radius } => {
                x[j] = x[j].max(0.0);
                let length = x[m + j].hypot(x[2 * m + j]);
                if length > radius {
                    let shrink = radius / length;
                    x[m + j] *= shrink;
                    x[2 * m + j] *= shrink;
                }
            }
            PointSet::HalfLineAndEllipse { radii, .. } => {
                x[j] = x[j].max(0.0);
                let (_, first) = set.axes();
                let pair = into_axes(first, [x[m + j], x[2 * m + j]]);
                [x[m + j], x[2 * m + j]] = out_of_axes(first, nearest_in_ellipse(radii, pair));
            }
            PointSet::Free => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projecting_twice_is_projecting_once_and_nothing_is_nearer() {
        let sets = [PointSet::HalfLineAndDisc { radius: 2.0 }, PointSet::Free];
        let start = [-1.0, -5.0, 3.0, 7.0, 4.0, 9.0];
        let mut x = start;
        project(&sets, &mut x);
        let mut twice = x;
        project(&sets, &mut twice);
        assert!(x.iter().zip(twice).all(|(a, b)| (a - b).abs() < 1e-15));
        assert_eq!((x[0], x[1], x[3], x[5]), (0.0, -5.0, 7.0, 9.0));
        // The disc point lies on the ray to the start: (3, 4) shrinks to length 2.
        assert!((x[2] - 1.2).abs() < 1e-15 && (x[4] - 1.6).abs() < 1e-15);
    }

    #[test]
    fn a_turned_ellipse_is_the_ellipse_in_turned_coordinates() {
        let (radii, angle) = ([3.0, 0.5], 0.7f64);
        let mut turned = [-1.0, 2.0, 1.5];
        project(&[PointSet::HalfLineAndEllipse { radii, angle }], &mut turned);
        let (s, c) = angle.sin_cos();
        let mut straight = [-1.0, c * 2.0 + s * 1.5, -s * 2.0 + c * 1.5];
        project(&[PointSet::HalfLineAndEllipse { radii, angle: 0.0 }], &mut straight);
        assert!(turned[0] == 0.0 && (turned[1] - (c * straight[1] - s * straight[2])).abs() < 1e-15);
        assert!((turned[2] - (s * straight[1] + c * straight[2])).abs() < 1e-15);
    }
}
