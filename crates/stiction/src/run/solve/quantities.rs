//! Single quantities of an answer: energy, forces of supports and loads, the largest displacement, how a body escapes, how small
//! its deformation is.

mod adrift;
mod couple;
mod facets;
mod micromotion;
mod smallness;
mod unheld;

pub use super::discretisation::nodal_stress_of;
pub(crate) use super::discretisation::stress_at;
pub use adrift::AdriftRecord;
pub(crate) use adrift::{adrift_among, adrift_of};
pub(crate) use couple::{Couple, Forces, couples, may_lie_apart};
pub use facets::FacetedRecord;
pub(crate) use facets::{between_normals, faceted, slides};
pub use micromotion::Micromotion;
pub(super) use micromotion::micromotions;
pub(crate) use micromotion::percentiles;
pub(super) use smallness::smallness;
pub(crate) use smallness::{Displaced, Extreme, extremes, of_extremes};
pub use smallness::{SMALL_ROTATION, SMALL_STRAIN, Smallness};
pub(crate) use unheld::{unheld, unheld_among};

use super::Outcome;
use crate::contact::ContactProblem;
use crate::contact::equilibrium::no_equilibrium;
use crate::contact::escape::{self, Escape};
use crate::contact::rigid::rigid_motions;
use crate::fem::{full_displacement, reactions};
use crate::friction::Status;
use crate::mesh::v3::{add, norm, scale};
use crate::run::pose::Prepared;

/// The largest displacement of a node, and where the node is.
pub(crate) fn largest_displacement(prepared: &Prepared, outcome: &Outcome) -> (f64, [f64; 3]) {
    let u = full_displacement(&prepared.model, &outcome.solution.u);
    let size = |u: &[f64; 3]| norm(add(*u, prepared.loading.travel));
    let sizes = u.as_chunks().0.iter().map(size).zip(&prepared.mesh.nodes);
    sizes.fold((0.0, [0.0; 3]), |best, (size, x)| if size > best.0 { (size, *x) } else { best })
}

/// `1/2 u'Ku - f'u` over all degrees of freedom, the prescribed ones included: what the body stores less the work of
/// the loads. `problem.f` holds what the prescribed displacements demand of the unknowns, their mixed term.
pub(crate) fn energy(prepared: &Prepared, u: &[f64]) -> f64 {
    let problem = &prepared.problem;
    let unknowns = potential(&problem.elastic.K.times(u), &problem.elastic.f, u);
    let supports = problem
        .labels
        .supports
        .as_ref()
        .map_or(0.0, |s| potential(&s.K_own.times(&s.displacement), &s.load, &s.displacement));
    unknowns + supports + prepared.loading.initial.energy
}

/// `1/2 u'Ku - f'u` for `elastic` `= K u`.
fn potential(elastic: &[f64], load: &[f64], u: &[f64]) -> f64 {
    elastic.iter().zip(load).zip(u).map(|((k, f), u)| (0.5 * k - f) * u).sum()
}

/// Force of the supports on the body at each node; zero away from them.
pub(crate) fn reaction(prepared: &Prepared, outcome: &Outcome) -> Vec<[f64; 3]> {
    let Prepared { mesh, model, problem, .. } = prepared;
    let mut reaction = vec![[0.0; 3]; mesh.nodes.len()];
    let put = |reaction: &mut [[f64; 3]], dof: u32, force: f64| {
        let at = &mut reaction[model.dofs.mesh_node(dof / 3) as usize];
        *at = add(*at, scale(force, model.dofs.direction(dof)));
    };
    let mut force = reactions(model, &outcome.solution.u);
    if let Some(supports) = &problem.labels.supports {
        // What the obstacle takes at a node that is held in part does not come from the support.
        let contact = supports.B.transpose_times(&outcome.solution.lambda);
        force.iter_mut().zip(contact).for_each(|(r, c)| *r += c);
    }
    for (&dof, force) in model.dofs.prescribed.iter().zip(force) {
        put(&mut reaction, dof, force);
    }
    for (dof, force) in prepared.loading.ties.reactions(&outcome.solution.lambda, prepared.loading.t) {
        put(&mut reaction, dof, force);
    }
    let springs = problem.labels.supports.as_ref().map_or(Vec::new(), |s| s.spring_forces(&outcome.solution.u));
    for (&dof, force) in model.dofs.free.iter().chain(&model.dofs.prescribed).zip(springs) {
        put(&mut reaction, dof, force);
    }
    reaction
}

/// The force the loads add up to in the step that is solved.
pub(crate) fn load(prepared: &Prepared) -> [f64; 3] {
    let dofs = &prepared.model.dofs;
    let mut sum = [0.0; 3];
    if let Some(supports) = &prepared.problem.labels.supports {
        let free = dofs.free.iter().zip(&supports.free_load);
        let held = dofs.prescribed.iter().zip(&supports.load);
        free.chain(held).for_each(|(&dof, force)| sum = add(sum, scale(*force, dofs.direction(dof))));
    }
    sum
}

/// How the loads carry a body or what bolts hold away, if the status says that nothing balances them.
pub fn escape_of(prepared: &Prepared, status: Status) -> Option<Escape> {
    let of_bolts = prepared.loading.of_bolts.clone().filter(|_| status == Status::NoEquilibrium);
    of_bolts.or_else(|| escape(&prepared.problem, status))
}

/// How the loads carry a body away, if the status says that nothing balances them.
pub fn escape(problem: &ContactProblem, status: Status) -> Option<Escape> {
    if status != Status::NoEquilibrium {
        return None;
    }
    let motions = rigid_motions(problem);
    no_equilibrium(problem, &motions).map(|slide| escape::escape(problem, &motions, &slide))
}
