use rayon::prelude::*;

use crate::linalg::{Csr, NodeGraph};

/// A dense block, by rows.
pub type Block<const R: usize, const C: usize> = [[f64; C]; R];

/// A sparse matrix of dense blocks by compressed rows; columns ascend in each row and are unique.
#[derive(Debug, Clone, Default)]
pub struct Blocks<const R: usize, const C: usize> {
    pub rows: usize,
    pub cols: usize,
    /// Row `i` occupies `start[i]..start[i + 1]`.
    pub start: Vec<usize>,
    pub column: Vec<u32>,
    pub value: Vec<Block<R, C>>,
}

/// Rows handed to a thread at a time; results do not depend on it.
pub(super) const ROWS_PER_TASK: usize = 1024;

impl<const R: usize, const C: usize> Blocks<R, C> {
    /// Columns and blocks of row `i`.
    pub fn row(&self, i: usize) -> (&[u32], &[Block<R, C>]) {
        let range = self.start[i]..self.start[i + 1];
        (&self.column[range.clone()], &self.value[range])
    }

    /// The place of block `(i, j)` among the values, if it is stored.
    pub fn place(&self, i: usize, j: usize) -> Option<usize> {
        let (columns, _) = self.row(i);
        columns.binary_search(&(j as u32)).ok().map(|k| self.start[i] + k)
    }

    /// `A x`.
    pub fn times(&self, x: &[[f64; C]]) -> Vec<[f64; R]> {
        let mut y = vec![[0.0; R]; self.rows];
        y.par_chunks_mut(ROWS_PER_TASK).enumerate().for_each(|(task, y)| {
            for (k, y) in y.iter_mut().enumerate() {
                let (columns, blocks) = self.row(task * ROWS_PER_TASK + k);
                for (&j, a) in columns.iter().zip(blocks) {
                    let x = &x[j as usize];
                    for r in 0..R {
                        for c in 0..C {
                            y[r] += a[r][c] * x[c];
                        }
                    }
                }
            }
        });
        y
    }

    /// Rows computed in parallel and put one after the other.
    pub(super) fn from_rows(
        rows: usize,
        cols: usize,
        row: impl Fn(usize, &mut RowBuilder<R, C>) + Sync,
    ) -> Blocks<R, C> {
        let tasks: Vec<usize> = (0..rows).step_by(ROWS_PER_TASK).collect();
        let parts: Vec<(Vec<usize>, Vec<u32>, Vec<Block<R, C>>)> = (tasks.par_iter())
            .map_init(
                || RowBuilder::new(cols),
                |builder, &first| {
                    let (mut lengths, mut column, mut value) = (Vec::new(), Vec::new(), Vec::new());
                    for i in first..rows.min(first + ROWS_PER_TASK) {
                        row(i, builder);
                        lengths.push(builder.drain(&mut column, &mut value));
                    }
                    (lengths, column, value)
                },
            )
            .collect();
        let mut matrix = Blocks { rows, cols, start: vec![0], column: Vec::new(), value: Vec::new() };
        let entries = parts.iter().map(|p| p.1.len()).sum();
        matrix.column.reserve_exact(entries);
        matrix.value.reserve_exact(entries);
        for (lengths, column, value) in parts {
            for length in lengths {
                let last = matrix.start[matrix.start.len() - 1];
                matrix.start.push(last + length);
            }
            matrix.column.extend_from_slice(&column);
            matrix.value.extend_from_slice(&value);
        }
        matrix
    }

    /// The transpose's pattern: for each column the rows that hold it, with the places of the blocks.
    pub(super) fn by_columns(&self) -> (Vec<usize>, Vec<(u32, u32)>) {
        let mut start = vec![0usize; self.cols + 1];
        self.column.iter().for_each(|&j| start[j as usize + 1] += 1);
        (0..self.cols).for_each(|j| start[j + 1] += start[j]);
        let (mut next, mut entry) = (start.clone(), vec![(0, 0); self.column.len()]);
        for i in 0..self.rows {
            for place in self.start[i]..self.start[i + 1] {
                let j = self.column[place] as usize;
                entry[next[j]] = (i as u32, place as u32);
                next[j] += 1;
            }
        }
        (start, entry)
    }
}

