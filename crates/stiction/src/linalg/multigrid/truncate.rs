use super::Multigrid;
use super::blocks::{Block, Blocks};
use super::coarsen::Coarser;
use super::dense::{add_product, add_transpose_product, inverse_of_rest, inverse_on};
use super::following::{Following, following};
use super::packed::{Packed, double, single};
use super::smoother::Level;
use crate::linalg::multigrid::bottom::Bottom;

/// What is constrained at a node: components held at their value, and a stiffness added to its diagonal block
/// (positive semidefinite, on components that are free).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Condition {
    pub held: [bool; 3],
    pub spring: Block<3, 3>,
    /// What the rows of the second and third component lose of the row of the first, which is held: a force on them that
    /// grows with what holds the first.
    pub follows: [f64; 2],
}

/// What local changes of the hierarchy need: everything about the nodes that may be constrained, and the matrices of
/// all levels without constraints.
///
/// Held components are truncated from the finest prolongation (Kornhuber 1997; Graeser & Kornhuber 2009). With `S` the
/// projector on them the coarse matrix `Pᵀ (I - S)(A + spring)(I - S) P` is the one without constraints plus
/// `Pᵀ (S A S + spring) P - G - Gᵀ`, `G = Pᵀ S A P`, which is supported near the constrained nodes.
#[derive(Debug, Clone, Default)]
pub(super) struct Local {
    nodes: Vec<u32>,
    diagonal: Vec<Block<3, 3>>,
    /// Couplings of the nodes among themselves, by their places in `nodes`.
    among: Blocks<3, 3>,
    /// Rows of `P` and `A P` at the nodes.
    pub p: Blocks<3, 6>,
    a_times_p: Blocks<3, 6>,
    p_columns: Columns,
    a_times_p_columns: Columns,
    /// Coarse nodes whose rows may change, by coarse level, the bottom last.
    pub touched: Vec<Vec<u32>>,
    /// Values of the touched rows without constraints, one row after the other, by coarse level.
    pub free: Vec<Vec<Block<6, 6>>>,
    bottom: Blocks<6, 6>,
}

/// For each column the rows that hold it, with the places of the blocks.
pub(super) type Columns = (Vec<usize>, Vec<(u32, u32)>);

impl Local {
    pub fn new(a: &Blocks<3, 3>, step: &Coarser<3>, nodes: &[u32]) -> Self {
        let mut place = vec![u32::MAX; a.rows];
        nodes.iter().enumerate().for_each(|(k, &v)| place[v as usize] = k as u32);
        let others = |k: usize, name: &mut dyn FnMut(u32)| {
            let own = a.row(nodes[k] as usize).0.iter().map(|&j| place[j as usize]);
            own.filter(|&p| p != u32::MAX).for_each(name);
        };
        let among = Blocks::from_rows(nodes.len(), nodes.len(), others, |k, row| {
            let (columns, blocks) = a.row(nodes[k] as usize);
            for (&j, block) in columns.iter().zip(blocks) {
                if place[j as usize] != u32::MAX {
                    *row.at(place[j as usize]) = *block;
                }
            }
        });
        let all = |k: usize, name: &mut dyn FnMut(u32)| {
            step.prolongation.row(nodes[k] as usize).0.iter().for_each(|&j| name(j));
        };
        let p = Blocks::from_rows(nodes.len(), step.prolongation.cols, all, |k, row| {
            let (columns, blocks) = step.prolongation.row(nodes[k] as usize);
            columns.iter().zip(blocks).for_each(|(&j, block)| *row.at(j) = *block);
        });
        let a_times_p = step.a_times_p.clone();
        let (p_columns, a_times_p_columns) = (p.by_columns(), a_times_p.by_columns());
        let diagonal = nodes.iter().map(|&v| a.diagonal(v as usize)).collect();
        let mut touched = [a_times_p.column.as_slice(), &p.column].concat();
        touched.sort_unstable();
        touched.dedup();
        let (free, bottom) = Default::default();
        let (nodes, touched) = (nodes.to_vec(), vec![touched]);
        Local { nodes, diagonal, among, p, a_times_p, p_columns, a_times_p_columns, touched, free, bottom }
    }

