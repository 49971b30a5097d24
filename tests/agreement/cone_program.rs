//! Quadratic programs over cones, solved by Clarabel: no code of it is ours.

use clarabel::algebra::CscMatrix;
use clarabel::solver::SupportedConeT::{self, NonnegativeConeT, SecondOrderConeT, ZeroConeT};
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus};

/// Rows of `offset - C x` in cones, in the order they are added.
#[derive(Default)]
pub struct Cones {
    entries: Vec<(usize, usize, f64)>,
    offset: Vec<f64>,
    kinds: Vec<SupportedConeT<f64>>,
}

impl Cones {
    fn row(&mut self, offset: f64, entries: &[(usize, f64)]) {
        let row = self.offset.len();
        self.entries.extend(entries.iter().map(|(column, value)| (row, *column, *value)));
        self.offset.push(offset);
    }

    /// `offset - entries x = 0`.
    pub fn zero(&mut self, offset: f64, entries: &[(usize, f64)]) {
        self.row(offset, entries);
        self.kinds.push(ZeroConeT(1));
    }

    /// `offset - entries x >= 0`.
    pub fn nonnegative(&mut self, offset: f64, entries: &[(usize, f64)]) {
        self.row(offset, entries);
        self.kinds.push(NonnegativeConeT(1));
    }

    /// `|(a x, b x)| <= radius`.
    pub fn disc(&mut self, radius: f64, a: &[(usize, f64)], b: &[(usize, f64)]) {
        self.row(radius, &[]);
        [a, b].iter().for_each(|entries| self.row(0.0, entries));
        self.kinds.push(SecondOrderConeT(3));
    }

    /// The minimum of `1/2 x'A x - b'x` within the cones, and the multipliers of their rows.
    pub fn minimum(self, a: &[Vec<f64>], b: &[f64], tolerance: f64) -> (Vec<f64>, Vec<f64>) {
        let n = b.len();
        let upper = (0..n).flat_map(|j| (0..=j).map(move |i| (i, j))).map(|(i, j)| (i, j, a[i][j]));
        let upper: Vec<(usize, usize, f64)> = upper.filter(|e| e.2 != 0.0).collect();
        let matrix = |rows: usize, t: &[(usize, usize, f64)]| {
            let column = |f: fn(&(usize, usize, f64)) -> usize| t.iter().map(f).collect::<Vec<_>>();
            let values = t.iter().map(|t| t.2).collect();
            CscMatrix::new_from_triplets(rows, n, column(|t| t.0), column(|t| t.1), values)
        };
        let linear: Vec<f64> = b.iter().map(|b| -b).collect();
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .tol_gap_abs(tolerance)
            .tol_gap_rel(tolerance)
            .tol_feas(tolerance)
            .build()
            .unwrap();
        let rows = self.offset.len();
        let (p, c) = (matrix(n, &upper), matrix(rows, &self.entries));
        let mut solver = DefaultSolver::new(&p, &linear, &c, &self.offset, &self.kinds, settings).unwrap();
        solver.solve();
        let status = solver.solution.status;
        assert!(matches!(status, SolverStatus::Solved | SolverStatus::AlmostSolved), "{status:?}");
        (solver.solution.x, solver.solution.z)
    }
}

pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

pub fn times(a: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    a.iter().map(|row| dot(row, x)).collect()
}

/// `1/2 x'A x - b'x`.
pub fn objective(a: &[Vec<f64>], b: &[f64], x: &[f64]) -> f64 {
    0.5 * dot(x, &times(a, x)) - dot(b, x)
}

/// `A` times a number.
pub fn scaled(a: &[Vec<f64>], factor: f64) -> Vec<Vec<f64>> {
    a.iter().map(|row| row.iter().map(|x| x * factor).collect()).collect()
}
