//! What is to be remarked of an answer, by the functions of one machine: whether surfaces pass through each other, how far the linear
//! theory is left, how far surfaces slide. Rank 0 has the outside of the whole; the rest are sums and maxima.

use serde::{Deserialize, Serialize};

use super::facts::own_cells;
use super::local::Local;
use super::loose::{adrift_of, faceted};
use super::outside::moved;
use super::steps::slid;
use super::tighten::Found;
use crate::Error;
use crate::contact::Moved;
use crate::contact::rigid::RigidMotions;
use crate::fem::Solid;
use crate::friction::{PointState, Status};
use crate::io::case::Case;
use crate::ranks::{Wire, agree, broadcast, from_bytes, gather, gather_all, max, put, sum, take, to_bytes};
use crate::run::solve::passing::{Searches, found, needed_searches};
use crate::run::solve::quantities::{
    AdriftRecord, Couple, Displaced, Extreme, FacetedRecord, Forces, Micromotion, Smallness, extremes, may_lie_apart,
    of_extremes, percentiles, unheld_among,
};
use crate::run::solve::{OverlapRecord, PairRecord, Totals, Whereabouts};

/// The same on every rank.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Remarks {
    pub overlaps: Vec<OverlapRecord>,
    pub smallness: Option<Smallness>,
    /// Bodies that nothing holds.
    pub unheld: Vec<String>,
    /// Motions that nothing resists.
    pub adrift: Option<AdriftRecord>,
    /// A motion that hardly more than the facets of curved surfaces resists.
    pub held_by_facets: Option<FacetedRecord>,
    /// Of each surface.
    pub micromotions: Vec<Option<Micromotion>>,
    /// How far the surfaces of contacts have to be looked for.
    pub needed: Searches,
}

impl Remarks {
    /// The records of the pairs with these totals.
    pub(super) fn pairs(&self, totals: Vec<(String, Totals)>) -> Vec<PairRecord> {
        let micromotions = self.micromotions.iter().copied().chain(std::iter::repeat(None));
        let pair = |((name, totals), micromotion)| PairRecord { name, totals, micromotion };
        totals.into_iter().zip(micromotions).map(pair).collect()
    }
}

/// Looks at an answer at time `t` that has led here from `before`, which becomes where everything is now; both are known at rank 0. Where contact is
/// named and surfaces pass through each other all the same, the answer is none.
///
/// # Errors
/// If the motion of an obstacle is not finite at `t`, at every rank.
pub(super) fn look(
    case: &Case,
    (local, motions): (&Local, &RigidMotions),
    before: &mut Option<Moved>,
    answer: &mut Found,
    t: f64,
) -> Result<Remarks, Error> {
    let ranks = &*local.division.ranks;
    let now = agree(ranks, moved(local, &answer.everywhere.u, t))?;
    let slides = slides(local, answer);
    let extremes = all_extremes(local, answer);
    let slips = slips(local, answer, &slides);
    let mut volume = [own_cells(local)
        .iter()
        .enumerate()
        .filter(|(_, own)| **own)
        .map(|(cell, _)| local.piece.mesh.cell_volume(cell))
        .sum::<f64>()];
    sum(ranks, &mut volume);
    let micromotions = micromotions(local, &slides);
    let of_points = (&answer.solution, &answer.everywhere.lambda[..]);
    let unheld = unheld_among(&local.problem, motions, of_points, &|values| max(ranks, values));
    let mut remarks = Remarks { micromotions: micromotions.unwrap_or_default(), unheld, ..Remarks::default() };
    if let (Some(now), Some(outside)) = (now, &local.outside) {
        if answer.solution.status == Status::Solved {
            let from = before.take().unwrap_or_else(|| outside.at_rest());
            let (assembly, tolerance) = (outside.assembly(), answer.solution.certificate.tolerance);
            let overlaps = found(&assembly, [&from, &now], tolerance, &|surface| outside.is_out(case, surface, t));
            let bodies = local.problem.labels.bodies.as_ref();
            let at = Whereabouts { groups: &outside.mesh.groups, bodies, contacts: &outside.contacts };
            remarks.needed = needed_searches(&overlaps, &outside.contacts, &outside.contact_of);
            if overlaps.iter().any(|overlap| overlap.kind.is_refused()) {
                answer.solution.status = Status::PassesThrough;
            }
            remarks.overlaps = overlaps.iter().map(|overlap| OverlapRecord::of(at, overlap)).collect();
        }
        *before = Some(now);
        if answer.solution.status != Status::NoEquilibrium {
            remarks.smallness = Some(of_extremes(extremes, volume[0], (&outside.mesh, &outside.surfaces), &slips));
        }
    }
    let passes = broadcast(ranks, vec![u8::from(answer.solution.status == Status::PassesThrough)]) == [1];
    if passes {
        answer.solution.status = Status::PassesThrough;
        remarks.unheld.clear();
    }
    let message = broadcast(ranks, serde_json::to_vec(&remarks).unwrap_or_default());
    // Numbers that are not finite, of an iteration that diverges, cannot be told; rank 0 reads it as well, so that all have the same.
    let remarks: Remarks = serde_json::from_slice(&message).unwrap_or_default();
    let adrift = adrift_of(local, motions, answer, &remarks.unheld);
    Ok(Remarks { adrift, held_by_facets: faceted(local, motions, answer), ..remarks })
}

