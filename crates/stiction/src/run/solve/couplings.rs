//! Motion of reference points in an answer, and what acts there.

use serde::{Deserialize, Serialize};

use super::Outcome;
use super::record::or_nans;
use crate::fem::full_displacement;
use crate::mesh::v3::add;
use crate::run::pose::{Coupling, Prepared};

/// A reference point in an answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CouplingState {
    /// Its name.
    pub name: String,
    /// Length; NaN where the coupled nodes do not tell it.
    #[serde(deserialize_with = "or_nans")]
    pub displacement: [f64; 3],
    /// Radians about x, y, z; NaN where the coupled nodes do not tell it.
    #[serde(deserialize_with = "or_nans")]
    pub rotation: [f64; 3],
    /// What acts on the body through the point, loads and reactions of prescribed motions, newton.
    #[serde(deserialize_with = "or_nans")]
    pub force: [f64; 3],
    /// The same about the point, newton times length.
    #[serde(deserialize_with = "or_nans")]
    pub moment: [f64; 3],
}

impl CouplingState {
    /// Of a point that moves so, on which the prescribed motions react so at time `t`.
    pub(crate) fn new(coupling: &Coupling, motion: [f64; 6], reaction: [f64; 6], t: f64) -> Self {
        // The load has been found finite when the step began.
        let load = coupling.load(t).unwrap_or([f64::NAN; 6]);
        let [x, y, z, a, b, c] = motion;
        let [fx, fy, fz, mx, my, mz] = std::array::from_fn(|k| load[k] + reaction[k]);
        let (displacement, rotation, force, moment) = ([x, y, z], [a, b, c], [fx, fy, fz], [mx, my, mz]);
        CouplingState { name: coupling.name.clone(), displacement, rotation, force, moment }
    }
}

/// The state of each reference point.
pub fn coupling_states(prepared: &Prepared, outcome: &Outcome) -> Vec<CouplingState> {
    let loading = &prepared.loading;
    if loading.couplings.is_empty() {
        return Vec::new();
    }
    let u = full_displacement(&prepared.model, &outcome.solution.u);
    let at = |node: u32| add(u.as_chunks::<3>().0[node as usize], loading.travel);
    let of_ties = loading.ties.forces(&outcome.solution.lambda, loading.t);
    let state = |coupling: &Coupling| {
        let mut reaction = [0.0; 6];
        for (tie, by) in &coupling.prescribed {
            reaction.iter_mut().zip(by).for_each(|(sum, by)| *sum += of_ties[*tie] * by);
        }
        CouplingState::new(coupling, coupling.motion(at), reaction, loading.t)
    };
    loading.couplings.iter().map(state).collect()
}
