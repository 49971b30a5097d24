//! The load state at a time: loads, prescribed displacements, and where the obstacles have moved to.

use std::collections::HashSet;

use super::activity::Activity;
use super::activity::note_gaps;
use super::bolts::{Bolt, thermal_forces};
use super::couplings::Coupling;
use super::frames::{PointFrame, frames};
use super::interface::{InitialStress, initial_forces};
use super::ties::Ties;
use super::travel::{travel, travel_rounding, without};
use super::{Prepared, coefficients, place};
use crate::Error;
use crate::contact::escape::Escape;
use crate::contact::{ContactProblem, ContactSurface, Counterpart, Friction, SurfaceFriction, is_led_into};
use crate::fem::{
    DofMap, Field, Fix, InitialStrain, Load, Solid, Voigt, dof_map, external_forces, full_displacement, initial_strain,
};
use crate::io::case::{Case, Spot, StepSpec};
use crate::mesh::v3::{dot, norm, scale, sub};
use crate::mesh::{Mesh, ascending};

/// Displacements below this part of others are rounding.
const ROUNDING: f64 = 1e-12;

/// The loading as functions of time, with the places of the case for errors.
#[derive(Debug, Clone, Default)]
pub struct Loading {
    /// The loads.
    pub loads: Vec<Load>,
    /// Where the case file asks for them.
    pub load_spots: Vec<Spot>,
    /// Prescribed displacements.
    pub fixes: Vec<Fix>,
    /// Where the case file asks for them.
    pub fix_spots: Vec<Spot>,
    /// Translation of the obstacle of each pair, length.
    pub motions: Vec<Option<[Field; 3]>>,
    /// Where the case file asks for contact.
    pub contact_spots: Vec<Spot>,
    /// The load steps.
    pub steps: Vec<StepSpec>,
    /// Gap and tangential offset of the undeformed body before anything is prescribed or has moved, length, `3m`.
    pub undeformed: Vec<f64>,
    /// How far each point had slid over its obstacle before the present step, length, `2m`.
    pub slid: Vec<f64>,
    /// Thermal strain now, and what tightened bolts do.
    pub initial: Initial,
    /// The stress that each contact carries before anything is loaded.
    pub initial_stresses: Vec<InitialStress>,
    /// Equations between displacements, couplings, and supports that begin or end with a step.
    pub ties: Ties,
    /// The reference points.
    pub couplings: Vec<Coupling>,
    /// The contact points that take part in some steps only.
    pub activity: Activity,
    /// Bonded points that are put in with a step, each with the period: they keep the gap they have when it begins.
    pub put_in: Vec<(usize, [f64; 2])>,
    /// What ties and bonded points that have been put in keep: the sum of each tie and the gap of each point when it began,
    /// length; empty before the first step.
    pub stood: Vec<f64>,
    /// The law of each point while it is in, as at the end of the last step.
    pub laws: Vec<Friction>,
    /// The points whose strength has been lost for good; empty before the first.
    pub lost: Vec<bool>,
    /// The bolts.
    pub bolts: Vec<Bolt>,
    /// How the loads of the present step carry away what they hold, if they do.
    pub of_bolts: Option<Escape>,
    /// The translation that supports and obstacles have in common now, length: what the displacements of the problem leave out.
    pub travel: [f64; 3],
    /// Now.
    pub t: f64,
}

/// Strain without stress, over unknowns and prescribed displacements; its forces are part of the loads as well.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Initial {
    /// Newton, length `n`; empty where there is none.
    pub load: Vec<f64>,
    /// Length `p`.
    pub support_load: Vec<f64>,
    /// Energy of the strain itself.
    pub energy: f64,
    /// Mean strain of each cell; empty where there is none or it is not known.
    pub strain: Vec<Voigt>,
    /// Rise of temperature at the integration points of quadratic cells, see [`InitialStrain`]; empty where there is none or
    /// it is not known.
    pub rise: Vec<f64>,
    /// Shortening of each bolt, length.
    pub shortening: Vec<f64>,
    /// Force through the cut of each bolt that the thermal strain of the cells beyond it causes while no node moves.
    pub thermal_force: Vec<f64>,
}