/// How far each point of a surface here has slid since the start, length.
fn slides(local: &Local, answer: &Found) -> Vec<f64> {
    let (m, slid) = (local.problem.points(), slid(local, &answer.everywhere.free));
    let of = |j: usize| slid[j].hypot(slid[m + j]) / local.problem.labels.unity_sum[j];
    (0..local.timed.contact_points()).map(of).collect()
}

/// Of the points of a surface those that this rank owns.
fn own_points(local: &Local, surface: usize) -> impl Iterator<Item = usize> + '_ {
    let points = local.problem.labels.pairs.get(surface).map_or(0..0, |pair| pair.points.clone());
    points.filter(|&j| local.division.is_own(local.division.points[j]))
}

/// The farthest slides of touching points of each surface, on every rank.
fn slips(local: &Local, answer: &Found, slides: &[f64]) -> Vec<f64> {
    let of_surface = |k: usize| {
        let touching = own_points(local, k).filter(|&j| answer.everywhere.states[j] != PointState::Open);
        touching.map(|j| slides[j]).fold(0.0, f64::max)
    };
    let mut slips: Vec<f64> = (0..local.signs.len()).map(of_surface).collect();
    max(&*local.division.ranks, &mut slips);
    slips
}

/// The largest rotation and strain of all ranks, on every one.
fn all_extremes(local: &Local, answer: &Found) -> [Extreme; 2] {
    let own = own_cells(local);
    let cuts = local.bolts.iter().zip(&answer.shortening);
    let displaced = Displaced {
        solid: Solid {
            mesh: &local.piece.mesh,
            materials: &local.materials,
            material_of_cell: &local.material_of_cell,
        },
        u: &answer.everywhere.u,
        cuts: cuts.map(|(bolt, &shortening)| (&bolt.bolt.cut, shortening)).collect(),
        counts: &|cell| own[cell],
    };
    let here = extremes(&displaced).map(|of| [of.value, of.at[0], of.at[1], of.at[2], of.volume]);
    let all = gather_all(&*local.division.ranks, to_bytes(&here));
    all.iter().fold([Extreme::default(); 2], |most, message| {
        let of = from_bytes::<[f64; 5]>(message);
        [0, 1].map(|k| {
            let [value, x, y, z, volume] = of[k];
            most[k].and(Extreme { value, at: [x, y, z], volume })
        })
    })
}

/// How far the surfaces slide, at rank 0.
fn micromotions(local: &Local, slides: &[f64]) -> Option<Vec<Option<Micromotion>>> {
    let labels = &local.problem.labels;
    let mut message = Vec::new();
    for surface in 0..local.signs.len() {
        let of = |j: usize| [slides[j], labels.area[j] * labels.unity_sum[j]];
        put(&own_points(local, surface).map(of).collect::<Vec<[f64; 2]>>(), &mut message);
    }
    let messages = gather(&*local.division.ranks, message)?;
    let mut all: Vec<Vec<(f64, f64)>> = vec![Vec::new(); local.signs.len()];
    for message in &messages {
        let mut from = &message[..];
        all.iter_mut()
            .for_each(|of| of.extend(take::<[f64; 2]>(&mut from).into_iter().map(|[slid, area]| (slid, area))));
    }
    Some(all.into_iter().map(percentiles).collect())
}

/// The couples that are left of contact across a distance, on every rank.
pub(super) fn couples(local: &Local, answer: &Found) -> Vec<Couple> {
    let (ranks, division) = (&*local.division.ranks, &local.division);
    let apart = local.outside.as_ref().map_or(Vec::new(), |outside| {
        outside.surfaces.iter().map(|surface| u8::from(may_lie_apart(surface))).collect()
    });
    let apart: Vec<bool> = broadcast(ranks, apart).iter().map(|apart| *apart == 1).collect();
    let forces = Forces {
        problem: &local.problem,
        u: &answer.everywhere.free,
        lambda: &answer.everywhere.lambda,
        place: &|j| local.piece.mesh.nodes[local.node_of(j) as usize],
        counts: [&|j| division.is_own(division.points[j]), &|p| division.is_own(division.supports[p])],
        sum: &|values| sum(ranks, values),
        max: &|values| max(ranks, values),
    };
    forces.couples(&apart)
}

/// The largest displacement, and where the node is; on every rank.
pub(super) fn largest_displacement(local: &Local, answer: &Found) -> (f64, [f64; 3]) {
    let (mesh, division) = (&local.piece.mesh, &local.division);
    let own = (0..mesh.nodes.len()).filter(|&v| division.is_own(v as u32));
    let sizes = own.map(|v| (crate::mesh::v3::norm(answer.everywhere.u[v]), mesh.nodes[v]));
    let (size, [x, y, z]) = sizes.fold((0.0, [0.0; 3]), |best, next| if next.0 > best.0 { next } else { best });
    let all = gather_all(&*division.ranks, to_bytes(&[[size, x, y, z]]));
    let all = all.iter().map(|message| <[f64; 4]>::read(message));
    let [size, at @ ..] = all.fold([0.0; 4], |best, next| if next[0] > best[0] { next } else { best });
    (size, at)
}
