//! Memory that readers take. A program of its own, since its allocator counts, and the counter is the process's.

#[path = "../common/fuzz.rs"]
mod fuzz;
#[path = "../common/written.rs"]
mod written;

mod mutations;
mod proportion;

/// Held by each test from beginning to end: what another allocates would be counted.
static ALONE: std::sync::Mutex<()> = std::sync::Mutex::new(());
