use std::ops::Range;

use rayon::prelude::*;

use super::Csr;
use super::pattern::ROWS_PER_TASK;
use crate::Error;

/// A sparse symmetric matrix by the rows of its lower triangle. Every row holds its diagonal, as its last entry.
///
/// Rows that follow one another and are coupled to the same unknowns, as those of a node in elasticity are, share their
/// columns: the columns of each are the first of those of the next. A matrix of elasticity takes two fifths of the memory
/// of its full rows that way, and memory is what its assembly and its products wait for.
#[derive(Debug, Clone)]
pub struct SymmetricCsr {
    /// Number of rows and columns.
    pub rows: usize,
    /// The values of row `i` are `value[start[i]..start[i + 1]]`; `rows + 1` entries.
    pub start: Vec<usize>,
    /// The columns of row `i`, which ascend up to `i`, begin at `first[i]` in `column`.
    pub first: Vec<usize>,
    /// Columns of the stored rows.
    pub column: Vec<u32>,
    /// Values of the lower triangle, row by row, the diagonal last in each.
    pub value: Vec<f64>,
}

/// Products are made by so many parts of the rows at most, each with a vector for what it adds to rows before its own.
const PARTS: usize = 32;
/// Relative difference of two mirror images that different orders of summation explain.
const ROUNDING: f64 = 1e-10;

impl SymmetricCsr {
    /// Adds a row, given by its entries left of the diagonal (columns ascending) and the one on it.
    pub fn push_row(&mut self, columns: &[u32], values: &[f64], diagonal: f64) {
        let shared = self.rows.checked_sub(1).filter(|&last| self.row(last).0 == columns);
        match shared {
            Some(last) => self.first.push(self.first[last]),
            None => {
                self.first.push(self.column.len());
                self.column.extend_from_slice(columns);
            }
        }
        self.column.push(self.rows as u32);
        self.value.extend_from_slice(values);
        self.value.push(diagonal);
        self.start.push(self.value.len());
        self.rows += 1;
    }

    /// The matrix with both triangles given; mirror images that differ by rounding are replaced by their mean.
    ///
    /// # Errors
    /// If `full`, called `name`, is no valid square matrix or not symmetric.
    pub fn from_full(full: &Csr, name: &str) -> Result<Self, Error> {
        full.validate(name)?;
        if full.rows != full.cols {
            let what = format!("{} rows and {} columns", full.rows, full.cols);
            return Err(Error::new(name, what, "give a square matrix"));
        }
        let mirrored = full.transpose();
        let diagonal = full.diagonal();
        let mut matrix = SymmetricCsr::default();
        let (mut columns, mut values) = (Vec::new(), Vec::new());
        for (i, &own) in diagonal.iter().enumerate() {
            let (left, below) = (left_of(full, i), left_of(&mirrored, i));
            columns.clear();
            values.clear();
            let (mut a, mut b) = (0, 0);
            while let Some(&j) = left.0.get(a).into_iter().chain(below.0.get(b)).min() {
                let entry = |(found, of): ((&[u32], &[f64]), &mut usize)| match found.0.get(*of) {
                    Some(&column) if column == j => {
                        *of += 1;
                        found.1[*of - 1]
                    }
                    _ => 0.0,
                };
                let (lower, upper) = (entry((left, &mut a)), entry((below, &mut b)));
                let j = j as usize;
                if (upper - lower).abs() > ROUNDING * own.abs().max(diagonal[j].abs()) {
                    return Err(Self::not_symmetric(name, j, i, upper, lower));
                }
                columns.push(j as u32);
                values.push(if upper == lower { lower } else { 0.5 * (lower + upper) });
            }
            matrix.push_row(&columns, &values, own);
        }
        Ok(matrix)
    }

    /// That the entries `(i, j)` and `(j, i)` of the matrix `name` differ by more than rounding.
    pub fn not_symmetric(name: &str, i: usize, j: usize, one: f64, other: f64) -> Error {
        let [a, b, apart] = [one, other, (one - other).abs()].map(Error::number);
        let apart = if a == b { format!(", {apart} apart") } else { String::new() };
        let what = format!("not symmetric at ({i}, {j}): {a} and {b}{apart}");
        Error::new(name, what, "give both triangles of a symmetric matrix")
    }

