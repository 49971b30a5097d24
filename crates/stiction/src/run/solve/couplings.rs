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
        let [x, y, z, a, b, c] = coupling.motion(at);
        // The load has been found finite when the step began.
        let mut load = coupling.load(loading.t).unwrap_or([f64::NAN; 6]);
        for (tie, by) in &coupling.prescribed {
            load.iter_mut().zip(by).for_each(|(load, by)| *load += of_ties[*tie] * by);
        }
        let [fx, fy, fz, mx, my, mz] = load;
        let (displacement, rotation, force, moment) = ([x, y, z], [a, b, c], [fx, fy, fz], [mx, my, mz]);
        CouplingState { name: coupling.name.clone(), displacement, rotation, force, moment }
    };
    loading.couplings.iter().map(state).collect()
}
