//! What happens where a rank finds no memory. MPI has handlers of its own, which those set here come after.

#[path = "../../stiction-cli/src/memory/remembering.rs"]
mod remembering;

pub use remembering::end_without_memory;

/// The exit code of such a rank.
pub const CODE: u8 = crate::REFUSED;
/// What such a rank says before it ends; the launcher ends the others.
pub const ENDED: &str = "error: a rank finds no memory\n\
    remedy: use more machines, fewer ranks on each, a coarser mesh, or raise the limit of the process (`ulimit -v`)\n";
