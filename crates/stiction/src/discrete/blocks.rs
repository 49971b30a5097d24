use super::V3;
use super::problem::LocalProblem;
use super::sweeps::sweep;
use super::system::{Discrete, Shifted};
use crate::friction::law::Linearisation;
use crate::friction::system::{Iterate, Step, System, length, moved};
use crate::linalg::{NodeGraph, nested_dissection};

/// `W` and `q` of a problem scaled point by point, as blocks of 3 x 3 (two dimensions get a third that is zero).
///
/// With `s_a = sqrt(3 / trace W_aa)` and one number `size` of the dimension of `q`, the scaled quantities are
/// `s_a W_ab s_b`, `s_a q_a / size`, `r_a / (s_a size)` and `s_a u_a / size`: the law of friction does not change, the
/// units vanish, and every diagonal block has the trace 3.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    pub mu: Vec<f64>,
    pub q: Vec<V3>,
    /// Blocks of row `a` are `start[a]..start[a + 1]`, columns ascending, the diagonal always stored; where `(a, b)`
    /// is stored, `(b, a)` is as well.
    pub start: Vec<usize>,
    pub column: Vec<u32>,
    pub block: Vec<[V3; 3]>,
    /// `s_a`.
    pub scale: Vec<f64>,
    pub size: f64,
    pub dimension: usize,
    /// An elimination order of the points with little fill.
    pub order: Vec<u32>,
}

impl Blocks {
    /// Scales a validated problem; its bilateral part, if any, has been condensed before.
    pub(super) fn new(problem: &LocalProblem) -> Self {
        let (d, m) = (problem.dimension, problem.mu.len());
        let (start, column) = pattern(problem);
        let mut block = vec![[[0.0; 3]; 3]; column.len()];
        for i in 0..d * m {
            let (columns, values) = problem.W.row(i);
            let own = start[i / d]..start[i / d + 1];
            for (&j, &v) in columns.iter().zip(values) {
                let (b, c) = (j / d as u32, j as usize % d);
                if let Ok(k) = column[own.clone()].binary_search(&b) {
                    block[own.start + k][i % d][c] = v;
                }
            }
        }
        let mut blocks = Blocks {
            mu: problem.mu.clone(),
            q: (0..m).map(|a| std::array::from_fn(|c| if c < d { problem.q[d * a + c] } else { 0.0 })).collect(),
            scale: scales(&(0..m).map(|a| trace(&block[diagonal(&start, &column, a)])).collect::<Vec<_>>()),
            order: Vec::new(),
            size: 1.0,
            dimension: d,
            start,
            column,
            block,
        };
        blocks.rescale();
        blocks.order = nested_dissection(&blocks.graph());
        blocks
    }

    fn rescale(&mut self) {
        for a in 0..self.mu.len() {
            for k in self.start[a]..self.start[a + 1] {
                let s = self.scale[a] * self.scale[self.column[k] as usize];
                self.block[k].as_flattened_mut().iter_mut().for_each(|v| *v *= s);
            }
            self.q[a].iter_mut().for_each(|v| *v *= self.scale[a]);
        }
        let size = length(&self.q);
        self.size = if size > 0.0 { size } else { 1.0 };
        self.q.as_flattened_mut().iter_mut().for_each(|v| *v /= self.size);
    }

    /// The graph of the points.
    fn graph(&self) -> NodeGraph {
        let m = self.mu.len();
        let (mut start, mut neighbours) = (vec![0], Vec::new());
        for a in 0..m {
            neighbours.extend(self.column[self.start[a]..self.start[a + 1]].iter().filter(|&&b| b as usize != a));
            start.push(neighbours.len());
        }
        let first = (0..=m).map(|a| 3 * a).collect();
        NodeGraph { first, unknowns: (0..3 * m as u32).collect(), start, neighbours }
    }

    /// `W_aa`.
    pub(super) fn diagonal(&self, a: usize) -> &[V3; 3] {
        &self.block[diagonal(&self.start, &self.column, a)]
    }

