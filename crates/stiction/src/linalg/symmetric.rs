use std::ops::Range;

use super::kernels::dot_columns;
use super::vectorised;

/// A dense symmetric matrix, all entries stored, for products in quick succession.
#[derive(Debug, Clone)]
pub struct Symmetric {
    /// Number of rows and columns.
    pub order: usize,
    /// Row by row, `order²` numbers.
    entries: Vec<f64>,
}

impl Symmetric {
    /// From its columns; what rounding left of asymmetry is taken out by the mean.
    pub fn from_columns(order: usize, mut column: impl FnMut(usize) -> Vec<f64>) -> Self {
        let mut entries: Vec<f64> = (0..order).flat_map(&mut column).collect();
        entries.resize(order * order, 0.0);
        for i in 0..order {
            for j in 0..i {
                let mean = 0.5 * (entries[i * order + j] + entries[j * order + i]);
                (entries[i * order + j], entries[j * order + i]) = (mean, mean);
            }
        }
        Symmetric { order, entries }
    }

    /// Row `i` up to its diagonal.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.entries[i * self.order..(i + 1) * self.order]
    }

    /// The block `rows x columns` times `x`, whose length is that of `columns`.
    pub fn block_times(&self, rows: Range<usize>, columns: Range<usize>, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; rows.len()];
        vectorised(
            #[inline(always)]
            || self.gather(rows.start, columns.clone(), x, &mut y),
        );
        y
    }

    /// Products with several vectors of length `order`, one after the other in `x` and in the result. The matrix is
    /// read once for all of them.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        /// Rows that stay in the fastest cache while the vectors pass.
        const ROWS: usize = 4;
        let mut y = vec![0.0; x.len()];
        vectorised(
            #[inline(always)]
            || {
                for first in (0..self.order).step_by(ROWS) {
                    let last = (first + ROWS).min(self.order);
                    for (x, y) in x.chunks_exact(self.order).zip(y.chunks_exact_mut(self.order)) {
                        self.gather(first, 0..self.order, x, &mut y[first..last]);
                    }
                }
            },
        );
        y
    }

    /// Scalar products of the rows from `first` on, cut to `columns`, with `x`; as many as `y` is long.
    #[inline(always)]
    fn gather(&self, first: usize, columns: Range<usize>, x: &[f64], y: &mut [f64]) {
        let row = |i: usize| &self.row(first + i)[columns.clone()];
        let fours = y.len() - y.len() % 4;
        for i in (0..fours).step_by(4) {
            y[i..i + 4].copy_from_slice(&dot_columns(x, [row(i), row(i + 1), row(i + 2), row(i + 3)]));
        }
        for (i, y) in y.iter_mut().enumerate().skip(fours) {
            *y = dot_columns(x, [row(i); 4])[0];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_sums_over_the_entries_for_every_remainder_of_the_blocking() {
        for n in [1, 3, 4, 7, 13] {
            let a = Symmetric::from_columns(n, |j| (0..n).map(|i| 1.0 / (1 + i + j) as f64).collect());
            let x: Vec<f64> = (0..2 * n).map(|i| (i as f64).sin()).collect();
            let y = a.times(&x);
            for k in 0..2 {
                for i in 0..n {
                    let sum: f64 = (0..n).map(|j| x[k * n + j] / (1 + i + j) as f64).sum();
                    assert!((y[k * n + i] - sum).abs() < 1e-14);
                }
            }
            let (rows, columns) = (n / 3..n, 0..n / 2);
            let block = a.block_times(rows.clone(), columns.clone(), &x[..columns.len()]);
            for (i, y) in rows.zip(block) {
                let sum: f64 = columns.clone().map(|j| x[j] / (1 + i + j) as f64).sum();
                assert!((y - sum).abs() < 1e-14);
            }
        }
    }
}
