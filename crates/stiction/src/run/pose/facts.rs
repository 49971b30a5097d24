//! What is known before anything is solved: shown to the user, who may see at once that a sign or a unit is wrong.

use super::surfaces::names;
use crate::contact::{ContactSurface, Counterpart, InterfaceStiffness, SurfaceFacts, SurfaceFriction};
use crate::fem::Material;
use crate::io::case::ContactSpec;
use crate::mesh::MeshInfo;

/// What a case amounts to on its mesh; `Display` says it in plain words.
#[derive(Debug, Clone)]
pub struct Facts {
    /// Heading of the case.
    pub title: String,
    /// Names of the units, a label only.
    pub units: Option<String>,
    /// Sizes and quality of the mesh.
    pub mesh: MeshInfo,
    /// The materials.
    pub materials: Vec<MaterialFacts>,
    /// Prescribed displacements.
    pub fixes: Vec<FixFacts>,
    /// Elastic foundations.
    pub springs: Vec<SpringFacts>,
    /// Loads.
    pub loads: Vec<LoadFacts>,
    /// Bolts.
    pub bolts: Vec<BoltFacts>,
    /// Reference points.
    pub couplings: Vec<CouplingFacts>,
    /// Cyclic symmetries.
    pub cyclic: Vec<CyclicFacts>,
    /// Contact surfaces.
    pub contacts: Vec<ContactFacts>,
    /// Increments of the load steps and the time they end at, for which the loads are given; none without load steps.
    pub steps: Option<(usize, f64)>,
    /// Unknown displacements.
    pub unknowns: usize,
    /// Equations, and how many displacements they hold.
    pub equations: Option<[usize; 2]>,
    /// Contact points.
    pub points: usize,
    /// What is probably not what was meant, one sentence each.
    pub warnings: Vec<String>,
    /// What a person should know and did not ask, one sentence each.
    pub notes: Vec<String>,
}

/// A material and how much of the body is made of it.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialFacts {
    /// Its name.
    pub name: String,
    /// Young's modulus, force per area; the largest of an orthotropic one.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// `E1, E2, E3; nu12, nu13, nu23; G12, G13, G23` where they depend on the direction.
    pub orthotropic: Option<[[f64; 3]; 3]>,
    /// Mass per volume.
    pub density: f64,
    /// Number of its cells.
    pub cells: usize,
    /// Their volume, length cubed.
    pub volume: f64,
}

impl MaterialFacts {
    /// Of a material of which no cell is known yet.
    pub(crate) fn of(material: &Material) -> Self {
        let Material { name, young, poisson, density, .. } = material.clone();
        let orthotropic = material.orthotropic.as_ref().map(|it| [it.young, it.poisson, it.shear]);
        MaterialFacts { name, young, poisson, orthotropic, density, cells: 0, volume: 0.0 }
    }

    /// Counts cells of this volume.
    pub(crate) fn add(&mut self, cells: usize, volume: f64) {
        self.cells += cells;
        self.volume += volume;
    }
}

/// Prescribed displacements.
#[derive(Debug, Clone, PartialEq)]
pub struct FixFacts {
    /// Where, as the case says it.
    pub on: String,
    /// Number of nodes.
    pub nodes: usize,
    /// The components held, such as `xz`, or the direction, such as `along (0.6, 0.8, 0)`.
    pub components: String,
    /// Where the node is that was nearest to the point asked for.
    pub at: Option<[f64; 3]>,
}

/// Nodes that move with a reference point.
#[derive(Debug, Clone, PartialEq)]
pub struct CouplingFacts {
    /// Its name.
    pub name: String,
    /// Where, as the case says it.
    pub on: String,
    /// Number of nodes.
    pub nodes: usize,
    /// The reference point, length.
    pub point: [f64; 3],
    /// Whether it moves as the faces do in the mean; else the nodes are rigid.
    pub distributing: bool,
    /// Force at the point at the end, newton.
    pub force: [f64; 3],
}

/// An elastic foundation.
#[derive(Debug, Clone, PartialEq)]
pub struct SpringFacts {
    /// Where, as the case says it.
    pub on: String,
    /// Area it covers, length squared.
    pub area: f64,
    /// Stiffness per area.
    pub normal: f64,
    /// Tangential stiffness per area.
    pub tangential: f64,
}

/// A load.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadFacts {
    /// Where, as the case says it.
    pub on: String,
    /// `traction`, `gravity` and so on.
    pub kind: &'static str,
    /// Area it acts on or, of gravity, rotation and temperature, volume.
    pub extent: f64,
    /// The force it adds up to.
    pub resultant: [f64; 3],
    /// Lowest and highest value of a temperature.
    pub range: Option<[f64; 2]>,
}

/// A bolt that is tightened.
#[derive(Debug, Clone, PartialEq)]
pub struct BoltFacts {
    /// Its name.
    pub name: String,
    /// Unit vector.
    pub axis: [f64; 3],
    /// Nodes of the cut and cells beyond it.
    pub nodes: usize,
    /// Number of cells at its cut.
    pub cells: usize,
    /// Force or shortening at the time for which the loads are given.
    pub by: &'static str,
    /// Force (newton) or shortening (length) at the time of the facts.
    pub value: f64,
}

/// A cyclic symmetry.
#[derive(Debug, Clone, PartialEq)]
pub struct CyclicFacts {
    /// What the case calls the cut that follows and the one it follows.
    pub cuts: [String; 2],
    /// Nodes of a cut.
    pub nodes: usize,
    /// Sectors of the whole.
    pub sectors: usize,
}

/// A contact pair.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactFacts {
    /// What was found on the surface in `on`.
    pub surface: SurfaceFacts,
    /// What it may touch.
    pub against: Counterpart,
    /// What the case calls the surface and, for a pair, its counterpart.
    pub names: [String; 2],
    /// The law of friction.
    pub friction: SurfaceFriction,
    /// How the interface yields; hard contact if `None`.
    pub stiffness: Option<InterfaceStiffness>,
    /// Archard's coefficient of wear, 1/stress.
    pub wear: Option<f64>,
}

impl ContactFacts {
    /// What was `found` on a surface of this contact of the case.
    pub(crate) fn new(found: SurfaceFacts, surface: &ContactSurface, spec: &ContactSpec) -> Self {
        let (against, names, friction) = (surface.against.clone(), names(spec), surface.friction.clone());
        ContactFacts { surface: found, against, names, friction, stiffness: surface.stiffness, wear: spec.wear }
    }
}

impl Facts {
    /// The force all loads add up to.
    pub fn resultant(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        let all = self.loads.iter().map(|load| load.resultant).chain(self.couplings.iter().map(|it| it.force));
        all.for_each(|force| (0..3).for_each(|c| sum[c] += force[c]));
        sum
    }
}
