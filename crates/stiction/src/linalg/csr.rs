use rayon::prelude::*;

use crate::Error;

/// A sparse matrix by compressed rows. Column indices ascend in each row and are unique.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Csr {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// Row `i` occupies `start[i]..start[i + 1]`; `rows + 1` entries.
    pub start: Vec<usize>,
    /// Column of each entry.
    pub column: Vec<u32>,
    /// Value of each entry.
    pub value: Vec<f64>,
}

/// Rows handed to a thread at a time; a product's result does not depend on it.
const ROWS_PER_TASK: usize = 4096;

impl Csr {
    /// A matrix without entries.
    pub fn zero(rows: usize, cols: usize) -> Self {
        Csr { rows, cols, start: vec![0; rows + 1], column: Vec::new(), value: Vec::new() }
    }

    /// The matrix with the given entries `(row, column, value)`; equal places are added in the order given.
    ///
    /// # Panics
    /// If an index lies outside the matrix.
    pub fn from_triplets(rows: usize, cols: usize, entries: &[(usize, usize, f64)]) -> Self {
        let mut start = vec![0usize; rows + 1];
        for &(i, j, _) in entries {
            assert!(i < rows && j < cols, "entry ({i}, {j}) outside a {rows} x {cols} matrix");
            start[i + 1] += 1;
        }
        for i in 0..rows {
            start[i + 1] += start[i];
        }
        let mut place = start.clone();
        let mut by_row = vec![(0u32, 0.0f64); entries.len()];
        for &(i, j, v) in entries {
            by_row[place[i]] = (j as u32, v);
            place[i] += 1;
        }
        let mut matrix = Csr::zero(rows, cols);
        for i in 0..rows {
            let row = &mut by_row[start[i]..start[i + 1]];
            row.sort_by_key(|e| e.0);
            let first = matrix.column.len();
            for &(j, v) in row.iter() {
                if matrix.column.len() > first && matrix.column.last() == Some(&j) {
                    *matrix.value.last_mut().expect("a value for each column") += v;
                } else {
                    matrix.column.push(j);
                    matrix.value.push(v);
                }
            }
            matrix.start[i + 1] = matrix.column.len();
        }
        matrix
    }

    /// Checks lengths, ascending columns and finite values; `name` is used in the message.
    ///
    /// # Errors
    /// The first thing that is wrong, with its row.
    pub fn validate(&self, name: &str) -> Result<(), Error> {
        let bad = |what: String| Err(Error::new(name, what, "give a matrix by compressed rows with ascending columns"));
        if self.start.len() != self.rows + 1 || self.start[0] != 0 || self.start[self.rows] != self.column.len() {
            return bad(format!("row pointers do not fit {} rows and {} entries", self.rows, self.column.len()));
        }
        if self.column.len() != self.value.len() {
            return bad(format!("{} columns but {} values", self.column.len(), self.value.len()));
        }
        let row = |i: usize| {
            if self.start[i] > self.start[i + 1] || self.start[i + 1] > self.column.len() {
                return bad(format!("row pointers descend at row {i}"));
            }
            let (columns, values) = self.row(i);
            if columns.windows(2).any(|w| w[0] >= w[1]) {
                return bad(format!("columns of row {i} do not ascend"));
            }
            if columns.last().is_some_and(|&j| j as usize >= self.cols) {
                return bad(format!("row {i} has a column beyond {}", self.cols));
            }
            if values.iter().any(|v| !v.is_finite()) {
                return bad(format!("row {i} holds a value that is not finite"));
            }
            Ok(())
        };
        // Of several faults the one in the first row is reported.
        let rows = (0..self.rows).into_par_iter().with_min_len(ROWS_PER_TASK);
        rows.find_map_first(|i| row(i).err()).map_or(Ok(()), Err)
    }

    /// Columns and values of row `i`.
    pub fn row(&self, i: usize) -> (&[u32], &[f64]) {
        let range = self.start[i]..self.start[i + 1];
        (&self.column[range.clone()], &self.value[range])
    }

    /// Column and value of every entry stored in row `i`.
    pub fn entries_of(&self, i: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let (columns, values) = self.row(i);
        columns.iter().copied().zip(values.iter().copied())
    }

