//! Strength that is lost for good: points that slip or open at the end of a solve keep friction alone.

use crate::contact::Friction;
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
            lost = true;
        }
    }
    lost
}

/// The strength of all points, two numbers each, as a step's file has it; empty where none can be lost.
pub(super) fn kept(prepared: &Prepared) -> Vec<f64> {
    if brittle(prepared).is_empty() {
        return Vec::new();
    }
    prepared.problem.contact.friction.iter().flat_map(Friction::strength).collect()
}

/// Puts back what [`kept`] has given.
pub(super) fn restore(laws: &mut [Friction], kept: &[f64]) {
    laws.iter_mut().zip(kept.as_chunks().0).for_each(|(law, &strength)| law.set_strength(strength));
}

/// The points whose strength can be lost.
fn brittle(prepared: &Prepared) -> Vec<usize> {
    let pairs = prepared.surfaces.iter().zip(&prepared.problem.labels.pairs);
    pairs.filter(|(surface, _)| surface.friction.is_brittle()).flat_map(|(_, pair)| pair.points.clone()).collect()
}
