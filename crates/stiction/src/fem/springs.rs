//! Elastic foundations (Winkler): springs to the ground, spread over boundary faces.
//!
//! Springs are part of `K`, so that a body on springs has no rigid motions left. Their own matrix is kept beside it: in the
//! balance of forces they act from outside.

use super::FeModel;
use super::faces::{face_coordinates, face_points};
use super::rotated::turn_block;
use super::solid::all_exist;
use crate::Error;
use crate::linalg::{Csr, SymmetricCsr};
use crate::mesh::Mesh;
use crate::mesh::v3::{norm, scale};

/// Springs from boundary faces to the ground; they pull as they push.
#[derive(Debug, Clone, PartialEq)]
pub struct Spring {
    /// Indices into `Mesh::faces`.
    pub faces: Vec<u32>,
    /// Stiffness per area along the normal of the faces, force per length³, >= 0.
    pub normal: f64,
    /// The same across it.
    pub tangential: f64,
}

/// Adds the springs to the matrices of an assembled model and keeps their own matrix in [`FeModel::springs`]:
/// `∫ N_i N_j (k_n n nᵀ + k_t (I - n nᵀ))`, with the normal at each quadrature point.
///
/// # Errors
/// Faces that do not exist, a stiffness that is negative or not finite, springs without any stiffness.
pub fn add_springs(mesh: &Mesh, springs: &[Spring], model: &mut FeModel) -> Result<(), Error> {
    if springs.is_empty() {
        return Ok(());
    }
    let size = model.dofs.free.len() + model.dofs.prescribed.len();
    let number = number(model);
    let mut entries = Vec::new();
    for spring in springs {
        refuse(mesh, spring)?;
        for &face in &spring.faces {
            let nodes = mesh.faces[face as usize].nodes();
            for point in face_points(&face_coordinates(mesh, face)) {
                let area = norm(point.area);
                let n = scale(1.0 / area, point.area);
                let stiffness = |a: usize, b: usize| {
                    let along = n[a] * n[b];
                    let across = f64::from(u8::from(a == b)) - along;
                    area * (spring.normal * along + spring.tangential * across)
                };
                for (&i, ni) in nodes.iter().zip(&point.shape) {
                    for (&j, nj) in nodes.iter().zip(&point.shape) {
                        let block = [0, 1, 2].map(|a| [0, 1, 2].map(|b| ni * nj * stiffness(a, b)));
                        let block = turn_block(&block, [i, j], model.dofs.axes(i), model.dofs.axes(j));
                        for (a, row) in block.iter().enumerate() {
                            for (b, &value) in row.iter().enumerate() {
                                let [row, column] = [3 * i as usize + a, 3 * j as usize + b].map(|dof| number[dof]);
                                entries.push((row, column, value));
                            }
                        }
                    }
                }
            }
        }
    }
    let own = Csr::from_triplets(size, size, &entries);
    let n = model.dofs.free.len();
    for row in 0..size {
        for (column, value) in own.entries_of(row) {
            let column = column as usize;
            match (row < n, column < n) {
                (true, true) => add_lower(&mut model.stiffness, row, column, value),
                (true, false) => model.load[row] -= value * model.dofs.value[column - n],
                (false, true) => add(&mut model.support_stiffness, row - n, column, value),
                (false, false) => add(&mut model.support_support, row - n, column - n, value),
            }
        }
    }
    model.springs = Some(own);
    Ok(())
}

/// For each degree of freedom its place among the unknown, then the prescribed.
fn number(model: &FeModel) -> Vec<usize> {
    let mut number = vec![0; model.dofs.unknown.len()];
    let all = model.dofs.free.iter().chain(&model.dofs.prescribed);
    all.enumerate().for_each(|(place, &dof)| number[dof as usize] = place);
    number
}

fn refuse(mesh: &Mesh, spring: &Spring) -> Result<(), Error> {
    all_exist("boundary face", &spring.faces, mesh.faces.len())?;
    let good = |k: f64| k >= 0.0 && k.is_finite();
    if !good(spring.normal) || !good(spring.tangential) || spring.normal + spring.tangential == 0.0 {
        let what = format!("springs of stiffness {} along and {} across the normal", spring.normal, spring.tangential);
        return Err(Error::new("", what, "give one of them a positive stiffness per area, and none a negative one"));
    }
    Ok(())
}

/// Adds to an entry of the pattern: nodes of a face share a cell, so their blocks are stored.
fn add(matrix: &mut Csr, row: usize, column: usize, value: f64) {
    let range = matrix.start[row]..matrix.start[row + 1];
    if let Ok(place) = matrix.column[range.clone()].binary_search(&(column as u32)) {
        matrix.value[range.start + place] += value;
    }
}

/// The same of a symmetric matrix, which stores one of two mirror images.
fn add_lower(matrix: &mut SymmetricCsr, row: usize, column: usize, value: f64) {
    if column <= row {
        matrix.entry_mut(row, column).into_iter().for_each(|entry| *entry += value);
    }
}
