//! An allocator that runs out of memory. A program that asks for [`limited`] memory allocates by it:
//! `#[global_allocator] static ALLOCATOR: Failing = Failing;`

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr::null_mut;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The system's allocator with a limit on what is in use, room that is only held included.
pub struct Failing;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);
static LIMIT: AtomicUsize = AtomicUsize::new(usize::MAX);
static REFUSED: AtomicUsize = AtomicUsize::new(0);

/// Smaller allocations are always granted: nobody predicts them one by one.
pub const LARGE: usize = 1 << 20;

fn is_granted(more: usize, whole: usize) -> bool {
    let in_use = IN_USE.fetch_add(more, Relaxed) + more;
    if whole >= LARGE && in_use > LIMIT.load(Relaxed) {
        IN_USE.fetch_sub(more, Relaxed);
        REFUSED.fetch_add(1, Relaxed);
        return false;
    }
    MOST.fetch_max(in_use, Relaxed);
    true
}

// SAFETY: every call goes to the system's allocator unchanged, or is refused by null as it may be.
unsafe impl GlobalAlloc for Failing {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if !is_granted(layout.size(), layout.size()) {
            return null_mut();
        }
        // SAFETY: the caller's promise is the system's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if !is_granted(layout.size(), layout.size()) {
            return null_mut();
        }
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let more = size.saturating_sub(layout.size());
        if !is_granted(more, if more > 0 { size } else { 0 }) {
            return null_mut();
        }
        IN_USE.fetch_sub(layout.size().saturating_sub(size), Relaxed);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// What became of work in limited memory.
#[derive(Debug, Clone, Copy)]
pub struct Limited {
    /// The most in use at a time, beyond what was in use before.
    pub most: usize,
    /// Allocations that were refused.
    pub refused: usize,
}

/// What `work` gives where it may use no more than `limit` bytes beyond what is in use; other threads must be idle.
pub fn limited<T>(limit: usize, work: impl FnOnce() -> T) -> (T, Limited) {
    let before = IN_USE.load(Relaxed);
    // A program has allocated something before: otherwise nothing would ever be refused.
    assert!(before > 0, "the program does not allocate by `Failing`");
    MOST.store(before, Relaxed);
    REFUSED.store(0, Relaxed);
    LIMIT.store(before.saturating_add(limit), Relaxed);
    let answer = work();
    LIMIT.store(usize::MAX, Relaxed);
    (answer, Limited { most: MOST.load(Relaxed).saturating_sub(before), refused: REFUSED.load(Relaxed) })
}
