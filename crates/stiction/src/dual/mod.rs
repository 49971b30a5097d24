//! The dual operator `Q = B K⁻¹ Bᵀ`: what a contact force does to the jump. Knows no friction.

mod choice;
mod estimate;
mod floating;

use std::sync::atomic::{AtomicUsize, Ordering};

pub use choice::{Choice, DualSettings, Form, choose};
pub use estimate::{Estimate, estimate};
pub use floating::Floating;

use crate::Error;
use crate::contact::ContactProblem;
use crate::contact::rigid::components;
use crate::linalg::{Cholesky, Csr, Path, Trailing};

/// `Q` as an operator on `R^{3m}`, by a Cholesky factor of `K`.
#[derive(Debug)]
#[allow(non_snake_case)]
pub struct Dual {
    factor: Cholesky,
    /// The unknowns some row of `B` touches, in the order of the columns of `B_touched`.
    touched: Vec<u32>,
    B_touched: Csr,
    /// The block of `K` on the touched unknowns.
    K_touched: Csr,
    product: Product,
    /// `1 / |row|²` of `B`; zero for an empty row.
    row_scale: Vec<f64>,
    /// Bodies held by contact alone; `K⁻¹` stands for a generalised inverse then.
    pub floating: Floating,
    products: AtomicUsize,
    solves: AtomicUsize,
}

#[derive(Debug)]
enum Product {
    /// The Schur complement of `K` on the touched unknowns as a dense factor: products are two triangular solves.
    Dense(Trailing),
    /// Products by sparse solves.
    Solves(Path),
}

/// What stands for the Schur complement `S` of `K` on the touched unknowns in [`Dual::approximate_inverse`]; names
/// from the preconditioners of FETI (Farhat & Roux 1991; Farhat, Mandel & Roux 1994).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inverse {
    /// The block of `K`: an upper bound of `S` at the cost of a sparse product.
    Lumped,
    /// `S` itself where it is at hand, at the cost of a product with `Q`; otherwise as lumped.
    Dirichlet,
}

impl Dual {
    /// Factorises `K` in the order that was chosen. Where bodies float, `K` gets springs that carry nothing as long as
    /// forces are in balance ([`Floating`]).
    ///
    /// # Errors
    /// If `K` is singular beyond the rigid motions of its bodies, not positive or memory runs out.
    pub fn new(problem: &ContactProblem, choice: Choice) -> Result<Self, Error> {
        let Choice { form, graph, plan, touched, .. } = choice;
        let floating = Floating::new(problem);
        let factor = if floating.is_empty() {
            Cholesky::new(&problem.K, &graph, plan)?
        } else {
            Cholesky::new(&floating.held(&problem.K), &graph, plan)?
        };
        let (touched, product) = match form {
            Form::Dense => {
                let trailing = factor.trailing();
                (trailing.unknowns.clone(), Product::Dense(trailing))
            }
            Form::Solves | Form::Auto => {
                let path = factor.path(&touched);
                (touched, Product::Solves(path))
            }
        };
        let b_touched = problem.B.select_columns(&touched);
        let k_touched = problem.K.select_rows(&touched).select_columns(&touched);
        let row_scale = (0..b_touched.rows).map(|i| b_touched.row(i).1.iter().map(|v| v * v).sum::<f64>());
        let row_scale = row_scale.map(|s| if s > 0.0 { 1.0 / s } else { 0.0 }).collect();
        let (products, solves) = Default::default();
        Ok(Dual {
            factor,
            touched,
            B_touched: b_touched,
            K_touched: k_touched,
            product,
            row_scale,
            floating,
            products,
            solves,
        })
    }

    /// `Q lambda`, length `3m`.
    pub fn times(&self, lambda: &[f64]) -> Vec<f64> {
        self.products.fetch_add(1, Ordering::Relaxed);
        let force = self.B_touched.transpose_times(lambda);
        let displacement = match &self.product {
            Product::Dense(trailing) => trailing.solve(&force),
            Product::Solves(path) => self.factor.solve_on(path, &self.touched, &force),
        };
        self.B_touched.times(&displacement)
    }

