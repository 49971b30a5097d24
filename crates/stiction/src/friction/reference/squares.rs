use serde::{Deserialize, Serialize};

use crate::contact::Friction;
use crate::qp::Bounds;

/// The disc of friction as the intersection of `count` squares turned by `alpha_i = (i - 1) pi / (2 count)`: a regular
/// polygon of `4 count` sides around it (Haslinger, Kucera & Dostal 2004, section 4). Copy `i` of the multipliers is
/// stored in the axes of square `i`, where its set is a box.
#[derive(Debug, Clone)]
pub(super) struct Squares {
    pub count: usize,
    /// Cosine and sine of `alpha_i`.
    turns: Vec<[f64; 2]>,
    /// Points whose disc is cut into squares: those with friction that can slip in two directions; `m`.
    round: Vec<bool>,
}

/// Which copies of the multipliers are constrained to be equal; both give `count - 1` times `3m` rows and the same for two
/// squares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Coupling {
    /// `lambda_i - lambda_(i+1) = 0`, as printed in the source paper.
    Chain,
    /// `lambda_1 - lambda_i = 0`: the copies agree within fewer steps.
    #[default]
    Star,
}

impl Squares {
    /// `has_row` is false for an empty row of `B`, `3m`; `count` is at least one.
    pub(super) fn new(count: usize, friction: &[Friction], has_row: &[bool]) -> Self {
        let m = friction.len();
        let alpha = |i: usize| std::f64::consts::FRAC_PI_2 * i as f64 / count as f64;
        let rubs = |j: usize| !matches!(friction[j], Friction::None | Friction::Bonded);
        Squares {
            count,
            turns: (0..count).map(|i| [alpha(i).cos(), alpha(i).sin()]).collect(),
            // A point that slips in one direction has a segment for a disc, which the first square bounds.
            round: (0..m).map(|j| rubs(j) && has_row[m + j] && has_row[2 * m + j]).collect(),
        }
    }

    /// `M_i lambda`, in place: from the axes of the problem to those of square `i`.
    pub(super) fn turn(&self, i: usize, lambda: &mut [f64]) {
        let [c, s] = self.turns[i];
        self.apply(c, s, lambda);
    }

    /// `M_iᵀ mu`, in place.
    pub(super) fn turn_back(&self, i: usize, mu: &mut [f64]) {
        let [c, s] = self.turns[i];
        self.apply(c, -s, mu);
    }

    /// Whether no point has a disc that the squares stand in for.
    pub(super) fn cuts_no_disc(&self) -> bool {
        !self.round.contains(&true)
    }

    /// The three rows of `M_i` at point `j`, in the order normal, first, second tangential.
    pub(super) fn rotation(&self, i: usize, j: usize) -> [[f64; 3]; 3] {
        let [c, s] = if self.round[j] { self.turns[i] } else { [1.0, 0.0] };
        [[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]
    }

    fn apply(&self, c: f64, s: f64, x: &mut [f64]) {
        let m = self.round.len();
        let (first, second) = x[m..].split_at_mut(m);
        for ((a, b), _) in first.iter_mut().zip(second).zip(&self.round).filter(|(_, round)| **round) {
            (*a, *b) = (c * *a + s * *b, c * *b - s * *a);
        }
    }

    /// Every copy in the axes of the problem.
    pub(super) fn in_common_axes(&self, copies: &[f64]) -> Vec<f64> {
        let mut common = copies.to_vec();
        let size = 3 * self.round.len().max(1);
        common.chunks_exact_mut(size).enumerate().for_each(|(i, copy)| self.turn_back(i, copy));
        common
    }

    /// Every copy in the axes of its square.
    pub(super) fn in_own_axes(&self, common: &[f64]) -> Vec<f64> {
        let mut copies = common.to_vec();
        let size = 3 * self.round.len().max(1);
        copies.chunks_exact_mut(size).enumerate().for_each(|(i, copy)| self.turn(i, copy));
        copies
    }

    /// The mean of the copies, in the axes of the problem.
    pub(super) fn mean(&self, copies: &[f64]) -> Vec<f64> {
        let size = 3 * self.round.len();
        let mut mean = vec![0.0; size];
        for copy in self.in_common_axes(copies).chunks_exact(size.max(1)) {
            crate::linalg::axpy(1.0 / self.count as f64, copy, &mut mean);
        }
        mean
    }
}

impl Coupling {
    /// The number of the copies a row compares, first those with plus.
    fn pairs(self, count: usize) -> impl Iterator<Item = (usize, usize)> {
        (1..count).map(move |i| match self {
            Coupling::Chain => (i - 1, i),
            Coupling::Star => (0, i),
        })
    }

