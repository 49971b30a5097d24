//! The file of a run that refines, as it goes on: each level is on the disk before the next one begins.

use std::path::Path;

use super::kept::AGAIN;
use super::step_file::fingerprint;
use crate::Error;
use crate::io::npz::{self, Array, Arrays, count, f64s, scalar, text, u32s, usizes};
use crate::io::problem::damaged;
use crate::io::{folder, replace};
use crate::run::pose::Prepared;
use crate::run::refine::{Indicators, Sequence};

/// Its name.
pub(crate) const LEVELS: &str = "refinement.npz";
/// Number of its format.
const FORMAT: usize = 2;

/// A number that differs where posed problems differ.
pub(in crate::run) fn problem_fingerprint(prepared: &Prepared) -> String {
    format!("{:016x}", fingerprint(prepared))
}

/// Writes what a later run needs to go on after the last level of `sequence`, whose problem has this fingerprint. The file is
/// the new one or the one before, whatever happens.
///
/// # Errors
/// If it cannot be written.
pub(in crate::run) fn keep_levels(into: &Path, problem: &str, sequence: &Sequence) -> Result<(), Error> {
    let record = serde_json::to_string(sequence).unwrap_or_default();
    let ends = sequence.marked.iter().scan(0, |end, marked| {
        *end += marked.len();
        Some(*end)
    });
    let (ends, marked) = (ends.collect::<Vec<usize>>(), sequence.marked.concat());
    folder::create(into)?;
    npz::write(
        &into.join(LEVELS),
        &[
            ("format", Array::count(FORMAT)),
            ("problem", Array::text(problem)),
            ("record", Array::text(&record)),
            ("marked_ends", Array::usize(&ends)),
            ("marked", Array::u32(&marked)),
            ("error", Array::scalar(sequence.indicators.error)),
            ("cell_error", Array::f64(&sequence.indicators.cells)),
            ("cells_at_peaks", Array::u32(&sequence.indicators.peaks)),
            ("displacement", Array::f64(&sequence.displacement)),
        ],
    )?;
    replace::sync(into, &[LEVELS])
}

/// What an earlier run has left in a folder: the fingerprint of its last problem and its levels; `None` if it left nothing.
///
/// # Errors
/// If the file is damaged, or of another version.
pub(in crate::run) fn kept_levels(from: &Path) -> Result<Option<(String, Sequence)>, Error> {
    let path = from.join(LEVELS);
    if !path.exists() {
        return Ok(None);
    }
    let again = |error: Error| Error::new(path.display().to_string(), error.what, AGAIN);
    npz::read(&path).and_then(|arrays| read(&arrays)).map(Some).map_err(again)
}

/// Removes it.
///
/// # Errors
/// If it cannot be removed.
pub(in crate::run) fn remove_levels(from: &Path) -> Result<(), Error> {
    folder::remove(&from.join(LEVELS))
}

fn read(arrays: &Arrays) -> Result<(String, Sequence), Error> {
    if count(arrays, "format")? != FORMAT {
        return Err(damaged("the file has another format than this version reads"));
    }
    let mut sequence: Sequence = serde_json::from_str(text(arrays, "record")?)
        .map_err(|_| damaged("the record of the levels cannot be read"))?;
    let mut marked = u32s(arrays, "marked", None)?;
    let mut begin = 0;
    for end in usizes(arrays, "marked_ends", None)? {
        let own = end.checked_sub(begin).and_then(|count| marked.split_at_checked(count));
        let (own, rest) = own.ok_or_else(|| damaged("the marked cells are not those of the levels"))?;
        sequence.marked.push(own.to_vec());
        (marked, begin) = (rest, end);
    }
    if sequence.levels.len() != sequence.marked.len() + 1 {
        return Err(damaged("there is not one list of marked cells for each level but the last"));
    }
    let finite = |name: &str| match f64s(arrays, name, None)? {
        values if values.iter().all(|value| value.is_finite()) => Ok(values.to_vec()),
        _ => Err(damaged(format!("array \"{name}\" holds what is no number"))),
    };
    let peaks = u32s(arrays, "cells_at_peaks", None)?.to_vec();
    sequence.indicators = Indicators::kept(finite("cell_error")?, scalar(arrays, "error")?, peaks);
    sequence.displacement = finite("displacement")?;
    Ok((text(arrays, "problem")?.to_string(), sequence))
}
