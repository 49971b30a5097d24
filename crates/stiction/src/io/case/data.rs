//! What a case file says, as plain data. Groups are still names: no mesh has been read yet.

use std::path::PathBuf;
use std::sync::Arc;

use super::during::During;
use super::source::Spot;
use crate::contact::{InitialGap, InterfaceStiffness, Obstacle, Role, Side, SurfaceFriction};
use crate::fem::{Axes, Field, Material};
use crate::friction::{Method, MethodSettings, SolverPath};
use crate::mesh::{Block, Mesh, MeshNotes, Ring, Turn};

/// A whole case. Any consistent system of units.
#[derive(Debug, Clone)]
pub struct Case {
    /// Heading of the results; the name of the file if the case gives none.
    pub title: String,
    /// Names of the units, a label only.
    pub units: Option<String>,
    /// Where the mesh comes from.
    pub mesh: MeshSpec,
    /// At least one.
    pub materials: Vec<MaterialSpec>,
    /// `[[fix]]`: prescribed displacements.
    pub fixes: Vec<FixSpec>,
    /// `[[spring]]`: elastic foundations.
    pub springs: Vec<SpringSpec>,
    /// `[[load]]`.
    pub loads: Vec<LoadSpec>,
    /// `[[equation]]`.
    pub equations: Vec<EquationSpec>,
    /// `[[cyclic]]`.
    pub cyclic: Vec<CyclicSpec>,
    /// `[[coupling]]`.
    pub couplings: Vec<CouplingSpec>,
    /// `[[bolt]]`.
    pub bolts: Vec<BoltSpec>,
    /// `[[contact]]`.
    pub contacts: Vec<ContactSpec>,
    /// `[solver]`.
    pub solver: SolverSpec,
    /// `[accuracy]`: the mesh is refined until these goals are met.
    pub accuracy: Option<AccuracySpec>,
    /// In the order of their times; empty for a single static problem.
    pub steps: Vec<StepSpec>,
    /// Remarks of who made the case, shown with what was understood of it.
    pub notes: Vec<String>,
}

/// How accurate an answer has to be; each goal is a part of one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AccuracySpec {
    /// Of the stresses in the mean: estimated error in the energy norm, relative.
    pub energy: Option<f64>,
    /// Of the resultants of contact: error bars over the largest resultant.
    pub forces: Option<f64>,
    /// Of the largest displacement: error bar, relative.
    pub displacement: Option<f64>,
    /// Of the largest pressure of each contact: error bar, relative.
    pub pressure: Option<f64>,
    /// No mesh with more displacements is solved.
    pub max_unknowns: Option<usize>,
    /// Whether meshes are of quadratic tetrahedra, or of linear ones.
    pub quadratic: bool,
    /// Whether a bound of the error is to be proven on the last mesh.
    pub proven: bool,
}

impl AccuracySpec {
    /// Whether there is a goal to refine the mesh for.
    pub fn refines(&self) -> bool {
        [self.energy, self.forces, self.displacement, self.pressure].iter().any(Option::is_some)
    }
}

/// A stretch of the time axis, from the end of the step before it or from 0.
#[derive(Debug, Clone, PartialEq)]
pub struct StepSpec {
    /// Its name.
    pub name: String,
    /// Time at its end, greater than that of the step before it.
    pub until: f64,
    /// Equal increments, >= 1.
    pub increments: usize,
    /// Where the file says so.
    pub spot: Spot,
}

/// Where the mesh comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSpec {
    /// What it is made of or read from.
    pub source: MeshSource,
    /// How it is scaled, turned and moved.
    pub placing: Placing,
    /// Where the file says so.
    pub spot: Spot,
}

impl MeshSpec {
    /// Allows the inputs of this mesh to include files from `folders` and below.
    pub fn include_from(&mut self, folders: &[PathBuf]) {
        match &mut self.source {
            MeshSource::File { include, .. } => include.extend_from_slice(folders),
            MeshSource::Parts(parts) => parts.iter_mut().for_each(|(_, part)| part.include_from(folders)),
            MeshSource::Block(_) | MeshSource::Ring(_) | MeshSource::Given(_) => {}
        }
    }
}

