use faer::Par;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::simplicial::EliminationTreeRef;
use faer::sparse::linalg::cholesky::supernodal::{
    SymbolicSupernodalCholesky, factorize_supernodal_numeric_llt, factorize_supernodal_numeric_llt_scratch,
    factorize_supernodal_symbolic_cholesky, factorize_supernodal_symbolic_cholesky_scratch,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};

use super::memory::REMEDY;
use super::stop::unless_stopped;
use super::symbolic::permuted;
use super::{NodeGraph, Plan, Stop, SymmetricCsr, Trailing, axpy, in_huge_pages, kernels, max_abs};
use crate::Error;

/// `P K Pᵀ = L Lᵀ`, `L` by supernodes: dense panels of columns that share their structure.
///
/// The arithmetic of the factorisation is faer's, single-threaded on purpose (its parallel kernels have open reports
/// of silent errors); the triangular solves are our own, with one right-hand side and, where only a few unknowns
/// matter, restricted to a [`Path`].
#[derive(Debug)]
pub struct Cholesky {
    plan: Plan,
    supernodes: SymbolicSupernodalCholesky<usize>,
    /// The panels from `first` on.
    values: Vec<f64>,
    first: usize,
}

/// Numbers of a cache line. Kernels treat what lies before the first whole one in another order, so that the last digits
/// of a factor would depend on where the allocator puts it.
const LINE: usize = 8;

/// The supernodes a solve has to visit when its right-hand side and the wanted part of its result are supported on
/// the same few unknowns: those holding the unknowns, and all their ancestors.
#[derive(Debug, Clone)]
pub struct Path {
    supernodes: Vec<u32>,
}

impl Cholesky {
    /// Factorises the symmetric positive definite `k` in the order of `plan`; `graph` is the graph `plan` was made of.
    ///
    /// A stop is heard within a twentieth of a second. The elimination itself cannot be left: it is abandoned on a thread of
    /// its own, where it takes a core and the memory of the factor until it ends.
    ///
    /// # Errors
    /// If `k` is not positive definite (the unknown with the failing pivot is named), or the factor does not solve
    /// a system to the accuracy a stable factorisation has. If it is stopped: [`Error::interrupted`].
    pub fn new(k: &SymmetricCsr, graph: &NodeGraph, plan: Plan, stop: &Stop) -> Result<Self, Error> {
        stop.check()?;
        let (pattern, entries) = {
            let (start, rows, entries) = permuted(k, graph, &plan);
            (SymbolicSparseColMat::new_checked(k.rows, k.rows, start, None, rows), entries)
        };
        stop.check()?;
        let supernodes = supernodes(pattern.as_ref(), &plan)?;
        stop.check()?;
        let (values, first, supernodes, failed) = unless_stopped(stop, eliminate(pattern, entries, supernodes)?)?;
        if let Some(place) = failed {
            let unknown = plan.unknown.get(place).copied().unwrap_or(0);
            return Err(not_positive_definite(unknown));
        }
        let factor = Cholesky { plan, supernodes, values, first };
        factor.verify(k)?;
        Ok(factor)
    }

    /// One system with a known right-hand side: a factor that is wrong anywhere shows here.
    fn verify(&self, k: &SymmetricCsr) -> Result<(), Error> {
        let b: Vec<f64> = (0..k.rows).map(|i| 1.0 + (i as f64 * 0.7).sin()).collect();
        let x = self.solve(&b);
        let mut residual = k.times(&x);
        axpy(-1.0, &b, &mut residual);
        let scale = 100.0 * k.max_abs() * max_abs(&x) + max_abs(&b);
        if max_abs(&residual) <= 1e-10 * scale {
            return Ok(());
        }
        let what = format!(
            "the Cholesky factor of the stiffness matrix is inaccurate (residual {:.1e} of its scale)",
            max_abs(&residual) / scale
        );
        Err(Error::new("", what, "the matrix is singular to working precision; is a body left floating?"))
    }