    /// The matrix whose lower triangle is given by rows.
    ///
    /// # Errors
    /// If `lower`, called `name`, has an entry above its diagonal.
    ///
    /// # Panics
    /// If `lower` does not pass [`Csr::validate`].
    pub fn from_lower(lower: &Csr, name: &str) -> Result<Self, Error> {
        let mut matrix = SymmetricCsr::default();
        for i in 0..lower.rows {
            let (columns, _) = lower.row(i);
            if let Some(&j) = columns.last().filter(|&&j| j as usize > i) {
                let what = format!("the entry ({i}, {j}) stands above the diagonal");
                return Err(Error::new(name, what, "give the lower triangle of a symmetric matrix"));
            }
            let ((left, values), diagonal) = (left_of(lower, i), lower.entry(i, i));
            matrix.push_row(left, values, diagonal);
        }
        Ok(matrix)
    }

    /// `b - A x`, rounded once: products and sums are kept in two numbers (Ogita, Rump & Oishi 2005).
    pub fn residual(&self, b: &[f64], x: &[f64]) -> Vec<f64> {
        let mut sum: Vec<[f64; 2]> = b.iter().map(|&b| [b, 0.0]).collect();
        let subtract = |sum: &mut [f64; 2], a: f64, x: f64| {
            let product = -a * x;
            let total = sum[0] + product;
            let part = total - sum[0];
            let lost = (sum[0] - (total - part)) + (product - part);
            *sum = [total, sum[1] + lost + (-a).mul_add(x, -product)];
        };
        for i in 0..self.rows {
            for (j, a) in self.entries_of(i) {
                let j = j as usize;
                subtract(&mut sum[i], a, x[j]);
                if j < i {
                    subtract(&mut sum[j], a, x[i]);
                }
            }
        }
        sum.into_iter().map(|[high, low]| high + low).collect()
    }

    /// Both triangles by rows.
    pub fn full(&self) -> Csr {
        let mut start = vec![0usize; self.rows + 1];
        for i in 0..self.rows {
            let (columns, _) = self.row(i);
            start[i + 1] += columns.len();
            columns[..columns.len() - 1].iter().for_each(|&j| start[j as usize + 1] += 1);
        }
        (0..self.rows).for_each(|i| start[i + 1] += start[i]);
        let mut next = start.clone();
        let (mut column, mut value) = (vec![0; start[self.rows]], vec![0.0; start[self.rows]]);
        // The left part of every row is complete before the rows below add to its right part in ascending order.
        for i in 0..self.rows {
            for (j, v) in self.entries_of(i) {
                let j = j as usize;
                (column[next[i]], value[next[i]]) = (j as u32, v);
                next[i] += 1;
                if j < i {
                    (column[next[j]], value[next[j]]) = (i as u32, v);
                    next[j] += 1;
                }
            }
        }
        Csr { rows: self.rows, cols: self.rows, start, column, value }
    }

    /// Checks lengths, ascending columns that end on the diagonal, and finite values; `name` is used in the message.
    ///
    /// # Errors
    /// The first thing that is wrong, with its row.
    pub fn validate(&self, name: &str) -> Result<(), Error> {
        let bad = |what: String| Err(Error::new(name, what, "give the lower triangle of a symmetric matrix by rows"));
        let (start, n) = (&self.start, self.rows);
        if start.len() != n + 1 || start[0] != 0 || start[n] != self.value.len() || self.first.len() != n {
            return bad(format!("row pointers do not fit {n} rows and {} values", self.value.len()));
        }
        let row = |i: usize| {
            if start[i] >= start[i + 1] || start[i + 1] > self.value.len() {
                return bad(format!("row {i} holds nothing"));
            }
            if self.column.len().checked_sub(start[i + 1] - start[i]).is_none_or(|last| self.first[i] > last) {
                return bad(format!("row {i} has no columns"));
            }
            let (columns, values) = self.row(i);
            // Those that the next row has as well are looked at there.
            let ascend = self.shares(i) || columns.windows(2).all(|w| w[0] < w[1]);
            if !ascend || columns.last() != Some(&(i as u32)) {
                return bad(format!("columns of row {i} do not ascend to its diagonal"));
            }
            if values.iter().any(|v| !v.is_finite()) {
                return bad(format!("row {i} holds a value that is not finite"));
            }
            Ok(())
        };
        // Of several faults the one in the first row is reported.
        let rows = (0..n).into_par_iter().with_min_len(ROWS_PER_TASK);
        rows.find_map_first(|i| row(i).err()).map_or(Ok(()), Err)
    }

    /// Columns and values of row `i` of the lower triangle, the diagonal last.
    pub fn row(&self, i: usize) -> (&[u32], &[f64]) {
        let values = self.start[i]..self.start[i + 1];
        (&self.column[self.first[i]..self.first[i] + values.len()], &self.value[values])
    }

