//! Both surfaces of each pair: the slave's fields, and what the master receives from it.

use super::fields::{PointFrame, Side, SurfaceFields, empty, frames, surfaces};
use super::{Outcome, Prepared};
use crate::contact::{Counterpart, Master};
use crate::fem::{nodal_areas, nodal_normals};
use crate::mesh::v3::{scale, sub};

/// The fields of each contact surface, a pair's master after its slave. Obstacles have none.
///
/// `lambda` of a master is the force its nodes receive, `-B' lambda` of the pair, told like that of the slave: as the
/// force of the surface in `on` on the other, so that both sides have one resultant. Pressure and shear are this force,
/// across and along the nodal normal, over the area the node stands for by its shape function. These are consistent
/// nodal forces over nodal areas: they have the right resultant and are exact for a constant pressure, but noisier than
/// the slave's, and too low at nodes whose faces the slave covers in part. Nodes that no contact point reaches have
/// NaN; gap, slip and state are known of the slave only.
pub(super) fn sides(prepared: &Prepared, outcome: &Outcome) -> Vec<SurfaceFields> {
    let frames = frames(prepared);
    let mut sides = Vec::new();
    for slave in surfaces(prepared, outcome) {
        let number = slave.pair;
        sides.push(slave);
        if let Counterpart::Surface(other) = &prepared.surfaces[number].against {
            sides.push(master(prepared, outcome, &frames, number, other));
        }
    }
    sides
}

fn master(
    prepared: &Prepared,
    outcome: &Outcome,
    frames: &[PointFrame],
    number: usize,
    other: &Master,
) -> SurfaceFields {
    let points = prepared.problem.pairs[number].points.clone();
    let sign = frames.get(points.start).map_or(1.0, |frame| frame.sign);
    let mut fields = SurfaceFields {
        pair: number,
        side: Side::Master,
        ..empty(prepared, &prepared.surfaces[number].name, &other.faces)
    };
    let mut reached = vec![false; fields.nodes.len()];
    for j in points {
        for row in prepared.problem.rows(j) {
            let lambda = outcome.solution.lambda[row];
            for (dof, value) in entries(prepared, row).filter(|(dof, _)| dof / 3 != frames[j].node) {
                if let Ok(at) = fields.nodes.binary_search(&((dof / 3) as i32)) {
                    let direction = prepared.model.dofs.direction(dof);
                    fields.lambda[at] = sub(fields.lambda[at], scale(value * lambda, direction));
                    reached[at] = true;
                }
            }
        }
    }
    let areas = nodal_areas(&prepared.mesh, &other.faces);
    let normals = nodal_normals(&prepared.mesh, &other.faces);
    for at in (0..reached.len()).filter(|&at| reached[at] && areas[at].1 > 0.0) {
        let (force, area, normal) = (fields.lambda[at], areas[at].1, normals[at].1);
        let across: f64 = (0..3).map(|c| force[c] * normal[c]).sum();
        // Not the negative: no force is no pressure, without a sign.
        fields.pressure[at] = 0.0 - across / area;
        fields.shear[at] = [0, 1, 2].map(|c| sign * (force[c] - across * normal[c]) / area);
    }
    fields.lambda.iter_mut().flatten().for_each(|force| *force = 0.0 + sign * *force);
    fields
}

/// The entries of a row of `B` by degrees of freedom of the mesh, free ones and prescribed ones.
fn entries(prepared: &Prepared, row: usize) -> impl Iterator<Item = (u32, f64)> {
    let dofs = &prepared.model.dofs;
    let (columns, values) = prepared.problem.B.row(row);
    let free = columns.iter().zip(values).map(|(&k, &value)| (dofs.free[k as usize], value));
    let (columns, values) = prepared.problem.supports.as_ref().map_or((&[][..], &[][..]), |s| s.B.row(row));
    free.chain(columns.iter().zip(values).map(|(&k, &value)| (dofs.prescribed[k as usize], value)))
}
