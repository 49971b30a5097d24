use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::{matmul, triangular_solve};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, Par};

use super::{Csr, Plan, axpy};

/// `P A Pᵀ = L U` of a square matrix with a symmetric pattern, by fronts (Duff & Reid 1983).
///
/// Rows are exchanged only within a front's own columns: stable for matrices whose symmetric part is positive definite
/// or that are near to such ones. A caller with other matrices checks a residual.
#[derive(Debug)]
pub struct Lu {
    pub(super) position: Vec<u32>,
    pub(super) unknown: Vec<u32>,
    pub(super) fronts: Vec<Front>,
}

/// Eliminated columns that share their structure, as dense blocks by columns.
#[derive(Debug)]
pub(super) struct Front {
    pub first: usize,
    pub columns: usize,
    /// Places below the columns, ascending.
    pub rows: Vec<u32>,
    /// Row of the front that became the `k`-th pivot.
    pub pivot: Vec<u32>,
    /// `[L11 \ U11; L21]`, of `columns + rows` rows.
    pub left: Vec<f64>,
    /// `U12`, `columns` rows.
    pub right: Vec<f64>,
}

/// A front may hold this part of its entries that are zero but stored, since few large fronts are faster than many
/// small ones.
const PADDING: f64 = 0.2;
/// Fronts narrower than this are merged whatever it stores.
const NARROW: usize = 8;

impl Lu {
    /// Factorises `a` in the order of `plan`, which was made for the graph of `a`; `None` if a pivot is zero or
    /// not finite.
    pub fn new(a: &Csr, plan: &Plan) -> Option<Self> {
        let by_column = a.transpose();
        let n = a.rows;
        let mut lu =
            Lu { position: plan.position.clone(), unknown: plan.unknown.clone(), fronts: Vec::with_capacity(n / 8) };
        let mut local = vec![u32::MAX; n];
        // Schur complements that wait for the front that holds their first row.
        let mut waiting: Vec<(usize, Vec<f64>)> = Vec::new();
        let mut begin = 0;
        while begin < n {
            let end = end_of_front(plan, begin);
            let own = |places: &[u32]| places.first().is_some_and(|&p| (p as usize) < end);
            let split = waiting.iter().rposition(|(child, _)| !own(&lu.fronts[*child].rows)).map_or(0, |k| k + 1);
            let children = waiting.split_off(split);
            let rows = lu.structure(a, &by_column, begin, end, &children, &mut local);
            let size = end - begin + rows.len();
            let mut dense = vec![0.0; size * size];
            lu.gather(a, &by_column, begin, end, size, &local, &mut dense);
            for (child, schur) in &children {
                extend_add(&lu.fronts[*child].rows, schur, &local, size, &mut dense);
            }
            (begin..end).for_each(|p| local[p] = u32::MAX);
            rows.iter().for_each(|&p| local[p as usize] = u32::MAX);
            let (front, schur) = eliminate(begin, end - begin, rows, dense)?;
            if !front.rows.is_empty() {
                waiting.push((lu.fronts.len(), schur));
            }
            lu.fronts.push(front);
            begin = end;
        }
        Some(lu)
    }

    /// Places below `begin..end` that its front touches, ascending; `local` learns the numbers within the front.
    fn structure(
        &self,
        a: &Csr,
        by_column: &Csr,
        begin: usize,
        end: usize,
        children: &[(usize, Vec<f64>)],
        local: &mut [u32],
    ) -> Vec<u32> {
        let mut rows = Vec::new();
        let mut touch = |place: u32| {
            if place as usize >= end && local[place as usize] == u32::MAX {
                local[place as usize] = 0;
                rows.push(place);
            }
        };
        for place in begin..end {
            let i = self.unknown[place] as usize;
            for matrix in [a, by_column] {
                matrix.row(i).0.iter().for_each(|&j| touch(self.position[j as usize]));
            }
        }
        children.iter().for_each(|(child, _)| self.fronts[*child].rows.iter().for_each(|&p| touch(p)));
        rows.sort_unstable();
        (begin..end).for_each(|p| local[p] = (p - begin) as u32);
        rows.iter().enumerate().for_each(|(k, &p)| local[p as usize] = (end - begin + k) as u32);
        rows
    }

