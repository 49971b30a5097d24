use std::ops::Range;

use rayon::prelude::*;

use crate::linalg::pattern::{Pattern, ROWS_PER_TASK, piece, tasks, with_room};
use crate::linalg::{NodeGraph, SymmetricCsr, in_huge_pages, vectorised};

/// A dense block, by rows.
pub(crate) type Block<const R: usize, const C: usize> = [[f64; C]; R];

/// A sparse matrix of dense blocks by compressed rows; columns ascend in each row and are unique.
#[derive(Debug, Clone, Default)]
pub(crate) struct Blocks<const R: usize, const C: usize> {
    /// Number of rows of blocks.
    pub rows: usize,
    /// Number of columns of blocks.
    pub cols: usize,
    /// Row `i` occupies `start[i]..start[i + 1]`.
    pub start: Vec<usize>,
    /// Column of each block.
    pub column: Vec<u32>,
    /// The blocks.
    pub value: Vec<Block<R, C>>,
}

/// Appends `more` values `x`.
pub(super) fn grow<T: Copy>(array: &mut Vec<T>, more: usize, x: T) {
    let length = array.len() + more;
    if array.capacity() < length {
        let mut larger = in_huge_pages(Vec::with_capacity(length));
        larger.extend_from_slice(array);
        *array = larger;
    }
    array.resize(length, x);
}

/// The values of the rows of each of `tasks`, which ascend; `value` has those from the first of these rows on.
pub(super) fn by_tasks<'a, T>(
    start: &[usize],
    tasks: &[Range<usize>],
    value: &'a mut [T],
) -> Vec<(Range<usize>, &'a mut [T])> {
    let (mut slices, mut rest) = (Vec::with_capacity(tasks.len()), value);
    let mut place = tasks.first().map_or(0, |rows| start[rows.start]);
    for rows in tasks {
        let (own, tail) = rest[start[rows.start] - place..].split_at_mut(start[rows.end] - start[rows.start]);
        slices.push((rows.clone(), own));
        (rest, place) = (tail, start[rows.end]);
    }
    slices
}

impl Pattern {
    /// A zero block for each place.
    pub(super) fn zeros<const R: usize, const C: usize>(&self) -> Vec<Block<R, C>> {
        let mut value = in_huge_pages(vec![[[0.0; C]; R]; with_room(self.column.len())]);
        value.truncate(self.column.len());
        value
    }

    /// Runs `fill` on each row of `tasks`, which ascend; `value` has the blocks from the first of these rows on.
    ///
    /// `fill` has to be `#[inline(always)]`, so that it is compiled for the vector instructions of the machine at hand.
    pub(super) fn fill<const R: usize, const C: usize>(
        &self,
        tasks: &[Range<usize>],
        cols: usize,
        value: &mut [Block<R, C>],
        fill: impl Fn(usize, &mut Row<'_, R, C>) + Sync,
    ) {
        let Pattern { start, column } = self;
        let slices = by_tasks(start, tasks, value);
        let at_once = piece(slices.len());
        slices.into_par_iter().with_max_len(at_once).for_each_init(
            || vec![0u32; cols],
            |slot, (rows, slice)| {
                let base = start[rows.start];
                vectorised(
                    #[inline(always)]
                    || {
                        for i in rows.clone() {
                            let columns = &column[start[i]..start[i + 1]];
                            let values = &mut slice[start[i] - base..start[i + 1] - base];
                            fill(i, &mut Row::new(slot, columns, values));
                        }
                    },
                );
            },
        );
    }
}

impl<const R: usize, const C: usize> Blocks<R, C> {
    /// The first `rows` rows, whose columns are below `cols`.
    pub(super) fn truncated(mut self, rows: usize, cols: usize) -> Self {
        if rows == 0 {
            return Blocks { cols, start: vec![0], ..Blocks::default() };
        }
        let entries = self.start[rows];
        self.start.truncate(rows + 1);
        (self.rows, self.cols) = (rows, cols);
        self.column.truncate(entries);
        self.value.truncate(entries);
        self
    }

    /// Columns and blocks of row `i`.
    pub(crate) fn row(&self, i: usize) -> (&[u32], &[Block<R, C>]) {
        let range = self.start[i]..self.start[i + 1];
        (&self.column[range.clone()], &self.value[range])
    }

    /// Column and block of every place in row `i`.
    pub(crate) fn entries_of(&self, i: usize) -> impl Iterator<Item = (u32, &Block<R, C>)> {
        let (columns, blocks) = self.row(i);
        columns.iter().copied().zip(blocks)
    }

    /// The place of block `(i, j)` among the values, if it is stored.
    pub(crate) fn place(&self, i: usize, j: usize) -> Option<usize> {
        let (columns, _) = self.row(i);
        columns.binary_search(&(j as u32)).ok().map(|k| self.start[i] + k)
    }

