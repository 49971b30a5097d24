//! The end of a process that finds no memory. Both programs have this file, each with its own words: an allocator belongs to a
//! program and not to a library.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, which remembers what it could not give. The library asks for its large arrays before it needs them
/// and returns an error where they cannot be had; small ones it takes as they come. The standard library ends a process that
/// finds no memory by SIGABRT: [`end_without_memory`] makes an error of that.
struct Remembering;

#[global_allocator]
static ALLOCATOR: Remembering = Remembering;

thread_local! {
    /// Whether this thread was ever refused memory.
    static REFUSED: Cell<bool> = const { Cell::new(false) };
}

fn remembered(pointer: *mut u8) -> *mut u8 {
    if pointer.is_null() {
        // A thread that ends has no cell any more.
        let _ = REFUSED.try_with(|refused| refused.set(true));
    }
    pointer
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Remembering {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise is the system's.
        remembered(unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        remembered(unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        remembered(unsafe { System.realloc(pointer, layout, size) })
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// From now on a process that finds no memory says [`ENDED`](super::ENDED) and ends with the exit code [`CODE`](super::CODE), not by a signal. Files of results are whole or absent
/// then as after any other end; the lock of the result folder stays and is told by the next run.
pub fn end_without_memory() {
    #[cfg(unix)]
    {
        extern "C" fn aborted(_: libc::c_int) {
            let refused = REFUSED.try_with(Cell::get).unwrap_or(false);
            // SAFETY: all three may be called in a handler; an abort for another reason goes its way.
            unsafe {
                if !refused {
                    libc::signal(libc::SIGABRT, libc::SIG_DFL);
                    return;
                }
                libc::write(libc::STDERR_FILENO, super::ENDED.as_ptr().cast(), super::ENDED.len());
                libc::_exit(super::CODE.into());
            }
        }
        // SAFETY: the handler calls nothing that it may not, and the thread that aborts runs it.
        unsafe {
            libc::signal(libc::SIGABRT, aborted as extern "C" fn(libc::c_int) as libc::sighandler_t);
        }
    }
}