    /// The next coarser level stands: where changes of this one reach there, and its matrix without constraints.
    pub fn add_level(&mut self, matrix: &Blocks<6, 6>, prolongation: &Packed<6, 6>) {
        let here = &self.touched[self.touched.len() - 1];
        let mut next: Vec<u32> = here.iter().flat_map(|&i| prolongation.row(i as usize).0).copied().collect();
        next.sort_unstable();
        next.dedup();
        self.free.push(here.iter().flat_map(|&i| matrix.row(i as usize).1).copied().collect());
        self.touched.push(next);
    }

    /// Contact nodes in the support of a node of the first coarse level, by their places in `nodes`, and their blocks of `P`.
    pub fn p_column(&self, k: u32) -> impl Iterator<Item = (usize, &Block<3, 6>)> {
        column(&self.p_columns, &self.p, k)
    }

    /// The same of `A P`.
    pub fn a_times_p_column(&self, k: u32) -> impl Iterator<Item = (usize, &Block<3, 6>)> {
        column(&self.a_times_p_columns, &self.a_times_p, k)
    }

    pub fn set_bottom(&mut self, bottom: Blocks<6, 6>) {
        self.bottom = bottom;
    }
}

/// The rows with a block in column `k`, and the blocks.
fn column<'a>(columns: &'a Columns, of: &'a Blocks<3, 6>, k: u32) -> impl Iterator<Item = (usize, &'a Block<3, 6>)> {
    let (start, entry) = columns;
    let own = &entry[start[k as usize]..start[k as usize + 1]];
    own.iter().map(|&(i, place)| (i as usize, &of.value[place as usize]))
}

impl Multigrid {
    /// Constrains the nodes the hierarchy was made for, one condition each in their order. The finest level follows
    /// at once; the coarse levels only if `coarse` is true (they may lag a few changes behind).
    pub fn constrain(&mut self, conditions: &[Condition], coarse: bool) {
        let local = &self.local;
        for ((condition, &v), block) in conditions.iter().zip(&local.nodes).zip(&local.diagonal) {
            let mut diagonal = *block;
            diagonal.iter_mut().flatten().zip(condition.spring.iter().flatten()).for_each(|(d, s)| *d += s);
            let symmetric = inverse_on(&diagonal, &condition.held.map(|h| !h));
            self.fine.inverse[v as usize] = single(&following(&symmetric, &diagonal, condition.follows));
        }
        self.follows.clear();
        let rows = conditions.iter().zip(&local.nodes).filter(|(c, _)| c.follows != [0.0; 2]);
        self.follows.extend(rows.map(|(c, &v)| (v, c.follows.map(|f| f as f32))));
        self.held.clear();
        self.held.extend(
            conditions.iter().zip(&local.nodes).filter(|(c, _)| c.held != [false; 3]).map(|(c, &v)| (v, c.held)),
        );
        if coarse {
            self.update_coarse(conditions);
        }
    }

    fn update_coarse(&mut self, conditions: &[Condition]) {
        let local = &self.local;
        let change = local.change(conditions, self.first_coarse());
        self.change_coarse(0, change);
        self.follow(conditions);
    }

    /// The matrix of a coarse level without constraints.
    pub(super) fn without_constraints(&self, level: usize) -> Blocks<6, 6> {
        let Some(Level { matrix, .. }) = self.coarse.get(level) else { return self.local.bottom.clone() };
        let mut value: Vec<Block<6, 6>> = matrix.value.iter().map(double).collect();
        let mut free = self.local.free[level].iter();
        for &i in &self.local.touched[level] {
            let own = matrix.start[i as usize]..matrix.start[i as usize + 1];
            value[own].iter_mut().zip(&mut free).for_each(|(value, free)| *value = *free);
        }
        let (start, column) = (matrix.start.clone(), matrix.column.clone());
        Blocks { rows: matrix.rows, cols: matrix.rows, start, column, value }
    }

