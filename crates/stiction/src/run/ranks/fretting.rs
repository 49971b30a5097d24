//! What contact does to the surfaces over load steps, on several ranks: each keeps what its own points have been through.

use super::bolts::strain;
use super::local::Local;
use super::solve::{Everywhere, axes};
use super::steps::slid;
use super::tighten::Found;
use super::tractions::{RankTractions, shear};
use crate::accuracy::{Straining, nodal_stress_at};
use crate::fem::Solid;
use crate::friction::PointState;
use crate::io::case::Case;
use crate::mesh::v3::{V3, add, norm, scale};
use crate::ranks::{max, sum};
use crate::run::results::{FIGURES, Fretting, FrettingRecord, PointHistory, PointStep, tension_along};

/// Adds the step at whose end the answer is this one.
pub(super) fn add_step(
    fretting: &mut Fretting,
    local: &Local,
    answer: &Everywhere,
    shortening: &[f64],
    tractions: &RankTractions,
) {
    let (m, count) = (local.problem.points(), local.timed.contact_points());
    let is_own = |j: usize| local.division.is_own(local.division.points[j]);
    let tension = tensions(local, answer, shortening);
    let (left, slid) = (local.problem.gap_and_slip(&answer.free), slid(local, &answer.free));
    let of_point = |j: usize| {
        let (_, [_, t1, t2]) = axes(local, j);
        let (sign, share) = (local.signs[local.pair_of(j)], local.problem.labels.unity_sum[j]);
        let along = |a: f64, b: f64| -> V3 { scale(sign / share, add(scale(a, t1), scale(b, t2))) };
        let [work, pressed] = tractions.rubbing[j];
        PointStep {
            work,
            pressed,
            shear: scale(sign, shear(tractions.points[j])),
            slip: along(-left[m + j], -left[2 * m + j]),
            slid: along(slid[j], slid[m + j]),
            tension: tension[j],
            touching: answer.states[j] != PointState::Open,
        }
    };
    fretting.add((0..count).map(|j| is_own(j).then(|| of_point(j))));
}

/// The largest tension along the surface at each own contact point here, whose node has all of its cells here; NaN at others.
fn tensions(local: &Local, answer: &Everywhere, shortening: &[f64]) -> Vec<f64> {
    let is_own = |j: usize| local.division.is_own(local.division.points[j]);
    let points = 0..local.timed.contact_points();
    let mut wanted = vec![false; local.piece.mesh.nodes.len()];
    points.clone().filter(|&j| is_own(j)).for_each(|j| wanted[local.node_of(j) as usize] = true);
    let solid =
        Solid { mesh: &local.piece.mesh, materials: &local.materials, material_of_cell: &local.material_of_cell };
    let cuts: Vec<_> = local.bolts.iter().map(|bolt| &bolt.bolt.cut).zip(shortening.iter().copied()).collect();
    let straining = Straining {
        displacement: answer.u.as_flattened(),
        initial: &strain(local, shortening),
        rise: &local.initial.rise,
        cuts: &cuts,
        region: &local.material_of_cell,
    };
    let stress = nodal_stress_at(&solid, &straining, Some(&wanted)).stress;
    let at_point = |j: usize| {
        let (node, [normal, ..]) = axes(local, j);
        if is_own(j) { tension_along(&stress[node as usize], scale(1.0 / norm(normal), normal)) } else { f64::NAN }
    };
    points.map(at_point).collect()
}

/// The figures of all contact points here at the end of the last step; those of other ranks are not known.
pub(super) fn figures(fretting: &Fretting, case: &Case, local: &Local, last: &Found) -> Vec<[f64; FIGURES]> {
    let tension = tensions(local, &last.everywhere, &last.shortening);
    let wear = |j: usize| case.contacts[local.contact_of[local.pair_of(j)] as usize].wear;
    tension.iter().enumerate().map(|(j, &tension)| fretting.at(j).figures(tension, wear(j))).collect()
}

/// The histories of all points here as numbers, those of other ranks and of ties zero.
pub(super) fn numbers(fretting: &Fretting, local: &Local) -> Vec<[f64; PointHistory::NUMBERS]> {
    let of = |j: usize| match local.division.is_own(local.division.points[j]) && j < local.timed.contact_points() {
        true => fretting.at(j).numbers(),
        false => [0.0; PointHistory::NUMBERS],
    };
    (0..local.problem.points()).map(of).collect()
}

/// The record of each pair over all ranks, the same on every one.
pub(super) fn records(fretting: &Fretting, case: &Case, local: &Local) -> Vec<FrettingRecord> {
    let labels = &local.problem.labels;
    let of_pair = |(pair, &contact): (&crate::contact::Pair, &u32)| {
        let wear = case.contacts[contact as usize].wear;
        let own = pair.points.clone().filter(|&j| local.division.is_own(local.division.points[j]));
        let points = own.map(|j| (fretting.at(j).figures(f64::NAN, wear), labels.area[j] * labels.unity_sum[j]));
        let mut record = FrettingRecord::of(&pair.name, wear.is_some(), points);
        let ranks = &*local.division.ranks;
        let mut sums = [record.work, record.worn_volume.unwrap_or(0.0)];
        sum(ranks, &mut sums);
        (record.work, record.worn_volume) = (sums[0], wear.map(|_| sums[1]));
        let mut most = record.maxima();
        max(ranks, &mut most);
        record.with_maxima(most)
    };
    labels.pairs.iter().take(local.signs.len()).zip(&local.contact_of).map(of_pair).collect()
}