impl Loading {
    /// As the case says; `undeformed` is found by [`on`](Self::on).
    pub(crate) fn new(case: &Case, loads: Vec<Load>, fixes: Vec<Fix>) -> Self {
        Loading {
            loads,
            load_spots: case.loads.iter().map(|l| l.spot.clone()).collect(),
            fixes,
            initial_stresses: case
                .contacts
                .iter()
                .map(|c| c.initial_stress.clone().map(|stress| (stress, c.spot.clone())))
                .collect(),
            motions: case.contacts.iter().map(|c| c.motion.clone()).collect(),
            contact_spots: case.contacts.iter().map(|c| c.spot.clone()).collect(),
            steps: case.steps.clone(),
            ..Loading::default()
        }
    }

    /// The same on a problem as `pose` left it.
    pub(crate) fn on(mut self, problem: &ContactProblem) -> Self {
        self.undeformed = problem.contact.gap.iter().chain(&problem.contact.slip_reference).copied().collect();
        if let Some(s) = &problem.labels.supports {
            self.undeformed.iter_mut().zip(s.B.times(&s.displacement)).for_each(|(offset, held)| *offset += held);
        }
        self.slid = vec![0.0; 2 * problem.points()];
        self.laws.clone_from(&problem.contact.friction);
        self
    }

    /// Whether there is strain without stress.
    pub(crate) fn strains(&self) -> bool {
        !self.bolts.is_empty() || self.loads.iter().any(|load| matches!(load, Load::Temperature { .. }))
    }

    /// Whether some interface carries a stress before anything is loaded.
    pub(crate) fn is_stressed(&self) -> bool {
        self.initial_stresses.iter().any(Option::is_some)
    }

    /// Whether some obstacle moves.
    pub(crate) fn moves(&self) -> bool {
        self.motions.iter().any(Option::is_some)
    }
}

/// The load state at one time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LoadState {
    pub t: f64,
    /// External forces at the unknowns, newton, length `n`.
    pub load: Vec<f64>,
    /// External forces at the prescribed degrees of freedom, newton, length `p`.
    pub support_load: Vec<f64>,
    /// Prescribed displacements without the travel, length `p`.
    pub displacement: Vec<f64>,
    /// How far the obstacles have moved along the rows of `B`, length, `3m`; towards the body where it is negative in
    /// the normal rows. Overlap of the mesh counts as moved: the obstacle pushes the body out in the first step. Counted without the travel.
    pub motion: Vec<f64>,
    pub initial: Initial,
    /// The laws of friction, `m`; none where they do not change with time.
    pub friction: Option<Vec<Friction>>,
    /// The points that take no part, with the gap each gets more, length.
    pub out: Vec<(usize, f64)>,
    /// The translation that supports and obstacles have in common, length.
    pub travel: [f64; 3],
}

impl LoadState {
    /// Before the first step: nothing acts, and the obstacles touch the undeformed body at most. `n` unknowns, `p`
    /// prescribed displacements, `m` contact points.
    pub(crate) fn start(n: usize, p: usize, m: usize) -> Self {
        LoadState {
            t: 0.0,
            load: vec![0.0; n],
            support_load: vec![0.0; p],
            displacement: vec![0.0; p],
            motion: vec![0.0; 3 * m],
            initial: Initial::default(),
            friction: None,
            out: Vec::new(),
            travel: [0.0; 3],
        }
    }
}

