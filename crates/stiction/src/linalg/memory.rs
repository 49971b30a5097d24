//! Room for large arrays, asked for before work begins.
//!
//! A vector that finds no memory ends the process. Each phase of a run therefore predicts the most it holds at a time beyond
//! what is there, and asks for that much in one piece: where it is refused the phase ends with an error. The pages are not
//! touched, so that asking takes microseconds. The predictions are tested against what is allocated
//! (`tests/memory/predictions.rs`); what they do not cover is listed in `docs/limits.md`.

use crate::Error;

/// A page, which nothing else is aligned like: an allocator that counts tells what is asked for from what is written by it.
#[derive(Debug)]
#[repr(align(4096))]
struct Page(#[allow(dead_code)] [u8; 4096]);

/// Memory that is held for later and not written to.
#[derive(Debug, Default)]
pub struct Room {
    /// Empty, with a capacity.
    _pages: Vec<Page>,
}

/// Takes hold of `bytes`, of which `limit` may be used, for `what`: "multigrid for 90000 unknowns".
///
/// # Errors
/// If that is beyond the limit, or the system does not give so much: how much is needed, how much there is, and what to do.
pub fn room(what: &str, bytes: f64, limit: Option<u64>) -> Result<Room, Error> {
    if let Some(limit) = limit.filter(|&limit| bytes > limit as f64) {
        return Err(too_large(what, bytes, limit));
    }
    let mut pages = Vec::new();
    // Saturates: more than can be addressed is refused as well.
    match pages.try_reserve_exact(bytes as usize / size_of::<Page>() + 1) {
        Ok(()) => Ok(Room { _pages: pages }),
        Err(_) => Err(refused(what, bytes)),
    }
}

/// The same where nothing has to be held: what is free now is enough.
///
/// # Errors
/// As [`room`].
pub fn ensure(what: &str, bytes: f64, limit: Option<u64>) -> Result<(), Error> {
    // Room that nothing uses would not be asked for.
    room(what, bytes, limit).map(|room| drop(std::hint::black_box(room)))
}

/// What all errors of too little memory end with.
pub(super) const REMEDY: &str = "coarsen the mesh, raise `settings.memory_limit`, or use a machine with more memory";

/// The error where `what` needs more than it may use.
pub fn too_large(what: &str, bytes: f64, limit: u64) -> Error {
    let sizes = format!("{} and {} may be used", size(bytes), size(limit as f64));
    Error::new("", format!("{what} needs {sizes}"), REMEDY)
}

/// The error where the system does not give what it should have.
pub(crate) fn refused(what: &str, bytes: f64) -> Error {
    let what = format!("{what} needs {}, which the system does not give in one piece", size(bytes));
    Error::new("", what, format!("{REMEDY} (`ulimit -v` shows the limit of a process)"))
}

/// Bytes to read: "0.3 MB", "1.25 GB".
fn size(bytes: f64) -> String {
    if bytes < 1e8 { format!("{:.1} MB", bytes / 1e6) } else { format!("{:.2} GB", bytes / 1e9) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_had_is_an_error_that_says_how_much() {
        let error = room("the factor", 2e9, Some(1_000_000_000)).unwrap_err();
        assert_eq!(error.what, "the factor needs 2.00 GB and 1.00 GB may be used");
        // More than any address space has.
        let error = room("the factor", 1e30, None).unwrap_err();
        assert!(error.what.contains("does not give") && error.remedy.contains("memory_limit"), "{error}");
        assert!(ensure("nothing", 0.0, Some(0)).is_ok() && ensure("a little", 1e6, None).is_ok());
    }
}
