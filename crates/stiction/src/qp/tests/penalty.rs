//! Bounds on rotated copies of one vector, held together by a penalty: `A = blkdiag(M_i Q M_i') / N + rho C'C`.

use super::super::*;
use super::*;
use crate::linalg::norm;

/// `copies` vectors of `points` triples; copy `i` sees its pairs turned by `i pi / (2 copies)`.
pub struct Copies {
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
    pub fn differences(&self, x: &[f64]) -> Vec<Vec<f64>> {
        self.common(x).windows(2).map(|w| w[0].iter().zip(&w[1]).map(|(a, b)| a - b).collect()).collect()
    }

    pub fn times(&self, x: &[f64]) -> Vec<f64> {
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

    pub fn right_hand_side(&self, h: &[f64]) -> Vec<f64> {
        (0..self.copies)
            .flat_map(|i| self.turn(i, 1.0, h).iter().map(|h| h / self.copies as f64).collect::<Vec<_>>())
            .collect()
    }

    pub fn bounds(&self, radius: f64) -> Bounds {
        let m = self.points;
        let one = |free: f64, normal: f64| -> Vec<f64> {
            (0..3 * m * self.copies).map(|k| if k % (3 * m) < m { normal } else { free }).collect()
        };
        Bounds { lower: one(-radius, 0.0), upper: one(radius, f64::INFINITY) }
    }
}

#[test]
fn print_penalties() {
    for copies in [2, 4] {
        for method in methods() {
            println!("{copies} {method:?}");
            for power in [-2, -1, 0, 1, 2, 3, 5, 7, 9] {
                let mut numbers = Numbers::new(5);
                let points = 40;
                let q = Dense::with_spectrum(&spread(3 * points, 1e-3, 1.0), &mut numbers);
                let h = numbers.vector(3 * points);
                let p = Copies { q, points, copies, penalty: 10f64.powi(power) };
                let b = p.right_hand_side(&h);
                let mut operator = |x: &[f64]| p.times(x);
                let problem = BoundProblem {
                    operator: &mut operator,
                    b: &b,
                    bounds: &p.bounds(1.0),
                    largest_eigenvalue: None,
                    preconditioner: None,
                };
                let s =
                    minimize_in_bounds(problem, &vec![0.0; b.len()], &method, 1e-8 * norm(&b), 20_000, &mut |_, _| {
                        false
                    });
                println!("  {power} {:?} {:?} {:.1e}", s.status, s.counts, s.projected_gradient / norm(&b));
            }
        }
    }
}

fn solve_small(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        for i in k + 1..n {
            let f = a[i][k] / a[k][k];
            for j in k..n {
                let v = a[k][j];
                a[i][j] -= f * v;
            }
            b[i] -= f * b[k];
        }
    }
    for k in (0..n).rev() {
        for j in k + 1..n {
            b[k] -= a[k][j] * b[j];
        }
        b[k] /= a[k][k];
    }
    b
}

#[test]
fn print_preconditioned() {
    for copies in [2, 4] {
        for method in methods() {
            println!("P {copies} {method:?}");
            for power in [-2, -1, 0, 1, 2, 3, 5, 7, 9] {
                let mut numbers = Numbers::new(5);
                let points = 40;
                let q = Dense::with_spectrum(&spread(3 * points, 1e-3, 1.0), &mut numbers);
                let h = numbers.vector(3 * points);
                let p = Copies { q, points, copies, penalty: 10f64.powi(power) };
                let b = p.right_hand_side(&h);
                let local = Copies {
                    q: Dense((0..3).map(|i| (0..3).map(|j| if i == j { 0.145 } else { 0.0 }).collect()).collect()),
                    points: 1,
                    copies,
                    penalty: p.penalty,
                };
                let size = 3 * copies;
                let block: Vec<Vec<f64>> = (0..size)
                    .map(|i| {
                        let mut e = vec![0.0; size];
                        e[i] = 1.0;
                        local.times(&e)
                    })
                    .collect();
                let pre = |r: &[f64], free: &[bool]| -> Vec<f64> {
                    let mut z = vec![0.0; r.len()];
                    for j in 0..points {
                        let at = |k: usize| (k / 3) * 3 * points + (k % 3) * points + j;
                        let f: Vec<usize> = (0..size).filter(|k| free[at(*k)]).collect();
                        let a = f.iter().map(|i| f.iter().map(|j| block[*i][*j]).collect()).collect();
                        let y = solve_small(a, f.iter().map(|i| r[at(*i)]).collect());
                        for (k, y) in f.iter().zip(y) {
                            z[at(*k)] = y;
                        }
                    }
                    z
                };
                let mut operator = |x: &[f64]| p.times(x);
                let problem = BoundProblem {
                    operator: &mut operator,
                    b: &b,
                    bounds: &p.bounds(1.0),
                    largest_eigenvalue: None,
                    preconditioner: Some(&pre),
                };
                let s =
                    minimize_in_bounds(problem, &vec![0.0; b.len()], &method, 1e-8 * norm(&b), 20_000, &mut |_, _| {
                        false
                    });
                println!("  {power} {:?} {:?} {:.1e}", s.status, s.counts, s.projected_gradient / norm(&b));
            }
        }
    }
}
