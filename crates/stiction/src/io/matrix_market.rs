//! Matrices and vectors as text in the Matrix Market exchange format (Boisvert, Pozo & Remington 1996).

use std::path::Path;

use crate::Error;
use crate::linalg::Csr;

/// Reads a real matrix, `coordinate` or `array`, general, symmetric or skew-symmetric; a vector is a matrix with one
/// column.
///
/// # Errors
/// If it cannot be read or breaks the format; the line is named.
pub fn read(path: &Path) -> Result<Csr, Error> {
    named(&super::file_bytes(path)?, &path.display().to_string())
}

/// The same from the bytes of a file called `name`.
///
/// # Errors
/// As [`read()`].
pub fn named(bytes: &[u8], name: &str) -> Result<Csr, Error> {
    parse(&String::from_utf8_lossy(bytes)).map_err(|(line, what)| {
        let place = if line == 0 { name.to_string() } else { format!("{name}:{line}") };
        Error::new(place, what, "give a real Matrix Market file, coordinate or array")
    })
}

/// A mistake: the number of its line, and what it is.
type Mistake = (usize, String);

#[derive(Clone, Copy, PartialEq)]
enum Symmetry {
    General,
    Symmetric,
    Skew,
}

fn parse(text: &str) -> Result<Csr, Mistake> {
    let mut lines = text.lines().enumerate().map(|(k, line)| (k + 1, line.trim()));
    let (_, head) = lines.next().ok_or((0, "the file is empty".to_string()))?;
    let words: Vec<String> = head.split_whitespace().map(str::to_lowercase).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let (coordinate, symmetry) = match words[..] {
        ["%%matrixmarket", "matrix", form @ ("coordinate" | "array"), "real" | "integer" | "double", symmetry] => {
            let symmetry = match symmetry {
                "general" => Symmetry::General,
                "symmetric" => Symmetry::Symmetric,
                "skew-symmetric" => Symmetry::Skew,
                other => return Err((1, format!("it is {other}"))),
            };
            (form == "coordinate", symmetry)
        }
        _ => return Err((1, "its first line is not %%MatrixMarket matrix coordinate|array real ...".to_string())),
    };
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('%'));
    let (at, sizes) = lines.next().ok_or((0, "its sizes are missing".to_string()))?;
    let sizes: Vec<usize> = sizes
        .split_whitespace()
        .map(|n| n.parse().map_err(|_| (at, format!("\"{n}\" is no size"))))
        .collect::<Result<_, Mistake>>()?;
    let (rows, cols, count) = match (coordinate, &sizes[..]) {
        (true, &[rows, cols, count]) => (rows, cols, count),
        (false, &[rows, cols]) => {
            let triangle = |n: usize| n.checked_add(1).and_then(|k| n.checked_mul(k)).map(|k| k / 2);
            let count = match symmetry {
                Symmetry::General => rows.checked_mul(cols),
                Symmetry::Symmetric => triangle(rows),
                Symmetry::Skew => triangle(rows).map(|k| k - rows),
            };
            (rows, cols, count.ok_or((at, "its sizes are too large".to_string()))?)
        }
        _ => return Err((at, format!("{} sizes", sizes.len()))),
    };
    // A row or column takes its digits somewhere: nothing larger is reserved.
    if rows.max(cols) > text.len().max(1) || count > text.len() {
        return Err((at, format!("{rows} x {cols} with {count} entries in a file of {} bytes", text.len())));
    }
    if symmetry != Symmetry::General && rows != cols {
        return Err((at, format!("{rows} x {cols} cannot be symmetric")));
    }
    let mut entries = Vec::with_capacity(2 * count);
    let (mut last, mut i, mut j) = (at, usize::from(symmetry == Symmetry::Skew), 0);
    for (line, text) in lines {
        last = line;
        if entries.len() >= 2 * count && count > 0 || count == 0 {
            return Err((line, format!("more than {count} entries")));
        }
        let (row, column, value) = if coordinate {
            coordinates(text, rows, cols).map_err(|what| (line, what))?
        } else {
            let place = (i, j);
            i += 1;
            if i == rows {
                j += 1;
                i = match symmetry {
                    Symmetry::General => 0,
                    Symmetry::Symmetric => j,
                    Symmetry::Skew => j + 1,
                };
            }
            (place.0, place.1, number(text).map_err(|what| (line, what))?)
        };
        entries.push((row, column, value));
        // A mirrored entry, or a place holder that keeps the count.
        let mirrored = if row == column { 0.0 } else { value };
        entries.push(match symmetry {
            Symmetry::General => (row, column, 0.0),
            Symmetry::Symmetric => (column, row, mirrored),
            Symmetry::Skew => (column, row, -mirrored),
        });
    }
    if entries.len() != 2 * count {
        return Err((last, format!("{} entries where {count} are announced", entries.len() / 2)));
    }
    Ok(Csr::from_triplets(rows, cols, &entries))
}

fn number(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(format!("\"{text}\" is no finite number")),
    }
}

/// A line of row, column (from one) and value.
fn coordinates(text: &str, rows: usize, cols: usize) -> Result<(usize, usize, f64), String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let [i, j, value] = words[..] else { return Err("a line holds a row, a column and a value".to_string()) };
    let index = |word: &str, limit: usize| match word.parse::<usize>() {
        Ok(k) if k >= 1 && k <= limit => Ok(k - 1),
        _ => Err(format!("\"{word}\" is not between 1 and {limit}")),
    };
    Ok((index(i, rows)?, index(j, cols)?, number(value)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_forms_of_one_matrix_are_equal() {
        let wanted = Csr::from_triplets(2, 2, &[(0, 0, 2.0), (0, 1, -1.5), (1, 0, -1.5), (1, 1, 0.5)]);
        let head = "%%MatrixMarket matrix";
        for text in [
            format!("{head} coordinate real general\n% a note\n\n2 2 5\n1 1 1\n1 1 1\n1 2 -1.5\n2 1 -1.5\n2 2 .5\n"),
            format!("{head} coordinate real symmetric\n2 2 3\n1 1 2\n2 1 -15e-1\n2 2 0.5"),
            format!("{head} array real general\n2 2\n2\n-1.5\n-1.5\n0.5"),
            format!("{head} array real symmetric\n2 2\n2\n-1.5\n0.5"),
        ] {
            assert_eq!(parse(&text), Ok(wanted.clone()), "{text}");
        }
        let skew = parse(&format!("{head} array integer skew-symmetric\n2 2\n3")).unwrap();
        assert_eq!((skew.entry(1, 0), skew.entry(0, 1)), (3.0, -3.0));
    }

    #[test]
    fn mistakes_are_told_with_their_line() {
        let head = "%%MatrixMarket matrix coordinate real general\n";
        let cases = [
            ("".to_string(), 0),
            ("1 2 3".to_string(), 1),
            ("%%MatrixMarket matrix coordinate complex general\n1 1 0".to_string(), 1),
            (format!("{head}2 2"), 2),
            (format!("{head}2 2 1\n3 1 1.0"), 3),
            (format!("{head}2 2 1\n0 1 1.0"), 3),
            (format!("{head}2 2 1\n1 1 nan"), 3),
            (format!("{head}2 2 1\n1 1 1\n2 2 1"), 4),
            (format!("{head}2 2 2\n1 1 1"), 3),
            (format!("{head}99999999999 2 1\n1 1 1"), 2),
            ("%%MatrixMarket matrix array real general\n9999999999 9999999999\n1".to_string(), 2),
        ];
        for (text, line) in cases {
            assert_eq!(parse(&text).unwrap_err().0, line, "{text}");
        }
    }
}
