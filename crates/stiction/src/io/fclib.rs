//! Discrete frictional contact problems as the collection FCLib exchanges them, in HDF5 (Acary, Brémond, Koziara &
//! Pérignon 2014, "FCLIB: a collection of discrete 3D frictional contact problems").
//!
//! Reading trusts nothing: indices, lengths and counts are checked against one another and against the size of the
//! file before anything is reserved.

use std::path::Path;

use hdf5_pure::{DType, File, Group};

use super::Contents;
use super::storage::{Storage, matrix};
use crate::Error;
use crate::discrete::{Bilateral, DiscreteProblem, Equalities, GlobalProblem, LocalProblem};
use crate::linalg::Csr;

/// Most guesses read.
const GUESSES: i32 = 64;
/// Chunks of this many bytes may be larger than their file.
const SMALL: u64 = 1 << 16;
/// No filter of HDF5 expands its input by more (that of deflate).
const EXPANSION: u64 = 1032;

/// Reads a file and checks its problem.
///
/// # Errors
/// If it cannot be read, is damaged, or holds a problem with rolling friction; the group or array is named.
pub fn read(path: &Path) -> Result<Contents, Error> {
    parse(super::file_bytes(path)?).map_err(|error| error.at(&path.display().to_string()))
}

/// The same from the bytes of a file.
///
/// # Errors
/// As [`read()`].
pub fn parse(bytes: Vec<u8>) -> Result<Contents, Error> {
    let size = bytes.len() as u64;
    let file = File::from_bytes(bytes).map_err(|e| damaged("", &format!("it is not a whole HDF5 file ({e})")))?;
    let root = Node { group: file.root(), path: String::new(), size };
    let names = root.groups()?;
    let has = |name: &str| names.iter().any(|n| n == name);
    if has("fclib_global_rolling") || has("fclib_local_rolling") {
        let what = "the problem has rolling friction";
        return Err(Error::new("", what, "only contact with sliding friction is solved"));
    }
    let problem = match (has("fclib_local"), has("fclib_global")) {
        (true, false) => DiscreteProblem::Local(local(&root.group("fclib_local")?)?),
        (false, true) => DiscreteProblem::Global(global(&root.group("fclib_global")?)?),
        (true, true) => return Err(damaged("", "it holds both fclib_local and fclib_global")),
        (false, false) => {
            let what = "there is neither fclib_local nor fclib_global in it";
            return Err(Error::new("", what, "give a file of the collection FCLib, or one written by this program"));
        }
    };
    problem.validate()?;
    let wanted = problem.dimension() * problem.points();
    let solution = if has("solution") { impulses(&root.group("solution")?, wanted)? } else { None };
    let guesses = if has("guesses") { guesses(&root.group("guesses")?, wanted)? } else { Vec::new() };
    Ok(Contents { problem, solution, guesses })
}

fn damaged(place: &str, what: &str) -> Error {
    Error::new(place, what, "the file is damaged or not of the format FCLib; write it again")
}

/// A group, where it lies, and the size of the file.
struct Node {
    group: Group,
    path: String,
    size: u64,
}

impl Node {
    fn damaged(&self, name: &str, what: &str) -> Error {
        damaged(&format!("{}/{name}", self.path), what)
    }

    fn groups(&self) -> Result<Vec<String>, Error> {
        self.group.groups().map_err(|e| damaged(&self.path, &format!("its groups cannot be listed ({e})")))
    }

    fn group(&self, name: &str) -> Result<Node, Error> {
        let group = self.group.group(name).map_err(|e| self.damaged(name, &format!("there is no such group ({e})")))?;
        Ok(Node { group, path: format!("{}/{name}", self.path), size: self.size })
    }

    fn has_group(&self, name: &str) -> Result<bool, Error> {
        Ok(self.groups()?.iter().any(|n| n == name))
    }

    /// Opens a dataset whose length fits the file.
    fn dataset(&self, name: &str) -> Result<hdf5_pure::Dataset, Error> {
        let unreadable = |e: hdf5_pure::Error| self.damaged(name, &format!("there is no such array ({e})"));
        let dataset = self.group.dataset(name).map_err(unreadable)?;
        let shape = dataset.shape().map_err(unreadable)?;
        // Without filters no array is larger than the file; with them no larger than what its stored chunks expand to.
        let limit = if dataset.filters().is_empty() {
            self.size
        } else {
            let stored = dataset.chunks().map_or(self.size, |all| all.iter().map(|c| c.storage_size).sum());
            stored.min(self.size).saturating_mul(EXPANSION)
        };
        let chunk = dataset.chunk_shape().map_err(unreadable)?.unwrap_or_default();
        for shape in [&shape, &chunk] {
            let numbers = shape.iter().try_fold(1u64, |n, &k| n.checked_mul(k));
            if numbers.and_then(|n| n.checked_mul(4)).is_none_or(|b| b > limit.max(SMALL)) {
                let what = format!("its shape {shape:?} is beyond the {} bytes of the file", self.size);
                return Err(self.damaged(name, &what));
            }
        }
        Ok(dataset)
    }