/// The load state at time `t`.
///
/// # Errors
/// Expressions that are not finite at `t`, prescribed displacements that contradict each other then, or motion along
/// the surface at a node whose friction cannot follow it; shown at their place in the case file.
pub(crate) fn load_state(prepared: &Prepared, t: f64) -> Result<LoadState, Error> {
    let Prepared { mesh, materials, material_of_cell, model, loading, .. } = prepared;
    let solid = Solid { mesh, materials, material_of_cell };
    let bolts: Vec<&Bolt> = loading.bolts.iter().collect();
    let loads = loading.loads.iter().zip(&loading.load_spots);
    let Acting { mut force, strained, thermal_force } = acting(&solid, loads, (&bolts, &|_| true), t)?;
    loading.couplings.iter().try_for_each(|coupling| coupling.add_forces(t, &mut force))?;
    let dofs = dof_map(mesh, &loading.fixes, t).map_err(|error| {
        let culprit = (0..loading.fixes.len()).find(|&i| dof_map(mesh, &loading.fixes[..=i], t).is_err());
        culprit.map_or(error.clone(), |i| place::at(&loading.fix_spots[i], error))
    })?;
    let travel = travel(mesh, model, &dofs);
    let motion = motion(prepared, &dofs, travel, t)?;
    refuse_overlap_of_held_nodes(prepared, &dofs, t)?;
    let at_both = |force: &mut Vec<f64>| {
        model.dofs.to_components(force);
        // Nothing acts on a node of an interface but the interface.
        force.resize(model.dofs.unknown.len(), 0.0);
        let at = |dofs: &[u32]| dofs.iter().map(|&dof| force[dof as usize]).collect();
        [at(&model.dofs.free), at(&model.dofs.prescribed)]
    };
    let initial = strained.map_or(Initial::default(), |InitialStrain { strain, rise, mut force, energy }| {
        let [load, support_load] = at_both(&mut force);
        Initial { load, support_load, energy, strain, rise, thermal_force, shortening: Vec::new() }
    });
    let [mut load, mut support_load] = at_both(&mut force);
    if let Some(forces) = initial_forces(prepared)? {
        let contact = &prepared.problem.contact.B;
        load.iter_mut().zip(contact.transpose_times(&forces)).for_each(|(sum, f)| *sum += f);
        if let Some(supports) = &prepared.problem.labels.supports {
            support_load.iter_mut().zip(supports.B.transpose_times(&forces)).for_each(|(sum, f)| *sum += f);
        }
    }
    let displacement = without(travel, &dofs);
    let friction = loading.activity.laws(coefficients_at(prepared, t)?, &loading.laws, t);
    let out = loading.activity.out(t).collect();
    Ok(LoadState { t, load, support_load, displacement, motion, initial, friction, out, travel })
}

fn coefficients_at(prepared: &Prepared, t: f64) -> Result<Option<Vec<Friction>>, Error> {
    let Prepared { mesh, problem, surfaces, loading, facts, .. } = prepared;
    let nodes: Vec<u32> = facts.contacts.iter().flat_map(|contact| contact.surface.nodes.iter().copied()).collect();
    let parts = surfaces.iter().zip(&problem.labels.pairs).zip(&loading.contact_spots);
    let parts = parts.map(|((surface, pair), spot)| (&surface.friction, pair.points.clone(), spot));
    coefficients::at(mesh, &loading.laws, parts, &|j| nodes[j], t)
}

/// What loads do at one time.
pub(crate) struct Acting {
    /// Along x, y, z of all nodes, newton.
    pub force: Vec<f64>,
    /// None where there is no temperature; its forces are in `force`.
    pub strained: Option<InitialStrain>,
    /// Of each bolt, as in [`Initial`].
    pub thermal_force: Vec<f64>,
}

/// What `loads` do at time `t`; of the forces through the cuts of `bolts` those at nodes that `counts` says, of the energy of thermal strain
/// that of cells whose first node it says.
///
/// # Errors
/// As of [`external_forces`], shown where the case asks for the load.
pub(crate) fn acting<'a>(
    solid: &Solid,
    loads: impl Iterator<Item = (&'a Load, &'a Spot)>,
    (bolts, counts): (&[&Bolt], &dyn Fn(u32) -> bool),
    t: f64,
) -> Result<Acting, Error> {
    let mut force = vec![0.0; 3 * solid.mesh.nodes.len()];
    let mut strained: Option<InitialStrain> = None;
    let mut thermal_force = vec![0.0; bolts.len()];
    for (load, spot) in loads {
        if let Some(more) = initial_strain(solid, load, counts, t).map_err(|e| place::instead(spot, e))? {
            force.iter_mut().zip(&more.force).for_each(|(sum, f)| *sum += f);
            strained = Some(strained.map_or(more.clone(), |sum| added(sum, more)));
            let through = thermal_forces(solid, bolts, counts, load, t).map_err(|e| place::instead(spot, e))?;
            thermal_force.iter_mut().zip(through).for_each(|(sum, f)| *sum += f);
            continue;
        }
        let added = external_forces(solid, std::slice::from_ref(load), t).map_err(|e| place::instead(spot, e))?;
        force.iter_mut().zip(added).for_each(|(sum, f)| *sum += f);
    }
    Ok(Acting { force, strained, thermal_force })
}

