//! Which columns the rows of a sparse matrix have.

use std::ops::Range;

use rayon::prelude::*;

use super::in_huge_pages;

/// Rows handed to a thread at a time at most; results do not depend on it.
pub(super) const ROWS_PER_TASK: usize = 1024;

/// Rows a thread makes at a time. On coarse levels they are few, and each is much work.
pub(super) fn tasks(rows: Range<usize>) -> Vec<Range<usize>> {
    let at_a_time = (rows.len() / 256).clamp(16, ROWS_PER_TASK);
    rows.clone().step_by(at_a_time).map(|first| first..rows.end.min(first + at_a_time)).collect()
}

/// Pieces of equal work a thread takes at least: the pages of one may come slower than those of another, and rayon does not
/// divide what a thread has begun with.
const PIECES: usize = 8;

/// How many of so many tasks are left together at most.
pub(crate) fn piece(tasks: usize) -> usize {
    tasks.div_ceil(PIECES * rayon::current_num_threads()).max(1)
}

/// Room for a few longer rows behind so many entries: memory that is not written costs nothing, and an array that outgrows
/// its own is copied.
pub(super) fn with_room(entries: usize) -> usize {
    entries + entries / 2
}

/// Where the entries of a sparse matrix stand, or its blocks.
#[derive(Debug, Clone)]
pub(crate) struct Pattern {
    /// Row `i` occupies `start[i]..start[i + 1]`.
    pub start: Vec<usize>,
    /// Ascending in each row.
    pub column: Vec<u32>,
}

impl Pattern {
    /// Row `i` has the columns that `columns` names, in any order, repeated or not.
    pub(crate) fn new(rows: usize, cols: usize, columns: impl Fn(usize, &mut dyn FnMut(u32)) + Sync) -> Pattern {
        let tasks = tasks(0..rows);
        let at_once = piece(tasks.len());
        let parts: Vec<(Vec<usize>, Vec<u32>)> = (tasks.into_par_iter().with_max_len(at_once))
            .map_init(
                || vec![u32::MAX; cols],
                |seen, own| {
                    let (mut ends, mut column) = (Vec::with_capacity(own.len()), Vec::new());
                    for i in own {
                        let begin = column.len();
                        columns(i, &mut |j| {
                            if seen[j as usize] != i as u32 {
                                seen[j as usize] = i as u32;
                                column.push(j);
                            }
                        });
                        column[begin..].sort_unstable();
                        ends.push(column.len());
                    }
                    (ends, column)
                },
            )
            .collect();
        let mut start = vec![0];
        let mut column = in_huge_pages(Vec::with_capacity(with_room(parts.iter().map(|p| p.1.len()).sum())));
        for (ends, part) in &parts {
            start.extend(ends.iter().map(|end| column.len() + end));
            column.extend_from_slice(part);
        }
        Pattern { start, column }
    }

    /// The pattern with the transposed one: an entry at `(j, i)` for each at `(i, j)`.
    pub(super) fn mirrored(&self) -> Pattern {
        let rows = self.start.len() - 1;
        let mut start = vec![0usize; rows + 1];
        self.column.iter().for_each(|&j| start[j as usize + 1] += 1);
        (0..rows).for_each(|j| start[j + 1] += start[j]);
        let (mut next, mut column) = (start.clone(), vec![0u32; self.column.len()]);
        for i in 0..rows {
            for &j in self.row(i) {
                column[next[j as usize]] = i as u32;
                next[j as usize] += 1;
            }
        }
        let transposed = Pattern { start, column };
        Pattern::new(rows, rows, |i, name| self.row(i).iter().chain(transposed.row(i)).for_each(|&j| name(j)))
    }

    pub(super) fn row(&self, i: usize) -> &[u32] {
        &self.column[self.start[i]..self.start[i + 1]]
    }
}
