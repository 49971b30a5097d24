//! The fields of both surfaces of each pair: the slave's own, and those of the master by what it receives.

use super::fields::{Side, SurfaceFields, empty, surfaces_with};
use crate::contact::{Counterpart, Master, tributary_areas};
use crate::mesh::v3::{scale, sub};
use crate::run::pose::Prepared;
use crate::run::pose::frames::{PointFrame, entries, frames};
use crate::run::solve::Outcome;
use crate::run::solve::tractions::{Tractions, tractions};

/// The fields of each contact surface, a pair's master after its slave. Obstacles have none.
///
/// `lambda` of a master is the force its nodes receive, `-B' lambda` of the pair, given like that of the slave: as the
/// force of the surface in `on` on the other, so that both sides have one resultant. Nodes that no contact point reaches
/// have no pressure, NaN; gap, slip and state are known of the slave only.
pub fn pair_fields(prepared: &Prepared, outcome: &Outcome) -> Vec<SurfaceFields> {
    let frames = frames(prepared);
    let tractions = tractions(prepared, outcome, &frames);
    let mut all = Vec::new();
    for slave in surfaces_with(prepared, outcome, &frames, &tractions) {
        let number = slave.pair;
        all.push(slave);
        if let Counterpart::Surface(other) = &prepared.surfaces[number].against {
            all.push(master(prepared, outcome, &frames, &tractions, number, other));
        }
    }
    all
}

fn master(
    prepared: &Prepared,
    outcome: &Outcome,
    frames: &[PointFrame],
    tractions: &Tractions,
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
    for j in points {
        let frame = frames[j];
        for row in prepared.problem.rows(j) {
            let lambda = outcome.solution.lambda[row];
            for (at, entry) in on_master(prepared, &fields.nodes, frame, row) {
                fields.lambda[at] = sub(fields.lambda[at], scale(lambda, entry));
            }
        }
    }
    let areas = tributary_areas(&prepared.mesh, &other.faces);
    fields.area = areas.iter().map(|of_node| of_node.area * of_node.unity_sum()).collect();
    for (at, traction) in tractions.masters[number].iter().enumerate() {
        if let Some([pressure, shear @ ..]) = *traction {
            fields.pressure[at] = pressure;
            fields.shear[at] = shear.map(|shear| 0.0 + sign * shear);
        }
    }
    fields.lambda.iter_mut().flatten().for_each(|force| *force = 0.0 + sign * *force);
    fields
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