/// Where a mesh is taken: turned first, then moved.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Placing {
    /// A rotation, after scaling and before moving.
    pub turn: Option<Turn>,
    /// Length.
    pub by: [f64; 3],
}

/// What a mesh is made of or read from.
#[derive(Debug, Clone, PartialEq)]
pub enum MeshSource {
    /// A box of cells with the groups `x-min` ... `z-max` and `body`.
    Block(Block),
    /// A block bent about the z axis, with the groups `inner` `outer` `start` `end` `z-min` `z-max` and `body`.
    Ring(Ring),
    /// A mesh file.
    File {
        /// Relative paths start at the folder of the case file.
        path: PathBuf,
        /// Factor on the coordinates, > 0.
        scale: f64,
        /// Folders outside that of the mesh from which an input may include files.
        include: Vec<PathBuf>,
    },
    /// A mesh that was made already, with what its maker noted.
    Given(Arc<(Mesh, MeshNotes)>),
    /// Several meshes, each under its name; none of them has parts of its own.
    Parts(Vec<(String, MeshSpec)>),
}

/// A linear elastic material.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialSpec {
    /// What it is made of.
    pub material: Material,
    /// Volume groups; `None` is the whole body, possible only for a single material.
    pub on: Option<Vec<(String, Spot)>>,
    /// Where the file says so.
    pub spot: Spot,
}

/// A part of the body.
#[derive(Debug, Clone, PartialEq)]
pub enum Region {
    /// The union of named groups, each with the place where it is named.
    Groups(Vec<(String, Spot)>),
    /// What lies in a box, its boundary included; length.
    Box {
        /// The corner with the least coordinates, length.
        min: [f64; 3],
        /// The corner with the largest coordinates, length.
        max: [f64; 3],
    },
    /// The node nearest to a point; length.
    Point([f64; 3]),
}

/// Names of the components along the axes of a cylinder: radial, tangential, axial.
pub const CYLINDRICAL: [&str; 3] = ["r", "t", "z"];

/// What a support does with its nodes in the step it begins with, if that is not the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Beginning {
    /// It leads them to its value on a line in time.
    #[default]
    Led,
    /// They have its value at once.
    AtOnce,
    /// It holds them where they stand.
    Stays,
}

/// Prescribed displacements.
#[derive(Debug, Clone)]
pub struct FixSpec {
    /// Where.
    pub on: Region,
    /// Length; `None` leaves the component free. Of a symmetry plane all are `None`: its normal decides.
    pub value: [Option<Field>; 3],
    /// What the components count along.
    pub axes: Axes,
    /// Whether the faces are a plane of symmetry.
    pub symmetry: bool,
    /// How it begins with a later step.
    pub beginning: Beginning,
    /// The steps in which it holds.
    pub during: During,
    /// Where the file says so.
    pub spot: Spot,
}

/// An elastic foundation.
#[derive(Debug, Clone, PartialEq)]
pub struct SpringSpec {
    /// Where.
    pub on: Region,
    /// Stiffness per area along the normal and across it, force per length³, >= 0, one of them positive.
    pub normal: f64,
    /// Tangential stiffness per area, force per length cubed.
    pub tangential: f64,
    /// Where the file says so.
    pub spot: Spot,
}

/// A load.
#[derive(Debug, Clone)]
pub struct LoadSpec {
    /// `None` is the whole body, possible only for loads on cells.
    pub on: Option<Region>,
    /// What acts.
    pub kind: LoadKind,
    /// Where the file says so.
    pub spot: Spot,
}

