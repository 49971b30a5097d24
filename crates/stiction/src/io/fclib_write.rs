//! Writing files of the collection FCLib; see [`super::fclib`].

use std::io::Write as _;
use std::path::Path;

use hdf5_pure::{FileBuilder, FinishedGroup, GroupBuilder, LibVer};

use super::replace::replace;
use crate::Error;
use crate::discrete::{Bilateral, DiscreteProblem, Equalities};
use crate::linalg::Csr;

/// A solution or a guess: impulses `r` and velocities `u` (`dm`), velocities of bodies `v` (`n`, empty for a local
/// problem), impulses of bilateral constraints `l` (`p`, empty without).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Impulses of the points.
    pub r: Vec<f64>,
    /// Relative velocities of the points.
    pub u: Vec<f64>,
    /// Velocities of a global problem; empty for a local one.
    pub v: Vec<f64>,
    /// Impulses of the bilateral constraints.
    pub l: Vec<f64>,
}

/// Writes a problem, its solution if there is one, and guesses. Readable by HDF5 1.8 and later.
///
/// # Errors
/// If the file cannot be written, or a matrix has more than `i32::MAX` entries.
pub fn write(path: &Path, problem: &DiscreteProblem, solution: Option<&State>, guesses: &[State]) -> Result<(), Error> {
    let bytes = compose(problem, solution, guesses).map_err(|error| error.at(&path.display().to_string()))?;
    replace(path, |file| file.write_all(&bytes))
}

/// The bytes of such a file.
///
/// # Errors
/// If a matrix has more than `i32::MAX` entries.
pub fn compose(problem: &DiscreteProblem, solution: Option<&State>, guesses: &[State]) -> Result<Vec<u8>, Error> {
    let mut file = FileBuilder::new();
    file.with_libver_bounds(LibVer::Earliest, LibVer::V18);
    let group = match problem {
        DiscreteProblem::Local(local) => {
            let mut group = file.create_group("fclib_local");
            matrix(&mut group, "W", &local.W)?;
            let mut vectors = group.create_group("vectors");
            vectors.create_dataset("q").with_f64_data(&local.q);
            vectors.create_dataset("mu").with_f64_data(&local.mu);
            if let Some(Bilateral { V, R, s }) = &local.bilateral {
                matrix(&mut group, "V", V)?;
                matrix(&mut group, "R", R)?;
                vectors.create_dataset("s").with_f64_data(s);
            }
            finish(group, vectors, problem.dimension())
        }
        DiscreteProblem::Global(global) => {
            let mut group = file.create_group("fclib_global");
            matrix(&mut group, "M", &global.M)?;
            matrix(&mut group, "H", &global.H)?;
            let mut vectors = group.create_group("vectors");
            vectors.create_dataset("f").with_f64_data(&global.f);
            vectors.create_dataset("w").with_f64_data(&global.w);
            vectors.create_dataset("mu").with_f64_data(&global.mu);
            if let Some(Equalities { G, b }) = &global.equalities {
                matrix(&mut group, "G", G)?;
                vectors.create_dataset("b").with_f64_data(b);
            }
            finish(group, vectors, problem.dimension())
        }
    };
    file.add_group(group);
    if let Some(solution) = solution {
        let group = file.create_group("solution");
        file.add_group(state(group, solution));
    }
    if !guesses.is_empty() {
        let mut group = file.create_group("guesses");
        group.create_dataset("number_of_guesses").with_i32_data(&[guesses.len() as i32]);
        for (k, guess) in (1..).zip(guesses) {
            let inner = group.create_group(&k.to_string());
            group.add_group(state(inner, guess));
        }
        file.add_group(group.finish());
    }
    file.finish().map_err(|e| Error::new("", format!("the file cannot be composed ({e})"), "write a smaller problem"))
}

fn finish(mut group: GroupBuilder, vectors: GroupBuilder, dimension: usize) -> FinishedGroup {
    group.create_dataset("spacedim").with_i32_data(&[dimension as i32]);
    group.add_group(vectors.finish());
    group.finish()
}

fn state(mut group: GroupBuilder, state: &State) -> FinishedGroup {
    for (name, values) in [("r", &state.r), ("u", &state.u), ("v", &state.v), ("l", &state.l)] {
        if !values.is_empty() {
            group.create_dataset(name).with_f64_data(values);
        }
    }
    group.finish()
}

/// By compressed rows.
fn matrix(parent: &mut GroupBuilder, name: &str, matrix: &Csr) -> Result<(), Error> {
    let narrow = |n: usize| {
        i32::try_from(n).map_err(|_| {
            Error::new(name, format!("{n} does not fit the 32 bits of the format"), "write a smaller problem")
        })
    };
    let mut group = parent.create_group(name);
    for (key, value) in [("m", matrix.rows), ("n", matrix.cols), ("nzmax", matrix.value.len())] {
        group.create_dataset(key).with_i32_data(&[narrow(value)?]);
    }
    group.create_dataset("nz").with_i32_data(&[-2]);
    let pointers = matrix.start.iter().map(|&s| narrow(s)).collect::<Result<Vec<i32>, Error>>()?;
    let columns = matrix.column.iter().map(|&c| narrow(c as usize)).collect::<Result<Vec<i32>, Error>>()?;
    group.create_dataset("p").with_i32_data(&pointers);
    group.create_dataset("i").with_i32_data(&columns);
    group.create_dataset("x").with_f64_data(&matrix.value);
    parent.add_group(group.finish());
    Ok(())
}
