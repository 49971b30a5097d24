//! The dual operator `Q = B K⁻¹ Bᵀ`: what a contact force does to the jump. Knows no friction.

mod choice;
mod estimate;
mod floating;
mod memory;

use std::sync::atomic::{AtomicUsize, Ordering};

pub use choice::{Choice, DualSettings, Form, choose};
pub use estimate::{Estimate, estimate};
pub(crate) use estimate::{Neighbours, least_entries_of_box, least_entries_of_graph};
pub use floating::Floating;
pub(crate) use memory::least_bytes;

use crate::Error;
use crate::contact::ContactProblem;
use crate::contact::rigid::components;
use crate::linalg::{Cholesky, Csr, Path, Stop, SymmetricCsr, Trailing, axpy};

/// `Q` as an operator on `R^{3m}`, by a Cholesky factor of `K`.
#[derive(Debug)]
pub struct Dual {
    factor: Cholesky,
    /// The unknowns some row of `B` touches, in the order of the columns of `B_touched`.
    touched: Vec<u32>,
    B_touched: Csr,
    /// The block of `K` on the touched unknowns.
    K_touched: Csr,
    product: Product,
    /// `B_D` of [`Dual::approximate_inverse`], on the touched unknowns.
    B_shared: Csr,
    /// Bodies held by contact alone; `K⁻¹` stands for a generalised inverse then.
    pub floating: Floating,
    stop: Stop,
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
    /// forces are in balance ([`Floating`]). Where friction differs by direction `B` is that of the
    /// [isotropic problem](ContactProblem::isotropic).
    ///
    /// # Errors
    /// If `K` is singular beyond the rigid motions of its bodies, not positive or memory runs out. If it is stopped by what
    /// the choice was made with: [`Error::interrupted`].
    pub fn new(problem: &ContactProblem, choice: Choice) -> Result<Self, Error> {
        let Choice { form, graph, plan, touched, stop, .. } = choice;
        let floating = Floating::new(problem);
        let factor = if floating.is_empty() {
            Cholesky::new(&problem.elastic.K, &graph, plan, &stop)?
        } else {
            Cholesky::new(&floating.held(&problem.elastic.K), &graph, plan, &stop)?
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
        stop.check()?;
        let b_touched = problem.isotropic_rows().select_columns(&touched);
        let k_touched = problem.elastic.K.principal(&touched);
        let b_shared = shared(problem, &b_touched, &touched);
        let (products, solves) = Default::default();
        Ok(Dual {
            factor,
            touched,
            B_touched: b_touched,
            K_touched: k_touched,
            product,
            B_shared: b_shared,
            floating,
            stop,
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

    /// An approximation of `Q⁻¹ v`: `B_D S B_Dᵀ v`, where `B_Dᵀ` shares each jump out to the bodies by their compliance:
    /// the stiffer of two hardly moves, otherwise its stiffness would stand for that of both (Rixen & Farhat 1999).
    pub fn approximate_inverse(&self, v: &[f64], by: Inverse) -> Vec<f64> {
        let jump = self.B_shared.transpose_times(v);
        let force = match (&self.product, by) {
            (Product::Dense(trailing), Inverse::Dirichlet) => trailing.times(&jump),
            _ => self.K_touched.times(&jump),
        };
        self.B_shared.times(&force)
    }

    /// `K⁻¹ (f - Bᵀ lambda)` with `B` of `problem`, length `n`; bodies that float are where their springs hold them.
    pub fn displacement(&self, problem: &ContactProblem, lambda: &[f64]) -> Vec<f64> {
        self.solves.fetch_add(1, Ordering::Relaxed);
        let mut force = problem.contact.B.transpose_times(lambda);
        force.iter_mut().zip(&problem.elastic.f).for_each(|(b, f)| *b = f - *b);
        self.factor.solve(&force)
    }

    /// What the multipliers `lambda` add to the displacements, `-K⁻¹ Bᵀ lambda`, length `n`.
    pub fn response(&self, problem: &ContactProblem, lambda: &[f64]) -> Vec<f64> {
        self.solves.fetch_add(1, Ordering::Relaxed);
        let force: Vec<f64> = problem.contact.B.transpose_times(lambda).iter().map(|b| -b).collect();
        self.factor.solve(&force)
    }

    /// Improves `u`, a [displacement](Self::displacement) under `lambda`, by a step of iterative refinement with the residual
    /// in twice the precision (Wilkinson 1963): the compliance of a slender body turns the rounding of its factor into
    /// displacements that contact notices.
    pub fn refine(&self, problem: &ContactProblem, lambda: &[f64], u: &mut [f64]) {
        self.solves.fetch_add(1, Ordering::Relaxed);
        let contact = problem.contact.B.transpose_times(lambda);
        let mut force: Vec<f64> = problem.elastic.f.iter().zip(contact).map(|(f, b)| f - b).collect();
        self.floating.springs.iter().for_each(|&(i, stiffness)| force[i as usize] -= stiffness * u[i as usize]);
        axpy(1.0, &self.factor.solve(&problem.elastic.K.residual(&force, u)), u);
    }

    /// Whether products use the dense Schur complement.
    pub fn is_dense(&self) -> bool {
        matches!(self.product, Product::Dense(_))
    }

    /// What ends linear systems with the operator.
    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    /// Products with `Q` so far.
    pub fn products(&self) -> usize {
        self.products.load(Ordering::Relaxed)
    }

    /// Solves with the whole of `K` so far.
    pub fn solves(&self) -> usize {
        self.solves.load(Ordering::Relaxed)
    }

    /// The local stiffness against the jump of each row of `B`; zero for an empty row. Force per length.
    ///
    /// On one body `(B K Bᵀ)_ii / |row|⁴`, an upper bound of the diagonal of the Schur complement. Between bodies the
    /// compliances add, as those of springs in a row do: the stiffness is about that of the softer.
    pub fn local_stiffness(problem: &ContactProblem) -> Vec<f64> {
        let body = bodies(&problem.elastic.K);
        let compliance = |part: &[Entry]| {
            let square: f64 = part.iter().map(|e| e.value * e.value).sum();
            let product = |a: &Entry| -> f64 {
                part.iter().map(|b| problem.elastic.K.entry(a.column as usize, b.column as usize) * b.value).sum()
            };
            let energy: f64 = part.iter().map(|e| e.value * product(e)).sum();
            if energy > 0.0 { square * square / energy } else { 0.0 }
        };
        let row_stiffness = |i: usize| {
            let entries = entries_by_body(&problem.contact.B, i, |j| body[j as usize]);
            let compliance: f64 = entries.chunk_by(|a, b| a.body == b.body).map(compliance).sum();
            if compliance > 0.0 { 1.0 / compliance } else { 0.0 }
        };
        (0..problem.contact.B.rows).map(row_stiffness).collect()
    }
}

/// One entry of a row of `B`.
struct Entry {
    body: u32,
    column: u32,
    value: f64,
}

/// Row `i` sorted by bodies.
fn entries_by_body(b: &Csr, i: usize, body: impl Fn(u32) -> u32) -> Vec<Entry> {
    let (columns, values) = b.row(i);
    let mut entries: Vec<Entry> =
        columns.iter().zip(values).map(|(&column, &value)| Entry { body: body(column), column, value }).collect();
    entries.sort_by_key(|e| e.body);
    entries
}

/// The body of each unknown: the connected components of the graph of `K`.
fn bodies(K: &SymmetricCsr) -> Vec<u32> {
    let mut body = vec![0; K.rows];
    for (number, unknowns) in components(K).iter().enumerate() {
        unknowns.iter().for_each(|&i| body[i as usize] = number as u32);
    }
    body
}

/// The rows `b` of `B` on the `touched` unknowns, the part on each body times its compliance (over the mean of the
/// diagonal of `K` there) and all of it such that `B_D Bᵀ` has ones on its diagonal. On one body `b / |b|²`.
fn shared(problem: &ContactProblem, b: &Csr, touched: &[u32]) -> Csr {
    let body = bodies(&problem.elastic.K);
    let mut shared = b.clone();
    for i in 0..b.rows {
        let entries = entries_by_body(b, i, |j| body[touched[j as usize] as usize]);
        let mut weight = Vec::new(); // body, square of its part, compliance
        for part in entries.chunk_by(|a, b| a.body == b.body) {
            let square: f64 = part.iter().map(|e| e.value * e.value).sum();
            let diagonal = |e: &Entry| problem.elastic.K.diagonal(touched[e.column as usize] as usize);
            let energy: f64 = part.iter().map(|e| e.value * e.value * diagonal(e)).sum();
            weight.push((part[0].body, square, if energy > 0.0 { square / energy } else { 0.0 }));
        }
        let whole: f64 = weight.iter().map(|(_, square, compliance)| square * compliance).sum();
        for at in b.start[i]..b.start[i + 1] {
            let own = body[touched[b.column[at] as usize] as usize];
            let compliance = weight.iter().find(|w| w.0 == own).map_or(0.0, |w| w.2);
            shared.value[at] *= if whole > 0.0 { compliance / whole } else { 0.0 };
        }
    }
    shared
}
