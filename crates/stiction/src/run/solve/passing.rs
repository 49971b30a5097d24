//! The last question to an answer: whether surfaces have passed through each other where no contact point is.

use super::Outcome;
use crate::Error;
use crate::contact::{Assembly, Counterpart, Moved, OverlapKind, overlaps};
use crate::fem::full_displacement;
use crate::friction::Status;
use crate::io::case::{AgainstSpec, Case};
use crate::mesh::bodies;
use crate::mesh::v3::sub;
use crate::run::pose::load_state::translations;
use crate::run::pose::{Prepared, stopwatch};

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
    let accuracy = ACCURACY.max(PER_TOLERANCE * outcome.solution.certificate.tolerance);
    outcome.overlaps = overlaps(&assembly, before, now, accuracy);
    // Surfaces of a contact that is out may go where they like.
    let is_out = |i: usize| {
        let (points, out) = (prepared.problem.labels.pairs[i].points.clone(), &prepared.problem.contact.out);
        !points.is_empty() && points.into_iter().all(|j| out.binary_search(&(j as u32)).is_ok())
    };
    outcome.overlaps.retain(|overlap| !overlap.surface.is_some_and(is_out));
    if outcome.overlaps.iter().any(|overlap| overlap.kind.is_refused()) {
        outcome.solution.status = Status::PassesThrough;
    }
    outcome.seconds.contact = outcome.seconds.contact + lap();
}

/// The case with a larger `search` wherever the surfaces of a pair have been found to meet beyond it; `None` if there is
/// nothing to enlarge. To be prepared and solved again, from its first load step on.
pub fn widened(case: &Case, prepared: &Prepared, outcome: &Outcome) -> Option<Case> {
    let mut wider = None;
    for overlap in &outcome.overlaps {
        let (OverlapKind::BeyondSearch { search: needed }, Some(i)) = (overlap.kind, overlap.surface) else { continue };
        let known = prepared.facts.contacts[i].surface.pair.as_ref().map_or(0.0, |pair| pair.search);
        let contact = prepared.contact_of[i];
        let case = wider.get_or_insert_with(|| case.clone());
        if let AgainstSpec::Surface { widened, .. } = &mut case.contacts[contact].against {
            *widened = Some(needed.max(known).max(widened.unwrap_or(0.0)));
        }
    }
    wider
}
