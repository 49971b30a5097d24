//! Coefficients of friction from arrays of the mesh, and those that change with time.

use std::ops::Range;

use super::arrays::{Found, find};
use super::place;
use crate::Error;
use crate::contact::{Coefficient, ContactSurface, CoulombLaw, Friction, SurfaceFriction};
use crate::fem::Field;
use crate::io::case::{ContactSpec, Spot};
use crate::mesh::Mesh;

/// What the values are called in messages.
const FRICTION: &str = "a coefficient of friction";
const COHESION: &str = "a cohesion";
const TENSION: &str = "a tensile strength";

/// Finds the values at the nodes of the surfaces, which carry the contact points by now, of arrays and at time `t`.
///
/// # Errors
/// An array that the mesh does not have, or a value on the surface that is no coefficient; shown where the case names it.
pub(crate) fn read(mesh: &Mesh, specs: &[ContactSpec], surfaces: &mut [ContactSurface], t: f64) -> Result<(), Error> {
    for (surface, spec) in surfaces.iter_mut().zip(specs) {
        let SurfaceFriction::Law(law) = &mut surface.friction else { continue };
        let across = law.across.as_mut().map(|across| (&mut across.coefficient, FRICTION));
        let strengths = law.cohesion.iter_mut().flat_map(|it| [(&mut it.shear, COHESION), (&mut it.tension, TENSION)]);
        for (coefficient, name) in std::iter::once((&mut law.coefficient, FRICTION)).chain(across).chain(strengths) {
            match coefficient {
                Coefficient::Field(_) => {}
                Coefficient::Array { name: array, values } => {
                    *values = at_nodes(mesh, &surface.faces, array, name, &spec.friction_spot)?;
                }
                Coefficient::OfTime { field, values } => {
                    *values = vec![f64::NAN; mesh.nodes.len()];
                    for node in mesh.face_nodes(&surface.faces) {
                        let value = at_time(field, mesh.nodes[node as usize], t);
                        values[node as usize] = value.map_err(|error| place::instead(&spec.friction_spot, error))?;
                    }
                }
            }
        }
    }
    Ok(())
}

/// The coefficient of a law that changes with time.
pub(crate) fn of_time(friction: &SurfaceFriction) -> Option<&Field> {
    match friction {
        SurfaceFriction::Law(CoulombLaw { coefficient: Coefficient::OfTime { field, .. }, .. }) => Some(field),
        _ => None,
    }
}

/// The laws of all points at time `t`, which are otherwise as `posed`; nothing where no coefficient changes with time. Each of the
/// surfaces has its points and its place in the case, `node` is that of a point.
///
/// # Errors
/// A coefficient that is negative or not finite then, shown where the case asks for it.
pub(crate) fn at<'a>(
    mesh: &Mesh,
    posed: &[Friction],
    surfaces: impl Iterator<Item = (&'a SurfaceFriction, Range<usize>, &'a Spot)>,
    node: &dyn Fn(usize) -> u32,
    t: f64,
) -> Result<Option<Vec<Friction>>, Error> {
    let mut laws: Option<Vec<Friction>> = None;
    for (friction, points, spot) in surfaces {
        let Some(field) = of_time(friction) else { continue };
        let laws = laws.get_or_insert_with(|| posed.to_vec());
        for j in points {
            let value = at_time(field, mesh.nodes[node(j) as usize], t);
            let value = value.map_err(|error| place::instead(spot, error))?;
            laws[j].set_coefficient(value);
        }
    }
    Ok(laws)
}

fn at_time(field: &Field, x: [f64; 3], t: f64) -> Result<f64, Error> {
    let value = field.finite_at(x, t)?;
    if value >= 0.0 {
        return Ok(value);
    }
    let what = format!("the coefficient of friction {field:?} is {value} at {x:?} at time t = {t}");
    Err(Error::new("", what, "give an expression that is at least zero, such as \"max(0, ...)\""))
}

/// One value for each node of the mesh, NaN away from the faces. A point array is read at the nodes; of a cell array a
/// node gets the mean over the faces around it that belong to the surface, weighted by their areas.
fn at_nodes(mesh: &Mesh, faces: &[u32], name: &str, quantity: &str, spot: &Spot) -> Result<Vec<f64>, Error> {
    let checked = |value: f64, place: String| {
        if value.is_finite() && value >= 0.0 {
            return Ok(value);
        }
        let found = if value.is_nan() { "has no value".to_string() } else { format!("is {value}") };
        let what = format!("the array \"{name}\" {found} {place} of the contact surface");
        Err(spot.error(what, format!("{quantity} is a number of at least zero wherever the surface is")))
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
