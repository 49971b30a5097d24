use std::path::Path;

use super::Head;
use crate::Error;
use crate::io::npz::{self, Arrays, f64s, text, usizes};
use crate::io::problem::damaged;

/// A file with its arrays.
pub(super) struct Piece {
    pub path: String,
    pub arrays: Arrays,
}

impl Piece {
    pub(super) fn read(folder: &Path, name: &str) -> Result<Piece, Error> {
        let path = folder.join(name);
        Ok(Piece { path: path.display().to_string(), arrays: npz::read(&path)? })
    }

    /// What `find` finds in its arrays, with its path on errors.
    pub(super) fn get<T>(&self, find: impl FnOnce(&Arrays) -> Result<T, Error>) -> Result<T, Error> {
        find(&self.arrays).map_err(|error| error.at(&self.path))
    }

    pub(super) fn head(&self) -> Result<Head, Error> {
        self.get(|arrays| {
            let run = u64::from_str_radix(text(arrays, "run")?, 16);
            match (run, &usizes(arrays, "piece", Some(2))?[..]) {
                (Ok(run), &[rank, ranks]) if rank < ranks => Ok(Head { run, rank, ranks }),
                _ => Err(damaged("it does not say which piece of which run it is")),
            }
        })
    }

    /// Refuses the piece of another run, or of another rank.
    pub(super) fn expect(&self, expected: &Head, first: &str) -> Result<(), Error> {
        let head = self.head()?;
        let fail =
            |what: String| Err(Error::new(&self.path, what, "put back the file of this run, or solve the case again"));
        if (head.run, head.ranks) != (expected.run, expected.ranks) {
            return fail(format!("it is of another run than {first}"));
        }
        if head.rank != expected.rank {
            return fail(format!("it is the piece of rank {}, and its name says rank {}", head.rank, expected.rank));
        }
        Ok(())
    }

    pub(super) fn f64s(&self, name: &str, length: usize) -> Result<Vec<f64>, Error> {
        self.get(|arrays| f64s(arrays, name, Some(length)).map(<[f64]>::to_vec))
    }

    pub(super) fn numbers(&self, name: &str) -> Result<Vec<u64>, Error> {
        self.get(|arrays| Ok(usizes(arrays, name, None)?.into_iter().map(|number| number as u64).collect()))
    }
}
