//! Motions of bodies among several ranks that nothing resists, or the facets of curved surfaces alone: what `adrift.rs` and `facets.rs` of
//! `run/solve/quantities` find, and what `run/solve/free_motions.rs` does with the former. Rank 0 knows the normals of all surfaces, and how
//! far obstacles of triangles are off.

use std::collections::HashMap;

use super::gather::answered_by_first;
use super::local::Local;
use super::outside::Outside;
use super::solve::{Everywhere, axes, entries};
use super::tighten::Found;
use crate::certificate::certify_divided;
use crate::contact::Counterpart;
use crate::contact::adrift::Held;
use crate::contact::among::Among;
use crate::contact::equilibrium::in_words_among;
use crate::contact::facets::held_among;
use crate::contact::rigid::RigidMotions;
use crate::fem::{full_displacement, nodal_normals};
use crate::friction::{PointState, Status};
use crate::mesh::v3::V3;
use crate::ranks::{from_bytes, max, put, sum, take, to_bytes};
use crate::run::solve::free_motions::moved_back;
use crate::run::solve::quantities::{AdriftRecord, FacetedRecord, adrift_among, between_normals, slides};

/// The motion of an answer, the same on every rank; none where nothing is solved.
pub(super) fn faceted(local: &Local, motions: &RigidMotions, answer: &Found) -> Option<FacetedRecord> {
    let Local { problem, .. } = local;
    if motions.is_empty() || answer.solution.status != Status::Solved {
        return None;
    }
    let is_slip = |j: usize| slides(problem.contact.friction[j], answer.everywhere.states[j] == PointState::Slip);
    let (lambda, angles) = (&answer.everywhere.lambda, angles(local));
    among(local, |among| {
        let found = held_among((problem, motions), (lambda, &is_slip, &angles), among)?;
        Some(FacetedRecord::of(in_words_among(problem, motions, &found.alpha, among.max), &found))
    })
}

/// The motions that nothing resists in an answer, the same on every rank; none where nothing is solved.
pub(super) fn adrift_of(
    local: &Local,
    motions: &RigidMotions,
    answer: &Found,
    unheld: &[String],
) -> Option<AdriftRecord> {
    if answer.solution.status != Status::Solved {
        return None;
    }
    let is_closed = |j: usize| answer.everywhere.states[j] != PointState::Open;
    let held = Held { lambda: &answer.everywhere.lambda, is_closed: &is_closed };
    among(local, |among| adrift_among((&local.problem, motions), (held, unheld), among))
}

/// Moves bodies along such motions as near to the displacements `before` of the unknowns here as gaps allow, as on one machine.
pub(super) fn move_back(
    local: &Local,
    motions: &RigidMotions,
    before: Option<&[f64]>,
    tolerance: f64,
    found: &mut Found,
) {
    let Found { solution, everywhere, .. } = found;
    if !matches!(solution.status, Status::Solved | Status::Uncertified) {
        return;
    }
    let Everywhere { free, lambda, states, .. } = &*everywhere;
    let held = Held { lambda, is_closed: &|j| states[j] != PointState::Open };
    let Local { problem, division, model, .. } = local;
    let Some(u) = among(local, |among| moved_back((problem, motions), before, (free, held), among)) else { return };
    let certificate = certify_divided(problem, division, &u, lambda, tolerance);
    if certificate.passed || !solution.certificate.passed {
        everywhere.u = full_displacement(model, &u).as_chunks().0.to_vec();
        (solution.u, solution.certificate) = (u.clone(), certificate);
        everywhere.free = u;
    }
}

/// Calls `find` with what this rank counts.
pub(super) fn among<T>(local: &Local, find: impl FnOnce(&Among) -> T) -> T {
    let Local { problem, division, .. } = local;
    let labels = problem.elastic.node_of.as_deref().unwrap_or_default();
    find(&Among {
        point: &|j| division.is_own(division.points[j]),
        unknown: &|i| division.is_own(labels[i]),
        sum: &|values| sum(&*division.ranks, values),
        max: &|values| max(&*division.ranks, values),
    })
}

