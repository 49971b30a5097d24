//! An allocator that counts. A program that asks for [`measured`] memory allocates by it:
//! `#[global_allocator] static ALLOCATOR: Counting = Counting;`

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The system's allocator, counted.
pub struct Counting;

/// Heap in use, and the most since the last reset.
static IN_USE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
/// The most that was asked for at a time, together with what was in use.
static ASKED: AtomicUsize = AtomicUsize::new(0);

/// What `stiction` asks for before a phase is in pages and not written to: no memory in use.
pub const PAGE: usize = 4096;

fn count(size: usize) {
    PEAK.fetch_max(IN_USE.fetch_add(size, Relaxed) + size, Relaxed);
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.align() == PAGE {
            ASKED.fetch_max(IN_USE.load(Relaxed) + layout.size(), Relaxed);
        } else {
            count(layout.size());
        }
        // SAFETY: the caller's promise is the system's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Old and new are not there at a time: the system moves the pages of what is large.
        IN_USE.fetch_sub(layout.size(), Relaxed);
        count(size);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        if layout.align() != PAGE {
            IN_USE.fetch_sub(layout.size(), Relaxed);
        }
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Bytes allocated.
#[derive(Debug, Clone, Copy)]
pub struct Memory {
    /// The most at a time, beyond what was in use before.
    pub peak: usize,
    /// What the answer keeps.
    pub kept: usize,
    /// The most that was predicted and asked for at a time, beyond what was in use before; zero if nothing was.
    pub asked: usize,
}

/// What `work` gives, and the memory it took; other threads of the program must be idle.
pub fn measured<T>(work: impl FnOnce() -> T) -> (T, Memory) {
    let before = IN_USE.load(Relaxed);
    // A program has allocated something before: otherwise nothing is counted, and every bound would be kept.
    assert!(before > 0, "the program does not allocate by `Counting`");
    PEAK.store(before, Relaxed);
    ASKED.store(before, Relaxed);
    let answer = work();
    let since = |count: &AtomicUsize| count.load(Relaxed).saturating_sub(before);
    let memory = Memory { peak: since(&PEAK), kept: since(&IN_USE), asked: since(&ASKED) };
    (answer, memory)
}
