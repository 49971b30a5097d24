//! Nested iteration on several ranks: displacements to start from, of the same case on a coarser block that the ranks divide among
//! them as they do the case.

use std::ops::ControlFlow;
use std::sync::Arc;

use rayon::prelude::*;

use super::homes::{Homes, Plan};
use super::local::{Local, local};
use super::share::share;
use super::solve::{Marched, Start, march};
use crate::Error;
use crate::friction::{Multigrid, Settings, SolverPath};
use crate::io::case::Case;
use crate::linalg::Stop;
use crate::mesh::v3::V3;
use crate::ranks::{Ranks, all_to_all, put, take};
use crate::run::pose::CoarserCase;
use crate::run::solve::nested::{around, settings};

/// Displacements of all unknowns of `fine` here, length; on all ranks or on none. There are none if the mesh is not a block that has a
/// coarser one with enough nodes for all ranks, or if that is not solved.
pub(super) fn start(case: &Case, fine: &Local) -> Option<Vec<f64>> {
    let coarser = CoarserCase::of(case)?;
    let ranks = &fine.division.ranks;
    let (coarse, u) = solved(&coarser.case, ranks).ok()??;
    let nodes = &fine.piece.mesh.nodes;
    // Where each node of the coarser block is among those around nodes here, of which every one is named up to 64 times.
    let mut place = vec![None; coarse.sizes[0] as usize];
    nodes.iter().flat_map(|&x| around(&coarser.axes, x)).for_each(|(node, _)| place[node as usize] = Some(0));
    let mut wanted: Vec<u64> = Vec::new();
    for (place, node) in place.iter_mut().zip(0..).filter(|(place, _)| place.is_some()) {
        *place = Some(wanted.len() as u32);
        wanted.push(node);
    }
    let u = fetched(&coarse, &u, &wanted, &**ranks);
    let at = |&x: &V3| {
        let mut sum = [0.0; 3];
        for (node, weight) in around(&coarser.axes, x) {
            let Some(place) = place[node as usize] else { continue };
            (0..3).for_each(|c| sum[c] += weight * u[place as usize][c]);
        }
        sum
    };
    Some(Start::Displacements(nodes.par_iter().map(at).collect()).displacements(fine))
}

/// What a rank has of the case, and displacements of all nodes there; `None` if it is not solved. Errors and answers are those of all
/// ranks.
fn solved(case: &Case, ranks: &Arc<dyn Ranks>) -> Result<Option<(Local, Vec<V3>)>, Error> {
    let share = share(case, &**ranks)?;
    let mut local = local(case, share, ranks)?;
    let (mut multigrid, own) = Multigrid::divided(&local.problem, &local.division, &Stop::never())?;
    let start = start(case, &local);
    let how = (Settings { path: SolverPath::Multigrid, ..settings() }, start, false);
    // It takes a sixty-fourth of the case: who asks to stop is heard after it.
    let mut observer = |_: &_| ControlFlow::Continue(());
    let Marched { found, .. } = march(case, (&mut local, &mut multigrid, own), how, (None, None), &mut observer)?;
    Ok(found.solution.certificate.passed.then_some((local, found.everywhere.u)))
}

/// The displacements of some nodes of a mesh, by their numbers, which ascend; `u` are those of the nodes here.
fn fetched(local: &Local, u: &[V3], wanted: &[u64], ranks: &dyn Ranks) -> Vec<V3> {
    let [count, _] = local.sizes;
    let first = |rank: usize| (u128::from(count) * rank as u128 / ranks.size() as u128) as u64;
    let homes = Homes::new(ranks, (first(ranks.rank() + 1) - first(ranks.rank())) as usize);
    let mut told: Vec<(Vec<u64>, Vec<V3>)> = vec![Default::default(); ranks.size()];
    let of_here = local.piece.nodes.iter().zip(u).enumerate();
    for (_, (&number, &u)) in of_here.filter(|(v, _)| local.division.is_own(*v as u32)) {
        let (numbers, values) = &mut told[homes.of(number)];
        numbers.push(number);
        values.push(u);
    }
    let message = |(numbers, values): &(Vec<u64>, Vec<V3>)| {
        let mut message = Vec::new();
        put(numbers, &mut message);
        put(values, &mut message);
        message
    };
    let mut kept = vec![[0.0; 3]; (first(ranks.rank() + 1) - first(ranks.rank())) as usize];
    for message in all_to_all(ranks, told.iter().map(message).collect()) {
        let mut from = &message[..];
        let (numbers, values): (Vec<u64>, Vec<V3>) = (take(&mut from), take(&mut from));
        numbers.iter().zip(values).for_each(|(&number, u)| kept[homes.place(number)] = u);
    }
    Plan::new(ranks, &homes, wanted).fetch(ranks, &kept)
}
