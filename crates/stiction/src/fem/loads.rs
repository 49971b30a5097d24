use rayon::prelude::*;

use super::elements::{MOST_NODES, folded, volume_points};
use super::faces::{FacePoint, face_coordinates, face_points};
use super::field::point;
use super::solid::all_exist;
use super::submerged::submerged_points;
use super::{Field, Load, Nodal, Solid, initial_strain};
use crate::Error;
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, cross, dot, norm, scale, sub};

/// Cells whose weight one task integrates.
const CELLS_PER_TASK: usize = 4096;

/// Consistent nodal forces of all loads at time `t`: `f_i = ∫ N_i (force per area or volume)`, newton, one entry per
/// degree of freedom (`3 i + c`). They sum to the integral of the load; temperatures give forces without resultant. Each face and cell counts once for each time
/// it is listed.
///
/// The quadrature is exact for tractions of degree 4 on triangles and plane parallelograms (degree 5 in their sum),
/// and for accelerations of degree 1 on tetrahedra; on straight quadratic cells for tractions of degree 3 and
/// accelerations of degree 3, on curved ones for a constant pressure. The pressure of a liquid acts on the part of a face below
/// its level.
///
/// # Errors
/// If a load has no area or mass to act on, names what the mesh does not have, or is not finite.
pub fn external_forces(solid: &Solid, loads: &[Load], t: f64) -> Result<Vec<f64>, Error> {
    let mut force = vec![0.0; 3 * solid.mesh.nodes.len()];
    for (number, load) in loads.iter().enumerate() {
        let added = match load {
            Load::Traction { faces, value } => {
                on_faces(solid.mesh, faces, &mut force, |p| Ok(scale(norm(p.area), vector(value, p.position, t)?)))
            }
            Load::Pressure { faces, value } => {
                on_faces(solid.mesh, faces, &mut force, |p| Ok(scale(-value.finite_at(p.position, t)?, p.area)))
            }
            Load::Force { faces, total } => total_force(solid.mesh, faces, total, t, &mut force),
            Load::Resultant { faces, force: total, moment, about } => {
                resultant(solid.mesh, faces, [total, moment], *about, t, &mut force)
            }
            Load::Hydrostatic { faces, weight, level, up } => {
                let level = of_time(level, t, "the level of a liquid");
                level.and_then(|level| {
                    let pressure = |p: &FacePoint| weight * (level - dot(*up, p.position)).max(0.0);
                    let points = |x: &[V3]| submerged_points(x, &|x| level - dot(*up, x));
                    on_points(solid.mesh, faces, &points, &mut force, |p| Ok(scale(-pressure(p), p.area)))
                })
            }
            Load::Nodal { nodes, value } => at_nodes(solid.mesh, nodes, value, t, &mut force),
            Load::Gravity { cells, acceleration } => {
                on_mass(solid, cells, "gravity", &mut force, |x| vector(acceleration, x, t))
            }
            Load::Rotation { cells, axis, point, speed } => {
                of_time(speed, t, "the speed of a rotation").and_then(|speed| {
                    on_mass(solid, cells, "the rotation", &mut force, |x| {
                        let arm = sub(x, *point);
                        Ok(scale(speed * speed, sub(arm, scale(dot(arm, *axis), *axis))))
                    })
                })
            }
            Load::Temperature { .. } => initial_strain(solid, load, &|_| true, t).map(|initial| {
                let initial = initial.unwrap_or_default();
                force.iter_mut().zip(initial.force).for_each(|(sum, f)| *sum += f);
            }),
        };
        added.map_err(|e| e.at(&format!("load {}", number + 1)))?;
    }
    Ok(force)
}

fn vector(value: &[Field; 3], x: V3, t: f64) -> Result<V3, Error> {
    Ok([value[0].finite_at(x, t)?, value[1].finite_at(x, t)?, value[2].finite_at(x, t)?])
}

/// Adds the shape functions times `force`, which gives the force a quadrature point stands for.
fn on_faces(
    mesh: &Mesh,
    faces: &[u32],
    nodal: &mut [f64],
    force: impl Fn(&FacePoint) -> Result<V3, Error>,
) -> Result<(), Error> {
    on_points(mesh, faces, &face_points, nodal, force)
}

/// The same over the `points` of each face.
fn on_points(
    mesh: &Mesh,
    faces: &[u32],
    points: &dyn Fn(&[V3]) -> Vec<FacePoint>,
    nodal: &mut [f64],
    force: impl Fn(&FacePoint) -> Result<V3, Error>,
) -> Result<(), Error> {
    if faces.is_empty() {
        return Err(Error::new("", "the load acts on no boundary face", "name a group that has boundary faces"));
    }
    all_exist("boundary face", faces, mesh.faces.len())?;
    for &face in faces {
        for point in points(&face_coordinates(mesh, face)) {
            let force = force(&point)?;
            for (&node, &shape) in mesh.faces[face as usize].nodes().iter().zip(&point.shape) {
                add_to_node(nodal, node, scale(shape, force));
            }
        }
    }
    Ok(())
}

