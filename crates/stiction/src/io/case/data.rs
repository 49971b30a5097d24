//! What a case file says, as plain data. Groups are still names: no mesh has been read yet.

use std::path::PathBuf;

use super::source::Spot;
use crate::fem::{Field, Formulation};
use crate::friction::{Method, MethodSettings};

/// A whole case. Any consistent system of units.
#[derive(Debug, Clone)]
pub struct Case {
    /// Heading of the results; the name of the file if the case gives none.
    pub title: String,
    /// Names of the units, a label only.
    pub units: Option<String>,
    pub mesh: MeshSpec,
    /// At least one.
    pub materials: Vec<MaterialSpec>,
    pub fixes: Vec<FixSpec>,
    pub loads: Vec<LoadSpec>,
    pub contacts: Vec<ContactSpec>,
    pub solver: SolverSpec,
}

/// Where the mesh comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSpec {
    pub source: MeshSource,
    pub spot: Spot,
}

#[derive(Debug, Clone, PartialEq)]
pub enum MeshSource {
    Block(BlockSpec),
    File {
        /// Relative paths start at the folder of the case file.
        path: PathBuf,
        /// Factor on the coordinates, > 0.
        scale: f64,
    },
}

/// A box of cells with the groups `x-min` ... `z-max` and `body`.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockSpec {
    /// Lengths of the edges, > 0.
    pub size: [f64; 3],
    /// Boxes along each axis, >= 1.
    pub cells: [usize; 3],
    /// Lowest corner, length.
    pub origin: [f64; 3],
    /// Length of the last box over that of the first along each axis, > 0.
    pub grading: [f64; 3],
    pub element: BlockElement,
}

/// What becomes of each box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockElement {
    /// Five tetrahedra, mirrored from box to box. At parity 0 the central tetrahedron of the box at the origin
    /// stands on the corners 100 010 001 111, at parity 1 on the other four.
    FiveTets { parity: u8 },
    /// Six tetrahedra around the diagonal from the lowest to the highest corner.
    SixTets,
    /// One hexahedron.
    Hex8,
}

/// An isotropic linear elastic material.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialSpec {
    pub name: String,
    /// Young's modulus, stress, > 0.
    pub young: f64,
    /// Poisson's ratio, in (-1, 0.5).
    pub poisson: f64,
    /// Mass per volume, >= 0.
    pub density: f64,
    pub formulation: Formulation,
    /// Volume groups; `None` is the whole body, possible only for a single material.
    pub on: Option<Vec<(String, Spot)>>,
    pub spot: Spot,
}

/// A part of the body.
#[derive(Debug, Clone, PartialEq)]
pub enum Region {
    /// The union of named groups, each with the place where it is named.
    Groups(Vec<(String, Spot)>),
    /// What lies in a box, its boundary included; length.
    Box { min: [f64; 3], max: [f64; 3] },
    /// The node nearest to a point; length.
    Point([f64; 3]),
}

/// Prescribed displacements.
#[derive(Debug, Clone)]
pub struct FixSpec {
    pub on: Region,
    /// Length; `None` leaves the component free.
    pub value: [Option<Field>; 3],
    pub spot: Spot,
}

/// A load.
#[derive(Debug, Clone)]
pub struct LoadSpec {
    /// `None` is the whole body, possible only for gravity.
    pub on: Option<Region>,
    pub kind: LoadKind,
    pub spot: Spot,
}

#[derive(Debug, Clone)]
pub enum LoadKind {
    /// Force per area.
    Traction([Field; 3]),
    /// Force per area against the outward normal.
    Pressure(Field),
    /// Total force, spread evenly over the area; depends on time only.
    Force([Field; 3]),
    /// Acceleration.
    Gravity([Field; 3]),
}

/// A surface that may touch a rigid obstacle.
#[derive(Debug, Clone)]
pub struct ContactSpec {
    /// No two contacts share one.
    pub name: String,
    /// Never a point.
    pub on: Region,
    pub against: ObstacleSpec,
    pub friction: FrictionSpec,
    pub spot: Spot,
}

/// A rigid obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ObstacleSpec {
    /// Half space; the unit normal points out of it, towards the body.
    Plane {
        point: [f64; 3],
        normal: [f64; 3],
    },
    Sphere {
        center: [f64; 3],
        radius: f64,
        side: Side,
    },
    /// Without ends; the axis has unit length.
    Cylinder {
        point: [f64; 3],
        axis: [f64; 3],
        radius: f64,
        side: Side,
    },
}

/// On which side of a round surface the body lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    #[default]
    Outside,
    /// As in a bore.
    Inside,
}

/// A law of friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrictionSpec {
    None,
    /// The surface sticks wherever it is.
    Bonded,
    /// Coefficient of friction, >= 0.
    Coulomb(f64),
    /// Shear stress at which a point slips, >= 0.
    TrescaStress(f64),
    /// Force at which a contact point slips, >= 0.
    TrescaNodal(f64),
}

/// Settings of the solver.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverSpec {
    /// What every number of the certificate is held against, in [1e-14, 0.1].
    pub tolerance: f64,
    /// Most outer iterations, >= 1.
    pub max_iterations: usize,
    /// Gigabytes (1e9 bytes) allowed for stored matrices, > 0; `None` is what the machine has.
    pub memory: Option<f64>,
    pub path: DualPath,
    /// As the case calls the method.
    pub method_name: String,
    /// The method, with its own tolerances.
    pub method: MethodSettings,
}

impl Default for SolverSpec {
    fn default() -> Self {
        let method = MethodSettings::new(Method::Newton);
        let (tolerance, max_iterations, path, method_name) = (1e-8, 100, DualPath::Auto, "newton".into());
        SolverSpec { tolerance, max_iterations, memory: None, path, method_name, method }
    }
}

/// The form of the operator `B K⁻¹ Bᵀ`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DualPath {
    /// The cheaper one that fits the memory.
    #[default]
    Auto,
    /// A stored dense matrix.
    Dense,
    /// Two triangular solves for each product.
    Solves,
}
