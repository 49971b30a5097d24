//! Ctrl-C: the iteration stops and its last step is kept; before it has begun there is nothing to keep.

use std::sync::atomic::{AtomicBool, Ordering};

use stiction::Error;

use crate::{code, output};

static ITERATING: AtomicBool = AtomicBool::new(false);
static ASKED: AtomicBool = AtomicBool::new(false);

/// Watches for Ctrl-C from now on.
pub fn watch() -> Result<(), Error> {
    let handler = || {
        if ITERATING.load(Ordering::SeqCst) && !ASKED.swap(true, Ordering::SeqCst) {
            output::note("interrupted: the last finished step is kept; once more to leave at once\n");
        } else {
            output::note("interrupted: nothing more is written\n");
            std::process::exit(code::INTERRUPTED.into());
        }
    };
    ctrlc::set_handler(handler)
        .map_err(|error| Error::new("", format!("interrupts cannot be watched ({error})"), "run it another way"))
}

/// From now on there is a step to keep.
pub fn iterating() {
    ITERATING.store(true, Ordering::SeqCst);
}

/// Whether the user asked to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}