/// What a load is.
#[derive(Debug, Clone)]
pub enum LoadKind {
    /// Force per area.
    Traction([Field; 3]),
    /// Force per area against the outward normal.
    Pressure(Field),
    /// Total force, spread evenly over the area; depends on time only.
    Force([Field; 3]),
    /// Total force and moment about a point, by default the centroid of the faces; they depend on time only.
    Resultant {
        /// The total force, newton.
        force: [Field; 3],
        /// The total moment, newton times length.
        moment: [Field; 3],
        /// The point the moment is about, length.
        about: Option<[f64; 3]>,
    },
    /// Pressure of a liquid: force per volume, the level along the unit vector `up`, which depends on time only.
    Hydrostatic {
        /// Weight of the liquid, force per volume.
        weight: f64,
        /// Its level along `up`, length.
        level: Field,
        /// Unit vector upwards.
        up: [f64; 3],
    },
    /// Acceleration.
    Gravity([Field; 3]),
    /// Unit axis, a point of it, and radians per time, which depend on time only.
    Rotation {
        /// Unit vector along the axis.
        axis: [f64; 3],
        /// A point of the axis, length.
        point: [f64; 3],
        /// Radians per time.
        speed: Field,
    },
    /// Force at each node.
    Nodal([NodalSpec; 3]),
    /// Temperature.
    Temperature(Field),
    /// Temperature at the nodes or of the cells by the name of an array of the mesh file, and the part of the way to it, which depends on
    /// time only.
    TemperatureArray {
        /// Its name.
        name: String,
        /// The part of the way to them, 0 to 1.
        ramp: Field,
        /// Where the file says so.
        spot: Spot,
    },
}

/// A component of the force at nodes.
#[derive(Debug, Clone)]
pub enum NodalSpec {
    /// Of each node.
    Field(Field),
    /// By the name of an array of points of the mesh file, times a function of time.
    Array {
        /// Its name.
        name: String,
        /// What it is multiplied by, which depends on time only.
        ramp: Field,
        /// Where the file says so.
        spot: Spot,
    },
}

impl LoadKind {
    /// Whether it acts at nodes, and at all of them if no region is given.
    pub fn at_nodes(&self) -> bool {
        matches!(self, LoadKind::Nodal(_))
    }

    /// Whether it acts on cells, and everywhere if no region is given.
    pub fn on_cells(&self) -> bool {
        use LoadKind::{Gravity, Rotation, Temperature, TemperatureArray};
        matches!(self, Gravity(_) | Rotation { .. } | Temperature(_) | TemperatureArray { .. })
    }
}

/// A linear equation between displacements.
#[derive(Debug, Clone)]
pub struct EquationSpec {
    /// What is added up.
    pub terms: Vec<TermSpec>,
    /// The sum; depends on time only.
    pub value: Field,
    /// Where the file says so.
    pub spot: Spot,
}

/// A term of an equation: the sum of the displacements of some nodes along a direction, times a factor.
#[derive(Debug, Clone, PartialEq)]
pub struct TermSpec {
    /// The nodes.
    pub on: Region,
    /// Unit vector.
    pub along: [f64; 3],
    /// Not zero.
    pub factor: f64,
    /// Where the file says so.
    pub spot: Spot,
}

/// Cyclic symmetry: the nodes of one cut follow those of the other, turned by one sector.
#[derive(Debug, Clone)]
pub struct CyclicSpec {
    /// The nodes of one cut.
    pub on: Region,
    /// Those of the other.
    pub against: Region,
    /// At least two.
    pub sectors: usize,
    /// Unit vector.
    pub axis: [f64; 3],
    /// A point of the axis, length.
    pub point: [f64; 3],
    /// How far apart nodes of the two cuts may be, length.
    pub search: Option<f64>,
    /// Where the file says so.
    pub spot: Spot,
}

/// Nodes that move with a reference point.
#[derive(Debug, Clone)]
pub struct CouplingSpec {
    /// No two couplings share one.
    pub name: String,
    /// The nodes, or the faces of a distributing coupling.
    pub on: Region,
    /// The reference point, length.
    pub point: [f64; 3],
    /// Whether the point moves as the faces do in the mean; else the nodes are one rigid body.
    pub distributing: bool,
    /// The displacements along x, y, z that follow the point.
    pub components: [bool; 3],
    /// Prescribed displacements of the point, length; they depend on time only.
    pub motion: [Option<Field>; 3],
    /// Prescribed rotations of the point, radians.
    pub rotation: [Option<Field>; 3],
    /// Force at the point.
    pub force: [Field; 3],
    /// Moment at the point.
    pub moment: [Field; 3],
    /// When motion and rotation are prescribed.
    pub during: During,
    /// Where the file says so.
    pub spot: Spot,
}