    /// `C lambda` of `count` copies in common axes, each of length `size`.
    pub fn differences(self, count: usize, size: usize, copies: &[f64]) -> Vec<f64> {
        let copy = |i: usize| &copies[i * size..(i + 1) * size];
        self.pairs(count).flat_map(|(a, b)| copy(a).iter().zip(copy(b)).map(|(a, b)| a - b)).collect()
    }

    /// `Cᵀ w`, `count` copies in common axes.
    pub fn transpose(self, count: usize, size: usize, w: &[f64]) -> Vec<f64> {
        let mut copies = vec![0.0; count * size];
        for ((a, b), w) in self.pairs(count).zip(w.chunks_exact(size.max(1))) {
            crate::linalg::axpy(1.0, w, &mut copies[a * size..(a + 1) * size]);
            crate::linalg::axpy(-1.0, w, &mut copies[b * size..(b + 1) * size]);
        }
        copies
    }

    /// Entry of `CᵀC` between copies `i` and `k`, times the unit matrix.
    pub fn entry(self, count: usize, i: usize, k: usize) -> f64 {
        let touches = |p: (usize, usize), i: usize| f64::from(u8::from(p.0 == i)) - f64::from(u8::from(p.1 == i));
        self.pairs(count).map(|pair| touches(pair, i) * touches(pair, k)).sum()
    }