    /// `A x`.
    pub(crate) fn times(&self, x: &[[f64; C]]) -> Vec<[f64; R]> {
        let mut y = vec![[0.0; R]; self.rows];
        y.par_chunks_mut(ROWS_PER_TASK).enumerate().for_each(|(task, y)| {
            vectorised(
                #[inline(always)]
                || {
                    for (k, y) in y.iter_mut().enumerate() {
                        let own = self.start[task * ROWS_PER_TASK + k]..self.start[task * ROWS_PER_TASK + k + 1];
                        // Entries add up each for itself, so that no addition waits for the one before.
                        let mut sums = [[0.0; C]; R];
                        for (&j, a) in self.column[own.clone()].iter().zip(&self.value[own]) {
                            let x = &x[j as usize];
                            for r in 0..R {
                                for c in 0..C {
                                    sums[r][c] += a[r][c] * x[c];
                                }
                            }
                        }
                        for r in 0..R {
                            for c in 0..C {
                                y[r] += sums[r][c];
                            }
                        }
                    }
                },
            );
        });
        y
    }

    /// A matrix whose row `i` has the columns that `columns` names (in any order, repeated or not) and the values that
    /// `fill` accumulates in its zeroed blocks. Rows are computed in parallel, each by one thread, in place: at this size
    /// copies and fresh pages cost more than the arithmetic.
    pub(super) fn from_rows(
        rows: usize,
        cols: usize,
        columns: impl Fn(usize, &mut dyn FnMut(u32)) + Sync,
        fill: impl Fn(usize, &mut Row<'_, R, C>) + Sync,
    ) -> Blocks<R, C> {
        let pattern = Pattern::new(rows, cols, columns);
        let mut value = pattern.zeros();
        pattern.fill(&tasks(0..rows), cols, &mut value, fill);
        let Pattern { start, column } = pattern;
        Blocks { rows, cols, start, column, value }
    }

    /// Replaces `rows`, which ascend and none of which gets shorter, by the rows of `new`. The others move up within the same
    /// memory: a second matrix of this size would cost more than the arithmetic on a few rows.
    pub(super) fn replace_rows(&mut self, rows: &[u32], new: &Blocks<R, C>) {
        let mut end = self.column.len();
        let grown = |t: usize, i: usize| new.row(t).0.len() - self.row(i).0.len();
        let mut shift: usize = rows.iter().enumerate().map(|(t, &i)| grown(t, i as usize)).sum();
        grow(&mut self.column, shift, 0);
        grow(&mut self.value, shift, [[0.0; C]; R]);
        let mut after = self.rows;
        for (t, &i) in rows.iter().enumerate().rev() {
            let i = i as usize;
            let (from, to) = (self.start[i], self.start[i + 1]);
            self.column.copy_within(to..end, to + shift);
            self.value.copy_within(to..end, to + shift);
            self.start[i + 1..=after].iter_mut().for_each(|start| *start += shift);
            let (columns, blocks) = new.row(t);
            shift -= columns.len() - (to - from);
            self.column[from + shift..][..columns.len()].copy_from_slice(columns);
            self.value[from + shift..][..columns.len()].copy_from_slice(blocks);
            (end, after) = (from, i);
        }
    }

    /// The pattern of the transpose of the first `rows` rows: for each column the rows that contain it, with the places of the
    /// blocks.
    pub(super) fn by_columns(&self, rows: usize) -> (Vec<usize>, Vec<(u32, u32)>) {
        by_columns(&self.start[..=rows], &self.column, self.cols)
    }
}

/// A copy of these rows.
pub(super) fn rows_at<'a>(
    nodes: &[u32],
    cols: usize,
    row: impl Fn(u32) -> (&'a [u32], &'a [Block<3, 3>]) + Sync,
) -> Blocks<3, 3> {
    let named = |t: usize, name: &mut dyn FnMut(u32)| row(nodes[t]).0.iter().for_each(|&j| name(j));
    Blocks::from_rows(nodes.len(), cols, named, |t, to| {
        let (columns, blocks) = row(nodes[t]);
        columns.iter().zip(blocks).for_each(|(&j, block)| *to.at(j) = *block);
    })
}

/// For each of `cols` columns the rows that contain it, with the places of their entries.
pub(super) fn by_columns(rows: &[usize], column: &[u32], cols: usize) -> (Vec<usize>, Vec<(u32, u32)>) {
    let entries = rows[rows.len() - 1];
    let mut start = vec![0usize; cols + 1];
    column[..entries].iter().for_each(|&j| start[j as usize + 1] += 1);
    (0..cols).for_each(|j| start[j + 1] += start[j]);
    let (mut next, mut entry) = (start.clone(), vec![(0, 0); entries]);
    for (i, own) in rows.windows(2).enumerate() {
        for place in own[0]..own[1] {
            let j = column[place] as usize;
            entry[next[j]] = (i as u32, place as u32);
            next[j] += 1;
        }
    }
    (start, entry)
}

impl<const R: usize> Blocks<R, R> {
    /// The diagonal block of row `i`; zero where none is stored.
    pub(crate) fn diagonal(&self, i: usize) -> Block<R, R> {
        self.place(i, i).map_or([[0.0; R]; R], |place| self.value[place])
    }
}

/// One row of blocks being filled.
pub(super) struct Row<'a, const R: usize, const C: usize> {
    /// Place of each of the row's columns in `values`, once they are `known`.
    slot: &'a mut [u32],
    known: bool,
    pub columns: &'a [u32],
    pub values: &'a mut [Block<R, C>],
}