impl CouplingSpec {
    /// Whether its nodes move as one rigid body, in all directions.
    pub(crate) fn is_rigid(&self) -> bool {
        !self.distributing && self.components == [true; 3]
    }
}

/// A bolt that is tightened.
#[derive(Debug, Clone)]
pub struct BoltSpec {
    /// Its name.
    pub name: String,
    /// Faces between cells, or cells; never a point.
    pub on: Region,
    /// Of unit length.
    pub axis: Option<[f64; 3]>,
    /// Length.
    pub point: Option<[f64; 3]>,
    /// Force or shortening.
    pub by: Tightening,
    /// The step after which the shortening stays, by its place in `Case::steps`.
    pub lock: Option<usize>,
    /// Where the file says so.
    pub spot: Spot,
}

/// What is prescribed of a bolt; depends on time only.
#[derive(Debug, Clone)]
pub enum Tightening {
    /// Tension.
    Force(Field),
    /// Length.
    Shortening(Field),
}

/// A surface that may touch a rigid obstacle or another surface.
#[derive(Debug, Clone)]
pub struct ContactSpec {
    /// No two contacts share one.
    pub name: String,
    /// Never a point.
    pub on: Region,
    /// What the surface may touch.
    pub against: AgainstSpec,
    /// Translation of the obstacle, length; depends on time only.
    pub motion: Option<[Field; 3]>,
    /// The law of friction.
    pub friction: SurfaceFriction,
    /// Where friction is given.
    pub friction_spot: Spot,
    /// How the interface yields; hard contact if `None`.
    pub stiffness: Option<InterfaceStiffness>,
    /// The stress xx, yy, zz, yz, xz, xy in it before anything is loaded, by place; tension is positive.
    pub initial_stress: Option<[Field; 6]>,
    /// The steps in which it holds.
    pub during: During,
    /// Steps among these in which it does not.
    pub without: Vec<usize>,
    /// The step through which it is bonded whatever its friction.
    pub bonded_until: Option<usize>,
    /// Archard's coefficient, depth over pressure and path, 1/stress.
    pub wear: Option<f64>,
    /// Where the file says so.
    pub spot: Spot,
}

/// What a surface may touch.
#[derive(Debug, Clone, PartialEq)]
pub enum AgainstSpec {
    /// Directions have unit length.
    Obstacle(Obstacle),
    /// A surface of triangles in a file.
    File(SurfaceFile),
    /// Groups of boundary faces.
    Surface {
        /// The other surface.
        region: Region,
        /// How the initial gap is taken; where `closed_at` is given no more than what is left of it.
        gap: InitialGap,
        /// Nodes of the slave at which it is closed.
        closed_at: Option<Region>,
        /// `None` lets sizes and materials decide.
        slave: Option<Role>,
        /// Length, > 0; `None` is a part of the surfaces' size.
        search: Option<f64>,
        /// What a solve has found that `search` has to be instead; never given in a file.
        widened: Option<f64>,
    },
}

/// A rigid obstacle from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceFile {
    /// Relative paths start at the folder of the case file.
    pub path: PathBuf,
    /// Factor on the coordinates, > 0.
    pub scale: f64,
    /// How it is scaled, turned and moved.
    pub placing: Placing,
    /// Which side the body is on.
    pub side: Side,
    /// Degrees; where the surface bends by more it has an edge, elsewhere it is smooth.
    pub feature_angle: f64,
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
    /// Factor or multigrid.
    pub path: SolverPath,
    /// From how many starts solutions are looked for; `None` is the default one alone.
    pub starts: Option<usize>,
    /// As the case calls the method.
    pub method_name: String,
    /// The method, with its own tolerances.
    pub method: MethodSettings,
    /// Where the settings are; empty if there are none.
    pub spot: Spot,
}

impl Default for SolverSpec {
    fn default() -> Self {
        let method = MethodSettings::new(Method::Newton);
        let (tolerance, max_iterations, path, method_name) = (1e-8, 200, SolverPath::Auto, "newton".into());
        SolverSpec {
            tolerance,
            max_iterations,
            memory: None,
            path,
            starts: None,
            method_name,
            method,
            spot: Spot::default(),
        }
    }
}
