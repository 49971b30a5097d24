//! Memory of each rank, asked for before it is taken: all ranks end where one of them finds too little.

use super::local::Local;
use crate::Error;
use crate::friction::multigrid_fits;
use crate::io::case::Case;
use crate::io::machine;
use crate::mesh::Mesh;
use crate::ranks::{Ranks, agree, gather_all};
use crate::run::pose::MemoryLimit;
use crate::run::pose::memory::{of_mesh, posing_fits};

/// What this rank may use: what the case allows each, or its part of what its machine has.
pub(super) fn limit(case: &Case, ranks: &dyn Ranks) -> MemoryLimit {
    let host = machine::host_name().unwrap_or_default().into_bytes();
    let here = gather_all(ranks, host.clone()).iter().filter(|other| **other == host).count();
    MemoryLimit::of_each(&case.solver, here)
}

/// Refuses a piece of a mesh whose matrix some rank has no memory for.
pub(super) fn piece_fits(mesh: &Mesh, limit: &MemoryLimit, ranks: &dyn Ranks) -> Result<(), Error> {
    part_fits([mesh.nodes.len() as f64, of_mesh(mesh)], limit, ranks)
}

/// The same of so many nodes, and bytes for each.
pub(super) fn part_fits([nodes, each]: [f64; 2], limit: &MemoryLimit, ranks: &dyn Ranks) -> Result<(), Error> {
    agree(ranks, posing_fits(nodes, each, limit).map_err(|error| named(error, ranks)))
}

/// Refuses a hierarchy that some rank has no memory for.
pub(super) fn hierarchy_fits(local: &Local, limit: &MemoryLimit, ranks: &dyn Ranks) -> Result<(), Error> {
    let fits = multigrid_fits(&local.problem, Some(&local.division), limit.bytes);
    agree(ranks, fits.map_err(|error| named(limit.named(error), ranks)))
}

fn named(mut error: Error, ranks: &dyn Ranks) -> Error {
    error.what = format!("rank {}: {}", ranks.rank(), error.what);
    error
}
