//! Pressure and shear at contact points that are divided among ranks. Between two bodies they are means over nodes of the other
//! surface, which rank 0 takes from the areas and forces of all points.

use std::collections::BTreeSet;

use super::gather::answered_by_first;
use super::local::Local;
use super::solve::{axes, entries};
use crate::certificate::ghost_values;
use crate::contact::TributaryArea;
use crate::mesh::v3::{V3, add, dot, scale};
use crate::ranks::{put, take};
use crate::run::solve::tractions::{Traction, project, rubbing};

/// Tractions of all points here, and of each surface the largest pressure at a node of the other one, the same on every rank.
pub(super) struct RankTractions {
    pub points: Vec<Traction>,
    pub max_other_pressure: Vec<f64>,
    /// At own points work of friction and pressure times slip of the load step, energy per area, as
    /// [`Tractions::rubbing`](crate::run::solve::tractions::Tractions::rubbing).
    pub rubbing: Vec<[f64; 2]>,
    /// Of each pair at own nodes of the other surface that some point reaches; nothing on obstacles.
    pub masters: Vec<Vec<(u32, Traction)>>,
}

/// Those of an answer, of which `u` are the displacements of all unknowns and `lambda` the multipliers of all points here.
pub(super) fn tractions(local: &Local, u: &[f64], lambda: &[f64]) -> RankTractions {
    let (problem, division) = (&local.problem, &local.division);
    let (m, count) = (problem.points(), local.timed.contact_points());
    let quotient = |j: usize| {
        if j >= count {
            return [0.0; 4];
        }
        let (_, [_, t1, t2]) = axes(local, j);
        let [x, y, z] = add(scale(lambda[m + j], t1), scale(lambda[2 * m + j], t2));
        [lambda[j], x, y, z].map(|force| force / problem.labels.area[j])
    };
    let mut points: Vec<Traction> = (0..m).map(quotient).collect();
    let mut rubbing = rubbing(problem, u, lambda, count);
    if !local.between_bodies.contains(&true) {
        let pairs = local.signs.len();
        return RankTractions {
            points,
            max_other_pressure: vec![0.0; pairs],
            rubbing,
            masters: vec![Vec::new(); pairs],
        };
    }
    let is_own = |j: &usize| division.is_own(division.points[*j]) && local.between_bodies[local.pair_of(*j)];
    let own: Vec<usize> = (0..count).filter(is_own).collect();
    let of_rubbing = |j: usize| [rubbing[j][0], rubbing[j][1], 0.0, 0.0];
    let [forces, works]: [Vec<Traction>; 2] =
        [own.iter().map(|&j| points[j]).collect(), own.iter().map(|&j| of_rubbing(j)).collect()];
    let (([means, works], max_other_pressure), masters) = exchanged(local, &own, [forces, works]);
    own.iter().zip(means).for_each(|(&j, mean)| points[j] = mean);
    own.iter().zip(works).for_each(|(&j, [work, pressed, ..])| rubbing[j] = [work, pressed]);
    // Three numbers of a point at a time are asked of its owner.
    let zeros = vec![0.0; problem.unknowns()];
    let fetch = |of: [usize; 3]| {
        let values: Vec<f64> = of.iter().flat_map(|&c| points.iter().map(move |t| t[c])).collect();
        ghost_values(problem, division, &zeros, &values).1
    };
    let (first, last) = (fetch([0, 1, 2]), fetch([3, 3, 3]));
    let points = (0..m).map(|j| [first[j], first[m + j], first[2 * m + j], last[j]]).collect();
    RankTractions { points, max_other_pressure, rubbing, masters }
}

/// Of the points their means of forces and of works, and of each pair the largest pressure at a node of the other surface.
type Means = ([Vec<Traction>; 2], Vec<f64>);

/// The means at the points `own` of both of their quotients, force and work over area, and of each pair the tractions at own nodes of the other
/// surface; found by rank 0 for all ranks.
fn exchanged(local: &Local, own: &[usize], quotients: [Vec<Traction>; 2]) -> (Means, Vec<Vec<(u32, Traction)>>) {
    let ranks = &*local.division.ranks;
    let shared: Vec<Vec<(u64, f64)>> = own.iter().map(|&j| shared(local, j)).collect();
    let mut message = Vec::new();
    put(&own.iter().map(|&j| local.pair_of(j) as u32).collect::<Vec<_>>(), &mut message);
    quotients.iter().for_each(|of| put(of, &mut message));
    put(&shared.iter().map(|row| row.len() as u32).collect::<Vec<_>>(), &mut message);
    put(&shared.iter().flatten().map(|entry| entry.0).collect::<Vec<u64>>(), &mut message);
    put(&shared.iter().flatten().map(|entry| entry.1).collect::<Vec<f64>>(), &mut message);
    let nodes_of = |areas: &Vec<TributaryArea>| -> Vec<u32> {
        areas.iter().map(|area| area.node).filter(|&node| local.division.is_own(node)).collect()
    };
    let masters: Vec<Vec<u32>> = local.masters.iter().map(nodes_of).collect();
    for nodes in &masters {
        put(&nodes.iter().map(|&node| local.piece.nodes[node as usize]).collect::<Vec<u64>>(), &mut message);
    }
    let reply = answered_by_first(ranks, message, |messages| replies(messages, local.signs.len()));
    let mut from = &reply[..];
    let means = ([take(&mut from), take(&mut from)], take(&mut from));
    let reached = |nodes: Vec<u32>| {
        let all = nodes.into_iter().zip(take::<Traction>(&mut from));
        all.filter(|(_, traction)| !traction[0].is_nan()).collect()
    };
    (means, masters.into_iter().map(reached).collect())
}