/// Strains of different cells.
fn added(mut sum: InitialStrain, more: InitialStrain) -> InitialStrain {
    sum.energy += more.energy;
    sum.force.iter_mut().zip(&more.force).for_each(|(a, b)| *a += b);
    for (a, b) in sum.strain.iter_mut().zip(&more.strain) {
        (0..6).for_each(|k| a[k] += b[k]);
    }
    if sum.rise.is_empty() {
        sum.rise = more.rise;
    } else {
        sum.rise.iter_mut().zip(&more.rise).for_each(|(a, b)| *a += b);
    }
    sum
}

fn motion(prepared: &Prepared, dofs: &DofMap, travel: [f64; 3], t: f64) -> Result<Vec<f64>, Error> {
    let (problem, loading) = (&prepared.problem, &prepared.loading);
    let m = problem.points();
    let mut motion: Vec<f64> = loading.undeformed[..m].iter().map(|gap| gap.min(0.0)).collect();
    motion.resize(3 * m, 0.0);
    let frames = frames(prepared);
    let surfaces = prepared.surfaces.iter().zip(&problem.labels.pairs);
    for (((surface, pair), field), spot) in surfaces.zip(&loading.motions).zip(&loading.contact_spots) {
        let translation = translation(field.as_ref(), t).map_err(|error| place::instead(spot, error))?;
        for j in pair.points.clone() {
            let frame = &frames[j];
            refuse_dragging(&prepared.mesh, dofs, frame, translation, loading.laws[j])
                .map_err(|error| place::at(spot, error))?;
            // Two surfaces travel together; an obstacle stays behind.
            let relative = match surface.against {
                Counterpart::Obstacle(_) => sub(translation, travel),
                Counterpart::Surface(_) => translation,
            };
            let translation = scale(problem.labels.unity_sum[j], relative);
            motion[j] += dot(frame.normal, translation);
            motion[m + j] += dot(frame.tangents[0], translation);
            motion[2 * m + j] += dot(frame.tangents[1], translation);
        }
    }
    let Loading { ties, stood, activity, put_in, undeformed, .. } = loading;
    ties.put_into(&mut motion, dofs, stood, travel, t)?;
    activity.keep_gaps((put_in, stood.get(ties.len()..).unwrap_or_default()), undeformed, &mut motion, t);
    Ok(motion)
}

/// How far obstacles have moved at time `t`, length: one for each surface, zero for what does not move.
pub(crate) fn translations(loading: &Loading, t: f64) -> Result<Vec<[f64; 3]>, Error> {
    loading.motions.iter().map(|motion| translation(motion.as_ref(), t)).collect()
}

pub(crate) fn translation(field: Option<&[Field; 3]>, t: f64) -> Result<[f64; 3], Error> {
    let Some([x, y, z]) = field else { return Ok([0.0; 3]) };
    // A translation has no place: an expression that reads one gives NaN and is refused.
    let at = |field: &Field| field.finite_at([f64::NAN; 3], t);
    Ok([at(x)?, at(y)?, at(z)?])
}

fn refuse_overlap_of_held_nodes(prepared: &Prepared, dofs: &DofMap, t: f64) -> Result<(), Error> {
    let Prepared { mesh, problem, loading, .. } = prepared;
    let frames = frames(prepared);
    for (i, (surface, pair)) in prepared.surfaces.iter().zip(&problem.labels.pairs).enumerate() {
        let d = translation(loading.motions[i].as_ref(), t)?;
        let carries: HashSet<u32> = pair.points.clone().map(|j| frames[j].node).collect();
        refuse_overlap(mesh, dofs, surface, &carries, d, t)
            .map_err(|error| place::at(&loading.contact_spots[i], error))?;
    }
    Ok(())
}