    fn panel(&self, s: usize) -> Panel<'_> {
        let symbolic = &self.supernodes;
        let pattern = symbolic.supernode(s).pattern();
        let first = symbolic.supernode_begin()[s];
        let columns = symbolic.supernode_end()[s] - first;
        let panels = &self.values[self.first..];
        let values = &panels[symbolic.col_ptr_for_val()[s]..symbolic.col_ptr_for_val()[s + 1]];
        Panel { first, columns, pattern, values }
    }

    /// `K⁻¹ b`.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let mut x: Vec<f64> = self.plan.unknown.iter().map(|&i| b[i as usize]).collect();
        let all = 0..self.supernodes.n_supernodes();
        let mut w = Vec::new();
        all.clone().for_each(|s| self.panel(s).forward(&mut x, &mut w));
        all.rev().for_each(|s| self.panel(s).backward(&mut x, &mut w));
        self.plan.position.iter().map(|&place| x[place as usize]).collect()
    }

    /// The path for right-hand sides and results on the given unknowns.
    pub fn path(&self, unknowns: &[u32]) -> Path {
        let count = self.supernodes.n_supernodes();
        let mut needed = vec![false; count];
        let of_place = |place: usize| self.supernodes.supernode_end().partition_point(|&end| end <= place);
        unknowns.iter().for_each(|&i| needed[of_place(self.plan.position[i as usize] as usize)] = true);
        for s in 0..count {
            // The parent of a supernode holds the first row below its columns; rows ascend.
            if let (true, Some(&row)) = (needed[s], self.panel(s).pattern.first()) {
                needed[of_place(row)] = true;
            }
        }
        Path { supernodes: (0..count as u32).filter(|&s| needed[s as usize]).collect() }
    }

    /// The entries of `K⁻¹ b` at `unknowns` for a `b` that vanishes elsewhere; `b` holds its values at `unknowns`,
    /// and `path` was made for them.
    pub fn solve_on(&self, path: &Path, unknowns: &[u32], b: &[f64]) -> Vec<f64> {
        let place = |&i: &u32| self.plan.position[i as usize] as usize;
        let (mut x, mut w) = (vec![0.0; self.plan.unknown.len()], Vec::new());
        unknowns.iter().zip(b).for_each(|(i, &b)| x[place(i)] = b);
        path.supernodes.iter().for_each(|&s| self.panel(s as usize).forward(&mut x, &mut w));
        path.supernodes.iter().rev().for_each(|&s| self.panel(s as usize).backward(&mut x, &mut w));
        unknowns.iter().map(|i| x[place(i)]).collect()
    }

    /// The trailing block of `L`, whose product with its transpose is the Schur complement of `K` on the unknowns
    /// that were ordered last.
    pub fn trailing(&self) -> Trailing {
        let n = self.plan.unknown.len();
        let (size, interior) = (self.plan.trailing, n - self.plan.trailing);
        let mut lower = in_huge_pages(vec![0.0; size * size]);
        for s in 0..self.supernodes.n_supernodes() {
            let panel = self.panel(s);
            let rows = panel.columns + panel.pattern.len();
            for c in interior.saturating_sub(panel.first)..panel.columns {
                let target = &mut lower[(panel.first + c - interior) * size..][..size];
                let source = &panel.values[c * rows..(c + 1) * rows];
                target[panel.first + c - interior..panel.first + panel.columns - interior]
                    .copy_from_slice(&source[c..panel.columns]);
                for (&row, &v) in panel.pattern.iter().zip(&source[panel.columns..]) {
                    target[row - interior] = v;
                }
            }
        }
        Trailing { unknowns: self.plan.unknown[interior..].to_vec(), lower }
    }
}

struct Panel<'a> {
    first: usize,
    columns: usize,
    pattern: &'a [usize],
    values: &'a [f64],
}

impl Panel<'_> {
    fn forward(&self, x: &mut [f64], w: &mut Vec<f64>) {
        w.clear();
        w.extend_from_slice(&x[self.first..self.first + self.columns]);
        w.resize(self.columns + self.pattern.len(), 0.0);
        kernels::forward(self.values, w.len(), self.columns, w);
        x[self.first..self.first + self.columns].copy_from_slice(&w[..self.columns]);
        self.pattern.iter().zip(&w[self.columns..]).for_each(|(&row, w)| x[row] += w);
    }

    fn backward(&self, x: &mut [f64], w: &mut Vec<f64>) {
        w.clear();
        w.extend_from_slice(&x[self.first..self.first + self.columns]);
        w.extend(self.pattern.iter().map(|&row| x[row]));
        kernels::backward(self.values, w.len(), self.columns, w);
        x[self.first..self.first + self.columns].copy_from_slice(&w[..self.columns]);
    }
}

