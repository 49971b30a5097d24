//! The last question to an answer: whether surfaces have passed through each other where no contact point is.

use super::Outcome;
use crate::Error;
use crate::contact::{Assembly, Counterpart, Moved, Overlap, OverlapKind, overlaps};
use crate::fem::full_displacement;
use crate::friction::Status;
use crate::io::case::{AgainstSpec, Case};
use crate::mesh::bodies;
use crate::mesh::v3::sub;
use crate::run::pose::activity::within;
use crate::run::pose::load_state::translations;
use crate::run::pose::{ContactFacts, Prepared, stopwatch};

/// Displacements at single nodes are known to this part of the largest, or to a hundred times the tolerance: the
/// certificate measures balances and gaps, which a mesh turns into displacements with factors of that order.
const ACCURACY: f64 = 1e-6;
const PER_TOLERANCE: f64 = 100.0;

/// Nothing has moved.
pub(super) fn at_rest(prepared: &Prepared) -> Moved {
    Moved { u: vec![[0.0; 3]; prepared.mesh.nodes.len()], obstacles: vec![[0.0; 3]; prepared.surfaces.len()] }
}

/// Where everything has moved to at time `t` in the frame of the travel, the displacements of the unknowns being `u`; the supports are those that
/// `prepared` holds.
///
/// # Errors
/// If the motion of an obstacle is not finite at `t`.
pub(super) fn moved(prepared: &Prepared, u: &[f64], t: f64) -> Result<Moved, Error> {
    let u = full_displacement(&prepared.model, u).as_chunks().0.to_vec();
    let mut obstacles = translations(&prepared.loading, t)?;
    for (at, surface) in obstacles.iter_mut().zip(&prepared.surfaces) {
        if let Counterpart::Obstacle(_) = surface.against {
            *at = sub(*at, prepared.loading.travel);
        }
    }
    Ok(Moved { u, obstacles })
}

/// The overlaps of an answer that leads from `before` to `now`, certified to `tolerance`. Surfaces of a contact that `is_out` may go
/// where they like.
pub(crate) fn found(
    assembly: &Assembly,
    [before, now]: [&Moved; 2],
    tolerance: f64,
    is_out: &dyn Fn(usize) -> bool,
) -> Vec<Overlap> {
    let mut found = overlaps(assembly, before, now, ACCURACY.max(PER_TOLERANCE * tolerance));
    found.retain(|overlap| !overlap.surface.is_some_and(is_out));
    found
}

/// Finds the overlaps of a solved `outcome` that leads from `before` to `now`. Where contact is named and surfaces pass
/// through each other all the same, the answer is none.
pub(super) fn look(prepared: &Prepared, before: &Moved, now: &Moved, outcome: &mut Outcome) {
    if !matches!(outcome.solution.status, Status::Solved | Status::Uncertified) {
        return;
    }
    let mut lap = stopwatch();
    let Prepared { mesh, surfaces, facts, .. } = prepared;
    let facts = facts.contacts.iter().map(|contact| &contact.surface).collect();
    let assembly = Assembly { mesh, body: bodies(mesh), surfaces, facts };
    // Surfaces of a contact that does not hold now may go where they like.
    let is_out = |i: usize| !surfaces[i].periods.iter().any(|&period| within(period, prepared.loading.t));
    outcome.overlaps = found(&assembly, [before, now], outcome.solution.certificate.tolerance, &is_out);
    if outcome.overlaps.iter().any(|overlap| overlap.kind.is_refused()) {
        outcome.solution.status = Status::PassesThrough;
    }
    outcome.seconds.contact = outcome.seconds.contact + lap();
}

/// The case with a larger `search` wherever the surfaces of a pair have been found to meet beyond it; `None` if there is
/// nothing to enlarge. To be prepared and solved again, from its first load step on.
pub fn widened(case: &Case, prepared: &Prepared, outcome: &Outcome) -> Option<Case> {
    with_searches(case, &needed_searches(&outcome.overlaps, &prepared.facts.contacts, &prepared.contact_of))
}

/// How far the surfaces of contacts have to be looked for, with the number of each contact in the case; length.
pub(crate) type Searches = Vec<(usize, f64)>;

/// Those that overlaps ask for; `contact_of` is the contact of each surface.
pub(crate) fn needed_searches(overlaps: &[Overlap], surfaces: &[ContactFacts], contact_of: &[usize]) -> Searches {
    let needed = |overlap: &Overlap| {
        let (OverlapKind::BeyondSearch { search }, Some(i)) = (overlap.kind, overlap.surface) else { return None };
        let known = surfaces[i].surface.pair.as_ref().map_or(0.0, |pair| pair.search);
        Some((contact_of[i], search.max(known)))
    };
    overlaps.iter().filter_map(needed).collect()
}

/// The case with these; `None` if there are none.
pub(crate) fn with_searches(case: &Case, needed: &[(usize, f64)]) -> Option<Case> {
    let mut wider = (!needed.is_empty()).then(|| case.clone())?;
    for &(contact, search) in needed {
        if let Some(AgainstSpec::Surface { widened, .. }) = wider.contacts.get_mut(contact).map(|it| &mut it.against) {
            *widened = Some(search.max(widened.unwrap_or(0.0)));
        }
    }
    Some(wider)
}
