//! Ctrl-C and SIGTERM: a solve ends with what it has found, anything else at once.

use std::sync::atomic::{AtomicBool, Ordering};

use stiction::Error;

use crate::{code, hold, output};

static HEARD: AtomicBool = AtomicBool::new(false);
static ASKED: AtomicBool = AtomicBool::new(false);

/// Watches for Ctrl-C from now on.
pub fn watch() -> Result<(), Error> {
    let handler = || {
        if HEARD.load(Ordering::SeqCst) && !ASKED.swap(true, Ordering::SeqCst) {
            output::note("interrupted: what has been found is kept; once more to leave at once\n");
        } else {
            output::note("interrupted: nothing more is written\n");
            hold::release();
            std::process::exit(code::INTERRUPTED.into());
        }
    };
    ctrlc::set_handler(handler)
        .map_err(|error| Error::new("", format!("interrupts cannot be watched ({error})"), "run it another way"))
}

/// From now on the work asks whether it is to stop.
pub fn heard() {
    HEARD.store(true, Ordering::SeqCst);
}

/// Whether the user asked to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}