fn supernodes(
    pattern: SymbolicSparseColMatRef<'_, usize>,
    plan: &Plan,
) -> Result<SymbolicSupernodalCholesky<usize>, Error> {
    let tree: Vec<isize> = plan.parent.iter().map(|&p| if p == u32::MAX { -1 } else { p as isize }).collect();
    let counts: Vec<usize> = plan.column_count.iter().map(|&c| c as usize).collect();
    // SAFETY: the tree is the elimination tree of `pattern`: each entry is -1 or a later column, as
    // `prefactorize_symbolic_cholesky` would fill it (a test compares the two).
    let tree = unsafe { EliminationTreeRef::from_inner(&tree) };
    let scratch = factorize_supernodal_symbolic_cholesky_scratch::<usize>(tree.len());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| out_of_memory())?;
    let stack = MemStack::new(&mut memory);
    factorize_supernodal_symbolic_cholesky(pattern, tree, &counts, stack, SymbolicSupernodalParams::default())
        .map_err(|_| out_of_memory())
}

/// The panels, the first of them, the supernodes, and the place whose pivot failed.
type Eliminated = (Vec<f64>, usize, SymbolicSupernodalCholesky<usize>, Option<usize>);

/// The elimination, to be run anywhere; all its memory is there before it begins.
fn eliminate(
    pattern: SymbolicSparseColMat<usize>,
    entries: Vec<f64>,
    supernodes: SymbolicSupernodalCholesky<usize>,
) -> Result<impl FnOnce() -> Eliminated + Send + 'static, Error> {
    let mut values = in_huge_pages(vec![0.0; supernodes.len_val() + LINE]);
    let first = values.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
    let scratch = factorize_supernodal_numeric_llt_scratch::<usize, f64>(&supernodes, Par::Seq, Default::default());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| out_of_memory())?;
    Ok(move || {
        let outcome = factorize_supernodal_numeric_llt(
            &mut values[first..first + supernodes.len_val()],
            SparseColMatRef::new(pattern.as_ref(), &entries),
            LltRegularization::default(),
            &supernodes,
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        let failed = outcome.err().map(|LltError::NonPositivePivot { index }| index);
        (values, first, supernodes, failed)
    })
}

fn out_of_memory() -> Error {
    Error::new("", "there is not enough memory for the Cholesky factor", REMEDY)
}

fn not_positive_definite(unknown: u32) -> Error {
    Error::new(
        "",
        format!("the stiffness matrix is not positive definite (pivot of unknown {unknown})"),
        "is a body left floating, or a material without stiffness?",
    )
}

#[cfg(test)]
mod tests {
    use faer::sparse::linalg::cholesky::simplicial::{
        prefactorize_symbolic_cholesky, prefactorize_symbolic_cholesky_scratch,
    };

    use super::*;
    use crate::linalg::{Csr, last, nested_dissection, plan};

    /// Two unknowns a node on an `n x n` grid of nodes: positive definite, not diagonally scaled.
    fn matrix(n: usize) -> (SymmetricCsr, Vec<u32>) {
        let node = |i: usize, j: usize| i * n + j;
        let mut entries = Vec::new();
        let mut couple = |a: usize, b: usize, v: f64| {
            for (p, q, s) in [(0, 0, 1.0), (1, 1, 2.0), (0, 1, 0.3), (1, 0, 0.3)] {
                entries.push((2 * a + p, 2 * b + q, s * v));
            }
        };
        for i in 0..n {
            for j in 0..n {
                couple(node(i, j), node(i, j), 4.1);
                for (a, b) in [(i + 1, j), (i, j + 1)] {
                    if a < n && b < n {
                        couple(node(i, j), node(a, b), -1.0);
                        couple(node(a, b), node(i, j), -1.0);
                    }
                }
            }
        }
        let unknowns = 2 * n * n;
        let full = Csr::from_triplets(unknowns, unknowns, &entries);
        (SymmetricCsr::from_full(&full, "K").unwrap(), (0..unknowns as u32).map(|i| i / 2).collect())
    }

    fn factor(n: usize, late: impl Fn(usize) -> bool) -> (SymmetricCsr, Cholesky) {
        let (k, node_of) = matrix(n);
        let graph = NodeGraph::of_symmetric(&k, Some(&node_of));
        let is_last: Vec<bool> = (0..graph.len()).map(late).collect();
        let trailing = is_last.iter().filter(|&&l| l).count();
        let plan = plan(&graph, &last(&nested_dissection(&graph), &is_last), trailing);
        let factor = Cholesky::new(&k, &graph, plan, &Stop::never()).unwrap();
        (k, factor)
    }

