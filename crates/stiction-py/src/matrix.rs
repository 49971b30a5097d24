//! Sparse matrices from the arrays of SciPy: compressed rows with indices of 32 or 64 bits.

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use stiction::linalg::Stop;
use stiction::{Csr, Error, SymmetricCsr};

/// `(rows, columns, indptr, indices, data)` with ascending columns; the Python side sees to types and contiguity.
#[derive(FromPyObject)]
pub(crate) struct Rows<'py>(usize, usize, Index<'py>, Index<'py>, PyReadonlyArray1<'py, f64>);

#[derive(FromPyObject)]
enum Index<'py> {
    I32(PyReadonlyArray1<'py, i32>),
    I64(PyReadonlyArray1<'py, i64>),
}

/// A view of the same, which needs no interpreter.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) rows: usize,
    pub(crate) cols: usize,
    start: Whole<'a>,
    column: Whole<'a>,
    value: &'a [f64],
}

#[derive(Clone, Copy)]
enum Whole<'a> {
    I32(&'a [i32]),
    I64(&'a [i64]),
}

impl Whole<'_> {
    fn len(self) -> usize {
        match self {
            Whole::I32(list) => list.len(),
            Whole::I64(list) => list.len(),
        }
    }

    /// The number at `i`; negative ones become so large that no check passes them.
    fn at(self, i: usize) -> usize {
        match self {
            Whole::I32(list) => usize::try_from(list[i]).unwrap_or(usize::MAX),
            Whole::I64(list) => usize::try_from(list[i]).unwrap_or(usize::MAX),
        }
    }
}

impl Index<'_> {
    fn view(&self) -> PyResult<Whole<'_>> {
        Ok(match self {
            Index::I32(list) => Whole::I32(list.as_slice()?),
            Index::I64(list) => Whole::I64(list.as_slice()?),
        })
    }
}

impl Rows<'_> {
    pub(crate) fn view(&self) -> PyResult<View<'_>> {
        Ok(View {
            rows: self.0,
            cols: self.1,
            start: self.2.view()?,
            column: self.3.view()?,
            value: self.4.as_slice()?,
        })
    }
}

/// Where a row or a column of the given matrix goes: its new number, or `DROPPED`. Ascending.
pub(crate) const DROPPED: u32 = u32::MAX;

/// Relative difference of two mirror images that different orders of summation explain, as in the library.
const ROUNDING: f64 = 1e-10;