/// A node that cannot move along the normal carries no contact point; nothing would keep it out of its obstacle, which has moved
/// by `d` at time `t`. `carries` are the nodes of the surface with a contact point.
pub(crate) fn refuse_overlap(
    mesh: &Mesh,
    dofs: &DofMap,
    surface: &ContactSurface,
    carries: &HashSet<u32>,
    d: [f64; 3],
    t: f64,
) -> Result<(), Error> {
    let Counterpart::Obstacle(obstacle) = &surface.against else { return Ok(()) };
    if surface.friction == SurfaceFriction::Bonded {
        return Ok(());
    }
    for node in mesh.face_nodes(&surface.faces) {
        let held = |c: u32| dofs.prescribed.binary_search(&(3 * node + c)).ok().map(|i| dofs.value[i]);
        let value = [0, 1, 2].map(held);
        let x = mesh.nodes[node as usize];
        let Some((distance, away)) = obstacle.distance(x) else { continue };
        if carries.contains(&node) {
            continue;
        }
        let [away, d] = [away, d].map(|v| dofs.components(node, v));
        // Those without a point that can get out of the way look away from the obstacle.
        if (0..3).any(|c| value[c].is_none() && away[c].abs() > ROUNDING) {
            continue;
        }
        let apart = (0..3).map(|c| away[c] * (value[c].unwrap_or(0.0) - d[c])).sum::<f64>();
        let rounding = ROUNDING * norm(value.map(|v| v.unwrap_or(0.0))).max(norm(d));
        // A travel that both have in common says nothing of what is small beside the other's motion.
        let relative = [0, 1, 2].map(|c| value[c].map_or(0.0, |v| v - d[c]));
        if apart < -rounding && is_led_into(distance, -apart, norm(relative)) {
            let depth = -distance - apart;
            let what =
                format!("node {} at {x:?}, which is held, gets {depth:.3e} into the obstacle at t = {t}", node + 1);
            return Err(Error::new("", what, surface.remedy_of_overlap()));
        }
    }
    Ok(())
}

/// Friction acts along the tangents of a point only: a node with some components held must not slide elsewhere in those.
pub(crate) fn refuse_dragging(
    mesh: &Mesh,
    dofs: &DofMap,
    frame: &PointFrame,
    translation: [f64; 3],
    friction: Friction,
) -> Result<(), Error> {
    let held = |c: usize| dofs.prescribed.binary_search(&(3 * frame.node + c as u32)).ok();
    let [normal, translation] = [frame.normal, translation].map(|v| dofs.components(frame.node, v));
    let relative = [0, 1, 2].map(|c| held(c).map_or(0.0, |i| dofs.value[i] - translation[c]));
    let along = match friction {
        Friction::None => return Ok(()),
        Friction::Bonded => relative,
        Friction::Given { .. } | Friction::Coulomb { .. } | Friction::Limited { .. } | Friction::Cohesive { .. } => {
            sub(relative, scale(dot(relative, normal), normal))
        }
    };
    // Between bodies a node that is held has a tangent where the other body moves.
    let tangents = frame.tangents.map(|tangent| dofs.components(frame.node, tangent));
    let along = tangents.iter().fold(along, |along, &tangent| sub(along, scale(dot(along, tangent), tangent)));
    let value = [0, 1, 2].map(|c| held(c).map_or(0.0, |i| dofs.value[i]));
    if norm(along) <= ROUNDING * norm(value).max(norm(translation)) {
        return Ok(());
    }
    let x = mesh.nodes[frame.node as usize];
    let what = format!("node {} at {x:?} is held in a direction in which it slides over the obstacle", frame.node + 1);
    Err(Error::new("", what, "hold none of its components, or let its support and the obstacle move together"))
}