    fn residual(k: &SymmetricCsr, x: &[f64], b: &[f64]) -> f64 {
        let mut r = k.times(x);
        axpy(-1.0, b, &mut r);
        max_abs(&r)
    }

    #[test]
    fn the_plan_is_the_elimination_tree_with_its_counts() {
        let (k, node_of) = matrix(13);
        let graph = NodeGraph::of_symmetric(&k, Some(&node_of));
        let plan = plan(&graph, &nested_dissection(&graph), 0);
        let (start, rows, _) = permuted(&k, &graph, &plan);
        let pattern = SymbolicSparseColMatRef::new_checked(k.rows, k.rows, &start, None, &rows);
        let (mut tree, mut counts) = (vec![0isize; k.rows], vec![0usize; k.rows]);
        let scratch = prefactorize_symbolic_cholesky_scratch::<usize>(k.rows, rows.len());
        let mut memory = MemBuffer::new(scratch);
        prefactorize_symbolic_cholesky(&mut tree, &mut counts, pattern, MemStack::new(&mut memory));
        assert!(counts.iter().zip(&plan.column_count).all(|(&a, &b)| a == b as usize));
        assert!(tree.iter().zip(&plan.parent).all(|(&a, &b)| a == b as i32 as isize));
    }

    #[test]
    fn a_factor_solves_and_its_path_solves_the_same() {
        let (k, factor) = factor(17, |_| false);
        let mut b = vec![0.0; k.rows];
        let unknowns: Vec<u32> = (0..34).chain([100, 333]).collect();
        unknowns.iter().for_each(|&i| b[i as usize] = 1.0 + f64::from(i).sin());
        let x = factor.solve(&b);
        assert!(residual(&k, &x, &b) < 1e-12);
        let path = factor.path(&unknowns);
        assert!(path.supernodes.len() < factor.supernodes.n_supernodes());
        let on: Vec<f64> = unknowns.iter().map(|&i| b[i as usize]).collect();
        let part = factor.solve_on(&path, &unknowns, &on);
        assert!(part.iter().zip(&unknowns).all(|(p, &i)| (p - x[i as usize]).abs() < 1e-13));
    }

    #[test]
    fn the_trailing_block_is_the_inverse_of_the_compliance() {
        let (k, factor) = factor(12, |v| v % 12 < 2 || v == 77);
        let trailing = factor.trailing();
        assert_eq!(trailing.unknowns.len(), 50);
        let mut b = vec![0.0; k.rows];
        let on: Vec<f64> = trailing.unknowns.iter().map(|&i| f64::from(i).cos()).collect();
        trailing.unknowns.iter().zip(&on).for_each(|(&i, &v)| b[i as usize] = v);
        let x = factor.solve(&b);
        assert!(residual(&k, &x, &b) < 1e-12);
        let by_block = trailing.solve(&on);
        assert!(by_block.iter().zip(&trailing.unknowns).all(|(p, &i)| (p - x[i as usize]).abs() < 1e-13));
        let back = trailing.times(&by_block);
        assert!(back.iter().zip(&on).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn an_indefinite_matrix_is_refused_by_name() {
        let (mut k, node_of) = matrix(5);
        *k.entry_mut(20, 20).unwrap() = -1.0;
        let graph = NodeGraph::of_symmetric(&k, Some(&node_of));
        let plan = plan(&graph, &nested_dissection(&graph), 0);
        assert!(Cholesky::new(&k, &graph, plan, &Stop::never()).unwrap_err().what.contains("not positive definite"));
    }

    #[test]
    fn a_stop_reaches_each_stage_of_the_factorisation() {
        let (k, node_of) = matrix(40);
        let graph = NodeGraph::of_symmetric(&k, Some(&node_of));
        let plan = plan(&graph, &nested_dissection(&graph), 0);
        for questions in 0..3 {
            let found = Cholesky::new(&k, &graph, plan.clone(), &Stop::after(questions));
            assert!(found.unwrap_err().interrupted, "after {questions}");
        }
        let whole = Cholesky::new(&k, &graph, plan.clone(), &Stop::never()).unwrap();
        let other = Cholesky::new(&k, &graph, plan, &Stop::when(|| false)).unwrap();
        assert!(
            whole.values[whole.first..][..whole.supernodes.len_val()]
                == other.values[other.first..][..other.supernodes.len_val()]
        );
    }
}
