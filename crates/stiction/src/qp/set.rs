/// The admissible set of one triple `(x_0, x_1, x_2)` of a vector of length `3m`, stored as
/// `[all x_0; all x_1; all x_2]`. The set of a problem is the product over its triples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PointSet {
    /// `x_0 >= 0` and `|(x_1, x_2)| <= radius`.
    HalfLineAndDisc {
        /// Radius of the disc.
        radius: f64,
    },
    /// No constraint.
    Free,
}

impl PointSet {
    /// The radius of the disc of the pair.
    pub(super) fn radius(&self) -> f64 {
        match *self {
            PointSet::HalfLineAndDisc { radius } => radius,
            PointSet::Free => f64::INFINITY,
        }
    }

    /// Whether the radius is a number that is not negative.
    pub fn is_valid(&self) -> bool {
        self.radius() >= 0.0
    }
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
}