    /// Row `a` of `W r`.
    pub(super) fn row_times(&self, a: usize, r: &[V3]) -> V3 {
        let mut y = [0.0; 3];
        for k in self.start[a]..self.start[a + 1] {
            let (w, x) = (&self.block[k], &r[self.column[k] as usize]);
            (0..3).for_each(|i| y[i] += w[i][0] * x[0] + w[i][1] * x[1] + w[i][2] * x[2]);
        }
        y
    }

    /// Scaled impulses in the units of the problem, length `dm`.
    pub(super) fn unscaled(&self, r: &[V3]) -> Vec<f64> {
        let of_point = |(r, s): (&V3, &f64)| r.map(|x| x * s * self.size);
        let all: Vec<V3> = r.iter().zip(&self.scale).map(of_point).collect();
        all.iter().flat_map(|r| r[..self.dimension].iter().copied()).collect()
    }

    /// Impulses of length `dm` scaled.
    pub(super) fn scaled(&self, r: &[f64]) -> Vec<V3> {
        let d = self.dimension;
        let of_point =
            |a: usize| std::array::from_fn(|c| if c < d { r[d * a + c] / (self.scale[a] * self.size) } else { 0.0 });
        (0..self.mu.len()).map(of_point).collect()
    }
}

impl System for Blocks {
    fn live(&self, _: usize) -> [bool; 3] {
        [true; 3]
    }

    fn imbalance(&self, _: &[V3]) -> Vec<f64> {
        Vec::new()
    }

    fn step(&self, _: &Iterate, points: &[Linearisation], _: f64) -> Option<Step> {
        self.newton_step(points)
    }

    fn advance(&self, at: &Iterate, t: f64, step: &Step) -> Iterate {
        let lambda = moved(&at.lambda, t, &step.lambda);
        Iterate { v: self.velocity(&lambda), lambda, alpha: Vec::new() }
    }
}

impl Discrete for Blocks {
    fn mu(&self) -> &[f64] {
        &self.mu
    }

    fn offset(&self) -> &[V3] {
        &self.q
    }

    fn velocity(&self, r: &[V3]) -> Vec<V3> {
        (0..r.len()).map(|a| plus(&self.row_times(a, r), &self.q[a])).collect()
    }

    fn shifted(&self, shift: f64) -> Option<Shifted<'_>> {
        let lu = self.shifted_factor(shift)?;
        Some(Box::new(move |x| lu.solve(x.as_flattened()).as_chunks().0.to_vec()))
    }

    fn sweep(&self, r: &mut [V3], sweeps: usize) -> bool {
        sweep(self, r, sweeps);
        true
    }
}

/// `x + y`.
pub(super) fn plus(x: &V3, y: &V3) -> V3 {
    [x[0] + y[0], x[1] + y[1], x[2] + y[2]]
}

fn trace(w: &[V3; 3]) -> f64 {
    w[0][0] + w[1][1] + w[2][2]
}

/// A point without a positive trace takes the scale of the softest one.
pub(super) fn scales(traces: &[f64]) -> Vec<f64> {
    let largest = traces.iter().copied().fold(0.0, f64::max);
    let largest = if largest > 0.0 { largest } else { 3.0 };
    traces.iter().map(|&t| (3.0 / if t > 0.0 { t } else { largest }).sqrt()).collect()
}

fn diagonal(start: &[usize], column: &[u32], a: usize) -> usize {
    start[a] + column[start[a]..start[a + 1]].partition_point(|&b| (b as usize) < a)
}

/// Columns of the blocks of each row: those of `W` and of its transpose, and the diagonal.
fn pattern(problem: &LocalProblem) -> (Vec<usize>, Vec<u32>) {
    let (d, m) = (problem.dimension, problem.mu.len());
    let transposed = problem.W.transpose();
    let mut seen = vec![u32::MAX; m];
    let (mut start, mut column) = (vec![0], Vec::new());
    for a in 0..m {
        let first = column.len();
        seen[a] = a as u32;
        column.push(a as u32);
        for matrix in [&problem.W, &transposed] {
            for j in (d * a..d * (a + 1)).flat_map(|i| matrix.row(i).0) {
                let b = j / d as u32;
                if std::mem::replace(&mut seen[b as usize], a as u32) != a as u32 {
                    column.push(b);
                }
            }
        }
        column[first..].sort_unstable();
        start.push(column.len());
    }
    (start, column)
}
