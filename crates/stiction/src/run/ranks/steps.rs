//! Load steps on several ranks: what acts at a time is put into the problem of each, and slip is measured from the last step.
//! Stiffness and `B` stand, so that one hierarchy serves all steps.

use super::bolts::add_forces;
use super::local::{Local, fixes, loads};
use crate::Error;
use crate::fem::{Solid, dof_map, external_forces};
use crate::io::case::Case;

/// Puts loads and prescribed displacements at time `t` into the problem, with the bolts drawn together by `shortening`, where each
/// point has slid by `slid` before; length, `2m`.
pub(super) fn put_state(local: &mut Local, case: &Case, t: f64, slid: &[f64], shortening: &[f64]) -> Result<(), Error> {
    let mesh = &local.piece.mesh;
    let (fixes, loads) = (fixes(mesh, case, &local.symmetry)?, loads(mesh, case, &local.area, t)?);
    let dofs = dof_map(mesh, &fixes, t)?;
    let solid = Solid { mesh, materials: &local.materials, material_of_cell: &local.material_of_cell };
    let mut forces = external_forces(&solid, &loads, t)?;
    dofs.to_components(&mut forces);
    add_forces(local, shortening, &mut forces);
    let Local { model, problem, .. } = local;
    let at = |list: &[u32]| -> Vec<f64> { list.iter().map(|&dof| forces[dof as usize]).collect() };
    let (load, support_load) = (at(&dofs.free), at(&dofs.prescribed));
    let demanded = model.support_stiffness.transpose_times(&dofs.value);
    problem.elastic.f = load.iter().zip(demanded).map(|(f, k)| f - k).collect();
    let m = problem.points();
    let mut offset = [local.undeformed.as_slice(), slid].concat();
    if let Some(supports) = &mut problem.labels.supports {
        offset.iter_mut().zip(supports.B.times(&dofs.value)).for_each(|(o, held)| *o -= held);
        supports.load.clone_from(&support_load);
        supports.free_load = load;
        supports.displacement.clone_from(&dofs.value);
    }
    problem.contact.slip_reference = offset.split_off(m);
    problem.contact.gap = offset;
    model.load.clone_from(&problem.elastic.f);
    model.support_load = support_load;
    model.dofs.value = dofs.value;
    Ok(())
}

/// How far each point here has slid since the start, length, `2m`; `u` are displacements of all unknowns here.
pub(super) fn slid(local: &Local, u: &[f64]) -> Vec<f64> {
    let (problem, m) = (&local.problem, local.problem.points());
    let mut slid = problem.contact.B.times(u).split_off(m);
    if let Some(supports) = &problem.labels.supports {
        let held = supports.B.times(&supports.displacement);
        slid.iter_mut().zip(&held[m..]).for_each(|(slid, held)| *slid += held);
    }
    slid
}