    /// Makes the matrices of the coarse levels those without constraints, changed on one level by rows for its touched
    /// nodes and on the ones below by what comes of that there. Nothing follows any more.
    pub(super) fn change_coarse(&mut self, from: usize, mut change: Blocks<6, 6>) {
        self.following = Following::default();
        let local = &self.local;
        for (k, level) in self.coarse.iter_mut().enumerate().skip(from) {
            let rows = &local.touched[k];
            let mut free = local.free[k].as_slice();
            for (t, &i) in rows.iter().enumerate() {
                let i = i as usize;
                let start = level.matrix.start[i];
                let own = level.matrix.row(i).0;
                let (before, rest) = free.split_at(own.len());
                free = rest;
                let mut now = before.to_vec();
                let (columns, blocks) = change.row(t);
                let mut place = 0;
                for (j, block) in columns.iter().zip(blocks) {
                    // Columns ascend in both, and the change lies within the pattern.
                    place += own[place..].partition_point(|column| column < j);
                    if own.get(place) == Some(j) {
                        now[place].iter_mut().flatten().zip(block.iter().flatten()).for_each(|(a, d)| *a += d);
                    }
                }
                if let Ok(place) = own.binary_search(&(i as u32)) {
                    level.inverse[i] = single(&inverse_of_rest(&now[place], &before[place]));
                }
                let values = &mut level.matrix.value[start..start + now.len()];
                values.iter_mut().zip(&now).for_each(|(value, now)| *value = single(now));
            }
            let prolongation = &self.further[k];
            change = coarser_change(&change, rows, prolongation, &local.touched[k + 1]);
        }
        let mut bottom = local.bottom.clone();
        for (t, &i) in local.touched[self.coarse.len()].iter().enumerate() {
            let (columns, blocks) = change.row(t);
            for (&j, block) in columns.iter().zip(blocks) {
                if let Some(place) = bottom.place(i as usize, j as usize) {
                    let target = bottom.value[place].iter_mut().flatten();
                    target.zip(block.iter().flatten()).for_each(|(a, d)| *a += d);
                }
            }
        }
        self.bottom = Bottom::new(&bottom);
    }
}

