//! Small dense algebra on blocks.

use rayon::prelude::*;

use super::blocks::Block;
use crate::ranks::Halo;

/// `c += a b`.
#[inline(always)]
pub(super) fn add_product<const R: usize, const M: usize, const C: usize>(
    a: &Block<R, M>,
    b: &Block<M, C>,
    c: &mut Block<R, C>,
) {
    for r in 0..R {
        for m in 0..M {
            let factor = a[r][m];
            for k in 0..C {
                c[r][k] += factor * b[m][k];
            }
        }
    }
}

/// `c += aᵀ b`.
#[inline(always)]
pub(super) fn add_transpose_product<const R: usize, const M: usize, const C: usize>(
    a: &Block<M, R>,
    b: &Block<M, C>,
    c: &mut Block<R, C>,
) {
    for r in 0..R {
        let mut row = c[r];
        for m in 0..M {
            let factor = a[m][r];
            for k in 0..C {
                row[k] += factor * b[m][k];
            }
        }
        c[r] = row;
    }
}

/// Sum of the squares of a block.
pub(super) fn square<const R: usize, const C: usize>(a: &Block<R, C>) -> f64 {
    a.iter().flatten().map(|v| v * v).sum()
}

/// A pivot below this multiple of the largest diagonal entry of the matrix is the rounding of a body that is a single node of the
/// level: its rigid motions cost nothing. Of forty blocks in a stack one inverse is infinite without it.
pub(super) const NO_STIFFNESS: f64 = 1e-13;

/// What counts as zero in small matrices.
struct Threshold;

impl Threshold {
    /// A pivot below this multiple of its diagonal entry counts as zero.
    const ZERO_PIVOT: f64 = 1e-12;
    /// A pivot that truncation has reduced to this multiple of its former value is rounding.
    const ROUNDING: f64 = 1e-10;
    /// A pivot below this multiple of its diagonal entry is not resolved in single precision.
    const SINGLE: f64 = 1e-6;
}

/// The lower Cholesky factor of a symmetric block and the pivots; columns whose pivot is not above `least` are zero and
/// count as pivot zero.
fn cholesky<const R: usize>(a: &Block<R, R>, least: &[f64; R]) -> (Block<R, R>, [f64; R]) {
    let (mut l, mut pivots) = ([[0.0; R]; R], [0.0; R]);
    for k in 0..R {
        let pivot = a[k][k] - (0..k).map(|j| l[k][j] * l[k][j]).sum::<f64>();
        if pivot > least[k] {
            pivots[k] = pivot;
            let scale = 1.0 / pivot.sqrt();
            for i in k..R {
                l[i][k] = (a[i][k] - (0..k).map(|j| l[i][j] * l[k][j]).sum::<f64>()) * scale;
            }
        }
    }
    (l, pivots)
}

fn zero_pivots<const R: usize>(a: &Block<R, R>) -> [f64; R] {
    std::array::from_fn(|k| Threshold::ZERO_PIVOT * a[k][k])
}

/// The inverse of a symmetric positive semidefinite block; directions with a zero pivot are left out (zero rows and
/// columns).
pub(crate) fn inverse<const R: usize>(a: &Block<R, R>) -> Block<R, R> {
    inverse_above(a, &zero_pivots(a))
}

/// [`inverse`] of the diagonal block of a matrix: pivots that are rounding beside `largest`, the largest of all diagonal entries,
/// are left out too.
pub(super) fn inverse_beside<const R: usize>(a: &Block<R, R>, largest: f64) -> Block<R, R> {
    inverse_above(a, &zero_pivots(a).map(|least| least.max(NO_STIFFNESS * largest)))
}

/// [`inverse_beside`] of a block after truncation, `before` it untruncated, for sweeps in single precision: directions whose pivot
/// is rounding are left out too, because steps along them would be a million times too long.
pub(super) fn inverse_of_truncated<const R: usize>(a: &Block<R, R>, before: &Block<R, R>, largest: f64) -> Block<R, R> {
    let (_, pivots) = cholesky(before, &zero_pivots(before));
    let least = |k: usize| (Threshold::ROUNDING * pivots[k]).max(Threshold::SINGLE * a[k][k]);
    inverse_above(a, &std::array::from_fn(|k| least(k).max(NO_STIFFNESS * largest)))
}

/// The largest diagonal entry of a matrix whose rows are divided by `halo`, by the diagonal blocks of those of this rank.
pub(super) fn largest_diagonal<const R: usize>(
    diagonal: impl Fn(usize) -> Block<R, R> + Sync + Send,
    halo: &Halo,
) -> f64 {
    let of_block = |i: usize| {
        let block = diagonal(i);
        (0..R).fold(0.0, |a: f64, k| a.max(block[k][k]))
    };
    let mut largest = [(0..halo.own()).into_par_iter().map(of_block).reduce(|| 0.0, f64::max)];
    halo.max(&mut largest);
    largest[0]
}

fn inverse_above<const R: usize>(a: &Block<R, R>, least: &[f64; R]) -> Block<R, R> {
    let (l, pivots) = cholesky(a, least);
    let reciprocal = pivots.map(|pivot| if pivot > 0.0 { 1.0 / pivot.sqrt() } else { 0.0 });
    let mut result = [[0.0; R]; R];
    for c in 0..R {
        if reciprocal[c] == 0.0 {
            continue;
        }
        let mut x = [0.0; R];
        for i in c..R {
            let b = f64::from(u8::from(i == c));
            x[i] = (b - (c..i).map(|j| l[i][j] * x[j]).sum::<f64>()) * reciprocal[i];
        }
        for i in (0..R).rev() {
            x[i] = (x[i] - (i + 1..R).map(|j| l[j][i] * x[j]).sum::<f64>()) * reciprocal[i];
        }
        (0..R).for_each(|i| result[i][c] = x[i]);
    }
    result
}

/// The inverse of a symmetric positive definite block on the components where `free` is true, zero elsewhere.
pub(super) fn inverse_on<const R: usize>(a: &Block<R, R>, free: &[bool; R]) -> Block<R, R> {
    let mut part = *a;
    for i in 0..R {
        for j in 0..R {
            if !(free[i] && free[j]) {
                part[i][j] = 0.0;
            }
        }
    }
    inverse(&part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_leaves_out_directions_with_a_zero_pivot() {
        let a = [[4.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 0.0, 0.0]];
        let b = inverse(&a);
        let mut product = [[0.0; 3]; 3];
        add_product(&a, &b, &mut product);
        for i in 0..3 {
            for j in 0..3 {
                let expected = f64::from(u8::from(i == j && i < 2));
                assert!((product[i][j] - expected).abs() < 1e-14);
            }
        }
        // The first direction was far stiffer, the third depends on the second but for rounding.
        let before = [[4e11, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 0.0, 1.0]];
        let left = [[4.0, 0.0, 0.0], [0.0, 3.0, 3.0], [0.0, 3.0, 3.0 + 1e-7]];
        let inverse = inverse_of_truncated(&left, &before, 0.0);
        assert!((inverse[1][1] - 1.0 / 3.0).abs() < 1e-15 && inverse[0] == [0.0; 3] && inverse[2] == [0.0; 3]);
        // Beside far stiffer nodes all of this is rounding.
        assert_eq!(inverse_beside(&a, 1e14), [[0.0; 3]; 3]);
        assert_eq!(inverse_beside(&a, 1e12), b);
        let only_second = inverse_on(&a, &[false, true, true]);
        assert!((only_second[1][1] - 1.0 / 3.0).abs() < 1e-15 && only_second[0] == [0.0; 3]);
    }
}
