//! Two pieces of work beside each other, neither of which uses the threads of rayon to wait for the other.

use std::thread::{self, ScopedJoinHandle};

/// What `here` and `there` give, `there` by a thread of its own where one can be had.
pub(crate) fn beside<A: Send, B>(there: impl Fn() -> A + Sync, here: impl FnOnce() -> B) -> (A, B) {
    thread::scope(|scope| match thread::Builder::new().spawn_scoped(scope, &there) {
        Ok(thread) => {
            let here = here();
            (joined(thread), here)
        }
        Err(_) => (there(), here()),
    })
}

/// What a thread gives; its panic is that of who waits for it.
pub(super) fn joined<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
