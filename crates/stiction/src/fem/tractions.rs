//! Loads whose traction is linear on each face, and forces that are constant in each cell.

use super::loads::resultant_traction;
use super::{FacePoint, Field, Load, Solid, face_coordinates, face_points};
use crate::Error;
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, cross, dot, norm, scale, sub};

/// Tractions that differ from linear ones by less than this part of the largest are linear.
const LINEAR: f64 = 1e-9;

/// Places on a triangle where a traction is compared with that between its values at the corners: where no polynomial that is
/// in use vanishes by symmetry.
const PLACES: [[f64; 3]; 6] =
    [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.6, 0.3, 0.1], [0.1, 0.2, 0.7], [0.25, 0.65, 0.1]];

/// Boundary faces, by number, with the traction at their three corners in their order, force per area.
pub type LinearTractions = Vec<(u32, [[f64; 3]; 3])>;

/// A load as tractions that are linear on each face, given at its three corners in their order, force per area. `None` for
/// loads on cells, on faces with four corners, and where the traction is not linear.
///
/// # Errors
/// As [`external_forces`](super::external_forces).
pub fn linear_tractions(mesh: &Mesh, load: &Load, t: f64) -> Result<Option<LinearTractions>, Error> {
    let vector = |value: &[Field; 3], x: V3| -> Result<V3, Error> {
        Ok([value[0].finite_at(x, t)?, value[1].finite_at(x, t)?, value[2].finite_at(x, t)?])
    };
    match load {
        Load::Traction { faces, value } => sampled(mesh, faces, |x, _| vector(value, x)),
        Load::Pressure { faces, value } => sampled(mesh, faces, |x, normal| Ok(scale(-value.finite_at(x, t)?, normal))),
        Load::Force { faces, total } => {
            let points = faces.iter().flat_map(|&face| face_points(&face_coordinates(mesh, face)));
            let area: f64 = points.map(|point: FacePoint| norm(point.area)).sum();
            let total = vector(total, [f64::NAN; 3])?;
            sampled(mesh, faces, |_, _| Ok(scale(1.0 / area, total)))
        }
        Load::Resultant { faces, force, moment, about } => {
            let [even, turn, centroid] = resultant_traction(mesh, faces, [force, moment], *about, t)?;
            sampled(mesh, faces, |x, _| Ok(add(even, cross(turn, sub(x, centroid)))))
        }
        Load::Hydrostatic { faces, weight, level, up } => {
            let level = level.finite_at([f64::NAN; 3], t)?;
            sampled(mesh, faces, |x, normal| Ok(scale(-weight * (level - dot(*up, x)).max(0.0), normal)))
        }
        Load::Nodal { .. } | Load::Gravity { .. } | Load::Rotation { .. } | Load::Temperature { .. } => Ok(None),
    }
}

fn sampled(
    mesh: &Mesh,
    faces: &[u32],
    traction: impl Fn(V3, V3) -> Result<V3, Error>,
) -> Result<Option<LinearTractions>, Error> {
    let mut list = Vec::with_capacity(faces.len());
    for &face in faces {
        let &[a, b, c] = mesh.faces[face as usize].corners() else { return Ok(None) };
        let normal = mesh.face_normal(face as usize);
        let x = [a, b, c].map(|node| mesh.nodes[node as usize]);
        let at = [traction(x[0], normal)?, traction(x[1], normal)?, traction(x[2], normal)?];
        let between = |of: &[V3; 3], w: [f64; 3]| (0..3).fold([0.0; 3], |sum, i| add(sum, scale(w[i], of[i])));
        let largest = at.iter().map(|&t| norm(t)).fold(0.0, f64::max);
        for w in PLACES {
            let found = traction(between(&x, w), normal)?;
            if norm(sub(found, between(&at, w))) > LINEAR * largest.max(norm(found)) {
                return Ok(None);
            }
        }
        list.push((face, at));
    }
    Ok(Some(list))
}

/// A load as a force per volume of each cell that is constant in it; `None` for loads on faces and for forces that vary.
pub fn constant_body_force(solid: &Solid, load: &Load) -> Option<Vec<V3>> {
    let Load::Gravity { cells, acceleration } = load else { return None };
    let value = |field: &Field| if let Field::Constant(value) = field { Some(*value) } else { None };
    let acceleration = [value(&acceleration[0])?, value(&acceleration[1])?, value(&acceleration[2])?];
    let mut force = vec![[0.0; 3]; solid.mesh.cell_count()];
    for &cell in cells {
        let density = solid.materials[solid.material_of_cell[cell as usize] as usize].density;
        force[cell as usize] = add(force[cell as usize], scale(density, acceleration));
    }
    Some(force)
}
