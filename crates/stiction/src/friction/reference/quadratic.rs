use std::cell::Cell;
use std::ops::Range;

use crate::contact::ContactProblem;
use crate::dual::Dual;
use crate::linalg::{Symmetric, largest_eigenvalue};

/// The dual energy `1/2 lambda' Q lambda - h' lambda` of a contact problem, with `Q = B K⁻¹ Bᵀ` and
/// `h = -[gap - N u0; slip_reference - T u0]`, `u0` the displacement without contact forces; `v = Q lambda - h`.
///
/// The methods of the source paper take thousands of products, so `Q` is stored as a matrix unless it is too large.
#[derive(Debug)]
pub struct Quadratic<'a> {
    Q: Matrix<'a>,
    /// Length, `3m`; zero where `has_row` is false.
    pub h: Vec<f64>,
    /// False for an empty row of `B`, whose multiplier is zero; `3m`.
    pub has_row: Vec<bool>,
    /// The largest eigenvalue of `Q`, length per newton, to 1e-4 from below.
    pub largest: f64,
    products: Cell<usize>,
}

#[derive(Debug)]
enum Matrix<'a> {
    Stored(Symmetric),
    /// With an estimate of the diagonal of `Q` for preconditioners.
    Applied(&'a Dual, Vec<f64>),
}

/// Most rows for which `Q` is stored unless a number is given: 72 MB, formed in the time of as many products.
pub(super) const MOST_STORED: usize = 3000;
/// Relative accuracy of the largest eigenvalue: penalties are multiples of it.
const SHARP: f64 = 1e-4;
const LANCZOS_LIMIT: usize = 100;

impl<'a> Quadratic<'a> {
    /// Solves for `h`, forms `Q` column by column if it has at most 3000 rows, and estimates its norm.
    pub fn new(problem: &ContactProblem, dual: &'a Dual) -> Self {
        Quadratic::stored_up_to(MOST_STORED, problem, dual)
    }

    /// The same with `Q` stored if it has at most `most` rows.
    pub fn stored_up_to(most: usize, problem: &ContactProblem, dual: &'a Dual) -> Self {
        let size = 3 * problem.points();
        let has_row: Vec<bool> = (0..size).map(|i| problem.contact.B.row(i).1.iter().any(|&v| v != 0.0)).collect();
        let free = problem.gap_and_slip(&dual.displacement(problem, &vec![0.0; size]));
        let h = free.iter().zip(&has_row).map(|(v, &has_row)| if has_row { -v } else { 0.0 }).collect();
        let column = |j: usize| {
            let mut unit = vec![0.0; size];
            unit[j] = 1.0;
            if has_row[j] { dual.times(&unit) } else { vec![0.0; size] }
        };
        let matrix = if size <= most {
            Matrix::Stored(Symmetric::from_columns(size, column))
        } else {
            let stiffness = Dual::local_stiffness(problem);
            Matrix::Applied(dual, stiffness.iter().map(|&k| if k > 0.0 { 1.0 / k } else { 0.0 }).collect())
        };
        let mut quadratic = Quadratic { Q: matrix, h, has_row, largest: 0.0, products: Cell::new(0) };
        quadratic.largest = largest_eigenvalue(size, |x| quadratic.times(x), SHARP, LANCZOS_LIMIT).value;
        quadratic
    }

    /// Number of contact points.
    pub fn points(&self) -> usize {
        self.h.len() / 3
    }

    /// A number not below the largest eigenvalue of `Q`.
    pub fn largest_bound(&self) -> f64 {
        self.largest * (1.0 + SHARP)
    }

    /// `Q` times each of the vectors of length `3m` that stand one after the other in `x`.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let size = self.h.len().max(1);
        self.products.set(self.products.get() + x.len() / size);
        match &self.Q {
            Matrix::Stored(q) => q.times(x),
            Matrix::Applied(dual, _) => x.chunks_exact(size).flat_map(|x| self.applied(dual, x)).collect(),
        }
    }

    fn applied(&self, dual: &Dual, x: &[f64]) -> Vec<f64> {
        let masked: Vec<f64> =
            x.iter().zip(&self.has_row).map(|(x, &has_row)| if has_row { *x } else { 0.0 }).collect();
        dual.times(&masked)
    }

    /// Products with `Q` since it was formed; a product with part of its rows and columns counts as one.
    pub fn products(&self) -> usize {
        self.products.get()
    }

    /// Whether `Q` is stored as a matrix.
    pub fn is_stored(&self) -> bool {
        matches!(self.Q, Matrix::Stored(_))
    }

    /// `Q` in turned axes, `M Q Mᵀ`, where `M` is applied by `turn` and its transpose by `turn_back`; `None` if `Q` is
    /// not stored.
    pub(super) fn turned(&self, turn: &dyn Fn(&mut [f64]), turn_back: &dyn Fn(&mut [f64])) -> Option<Symmetric> {
        let Matrix::Stored(q) = &self.Q else { return None };
        let column = |j: usize| {
            let mut unit = vec![0.0; q.order];
            unit[j] = 1.0;
            turn_back(&mut unit);
            let mut column = vec![0.0; q.order];
            for (i, &weight) in unit.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                crate::linalg::axpy(weight, q.row(i), &mut column);
            }
            turn(&mut column);
            column
        };
        Some(Symmetric::from_columns(q.order, column))
    }

    /// A block of a matrix made by [`Quadratic::turned`] times `x`, counted as a product.
    pub(super) fn block_times(&self, of: &Symmetric, rows: Range<usize>, columns: Range<usize>, x: &[f64]) -> Vec<f64> {
        self.products.set(self.products.get() + 1);
        of.block_times(rows, columns, x)
    }

    /// `Q` among the three multipliers of point `j`; where `Q` is not stored, an estimate of
    /// its diagonal.
    pub(super) fn local(&self, j: usize) -> [[f64; 3]; 3] {
        let m = self.points();
        let rows = [j, m + j, 2 * m + j];
        match &self.Q {
            Matrix::Stored(q) => rows.map(|i| rows.map(|k| q.row(i)[k])),
            Matrix::Applied(_, diagonal) => {
                std::array::from_fn(|a| std::array::from_fn(|b| if a == b { diagonal[rows[a]] } else { 0.0 }))
            }
        }
    }
}
