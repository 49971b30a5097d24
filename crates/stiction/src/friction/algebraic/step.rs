use super::V3;
use super::blocks::{Blocks, plus};
use super::law::{State, state};
use crate::linalg::{Csr, Lu, NodeGraph, axpy, norm, plan};

/// What a Newton step leaves open at one point: its change of impulse is `known + columns' y`, and `y` obeys
/// `rows du + softness y = rhs` with `du` its change of velocity.
struct Reduced {
    known: V3,
    /// How many of the following are in use.
    unknowns: usize,
    columns: [V3; 3],
    rows: [V3; 3],
    softness: V3,
    rhs: V3,
}

/// A slipping point whose bound is below this part of its augmented friction does not feel its velocity.
const NO_BOUND: f64 = 1e-12;
/// Residual of the linear system beyond which its factor is not trusted, relative to its right-hand side.
const TRUSTED: f64 = 1e-6;

impl Reduced {
    /// Linearises the law at impulse `r` and velocity `u`: an open point loses its impulse, a sticking one its
    /// velocity; of a slipping one the normal velocity vanishes, friction follows the normal impulse along the
    /// direction of slip, and across it friction and velocity turn together.
    fn new(mu: f64, r: &V3, u: &V3) -> Self {
        let (zero, unit) = ([0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let none = Reduced { known: zero, unknowns: 0, columns: [zero; 3], rows: [zero; 3], softness: zero, rhs: zero };
        match state(mu, r, u) {
            State::Open => Reduced { known: r.map(|x| -x), ..none },
            State::Stick => Reduced { unknowns: 3, columns: unit, rows: unit, rhs: u.map(|x| -x), ..none },
            State::Slip { direction: [e1, e2], length, bound } => {
                let (along, across) = (r[1] * e1 + r[2] * e2, r[2] * e1 - r[1] * e2);
                let (follow, share) = (mu * r[0] - along, bound / length);
                let normal = Reduced {
                    known: [0.0, follow * e1, follow * e2],
                    unknowns: 1,
                    columns: [[1.0, mu * e1, mu * e2], zero, zero],
                    rows: [unit[0], zero, zero],
                    softness: zero,
                    rhs: [-u[0], 0.0, 0.0],
                };
                let turn = [0.0, -e2, e1];
                if share <= NO_BOUND {
                    let known = std::array::from_fn(|i| normal.known[i] - across * turn[i]);
                    return Reduced { known, ..normal };
                }
                Reduced {
                    unknowns: 2,
                    columns: [normal.columns[0], turn, zero],
                    rows: [unit[0], turn, zero],
                    softness: [0.0, (1.0 - share) / share, 0.0],
                    rhs: [-u[0], -across / share, 0.0],
                    ..normal
                }
            }
        }
    }
}

/// The Newton step for `W + alpha` at impulses `r` and velocities `u`: the change of the impulses. `None` where the
/// linear system is singular to working precision.
pub fn newton_step(blocks: &Blocks, alpha: f64, r: &[V3], u: &[V3]) -> Option<Vec<V3>> {
    let points: Vec<Reduced> = (0..r.len()).map(|a| Reduced::new(blocks.mu[a], &r[a], &u[a])).collect();
    let mut d: Vec<V3> = points.iter().map(|p| p.known).collect();
    let (first, matrix, rhs) = assemble(blocks, alpha, &points, &d);
    let y = solve(blocks, &points, &matrix, &rhs)?;
    for (a, point) in points.iter().enumerate() {
        for (k, y) in y[first[a]..first[a + 1]].iter().enumerate() {
            (0..3).for_each(|i| d[a][i] += point.columns[k][i] * y);
        }
    }
    d.as_flattened().iter().all(|x| x.is_finite()).then_some(d)
}

/// Number of the first unknown of each point, the matrix of all unknowns and the right-hand side.
fn assemble(blocks: &Blocks, alpha: f64, points: &[Reduced], known: &[V3]) -> (Vec<usize>, Csr, Vec<f64>) {
    let mut first = vec![0];
    points.iter().for_each(|p| first.push(first[first.len() - 1] + p.unknowns));
    let n = first[points.len()];
    let mut matrix = Csr::zero(n, n);
    let mut rhs = Vec::with_capacity(n);
    for (a, point) in points.iter().enumerate() {
        if point.unknowns == 0 {
            continue;
        }
        let w = plus(&blocks.row_times(a, known), &known[a].map(|x| alpha * x));
        for k in 0..point.unknowns {
            rhs.push(point.rhs[k] - dot(&point.rows[k], &w));
            for e in blocks.start[a]..blocks.start[a + 1] {
                let b = blocks.column[e] as usize;
                let other = &points[b];
                if other.unknowns == 0 {
                    continue;
                }
                let mut row = row_times(&point.rows[k], &blocks.block[e]);
                if a == b {
                    (0..3).for_each(|i| row[i] += alpha * point.rows[k][i]);
                }
                for l in 0..other.unknowns {
                    let soft = if a == b && k == l { point.softness[k] } else { 0.0 };
                    matrix.column.push((first[b] + l) as u32);
                    matrix.value.push(dot(&row, &other.columns[l]) + soft);
                }
            }
            matrix.start[rhs.len()] = matrix.column.len();
        }
    }
    (first, matrix, rhs)
}

fn solve(blocks: &Blocks, points: &[Reduced], matrix: &Csr, rhs: &[f64]) -> Option<Vec<f64>> {
    if rhs.is_empty() {
        return Some(Vec::new());
    }
    let mut number = vec![u32::MAX; points.len()];
    let mut labels = Vec::with_capacity(rhs.len());
    let active = points.iter().enumerate().filter(|(_, p)| p.unknowns > 0);
    for (k, (a, point)) in (0..).zip(active) {
        number[a] = k;
        labels.extend(std::iter::repeat_n(k, point.unknowns));
    }
    let order: Vec<u32> = blocks.order.iter().map(|&a| number[a as usize]).filter(|&v| v != u32::MAX).collect();
    let lu = Lu::new(matrix, &plan(&NodeGraph::new(matrix, Some(&labels)), &order, 0))?;
    let mut y = lu.solve(rhs);
    let mut rest = rhs.to_vec();
    axpy(-1.0, &matrix.times(&y), &mut rest);
    // One refinement: pivots were sought within fronts only.
    axpy(1.0, &lu.solve(&rest), &mut y);
    rest.copy_from_slice(rhs);
    axpy(-1.0, &matrix.times(&y), &mut rest);
    (norm(&rest) <= TRUSTED * norm(rhs)).then_some(y)
}

fn dot(x: &V3, y: &V3) -> f64 {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

/// `x' w`.
fn row_times(x: &V3, w: &[V3; 3]) -> V3 {
    std::array::from_fn(|j| x[0] * w[0][j] + x[1] * w[1][j] + x[2] * w[2][j])
}
