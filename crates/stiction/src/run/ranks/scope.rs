//! What can be divided among ranks, said before anything is done.

use crate::Error;
use crate::friction::{Method, SolverPath};
use crate::io::case::{Case, ContactSpec, During, Spot};
use crate::run::pose::activity::ALWAYS;

/// What every refusal ends with.
const REMEDY: &str = "use `stiction solve` on one machine";

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
    case.contacts.iter().try_for_each(contact)?;
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
    let setting = |what: &str| Err(refused(&case.solver.spot, what));
    if case.solver.starts.is_some() {
        return setting("the search for further solutions (solver.starts)");
    }
    if case.solver.method.method != Method::Newton {
        return setting("another method than the default one (solver.method)");
    }
    if !matches!(case.solver.path, SolverPath::Auto | SolverPath::Multigrid) {
        return setting("another path than multigrid (solver.path)");
    }
    Ok(())
}

fn contact(contact: &ContactSpec) -> Result<(), Error> {
    let what = match contact {
        ContactSpec { wear: Some(_), .. } => "wear",
        _ => return Ok(()),
    };
    Err(refused(&contact.spot, what))
}
