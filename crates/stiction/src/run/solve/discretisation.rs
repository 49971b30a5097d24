//! How good the mesh is for an answer.

use super::Outcome;
use super::quantities::smallness;
use crate::accuracy::{Estimate, NodalStress, Straining, estimate, nodal_stress, nodal_stress_at};
use crate::fem::{Load, Solid, Voigt, full_displacement};
use crate::friction::Status;
use crate::run::pose::{Prepared, stopwatch};

/// Estimates the discretisation error of the displacements `u`, one for each unknown, under the loads that `prepared`
/// holds: those of the last step that was solved.
///
/// Springs store energy as well, which is not part of the norm.
///
/// # Panics
/// If `u` has not one entry per unknown.
pub fn discretisation_error(prepared: &Prepared, u: &[f64]) -> Estimate {
    strained(prepared, u, &regions(prepared), estimate)
}

/// Stress and strain at the nodes for the displacements `u`, one for each unknown, under the loads that `prepared` holds.
///
/// # Panics
/// If `u` has not one entry per unknown.
pub fn nodal_stress_of(prepared: &Prepared, u: &[f64]) -> NodalStress {
    strained(prepared, u, &prepared.material_of_cell, nodal_stress)
}

/// The stress at the nodes for which `wanted` is true, NaN at the others.
pub(crate) fn stress_at(prepared: &Prepared, u: &[f64], wanted: &[bool]) -> Vec<Voigt> {
    let find = |solid: &Solid, straining: &Straining| nodal_stress_at(solid, straining, Some(wanted)).stress;
    strained(prepared, u, &prepared.material_of_cell, find)
}

/// What `find` makes of the body under its loads, displaced by `u`.
fn strained<T>(prepared: &Prepared, u: &[f64], region: &[u32], find: impl Fn(&Solid, &Straining) -> T) -> T {
    let Prepared { mesh, materials, material_of_cell, model, loading, .. } = prepared;
    let initial = &loading.initial;
    // Before a bolt is tightened its shortening is not there.
    let cuts: Vec<_> = loading.bolts.iter().zip(&initial.shortening).map(|(bolt, &s)| (&bolt.cut, s)).collect();
    let straining = Straining {
        displacement: &full_displacement(model, u),
        initial: &initial.strain,
        rise: &initial.rise,
        cuts: &cuts,
        region,
    };
    find(&Solid { mesh, materials, material_of_cell }, &straining)
}

/// A number for each cell: cells of one material under one temperature load have the same.
fn regions(prepared: &Prepared) -> Vec<u32> {
    let mut region = prepared.material_of_cell.clone();
    let count = prepared.materials.len() as u32;
    let mut heated = 0;
    for load in &prepared.loading.loads {
        if let Load::Temperature { cells, .. } = load {
            heated += count;
            cells.iter().for_each(|&cell| region[cell as usize] = heated + prepared.material_of_cell[cell as usize]);
        }
    }
    region
}

/// Estimates it for an answer and measures its deformation, unless that holds a body by force or is none; the time is part of the
/// output.
pub(crate) fn add_estimate(prepared: &Prepared, outcome: &mut Outcome) {
    if matches!(outcome.solution.status, Status::NoEquilibrium) {
        return;
    }
    let mut lap = stopwatch();
    outcome.estimate = Some(discretisation_error(prepared, &outcome.solution.u));
    outcome.smallness = Some(smallness(prepared, outcome));
    outcome.seconds.output = outcome.seconds.output + lap();
}