/// Puts a load state into the problem; `slid` is how far each point has slid over its obstacle so far, length, `2m`.
pub(crate) fn apply(prepared: &mut Prepared, loads: &LoadState, slid: &[f64]) {
    let Prepared { problem, model, loading, .. } = prepared;
    let m = problem.points();
    let place =
        |j: usize| (if j < m { loading.undeformed[j].max(0.0) } else { loading.undeformed[j] }) + loads.motion[j];
    let mut offset: Vec<f64> = (0..3 * m).map(place).collect();
    loads.out.iter().for_each(|&(j, wide)| offset[j] += wide);
    problem.contact.out = ascending(loads.out.iter().map(|&(j, _)| j as u32));
    offset[m..].iter_mut().zip(slid).for_each(|(o, s)| *o += s);
    if let Some(supports) = &mut problem.labels.supports {
        offset.iter_mut().zip(supports.B.times(&loads.displacement)).for_each(|(o, held)| *o -= held);
        supports.load.clone_from(&loads.support_load);
        supports.free_load.clone_from(&loads.load);
        supports.displacement.clone_from(&loads.displacement);
    }
    problem.contact.slip_reference = offset.split_off(m);
    problem.contact.gap = offset;
    if let Some(laws) = &loads.friction {
        problem.contact.friction.clone_from(laws);
        take_lost_strength(&mut problem.contact.friction, &loading.lost);
    }
    loading.slid = slid.to_vec();
    loading.initial.clone_from(&loads.initial);
    (loading.travel, loading.t) = (loads.travel, loads.t);
    problem.contact.rounding = travel_rounding(loads.travel);
    let demanded = model.support_stiffness.transpose_times(&loads.displacement);
    problem.elastic.f = loads.load.iter().zip(demanded).map(|(f, k)| f - k).collect();
    model.load.clone_from(&problem.elastic.f);
    model.support_load.clone_from(&loads.support_load);
    model.dofs.value.clone_from(&loads.displacement);
}

/// Takes from points whose strength is lost what their laws have: it is a state of the interface, no load.
pub(crate) fn take_lost_strength(laws: &mut [Friction], lost: &[bool]) {
    laws.iter_mut().zip(lost).filter(|(_, lost)| **lost).for_each(|(law, _)| law.set_strength([0.0; 2]));
}

/// How far each point has slid over its obstacle since the start, length, `2m`.
pub(crate) fn slid(prepared: &Prepared, loads: &LoadState, u: &[f64]) -> Vec<f64> {
    slid_over(&prepared.problem, loads, &prepared.loading.undeformed, u)
}

/// The same; `undeformed` is gap and tangential offset before anything has moved, length, `3m`.
pub(crate) fn slid_over(problem: &ContactProblem, loads: &LoadState, undeformed: &[f64], u: &[f64]) -> Vec<f64> {
    let m = problem.points();
    let jump = jump(problem, &loads.displacement, u);
    // Points of no surface slide over nothing: their values are what they are.
    let of =
        |i: usize| if problem.labels.unity_sum[i % m] == 0.0 { 0.0 } else { jump[i] - loads.motion[i] - undeformed[i] };
    (m..3 * m).map(of).collect()
}

/// The jump of all degrees of freedom, those that have the prescribed `displacement` included, length, `3m`.
pub(crate) fn jump(problem: &ContactProblem, displacement: &[f64], u: &[f64]) -> Vec<f64> {
    let mut jump = problem.contact.B.times(u);
    if let Some(supports) = &problem.labels.supports {
        jump.iter_mut().zip(supports.B.times(displacement)).for_each(|(j, held)| *j += held);
    }
    jump
}

/// Notes where everything stands that begins at the end `t` of the step that was solved with `loads`, or later.
pub(crate) fn note_where_it_stands(prepared: &mut Prepared, loads: &LoadState, u: &[f64], t: f64) {
    let Prepared { problem, model, loading, .. } = prepared;
    let mut full = full_displacement(model, u);
    model.dofs.to_components(&mut full);
    let mut stood = std::mem::take(&mut loading.stood);
    let ties = loading.ties.len();
    stood.resize(ties + loading.put_in.len(), 0.0);
    let dofs = &model.dofs;
    loading.ties.note(&mut stood[..ties], dofs, &full, loads.travel, t);
    if !loading.put_in.is_empty() {
        let jump = jump(problem, &loads.displacement, u);
        note_gaps((&loading.put_in, &mut stood[ties..]), &jump, &loads.motion, &loading.undeformed, t);
    }
    loading.stood = stood;
}
