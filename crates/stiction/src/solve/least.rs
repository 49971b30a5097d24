//! What cannot be solved in the memory there is, told by counts before there is a matrix.

use crate::Error;
use crate::dual::least_bytes;
use crate::friction::{SolverPath, multigrid_bytes};
use crate::linalg::memory::too_large;

/// Counts of a problem, none above what it will have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct LeastCounts {
    /// Unknown displacements.
    pub unknowns: f64,
    /// Stored entries of `K`, its lower triangle.
    pub entries: f64,
    /// Entries of a Cholesky factor of `K`.
    pub factor: f64,
}

impl LeastCounts {
    /// The counts of both, which have no stiffness in common.
    pub(crate) fn and(self, other: LeastCounts) -> LeastCounts {
        LeastCounts {
            unknowns: self.unknowns + other.unknowns,
            entries: self.entries + other.entries,
            factor: self.factor + other.factor,
        }
    }

    fn by_multigrid(&self) -> f64 {
        multigrid_bytes(self.unknowns, self.entries, 0.0)
    }

    fn by_factor(&self) -> f64 {
        least_bytes(self.unknowns, self.entries, self.factor)
    }
}

/// Refuses what no path allowed can solve within `limit` bytes: multigrid, the direct path, or both are `allowed`. Whether
/// the factor is needed is asked first: `factor` counts its entries, which may take time.
///
/// # Errors
/// If what the path that needs the least needs at least is more: how much, how much there is, and the remedy.
pub(crate) fn fits_by_counts(
    counts: LeastCounts,
    path: SolverPath,
    by_newton: bool,
    limit: Option<u64>,
    factor: impl FnOnce() -> f64,
) -> Result<(), Error> {
    let Some(limit) = limit else { return Ok(()) };
    let multigrid = by_newton && matches!(path, SolverPath::Auto | SolverPath::Multigrid);
    let direct = !by_newton || path != SolverPath::Multigrid;
    let too_much = |bytes: f64| bytes > limit as f64;
    if multigrid && !too_much(counts.by_multigrid()) {
        return Ok(());
    }
    let counts = if direct { LeastCounts { factor: counts.factor.max(factor()), ..counts } } else { counts };
    if direct && !too_much(counts.by_factor()) {
        return Ok(());
    }
    let n = counts.unknowns;
    let by_factor = (format!("the Cholesky factor of at least {n:.0} unknowns"), counts.by_factor());
    let by_multigrid = (format!("multigrid for at least {n:.0} unknowns"), counts.by_multigrid());
    let (what, bytes, power) = match (multigrid, direct && by_factor.1 < by_multigrid.1) {
        (true, false) => (by_multigrid.0, by_multigrid.1, 1.0),
        // The factor of a 3D mesh grows like n^(4/3).
        _ => (by_factor.0, by_factor.1, 0.75),
    };
    let error = too_large(&what, bytes, limit);
    let unknowns = n * (limit as f64 / bytes).powf(power);
    let less = format!("coarsen the mesh to less than {unknowns:.0} unknowns or take linear elements");
    let remedy = error.remedy.replace("coarsen the mesh", &less);
    let other = by_newton && !multigrid && !too_much(counts.by_multigrid());
    let remedy = if other { format!("leave `settings.path` at auto, {remedy}") } else { remedy };
    Err(Error { remedy, ..error })
}
