use super::V3;
use crate::friction::law::Linearisation;
use crate::linalg::{Csr, Lu, axpy, norm};

/// Residual of a linear system beyond which its factor is not trusted, relative to the right-hand side: far above what a
/// stable factor leaves, far below what a Newton step has to gain.
const TRUSTED: f64 = 1e-6;

/// The linearised laws of all points as equations for their unknowns, those of bodies before them where `W` is not stored.
pub(super) struct LinearSystem {
    pub matrix: Csr,
    pub rhs: Vec<f64>,
    /// Number of the first unknown of each point, and of all unknowns.
    pub first: Vec<usize>,
}

impl LinearSystem {
    /// Numbers the unknowns of the points after `others`.
    pub(super) fn number(points: &[Linearisation], others: usize) -> Vec<usize> {
        let ends = points.iter().scan(others, |end, p| {
            *end += p.unknowns;
            Some(*end)
        });
        std::iter::once(others).chain(ends).collect()
    }

    /// The changes of the impulses by a factor of the matrix; `None` where they are not trusted.
    pub(super) fn changes(&self, lu: &Lu, points: &[Linearisation]) -> Option<Vec<V3>> {
        let y = refined(lu, &self.matrix, &self.rhs)?;
        let change = |(p, own): (&Linearisation, &[usize])| p.change(&y[own[0]..own[1]]);
        let changes: Vec<V3> = points.iter().zip(self.first.windows(2)).map(change).collect();
        changes.as_flattened().iter().all(|x| x.is_finite()).then_some(changes)
    }
}

/// Solves with one refinement, since pivots are sought within fronts only; `None` where the residual is not trusted.
fn refined(lu: &Lu, matrix: &Csr, rhs: &[f64]) -> Option<Vec<f64>> {
    let residual = |y: &[f64]| {
        let mut residual = rhs.to_vec();
        axpy(-1.0, &matrix.times(y), &mut residual);
        residual
    };
    let mut y = lu.solve(rhs);
    axpy(1.0, &lu.solve(&residual(&y)), &mut y);
    (norm(&residual(&y)) <= TRUSTED * norm(rhs)).then_some(y)
}

/// The factor, if it solves a system with a known right-hand side.
pub(super) fn verified(lu: Lu, matrix: &Csr) -> Option<Lu> {
    let known: Vec<f64> = (0..matrix.rows).map(|i| 1.0 + (i as f64 * 0.7).sin()).collect();
    refined(&lu, matrix, &known).is_some().then_some(lu)
}

pub(super) fn dot(x: &V3, y: &V3) -> f64 {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

/// `x' w`.
pub(super) fn row_times(x: &V3, w: &[V3; 3]) -> V3 {
    std::array::from_fn(|j| x[0] * w[0][j] + x[1] * w[1][j] + x[2] * w[2][j])
}
