use std::collections::HashMap;

use super::{Axes, Field, RotatedNode};
use crate::linalg::{Csr, SymmetricCsr};

/// A load on boundary faces (indices into `Mesh::faces`) or cells.
#[derive(Debug, Clone)]
pub enum Load {
    /// Force per area, as a vector.
    Traction {
        /// Boundary faces, by number.
        faces: Vec<u32>,
        /// Force per area.
        value: [Field; 3],
    },
    /// Force per area against the outward normal.
    Pressure {
        /// Boundary faces, by number.
        faces: Vec<u32>,
        /// Force per area.
        value: Field,
    },
    /// A total force, spread evenly over the area of the faces; expressions see the time only.
    Force {
        /// Boundary faces, by number.
        faces: Vec<u32>,
        /// The total force, newton.
        total: [Field; 3],
    },
    /// A total force and a total moment about a point (the centroid of the faces if `None`), spread as the traction
    /// `a + b x r`; expressions see the time only.
    Resultant {
        /// Boundary faces, by number.
        faces: Vec<u32>,
        /// The total force, newton.
        force: [Field; 3],
        /// The total moment, newton times length.
        moment: [Field; 3],
        /// The point the moment is about, length.
        about: Option<[f64; 3]>,
    },
    /// The pressure `weight * depth` of a liquid, where `depth` is how far a place lies below the level, counted along
    /// the unit vector `up`; no pressure above it. `weight` is force per volume, the level a length that depends on
    /// the time only.
    Hydrostatic {
        /// Boundary faces, by number.
        faces: Vec<u32>,
        /// Weight of the liquid, force per volume.
        weight: f64,
        /// Its level along `up`, length.
        level: Field,
        /// Unit vector upwards.
        up: [f64; 3],
    },
    /// A force at each node, newton.
    Nodal {
        /// Nodes, by number; a node that is listed twice has it twice.
        nodes: Vec<u32>,
        /// Its components.
        value: [Nodal; 3],
    },
    /// An acceleration acting on the mass of the cells.
    Gravity {
        /// Cells, by number.
        cells: Vec<u32>,
        /// Length per time squared.
        acceleration: [Field; 3],
    },
    /// Centrifugal force on the mass of the cells that turn about the line through `point` along the unit vector `axis`;
    /// the speed, radians per time, depends on the time only.
    Rotation {
        /// Cells, by number.
        cells: Vec<u32>,
        /// Unit vector along the axis.
        axis: [f64; 3],
        /// A point of the axis, length.
        point: [f64; 3],
        /// Radians per time.
        speed: Field,
    },
    /// The temperature of the cells, which strains them by the expansion of their material.
    Temperature {
        /// Cells, by number.
        cells: Vec<u32>,
        /// The temperature.
        value: Temperature,
    },
}

/// A component of the force at nodes.
#[derive(Debug, Clone)]
pub enum Nodal {
    /// Of each node, as a function of place and time.
    Field(Field),
    /// One value for each node of the mesh, times a function of the time only.
    Values {
        /// Forces, newton.
        values: Vec<f64>,
        /// What they are multiplied by.
        ramp: Field,
    },
}

/// A temperature.
#[derive(Debug, Clone)]
pub enum Temperature {
    /// As a function of place and time.
    Field(Field),
    /// Values at the nodes of the mesh, reached along the part `ramp` (0 to 1, of the time only) of the way from the
    /// reference temperature.
    Nodal {
        /// Temperatures.
        values: Vec<f64>,
        /// The part of the way to them, 0 to 1.
        ramp: Field,
    },
    /// The same with one value for each cell of the mesh.
    OfCells {
        /// Temperatures.
        values: Vec<f64>,
        /// The part of the way to them, 0 to 1.
        ramp: Field,
    },
}

/// Prescribed displacements of nodes.
#[derive(Debug, Clone, Default)]
pub struct Fix {
    /// The nodes whose displacement is prescribed.
    pub nodes: Vec<u32>,
    /// Components along `axes`; `None` leaves one free. Expressions see the place along x, y, z.
    pub value: [Option<Field>; 3],
    /// What the components count along.
    pub axes: Axes,
    /// The boundary faces they are the nodes of, by number; none where nodes alone are prescribed.
    pub faces: Vec<u32>,
}

/// Which components of displacement are unknown. Component `c` of node `i` is degree of freedom `3 i + c`; it is that along
/// x, y, z except at the nodes that are rotated.
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
    /// Nodes with axes of their own, ascending.
    pub rotated: Vec<RotatedNode>,
    /// Nodes of the mesh with another node in front of them, an interface that yields: the first of these comes after all
    /// nodes of the mesh. It has the axes of the node of the mesh.
    pub layer: Vec<u32>,
    /// Nodes that follow others by equations, turned about an axis (cyclic symmetry), each with the one it follows.
    pub follows: HashMap<u32, Followed>,
}

/// The node that another follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Followed {
    /// Its number.
    pub node: u32,
    /// What the directions x, y, z at the other node are at this one.
    pub axes: [[f64; 3]; 3],
}

impl DofMap {
    /// Number of nodes of the mesh.
    pub fn nodes(&self) -> usize {
        self.unknown.len() / 3 - self.layer.len()
    }

    /// The node of the mesh that `node` is, or that it lies in front of.
    pub fn mesh_node(&self, node: u32) -> u32 {
        self.layer.get((node as usize).wrapping_sub(self.nodes())).copied().unwrap_or(node)
    }

    /// The degree of freedom of the mesh that `dof` is, or that it lies in front of.
    pub fn mesh_dof(&self, dof: u32) -> u32 {
        3 * self.mesh_node(dof / 3) + dof % 3
    }
}

/// The elastic body without contact: `K u = f` for the unknown displacements.
#[derive(Debug, Clone)]
pub struct FeModel {
    /// Which components are unknown and which prescribed.
    pub dofs: DofMap,
    /// `K`, `n x n`; unknowns of nodes that share a cell have an entry each, zero or not.
    pub stiffness: SymmetricCsr,
    /// Forces on the unknowns less what the prescribed displacements demand, length `n`, newton.
    pub load: Vec<f64>,
    /// Rows of the prescribed degrees of freedom: `p x n`.
    pub support_stiffness: Csr,
    /// `p x p`.
    pub support_support: Csr,
    /// External forces applied at prescribed degrees of freedom, length `p`.
    pub support_load: Vec<f64>,
    /// What springs to the ground add to all three matrices, over the unknowns and then the prescribed, `n + p` square.
    pub springs: Option<Csr>,
}
