//! Discrete problems from named arrays: a NumPy file (`.npz`) or a folder of Matrix Market files.
//!
//! ```text
//! W q mu            local:   u = W r + q, point by point
//! M H f w mu        global:  M v = H r + f, u = H' v + w
//! K B f gap mu      as this library poses it: K u = f - B' lambda, B = [N; T1; T2], N u <= gap
//! ```
//! `mu` may be called `friction`. In a NumPy file a matrix `A` is a dense array `A` in C order or the arrays `A_data`,
//! `A_indices`, `A_indptr` and `A_shape` of compressed rows as SciPy has them; in a folder it is `A.mtx`.

use std::path::Path;

use super::npz::{self, Arrays, Data};
use super::storage::{Storage, matrix};
use super::{Contents, matrix_market};
use crate::Error;
use crate::contact::{ContactProblem, Friction};
use crate::discrete::{DiscreteProblem, GlobalProblem, LocalProblem};
use crate::linalg::{Csr, SymmetricCsr};

/// Where arrays come from.
trait Source {
    fn has(&self, name: &str) -> bool;
    fn matrix(&self, name: &str) -> Result<Csr, Error>;
    fn vector(&self, name: &str) -> Result<Vec<f64>, Error>;
}

/// Reads a NumPy file.
///
/// # Errors
/// What is missing or wrong, with the name of the array.
pub fn read_npz(path: &Path) -> Result<Contents, Error> {
    contents(&Npz(npz::read(path)?)).map_err(|error| error.at(&path.display().to_string()))
}

/// The same from the bytes of a file.
///
/// # Errors
/// As [`read_npz()`].
pub fn parse_npz(bytes: &[u8]) -> Result<Contents, Error> {
    contents(&Npz(npz::parse(bytes)?))
}

/// Reads a folder of Matrix Market files.
///
/// # Errors
/// What is missing or wrong, with the name of the file.
pub fn read_folder(path: &Path) -> Result<Contents, Error> {
    contents(&Folder(path)).map_err(|error| error.at(&path.display().to_string()))
}

fn contents(source: &dyn Source) -> Result<Contents, Error> {
    let mu = || source.vector(if source.has("mu") { "mu" } else { "friction" });
    let problem = if source.has("W") {
        let (W, q, mu) = (source.matrix("W")?, source.vector("q")?, mu()?);
        let dimension = dimension(q.len(), mu.len());
        DiscreteProblem::Local(LocalProblem { dimension, W, q, mu, bilateral: None })
    } else if source.has("M") {
        let (M, H) = (source.matrix("M")?, source.matrix("H")?);
        let (f, w, mu) = (source.vector("f")?, source.vector("w")?, mu()?);
        let dimension = dimension(w.len(), mu.len());
        DiscreteProblem::Global(GlobalProblem { dimension, M, H, f, w, mu, equalities: None })
    } else if source.has("K") {
        let coulomb = |&coefficient: &f64| Friction::Coulomb { coefficient };
        let laws = mu()?.iter().map(coulomb).collect();
        let (K, B) = (source.matrix("K")?, source.matrix("B")?);
        let K = SymmetricCsr::from_full(&K, "K")?;
        let posed = ContactProblem::from_matrices(K, source.vector("f")?, B, source.vector("gap")?, laws);
        posed.validate()?;
        DiscreteProblem::Global(GlobalProblem::of(&posed)?)
    } else {
        let remedy = "give W, q, mu or M, H, f, w, mu or K, B, f, gap, mu";
        return Err(Error::new("", "there is no matrix W, M or K in it", remedy));
    };
    problem.validate()?;
    Ok(Contents { problem, solution: None, guesses: Vec::new() })
}

/// Components of a point; checked with everything else.
fn dimension(components: usize, points: usize) -> usize {
    components.checked_div(points).unwrap_or(3)
}

struct Npz(Arrays);

impl Source for Npz {
    fn has(&self, name: &str) -> bool {
        self.0.contains_key(name) || self.0.contains_key(&format!("{name}_data"))
    }

    fn matrix(&self, name: &str) -> Result<Csr, Error> {
        if let Some(array) = self.0.get(name) {
            return match (&array.data, &array.shape[..]) {
                (Data::F64(values), &[rows, cols]) if !values.is_empty() => {
                    let place = |(k, &v): (usize, &f64)| (k / cols, k % cols, v);
                    let entries: Vec<_> = values.iter().enumerate().map(place).filter(|e| e.2 != 0.0).collect();
                    Ok(Csr::from_triplets(rows, cols, &entries))
                }
                _ => Err(Error::new(name, "it is no matrix of float64", "give an array with two axes")),
            };
        }
        let sparse = |part: &str| format!("{name}_{part}");
        let shape = npz::usizes(&self.0, &sparse("shape"), Some(2))?;
        let indices = |part: &str| -> Result<Vec<i32>, Error> {
            let too_large = || Error::new(sparse(part), "an index is beyond 32 bits", "give a smaller matrix");
            let all = npz::usizes(&self.0, &sparse(part), None)?;
            all.into_iter().map(|k| i32::try_from(k).map_err(|_| too_large())).collect()
        };
        let values = npz::f64s(&self.0, &sparse("data"), None)?;
        let (p, i) = (indices("indptr")?, indices("indices")?);
        // Each row has its pointer; each column belongs to a number of some vector.
        if shape[0] >= p.len() || shape[1] > self.0.values().map(|a| a.shape.iter().product()).max().unwrap_or(0) {
            return Err(Error::new(sparse("shape"), format!("it is {shape:?}"), "give the shape of the matrix"));
        }
        matrix(Storage::Rows, shape[0], shape[1], &p, &i, values)
            .map_err(|what| Error::new(name, what, "give compressed rows as SciPy has them"))
    }

    fn vector(&self, name: &str) -> Result<Vec<f64>, Error> {
        npz::f64s(&self.0, name, None).map(<[f64]>::to_vec)
    }
}

struct Folder<'a>(&'a Path);

impl Source for Folder<'_> {
    fn has(&self, name: &str) -> bool {
        self.0.join(format!("{name}.mtx")).is_file()
    }

    fn matrix(&self, name: &str) -> Result<Csr, Error> {
        matrix_market::read(&self.0.join(format!("{name}.mtx")))
    }

    fn vector(&self, name: &str) -> Result<Vec<f64>, Error> {
        let matrix = self.matrix(name)?;
        match (matrix.rows, matrix.cols) {
            (rows, 1) => Ok((0..rows).map(|i| matrix.entry(i, 0)).collect()),
            (1, cols) => Ok((0..cols).map(|j| matrix.entry(0, j)).collect()),
            (rows, cols) => Err(Error::new(name, format!("it is {rows} x {cols}"), "give a matrix with one column")),
        }
    }
}
