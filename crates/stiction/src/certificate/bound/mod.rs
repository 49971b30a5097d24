//! Judges a bound of the discretisation error from the two fields that prove it: admissible displacements, and a stress in
//! equilibrium with the loads and with contact tractions within the law.
//!
//! Whatever made these fields, they prove the bound if they are what they are said to be (Prager and Synge 1947; with
//! contact Coorevits, Hild and Pelle 2000). Every condition is looked at, and the bound is integrated anew. The stress is
//! linear in the four parts into which the centroid divides a cell; nothing else of how it was found is used.

mod cells;
mod sides;
mod tie;
mod vectors;

use crate::Error;
use cells::{factorised, judge_cell};
use sides::{Contact, judge_faces, judge_side};
pub use tie::judge_tie;
use vectors::{ascending, numbers};

/// Corners of the edges of a cell in the order of its middles.
const ENDS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
/// What each measure may be. Fields are found to about 1e-12.
pub const BOUND_TOLERANCE: f64 = 1e-9;
/// The fields and what they have to satisfy. Tensors are `xx yy zz xy yz xz`, strains with twice their shears.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BoundFields {
    /// Coordinates, length.
    pub nodes: Vec<[f64; 3]>,
    /// Corners of the tetrahedra.
    pub corners: Vec<[u32; 4]>,
    /// Nodes in the middles of the edges `01 02 03 12 13 23`; empty for linear cells.
    pub middles: Vec<[u32; 6]>,
    /// Of each material, force per area.
    pub stiffness: Vec<[[f64; 6]; 6]>,
    /// Of each cell.
    pub material: Vec<u32>,
    /// Strain that causes no stress, of each cell; empty if there is none.
    pub initial: Vec<[f64; 6]>,
    /// Force per volume, of each cell; empty if there is none.
    pub body_force: Vec<[f64; 3]>,
    /// What the unknowns of the problem are, in their order.
    pub unknowns: Vec<BoundUnknown>,
    /// Displacements of the answer, `3 i + c`, length.
    pub found: Vec<f64>,
    /// The admissible ones.
    pub displacement: Vec<f64>,
    /// Stress in equilibrium: in part `j` of a cell, where the centroid takes the place of corner `j`, at its four corners.
    pub stress: Vec<[[[f64; 6]; 4]; 4]>,
    /// Flat obstacles.
    pub obstacles: Vec<FlatObstacle>,
    /// All boundary faces.
    pub sides: Vec<BoundSide>,
}

/// The displacement of a node along a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundUnknown {
    /// The node.
    pub node: u32,
    /// Unit vector.
    pub direction: [f64; 3],
}

/// Places `x` with `normal · x <= offset` are out of it.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatObstacle {
    /// Unit normal towards the obstacle.
    pub normal: [f64; 3],
    /// Length.
    pub offset: f64,
}

/// A boundary face and what is given there.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundSide {
    /// Its nodes.
    pub corners: [u32; 3],
    /// Directions along which displacements are prescribed and tractions are free.
    pub held: Vec<[f64; 3]>,
    /// Traction of loads at the corners, force per area.
    pub load: [[f64; 3]; 3],
    /// Obstacles that it may touch; usually one or none.
    pub touches: Vec<Touch>,
}

/// Contact of a face. Nodes are its three corners, then the middles of the edges across from these (without meaning in linear cells).
#[derive(Debug, Clone, PartialEq)]
pub struct Touch {
    /// The obstacle.
    pub obstacle: u32,
    /// On the obstacle, at the corners, force per area.
    pub pressure: [f64; 3],
    /// The same across the normal.
    pub shear: [[f64; 3]; 3],
    /// At the corners the coefficient of friction, infinite where there is none, and the largest shear whatever the pressure.
    pub law: [[f64; 2]; 3],
    /// Distance from the obstacle at the nodes, length. It is kept as a number, as coordinates would round it.
    pub opening: [f64; 6],
    /// Slip at the nodes, length.
    pub slip: [[f64; 3]; 6],
    /// The displacement that is no slip.
    pub reference: [[f64; 3]; 6],
}

/// What the fields are said to prove.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundClaim {
    /// Bound of the energy norm of the error of the stress of the displacements; root of an energy.
    pub error: f64,
    /// The same of the mean of both stresses.
    pub mean_error: f64,
    /// Energy norm of that mean.
    pub mean_norm: f64,
    /// Least and largest energy the exact answer can have.
    pub energy: [f64; 2],
}

/// How far a condition is missed, dimensionless, and where most.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundMeasure {
    /// What is measured.
    pub name: &'static str,
    /// At most [`BOUND_TOLERANCE`] where it is met.
    pub value: f64,
    /// The cell or face.
    pub place: String,
}

impl BoundMeasure {
    /// Whether the condition is met; what is no number is not.
    pub fn is_met(&self) -> bool {
        self.value <= BOUND_TOLERANCE
    }
}

/// What the fields prove.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedBound {
    /// Integrated anew.
    pub proven: BoundClaim,
    /// All conditions.
    pub measures: Vec<BoundMeasure>,
}

impl JudgedBound {
    /// Whether all conditions are met.
    pub fn passed(&self) -> bool {
        self.measures.iter().all(BoundMeasure::is_met)
    }
}

