//! Matrices by triplets, compressed columns or compressed rows with indices from files.

use crate::linalg::Csr;

/// How a matrix is stored by `p`, `i` and `x`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Storage {
    /// So many triplets: row `i`, column `p`; equal places are added.
    Triplets(usize),
    /// `p` points to the begin of each column, `i` are rows.
    Columns,
    /// `p` points to the begin of each row, `i` are columns.
    Rows,
}

/// The matrix, or what is wrong with its arrays. Arrays may be longer than what is used of them.
///
/// # Errors
/// What is wrong with the arrays, as a sentence.
pub fn matrix(storage: Storage, rows: usize, cols: usize, p: &[i32], i: &[i32], x: &[f64]) -> Result<Csr, String> {
    let entries = match storage {
        Storage::Triplets(count) => {
            if count > p.len().min(i.len()).min(x.len()) {
                let lengths = format!("{}, {} and {}", p.len(), i.len(), x.len());
                return Err(format!("{count} triplets are announced, but p, i and x have {lengths} numbers"));
            }
            (0..count).map(|k| entry(rows, cols, i[k], p[k], x[k])).collect::<Result<Vec<_>, String>>()?
        }
        Storage::Columns => {
            let at = |c: usize, k: usize| entry(rows, cols, i[k], c as i32, x[k]);
            compressed("columns", cols, p, i.len().min(x.len()), at)?
        }
        Storage::Rows => {
            let at = |r: usize, k: usize| entry(rows, cols, r as i32, i[k], x[k]);
            compressed("rows", rows, p, i.len().min(x.len()), at)?
        }
    };
    // Columns are numbered by 32 bits.
    if u32::try_from(rows.max(cols)).is_err() {
        return Err(format!("a matrix of {rows} x {cols} is too large"));
    }
    let matrix = Csr::from_triplets(rows, cols, &entries);
    match matrix.value.iter().find(|x| !x.is_finite()) {
        Some(x) => Err(format!("it holds the value {x}")),
        None => Ok(matrix),
    }
}

type Entry = (usize, usize, f64);

fn entry(rows: usize, cols: usize, i: i32, j: i32, x: f64) -> Result<Entry, String> {
    match (usize::try_from(i), usize::try_from(j)) {
        (Ok(i), Ok(j)) if i < rows && j < cols => Ok((i, j, x)),
        _ => Err(format!("entry ({i}, {j}) lies outside {rows} x {cols}")),
    }
}

fn compressed(
    name: &str,
    count: usize,
    p: &[i32],
    available: usize,
    at: impl Fn(usize, usize) -> Result<Entry, String>,
) -> Result<Vec<Entry>, String> {
    if p.len() <= count {
        return Err(format!("{count} {name} need {} pointers, p has {}", count + 1, p.len()));
    }
    let mut entries = Vec::new();
    let mut begin = 0;
    for (c, &end) in p[..=count].iter().enumerate() {
        let end = usize::try_from(end).map_err(|_| format!("pointer {c} of its {name} is {end}"))?;
        if end < begin || end > available || (c == 0 && end != 0) {
            return Err(format!("pointer {c} of its {name} is {end} with {available} entries"));
        }
        for k in begin..end {
            entries.push(at(c - 1, k)?);
        }
        begin = end;
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_storages_of_one_matrix_are_equal() {
        // [[1, 0, 2], [0, 5, 3]] with the 5 in two parts and rows unsorted.
        let triplets =
            matrix(Storage::Triplets(5), 2, 3, &[2, 0, 1, 2, 1, 9], &[0, 0, 1, 1, 1, 9], &[2., 1., 4., 3., 1., 0.]);
        let columns = matrix(Storage::Columns, 2, 3, &[0, 1, 2, 4], &[0, 1, 1, 0], &[1., 5., 3., 2.]);
        let rows = matrix(Storage::Rows, 2, 3, &[0, 2, 4], &[2, 0, 1, 2], &[2., 1., 5., 3.]);
        let wanted = Csr::from_triplets(2, 3, &[(0, 0, 1.), (0, 2, 2.), (1, 1, 5.), (1, 2, 3.)]);
        assert_eq!(triplets.as_ref(), Ok(&wanted));
        assert_eq!(columns.as_ref(), Ok(&wanted));
        assert_eq!(rows.as_ref(), Ok(&wanted));
    }

    #[test]
    fn damaged_arrays_are_refused() {
        let (c, r, t) = (Storage::Columns, Storage::Rows, Storage::Triplets(2));
        type Case<'a> = (Storage, &'a [i32], &'a [i32], &'a [f64]);
        let cases: [Case; 9] = [
            (t, &[0], &[0], &[1.0]),
            (t, &[0, 2], &[0, 0], &[1.0, 1.0]),
            (t, &[0, 0], &[0, -1], &[1.0, 1.0]),
            (t, &[0, 1], &[0, 1], &[1.0, f64::NAN]),
            (c, &[0, 1], &[0], &[1.0]),
            (c, &[0, 1, 3], &[0, 1], &[1.0, 1.0]),
            (c, &[0, 2, 1], &[0, 1], &[1.0, 1.0]),
            (r, &[1, 1, 2], &[0, 1], &[1.0, 1.0]),
            (r, &[0, -1, 2], &[0, 1], &[1.0, 1.0]),
        ];
        for (storage, p, i, x) in cases {
            assert!(matrix(storage, 2, 2, p, i, x).is_err(), "{storage:?} {p:?}");
        }
    }
}
