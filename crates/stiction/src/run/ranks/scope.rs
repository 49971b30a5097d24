//! What can be divided among ranks, said before anything is done.

use super::timed::is_brittle;
use crate::Error;
use crate::friction::{Method, SolverPath};
use crate::io::case::{Case, During, Spot};
use crate::run::pose::activity::ALWAYS;

/// What every refusal ends with.
const REMEDY: &str = "use `stiction solve` on one machine";

/// Unknowns of the whole up to which rank 0 does alone what a case asks for: a minute, and some GB, for which `stiction solve` asks first too.
const MOST_ASKED: usize = 100_000;

pub(super) fn refused(spot: &Spot, what: &str) -> Error {
    spot.error(format!("{what} cannot be divided among ranks in this version"), REMEDY)
}

/// Refuses what ranks cannot do, by the first entry of the case that asks for it.
pub(super) fn check(case: &Case) -> Result<(), Error> {
    let first = |spots: &mut dyn Iterator<Item = &Spot>, what: &str| match spots.next() {
        Some(spot) => Err(refused(spot, what)),
        None => Ok(()),
    };
    first(&mut case.cyclic.iter().map(|cyclic| &cyclic.spot), "cyclic symmetry")?;
    if case.accuracy.is_some_and(|accuracy| accuracy.proven) {
        return Err(refused(&case.mesh.spot, "the proof of a bound of the error (accuracy.proven)"));
    }
    let timed = |(during, _): &(&During, &Spot)| case.accuracy.is_some() && during.period(&case.steps) != ALWAYS;
    let of_fixes = case.fixes.iter().map(|fix| (&fix.during, &fix.spot));
    let of_couplings = case.couplings.iter().map(|coupling| (&coupling.during, &coupling.spot));
    let mut timed = of_fixes.chain(of_couplings).filter(timed).map(|(_, spot)| spot);
    first(&mut timed, "[accuracy] with a support or a coupling that begins or ends with a step")?;
    if case.accuracy.is_some() {
        let mut yields =
            case.contacts.iter().filter(|contact| contact.stiffness.is_some()).map(|contact| &contact.spot);
        first(&mut yields, "[accuracy] with an interface that yields")?;
    }
    match of_rank_0(case) {
        Some(what) if case.accuracy.is_some() => Err(refused(&case.solver.spot, &format!("[accuracy] with {what}"))),
        Some(what) if is_left_to_all(case) => {
            let of = "an interface that yields or, with load steps, loses its strength";
            Err(refused(&case.solver.spot, &format!("{of}, with {what},")))
        }
        _ => Ok(()),
    }
}

/// What a case asks for that rank 0 alone can do.
pub(super) fn of_rank_0(case: &Case) -> Option<&'static str> {
    if case.solver.starts.is_some() {
        Some("the search for further solutions (solver.starts)")
    } else if case.solver.method.method != Method::Newton {
        Some("another method than the default one (solver.method)")
    } else if !matches!(case.solver.path, SolverPath::Auto | SolverPath::Multigrid) {
        Some("another path than multigrid (solver.path)")
    } else {
        None
    }
}

/// Whether answers of rank 0 alone lack what the ranks need of them: how far interfaces have yielded, or what strength is left at the end
/// of each increment.
pub(super) fn is_left_to_all(case: &Case) -> bool {
    case.contacts.iter().any(|contact| contact.stiffness.is_some()) || !case.steps.is_empty() && is_brittle(case)
}

/// Refuses what only rank 0 could do on a whole that is too large for it; `unknowns` are those of all ranks.
pub(super) fn check_size(case: &Case, unknowns: usize) -> Result<(), Error> {
    match of_rank_0(case).filter(|_| unknowns > MOST_ASKED) {
        Some(what) => {
            let what = format!("{what} with {unknowns} unknowns (rank 0, which does this alone, takes {MOST_ASKED})");
            Err(refused(&case.solver.spot, &what))
        }
        None => Ok(()),
    }
}