/// Adds a force to each node.
fn at_nodes(mesh: &Mesh, nodes: &[u32], value: &[Nodal; 3], t: f64, nodal: &mut [f64]) -> Result<(), Error> {
    all_exist("node", nodes, mesh.nodes.len())?;
    for &node in nodes {
        let x = mesh.nodes[node as usize];
        for (c, value) in value.iter().enumerate() {
            nodal[3 * node as usize + c] += match value {
                Nodal::Field(field) => field.finite_at(x, t)?,
                Nodal::Values { values, ramp } => {
                    let value = values.get(node as usize).copied().unwrap_or(f64::NAN);
                    if !value.is_finite() {
                        let what = format!("the array has no number at node {} at {}", node + 1, point(x));
                        return Err(Error::new("", what, "give one for each node the force acts at"));
                    }
                    value * of_time(ramp, t, "the factor of an array")?
                }
            };
        }
    }
    Ok(())
}

/// A value that has no place: an expression that reads one gives NaN and is refused.
fn of_time(field: &Field, t: f64, what: &str) -> Result<f64, Error> {
    field.finite_at([f64::NAN; 3], t).map_err(|mut e| {
        e.remedy = format!("{what} is a finite number or an expression in the time t only");
        e
    })
}

/// The traction `a + b x r`, `r` from the centroid of the faces, with a given force and moment: `area a` is the force and
/// `J b` the moment about the centroid, `J = ∫ r² I - r rᵀ`, all by the quadrature that loads the nodes, so that the
/// nodal forces have the resultants to rounding.
fn resultant(
    mesh: &Mesh,
    faces: &[u32],
    [force, moment]: [&[Field; 3]; 2],
    about: Option<V3>,
    t: f64,
    nodal: &mut [f64],
) -> Result<(), Error> {
    on_faces(mesh, faces, &mut nodal.to_vec(), |_| Ok([0.0; 3]))?; // refuses faces that do not exist
    let [even, turn, centroid] = resultant_traction(mesh, faces, [force, moment], about, t)?;
    on_faces(mesh, faces, nodal, |p| Ok(scale(norm(p.area), add(even, cross(turn, sub(p.position, centroid))))))
}

/// `a`, `b` and the centroid of that traction; the faces exist.
pub(super) fn resultant_traction(
    mesh: &Mesh,
    faces: &[u32],
    total: [&[Field; 3]; 2],
    about: Option<V3>,
    t: f64,
) -> Result<[V3; 3], Error> {
    FaceMoments::new(mesh, faces).resultant(total, about, t)
}

/// What spreads a total force and a total moment over faces, by the quadrature that loads their nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FaceMoments {
    /// Length squared.
    pub area: f64,
    /// Length.
    pub centroid: V3,
    /// `∫ r² I - r rᵀ`, `r` from the centroid; length to the fourth power.
    pub inertia: [V3; 3],
}

impl FaceMoments {
    /// Of faces that exist.
    pub(crate) fn new(mesh: &Mesh, faces: &[u32]) -> FaceMoments {
        let points = || faces.iter().flat_map(|&face| face_points(&face_coordinates(mesh, face)));
        let area: f64 = points().map(|p| norm(p.area)).sum();
        let centroid = points().fold([0.0; 3], |c, p| add(c, scale(norm(p.area) / area, p.position)));
        let mut inertia = [[0.0; 3]; 3];
        for p in points() {
            let (r, weight) = (sub(p.position, centroid), norm(p.area));
            for a in 0..3 {
                inertia[a][a] += weight * dot(r, r);
                (0..3).for_each(|b| inertia[a][b] -= weight * r[a] * r[b]);
            }
        }
        FaceMoments { area, centroid, inertia }
    }

    /// As numbers, for messages.
    pub(crate) fn numbers(&self) -> [f64; 13] {
        let [x, y, z] = self.centroid;
        let [[a, b, c], [d, e, f], [g, h, i]] = self.inertia;
        [self.area, x, y, z, a, b, c, d, e, f, g, h, i]
    }

    /// The inverse of [`Self::numbers`].
    pub(crate) fn of_numbers([area, x, y, z, a, b, c, d, e, f, g, h, i]: [f64; 13]) -> FaceMoments {
        FaceMoments { area, centroid: [x, y, z], inertia: [[a, b, c], [d, e, f], [g, h, i]] }
    }

