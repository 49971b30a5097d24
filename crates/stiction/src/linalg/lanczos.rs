use faer::{Mat, Side};

use super::{axpy, dot, norm};

/// An eigenvalue estimate with the bound that belongs to it: the interval `value ± residual` holds an eigenvalue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ritz {
    /// The Ritz value.
    pub value: f64,
    /// Norm of its residual: an eigenvalue is as near.
    pub residual: f64,
    /// Products with the operator.
    pub products: usize,
}

/// The largest eigenvalue of a symmetric operator of order `n` by Lanczos with full reorthogonalisation, until its
/// residual is at most `tolerance` times the value or `limit` products are spent.
///
/// The estimate approaches from below; `value + residual` bounds an eigenvalue from above, which is the largest
/// unless the fixed start vector is orthogonal to its eigenvector to working precision.
pub fn largest_eigenvalue(
    n: usize,
    mut operator: impl FnMut(&[f64]) -> Vec<f64>,
    tolerance: f64,
    limit: usize,
) -> Ritz {
    // A start vector without symmetries, the same in every run.
    let mut v: Vec<f64> = (0..n).map(|i| 1.0 + 0.5 * (1.0 + i as f64 * 1.618_033_988_75).sin()).collect();
    let mut result = Ritz { value: 0.0, residual: 0.0, products: 0 };
    let (mut basis, mut diagonal, mut below): (Vec<Vec<f64>>, Vec<f64>, Vec<f64>) = Default::default();
    let mut length = norm(&v);
    while length > 0.0 && result.products < limit.min(n) {
        v.iter_mut().for_each(|x| *x /= length);
        let mut w = operator(&v);
        result.products += 1;
        diagonal.push(dot(&v, &w));
        basis.push(v);
        for _ in 0..2 {
            for b in &basis {
                let s = dot(&w, b);
                axpy(-s, b, &mut w);
            }
        }
        length = norm(&w);
        let (value, last) = top_of_tridiagonal(&diagonal, &below);
        result.value = value;
        result.residual = length * last;
        if !result.residual.is_finite() || result.residual <= tolerance * value.abs() {
            break;
        }
        below.push(length);
        v = w;
    }
    result
}

/// Largest eigenvalue of a tridiagonal matrix and the magnitude of the last entry of its unit eigenvector.
fn top_of_tridiagonal(diagonal: &[f64], below: &[f64]) -> (f64, f64) {
    let k = diagonal.len();
    let t = Mat::from_fn(k, k, |i, j| match (i.max(j), i.min(j)) {
        (i, j) if i == j => diagonal[i],
        (i, j) if i == j + 1 => below[j],
        _ => 0.0,
    });
    match t.self_adjoint_eigen(Side::Lower) {
        Ok(eigen) => (eigen.S()[k - 1], eigen.U()[(k - 1, k - 1)].abs()),
        Err(_) => (f64::NAN, f64::NAN),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_of_a_known_spectrum_is_found_within_its_bound() {
        // The chain 2, -1 of length n has eigenvalues 2 - 2 cos(k pi / (n + 1)).
        let n = 60;
        let chain = |x: &[f64]| -> Vec<f64> {
            let at = |i: isize| if i < 0 || i as usize >= n { 0.0 } else { x[i as usize] };
            (0..n as isize).map(|i| 2.0 * at(i) - at(i - 1) - at(i + 1)).collect()
        };
        let exact = 2.0 - 2.0 * (std::f64::consts::PI * n as f64 / (n as f64 + 1.0)).cos();
        let found = largest_eigenvalue(n, chain, 1e-2, 60);
        assert!(found.value <= exact + 1e-12 && (exact - found.value) <= found.residual);
        assert!(found.residual <= 1e-2 * found.value && found.products < 60);
    }
}