/// Looks at every condition of the proof, and integrates the bound anew.
///
/// # Errors
/// If arrays do not fit each other, hold what is no number, cells have no volume, or a stiffness is not positive definite.
pub fn judge_bound(fields: &BoundFields, claim: &BoundClaim) -> Result<JudgedBound, Error> {
    validate(fields)?;
    let factors = fields.stiffness.iter().enumerate().map(|(i, stiffness)| factorised(stiffness, i));
    let factors = factors.collect::<Result<Vec<_>, Error>>()?;
    let mut worst = Worst::default();
    let size = fields.stress.as_flattened().as_flattened().as_flattened().iter().fold(0.0, |m: f64, s| m.max(s.abs()));
    let mut sums = Energies::default();
    for cell in 0..fields.corners.len() {
        sums.add(&judge_cell(fields, &factors, cell, size, &mut worst)?);
    }
    let outside = judge_faces(fields, size, &mut worst)?;
    let length = fields.displacement.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let (mut work, mut contact) = (sums.work, Contact::default());
    for side in &fields.sides {
        let Some(own) = outside.get(&ascending(side.corners)) else {
            let what = format!("the face with the nodes {} is no boundary face", numbers(side.corners));
            return Err(damaged(what));
        };
        work += judge_side(fields, side, own, size, length, &mut worst, &mut contact);
    }
    if fields.sides.len() != outside.len() {
        let what = format!("there are {} boundary faces, and {} are described", outside.len(), fields.sides.len());
        return Err(damaged(what));
    }
    let missed = 2.0 * (contact.normal + contact.slip);
    let largest = 0.5 * sums.found - work + contact.limits;
    let proven = BoundClaim {
        error: (sums.apart + missed).sqrt(),
        mean_error: (0.25 * sums.apart + 0.5 * missed).sqrt(),
        mean_norm: sums.mean.sqrt(),
        energy: [largest - 0.5 * (sums.apart + missed), largest],
    };
    let norm = sums.found.max(sums.balanced).sqrt();
    let energy = (norm * norm).max(work.abs());
    let mut differ = |name: &'static str, claimed: f64, own: f64, scale: f64| {
        // Zero of zero is the same.
        let off = if claimed == own { 0.0 } else { (claimed - own).abs() / scale };
        worst.see(name, off, || format!("{claimed:e} is claimed and {own:e} proven"));
    };
    differ("bound of the error", claim.error, proven.error, norm);
    differ("bound of the error of the mean stress", claim.mean_error, proven.mean_error, norm);
    differ("norm of the mean stress", claim.mean_norm, proven.mean_norm, norm);
    (0..2).for_each(|end| differ("interval of the energy", claim.energy[end], proven.energy[end], energy));
    Ok(JudgedBound { proven, measures: worst.0 })
}

/// The largest of each measure.
#[derive(Default)]
struct Worst(Vec<BoundMeasure>);

impl Worst {
    fn see(&mut self, name: &'static str, value: f64, place: impl Fn() -> String) {
        match self.0.iter_mut().find(|measure| measure.name == name) {
            None => self.0.push(BoundMeasure { name, value, place: place() }),
            // What is no number is worse than all.
            Some(known) if value > known.value || (value.is_nan() && !known.value.is_nan()) => {
                (known.value, known.place) = (value, place());
            }
            Some(_) => {}
        }
    }
}

/// Squared energy norms and the work of body forces.
#[derive(Default)]
struct Energies {
    apart: f64,
    found: f64,
    balanced: f64,
    mean: f64,
    work: f64,
}

impl Energies {
    fn add(&mut self, other: &Energies) {
        self.apart += other.apart;
        self.found += other.found;
        self.balanced += other.balanced;
        self.mean += other.mean;
        self.work += other.work;
    }
}

fn validate(fields: &BoundFields) -> Result<(), Error> {
    let (cells, nodes) = (fields.corners.len(), fields.nodes.len());
    let fits = |name: &str, found: usize, needed: usize| match found == needed {
        true => Ok(()),
        false => Err(damaged(format!("`{name}` has {found} entries in the place of {needed}"))),
    };
    let or_none = |name: &str, found: usize| if found == 0 { Ok(()) } else { fits(name, found, cells) };
    fits("material", fields.material.len(), cells)?;
    fits("stress", fields.stress.len(), cells)?;
    fits("found", fields.found.len(), 3 * nodes)?;
    fits("displacement", fields.displacement.len(), 3 * nodes)?;
    or_none("middles", fields.middles.len())?;
    or_none("initial", fields.initial.len())?;
    or_none("body_force", fields.body_force.len())?;
    let named = fields.corners.as_flattened().iter().chain(fields.middles.as_flattened());
    let named = named.chain(fields.unknowns.iter().map(|unknown| &unknown.node));
    let named = named.chain(fields.sides.iter().flat_map(|side| &side.corners));
    if let Some(node) = named.into_iter().find(|&&node| node as usize >= nodes) {
        return Err(damaged(format!("node {} is named and there are {nodes}", node + 1)));
    }
    if fields.material.iter().any(|&material| material as usize >= fields.stiffness.len()) {
        return Err(damaged("a cell has a material that does not exist".into()));
    }
    let mut touches = fields.sides.iter().flat_map(|side| &side.touches);
    if touches.any(|touch| touch.obstacle as usize >= fields.obstacles.len()) {
        return Err(damaged("a face touches an obstacle that does not exist".into()));
    }
    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    let all = [
        ("nodes", finite(fields.nodes.as_flattened())),
        ("found", finite(&fields.found)),
        ("displacement", finite(&fields.displacement)),
        ("stress", finite(fields.stress.as_flattened().as_flattened().as_flattened())),
        ("initial", finite(fields.initial.as_flattened())),
        ("body_force", finite(fields.body_force.as_flattened())),
    ];
    match all.iter().find(|(_, finite)| !finite) {
        Some((name, _)) => Err(damaged(format!("`{name}` holds what is no number"))),
        None => Ok(()),
    }
}

fn damaged(what: String) -> Error {
    Error::new("the fields of the bound", what, "solve the case again")
}