    /// The numbers of an array of these kinds, which are `wanted`.
    fn numbers<T>(
        &self,
        name: &str,
        kinds: &[DType],
        wanted: &str,
        read: fn(&hdf5_pure::Dataset) -> Result<Vec<T>, hdf5_pure::Error>,
    ) -> Result<Vec<T>, Error> {
        let dataset = self.dataset(name)?;
        match dataset.dtype() {
            Ok(kind) if kinds.contains(&kind) => {
                read(&dataset).map_err(|e| self.damaged(name, &format!("it cannot be read ({e})")))
            }
            Ok(kind) => Err(self.damaged(name, &format!("it holds {kind} where {wanted} are needed"))),
            Err(e) => Err(self.damaged(name, &format!("its type cannot be read ({e})"))),
        }
    }

    fn integers(&self, name: &str) -> Result<Vec<i32>, Error> {
        let kinds = [DType::I32, DType::I16, DType::I8, DType::U16, DType::U8];
        self.numbers(name, &kinds, "integers of 32 bits", hdf5_pure::Dataset::read_i32)
    }

    fn reals(&self, name: &str) -> Result<Vec<f64>, Error> {
        self.numbers(name, &[DType::F64, DType::F32], "reals", hdf5_pure::Dataset::read_f64)
    }

    fn integer(&self, name: &str) -> Result<i32, Error> {
        match self.integers(name)?[..] {
            [value] => Ok(value),
            ref values => Err(self.damaged(name, &format!("it holds {} numbers instead of one", values.len()))),
        }
    }

    fn count(&self, name: &str) -> Result<usize, Error> {
        let value = self.integer(name)?;
        usize::try_from(value).map_err(|_| self.damaged(name, &format!("it is {value}, no count")))
    }

    fn matrix(&self, name: &str) -> Result<Csr, Error> {
        let node = self.group(name)?;
        let (rows, cols) = (node.count("m")?, node.count("n")?);
        // Each row and column goes with a number of some vector, so that the order cannot exceed the file.
        for (name, count) in [("m", rows), ("n", cols)] {
            if count as u64 > self.size {
                return Err(node.damaged(name, &format!("it is {count} in a file of {} bytes", self.size)));
            }
        }
        let storage = match node.integer("nz")? {
            -1 => Storage::Columns,
            -2 => Storage::Rows,
            nz => {
                let nz = usize::try_from(nz).map_err(|_| {
                    node.damaged("nz", &format!("it is {nz}: neither a count nor -1 (columns) nor -2 (rows)"))
                })?;
                Storage::Triplets(nz)
            }
        };
        let (p, i, x) = (node.integers("p")?, node.integers("i")?, node.reals("x")?);
        matrix(storage, rows, cols, &p, &i, &x).map_err(|what| damaged(&node.path, &what))
    }
}

fn local(node: &Node) -> Result<LocalProblem, Error> {
    let vectors = node.group("vectors")?;
    let bilateral = match (node.has_group("V")?, node.has_group("R")?) {
        (true, true) => Some(Bilateral { V: node.matrix("V")?, R: node.matrix("R")?, s: vectors.reals("s")? }),
        (false, false) => None,
        _ => return Err(damaged(&node.path, "it holds one of V and R but not the other")),
    };
    Ok(LocalProblem {
        dimension: dimension(node)?,
        W: node.matrix("W")?,
        q: vectors.reals("q")?,
        mu: vectors.reals("mu")?,
        bilateral,
    })
}

fn global(node: &Node) -> Result<GlobalProblem, Error> {
    let vectors = node.group("vectors")?;
    let equalities = match node.has_group("G")? {
        true => Some(Equalities { G: node.matrix("G")?, b: vectors.reals("b")? }),
        false => None,
    };
    Ok(GlobalProblem {
        dimension: dimension(node)?,
        M: node.matrix("M")?,
        H: node.matrix("H")?,
        f: vectors.reals("f")?,
        w: vectors.reals("w")?,
        mu: vectors.reals("mu")?,
        equalities,
    })
}

fn dimension(node: &Node) -> Result<usize, Error> {
    match node.count("spacedim")? {
        d @ (2 | 3) => Ok(d),
        d => Err(node.damaged("spacedim", &format!("it is {d}, neither 2 nor 3"))),
    }
}

/// The impulses `r` of a group, if they have the wanted length.
fn impulses(node: &Node, wanted: usize) -> Result<Option<Vec<f64>>, Error> {
    let names = node.group.datasets().map_err(|e| damaged(&node.path, &format!("it cannot be listed ({e})")))?;
    if !names.iter().any(|n| n == "r") {
        return Ok(None);
    }
    let r = node.reals("r")?;
    if r.len() != wanted {
        return Err(node.damaged("r", &format!("it has {} numbers where {wanted} are needed", r.len())));
    }
    Ok(Some(r))
}

fn guesses(node: &Node, wanted: usize) -> Result<Vec<Vec<f64>>, Error> {
    let count = node.integer("number_of_guesses")?;
    let all = (1..=count.min(GUESSES)).map(|k| impulses(&node.group(&k.to_string())?, wanted));
    Ok(all.collect::<Result<Vec<_>, Error>>()?.into_iter().flatten().collect())
}