    /// Entries of `a` in the rows and columns of the front.
    #[allow(clippy::too_many_arguments)]
    fn gather(
        &self,
        a: &Csr,
        by_column: &Csr,
        begin: usize,
        end: usize,
        size: usize,
        local: &[u32],
        dense: &mut [f64],
    ) {
        for place in begin..end {
            let (i, k) = (self.unknown[place] as usize, place - begin);
            let (columns, values) = a.row(i);
            for (&j, &v) in columns.iter().zip(values) {
                let p = self.position[j as usize] as usize;
                if p >= begin {
                    dense[local[p] as usize * size + k] = v;
                }
            }
            for (j, v) in by_column.entries_of(i) {
                let p = self.position[j as usize] as usize;
                if p >= end {
                    dense[k * size + local[p] as usize] = v;
                }
            }
        }
    }

    /// `A⁻¹ b`.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let mut x: Vec<f64> = self.unknown.iter().map(|&i| b[i as usize]).collect();
        self.fronts.iter().for_each(|front| front.forward(&mut x));
        self.fronts.iter().rev().for_each(|front| front.backward(&mut x));
        self.position.iter().map(|&place| x[place as usize]).collect()
    }
}

/// Columns `begin..end` make one front: a chain of parents whose structures nest, with little padding.
fn end_of_front(plan: &Plan, begin: usize) -> usize {
    let n = plan.parent.len();
    let (mut end, mut entries) = (begin + 1, f64::from(plan.column_count[begin]));
    while end < n && plan.parent[end - 1] as usize == end {
        let width = end - begin + 1;
        let height = end - begin + plan.column_count[end] as usize;
        let stored = (width * height) as f64 - 0.5 * (width * (width - 1)) as f64;
        entries += f64::from(plan.column_count[end]);
        if width > NARROW && stored > (1.0 + PADDING) * entries {
            break;
        }
        end += 1;
    }
    end
}

/// Adds the Schur complement on the places `rows` to the front with the numbers `local`.
fn extend_add(rows: &[u32], schur: &[f64], local: &[u32], size: usize, dense: &mut [f64]) {
    for (&place, column) in rows.iter().zip(schur.chunks_exact(rows.len())) {
        let target = &mut dense[local[place as usize] as usize * size..][..size];
        rows.iter().zip(column).for_each(|(&row, v)| target[local[row as usize] as usize] += v);
    }
}

/// Eliminates the first columns of a front; the Schur complement on its rows comes back.
fn eliminate(first: usize, columns: usize, rows: Vec<u32>, mut dense: Vec<f64>) -> Option<(Front, Vec<f64>)> {
    let (size, below) = (columns + rows.len(), rows.len());
    let (mut pivot, mut inverse) = (vec![0u32; columns], vec![0u32; columns]);
    let mut memory = faer::dyn_stack::MemBuffer::try_new(lu_in_place_scratch::<u32, f64>(
        columns,
        columns,
        Par::Seq,
        Default::default(),
    ))
    .ok()?;
    let whole = MatMut::from_column_major_slice_mut(&mut dense, size, size);
    let (mut a11, a12, mut a21, mut a22) = whole.split_at_mut(columns, columns);
    let stack = faer::dyn_stack::MemStack::new(&mut memory);
    lu_in_place(a11.rb_mut(), &mut pivot, &mut inverse, Par::Seq, stack, Default::default());
    if (0..columns).any(|k| a11[(k, k)] == 0.0 || !a11[(k, k)].is_finite()) {
        return None;
    }
    let mut right = vec![0.0; columns * below];
    for j in 0..below {
        (0..columns).for_each(|k| right[j * columns + k] = a12[(pivot[k] as usize, j)]);
    }
    if below > 0 {
        let mut u12 = MatMut::from_column_major_slice_mut(&mut right, columns, below);
        triangular_solve::solve_unit_lower_triangular_in_place(a11.rb(), u12.rb_mut(), Par::Seq);
        let (u11, l21) = (a11.rb().transpose(), a21.rb_mut().transpose_mut());
        triangular_solve::solve_lower_triangular_in_place(u11, l21, Par::Seq);
        matmul::matmul(a22.rb_mut(), Accum::Add, a21.rb(), u12.rb(), -1.0, Par::Seq);
    }
    let mut schur = Vec::with_capacity(below * below);
    (columns..size).for_each(|j| schur.extend_from_slice(&dense[j * size + columns..(j + 1) * size]));
    dense.truncate(size * columns);
    Some((Front { first, columns, rows, pivot, left: dense, right }, schur))
}

