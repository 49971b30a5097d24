use super::V3;
use super::blocks::Blocks;
use crate::friction::law::Linearisation;
use crate::friction::system::Step;
use crate::linalg::{Csr, Lu, NodeGraph, axpy, norm, plan};

/// Residual of the linear system beyond which its factor is not trusted, relative to its right-hand side.
const TRUSTED: f64 = 1e-6;

impl Blocks {
    /// The change of impulses that solves the linearised laws of all points; `None` where it is not trusted.
    pub(super) fn newton_step(&self, points: &[Linearisation]) -> Option<Step> {
        let known: Vec<V3> = points.iter().map(|p| p.known).collect();
        let (first, matrix, rhs) = assemble(self, points, &known);
        if rhs.is_empty() {
            return Some(change(known));
        }
        let y = refined(&factor(self, points, &matrix)?, &matrix, &rhs)?;
        let d: Vec<V3> = points.iter().enumerate().map(|(a, p)| p.change(&y[first[a]..first[a + 1]])).collect();
        d.as_flattened().iter().all(|x| x.is_finite()).then(|| change(d))
    }

    /// A factor of `W + shift`.
    pub(super) fn shifted_factor(&self, shift: f64) -> Option<Lu> {
        let points = vec![Linearisation::free(shift); self.mu.len()];
        let (_, matrix, _) = assemble(self, &points, &vec![[0.0; 3]; points.len()]);
        factor(self, &points, &matrix)
    }
}

/// A step to these changes of the impulses; velocities are computed anew along it.
pub(super) fn change(lambda: Vec<V3>) -> Step {
    Step { lambda, v: Vec::new(), alpha: Vec::new(), resisted: true }
}

/// Number of the first unknown of each point, the matrix of all unknowns and the right-hand side.
fn assemble(blocks: &Blocks, points: &[Linearisation], known: &[V3]) -> (Vec<usize>, Csr, Vec<f64>) {
    let mut first = vec![0];
    points.iter().for_each(|p| first.push(first[first.len() - 1] + p.unknowns));
    let n = first[points.len()];
    let mut matrix = Csr::zero(n, n);
    let mut rhs = Vec::with_capacity(n);
    for (a, point) in points.iter().enumerate() {
        if point.unknowns == 0 {
            continue;
        }
        let w = blocks.row_times(a, known);
        for k in 0..point.unknowns {
            rhs.push(point.rhs[k] - dot(&point.rows[k], &w));
            for e in blocks.start[a]..blocks.start[a + 1] {
                let b = blocks.column[e] as usize;
                let other = &points[b];
                if other.unknowns == 0 {
                    continue;
                }
                let row = row_times(&point.rows[k], &blocks.block[e]);
                for l in 0..other.unknowns {
                    let own = if a == b && k == l { point.compliance[k] } else { 0.0 };
                    matrix.column.push((first[b] + l) as u32);
                    matrix.value.push(dot(&row, &other.columns[l]) + own);
                }
            }
            matrix.start[rhs.len()] = matrix.column.len();
        }
    }
    (first, matrix, rhs)
}

fn factor(blocks: &Blocks, points: &[Linearisation], matrix: &Csr) -> Option<Lu> {
    let mut number = vec![u32::MAX; points.len()];
    let mut labels = Vec::with_capacity(matrix.rows);
    let active = points.iter().enumerate().filter(|(_, p)| p.unknowns > 0);
    for (k, (a, point)) in (0..).zip(active) {
        number[a] = k;
        labels.extend(std::iter::repeat_n(k, point.unknowns));
    }
    let order: Vec<u32> = blocks.order.iter().map(|&a| number[a as usize]).filter(|&v| v != u32::MAX).collect();
    Lu::new(matrix, &plan(&NodeGraph::new(matrix, Some(&labels)), &order, 0))
}

/// Solves with one refinement, since pivots are sought within fronts only; `None` where the residual is not trusted.
pub(super) fn refined(lu: &Lu, matrix: &Csr, rhs: &[f64]) -> Option<Vec<f64>> {
    let mut y = lu.solve(rhs);
    let mut rest = rhs.to_vec();
    axpy(-1.0, &matrix.times(&y), &mut rest);
    axpy(1.0, &lu.solve(&rest), &mut y);
    rest.copy_from_slice(rhs);
    axpy(-1.0, &matrix.times(&y), &mut rest);
    (norm(&rest) <= TRUSTED * norm(rhs)).then_some(y)
}

pub(super) fn dot(x: &V3, y: &V3) -> f64 {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

/// `x' w`.
pub(super) fn row_times(x: &V3, w: &[V3; 3]) -> V3 {
    std::array::from_fn(|j| x[0] * w[0][j] + x[1] * w[1][j] + x[2] * w[2][j])
}
