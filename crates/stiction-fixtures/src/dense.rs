//! Dense linear algebra of the tests' own: a second road past the library's factorisation.

use stiction::contact::ContactProblem;
use stiction::linalg::{Csr, SymmetricCsr};

/// A dense symmetric positive definite matrix as its Cholesky factor, rows of the lower triangle.
pub struct Factor(Vec<Vec<f64>>);

impl Factor {
    pub fn new(a: &SymmetricCsr) -> Factor {
        let mut l: Vec<Vec<f64>> = Vec::with_capacity(a.rows);
        for i in 0..a.rows {
            let mut row = vec![0.0; i + 1];
            let (columns, values) = a.row(i);
            columns.iter().zip(values).for_each(|(&j, &v)| row[j as usize] += v);
            for j in 0..i {
                let s: f64 = row[..j].iter().zip(&l[j][..j]).map(|(a, b)| a * b).sum();
                row[j] = (row[j] - s) / l[j][j];
            }
            let square: f64 = row[..i].iter().map(|x| x * x).sum();
            row[i] = (row[i] - square).sqrt();
            assert!(row[i] > 0.0, "pivot {i}");
            l.push(row);
        }
        Factor(l)
    }

    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let n = self.0.len();
        let mut x = b.to_vec();
        for i in 0..n {
            let s: f64 = self.0[i][..i].iter().zip(&x).map(|(l, x)| l * x).sum();
            x[i] = (x[i] - s) / self.0[i][i];
        }
        for i in (0..n).rev() {
            x[i] /= self.0[i][i];
            let xi = x[i];
            (0..i).for_each(|j| x[j] -= self.0[i][j] * xi);
        }
        x
    }
}

/// `Q = B K⁻¹ Bᵀ` column by column and `h = B K⁻¹ f - [gap; slip_reference]`, so that `v = Q lambda - h`.
pub fn dual_data(problem: &ContactProblem, factor: &Factor) -> (Vec<Vec<f64>>, Vec<f64>) {
    let size = 3 * problem.points();
    let column = |i: usize| {
        let mut unit = vec![0.0; size];
        unit[i] = 1.0;
        problem.contact.B.times(&factor.solve(&problem.contact.B.transpose_times(&unit)))
    };
    let h = problem.gap_and_slip(&factor.solve(&problem.elastic.f)).iter().map(|v| -v).collect();
    ((0..size).map(column).collect(), h)
}

/// Largest eigenvalue of a symmetric matrix with non-negative spectrum by plain power steps, to about `1e-6`.
pub fn largest_eigenvalue(a: &[Vec<f64>]) -> f64 {
    let n = a.len();
    let mut x: Vec<f64> = (0..n).map(|i| 1.0 + (i as f64).sin()).collect();
    let mut value = 0.0;
    for _ in 0..20_000 {
        let y: Vec<f64> = a.iter().map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum()).collect();
        let size = y.iter().map(|v| v * v).sum::<f64>().sqrt();
        x = y.iter().map(|v| v / size).collect();
        if (size - value).abs() < 1e-13 * size {
            return size;
        }
        value = size;
    }
    value
}

pub fn block(a: &[Vec<f64>], range: std::ops::Range<usize>) -> Vec<Vec<f64>> {
    range.clone().map(|i| a[i][range.clone()].to_vec()).collect()
}

/// The inverse of a symmetric positive definite matrix.
pub fn inverse(a: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = a.len();
    let entries: Vec<_> = (0..n * n).map(|k| (k / n, k % n, a[k / n][k % n])).collect();
    let full = Csr::from_triplets(n, n, &entries);
    let factor = Factor::new(&SymmetricCsr::from_full(&full, "K").unwrap());
    let unit = |i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect::<Vec<f64>>();
    (0..n).map(|i| factor.solve(&unit(i))).collect()
}