    /// Column and value of every entry stored in row `i`.
    pub fn entries_of(&self, i: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let (columns, values) = self.row(i);
        columns.iter().copied().zip(values.iter().copied())
    }

    /// Whether the columns of row `i` are the first of those of the next.
    pub fn shares(&self, i: usize) -> bool {
        let one_longer = |i: usize| self.start[i + 2] + self.start[i] == 2 * self.start[i + 1] + 1;
        i + 1 < self.rows && self.first[i + 1] == self.first[i] && one_longer(i)
    }

    /// The entry at `(i, j)`, zero where none is stored.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        self.place(i, j).map_or(0.0, |place| self.value[place])
    }

    /// The same to be changed, `None` where none is stored.
    pub fn entry_mut(&mut self, i: usize, j: usize) -> Option<&mut f64> {
        self.place(i, j).map(|place| &mut self.value[place])
    }

    fn place(&self, i: usize, j: usize) -> Option<usize> {
        let (row, column) = (i.max(j), i.min(j) as u32);
        self.row(row).0.binary_search(&column).ok().map(|k| self.start[row] + k)
    }

    /// The entry on the diagonal of row `i`.
    pub fn diagonal(&self, i: usize) -> f64 {
        self.value[self.start[i + 1] - 1]
    }

    /// Largest magnitude of an entry.
    pub fn max_abs(&self) -> f64 {
        super::max_abs(&self.value)
    }

    /// The rows and columns `keep`, in that order, with both triangles.
    pub fn principal(&self, keep: &[u32]) -> Csr {
        let mut number = vec![u32::MAX; self.rows];
        keep.iter().enumerate().for_each(|(k, &i)| number[i as usize] = k as u32);
        let mut entries = Vec::new();
        for (k, &i) in keep.iter().enumerate() {
            let (columns, values) = self.row(i as usize);
            for (&j, &v) in columns.iter().zip(values).filter(|(j, _)| number[**j as usize] != u32::MAX) {
                let l = number[j as usize] as usize;
                entries.push((k, l, v));
                if k != l {
                    entries.push((l, k, v));
                }
            }
        }
        Csr::from_triplets(keep.len(), keep.len(), &entries)
    }

    /// `A x`. The result does not depend on the number of threads.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        self.product(x, |v| v)
    }

    /// `|A| |x|` with the magnitudes of all numbers: the size of the terms that `A x` adds up.
    pub fn magnitude_times(&self, x: &[f64]) -> Vec<f64> {
        let x: Vec<f64> = x.iter().map(|v| v.abs()).collect();
        self.product(&x, f64::abs)
    }

    /// The product with the entries `of(value)`. A part of the rows adds to its own rows in place and to those before
    /// them in a vector of its own; these are added in the order of the parts.
    fn product(&self, x: &[f64], of: impl Fn(f64) -> f64 + Sync) -> Vec<f64> {
        assert_eq!(x.len(), self.rows);
        let mut y = vec![0.0; self.rows];
        let size = self.rows.div_ceil(PARTS).max(ROWS_PER_TASK);
        let before: Vec<(usize, Vec<f64>)> = (y.par_chunks_mut(size).enumerate())
            .map(|(part, own)| {
                let rows = part * size..part * size + own.len();
                let lowest = rows.clone().map(|i| self.column[self.first[i]] as usize).min().unwrap_or(rows.start);
                let mut all = vec![0.0; rows.end - lowest.min(rows.start)];
                let offset = rows.end - all.len();
                self.add_rows(rows.clone(), x, offset, &mut all, &of);
                own.copy_from_slice(&all[rows.start - offset..]);
                all.truncate(rows.start - offset);
                (offset, all)
            })
            .collect();
        for (offset, part) in before {
            y[offset..].iter_mut().zip(part).for_each(|(y, part)| *y += part);
        }
        y
    }

    /// What `rows` add to the product, where `y` begins with row `offset`.
    fn add_rows(&self, rows: Range<usize>, x: &[f64], offset: usize, y: &mut [f64], of: &impl Fn(f64) -> f64) {
        let mut i = rows.start;
        while i < rows.end {
            let together = (1..3).take_while(|k| i + k < rows.end && self.shares(i + k - 1)).count() + 1;
            match together {
                3 => self.add_together::<3>(i, x, offset, y, of),
                2 => self.add_together::<2>(i, x, offset, y, of),
                _ => self.add_together::<1>(i, x, offset, y, of),
            }
            i += together;
        }
    }

    /// The same of `N` rows that share their columns.
    #[inline(always)]
    fn add_together<const N: usize>(
        &self,
        i: usize,
        x: &[f64],
        offset: usize,
        y: &mut [f64],
        of: &impl Fn(f64) -> f64,
    ) {
        let columns = self.row(i).0;
        let shared = &columns[..columns.len() - 1];
        let values: [&[f64]; N] = std::array::from_fn(|k| self.row(i + k).1);
        let left = values.map(|values| &values[..shared.len()]);
        let own: [f64; N] = std::array::from_fn(|k| x[i + k]);
        let mut sum = [0.0; N];
        for (place, &j) in shared.iter().enumerate() {
            let (j, mut mirrored) = (j as usize, 0.0);
            for k in 0..N {
                let v = of(left[k][place]);
                sum[k] += v * x[j];
                mirrored += v * own[k];
            }
            y[j - offset] += mirrored;
        }
        // The rows among themselves.
        for k in 0..N {
            for l in 0..=k {
                let v = of(values[k][shared.len() + l]);
                sum[k] += v * own[l];
                if l < k {
                    sum[l] += v * own[k];
                }
            }
        }
        (0..N).for_each(|k| y[i + k - offset] += sum[k]);
    }
}

