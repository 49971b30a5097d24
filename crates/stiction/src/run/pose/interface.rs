//! The stress an interface carries before anything is loaded.

use super::frames::frames;
use super::{Prepared, place};
use crate::Error;
use crate::fem::Field;
use crate::io::case::Spot;
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
    let (m, frames) = (problem.points(), frames(prepared));
    let mut forces = vec![0.0; 3 * m];
    for (stress, pair) in loading.initial_stresses.iter().zip(&problem.labels.pairs) {
        let Some((fields, spot)) = stress else { continue };
        for j in pair.points.clone() {
            let frame = &frames[j];
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
    Ok(Some(forces))
}