    /// Largest eigenvalue of `CᵀC`: that of the graph of the coupling.
    pub fn largest(self, count: usize) -> f64 {
        match self {
            _ if count < 2 => 0.0,
            Coupling::Chain => 2.0 + 2.0 * (std::f64::consts::PI / count as f64).cos(),
            Coupling::Star => count as f64,
        }
    }
}

/// The box of one copy: what the multipliers may be where the friction at point `j` is at most `slip_bound[j]`.
pub(super) fn boxes(friction: &[Friction], has_row: &[bool], slip_bound: &[f64]) -> Bounds {
    let m = friction.len();
    let (mut lower, mut upper) = (vec![0.0; 3 * m], vec![0.0; 3 * m]);
    for j in 0..m {
        let (normal, tangential) = match friction[j] {
            Friction::Bonded => (f64::NEG_INFINITY, f64::INFINITY),
            Friction::None => (0.0, 0.0),
            Friction::Given { .. }
            | Friction::Coulomb { .. }
            | Friction::Limited { .. }
            | Friction::Cohesive { .. } => (0.0, slip_bound[j]),
        };
        let limits = [(normal, f64::INFINITY), (-tangential, tangential), (-tangential, tangential)];
        for (i, (low, high)) in [j, m + j, 2 * m + j].into_iter().zip(limits).filter(|(i, _)| has_row[*i]) {
            (lower[i], upper[i]) = (low, high);
        }
    }
    Bounds { lower, upper }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dot;

    /// Corners of the polygon that `count` squares cut out around a disc of the given radius, counter-clockwise.
    fn polygon(count: usize, radius: f64) -> Vec<[f64; 2]> {
        let half = std::f64::consts::FRAC_PI_4 / count as f64;
        let corner = |k: usize| {
            let (s, c) = ((2 * k + 1) as f64 * half).sin_cos();
            [radius / half.cos() * c, radius / half.cos() * s]
        };
        (0..4 * count).map(corner).collect()
    }

    fn numbers(n: usize) -> Vec<f64> {
        (0..n).map(|i| (1.0 + i as f64 * 1.7).sin()).collect()
    }

    #[test]
    fn a_point_is_in_all_squares_exactly_if_it_is_in_their_polygon() {
        let laws = [Friction::Given { slip_bound: 2.0 }];
        for count in [1, 2, 3, 6] {
            let squares = Squares::new(count, &laws, &[true; 3]);
            let corners = polygon(count, 2.0);
            assert_eq!(corners.len(), 4 * count);
            let largest = |x: [f64; 2]| {
                let over = |i: usize| {
                    let mut lambda = [0.0, x[0], x[1]];
                    squares.turn(i, &mut lambda);
                    lambda[1].abs().max(lambda[2].abs())
                };
                (0..count).map(over).fold(0.0, f64::max)
            };
            for (k, corner) in corners.iter().enumerate() {
                // A corner lies sec(pi / 4N) beyond the disc, on two sides; the middle of a side touches the disc.
                let beyond = 2.0 / (std::f64::consts::FRAC_PI_4 / count as f64).cos();
                assert!((corner[0].hypot(corner[1]) - beyond).abs() < 1e-14);
                assert!((largest(*corner) - 2.0).abs() < 1e-14);
                let next = corners[(k + 1) % corners.len()];
                let middle = [0.5 * (corner[0] + next[0]), 0.5 * (corner[1] + next[1])];
                assert!((middle[0].hypot(middle[1]) - 2.0).abs() < 1e-14 && (largest(middle) - 2.0).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn points_that_slip_in_one_direction_or_not_at_all_are_not_turned() {
        let given = Friction::Given { slip_bound: 1.0 };
        let laws = [given, given, Friction::Bonded, Friction::None, given];
        let mut has_row = [true; 15];
        (has_row[6], has_row[11]) = (false, false);
        let squares = Squares::new(3, &laws, &has_row);
        let mut x = numbers(15);
        let before = x.clone();
        squares.turn(1, &mut x);
        let moved: Vec<usize> = (0..15).filter(|&i| x[i] != before[i]).collect();
        assert_eq!(moved, [5, 9, 10, 14]);
        squares.turn_back(1, &mut x);
        assert!(x.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-15));
        let bounds = boxes(&laws, &has_row, &[1.0; 5]);
        assert_eq!((bounds.lower[6], bounds.upper[6]), (0.0, 0.0));
        assert_eq!((bounds.lower[2], bounds.upper[12]), (f64::NEG_INFINITY, f64::INFINITY));
        assert_eq!((bounds.upper[8], bounds.upper[3], bounds.lower[5]), (0.0, f64::INFINITY, -1.0));
    }

    #[test]
    fn differences_and_their_transpose_are_adjoint_and_as_large_as_their_bound_says() {
        for coupling in [Coupling::Chain, Coupling::Star] {
            for count in 1..7 {
                let (x, w) = (numbers(6 * count), numbers(6 * (count - 1)));
                let (cx, cw) = (coupling.differences(count, 6, &x), coupling.transpose(count, 6, &w));
                assert!((dot(&cx, &w) - dot(&x, &cw)).abs() < 1e-13);
                let equal = numbers(6).repeat(count);
                assert!(coupling.differences(count, 6, &equal).iter().all(|&d| d == 0.0));
                // The largest eigenvalue by power steps on C'C, and its entries from unit vectors.
                let mut v: Vec<f64> = numbers(count);
                let square = |v: &[f64]| coupling.transpose(count, 1, &coupling.differences(count, 1, v));
                for _ in 0..2000 {
                    let next = square(&v);
                    let size = dot(&next, &next).sqrt().max(f64::MIN_POSITIVE);
                    v = next.iter().map(|x| x / size).collect();
                }
                let value = dot(&v, &square(&v)) / dot(&v, &v).max(f64::MIN_POSITIVE);
                assert!((value - coupling.largest(count)).abs() < 1e-6, "{coupling:?} {count}");
                for i in 0..count {
                    let unit: Vec<f64> = (0..count).map(|k| f64::from(u8::from(k == i))).collect();
                    for (k, entry) in square(&unit).into_iter().enumerate() {
                        assert_eq!(entry, coupling.entry(count, k, i));
                    }
                }
            }
        }
    }
}
