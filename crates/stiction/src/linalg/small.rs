//! Dense matrices of a few rows, as rows of vectors.

/// Eigenvalues and orthonormal eigenvectors (one a row) of a symmetric matrix by cyclic Jacobi rotations (Golub & Van
/// Loan, sec. 8.5); in no particular order. Each is accurate to rounding of the largest entry.
pub fn symmetric_eigen(a: &[Vec<f64>]) -> (Vec<f64>, Vec<Vec<f64>>) {
    /// Sweeps reach rounding in less than ten.
    const SWEEPS: usize = 30;
    let n = a.len();
    let mut a = a.to_vec();
    let mut vectors: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    let largest = a.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                if a[p][q].abs() <= 1e-2 * f64::EPSILON * largest {
                    continue;
                }
                rotated = true;
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let (c, s) = (1.0 / t.hypot(1.0), t / t.hypot(1.0));
                a.iter_mut().for_each(|row| (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]));
                turn_rows(&mut a, p, q, c, s);
                turn_rows(&mut vectors, p, q, c, s);
            }
        }
        if !rotated {
            break;
        }
    }
    ((0..n).map(|i| a[i][i]).collect(), vectors)
}

fn turn_rows(a: &mut [Vec<f64>], p: usize, q: usize, c: f64, s: f64) {
    for k in 0..a[p].len() {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
    }
}

/// A square matrix factorised with partial pivoting; pivots below `1e-12` of the largest entry are replaced by that,
/// so that directions in which the matrix is singular are answered by large but finite numbers.
#[derive(Debug, Clone)]
pub struct SmallLu {
    lu: Vec<Vec<f64>>,
    /// Row of the matrix that stands at each place.
    order: Vec<usize>,
    /// Whether a pivot had to be replaced.
    pub singular: bool,
}

impl SmallLu {
    /// Factorises the square matrix with the rows `a`.
    pub fn new(mut a: Vec<Vec<f64>>) -> Self {
        let n = a.len();
        let mut order: Vec<usize> = (0..n).collect();
        let mut singular = false;
        let least = 1e-12 * a.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
        for k in 0..n {
            let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
            a.swap(k, pivot);
            order.swap(k, pivot);
            if a[k][k].abs() <= least {
                a[k][k] = least.max(f64::MIN_POSITIVE);
                singular = true;
            }
            let (above, below) = a.split_at_mut(k + 1);
            for row in below {
                row[k] /= above[k][k];
                (k + 1..n).for_each(|j| row[j] -= row[k] * above[k][j]);
            }
        }
        SmallLu { lu: a, order, singular }
    }

    /// The solution for the right-hand side `b`.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let n = self.lu.len();
        let mut x: Vec<f64> = self.order.iter().map(|&i| b[i]).collect();
        for i in 0..n {
            x[i] -= (0..i).map(|j| self.lu[i][j] * x[j]).sum::<f64>();
        }
        for i in (0..n).rev() {
            x[i] = (x[i] - (i + 1..n).map(|j| self.lu[i][j] * x[j]).sum::<f64>()) / self.lu[i][i];
        }
        x
    }
}

/// The Cholesky factor of a symmetric positive definite matrix. A row begins at its first entry that is not zero, where that of
/// the factor begins too: bodies in a row, each coupled with the next, have a narrow factor.
#[derive(Debug, Clone)]
pub struct SmallCholesky {
    /// The rows of the factor, each from its first column to the diagonal.
    rows: Vec<Vec<f64>>,
    first: Vec<usize>,
}

/// A pivot below this part of its diagonal entry is rounding.
const PIVOT: f64 = 1e-15;

