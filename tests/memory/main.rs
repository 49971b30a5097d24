//! Memory that readers take. A program of its own, since its allocator counts, and the counter is the process's.

use stiction_fixtures::counting::Counting;

mod compressed;
mod mutations;
mod predictions;
mod proportion;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Held by each test from beginning to end: what another allocates would be counted.
static ALONE: std::sync::Mutex<()> = std::sync::Mutex::new(());
