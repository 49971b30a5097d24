//! The four loops in which a triangular solve spends its time, compiled for the vector unit found at run time.

// Triangles are written by their indices, and two vectors share them.
#![allow(clippy::needless_range_loop)]

use super::vectorised;

/// `y -= a0 c0 + a1 c1 + a2 c2 + a3 c3`; all of the length of `y`.
#[inline(always)]
fn subtract_columns(y: &mut [f64], c: [&[f64]; 4], a: [f64; 4]) {
    let n = y.len();
    let [c0, c1, c2, c3] = c.map(|c| &c[..n]);
    for i in 0..n {
        y[i] -= a[0] * c0[i] + a[1] * c1[i] + a[2] * c2[i] + a[3] * c3[i];
    }
}

/// `[c0.x, c1.x, c2.x, c3.x]`.
#[inline(always)]
pub(super) fn dot_columns(x: &[f64], c: [&[f64]; 4]) -> [f64; 4] {
    const LANES: usize = 8;
    let n = x.len();
    let c = c.map(|c| &c[..n]);
    let mut sums = [[0.0; LANES]; 4];
    let whole = n - n % LANES;
    for i in (0..whole).step_by(LANES) {
        let x = &x[i..i + LANES];
        for (sum, c) in sums.iter_mut().zip(c) {
            let c = &c[i..i + LANES];
            for l in 0..LANES {
                sum[l] += c[l] * x[l];
            }
        }
    }
    let mut result = [0.0; 4];
    for ((result, sum), c) in result.iter_mut().zip(sums).zip(c) {
        *result = sum.iter().sum::<f64>() + (whole..n).map(|i| c[i] * x[i]).sum::<f64>();
    }
    result
}

/// `L` of a column-major panel with `columns` columns of `rows >= columns` entries whose upper part is lower
/// triangular. Solves `L_top w_top = w_top` and subtracts `L_bottom w_top` from `w_bottom`, in place.
pub(super) fn forward(panel: &[f64], rows: usize, columns: usize, w: &mut [f64]) {
    vectorised(
        #[inline(always)]
        || {
            let column = |j: usize| &panel[j * rows..(j + 1) * rows];
            let mut j = 0;
            while j + 4 <= columns {
                for k in j..j + 4 {
                    w[k] /= column(k)[k];
                    for i in k + 1..j + 4 {
                        w[i] -= column(k)[i] * w[k];
                    }
                }
                let a = [w[j], w[j + 1], w[j + 2], w[j + 3]];
                let below = j + 4;
                subtract_columns(&mut w[below..], [j, j + 1, j + 2, j + 3].map(|k| &column(k)[below..]), a);
                j = below;
            }
            for k in j..columns {
                w[k] /= column(k)[k];
                let a = w[k];
                w[k + 1..].iter_mut().zip(&column(k)[k + 1..]).for_each(|(w, l)| *w -= a * l);
            }
        },
    );
}

/// The transposed solve of [`forward`]: `w_top = L_top^-T (w_top - L_bottomᵀ w_bottom)`, in place.
pub(super) fn backward(panel: &[f64], rows: usize, columns: usize, w: &mut [f64]) {
    vectorised(
        #[inline(always)]
        || {
            let column = |j: usize| &panel[j * rows..(j + 1) * rows];
            let fours = columns - columns % 4;
            for k in (fours..columns).rev() {
                let sum: f64 = w[k + 1..].iter().zip(&column(k)[k + 1..]).map(|(w, l)| w * l).sum();
                w[k] = (w[k] - sum) / column(k)[k];
            }
            for j in (0..fours).step_by(4).rev() {
                let below = j + 4;
                let sums = dot_columns(&w[below..], [j, j + 1, j + 2, j + 3].map(|k| &column(k)[below..]));
                for k in (j..below).rev() {
                    let inner: f64 = (k + 1..below).map(|i| column(k)[i] * w[i]).sum();
                    w[k] = (w[k] - sums[k - j] - inner) / column(k)[k];
                }
            }
        },
    );
}

/// `L x` for the square lower triangle of order `n` stored by columns of `n` entries.
pub(super) fn lower_times(l: &[f64], n: usize, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; n];
    vectorised(
        #[inline(always)]
        || {
            let column = |j: usize| &l[j * n..(j + 1) * n];
            let fours = n - n % 4;
            for j in (0..fours).step_by(4) {
                let below = j + 4;
                for k in j..below {
                    (k..below).for_each(|i| y[i] += column(k)[i] * x[k]);
                }
                let a = [-x[j], -x[j + 1], -x[j + 2], -x[j + 3]];
                subtract_columns(&mut y[below..], [j, j + 1, j + 2, j + 3].map(|k| &column(k)[below..]), a);
            }
            for k in fours..n {
                (k..n).for_each(|i| y[i] += column(k)[i] * x[k]);
            }
        },
    );
    y
}

/// `Lᵀ x` for the square lower triangle of order `n` stored by columns of `n` entries.
pub(super) fn lower_transpose_times(l: &[f64], n: usize, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; n];
    vectorised(
        #[inline(always)]
        || {
            let column = |j: usize| &l[j * n..(j + 1) * n];
            let fours = n - n % 4;
            for j in (0..fours).step_by(4) {
                let below = j + 4;
                let sums = dot_columns(&x[below..], [j, j + 1, j + 2, j + 3].map(|k| &column(k)[below..]));
                for k in j..below {
                    y[k] = sums[k - j] + (k..below).map(|i| column(k)[i] * x[i]).sum::<f64>();
                }
            }
            for k in fours..n {
                y[k] = (k..n).map(|i| column(k)[i] * x[i]).sum();
            }
        },
    );
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_undo_products_for_every_remainder_of_the_blocking() {
        for n in 1..14 {
            let l: Vec<f64> = (0..n * n)
                .map(|k| {
                    let (j, i) = (k / n, k % n);
                    if i < j { f64::NAN } else { 1.0 / (1 + i + 2 * j) as f64 + f64::from(u8::from(i == j)) }
                })
                .collect();
            let x: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let mut down = lower_times(&l, n, &x);
            forward(&l, n, n, &mut down);
            let mut up = lower_transpose_times(&l, n, &x);
            backward(&l, n, n, &mut up);
            for i in 0..n {
                assert!((down[i] - x[i]).abs() < 1e-12 && (up[i] - x[i]).abs() < 1e-12, "n = {n}");
            }
        }
    }

    #[test]
    fn a_panel_with_rows_below_its_triangle_carries_them_along() {
        let (rows, columns) = (11, 6);
        let panel: Vec<f64> =
            (0..rows * columns).map(|k| if k % rows < k / rows { f64::NAN } else { 2.0 + (k as f64).sin() }).collect();
        let x: Vec<f64> = (0..rows).map(|i| 1.0 + i as f64).collect();
        let mut w = vec![0.0; rows];
        for j in 0..columns {
            (j..rows).for_each(|i| w[i] += panel[j * rows + i] * x[j]);
        }
        (columns..rows).for_each(|i| w[i] += x[i]);
        forward(&panel, rows, columns, &mut w);
        assert!((0..rows).all(|i| (w[i] - x[i]).abs() < 1e-9));
        let mut v: Vec<f64> = (0..rows)
            .map(|j| if j < columns { (j..rows).map(|i| panel[j * rows + i] * x[i]).sum() } else { x[j] })
            .collect();
        backward(&panel, rows, columns, &mut v);
        assert!((0..rows).all(|i| (v[i] - x[i]).abs() < 1e-9));
    }
}
