use super::{Stop, axpy, dot, norm};

/// How a Krylov solve ended.
#[derive(Debug, Clone)]
pub struct Krylov {
    /// The solution in terms of the vectors handed to the operator: `x = sum_k coefficient[k] z_k`.
    pub coefficient: Vec<f64>,
    /// The vectors `z_k` handed to the operator, in the order of the calls.
    pub directions: Vec<Vec<f64>>,
    /// `|b - A x| / |b|` by the recurrence.
    pub residual: f64,
}

/// GMRES without restart (Saad & Schultz 1986), preconditioned from the right, from a zero start: stops when
/// `|b - A x| <= tolerance |b|` or after `limit` products, or as far as it came when `stop` asks to end.
///
/// The directions are returned so that a caller who keeps by-products of `A z_k` can combine them to by-products of
/// `A x` without a further product.
pub fn gmres(
    mut operator: impl FnMut(&[f64]) -> Vec<f64>,
    preconditioner: impl Fn(&[f64]) -> Vec<f64>,
    b: &[f64],
    tolerance: f64,
    limit: usize,
    stop: &Stop,
) -> Krylov {
    let beta = norm(b);
    let mut result = Krylov { coefficient: Vec::new(), directions: Vec::new(), residual: 1.0 };
    if beta == 0.0 || !beta.is_finite() {
        result.residual = if beta == 0.0 { 0.0 } else { beta };
        return result;
    }
    let mut basis = vec![b.iter().map(|v| v / beta).collect::<Vec<f64>>()];
    let mut triangle: Vec<Vec<f64>> = Vec::new(); // columns of R
    let mut rotations: Vec<(f64, f64)> = Vec::new();
    let mut rhs = vec![beta];
    while result.residual > tolerance && triangle.len() < limit && !stop.asked() {
        let k = triangle.len();
        let z = preconditioner(&basis[k]);
        let mut w = operator(&z);
        let before = norm(&w);
        let mut column = vec![0.0; k + 1];
        // Twice is enough: one sweep loses orthogonality once the basis has converged in some direction.
        for _ in 0..2 {
            for (h, v) in column.iter_mut().zip(&basis) {
                let s = dot(&w, v);
                *h += s;
                axpy(-s, v, &mut w);
            }
        }
        let mut below = norm(&w);
        if !below.is_finite() {
            break;
        }
        let broke_down = below <= 1e-14 * before;
        for (i, &(c, s)) in rotations.iter().enumerate() {
            (column[i], column[i + 1]) = (c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]);
        }
        if broke_down {
            below = 0.0;
        }
        let length = column[k].hypot(below);
        if length == 0.0 {
            break; // the operator vanishes on the new direction: singular, nothing more to gain
        }
        let (c, s) = (column[k] / length, below / length);
        column[k] = length;
        rotations.push((c, s));
        rhs.push(-s * rhs[k]);
        rhs[k] *= c;
        triangle.push(column);
        result.directions.push(z);
        result.residual = rhs[k + 1].abs() / beta;
        if broke_down {
            break;
        }
        w.iter_mut().for_each(|v| *v /= below);
        basis.push(w);
    }
    let size = triangle.len();
    result.coefficient = rhs[..size].to_vec();
    for k in (0..size).rev() {
        result.coefficient[k] /= triangle[k][k];
        let value = result.coefficient[k];
        (0..k).for_each(|i| result.coefficient[i] -= triangle[k][i] * value);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unsymmetric_system_is_solved_in_at_most_its_order() {
        let a = [[4.0, 1.0, 0.0], [-2.0, 3.0, 0.5], [0.0, 7.0, 5.0]];
        let times = |x: &[f64]| a.iter().map(|row| dot(row, x)).collect::<Vec<f64>>();
        let b = [1.0, 2.0, 3.0];
        let jacobi = |r: &[f64]| vec![r[0] / 4.0, r[1] / 3.0, r[2] / 5.0];
        let found = gmres(times, jacobi, &b, 1e-13, 10, &Stop::never());
        assert!(found.directions.len() <= 3 && found.residual <= 1e-13);
        let mut x = vec![0.0; 3];
        found.coefficient.iter().zip(&found.directions).for_each(|(&c, z)| axpy(c, z, &mut x));
        let mut r = times(&x);
        axpy(-1.0, &b, &mut r);
        assert!(norm(&r) < 1e-12);
    }

    #[test]
    fn a_singular_operator_ends_without_dividing_by_zero() {
        let found = gmres(|x| vec![x[0], 0.0], <[f64]>::to_vec, &[1.0, 1.0], 1e-10, 10, &Stop::never());
        assert!(found.coefficient.iter().all(|c| c.is_finite()) && found.residual > 0.5);
    }

    #[test]
    fn a_stop_ends_it_with_what_there_is() {
        let found =
            gmres(|x| vec![x[0], 2.0 * x[1], 3.0 * x[2]], <[f64]>::to_vec, &[1.0; 3], 1e-13, 10, &Stop::after(2));
        assert!(found.directions.len() == 2 && found.coefficient.len() == 2 && found.residual > 1e-6);
    }
}