impl View<'_> {
    /// Checks what the loops below rely on.
    pub(crate) fn check(&self, name: &str, stop: &Stop) -> Result<(), Error> {
        let wrong = |what: String| Err(Error::new(name, what, "give a matrix as scipy.sparse makes it"));
        let entries = self.value.len();
        if self.start.len() != self.rows + 1 || self.column.len() != entries || self.start.at(0) != 0 {
            return wrong(format!("indptr and indices do not fit {} rows and {entries} entries", self.rows));
        }
        if u32::try_from(self.cols.max(self.rows)).is_err() {
            return wrong(format!("{} rows and {} columns are too many", self.rows, self.cols));
        }
        for i in 0..self.rows {
            now_and_then(i, stop)?;
            let (begin, end) = (self.start.at(i), self.start.at(i + 1));
            if begin > end || end > entries {
                return wrong(format!("indptr descends at row {i}"));
            }
            let mut least = 0;
            for k in begin..end {
                let j = self.column.at(k);
                if j < least || j >= self.cols {
                    return wrong(format!("the columns of row {i} do not ascend below {}", self.cols));
                }
                least = j + 1;
                if !self.value[k].is_finite() {
                    let what = format!("the entry ({i}, {j}) is {}", self.value[k]);
                    return Err(Error::new(name, what, "give finite numbers"));
                }
            }
        }
        if self.start.at(self.rows) != entries {
            return wrong(format!("indptr ends before the {entries} entries"));
        }
        Ok(())
    }

    fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.start.at(i)..self.start.at(i + 1)
    }

    /// The rows `rows` with the columns that `place` keeps, of which there are `cols`.
    pub(crate) fn part(
        &self,
        rows: impl ExactSizeIterator<Item = usize>,
        place: impl Fn(usize) -> u32,
        cols: usize,
    ) -> Csr {
        let mut part = Csr::zero(rows.len(), cols);
        for (new, i) in rows.enumerate() {
            for k in self.range(i) {
                let j = place(self.column.at(k));
                if j != DROPPED {
                    part.column.push(j);
                    part.value.push(self.value[k]);
                }
            }
            part.start[new + 1] = part.column.len();
        }
        part
    }

    /// The lower triangle of the `kept` rows and columns of a symmetric matrix, in one pass and with no other copy. `None`
    /// where its two triangles do not hold the same places.
    fn lower(&self, place: &[u32], name: &str, stop: &Stop) -> Result<Option<SymmetricCsr>, Error> {
        // The next entry right of the diagonal that its mirror image has not asked for yet: rows ask in ascending order.
        let mut next = vec![0usize; self.rows];
        let mut matrix = SymmetricCsr::default();
        // Grown by doubling it would be there twice for a moment.
        matrix.value.reserve_exact(self.value.len().midpoint(self.rows));
        let (mut columns, mut values) = (Vec::new(), Vec::new());
        for i in (0..self.rows).filter(|&i| place[i] != DROPPED) {
            now_and_then(i, stop)?;
            columns.clear();
            values.clear();
            let mut diagonal = None;
            let range = self.range(i);
            next[i] = range.end;
            for k in range {
                let j = self.column.at(k);
                if j > i {
                    next[i] = k;
                    break;
                }
                let value = self.value[k];
                if j == i {
                    diagonal = Some(value);
                } else if place[j] != DROPPED {
                    let end = self.start.at(j + 1);
                    while next[j] < end && place[self.column.at(next[j])] == DROPPED {
                        next[j] += 1;
                    }
                    if next[j] >= end || self.column.at(next[j]) != i {
                        return Ok(None);
                    }
                    let mirrored = self.value[next[j]];
                    next[j] += 1;
                    // Both diagonals stand in rows that were passed, this one's at the end of its left part.
                    if mirrored != value {
                        let largest = self.entry(i, i).abs().max(self.entry(j, j).abs());
                        if (mirrored - value).abs() > ROUNDING * largest {
                            return Err(SymmetricCsr::not_symmetric(name, j, i, mirrored, value));
                        }
                    }
                    columns.push(place[j]);
                    values.push(if mirrored == value { value } else { 0.5 * (value + mirrored) });
                }
            }
            let Some(diagonal) = diagonal else { return Ok(None) };
            matrix.push_row(&columns, &values, diagonal);
        }
        let unasked = |j: usize| (next[j]..self.start.at(j + 1)).any(|k| place[self.column.at(k)] != DROPPED);
        let asymmetric = (0..self.rows).any(|j| place[j] != DROPPED && unasked(j));
        Ok((!asymmetric).then_some(matrix))
    }

    fn entry(&self, i: usize, j: usize) -> f64 {
        self.range(i).find(|&k| self.column.at(k) == j).map_or(0.0, |k| self.value[k])
    }

    /// Every kept unknown needs a stiffness. Looked at first: of a matrix with the wrong sign nothing else is worth saying.
    fn check_diagonal(&self, place: &[u32], count: usize, name: &str) -> Result<(), Error> {
        let mut bad = (0..self.rows).filter(|&i| place[i] != DROPPED && self.entry(i, i) <= 0.0);
        let Some(i) = bad.next() else { return Ok(()) };
        let what = format!("the diagonal entry of unknown {i} is {}", Error::number(self.entry(i, i)));
        let remedy = match bad.count() + 1 {
            all if all == count && self.entry(i, i) < 0.0 => {
                "so are all others: give the stiffness with the other sign"
            }
            _ => "give a stiffness: every unknown that is not held needs one, larger than zero",
        };
        Err(Error::new(name, what, remedy))
    }

    /// The kept part of a symmetric matrix.
    pub(crate) fn symmetric(
        &self,
        place: &[u32],
        count: usize,
        name: &str,
        stop: &Stop,
    ) -> Result<SymmetricCsr, Error> {
        if self.rows != self.cols {
            let what = format!("{} rows and {} columns", self.rows, self.cols);
            return Err(Error::new(name, what, "give a square matrix"));
        }
        self.check_diagonal(place, count, name)?;
        if let Some(lower) = self.lower(place, name, stop)? {
            return Ok(lower);
        }
        let kept: Vec<usize> = (0..self.rows).filter(|&i| place[i] != DROPPED).collect();
        SymmetricCsr::from_full(&self.part(kept.into_iter(), |j| place[j], count), name)
    }
}

/// Asks for a stop at some rows.
fn now_and_then(row: usize, stop: &Stop) -> Result<(), Error> {
    if row.is_multiple_of(4096) { stop.check() } else { Ok(()) }
}

/// A matrix for Python: `(rows, columns, indptr, indices, data)`.
pub(crate) fn rows(py: Python<'_>, matrix: Csr) -> PyResult<Bound<'_, PyAny>> {
    let Csr { rows, cols, start, column, value } = matrix;
    let start = PyArray1::from_iter(py, start.into_iter().map(|i| i as i64));
    let column = PyArray1::from_iter(py, column.into_iter().map(i64::from));
    Ok((rows, cols, start, column, PyArray1::from_vec(py, value)).into_pyobject(py)?.into_any())
}

/// Rows of three numbers.
pub(crate) fn triples(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[f64; 3]>> {
    Ok(array.as_slice()?.as_chunks::<3>().0.to_vec())
}