    /// Row, column and value of every stored entry, row by row.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.rows).flat_map(|i| self.entries_of(i).map(move |(j, v)| (i, j as usize, v)))
    }

    fn row_dot(&self, i: usize, x: &[f64]) -> f64 {
        let (columns, values) = self.row(i);
        columns.iter().zip(values).map(|(&j, v)| v * x[j as usize]).sum()
    }

    /// `A x`, of length `rows`. The result does not depend on the number of threads.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.cols);
        let mut y = vec![0.0; self.rows];
        if self.rows <= ROWS_PER_TASK {
            y.iter_mut().enumerate().for_each(|(i, y)| *y = self.row_dot(i, x));
        } else {
            y.par_chunks_mut(ROWS_PER_TASK).enumerate().for_each(|(task, y)| {
                y.iter_mut().enumerate().for_each(|(i, y)| *y = self.row_dot(task * ROWS_PER_TASK + i, x));
            });
        }
        y
    }

    /// `Aᵀ x`, of length `cols`.
    pub fn transpose_times(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.rows);
        let mut y = vec![0.0; self.cols];
        for (i, &xi) in x.iter().enumerate() {
            if xi != 0.0 {
                self.entries_of(i).for_each(|(j, v)| y[j as usize] += v * xi);
            }
        }
        y
    }

    /// `Aᵀ`.
    pub fn transpose(&self) -> Csr {
        let mut t = Csr::zero(self.cols, self.rows);
        for &j in &self.column {
            t.start[j as usize + 1] += 1;
        }
        for j in 0..self.cols {
            t.start[j + 1] += t.start[j];
        }
        let mut place = t.start.clone();
        t.column = vec![0; self.column.len()];
        t.value = vec![0.0; self.value.len()];
        for (i, j, v) in self.entries() {
            (t.column[place[j]], t.value[place[j]]) = (i as u32, v);
            place[j] += 1;
        }
        t
    }

    /// The entry at `(i, j)`, zero where none is stored.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        let (columns, values) = self.row(i);
        columns.binary_search(&(j as u32)).map_or(0.0, |k| values[k])
    }

    /// Largest magnitude of an entry.
    pub fn max_abs(&self) -> f64 {
        super::max_abs(&self.value)
    }

    /// The same rows with the columns `keep`, renumbered in that order; entries in other columns are left out.
    pub fn select_columns(&self, keep: &[u32]) -> Csr {
        let mut number = vec![u32::MAX; self.cols];
        keep.iter().enumerate().for_each(|(k, &j)| number[j as usize] = k as u32);
        let kept = self.entries().filter(|e| number[e.1] != u32::MAX);
        let kept: Vec<(usize, usize, f64)> = kept.map(|(i, j, v)| (i, number[j] as usize, v)).collect();
        Csr::from_triplets(self.rows, keep.len(), &kept)
    }

    /// The given rows, in that order.
    pub fn select_rows(&self, keep: &[u32]) -> Csr {
        let mut part = Csr::zero(keep.len(), self.cols);
        for (k, &i) in keep.iter().enumerate() {
            let (columns, values) = self.row(i as usize);
            part.column.extend_from_slice(columns);
            part.value.extend_from_slice(values);
            part.start[k + 1] = part.column.len();
        }
        part
    }

    /// Adds the rows of `below`.
    pub fn append(&mut self, below: &Csr) {
        let offset = self.column.len();
        self.rows += below.rows;
        self.start.extend(below.start[1..].iter().map(|s| s + offset));
        self.column.extend_from_slice(&below.column);
        self.value.extend_from_slice(&below.value);
    }

    /// Adds a row; its columns ascend.
    pub fn append_row(&mut self, entries: impl Iterator<Item = (u32, f64)>) {
        for (column, value) in entries {
            self.column.push(column);
            self.value.push(value);
        }
        self.rows += 1;
        self.start.push(self.column.len());
    }

    /// The matrix with these columns, of length `rows` each, to its right.
    pub fn beside(&self, columns: &[Vec<f64>]) -> Csr {
        let mut wide = Csr::zero(0, self.cols + columns.len());
        for i in 0..self.rows {
            let right = columns.iter().enumerate().map(|(k, column)| ((self.cols + k) as u32, column[i]));
            wide.append_row(self.entries_of(i).chain(right.filter(|(_, value)| *value != 0.0)));
        }
        wide
    }

    /// Column `j` with its zeros.
    pub fn column_of(&self, j: usize) -> Vec<f64> {
        (0..self.rows).map(|i| self.entry(i, j)).collect()
    }

    /// The diagonal of a square matrix.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.rows).map(|i| self.entry(i, i)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_places_are_added_and_rows_sorted() {
        let a = Csr::from_triplets(2, 3, &[(0, 2, 1.0), (0, 0, 2.0), (0, 2, 3.0), (1, 1, 5.0)]);
        assert_eq!(a.row(0), (&[0u32, 2][..], &[2.0, 4.0][..]));
        assert_eq!(a.times(&[1.0, 10.0, 100.0]), [402.0, 50.0]);
        assert_eq!(a.transpose_times(&[1.0, 10.0]), [2.0, 50.0, 4.0]);
        assert_eq!(a.transpose().transpose(), a);
        a.validate("a").unwrap();
    }

    #[test]
    fn damaged_rows_are_refused() {
        let mut a = Csr::from_triplets(2, 2, &[(0, 0, 1.0), (1, 1, 1.0)]);
        a.value[1] = f64::NAN;
        assert!(a.validate("K").unwrap_err().to_string().contains("row 1"));
        a.start[1] = 7;
        assert!(a.validate("K").is_err());
    }
}