/// What a point shares with the nodes of the other surface, by their numbers in the whole mesh, with the partition of unity in it;
/// area. On quadratic faces it is that of the functions with positive integrals.
fn shared(local: &Local, j: usize) -> Vec<(u64, f64)> {
    let (problem, dofs) = (&local.problem, &local.model.dofs);
    let (own, axes) = axes(local, j);
    let Some((i, axis)) = problem.rows(j).into_iter().zip(axes).find(|(_, axis)| dot(*axis, *axis) > 0.0) else {
        return Vec::new();
    };
    let master = &local.masters[local.pair_of(j)];
    let weight = |dof: u32, value: f64| -> f64 {
        -problem.labels.area[j] * value * dot(dofs.direction(dof), axis) / dot(axis, axis)
    };
    let number = |node: u32| local.piece.nodes[node as usize];
    let mut shared: Vec<(u64, f64)> = Vec::new();
    for (dof, value) in entries(local, i).filter(|(dof, _)| dof / 3 != own) {
        let Ok(at) = master.binary_search_by_key(&(dof / 3), |area| area.node) else { continue };
        let part = weight(dof, value);
        shared.push((number(dof / 3), part * master[at].unity_sum()));
        shared.extend(master[at].others.iter().map(|&(end, weight)| (number(end), -part * weight)));
    }
    shared.sort_by_key(|entry| entry.0);
    shared.chunk_by(|a, b| a.0 == b.0).map(|terms| (terms[0].0, terms.iter().map(|term| term.1).sum())).collect()
}

/// A point of a rank: its pair, its quotients of force and of work and area, and what it shares.
type Sent = (u32, [Traction; 2], Vec<(u64, f64)>);

/// The messages of rank 0 to all ranks, of so many surfaces.
fn replies(messages: &[Vec<u8>], surfaces: usize) -> Vec<Vec<u8>> {
    let (all, asked): (Vec<Vec<Sent>>, Vec<Vec<Vec<u64>>>) =
        messages.iter().map(|message| sent(message, surfaces)).unzip();
    let mut received: Vec<Vec<Vec<Traction>>> =
        asked.iter().map(|of| of.iter().map(|nodes| vec![[f64::NAN; 4]; nodes.len()]).collect()).collect();
    let mut means: Vec<[Vec<Traction>; 2]> =
        all.iter().map(|points| [0, 1].map(|_| vec![[0.0; 4]; points.len()])).collect();
    let mut most = vec![0.0; surfaces];
    let pairs: BTreeSet<u32> = all.iter().flatten().map(|point| point.0).collect();
    for pair in pairs {
        let of_rank = |(rank, points): (usize, &Vec<Sent>)| {
            let own = points.iter().enumerate().filter(|(_, point)| point.0 == pair);
            own.map(|(place, _)| (rank, place)).collect::<Vec<_>>()
        };
        let places: Vec<(usize, usize)> = all.iter().enumerate().flat_map(of_rank).collect();
        let rows = || places.iter().map(|&(rank, place)| &all[rank][place]);
        let mut nodes: Vec<u64> = rows().flat_map(|point| &point.2).map(|entry| entry.0).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let place = |node: u64| nodes.partition_point(|&other| other < node);
        let shared: Vec<Vec<(usize, f64)>> =
            rows().map(|point| point.2.iter().map(|&(node, area)| (place(node), area)).collect()).collect();
        for which in [0, 1] {
            let quotients: Vec<Traction> = rows().map(|point| point.1[which]).collect();
            let (of_points, of_nodes) = project(&shared, &quotients, nodes.len());
            places.iter().zip(of_points).for_each(|(&(rank, place), mean)| means[rank][which][place] = mean);
            if which == 0 {
                let pair = pair as usize;
                most[pair] = of_nodes.iter().flatten().fold(0.0, |most: f64, traction| most.max(traction[0]));
                for (asked, received) in asked.iter().zip(&mut received) {
                    for (number, to) in asked[pair].iter().zip(&mut received[pair]) {
                        let found = nodes.binary_search(number).ok().and_then(|place| of_nodes[place]);
                        found.iter().for_each(|traction| *to = *traction);
                    }
                }
            }
        }
    }
    let reply = |(means, received): (&[Vec<Traction>; 2], &Vec<Vec<Traction>>)| {
        let mut to = Vec::new();
        means.iter().for_each(|of| put(of, &mut to));
        put(&most, &mut to);
        received.iter().for_each(|of| put(of, &mut to));
        to
    };
    means.iter().zip(&received).map(reply).collect()
}

/// The points of a message, and of each of so many surfaces the nodes that are asked for.
fn sent(mut message: &[u8], surfaces: usize) -> (Vec<Sent>, Vec<Vec<u64>>) {
    let from = &mut message;
    let pairs: Vec<u32> = take(from);
    let [forces, works]: [Vec<Traction>; 2] = [take(from), take(from)];
    let counts: Vec<u32> = take(from);
    let (nodes, areas): (Vec<u64>, Vec<f64>) = (take(from), take(from));
    let mut shared = nodes.into_iter().zip(areas);
    let rows = counts.into_iter().map(|count| shared.by_ref().take(count as usize).collect());
    let quotients = forces.into_iter().zip(works).map(|(force, work)| [force, work]);
    let points = pairs.into_iter().zip(quotients).zip(rows).map(|((pair, quotients), row)| (pair, quotients, row));
    let points = points.collect();
    (points, (0..surfaces).map(|_| take(from)).collect())
}

/// The shear of a traction.
pub(super) fn shear([_, x, y, z]: Traction) -> V3 {
    [x, y, z]
}