impl Local {
    /// The change of the first coarse matrix under the conditions: a row for each of its touched nodes.
    pub fn change(&self, conditions: &[Condition], cols: usize) -> Blocks<6, 6> {
        // Row i of (S A S + spring) P - S A P.
        let reached = |i: usize, name: &mut dyn FnMut(u32)| {
            if conditions[i] != Condition::default() {
                self.a_times_p.row(i).0.iter().for_each(|&j| name(j));
                // Relative displacements reach coarse nodes that the rows of `A P` do not.
                let near = self.among.row(i).0.iter();
                near.for_each(|&k| self.p.row(k as usize).0.iter().for_each(|&j| name(j)));
            }
        };
        let inner: Blocks<3, 6> = Blocks::from_rows(self.nodes.len(), cols, reached, |i, row| {
            let condition = &conditions[i];
            let (columns, blocks) = self.p.row(i);
            if condition.spring != [[0.0; 3]; 3] {
                columns.iter().zip(blocks).for_each(|(&j, p)| add_product(&condition.spring, p, row.at(j)));
            }
            if condition.held == [false; 3] {
                return;
            }
            let (columns, blocks) = self.among.row(i);
            for (&k, a) in columns.iter().zip(blocks) {
                let other = conditions[k as usize].held;
                if other == [false; 3] {
                    continue;
                }
                let held = |r: usize, c: usize| if condition.held[r] && other[c] { a[r][c] } else { 0.0 };
                let part = std::array::from_fn(|r| std::array::from_fn(|c| held(r, c)));
                let (columns, blocks) = self.p.row(k as usize);
                columns.iter().zip(blocks).for_each(|(&j, p)| add_product(&part, p, row.at(j)));
            }
            let (columns, blocks) = self.a_times_p.row(i);
            for (&j, block) in columns.iter().zip(blocks) {
                let target = row.at(j);
                for r in (0..3).filter(|&r| condition.held[r]) {
                    (0..6).for_each(|c| target[r][c] -= block[r][c]);
                }
            }
        });
        let touched = &self.touched[0];
        let reached = |t: usize, name: &mut dyn FnMut(u32)| {
            let k = touched[t];
            let mut near = |i: usize, of: &Blocks<3, 6>| of.row(i).0.iter().for_each(|&j| name(j));
            self.p_column(k).for_each(|(i, _)| near(i, &inner));
            let held = self.a_times_p_column(k).filter(|&(i, _)| conditions[i].held != [false; 3]);
            held.for_each(|(i, _)| near(i, &self.p));
        };
        Blocks::from_rows(touched.len(), cols, reached, |t, row| {
            let k = touched[t];
            for (i, p) in self.p_column(k) {
                let (columns, blocks) = inner.row(i);
                columns.iter().zip(blocks).for_each(|(&j, block)| add_transpose_product(p, block, row.at(j)));
            }
            for (i, part) in self.a_times_p_column(k) {
                let held = conditions[i].held;
                if held == [false; 3] {
                    continue;
                }
                let mut part = *part;
                (0..3).for_each(|r| part[r] = if held[r] { part[r].map(|v| -v) } else { [0.0; 6] });
                let (columns, blocks) = self.p.row(i);
                columns.iter().zip(blocks).for_each(|(&j, p)| add_transpose_product(&part, p, row.at(j)));
            }
        })
    }
}

/// `Pᵀ D P` for a change `D` with the rows `rows`: a row for each of the coarser nodes `touched`.
pub fn coarser_change(change: &Blocks<6, 6>, rows: &[u32], p: &Packed<6, 6>, touched: &[u32]) -> Blocks<6, 6> {
    let cols = touched.iter().chain(&p.column).map(|&j| j as usize + 1).max().unwrap_or(0);
    let reached = |t: usize, name: &mut dyn FnMut(u32)| {
        change.row(t).0.iter().for_each(|&j| p.row(j as usize).0.iter().for_each(|&k| name(k)));
    };
    let right: Blocks<6, 6> = Blocks::from_rows(rows.len(), cols, reached, |t, row| {
        let (columns, blocks) = change.row(t);
        for (&j, d) in columns.iter().zip(blocks) {
            let (coarse, values) = p.row(j as usize);
            coarse.iter().zip(values).for_each(|(&k, value)| add_product(d, &double(value), row.at(k)));
        }
    });
    let mut by_column: Vec<Vec<(u32, Block<6, 6>)>> = vec![Vec::new(); cols];
    for (t, &i) in rows.iter().enumerate() {
        let (coarse, values) = p.row(i as usize);
        coarse.iter().zip(values).for_each(|(&k, value)| by_column[k as usize].push((t as u32, double(value))));
    }
    let reached = |k: usize, name: &mut dyn FnMut(u32)| {
        let above = by_column[touched[k] as usize].iter();
        above.for_each(|(t, _)| right.row(*t as usize).0.iter().for_each(|&j| name(j)));
    };
    Blocks::from_rows(touched.len(), cols, reached, |k, row| {
        for (t, value) in &by_column[touched[k] as usize] {
            let (columns, blocks) = right.row(*t as usize);
            columns.iter().zip(blocks).for_each(|(&j, b)| add_transpose_product(value, b, row.at(j)));
        }
    })
}
