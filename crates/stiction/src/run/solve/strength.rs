//! Strength that is lost for good: points that slip or open at the end of a solve keep friction alone.

use crate::contact::Friction;
use crate::friction::PointState;
use crate::run::pose::Prepared;

/// Takes the strength of points that have failed, by the states of a solution; false where none has.
///
/// All points that fail in one solve fail together: how far a crack runs in a step depends on the increment. The set of
/// intact points only shrinks, and what is solved at last has no intact point at its strength.
pub(super) fn lose(prepared: &mut Prepared, states: &[PointState]) -> bool {
    let brittle = brittle(prepared);
    lose_of(&brittle, states, &mut prepared.problem.contact.friction, &mut prepared.loading.lost)
}

/// The same of the points `brittle` with their `laws`, where `lost` says of all points what they have lost.
pub(crate) fn lose_of(brittle: &[usize], states: &[PointState], laws: &mut [Friction], lost: &mut Vec<bool>) -> bool {
    let mut any = false;
    for &j in brittle {
        if laws[j].strength() != [0.0; 2] && states[j] != PointState::Stick {
            laws[j].set_strength([0.0; 2]);
            lost.resize(states.len(), false);
            lost[j] = true;
            any = true;
        }
    }
    any
}

/// The strength of all points, two numbers each, as a step's file has it; empty where none can be lost. A point that takes no
/// part in a step keeps its own.
pub(super) fn kept(prepared: &Prepared) -> Vec<f64> {
    if brittle(prepared).is_empty() {
        return Vec::new();
    }
    left(&prepared.loading.laws, &prepared.loading.lost).into_flattened()
}

/// The strength that each point has left.
pub(crate) fn left(laws: &[Friction], lost: &[bool]) -> Vec<[f64; 2]> {
    let is_lost = |j: usize| lost.get(j) == Some(&true);
    laws.iter().enumerate().map(|(j, law)| if is_lost(j) { [0.0; 2] } else { law.strength() }).collect()
}

/// Puts back what [`kept`] has given.
pub(super) fn restore(prepared: &mut Prepared, kept: &[f64]) {
    let (all, laws) = (kept.as_chunks().0, &prepared.loading.laws);
    prepared.loading.lost = lost(all, laws);
    prepared.problem.contact.friction.iter_mut().zip(all).for_each(|(law, &strength)| law.set_strength(strength));
}

/// The points of which less is left than their laws have.
pub(crate) fn lost(left: &[[f64; 2]], laws: &[Friction]) -> Vec<bool> {
    left.iter().zip(laws).map(|(now, law)| *now != law.strength()).collect()
}

/// The points whose strength can be lost.
fn brittle(prepared: &Prepared) -> Vec<usize> {
    let pairs = prepared.surfaces.iter().zip(&prepared.problem.labels.pairs);
    pairs.filter(|(surface, _)| surface.friction.is_brittle()).flat_map(|(_, pair)| pair.points.clone()).collect()
}
