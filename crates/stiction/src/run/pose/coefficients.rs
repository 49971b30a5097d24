//! Coefficients of friction from arrays of the mesh.

use super::arrays::{Found, find};
use crate::Error;
use crate::contact::{Coefficient, ContactSurface, SurfaceFriction};
use crate::io::case::{ContactSpec, Spot};
use crate::mesh::Mesh;

/// Reads the arrays at the nodes of the surfaces, which carry the contact points by now.
///
/// # Errors
/// An array that the mesh does not have, or a value on the surface that is no coefficient; shown where the case names it.
pub(crate) fn read(mesh: &Mesh, specs: &[ContactSpec], surfaces: &mut [ContactSurface]) -> Result<(), Error> {
    for (surface, spec) in surfaces.iter_mut().zip(specs) {
        let SurfaceFriction::Law(law) = &mut surface.friction else { continue };
        let across = law.across.as_mut().map(|across| &mut across.coefficient);
        for coefficient in std::iter::once(&mut law.coefficient).chain(across) {
            let Coefficient::Array { name, values } = coefficient else { continue };
            *values = at_nodes(mesh, &surface.faces, name, &spec.friction_spot)?;
        }
    }
    Ok(())
}

/// One value for each node of the mesh, NaN away from the faces. A point array is read at the nodes; of a cell array a
/// node gets the mean over the faces around it that belong to the surface, weighted by their areas.
fn at_nodes(mesh: &Mesh, faces: &[u32], name: &str, spot: &Spot) -> Result<Vec<f64>, Error> {
    let checked = |value: f64, place: String| {
        if value.is_finite() && value >= 0.0 {
            return Ok(value);
        }
        let found = if value.is_nan() { "has no value".to_string() } else { format!("is {value}") };
        let what = format!("the array \"{name}\" {found} {place} of the contact surface");
        Err(spot.error(what, "a coefficient of friction is a number of at least zero wherever the surface is"))
    };
    let mut values = vec![f64::NAN; mesh.nodes.len()];
    match find(mesh, name, spot)? {
        Found::Nodes(array) => {
            for node in mesh.face_nodes(faces) {
                let place = || format!("at node {} at {:?}", node + 1, mesh.nodes[node as usize]);
                values[node as usize] = checked(array.values[node as usize], place())?;
            }
        }
        Found::Cells(array) => {
            let mut weight = vec![0.0; mesh.nodes.len()];
            for &number in faces {
                let face = &mesh.faces[number as usize];
                let place = || format!("on the face {} of cell {}", one_based(face.nodes()), face.cell + 1);
                let value = checked(array.of_face(number, face.cell), place())?;
                let area = mesh.face_area(number as usize);
                for &node in face.nodes() {
                    let (mean, weight) = (&mut values[node as usize], &mut weight[node as usize]);
                    *weight += area;
                    // A running mean: equal values stay what they are to the last digit.
                    *mean = if mean.is_nan() { value } else { *mean + (value - *mean) * (area / *weight) };
                }
            }
        }
    }
    Ok(values)
}

/// Nodes counted from 1, as messages do.
fn one_based(nodes: &[u32]) -> String {
    let numbers: Vec<String> = nodes.iter().map(|node| (node + 1).to_string()).collect();
    format!("with the nodes {}", numbers.join(", "))
}
