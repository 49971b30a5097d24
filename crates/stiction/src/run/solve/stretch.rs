//! Bolts whose force is given, for a solver that finds their shortenings itself: what a unit of shortening does, and how
//! a bolt takes it up along its free length.

use crate::fem::full_displacement;
use crate::friction::SoughtForce;
use crate::mesh::Mesh;
use crate::mesh::v3::{dot, mean, sub};
use crate::run::pose::Prepared;
use crate::run::pose::bolts::Bolt;
use crate::run::pose::cut_sides::sides;

/// The forces (`wanted`: number of the bolt, newton) beyond what the shortenings that act now give.
pub(crate) fn sought_forces(prepared: &Prepared, wanted: &[(usize, f64)]) -> Vec<SoughtForce> {
    if wanted.is_empty() {
        return Vec::new();
    }
    let (dofs, initial) = (&prepared.model.dofs, &prepared.loading.initial);
    let held = full_displacement(&prepared.model, &vec![0.0; prepared.problem.unknowns()]);
    let ends = ends(prepared);
    let unknowns = |entries: &[(u32, f64)]| -> Vec<(u32, f64)> {
        let numbered = dofs.entries(entries).into_iter().map(|(dof, x)| (dofs.unknown[dof as usize], x));
        numbered.filter(|(number, _)| *number != u32::MAX).collect()
    };
    let of = |&(number, force): &(usize, f64)| {
        let bolt = &prepared.loading.bolts[number];
        let from_held: f64 = bolt.cut.force.iter().map(|&(dof, unit)| unit * held[dof as usize]).sum();
        let stiffness = bolt.cut.stiffness;
        SoughtForce {
            force: unknowns(&bolt.cut.force),
            stiffness,
            target: force - initial.thermal_force[number] + from_held - stiffness * initial.shortening[number],
            stretch: unknowns(&along_axis(bolt, &stretch(&prepared.mesh, bolt, &ends))),
        }
    };
    wanted.iter().map(of).collect()
}

/// Nodes that a bolt cannot be stretched beyond: contact acts on them, or they are held.
fn ends(prepared: &Prepared) -> Vec<bool> {
    let dofs = &prepared.model.dofs;
    let mut ends = vec![false; prepared.mesh.nodes.len()];
    let touched = prepared.problem.contact.B.column.iter().map(|&column| dofs.free[column as usize]);
    touched.chain(dofs.prescribed.iter().copied()).for_each(|dof| ends[dofs.mesh_node(dof / 3) as usize] = true);
    ends
}

/// Ways along the axis of a bolt as displacements by degree of freedom.
pub(crate) fn along_axis(bolt: &Bolt, ways: &[(u32, f64)]) -> Vec<(u32, f64)> {
    let axis = bolt.cut.axis;
    ways.iter().flat_map(|&(node, way)| (0..3).map(move |c| (3 * node + c as u32, way * axis[c]))).collect()
}

/// Ways of nodes along the axis that take a unit of shortening up by a uniform strain between the next of `ends` on either side of
/// the cut.
pub(crate) fn stretch(mesh: &Mesh, bolt: &Bolt, ends: &[bool]) -> Vec<(u32, f64)> {
    let cut = &bolt.cut;
    let middle = mean(cut.nodes.iter().map(|&node| mesh.nodes[node as usize]));
    let [before, beyond] = sides(mesh, bolt);
    let away = |node: usize, sign: f64| sign * dot(cut.axis, sub(mesh.nodes[node], middle));
    let free_length = |side: &[bool], sign: f64| {
        let of_side = || (0..side.len()).filter(|&node| side[node]).map(|node| (ends[node], away(node, sign).max(0.0)));
        let nearest = of_side().filter(|(end, _)| *end).map(|(_, away)| away).fold(f64::INFINITY, f64::min);
        if nearest.is_finite() { nearest } else { of_side().map(|(_, away)| away).fold(0.0, f64::max) }
    };
    let lengths = [free_length(&before, -1.0), free_length(&beyond, 1.0)];
    let whole = lengths[0] + lengths[1];
    let at = |node: usize| {
        let later = away(node, 1.0) > 0.0;
        let (length, sign) = match (before[node], beyond[node]) {
            (true, true) if later => (lengths[1], 1.0),
            (true, _) => (lengths[0], -1.0),
            (false, true) => (lengths[1], 1.0),
            (false, false) => return 0.0,
        };
        -sign * (length - away(node, sign).max(0.0)).max(0.0) / whole
    };
    if whole == 0.0 {
        return Vec::new();
    }
    (0..mesh.nodes.len()).map(|node| (node as u32, at(node))).filter(|(_, way)| *way != 0.0).collect()
}
