//! The fields of both surfaces of each pair: the slave's own, and those of the master by what it receives.

use super::fields::{Side, SurfaceFields, empty, surfaces};
use crate::contact::{Counterpart, Master, TributaryArea, tributary_areas};
use crate::mesh::v3::{dot, scale, sub};
use crate::run::pose::Prepared;
use crate::run::pose::frames::{PointFrame, entries, frames};
use crate::run::solve::Outcome;

/// The fields of each contact surface, a pair's master after its slave. Obstacles have none.
///
/// `lambda` of a master is the force its nodes receive, `-B' lambda` of the pair, given like that of the slave: as the
/// force of the surface in `on` on the other, so that both sides have one resultant. Pressure and shear are the mean of
/// those of the contact points, each with the area it shares with the node: between the least and the greatest of them,
/// right for a constant pressure, and not diluted where the slave covers the faces around a node in part only, as force
/// over area would be. Nodes that no contact point reaches have NaN; gap, slip and state are known of the slave only.
pub(crate) fn pair_fields(prepared: &Prepared, outcome: &Outcome) -> Vec<SurfaceFields> {
    let frames = frames(prepared);
    let mut all = Vec::new();
    for slave in surfaces(prepared, outcome) {
        let number = slave.pair;
        all.push(slave);
        if let Counterpart::Surface(other) = &prepared.surfaces[number].against {
            all.push(master(prepared, outcome, &frames, number, other));
        }
    }
    all
}

fn master(
    prepared: &Prepared,
    outcome: &Outcome,
    frames: &[PointFrame],
    number: usize,
    other: &Master,
) -> SurfaceFields {
    let points = prepared.problem.labels.pairs[number].points.clone();
    let sign = frames.get(points.start).map_or(1.0, |frame| frame.sign);
    let mut fields = SurfaceFields {
        pair: number,
        side: Side::Master,
        ..empty(prepared, &prepared.surfaces[number].name, &other.faces)
    };
    let areas = tributary_areas(&prepared.mesh, &other.faces);
    // Per node: the shared area, and the pressure and shear times it.
    let mut sums = vec![(0.0, 0.0, [0.0; 3]); fields.nodes.len()];
    for j in points {
        let (frame, area) = (frames[j], prepared.problem.labels.area[j]);
        for row in prepared.problem.rows(j) {
            let lambda = outcome.solution.lambda[row];
            for (at, entry) in on_master(prepared, &fields.nodes, frame, row) {
                fields.lambda[at] = sub(fields.lambda[at], scale(lambda, entry));
            }
        }
        let [n, t1, t2] = prepared.problem.rows(j).map(|row| outcome.solution.lambda[row]);
        let shear = frame.tangential([t1, t2]);
        for (at, weight) in shared(prepared, &fields.nodes, &areas, frame, j) {
            let (whole, pressure, along) = &mut sums[at];
            // Area times force over area.
            (*whole, *pressure) = (*whole + weight * area, *pressure + weight * n);
            along.iter_mut().zip(shear).for_each(|(sum, shear)| *sum += weight * shear);
        }
    }
    for (at, (whole, pressure, along)) in sums.into_iter().enumerate().filter(|(_, sums)| sums.0 > 0.0) {
        // No force is no pressure, without a sign.
        fields.pressure[at] = 0.0 + pressure / whole;
        fields.shear[at] = along.map(|shear| 0.0 + sign * shear / whole);
    }
    fields.lambda.iter_mut().flatten().for_each(|force| *force = 0.0 + sign * *force);
    fields
}

/// The part of the area of point `j` that it shares with each node of the master, `int psi_j phi / D_jj`, where it is
/// positive. As `psi_j` changes its sign, so may these integrals at nodes beyond the neighbours of the point: they are no
/// areas. On quadratic faces `phi` are the functions with positive integrals.
fn shared(
    prepared: &Prepared,
    nodes: &[i32],
    areas: &[TributaryArea],
    frame: PointFrame,
    j: usize,
) -> impl Iterator<Item = (usize, f64)> {
    // Any row gives the weights: they stand before the same axis at the point's own node, with the other sign.
    let axes = [frame.normal, frame.tangents[0], frame.tangents[1]];
    let rows = prepared.problem.rows(j);
    let square = |axis: &[f64; 3]| axis.iter().map(|a| a * a).sum::<f64>();
    let mut weights: Vec<(usize, f64)> = Vec::new();
    if let Some((row, axis)) = rows.into_iter().zip(axes).find(|(_, axis)| square(axis) > 0.0) {
        let weight = |entry: [f64; 3]| -dot(entry, axis) / square(&axis);
        weights.extend(on_master(prepared, nodes, frame, row).map(|(at, entry)| (at, weight(entry))));
    }
    let of_middles = |&(at, weight): &(usize, f64)| {
        let of_end =
            move |&(end, part): &(u32, f64)| (nodes.partition_point(|&node| node < end as i32), -part * weight);
        areas[at].others.iter().map(of_end).collect::<Vec<_>>()
    };
    let more: Vec<(usize, f64)> = weights.iter().flat_map(of_middles).collect();
    weights.extend(more);
    weights.sort_by_key(|entry| entry.0);
    let sums = weights.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, same.iter().map(|s| s.1).sum::<f64>()));
    sums.filter(|(_, weight)| *weight > 0.0).collect::<Vec<_>>().into_iter()
}

/// The entries of a row of `B` at the nodes of the master: place in `nodes`, and the part of the entry as a vector.
fn on_master(
    prepared: &Prepared,
    nodes: &[i32],
    frame: PointFrame,
    row: usize,
) -> impl Iterator<Item = (usize, [f64; 3])> {
    let others = entries(prepared, row).filter(move |(dof, _)| dof / 3 != frame.node);
    others.filter_map(|(dof, value)| {
        let at = nodes.binary_search(&((dof / 3) as i32)).ok()?;
        Some((at, scale(value, prepared.model.dofs.direction(dof))))
    })
}
