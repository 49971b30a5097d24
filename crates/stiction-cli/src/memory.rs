//! What the allocator does with memory that is free, and what happens where there is none.

mod remembering;

use std::panic::PanicHookInfo;

use crate::output::panic_message;
pub use remembering::end_without_memory;

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

/// The exit code of a process that finds no memory.
pub const CODE: u8 = crate::code::INPUT;
/// What is said where memory has ended, after the standard library has said how much was asked for.
pub const ENDED: &str = "error: there is no memory left\n\
    remedy: coarsen the mesh, use a machine with more memory, or raise the limit of the process (`ulimit -v`)\n";

/// Whether the panic is that of a thread which finds no memory for the stack of its signal handlers: the standard library asks
/// for it when the thread begins, and knows no other way to say so.
pub fn is_lack_of_memory(info: &PanicHookInfo) -> bool {
    panic_message(info).is_some_and(|message| message.starts_with("failed to allocate an alternative stack"))
}
