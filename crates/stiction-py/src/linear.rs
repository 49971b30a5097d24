//! A solved problem as a linear model about its state of contact, for modes and responses.

use std::sync::Arc;

use pyo3::prelude::*;
use stiction::fem::{DofMap, Material, Solid, mass};
use stiction::friction::{PointState, free_motions};
use stiction::mesh::Mesh;
use stiction::{ContactProblem, Csr};

use crate::errors::{raised, wrong};
use crate::matrix::rows;
use crate::work::borrowed;

/// The problem, which its factor does not belong to, and the state.
#[pyclass(frozen, module = "stiction._stiction")]
pub(crate) struct Matrices {
    pub(crate) problem: Arc<ContactProblem>,
    pub(crate) states: Vec<PointState>,
    /// Of a case.
    pub(crate) body: Option<Body>,
}

/// What the unknowns of a case are displacements of.
pub(crate) struct Body {
    pub(crate) mesh: Mesh,
    pub(crate) materials: Vec<Material>,
    pub(crate) material_of_cell: Vec<u32>,
    pub(crate) dofs: DofMap,
}

impl Matrices {
    fn body(&self, py: Python<'_>) -> PyResult<&Body> {
        self.body.as_ref().ok_or_else(|| wrong(py, "matrices", "they are of a problem without a mesh", "pose a case"))
    }
}

#[pymethods]
impl Matrices {
    /// `K` of the unknowns, both triangles.
    fn stiffness<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        rows(py, borrowed(py, |_| self.problem.elastic.K.full())?)
    }

    /// The motions that contact leaves to the unknowns.
    fn free<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        rows(py, borrowed(py, |_| free_motions(&self.problem, &self.states))?)
    }

    /// Displacements of the nodes along x, y, z by the unknowns.
    fn directions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let dofs = &self.body(py)?.dofs;
        let size = 3 * dofs.nodes();
        let entries = |(k, &dof): (usize, &u32)| {
            let (first, d) = (dof as usize / 3 * 3, dofs.direction(dof));
            (0..3).filter(move |&c| d[c] != 0.0).map(move |c| (first + c, k, d[c]))
        };
        // Interfaces that yield have nodes beyond those of the mesh, without a mass.
        let of_mesh = dofs.free.iter().enumerate().filter(|(_, dof)| (**dof as usize) < size);
        let entries: Vec<(usize, usize, f64)> = of_mesh.flat_map(entries).collect();
        rows(py, Csr::from_triplets(size, dofs.free.len(), &entries))
    }

    /// The consistent masses of the nodes.
    fn mass<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let Body { mesh, materials, material_of_cell, .. } = self.body(py)?;
        let found = borrowed(py, |_| mass(&Solid { mesh, materials, material_of_cell }))?;
        rows(py, found.map_err(|error| raised(py, error))?)
    }
}