impl<const R: usize> Blocks<R, R> {
    /// The diagonal block of row `i`; zero where none is stored.
    pub fn diagonal(&self, i: usize) -> Block<R, R> {
        self.place(i, i).map_or([[0.0; R]; R], |place| self.value[place])
    }
}

/// One sparse row of blocks under construction.
pub(super) struct RowBuilder<const R: usize, const C: usize> {
    /// Place of each column in `entries`; `u32::MAX` where there is none.
    slot: Vec<u32>,
    entries: Vec<(u32, Block<R, C>)>,
}

impl<const R: usize, const C: usize> RowBuilder<R, C> {
    fn new(cols: usize) -> Self {
        RowBuilder { slot: vec![u32::MAX; cols], entries: Vec::new() }
    }

    /// The block of column `j`, zero at first.
    pub fn at(&mut self, j: u32) -> &mut Block<R, C> {
        let slot = &mut self.slot[j as usize];
        if *slot == u32::MAX {
            *slot = self.entries.len() as u32;
            self.entries.push((j, [[0.0; C]; R]));
        }
        &mut self.entries[*slot as usize].1
    }

    /// Changes every block added so far.
    pub fn each(&mut self, mut change: impl FnMut(&mut Block<R, C>)) {
        self.entries.iter_mut().for_each(|(_, block)| change(block));
    }

    fn drain(&mut self, column: &mut Vec<u32>, value: &mut Vec<Block<R, C>>) -> usize {
        let length = self.entries.len();
        self.entries.sort_unstable_by_key(|e| e.0);
        for (j, block) in self.entries.drain(..) {
            self.slot[j as usize] = u32::MAX;
            column.push(j);
            value.push(block);
        }
        length
    }
}

/// Where the unknowns of a matrix stand in vectors of nodes with three components.
#[derive(Debug, Clone)]
pub struct Nodes {
    /// Node and component of each unknown.
    pub of: Vec<(u32, u8)>,
    pub count: usize,
}

impl Nodes {
    /// Nodes of the graph; `None` if one has more than three unknowns.
    pub fn new(graph: &NodeGraph, unknowns: usize) -> Option<Nodes> {
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

    /// A vector of unknowns as one of nodes; components no unknown stands for are zero.
    pub fn gather(&self, x: &[f64]) -> Vec<[f64; 3]> {
        let mut y = vec![[0.0; 3]; self.count];
        self.of.iter().zip(x).for_each(|(&(v, c), &x)| y[v as usize][c as usize] = x);
        y
    }

    /// The inverse of [`Self::gather`].
    pub fn scatter(&self, y: &[[f64; 3]]) -> Vec<f64> {
        self.of.iter().map(|&(v, c)| y[v as usize][c as usize]).collect()
    }

    /// The matrix by nodes; components no unknown stands for get the identity, so that it stays positive definite.
    pub fn blocks(&self, k: &Csr, graph: &NodeGraph) -> Blocks<3, 3> {
        let mut scale = vec![0.0f64; self.count];
        (0..k.rows).for_each(|i| {
            let v = self.of[i].0 as usize;
            scale[v] = scale[v].max(k.entry(i, i));
        });
        Blocks::from_rows(self.count, self.count, |v, row| {
            let own = graph.unknowns_of(v);
            for (r, &i) in own.iter().enumerate() {
                let (columns, values) = k.row(i as usize);
                for (&j, &a) in columns.iter().zip(values) {
                    let (w, c) = self.of[j as usize];
                    row.at(w)[r][c as usize] += a;
                }
            }
            let diagonal = row.at(v as u32);
            (own.len()..3).for_each(|c| diagonal[c][c] = scale[v].max(f64::MIN_POSITIVE));
        })
    }
}
