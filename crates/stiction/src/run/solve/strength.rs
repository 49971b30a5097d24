//! Strength that is lost for good: points that slip or open at the end of a solve keep friction alone.

use crate::friction::PointState;
use crate::run::pose::Prepared;

/// Takes the strength of points that have failed, by the states of a solution; false where none has.
///
/// All points that fail in one solve fail together: how far a crack runs in a step depends on the increment. The set of
/// intact points only shrinks, and what is solved at last has no intact point at its strength.
pub(super) fn lose(prepared: &mut Prepared, states: &[PointState]) -> bool {
    let mut lost = false;
    for j in brittle(prepared) {
        let law = &mut prepared.problem.contact.friction[j];
        if law.strength() != [0.0; 2] && states[j] != PointState::Stick {
            law.set_strength([0.0; 2]);
            prepared.loading.lost.resize(states.len(), false);
            prepared.loading.lost[j] = true;
            lost = true;
        }
    }
    lost
}

/// The strength of all points, two numbers each, as a step's file has it; empty where none can be lost. A point that takes no
/// part in a step keeps its own.
pub(super) fn kept(prepared: &Prepared) -> Vec<f64> {
    if brittle(prepared).is_empty() {
        return Vec::new();
    }
    let is_lost = |j: usize| prepared.loading.lost.get(j) == Some(&true);
    let laws = prepared.loading.laws.iter().enumerate();
    laws.flat_map(|(j, law)| if is_lost(j) { [0.0; 2] } else { law.strength() }).collect()
}

/// Puts back what [`kept`] has given.
pub(super) fn restore(prepared: &mut Prepared, kept: &[f64]) {
    let (all, laws) = (kept.as_chunks().0, &prepared.loading.laws);
    prepared.loading.lost = all.iter().zip(laws).map(|(now, law)| *now != law.strength()).collect();
    prepared.problem.contact.friction.iter_mut().zip(all).for_each(|(law, &strength)| law.set_strength(strength));
}

/// The points whose strength can be lost.
fn brittle(prepared: &Prepared) -> Vec<usize> {
    let pairs = prepared.surfaces.iter().zip(&prepared.problem.labels.pairs);
    pairs.filter(|(surface, _)| surface.friction.is_brittle()).flat_map(|(_, pair)| pair.points.clone()).collect()
}