impl<'a, const R: usize, const C: usize> Row<'a, R, C> {
    /// `slot` has a place for each column of the matrix, with any values.
    pub(super) fn new(slot: &'a mut [u32], columns: &'a [u32], values: &'a mut [Block<R, C>]) -> Self {
        Row { slot, known: false, columns, values }
    }

    /// The block of column `j`, one of those the row was declared with.
    pub(super) fn at(&mut self, j: u32) -> &mut Block<R, C> {
        if !self.known {
            self.known = true;
            self.columns.iter().enumerate().for_each(|(k, &j)| self.slot[j as usize] = k as u32);
        }
        &mut self.values[self.slot[j as usize] as usize]
    }
}

/// The position of each unknown in vectors of nodes with three components.
#[derive(Debug, Clone)]
pub(crate) struct Nodes {
    /// Node and component of each unknown.
    pub of: Vec<(u32, u8)>,
    /// Number of nodes.
    pub count: usize,
}

impl Nodes {
    /// The nodes of the graph; `None` if one has more than three unknowns.
    pub(crate) fn new(graph: &NodeGraph, unknowns: usize) -> Option<Nodes> {
        let mut of = vec![(0, 0); unknowns];
        for v in 0..graph.len() {
            let own = graph.unknowns_of(v);
            if own.len() > 3 {
                return None;
            }
            own.iter().enumerate().for_each(|(c, &i)| of[i as usize] = (v as u32, c as u8));
        }
        Some(Nodes { of, count: graph.len() })
    }

    /// A vector of unknowns as one of nodes; components without unknown are zero.
    pub(crate) fn gather(&self, x: &[f64]) -> Vec<[f64; 3]> {
        let mut y = vec![[0.0; 3]; self.count];
        self.of.iter().zip(x).for_each(|(&(v, c), &x)| y[v as usize][c as usize] = x);
        y
    }

    /// The inverse of [`Self::gather`].
    pub(crate) fn scatter(&self, y: &[[f64; 3]]) -> Vec<f64> {
        self.of.iter().map(|&(v, c)| y[v as usize][c as usize]).collect()
    }

    /// The matrix by nodes; components without unknown get a diagonal entry, so that it stays positive definite.
    pub(crate) fn blocks(&self, k: &SymmetricCsr, graph: &NodeGraph) -> Blocks<3, 3> {
        let pattern = Pattern::new(self.count, self.count, |v, name| {
            name(v as u32);
            graph.neighbours_of(v).iter().for_each(|&w| name(w));
        });
        let mut value = pattern.zeros();
        self.copy_stored(k, graph, &pattern, &mut value);
        symmetrise(&pattern, &mut value);
        let Pattern { start, column } = pattern;
        Blocks { rows: self.count, cols: self.count, start, column, value }
    }

    /// What `k` stores of each row: the entries left of the diagonal and on it. The rows are taken in the order of `k`, which
    /// is larger than the caches, whatever order the nodes are in.
    fn copy_stored(&self, k: &SymmetricCsr, graph: &NodeGraph, pattern: &Pattern, value: &mut [Block<3, 3>]) {
        let (mut rows, mut rest) = (Vec::with_capacity(self.count), value);
        for v in 0..self.count {
            let (own, tail) = rest.split_at_mut(pattern.row(v).len());
            rows.push((v, own));
            rest = tail;
        }
        rows.sort_by_key(|(v, _)| graph.unknowns_of(*v).first().copied());
        let most = piece(rows.len()).max(ROWS_PER_TASK);
        rows.par_iter_mut().with_min_len(ROWS_PER_TASK).with_max_len(most).for_each_init(
            || vec![0u32; self.count],
            |slot, (v, row)| {
                pattern.row(*v).iter().enumerate().for_each(|(place, &w)| slot[w as usize] = place as u32);
                let own = graph.unknowns_of(*v);
                for (r, &i) in own.iter().enumerate() {
                    for (j, a) in k.entries_of(i as usize) {
                        let (w, c) = self.of[j as usize];
                        row[slot[w as usize] as usize][r][c as usize] += a;
                    }
                }
                let diagonal = &mut row[slot[*v] as usize];
                let scale = (0..own.len()).map(|c| diagonal[c][c]).fold(f64::MIN_POSITIVE, f64::max);
                (own.len()..3).for_each(|c| diagonal[c][c] = scale);
            },
        );
    }
}