/// The matrix of order zero, to which rows may be added.
impl Default for SymmetricCsr {
    fn default() -> Self {
        SymmetricCsr { rows: 0, start: vec![0], first: Vec::new(), column: Vec::new(), value: Vec::new() }
    }
}

/// Matrices are equal if their rows are, however these share their columns.
impl PartialEq for SymmetricCsr {
    fn eq(&self, other: &Self) -> bool {
        self.rows == other.rows && (0..self.rows).all(|i| self.row(i) == other.row(i))
    }
}

/// The entries of row `i` left of its diagonal.
fn left_of(matrix: &Csr, i: usize) -> (&[u32], &[f64]) {
    let (columns, values) = matrix.row(i);
    let count = columns.partition_point(|&j| (j as usize) < i);
    (&columns[..count], &values[..count])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_full(entries: &[(usize, usize, f64)]) -> Result<SymmetricCsr, Error> {
        SymmetricCsr::from_full(&Csr::from_triplets(3, 3, entries), "K")
    }

    #[test]
    fn a_residual_is_rounded_once() {
        let large = 2f64.powi(53);
        let k = from_full(&[(0, 0, large), (1, 1, large), (2, 2, 1.0), (0, 1, 1.0), (1, 0, 1.0)]).unwrap();
        let x = [3.0, 7.0, 0.5];
        // Sums of one number each lose the last bits of 3 * 2^53 + 7.
        assert_eq!(k.residual(&[3.0 * large, 7.0 * large, 1.0], &x), [-7.0, -3.0, 0.5]);
        let lost = 3.0 * large - k.times(&x)[0];
        assert_ne!(lost, -7.0);
    }

    /// Nodes of one to three unknowns in a row, each coupled to the two before it; of several parts of a product.
    fn chain(nodes: usize) -> (SymmetricCsr, Csr) {
        let number = |i: usize, j: usize| ((i * 37 + j * 101) % 97) as f64 / 97.0 - 0.5;
        let first: Vec<usize> = (0..=nodes).scan(0, |at, v| Some(std::mem::replace(at, *at + v % 3 + 1))).collect();
        let mut entries = Vec::new();
        for v in 0..nodes {
            for i in first[v]..first[v + 1] {
                for j in first[v.saturating_sub(2)]..i {
                    entries.extend([(i, j, number(i, j)), (j, i, number(i, j))]);
                }
                entries.push((i, i, 5.0));
            }
        }
        let full = Csr::from_triplets(first[nodes], first[nodes], &entries);
        (SymmetricCsr::from_full(&full, "K").unwrap(), full)
    }

    #[test]
    fn products_are_those_of_the_full_rows() {
        for nodes in [1, 2, 7, 5000] {
            let (half, full) = chain(nodes);
            half.validate("K").unwrap();
            assert!(half.full() == full && half.rows == full.rows);
            let x: Vec<f64> = (0..half.rows).map(|i| (i as f64 * 0.7).sin()).collect();
            let mut magnitudes = full.clone();
            magnitudes.value.iter_mut().for_each(|v| *v = v.abs());
            let sizes = magnitudes.times(&x.iter().map(|v| v.abs()).collect::<Vec<_>>());
            for (i, (found, expected)) in half.times(&x).iter().zip(full.times(&x)).enumerate() {
                assert!((found - expected).abs() <= 1e-15 * sizes[i], "{nodes} {i}: {found} {expected}");
            }
            for (found, expected) in half.magnitude_times(&x).iter().zip(&sizes) {
                assert!((found - expected).abs() <= 1e-15 * expected);
            }
        }
    }

    #[test]
    fn products_are_the_same_to_the_bit_for_any_number_of_threads() {
        let (half, _) = chain(5000);
        let x: Vec<f64> = (0..half.rows).map(|i| (i as f64 * 0.7).sin()).collect();
        let by = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| half.times(&x))
        };
        let one = by(1);
        assert!(one == by(2) && one == by(5));
    }

    #[test]
    fn rows_of_a_node_share_their_columns() {
        let (half, _) = chain(6);
        // Nodes of 1, 2, 3, 1, 2, 3 unknowns: the first three are coupled to all before them, the others to 5, 4 and 3.
        assert_eq!(half.column.len(), 6 + 6 + 6 + 6);
        let shares: Vec<usize> = (0..12).filter(|&i| half.shares(i)).collect();
        assert_eq!(shares, [0, 1, 2, 3, 4, 7, 9, 10]);
    }

    #[test]
    fn parts_of_the_matrix_are_those_of_the_full_rows() {
        let (half, full) = chain(40);
        let keep = [17, 3, 4, 60, 16, 5];
        assert_eq!(half.principal(&keep), full.select_rows(&keep).select_columns(&keep));
        assert!((0..half.rows).all(|i| half.diagonal(i) == 5.0 && half.entry(i, 9) == full.entry(i, 9)));
        assert!(half == SymmetricCsr::from_lower(&lower(&full), "K").unwrap());
    }

    fn lower(full: &Csr) -> Csr {
        let rows = (0..full.rows).flat_map(|i| {
            let (columns, values) = full.row(i);
            columns.iter().zip(values).map(move |(&j, &v)| (i, j as usize, v))
        });
        Csr::from_triplets(full.rows, full.cols, &rows.filter(|e| e.1 <= e.0).collect::<Vec<_>>())
    }

    #[test]
    fn an_entry_without_its_mirror_image_is_found_wherever_it_stands() {
        let with = |more: &[(usize, usize, f64)]| {
            from_full(&[&[(0, 0, 2.0), (1, 1, 2.0), (2, 2, 2.0), (0, 2, -1.0), (2, 0, -1.0)], more].concat())
        };
        assert!(with(&[]).is_ok() && with(&[(0, 1, 1e-11)]).unwrap().entry(1, 0) == 5e-12);
        for (i, j) in [(0, 1), (1, 2), (1, 0), (2, 1), (2, 0), (0, 2)] {
            assert!(with(&[(i, j, 0.5)]).unwrap_err().what.contains("not symmetric"), "({i}, {j})");
        }
    }

    #[test]
    fn a_turned_matrix_is_as_symmetric_and_differences_can_be_read() {
        let apart = |by: f64| from_full(&[(0, 0, -2.1e5), (1, 1, -2.1e5), (0, 1, 1e5 / 3.0), (1, 0, 1e5 / 3.0 + by)]);
        assert!(apart(7.3e-12).is_ok());
        let what = apart(1e-3).unwrap_err().what;
        assert_eq!(what, "not symmetric at (0, 1): 33333 and 33333, 0.001 apart");
    }

    #[test]
    fn what_is_no_lower_triangle_is_refused() {
        let above = Csr::from_triplets(3, 3, &[(0, 0, 1.0), (0, 2, 1.0)]);
        assert!(SymmetricCsr::from_lower(&above, "K").unwrap_err().what.contains("(0, 2)"));
        let flat = SymmetricCsr::from_full(&Csr::zero(2, 3), "K");
        assert!(flat.unwrap_err().what.contains("2 rows and 3 columns"));
        let good = from_full(&[(0, 0, 1.0), (1, 1, 1.0), (2, 1, 1.0), (1, 2, 1.0)]).unwrap();
        // A diagonal that is not stored is zero.
        assert!(good.validate("K").is_ok() && good.diagonal(2) == 0.0);
        let spoilt: [fn(&mut SymmetricCsr); 6] = [
            |k| k.value[1] = f64::NAN,
            |k| k.start[1] = 7,
            |k| k.first[2] = 9,
            |k| k.column[1] = 0,
            |k| k.start[3] = 1,
            |k| k.first.truncate(1),
        ];
        for spoil in spoilt {
            let mut bad = good.clone();
            spoil(&mut bad);
            assert!(bad.validate("K").is_err(), "{bad:?}");
        }
    }
}
