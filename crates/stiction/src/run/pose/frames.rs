//! Where the contact points are, and their axes.

use super::Prepared;
use crate::contact::{Counterpart, Role};
use crate::mesh::v3::{add, scale};

/// Where a contact point is and which way its rows of `B` point.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PointFrame {
    pub node: u32,
    /// Unit normal towards the counterpart.
    pub normal: [f64; 3],
    /// Zero where the point cannot move that way.
    pub tangents: [[f64; 3]; 2],
    /// -1 where the body with the point is the one the case names in `against`: forces and slips are given as those of the
    /// surface in `on`.
    pub sign: f64,
}

impl PointFrame {
    /// The vector with these two tangential components.
    pub(crate) fn tangential(&self, [a, b]: [f64; 2]) -> [f64; 3] {
        let [t1, t2] = self.tangents;
        [0, 1, 2].map(|c| a * t1[c] + b * t2[c])
    }
}

/// The frames of all contact points, read from the rows of `B` at their own nodes.
pub(crate) fn frames(prepared: &Prepared) -> Vec<PointFrame> {
    let m = prepared.problem.points();
    let mut frames = Vec::with_capacity(m);
    for (contact, surface) in prepared.facts.contacts.iter().zip(&prepared.surfaces) {
        let sign = match &surface.against {
            Counterpart::Surface(master) if master.slave == Role::Against => -1.0,
            _ => 1.0,
        };
        frames.extend(contact.surface.nodes.iter().map(|&node| PointFrame { node, sign, ..PointFrame::default() }));
    }
    for (j, frame) in frames.iter_mut().enumerate() {
        for (i, row) in [j, m + j, 2 * m + j].into_iter().enumerate() {
            for (dof, value) in entries(prepared, row).filter(|(dof, _)| dof / 3 == frame.node) {
                let vector = if i == 0 { &mut frame.normal } else { &mut frame.tangents[i - 1] };
                *vector = add(*vector, scale(value, prepared.model.dofs.direction(dof)));
            }
        }
    }
    frames
}

/// The entries of a row of `B` by degrees of freedom of the mesh, free ones and prescribed ones.
pub(crate) fn entries(prepared: &Prepared, row: usize) -> impl Iterator<Item = (u32, f64)> {
    let dofs = &prepared.model.dofs;
    let (columns, values) = prepared.problem.contact.B.row(row);
    let free = columns.iter().zip(values).map(|(&k, &value)| (dofs.mesh_dof(dofs.free[k as usize]), value));
    let (columns, values) = prepared.problem.labels.supports.as_ref().map_or((&[][..], &[][..]), |s| s.B.row(row));
    free.chain(columns.iter().zip(values).map(|(&k, &value)| (dofs.prescribed[k as usize], value)))
}
