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
use super::balance::{Counted, potential};
use crate::contact::ContactProblem;
use crate::contact::equilibrium::no_equilibrium;
use crate::contact::escape::{self, Escape};
use crate::contact::rigid::rigid_motions;
use crate::fem::{DofMap, FeModel, full_displacement, reactions};
use crate::friction::{Solution, Status};
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
/// the loads.
pub(crate) fn energy(prepared: &Prepared, u: &[f64]) -> f64 {
    potential(&prepared.problem, u, &Counted::ALL) + prepared.loading.initial.energy
}

/// Force of the supports on the body at each node; zero away from them.
pub(crate) fn reaction(prepared: &Prepared, outcome: &Outcome) -> Vec<[f64; 3]> {
    let Prepared { mesh, model, problem, loading, .. } = prepared;
    let Solution { u, lambda, .. } = &outcome.solution;
    reaction_at_nodes(mesh.nodes.len(), (model, problem), &loading.ties.reactions(lambda, loading.t), u, lambda)
}

/// The same at each of so many nodes; `of_ties` are the forces of supports that begin or end with a step, by degrees of freedom.
pub(crate) fn reaction_at_nodes(
    nodes: usize,
    (model, problem): (&FeModel, &ContactProblem),
    of_ties: &[(u32, f64)],
    u: &[f64],
    lambda: &[f64],
) -> Vec<[f64; 3]> {
    let mut reaction = vec![[0.0; 3]; nodes];
    let mut put = |dof: u32, force: f64| {
        let at = &mut reaction[model.dofs.mesh_node(dof / 3) as usize];
        *at = add(*at, scale(force, model.dofs.direction(dof)));
    };
    let mut force = reactions(model, u);
    if let Some(supports) = &problem.labels.supports {
        // What the obstacle takes at a node that is held in part does not come from the support.
        force.iter_mut().zip(supports.B.transpose_times(lambda)).for_each(|(r, c)| *r += c);
    }
    model.dofs.prescribed.iter().zip(force).for_each(|(&dof, force)| put(dof, force));
    of_ties.iter().for_each(|&(dof, force)| put(dof, force));
    let springs = problem.labels.supports.as_ref().map_or(Vec::new(), |s| s.spring_forces(u));
    model.dofs.free.iter().chain(&model.dofs.prescribed).zip(springs).for_each(|(&dof, force)| put(dof, force));
    reaction
}

/// The force the loads add up to in the step that is solved.
pub(crate) fn load(prepared: &Prepared) -> [f64; 3] {
    load_of(&prepared.model.dofs, &prepared.problem, &Counted::ALL)
}

/// The same of what is `counted`.
pub(crate) fn load_of(dofs: &DofMap, problem: &ContactProblem, counted: &Counted) -> [f64; 3] {
    let Some(supports) = &problem.labels.supports else { return [0.0; 3] };
    let of = |list: &[u32], forces: &[f64], counts: &dyn Fn(usize) -> bool| {
        let all = list.iter().zip(forces).enumerate().filter(|(i, _)| counts(*i));
        all.fold([0.0; 3], |sum, (_, (&dof, force))| add(sum, scale(*force, dofs.direction(dof))))
    };
    let (free, held) = (&supports.free_load, &supports.load);
    add(of(&dofs.free, free, counted.unknown), of(&dofs.prescribed, held, counted.held))
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
