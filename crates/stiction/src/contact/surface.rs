use std::fmt;

use super::{InterfaceStiffness, Obstacle, Reason, Role};
use crate::fem::Field;

/// Friction of a whole surface.
#[derive(Debug, Clone, PartialEq)]
pub enum SurfaceFriction {
    /// No tangential force.
    None,
    /// Tied in every direction.
    Bonded,
    /// Coefficient of Coulomb friction.
    Coulomb(f64),
    /// Coulomb friction that differs by place or by direction, or has a limit.
    Law(CoulombLaw),
    /// Given friction as a shear stress; the bound of a point is the stress times its area.
    GivenStress(f64),
    /// Given friction as a force at each point, as in the source paper.
    GivenForce(f64),
}

/// Coulomb friction in all its forms. Coefficients are functions of place, read at the nodes of the undeformed surface.
#[derive(Debug, Clone, PartialEq)]
pub struct CoulombLaw {
    /// The coefficient; where friction differs by direction that along it.
    pub coefficient: Coefficient,
    /// Another coefficient across a direction.
    pub across: Option<Across>,
    /// The shear stress friction does not exceed. Where friction differs by direction, that of the direction in which it is
    /// the largest: the ellipse keeps its shape.
    pub limit: Option<f64>,
    /// Strength beside friction; with one coefficient and no limit.
    pub cohesion: Option<Box<Cohesion>>,
}

/// Strength of an interface beside friction: `shear <= cohesion + coefficient * pressure` where the surfaces touch, and
/// `pressure >= -tension`.
#[derive(Debug, Clone, PartialEq)]
pub struct Cohesion {
    /// Shear strength without pressure, stress.
    pub shear: Coefficient,
    /// Tensile strength, stress; the apex of the cone, `shear / coefficient`, where that is less.
    pub tension: Coefficient,
    /// Whether a point loses both for good once it slips or opens, at the end of the step in which it does.
    pub brittle: bool,
}

/// A coefficient of friction or a strength, >= 0.
#[derive(Clone, PartialEq)]
pub enum Coefficient {
    /// A number or an expression in x, y, z.
    Field(Field),
    /// An expression in x, y, z and t.
    OfTime {
        /// The expression.
        field: Field,
        /// One value a node of the mesh at the time the problem is posed for, NaN away from the surface; none before the mesh
        /// is known.
        values: Vec<f64>,
    },
    /// An array of the mesh: one value for each node, NaN away from the surface; none before the mesh is known.
    Array {
        /// Name of the array.
        name: String,
        /// One value a node of the mesh.
        values: Vec<f64>,
    },
}

impl From<Field> for Coefficient {
    fn from(field: Field) -> Self {
        Coefficient::Field(field)
    }
}

impl fmt::Debug for Coefficient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Coefficient::Field(field) | Coefficient::OfTime { field, .. } => write!(f, "{field:?}"),
            Coefficient::Array { name, values } => {
                let [low, high] = [f64::min, f64::max].map(|of| values.iter().copied().fold(f64::NAN, of));
                write!(f, "by the array \"{name}\" (from {low} to {high})")
            }
        }
    }
}

impl SurfaceFriction {
    /// Whether friction follows the normal force.
    pub fn is_coulomb(&self) -> bool {
        matches!(self, SurfaceFriction::Coulomb(_) | SurfaceFriction::Law(_))
    }

    /// Whether an array of the mesh gives a coefficient.
    pub fn is_array(&self) -> bool {
        let SurfaceFriction::Law(law) = self else { return false };
        let array = |coefficient: &Coefficient| matches!(coefficient, Coefficient::Array { .. });
        array(&law.coefficient)
            || law.across.as_ref().is_some_and(|across| array(&across.coefficient))
            || law.cohesion.as_ref().is_some_and(|cohesion| array(&cohesion.shear) || array(&cohesion.tension))
    }

