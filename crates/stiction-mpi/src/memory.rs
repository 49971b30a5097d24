//! What happens where a rank finds no memory.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ffi::c_int;

/// The system's allocator, which remembers what it could not give. The standard library ends a process that finds no memory by
/// SIGABRT, as other failures do: [`end_without_memory`] tells them apart.
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

const ENDED: &str = "error: a rank finds no memory\n\
    remedy: use more machines, fewer ranks on each, a coarser mesh, or raise the limit of the process (`ulimit -v`)\n";

/// From now on a rank that finds no memory says so and ends with exit code 2; the launcher ends the others. MPI has handlers of
/// its own, which this comes after.
pub fn end_without_memory() {
    extern "C" fn aborted(_: c_int) {
        let refused = REFUSED.try_with(Cell::get).unwrap_or(false);
        // SAFETY: all three may be called in a handler; an abort for another reason goes its way.
        unsafe {
            if !refused {
                libc::signal(libc::SIGABRT, libc::SIG_DFL);
                return;
            }
            libc::write(libc::STDERR_FILENO, ENDED.as_ptr().cast(), ENDED.len());
            libc::_exit(crate::REFUSED.into());
        }
    }
    // SAFETY: the handler calls nothing that it may not, and the thread that aborts runs it.
    unsafe {
        libc::signal(libc::SIGABRT, aborted as extern "C" fn(c_int) as libc::sighandler_t);
    }
}