    /// An approximation of `Q⁻¹ v`: `D B S Bᵀ D v` with `D = diag(B Bᵀ)⁻¹`.
    pub fn approximate_inverse(&self, v: &[f64], by: Inverse) -> Vec<f64> {
        let scaled: Vec<f64> = v.iter().zip(&self.row_scale).map(|(v, s)| v * s).collect();
        let jump = self.B_touched.transpose_times(&scaled);
        let force = match (&self.product, by) {
            (Product::Dense(trailing), Inverse::Dirichlet) => trailing.times(&jump),
            _ => self.K_touched.times(&jump),
        };
        let mut result = self.B_touched.times(&force);
        result.iter_mut().zip(&self.row_scale).for_each(|(r, s)| *r *= s);
        result
    }

    /// `K⁻¹ (f - Bᵀ lambda)`, length `n`; bodies that float are where their springs hold them.
    pub fn displacement(&self, problem: &ContactProblem, lambda: &[f64]) -> Vec<f64> {
        self.solves.fetch_add(1, Ordering::Relaxed);
        let mut force = problem.B.transpose_times(lambda);
        force.iter_mut().zip(&problem.f).for_each(|(b, f)| *b = f - *b);
        self.factor.solve(&force)
    }

    /// Products with `Q` so far.
    pub fn products(&self) -> usize {
        self.products.load(Ordering::Relaxed)
    }

    /// Solves with the whole of `K` so far.
    pub fn solves(&self) -> usize {
        self.solves.load(Ordering::Relaxed)
    }

    /// Numbers stored for the factor and, if dense, the Schur complement.
    pub fn stored(&self) -> usize {
        self.factor.len() + if matches!(self.product, Product::Dense(_)) { self.touched.len().pow(2) } else { 0 }
    }

    /// The local stiffness against the jump of each row of `B`; zero for an empty row. Force per length.
    ///
    /// On one body `(B K Bᵀ)_ii / |row|⁴`, an upper bound of `1 / Q_ii` on the diagonal of the Schur complement. The
    /// bodies of a row yield one after the other, so that their compliances add: the stiffness is that of the softer.
    pub fn local_stiffness(problem: &ContactProblem) -> Vec<f64> {
        let body = bodies(&problem.K);
        let mut dense = vec![0.0; problem.unknowns()];
        let mut compliance_of = |columns: &[u32], values: &[f64]| {
            let square: f64 = values.iter().map(|v| v * v).sum();
            columns.iter().zip(values).for_each(|(&j, &v)| dense[j as usize] = v);
            let product = |j: u32| {
                let (k, a) = problem.K.row(j as usize);
                k.iter().zip(a).map(|(&k, a)| a * dense[k as usize]).sum::<f64>()
            };
            let energy: f64 = columns.iter().zip(values).map(|(&j, v)| v * product(j)).sum();
            columns.iter().for_each(|&j| dense[j as usize] = 0.0);
            if energy > 0.0 { square * square / energy } else { 0.0 }
        };
        let mut row_stiffness = |i: usize| {
            let (columns, values) = problem.B.row(i);
            let mut parts: Vec<(u32, u32, f64)> =
                columns.iter().zip(values).map(|(&j, &v)| (body[j as usize], j, v)).collect();
            parts.sort_by_key(|part| part.0);
            let compliance: f64 = parts
                .chunk_by(|a, b| a.0 == b.0)
                .map(|part| {
                    let (columns, values): (Vec<u32>, Vec<f64>) = part.iter().map(|p| (p.1, p.2)).unzip();
                    compliance_of(&columns, &values)
                })
                .sum();
            if compliance > 0.0 { 1.0 / compliance } else { 0.0 }
        };
        (0..problem.B.rows).map(&mut row_stiffness).collect()
    }
}

/// The body of each unknown: the connected components of the graph of `K`.
#[allow(non_snake_case)]
fn bodies(K: &Csr) -> Vec<u32> {
    let mut body = vec![0; K.rows];
    for (number, unknowns) in components(K).iter().enumerate() {
        unknowns.iter().for_each(|&i| body[i as usize] = number as u32);
    }
    body
}
