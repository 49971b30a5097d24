//! The result folder of this process. No other run writes to it until this one ends, in whatever way.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use stiction::Error;
use stiction::io::lock::Lock;

use crate::output;

static HELD: Mutex<Option<Lock>> = Mutex::new(None);

/// Takes a folder, which is created.
pub fn folder(folder: &Path) -> Result<(), Error> {
    let mut held = HELD.lock().unwrap_or_else(PoisonError::into_inner);
    let (lock, note) = Lock::take(folder)?;
    *held = Some(lock);
    note.iter().for_each(|note| output::note(&format!("note: {note}\n")));
    Ok(())
}

/// Gives it back: before every end of the process.
pub fn release() {
    // It is not waited for: the thread that fails may be the one that takes it.
    if let Ok(mut held) = HELD.try_lock() {
        held.take();
    }
}
