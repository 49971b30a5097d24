//! Bounds on rotated copies of one vector, held together by a penalty: `A = blkdiag(M_i Q M_i') / N + rho C'C`.

use super::super::*;
use super::*;
use crate::linalg::norm;

/// `copies` vectors of `points` triples; copy `i` sees its pairs turned by `i pi / (2 copies)`.
pub(super) struct Copies {
    pub q: Dense,
    pub points: usize,
    pub copies: usize,
    pub penalty: f64,
}

impl Copies {
    fn turn(&self, copy: usize, sign: f64, x: &[f64]) -> Vec<f64> {
        let m = self.points;
        let (s, c) = (sign * copy as f64 * std::f64::consts::FRAC_PI_2 / self.copies as f64).sin_cos();
        let mut y = x.to_vec();
        for j in 0..m {
            y[m + j] = c * x[m + j] + s * x[2 * m + j];
            y[2 * m + j] = c * x[2 * m + j] - s * x[m + j];
        }
        y
    }

    /// Every copy, turned back.
    fn common(&self, x: &[f64]) -> Vec<Vec<f64>> {
        x.chunks(3 * self.points).enumerate().map(|(i, x)| self.turn(i, -1.0, x)).collect()
    }

    /// Differences of neighbouring copies.
    pub(super) fn differences(&self, x: &[f64]) -> Vec<Vec<f64>> {
        self.common(x).windows(2).map(|w| w[0].iter().zip(&w[1]).map(|(a, b)| a - b).collect()).collect()
    }

    pub(super) fn times(&self, x: &[f64]) -> Vec<f64> {
        let common = self.common(x);
        let mut images: Vec<Vec<f64>> =
            common.iter().map(|l| self.q.times(l).iter().map(|v| v / self.copies as f64).collect()).collect();
        for (i, d) in self.differences(x).iter().enumerate() {
            for (k, d) in d.iter().enumerate() {
                images[i][k] += self.penalty * d;
                images[i + 1][k] -= self.penalty * d;
            }
        }
        images.iter().enumerate().flat_map(|(i, l)| self.turn(i, 1.0, l)).collect()
    }

    pub(super) fn right_hand_side(&self, h: &[f64]) -> Vec<f64> {
        (0..self.copies)
            .flat_map(|i| self.turn(i, 1.0, h).iter().map(|h| h / self.copies as f64).collect::<Vec<_>>())
            .collect()
    }

    pub(super) fn bounds(&self, radius: f64) -> Bounds {
        let m = self.points;
        let one = |free: f64, normal: f64| -> Vec<f64> {
            (0..3 * m * self.copies).map(|k| if k % (3 * m) < m { normal } else { free }).collect()
        };
        Bounds { lower: one(-radius, 0.0), upper: one(radius, f64::INFINITY) }
    }
}

/// Gaussian elimination without pivoting, for small positive definite systems.
fn solve_small(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let (pivot, below) = (a[k].clone(), k + 1..n);
        for i in below {
            let factor = a[i][k] / pivot[k];
            a[i].iter_mut().zip(&pivot).for_each(|(a, p)| *a -= factor * p);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = a[k][k + 1..].iter().zip(&b[k + 1..]).map(|(a, b)| a * b).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}

/// Solves with the penalised copies and the inverse of the blocks of single triples on the face. Returns also the
/// projected gradient and the level at which products with the penalty round, both relative to the right-hand side.
fn solved(points: usize, copies: usize, penalty: f64, method: &MprgpSettings) -> ([f64; 2], QpSolution) {
    let mut numbers = Numbers::new(5);
    let spectrum = spread(3 * points, 1e-3, 1.0);
    let mean = spectrum.iter().sum::<f64>() / spectrum.len() as f64;
    let q = Dense::with_spectrum(&spectrum, &mut numbers);
    let h = numbers.vector(3 * points);
    let p = Copies { q, points, copies, penalty };
    let b = p.right_hand_side(&h);
    let diagonal = Dense((0..3).map(|i| (0..3).map(|j| if i == j { mean } else { 0.0 }).collect()).collect());
    let one = Copies { q: diagonal, points: 1, copies, penalty };
    let unit = |i: usize| -> Vec<f64> { (0..3 * copies).map(|j| f64::from(u8::from(i == j))).collect() };
    let block: Vec<Vec<f64>> = (0..3 * copies).map(|i| one.times(&unit(i))).collect();
    let apply = |r: &[f64], free: &[bool]| -> Vec<f64> {
        let mut z = vec![0.0; r.len()];
        for j in 0..points {
            let at = |k: usize| (k / 3) * 3 * points + (k % 3) * points + j;
            let f: Vec<usize> = (0..3 * copies).filter(|k| free[at(*k)]).collect();
            let a = f.iter().map(|i| f.iter().map(|j| block[*i][*j]).collect()).collect();
            let y = solve_small(a, f.iter().map(|i| r[at(*i)]).collect());
            f.iter().zip(y).for_each(|(k, y)| z[at(*k)] = y);
        }
        z
    };
    let mut operator = |x: &[f64]| p.times(x);
    let bounds = p.bounds(1.0);
    let problem = Program { operator: &mut operator, b: &b, largest_eigenvalue: None, preconditioner: Some(&apply) };
    let s = minimize_in_bounds(problem, &bounds, &vec![0.0; b.len()], method, 1e-8 * norm(&b), 5000, &mut |_, _| false);
    let apart = p.differences(&s.x).iter().map(|d| norm(d)).fold(0.0, f64::max);
    assert!(apart * penalty < 10.0 * norm(&b), "the copies are {apart} apart");
    let rounding = f64::EPSILON * 4.0 * penalty * norm(&s.x);
    ([s.measure / norm(&b), rounding / norm(&b)], s)
}

#[test]
fn with_its_blocks_on_the_face_a_penalty_may_be_a_million_times_the_rest() {
    for copies in [2, 4] {
        for method in variants() {
            for power in [-2, 0, 2, 4, 6] {
                let ([residual, rounding], s) = solved(20, copies, 10f64.powi(power), &method);
                let reached = s.status == QpStatus::Solved || residual < rounding;
                assert!(reached, "{copies} {power} {method:?} {residual} {:?}", s.counts);
                assert!(s.counts.products < 1500, "{copies} {power} {method:?} {:?}", s.counts);
            }
        }
    }
}

#[test]
fn beyond_that_rounding_is_named_as_what_ends_it() {
    for copies in [2, 4] {
        for method in variants() {
            let ([residual, rounding], s) = solved(20, copies, 1e9, &method);
            assert_eq!(s.status, QpStatus::Stalled, "{copies} {method:?} {residual} {:?}", s.counts);
            assert!(residual < rounding, "{copies} {method:?} {residual} {:?}", s.counts);
        }
    }
}