/// Adds to each block off the diagonal the transpose of the one across, and fills the diagonal blocks above their diagonal. The
/// pattern is symmetric.
fn symmetrise(pattern: &Pattern, value: &mut [Block<3, 3>]) {
    let rows = pattern.start.len() - 1;
    let slab = rows.div_ceil(rayon::current_num_threads()).max(ROWS_PER_TASK);
    let (mut slabs, mut rest) = (Vec::new(), &mut *value);
    for first in (0..rows).step_by(slab) {
        let own = first..rows.min(first + slab);
        let (values, tail) = rest.split_at_mut(pattern.start[own.end] - pattern.start[own.start]);
        slabs.push((own, values));
        rest = tail;
    }
    slabs.into_par_iter().for_each(|(own, values)| {
        let base = pattern.start[own.start];
        // The place of the next block above the diagonal in each row: the columns of a row ascend, and so do the rows below.
        let above = |v: usize| pattern.start[v] + pattern.row(v).partition_point(|&w| w as usize <= v);
        let mut next: Vec<usize> = own.clone().map(above).collect();
        for v in own.clone() {
            for place in pattern.start[v]..pattern.start[v + 1] {
                let w = pattern.column[place] as usize;
                if w == v {
                    let block = &mut values[place - base];
                    (0..3).for_each(|r| (r + 1..3).for_each(|c| block[r][c] = block[c][r]));
                } else if own.contains(&w) && w < v {
                    let across = &mut next[w - own.start];
                    add_across(values, place - base, *across - base);
                    *across += 1;
                }
            }
        }
    });
    // Blocks that couple rows of two slabs.
    for v in 0..rows {
        let first = v / slab * slab;
        for (k, &w) in pattern.row(v).iter().enumerate().take_while(|(_, w)| (**w as usize) < first) {
            if let Ok(across) = pattern.row(w as usize).binary_search(&(v as u32)) {
                add_across(value, pattern.start[v] + k, pattern.start[w as usize] + across);
            }
        }
    }
}

/// Two blocks across the diagonal, of which each entry is stored in one: both are set to the sum of one and the other's
/// transpose.
fn add_across(value: &mut [Block<3, 3>], place: usize, across: usize) {
    let (one, other) = (value[place], value[across]);
    let sum: Block<3, 3> = std::array::from_fn(|r| std::array::from_fn(|c| one[r][c] + other[c][r]));
    value[place] = sum;
    value[across] = std::array::from_fn(|r| std::array::from_fn(|c| sum[c][r]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Csr;

    /// A matrix of nodes with one to three unknowns, which are scattered over the matrix.
    fn scattered() -> (SymmetricCsr, Vec<u32>) {
        let n = 3001;
        let node_of: Vec<u32> = (0..n as u32).map(|i| i * 7 % n as u32 / 3).collect();
        let mut entries: Vec<(usize, usize, f64)> = (0..n).map(|i| (i, i, 10.0 + (i % 7) as f64)).collect();
        for i in 0..n {
            for step in [1, 3, 50, 1500] {
                if let j @ 0.. = i as i64 - step {
                    let value = ((i * 13 + j as usize) % 17) as f64 - 8.0;
                    entries.extend([(i, j as usize, value), (j as usize, i, value)]);
                }
            }
        }
        (SymmetricCsr::from_full(&Csr::from_triplets(n, n, &entries), "K").unwrap(), node_of)
    }

    #[test]
    fn blocks_have_the_products_of_the_matrix_in_any_order_of_nodes_and_on_any_number_of_threads() {
        let (k, node_of) = scattered();
        let graph = NodeGraph::of_symmetric(&k, Some(&node_of));
        let n = graph.len() as u32;
        let x: Vec<f64> = (0..k.rows).map(|i| (i as f64 * 0.618).fract() - 0.5).collect();
        let expected = k.times(&x);
        for order in [(0..n).collect::<Vec<_>>(), (0..n).map(|v| v * 17 % n).collect()] {
            let graph = graph.reordered(&order);
            let nodes = Nodes::new(&graph, k.rows).unwrap();
            for threads in [1, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let blocks = pool.install(|| nodes.blocks(&k, &graph));
                let found = nodes.scatter(&blocks.times(&nodes.gather(&x)));
                let wrong = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(wrong < 1e-12, "{wrong}");
            }
        }
    }
}