/// By how much the normals of both surfaces differ at the points of this rank, radians; zero at others.
fn angles(local: &Local) -> Vec<f64> {
    let is_own = |j: &usize| local.division.is_own(local.division.points[*j]);
    let own: Vec<usize> = (0..local.timed.contact_points()).filter(is_own).collect();
    let number = |node: u32| local.piece.nodes[node as usize];
    let at: Vec<(u64, V3)> = own.iter().map(|&j| axes(local, j)).map(|(node, [n, ..])| (number(node), n)).collect();
    let others: Vec<Vec<(u64, f64)>> = own.iter().map(|&j| others(local, j)).collect();
    let mut message = Vec::new();
    put(&own.iter().map(|&j| local.pair_of(j) as u32).collect::<Vec<_>>(), &mut message);
    put(&at.iter().map(|at| at.0).collect::<Vec<u64>>(), &mut message);
    put(&at.iter().map(|at| at.1).collect::<Vec<V3>>(), &mut message);
    put(&others.iter().map(|row| row.len() as u32).collect::<Vec<_>>(), &mut message);
    put(&others.iter().flatten().map(|entry| entry.0).collect::<Vec<u64>>(), &mut message);
    put(&others.iter().flatten().map(|entry| entry.1).collect::<Vec<f64>>(), &mut message);
    let reply = |messages: &[Vec<u8>]| match &local.outside {
        Some(outside) => replies(outside, messages),
        None => vec![to_bytes::<f64>(&[]); messages.len()],
    };
    let of_own: Vec<f64> = from_bytes(&answered_by_first(&*local.division.ranks, message, reply));
    let mut angles = vec![0.0; local.problem.points()];
    own.iter().zip(of_own).for_each(|(&j, angle)| angles[j] = angle);
    angles
}

/// The nodes that a point touches, by their numbers in the whole mesh, with how they count.
fn others(local: &Local, j: usize) -> Vec<(u64, f64)> {
    let node = |dof: u32| local.model.dofs.mesh_node(dof / 3);
    let others = entries(local, j).filter(|(dof, _)| node(*dof) != local.node_of(j));
    others.map(|(dof, value)| (local.piece.nodes[node(dof) as usize], value.abs())).collect()
}

/// The angles at the points of each rank.
fn replies(outside: &Outside, messages: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let normals = |of: &Counterpart| match of {
        Counterpart::Surface(master) => nodal_normals(&outside.mesh, &master.faces).into_iter().collect(),
        Counterpart::Obstacle(_) => HashMap::new(),
    };
    let normals: Vec<HashMap<u32, V3>> = outside.surfaces.iter().map(|surface| normals(&surface.against)).collect();
    let reply = |message: &Vec<u8>| {
        let from = &mut &message[..];
        let (pairs, numbers, own): (Vec<u32>, Vec<u64>, Vec<V3>) = (take(from), take(from), take(from));
        let (counts, nodes, weights): (Vec<u32>, Vec<u64>, Vec<f64>) = (take(from), take(from), take(from));
        let mut entries = nodes.into_iter().zip(weights);
        let angle = |(((pair, number), own), count): (((u32, u64), V3), u32)| {
            let entries: Vec<(u64, f64)> = entries.by_ref().take(count as usize).collect();
            match &outside.surfaces[pair as usize].against {
                Counterpart::Surface(_) => {
                    let normal = |(number, weight): (u64, f64)| {
                        Some((*normals[pair as usize].get(&outside.place(number)?)?, weight))
                    };
                    between_normals(own, entries.into_iter().filter_map(normal))
                }
                Counterpart::Obstacle(obstacle) => {
                    let node = outside.place(number).map(|node| outside.mesh.nodes[node as usize]);
                    node.map_or(0.0, |x| obstacle.normal_error(x))
                }
            }
        };
        to_bytes(&pairs.into_iter().zip(numbers).zip(own).zip(counts).map(angle).collect::<Vec<f64>>())
    };
    messages.iter().map(reply).collect()
}
