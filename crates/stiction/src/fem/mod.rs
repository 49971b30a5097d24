//! Elements, materials and loads: from a mesh to a stiffness matrix and a load vector.

use std::fmt;
use std::sync::Arc;

use crate::linalg::Csr;

/// A number, or a function of position and time given as an expression.
#[derive(Clone)]
pub enum Field {
    Constant(f64),
    /// `f(x, t)`, with the text it was read from for messages.
    Function {
        text: String,
        value: Arc<dyn Fn([f64; 3], f64) -> f64 + Send + Sync>,
    },
}

impl Field {
    /// The value at `x` and time `t`.
    pub fn at(&self, x: [f64; 3], t: f64) -> f64 {
        match self {
            Field::Constant(c) => *c,
            Field::Function { value, .. } => value(x, t),
        }
    }
}

impl fmt::Debug for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Field::Constant(c) => write!(f, "{c}"),
            Field::Function { text, .. } => write!(f, "{text:?}"),
        }
    }
}

/// How the strain of a hexahedron is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Formulation {
    /// B-bar where Poisson's ratio exceeds 0.45, full integration elsewhere.
    #[default]
    Auto,
    /// 2 x 2 x 2 Gauss points.
    Full,
    /// Mean dilatation (Hughes 1980): the volumetric strain is averaged over the cell, which avoids locking.
    BBar,
}

/// Isotropic linear elasticity.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    pub name: String,
    /// Young's modulus, stress.
    pub young: f64,
    /// Poisson's ratio, in (-1, 0.5).
    pub poisson: f64,
    /// Mass per volume; zero if gravity does not act on it.
    pub density: f64,
    pub formulation: Formulation,
}

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