    /// Whether points lose their strength for good once they slip or open.
    pub fn is_brittle(&self) -> bool {
        let SurfaceFriction::Law(law) = self else { return false };
        law.cohesion.as_ref().is_some_and(|cohesion| cohesion.brittle)
    }
}

/// How friction across a direction differs from that along it: forces lie in an ellipse with these axes, slip along its
/// normal.
#[derive(Debug, Clone, PartialEq)]
pub struct Across {
    /// The coefficient across the direction.
    pub coefficient: Coefficient,
    /// Of any length; its part along the surface counts.
    pub direction: [f64; 3],
}

/// A candidate contact surface of the body and what it may touch.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSurface {
    /// Name of the surface, for reports and messages.
    pub name: String,
    /// Indices into `Mesh::faces`; their nodes carry the contact points.
    pub faces: Vec<u32>,
    /// What it may touch.
    pub against: Counterpart,
    /// The law of friction.
    pub friction: SurfaceFriction,
    /// How the interface yields under the forces it carries; hard contact if `None`.
    pub stiffness: Option<InterfaceStiffness>,
    /// When it holds, ascending: surfaces that never do so together do not compete for nodes.
    pub periods: Vec<Period>,
}

/// Time after which something holds, and until which.
pub type Period = [f64; 2];

/// From beginning to end.
pub const ALWAYS: Period = [f64::NEG_INFINITY, f64::INFINITY];

impl ContactSurface {
    /// Whether both hold at some time.
    pub(crate) fn holds_with(&self, other: &ContactSurface) -> bool {
        self.periods.iter().any(|[a, b]| other.periods.iter().any(|[from, to]| a.max(*from) < b.min(*to)))
    }

    /// What helps where a prescribed displacement presses nodes into an obstacle.
    pub(crate) fn remedy_of_overlap(&self) -> &'static str {
        match self.stiffness {
            Some(_) => {
                "move the nodes by a rigid [[coupling]] in place of the [[fix]]: the interface yields under them there; or take them out of \
                 the contact surface"
            }
            None => "reduce the prescribed displacement, or take the node out of the contact surface",
        }
    }

    /// Lets the other surface of a pair carry the points; nothing where there is no other.
    pub(crate) fn change_sides(&mut self) {
        let Counterpart::Surface(master) = &mut self.against else { return };
        std::mem::swap(&mut self.faces, &mut master.faces);
        master.slave = if master.slave == Role::On { Role::Against } else { Role::On };
    }
}

/// What a surface may touch.
#[derive(Debug, Clone, PartialEq)]
pub enum Counterpart {
    /// A rigid obstacle.
    Obstacle(Obstacle),
    /// Another surface of the mesh, deformable as well.
    Surface(Master),
}

impl From<Obstacle> for Counterpart {
    fn from(obstacle: Obstacle) -> Self {
        Counterpart::Obstacle(obstacle)
    }
}

/// The surface that follows the contact points of another.
#[derive(Debug, Clone, PartialEq)]
pub struct Master {
    /// Indices into `Mesh::faces`.
    pub faces: Vec<u32>,
    /// How the initial gap is taken.
    pub gap: InitialGap,
    /// Surfaces meet if they are no farther apart, or overlap no deeper, than this length; by default
    /// [`SEARCH`] of the diagonal of the smaller of the two.
    pub search: Option<f64>,
    /// Which of the surfaces named by the user is the slave, the one with the contact points. Forces and slips are those
    /// of the slave whoever it is.
    pub slave: Role,
    /// Why the points are where they are.
    pub reason: Reason,
    /// Nodes of the slave that meet the master each by itself, ascending: node to surface. `None` lets its faces meet, by
    /// the mortar method.
    pub nodes: Option<Vec<u32>>,
}

/// The default of [`Master::search`] as a part of the diagonal of the smaller surface.
pub const SEARCH: f64 = 0.25;

