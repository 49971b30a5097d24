use super::V3;
use super::linear::{LinearSystem, dot, row_times};
use super::problem::LocalProblem;
use super::system::Operator;
use crate::friction::law::Linearisation;
use crate::linalg::{Csr, Lu, NodeGraph, Pattern, nested_dissection, plan};

/// `W` stored as scaled blocks of 3 x 3.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    /// Blocks of row `a` are `start[a]..start[a + 1]`, columns ascending, the diagonal always stored; where `(a, b)`
    /// is stored, `(b, a)` is as well.
    pub start: Vec<usize>,
    pub column: Vec<u32>,
    pub block: Vec<[V3; 3]>,
    /// `s_a`.
    scale: Vec<f64>,
    /// An elimination order of the points with little fill.
    order: Vec<u32>,
}

impl Blocks {
    /// Scales a validated problem; its bilateral part, if any, has been condensed before.
    pub(super) fn new(problem: &LocalProblem) -> Self {
        let (d, m) = (problem.dimension, problem.mu.len());
        let scale = scales(&problem.traces());
        let transposed = problem.W.transpose();
        let Pattern { start, column } = Pattern::new(m, m, |a, name| {
            name(a as u32);
            for matrix in [&problem.W, &transposed] {
                (d * a..d * (a + 1)).flat_map(|i| matrix.row(i).0).for_each(|&j| name(j / d as u32));
            }
        });
        let mut block = vec![[[0.0; 3]; 3]; column.len()];
        for (i, j, v) in problem.W.entries() {
            let (a, b) = (i / d, j / d);
            if let Ok(k) = column[start[a]..start[a + 1]].binary_search(&(b as u32)) {
                block[start[a] + k][i % d][j % d] = v * (scale[a] * scale[b]);
            }
        }
        let graph = Csr { rows: m, cols: m, start, column, value: vec![0.0; block.len()] };
        let order = nested_dissection(&NodeGraph::new(&graph, None));
        let Csr { start, column, .. } = graph;
        Blocks { start, column, block, scale, order }
    }

    /// `W_aa`.
    pub(super) fn diagonal(&self, a: usize) -> &[V3; 3] {
        let own = &self.column[self.start[a]..self.start[a + 1]];
        &self.block[self.start[a] + own.partition_point(|&b| (b as usize) < a)]
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
}

impl Operator for Blocks {
    fn scale(&self) -> &[f64] {
        &self.scale
    }

    fn times(&self, r: &[V3]) -> Vec<V3> {
        (0..r.len()).map(|a| self.row_times(a, r)).collect()
    }

    fn linearised(&self, points: &[Linearisation]) -> LinearSystem {
        let first = LinearSystem::number(points, 0);
        let n = first[points.len()];
        let known: Vec<V3> = points.iter().map(|p| p.known).collect();
        let (mut matrix, mut rhs) = (Csr::zero(n, n), Vec::with_capacity(n));
        for (a, point) in points.iter().enumerate().filter(|(_, p)| p.unknowns > 0) {
            let w = self.row_times(a, &known);
            for k in 0..point.unknowns {
                rhs.push(point.rhs[k] - dot(&point.rows[k], &w));
                for e in self.start[a]..self.start[a + 1] {
                    let b = self.column[e] as usize;
                    if points[b].unknowns == 0 {
                        continue;
                    }
                    let row = row_times(&point.rows[k], &self.block[e]);
                    for l in 0..points[b].unknowns {
                        let own = if a == b && k == l { point.compliance[k] } else { 0.0 };
                        matrix.column.push((first[b] + l) as u32);
                        matrix.value.push(dot(&row, &points[b].columns[l]) + own);
                    }
                }
                matrix.start[rhs.len()] = matrix.column.len();
            }
        }
        LinearSystem { matrix, rhs, first }
    }

    fn factor(&self, points: &[Linearisation], linear: &LinearSystem) -> Option<Lu> {
        let mut number = vec![u32::MAX; points.len()];
        let mut labels = Vec::with_capacity(linear.rhs.len());
        let active = points.iter().enumerate().filter(|(_, p)| p.unknowns > 0);
        for (k, (a, point)) in (0..).zip(active) {
            number[a] = k;
            labels.extend(std::iter::repeat_n(k, point.unknowns));
        }
        let order: Vec<u32> = self.order.iter().map(|&a| number[a as usize]).filter(|&v| v != u32::MAX).collect();
        Lu::new(&linear.matrix, &plan(&NodeGraph::new(&linear.matrix, Some(&labels)), &order, 0))
    }

    fn blocks(&self) -> Option<&Blocks> {
        Some(self)
    }
}

/// `s_a` by the trace of the blocks; a point without a positive trace takes the scale of the one with the largest.
pub(super) fn scales(traces: &[f64]) -> Vec<f64> {
    let largest = traces.iter().copied().fold(0.0, f64::max);
    let largest = if largest > 0.0 { largest } else { 3.0 };
    traces.iter().map(|&t| (3.0 / if t > 0.0 { t } else { largest }).sqrt()).collect()
}
