//! Load steps on several ranks: what acts at a time is put into the problem of each, and slip is measured from the last step.
//! Stiffness and `B` stand, so that one hierarchy serves all steps.

use super::bolts::add_forces;
use super::energy;
use super::local::{Local, fixes, is_stressed, loads};
use super::solve::axes;
use super::timed::laws;
use crate::Error;
use crate::fem::{DofMap, Solid, dof_map, full_displacement};
use crate::io::case::Case;
use crate::mesh::ascending;
use crate::mesh::v3::{dot, scale};
use crate::run::pose::bolts::Bolt;
use crate::run::pose::frames::PointFrame;
use crate::run::pose::interface::forces_of;
use crate::run::pose::load_state::{Acting, acting, jump, refuse_dragging, translation};
use crate::run::pose::place;

/// Puts loads and prescribed displacements at time `t` into the problem, with the bolts drawn together by `shortening`, where each
/// point has slid by `slid` before; length, `2m`.
pub(super) fn put_state(local: &mut Local, case: &Case, t: f64, slid: &[f64], shortening: &[f64]) -> Result<(), Error> {
    let mesh = &local.piece.mesh;
    let (fixes, (loads, spots)) = (fixes(mesh, case, &local.symmetry), loads(mesh, case, &local.moments, t)?);
    let dofs = dof_map(mesh, &fixes, t)?;
    let solid = Solid { mesh, materials: &local.materials, material_of_cell: &local.material_of_cell };
    let (bolts, own): (Vec<&Bolt>, _) = (local.bolts.iter().map(|b| &b.bolt).collect(), |v| local.division.is_own(v));
    let acting = acting(&solid, loads.iter().zip(spots), (&bolts, &own), t)?;
    let Acting { force: mut forces, strained, thermal_force } = acting;
    let strained = energy::initial(local, strained, thermal_force, shortening);
    local.couplings.iter().try_for_each(|coupling| coupling.add_forces(t, &mut forces))?;
    dofs.to_components(&mut forces);
    add_forces(local, shortening, &mut forces);
    let (laws, motion) = (laws(local, case, t)?, motion(local, case, &dofs, t)?);
    let initial = initial_forces(local, case)?;
    let Local { model, problem, timed, .. } = local;
    let at = |list: &[u32]| -> Vec<f64> { list.iter().map(|&dof| forces[dof as usize]).collect() };
    // On layers of interfaces that yield nothing acts.
    let free = |dof: &u32| forces.get(*dof as usize).copied().unwrap_or(0.0);
    let (mut load, mut support_load) = (model.dofs.free.iter().map(free).collect::<Vec<f64>>(), at(&dofs.prescribed));
    if let Some(forces) = initial {
        let add = |sum: &mut [f64], more: Vec<f64>| sum.iter_mut().zip(more).for_each(|(sum, f)| *sum += f);
        add(&mut load, problem.contact.B.transpose_times(&forces));
        problem.labels.supports.iter().for_each(|held| add(&mut support_load, held.B.transpose_times(&forces)));
    }
    let demanded = model.support_stiffness.transpose_times(&dofs.value);
    problem.elastic.f = load.iter().zip(demanded).map(|(f, k)| f - k).collect();
    let m = problem.points();
    let apart = local.undeformed.iter().map(|gap| gap.max(0.0));
    let mut offset: Vec<f64> = apart.chain(slid.iter().copied()).collect();
    offset.iter_mut().zip(&motion).for_each(|(o, moved)| *o += moved);
    timed.out(t).for_each(|(j, wide)| offset[j] += wide);
    problem.contact.out = ascending(timed.out(t).map(|(j, _)| j as u32));
    if let Some(supports) = &mut problem.labels.supports {
        offset.iter_mut().zip(supports.B.times(&dofs.value)).for_each(|(o, held)| *o -= held);
        supports.load.clone_from(&support_load);
        supports.free_load = load;
        supports.displacement.clone_from(&dofs.value);
    }
    problem.contact.slip_reference = offset.split_off(m);
    problem.contact.gap = offset;
    problem.contact.friction = laws;
    model.load.clone_from(&problem.elastic.f);
    model.support_load = support_load;
    model.dofs.value = dofs.value;
    local.motion = motion;
    local.initial = strained;
    Ok(())
}

/// How far each point here has slid since the start, length, `2m`; `u` are displacements of all unknowns here.
pub(super) fn slid(local: &Local, u: &[f64]) -> Vec<f64> {
    let (problem, m) = (&local.problem, local.problem.points());
    let held = problem.labels.supports.as_ref().map_or(&[][..], |supports| &supports.displacement);
    let jump = jump(problem, held, u);
    // Points of no surface slide over nothing: their values are what they are.
    let of = |i: usize| if problem.labels.unity_sum[i % m] == 0.0 { 0.0 } else { jump[i] - local.motion[i] };
    (m..3 * m).map(of).collect()
}

/// Displacements of all degrees of freedom here; `u` are those of all unknowns here.
pub(super) fn full(local: &Local, u: &[f64]) -> Vec<f64> {
    let mut full = full_displacement(&local.model, u);
    local.model.dofs.to_components(&mut full);
    full
}

/// The contact forces here of the stresses that interfaces carry before anything is loaded, newton, `3m`; none where no contact has any.
fn initial_forces(local: &Local, case: &Case) -> Result<Option<Vec<f64>>, Error> {
    if !is_stressed(case) {
        return Ok(None);
    }
    let contacts = local.contact_of.iter().map(|&k| &case.contacts[k as usize]);
    let stresses = contacts.map(|contact| Some((contact.initial_stress.as_ref()?, &contact.spot)));
    forces_of(&local.piece.mesh, &local.problem, &|j| frame(local, j), stresses).map(Some)
}

fn frame(local: &Local, j: usize) -> PointFrame {
    let (node, [normal, t1, t2]) = axes(local, j);
    PointFrame { node, normal, tangents: [t1, t2], sign: 1.0 }
}

/// How far the obstacles have moved at time `t` along the rows of `B` at each point here, length, `3m`; overlap of the mesh counts
/// as moved, and so does what is kept of a gap.
fn motion(local: &Local, case: &Case, dofs: &DofMap, t: f64) -> Result<Vec<f64>, Error> {
    let (problem, mesh) = (&local.problem, &local.piece.mesh);
    let m = problem.points();
    let mut motion: Vec<f64> = local.undeformed.iter().map(|gap| gap.min(0.0)).collect();
    motion.resize(3 * m, 0.0);
    for (pair, &k) in problem.labels.pairs.iter().zip(&local.contact_of) {
        let contact = &case.contacts[k as usize];
        let moved = translation(contact.motion.as_ref(), t);
        let moved = moved.map_err(|error| place::instead(&contact.spot, error))?;
        for j in pair.points.clone() {
            let frame = frame(local, j);
            refuse_dragging(mesh, dofs, &frame, moved, local.timed.laws[j])
                .map_err(|error| place::at(&contact.spot, error))?;
            let by = scale(problem.labels.unity_sum[j], moved);
            let PointFrame { normal, tangents: [t1, t2], .. } = frame;
            [normal, t1, t2].iter().enumerate().for_each(|(r, axis)| motion[r * m + j] += dot(*axis, by));
        }
    }
    local.timed.put_into(&mut motion, dofs, &local.undeformed, t)?;
    Ok(motion)
}