/// The distance of two surfaces before anything is loaded.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum InitialGap {
    /// What the meshes say, overlaps included.
    #[default]
    AsMeshed,
    /// None, wherever the surfaces meet.
    Closed,
    /// None where the meshes are no farther apart than this length or overlap, elsewhere what they say.
    ClosedWithin(f64),
    /// None at these nodes of the slave, ascending; elsewhere what the meshes say.
    ClosedAt(Vec<u32>),
    /// The same length wherever they meet; negative for an interference fit.
    Uniform(f64),
}

/// What was found while posing one surface.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SurfaceFacts {
    /// Name of the surface, for reports and messages.
    pub name: String,
    /// Contact points kept.
    pub points: usize,
    /// The node of each.
    pub nodes: Vec<u32>,
    /// Points that take no part for a time in which the surface holds: another contact has their node then, or that of a neighbour.
    pub out: Vec<(usize, Period)>,
    /// Area of the faces.
    pub area: f64,
    /// Least initial gap, length.
    pub gap_min: f64,
    /// Largest initial gap, length.
    pub gap_max: f64,
    /// Points that start inside the counterpart, and the area they stand for.
    pub overlapping: usize,
    /// Area that overlaps its counterpart, length squared.
    pub overlapping_area: f64,
    /// Nodes of the surface whose three components are prescribed: their multipliers are dropped.
    pub clamped: usize,
    /// Nodes that cannot move along the normal, those a bonded surface ties included: dropped as well.
    pub held_along_normal: usize,
    /// Points with one or no free tangential direction, as on a symmetry plane.
    pub guided: usize,
    /// Points that a support holds along the surface while the other body moves there: friction acts on it and on the support.
    pub held_along_surface: usize,
    /// Nodes beyond the border of an open obstacle, which meet nothing: dropped.
    pub beyond: usize,
    /// Points whose outward normal does not face the obstacle.
    pub facing_away: usize,
    /// Points that have triangles of an open surface between them and what they meet, all with their backs to the body.
    pub behind_backs: usize,
    /// Nodes of faces that look away from the obstacle, where others look at it: dropped.
    pub looking_away: usize,
    /// Area of dropped nodes, which carries no contact force.
    pub dropped_area: f64,
    /// Nodes that another contact uses: dropped; in a pair neighbours carry for them.
    pub taken: usize,
    /// Nodes in front of which the counterpart of another contact lies: they meet that one.
    pub behind: usize,
    /// Nodes that touch the counterpart or nearly do: those that stay, and those that contacts with the same faces use.
    pub near: [usize; 2],
    /// For contact between two surfaces.
    pub pair: Option<PairFacts>,
}

impl SurfaceFacts {
    /// Of a surface of which no point has been found yet.
    pub(super) fn named(name: &str) -> Self {
        SurfaceFacts { name: name.into(), gap_min: f64::INFINITY, gap_max: f64::NEG_INFINITY, ..Default::default() }
    }
}

/// What was found about two surfaces; areas and sizes are those of the slave.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PairFacts {
    /// The surface that carries the points.
    pub slave: Role,
    /// Why the points are where they are.
    pub reason: Reason,
    /// Faces of slave and master.
    pub faces: [usize; 2],
    /// Root of the mean area of the faces of slave and master; length.
    pub face_size: [f64; 2],
    /// How far apart the surfaces were allowed to be; length.
    pub search: f64,
    /// Area over which the surfaces look at one another within that distance.
    pub covered_area: f64,
    /// Area of the flat pieces that stand for the faces there: less than that of faces with curved edges.
    pub flat_area: f64,
    /// Area of the points whose gap is rounding.
    pub touching_area: f64,
    /// Nodes that look at nothing of the other surface.
    pub uncovered: usize,
    /// Nodes whose patch hardly reaches over the other surface: their neighbours carry for them.
    pub barely_covered: usize,
    /// Nodes of both surfaces, where the meshes are joined: dropped, neighbours carry for them.
    pub shared: usize,
    /// Whether faces that look the same way lie over one another.
    pub averted: bool,
    /// Smallest distance of a slave node from the other surface, reported only if the surfaces nowhere meet; length.
    pub nearest: Option<f64>,
}