impl Front {
    /// Number within the front of a place that it holds.
    pub(super) fn local(&self, place: usize) -> usize {
        if place < self.first + self.columns {
            return place - self.first;
        }
        self.columns + self.rows.binary_search(&(place as u32)).expect("the front holds the place")
    }

    fn forward(&self, x: &mut [f64]) {
        let (c, size) = (self.columns, self.columns + self.rows.len());
        let mut y: Vec<f64> = self.pivot.iter().map(|&p| x[self.first + p as usize]).collect();
        for k in 0..c {
            let yk = y[k];
            let column = &self.left[k * size..(k + 1) * size];
            axpy(-yk, &column[k + 1..c], &mut y[k + 1..]);
            self.rows.iter().zip(&column[c..]).for_each(|(&row, l)| x[row as usize] -= l * yk);
        }
        x[self.first..self.first + c].copy_from_slice(&y);
    }

    fn backward(&self, x: &mut [f64]) {
        let (c, size) = (self.columns, self.columns + self.rows.len());
        let (before, after) = x.split_at_mut(self.first + c);
        let y = &mut before[self.first..];
        for (&row, column) in self.rows.iter().zip(self.right.chunks_exact(c)) {
            axpy(-after[row as usize - self.first - c], column, y);
        }
        for k in (0..c).rev() {
            let column = &self.left[k * size..k * size + k + 1];
            y[k] /= column[k];
            let yk = y[k];
            axpy(-yk, &column[..k], &mut y[..k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{NodeGraph, max_abs, nested_dissection, plan};

    /// A convection-diffusion stencil on an `n x n` grid, unknowns in pairs.
    fn stencil(n: usize) -> Csr {
        let mut entries = Vec::new();
        for i in 0..n * n {
            let (x, y) = (i % n, i / n);
            for a in 0..2 {
                entries.push((2 * i + a, 2 * i + a, 4.5));
                entries.push((2 * i + a, 2 * i + 1 - a, if a == 0 { 0.7 } else { -0.4 }));
                for (u, v, w) in [(x + 1, y, -1.6), (x, y + 1, -0.9)] {
                    if u < n && v < n {
                        let j = v * n + u;
                        entries.push((2 * i + a, 2 * j + a, w));
                        entries.push((2 * j + a, 2 * i + a, -2.0 - w));
                    }
                }
            }
        }
        Csr::from_triplets(2 * n * n, 2 * n * n, &entries)
    }

    #[test]
    fn an_unsymmetric_system_is_solved_in_any_order() {
        let a = stencil(17);
        let labels: Vec<u32> = (0..a.rows as u32).map(|i| i / 2).collect();
        let graph = NodeGraph::new(&a, Some(&labels));
        let natural: Vec<u32> = (0..graph.len() as u32).collect();
        let wanted: Vec<f64> = (0..a.rows).map(|i| (i as f64).sin()).collect();
        let b = a.times(&wanted);
        for order in [natural, nested_dissection(&graph)] {
            let lu = Lu::new(&a, &plan(&graph, &order, 0)).unwrap();
            let mut x = lu.solve(&b);
            axpy(-1.0, &wanted, &mut x);
            assert!(max_abs(&x) < 1e-12, "{}", max_abs(&x));
        }
    }

    #[test]
    fn rows_are_exchanged_within_a_front_and_a_singular_matrix_is_refused() {
        let turn = Csr::from_triplets(2, 2, &[(0, 0, 0.0), (0, 1, 2.0), (1, 0, 3.0), (1, 1, 0.0)]);
        let graph = NodeGraph::new(&turn, None);
        let lu = Lu::new(&turn, &plan(&graph, &[0, 1], 0)).unwrap();
        assert_eq!(lu.solve(&[4.0, 9.0]), [3.0, 2.0]);
        let flat = Csr::from_triplets(2, 2, &[(0, 0, 1.0), (0, 1, 2.0), (1, 0, 2.0), (1, 1, 4.0)]);
        assert!(Lu::new(&flat, &plan(&graph, &[0, 1], 0)).is_none());
    }
}
