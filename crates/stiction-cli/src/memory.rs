//! What the allocator does with memory that is free, and what happens where there is none.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::panic::PanicHookInfo;

use crate::output::panic_message;

/// Keeps what is freed for what comes next, instead of giving it back to the system: pages that are fresh have to be zeroed,
/// and on virtual machines found first, at two seconds a gigabyte. A solve frees and takes its largest arrays several times:
/// this spares 3 to 10 % of the processor time of a million unknowns, for 2 % more memory. Where the C library has no such
/// settings nothing happens.
///
/// Under a limit on addresses all threads share one heap: each heap takes 64 MB of addresses, and memory asked for in one of
/// them would not be there in another.
pub fn keep_freed() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: settings of the allocator, before any other thread runs; `getrlimit` writes one `rlimit`, which is ours.
    unsafe {
        libc::mallopt(libc::M_MMAP_MAX, 0);
        libc::mallopt(libc::M_TRIM_THRESHOLD, -1);
        let mut limit = libc::rlimit { rlim_cur: libc::RLIM_INFINITY, rlim_max: 0 };
        if libc::getrlimit(libc::RLIMIT_AS, &mut limit) == 0 && limit.rlim_cur != libc::RLIM_INFINITY {
            libc::mallopt(libc::M_ARENA_MAX, 1);
        }
    }
}

/// Gives back what is free: files about to be written are cached in the same pages, which need not be fetched.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the allocator may do this at any time.
    unsafe {
        libc::malloc_trim(0);
    }
}

/// The system's allocator, which remembers what it could not give. The library asks for its large arrays before it needs them
/// and returns an error where they cannot be had; small ones it takes as they come. The standard library ends a process that
/// finds no memory by SIGABRT: [`end_without_memory`] makes an error of that.
pub struct Remembering;

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

/// What is said where memory has ended, after the standard library has said how much was asked for.
pub const ENDED: &str = "error: there is no memory left\n\
    remedy: coarsen the mesh, use a machine with more memory, or raise the limit of the process (`ulimit -v`)\n";

/// Whether the panic is that of a thread which finds no memory for the stack of its signal handlers: the standard library asks
/// for it when the thread begins, and knows no other way to say so.
pub fn is_lack_of_memory(info: &PanicHookInfo) -> bool {
    panic_message(info).is_some_and(|message| message.starts_with("failed to allocate an alternative stack"))
}

/// From now on a process that finds no memory ends with exit code 2 and not by a signal. Files of results are whole or absent
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
                libc::write(libc::STDERR_FILENO, ENDED.as_ptr().cast(), ENDED.len());
                libc::_exit(crate::code::INPUT.into());
            }
        }
        // SAFETY: the handler calls nothing that it may not, and the thread that aborts runs it.
        unsafe {
            libc::signal(libc::SIGABRT, aborted as extern "C" fn(libc::c_int) as libc::sighandler_t);
        }
    }
}