    /// The traction of a total force.
    pub(crate) fn even(&self, total: &[Field; 3], t: f64) -> Result<V3, Error> {
        // There is no one place to evaluate a total at: an expression that reads it gives NaN and is refused.
        let total = vector(total, [f64::NAN; 3], t).map_err(|mut e| {
            e.remedy = "a total force is a finite number or an expression in the time t only".into();
            e
        })?;
        if self.area.is_nan() || self.area <= 0.0 {
            return Err(Error::new("", "the faces that carry the total force have no area", "choose other faces"));
        }
        Ok(scale(1.0 / self.area, total))
    }

    /// `a`, `b` and the centroid of the traction `a + b x r` of a total force and moment.
    pub(crate) fn resultant(
        &self,
        [force, moment]: [&[Field; 3]; 2],
        about: Option<V3>,
        t: f64,
    ) -> Result<[V3; 3], Error> {
        let FaceMoments { area, centroid, inertia } = *self;
        let all = |value: &[Field; 3], what: &str| -> Result<V3, Error> {
            Ok([of_time(&value[0], t, what)?, of_time(&value[1], t, what)?, of_time(&value[2], t, what)?])
        };
        let (force, moment) = (all(force, "a total force")?, all(moment, "a total moment")?);
        let of_centroid = add(moment, cross(sub(about.unwrap_or(centroid), centroid), force));
        let columns = [cross(inertia[1], inertia[2]), cross(inertia[2], inertia[0]), cross(inertia[0], inertia[1])];
        let determinant = dot(inertia[0], columns[0]);
        let size = inertia[0][0] + inertia[1][1] + inertia[2][2];
        // A strip of faces along a line resists turning about it by its width only: its own digits are lost below this.
        if !(area > 0.0 && determinant > 1e-12 * size * size * size) {
            let what = "the faces that carry the moment have no width across some axis";
            return Err(Error::new("", what, "choose faces that do not all lie along one line"));
        }
        let turn = scale(1.0 / determinant, [0, 1, 2].map(|k| (0..3).map(|j| columns[j][k] * of_centroid[j]).sum()));
        Ok([scale(1.0 / area, force), turn, centroid])
    }
}

fn total_force(mesh: &Mesh, faces: &[u32], total: &[Field; 3], t: f64, nodal: &mut [f64]) -> Result<(), Error> {
    on_faces(mesh, faces, &mut nodal.to_vec(), |_| Ok([0.0; 3]))?; // refuses faces that do not exist
    let traction = FaceMoments::new(mesh, faces).even(total, t)?;
    on_faces(mesh, faces, nodal, |p| Ok(scale(norm(p.area), traction)))
}

/// Adds what the acceleration does to the mass of the cells; `who` names the load.
fn on_mass(
    solid: &Solid,
    cells: &[u32],
    who: &str,
    nodal: &mut [f64],
    acceleration: impl Fn(V3) -> Result<V3, Error> + Sync,
) -> Result<(), Error> {
    all_exist("cell", cells, solid.mesh.cell_count())?;
    let density = |cell: u32| solid.materials[solid.material_of_cell[cell as usize] as usize].density;
    if !cells.iter().any(|&cell| density(cell) > 0.0) {
        let remedy = "give the material a density, mass per volume";
        return Err(Error::new("", format!("{who} acts on cells without mass"), remedy));
    }
    let list = solid.cells();
    let of_cell = |&cell: &u32| -> Result<[V3; MOST_NODES], Error> {
        let mut force = [[0.0; 3]; MOST_NODES];
        let (kind, nodes) = list.get(cell as usize);
        if density(cell) > 0.0 {
            let points =
                volume_points(kind, solid.mesh, nodes).ok_or_else(|| folded(solid, cell as usize, kind, nodes))?;
            for point in points {
                let weight = scale(density(cell) * point.weight, acceleration(point.position)?);
                force.iter_mut().zip(point.shape).for_each(|(f, shape)| *f = add(*f, scale(shape, weight)));
            }
        }
        Ok(force)
    };
    // Cells are integrated in parallel and added in their order: the sum does not depend on the threads.
    for chunk in cells.chunks(CELLS_PER_TASK * 16) {
        let forces: Vec<Result<[V3; MOST_NODES], Error>> =
            chunk.par_iter().with_min_len(CELLS_PER_TASK).map(of_cell).collect();
        for (&cell, forces) in chunk.iter().zip(forces) {
            let nodes = list.get(cell as usize).1;
            nodes.iter().zip(forces?).for_each(|(&node, force)| add_to_node(nodal, node, force));
        }
    }
    Ok(())
}

fn add_to_node(nodal: &mut [f64], node: u32, force: V3) {
    let first = 3 * node as usize;
    nodal[first..first + 3].iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
}
