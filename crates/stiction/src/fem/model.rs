use super::Field;
use crate::linalg::Csr;

/// A load on boundary faces (indices into `Mesh::faces`) or cells.
#[derive(Debug, Clone)]
pub enum Load {
    /// Force per area, as a vector.
    Traction { faces: Vec<u32>, value: [Field; 3] },
    /// Force per area against the outward normal.
    Pressure { faces: Vec<u32>, value: Field },
    /// A total force, spread evenly over the area of the faces; expressions see the time only.
    Force { faces: Vec<u32>, total: [Field; 3] },
    /// An acceleration acting on the mass of the cells.
    Gravity { cells: Vec<u32>, acceleration: [Field; 3] },
}

/// Prescribed displacement components of nodes.
#[derive(Debug, Clone)]
pub struct Fix {
    pub nodes: Vec<u32>,
    /// `None` leaves the component free.
    pub value: [Option<Field>; 3],
}

/// Which components of displacement are unknown. Component `c` of node `i` is degree of freedom `3 i + c`.
#[derive(Debug, Clone, PartialEq)]
pub struct DofMap {
    /// For each degree of freedom its number among the unknowns, or `u32::MAX` where it is prescribed.
    pub unknown: Vec<u32>,
    /// Degrees of freedom that are unknown, ascending; its length is `n`.
    pub free: Vec<u32>,
    /// Degrees of freedom that are prescribed, ascending; its length is `p`.
    pub prescribed: Vec<u32>,
    /// Prescribed displacements, length `p`.
    pub value: Vec<f64>,
}

/// The elastic body without contact: `K u = f` for the unknown displacements.
#[derive(Debug, Clone)]
pub struct FeModel {
    pub dofs: DofMap,
    /// `K`, `n x n`, symmetric, both triangles stored; every 3x3 block of two neighbouring nodes is stored in full.
    pub stiffness: Csr,
    /// Forces on the unknowns less what the prescribed displacements demand, length `n`, newton.
    pub load: Vec<f64>,
    /// Rows of the prescribed degrees of freedom: `p x n`.
    pub support_stiffness: Csr,
    /// `p x p`.
    pub support_support: Csr,
    /// External forces applied at prescribed degrees of freedom, length `p`.
    pub support_load: Vec<f64>,
}
