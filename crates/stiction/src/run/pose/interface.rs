//! The stress an interface carries before anything is loaded.

use super::frames::{PointFrame, frames};
use super::{Prepared, place};
use crate::Error;
use crate::contact::ContactProblem;
use crate::fem::Field;
use crate::io::case::Spot;
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, dot, scale};

/// An initial stress, and where the case asks for it.
pub(crate) type InitialStress = Option<([Field; 6], Spot)>;

/// The contact forces of the initial stresses, newton, `3m`; none where no contact has any.
///
/// The bodies are in equilibrium under them and under what has loaded them so far; loads and displacements count from
/// there. So they enter as loads that the contact forces balance as long as nothing changes.
///
/// # Errors
/// An expression that is not finite at a contact point, shown where the case has it.
pub(super) fn initial_forces(prepared: &Prepared) -> Result<Option<Vec<f64>>, Error> {
    let Prepared { mesh, problem, loading, .. } = prepared;
    if loading.initial_stresses.iter().all(Option::is_none) {
        return Ok(None);
    }
    let frames = frames(prepared);
    let stresses = loading.initial_stresses.iter().map(|of| of.as_ref().map(|(fields, spot)| (fields, spot)));
    forces_of(mesh, problem, &|j| frames[j], stresses).map(Some)
}

/// The same of the stresses of all surfaces, each with its place in the case.
pub(crate) fn forces_of<'c>(
    mesh: &Mesh,
    problem: &ContactProblem,
    frame: &dyn Fn(usize) -> PointFrame,
    stresses: impl Iterator<Item = Option<(&'c [Field; 6], &'c Spot)>>,
) -> Result<Vec<f64>, Error> {
    let mut forces = vec![0.0; 3 * problem.points()];
    for (stress, pair) in stresses.zip(&problem.labels.pairs) {
        let Some((fields, spot)) = stress else { continue };
        for j in pair.points.clone() {
            let frame = frame(j);
            let at = |field: &Field| field.finite_at(mesh.nodes[frame.node as usize], 0.0);
            let mut s = [0.0; 6];
            for (value, field) in s.iter_mut().zip(fields) {
                *value = at(field).map_err(|error| place::instead(spot, error))?;
            }
            let [xx, yy, zz, yz, xz, xy] = s;
            let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
            // The normal points out of the body: what acts on it there is `stress . normal`, and it exerts the opposite.
            let exerts: V3 = rows.map(|row| 0.0 - dot(row, frame.normal));
            let exerts = scale(problem.labels.area[j], exerts);
            let axes = [frame.normal, frame.tangents[0], frame.tangents[1]];
            problem.rows(j).into_iter().zip(axes).for_each(|(row, axis)| forces[row] = dot(axis, exerts));
        }
    }
    Ok(forces)
}