impl SmallCholesky {
    /// Factorises the matrix whose lower triangle has these rows, each up to the diagonal; `None` if it is not positive
    /// definite.
    pub fn new(lower: Vec<Vec<f64>>) -> Option<Self> {
        let (mut rows, mut first) = (Vec::<Vec<f64>>::with_capacity(lower.len()), Vec::<usize>::new());
        for (i, mut row) in lower.into_iter().enumerate() {
            let begin = row.iter().position(|v| *v != 0.0)?;
            row.drain(..begin);
            let entry = *row.last()?;
            for j in begin..=i {
                let from = begin.max(if j < i { first[j] } else { begin });
                let (before, rest) = row.split_at_mut(j - begin);
                let own = &before[from - begin..];
                if j < i {
                    let other = &rows[j];
                    let known = super::dot(own, &other[from - first[j]..other.len() - 1]);
                    rest[0] = (rest[0] - known) / other[other.len() - 1];
                } else {
                    let pivot = rest[0] - super::dot(own, own);
                    if pivot.is_nan() || pivot <= PIVOT * entry.abs() {
                        return None;
                    }
                    rest[0] = pivot.sqrt();
                }
            }
            rows.push(row);
            first.push(begin);
        }
        Some(SmallCholesky { rows, first })
    }

    /// The solution for the right-hand side `b`.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let mut x = b.to_vec();
        for (i, (row, &first)) in self.rows.iter().zip(&self.first).enumerate() {
            let known = super::dot(&row[..i - first], &x[first..i]);
            x[i] = (x[i] - known) / row[i - first];
        }
        for (i, (row, &first)) in self.rows.iter().zip(&self.first).enumerate().rev() {
            x[i] /= row[i - first];
            let xi = x[i];
            super::axpy(-xi, &row[..i - first], &mut x[first..i]);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dot;

    #[test]
    fn eigenvectors_diagonalise_and_solutions_solve() {
        for n in [1, 2, 6, 9] {
            let a: Vec<Vec<f64>> = (0..n)
                .map(|i| (0..n).map(|j| ((i * j + i + j) as f64).sin() + f64::from(u8::from(i == j))).collect())
                .collect();
            let (values, vectors) = symmetric_eigen(&a);
            for (i, v) in vectors.iter().enumerate() {
                for (j, w) in vectors.iter().enumerate() {
                    assert!((dot(v, w) - f64::from(u8::from(i == j))).abs() < 1e-14);
                }
                (0..n).for_each(|r| assert!((dot(&a[r], v) - values[i] * v[r]).abs() < 1e-13));
            }
            let b: Vec<f64> = (0..n).map(|i| i as f64 - 1.5).collect();
            let x = SmallLu::new(a.clone()).solve(&b);
            (0..n).for_each(|r| assert!((dot(&a[r], &x) - b[r]).abs() < 1e-12, "{n}"));
        }
    }

    #[test]
    fn a_cholesky_factor_solves_and_tells_what_is_not_definite() {
        let n = 12;
        // A chain: each row is coupled with the three before it.
        let entry = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 4.0,
            1..=3 => -0.6 + 0.1 * ((i + j) as f64).cos(),
            _ => 0.0,
        };
        let lower = |shift: f64| -> Vec<Vec<f64>> {
            (0..n).map(|i| (0..=i).map(|j| entry(i, j) - if i == j { shift } else { 0.0 }).collect()).collect()
        };
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let factor = SmallCholesky::new(lower(0.0)).expect("a dominant diagonal");
        let x = factor.solve(&b);
        (0..n).for_each(|i| assert!(((0..n).map(|j| entry(i, j) * x[j]).sum::<f64>() - b[i]).abs() < 1e-13));
        let full: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
        let least = symmetric_eigen(&full).0.into_iter().fold(f64::INFINITY, f64::min);
        assert!(SmallCholesky::new(lower(0.999 * least)).is_some());
        assert!(SmallCholesky::new(lower(1.001 * least)).is_none());
        assert!(SmallCholesky::new(vec![vec![0.0]]).is_none());
        assert!(SmallCholesky::new(vec![vec![f64::NAN]]).is_none());
    }

    #[test]
    fn a_singular_matrix_is_answered_by_finite_numbers() {
        let singular = SmallLu::new(vec![vec![1.0, 1.0], vec![1.0, 1.0]]);
        assert!(singular.singular);
        let x = singular.solve(&[1.0, 1.0]);
        assert!((x[0] + x[1] - 1.0).abs() < 1e-12, "{x:?}");
        assert!(singular.solve(&[1.0, 2.0]).iter().all(|x| x.is_finite()));
    }
}
