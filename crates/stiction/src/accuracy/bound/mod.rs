//! A bound of the discretisation error: not an estimate, but a number the error is proven not to exceed.
//!
//! Let the displacements `v` be admissible (as prescribed, not in the obstacle) and the stress `τ` in equilibrium with the
//! loads and with contact tractions `p = -τ_n >= 0`, `|q| <= s`, where `s` is the given limit of friction and `w` what is no
//! slip. Then (Prager and Synge 1947; with contact Coorevits, Hild and Pelle 2000)
//!
//! ```text
//! |u - v|² + |σ - τ|²  <=  |τ - C ε(v)|² + 2 ∫ p (g - v_n) + 2 ∫ (s |v_t - w| - q·(v_t - w))  =  η²
//! ```
//! in the energy norm, without any constant. The energy of the continuum lies between that of `v` and `η²/2` below it, and
//! half the sum of both stresses, `(C ε(v) + τ)/2`, is off by at most the root of `|τ - C ε(v)|²/4` and half of the
//! other terms.
//!
//! [`bound`] makes `τ`: contact tractions within the law from the contact forces (`contact.rs`); displacements that are in equilibrium with
//! these for all test functions that are linear in the cells (`linear.rs`); tractions on all faces with which every cell is in equilibrium (`equilibrate.rs`); a stress in each cell from
//! them (`fill.rs`); and less energy by tractions that leave every cell in equilibrium (`sharpen.rs`).
//!
//! The proof needs straight tetrahedra, flat obstacles, tractions that are linear on faces, and forces and strains that are
//! constant in cells. Coulomb friction has no given limits: there the limits found are taken, and the bound is that of the
//! problem with these.

// Small dense blocks are read by their indices.
#![allow(clippy::needless_range_loop)]

mod contact;
mod equilibrate;
mod fields;
mod fill;
mod linear;
mod modes;
mod sharpen;
mod tets;

use std::collections::{HashMap, HashSet};
use std::fmt;

use rayon::prelude::*;

use crate::Error;
use crate::certificate::{BoundClaim, BoundFields};
use crate::fem::{DofMap, Solid, Voigt};
use crate::linalg::max_abs;
use crate::mesh::v3::{V3, add, dot, scale, sub};
use contact::{Bearing, Surface};
use equilibrate::{Given, OnFace, complement, equilibrate};
use fields::fields;
use fill::{Map, Sides, compliance, mean_stress};
pub use linear::LinearSystem;
use sharpen::sharpen;
use tets::{CELLS_PER_TASK, NONE, Shape, Tets, traction, without};

/// What acts on a body, as far as a bound needs it, and the answer that is judged.
#[derive(Debug, Clone, Copy)]
pub struct Acting<'a> {
    /// Displacements found, along x, y, z, `3 i + c` for node `i`, length.
    pub displacement: &'a [f64],
    /// Which of them are prescribed.
    pub dofs: &'a DofMap,
    /// Strain that causes no stress, constant in each cell; empty if there is none.
    pub initial: &'a [Voigt],
    /// Force per volume, constant in each cell; empty if there is none.
    pub body_force: &'a [V3],
    /// Tractions on boundary faces (numbers of the mesh), force per area at the three corners in the order of
    /// [`Face::corners`](crate::mesh::Face::corners); those of a face that is named several times add up.
    pub loads: &'a [(u32, [V3; 3])],
    /// Boundary faces whose displacement along a unit vector is prescribed, each with one direction.
    pub held: &'a [(u32, V3)],
    /// Contact with flat obstacles.
    pub contacts: &'a [FlatContact],
    /// Rigid motions that contact alone resists, as displacements of all nodes; any scale.
    pub motions: &'a [Vec<f64>],
}

/// A surface that may touch a flat obstacle.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatContact {
    /// Boundary faces, by number.
    pub faces: Vec<u32>,
    /// Unit normal towards the obstacle.
    pub normal: [f64; 3],
    /// Where the obstacle is: places `x` with `normal · x <= offset` are out of it, length.
    pub offset: f64,
    /// All nodes of the faces, in ascending order.
    pub nodes: Vec<ContactNode>,
}

/// A node of a contact surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactNode {
    /// Its number.
    pub node: u32,
    /// The force of the body on the obstacle there, newton; `None` where supports take it and there is no contact point.
    pub force: Option<[f64; 3]>,
    /// How much shear friction allows.
    pub limit: Limit,
    /// The displacement that is no slip: that of the obstacle and earlier slip, length.
    pub reference: [f64; 3],
}

/// The largest shear, force per area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// No friction.
    None,
    /// Given.
    Given(f64),
    /// The coefficient of friction times the pressure.
    Coulomb(f64),
    /// The smaller of both.
    Limited {
        /// The coefficient of friction.
        coefficient: f64,
        /// The largest shear whatever the pressure.
        most: f64,
    },
}

impl Limit {
    fn at(self, pressure: f64) -> f64 {
        match self {
            Limit::None => 0.0,
            Limit::Given(most) => most,
            Limit::Coulomb(coefficient) => coefficient * pressure,
            Limit::Limited { coefficient, most } => most.min(coefficient * pressure),
        }
    }
}

/// What a bound is a bound of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// The error.
    Proven,
    /// The distance from the answer with the friction limits that were computed.
    ProvenAtLimits,
}

/// A bound of the discretisation error.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// What it is a bound of.
    pub standing: Standing,
    /// Bound of the energy norm of the error of the stress of the displacements; root of an energy.
    pub error: f64,
    /// The same of the mean of that stress and of the stress in equilibrium.
    pub mean_error: f64,
    /// Energy norm of that mean stress.
    pub mean_norm: f64,
    /// Least and largest energy the exact answer can have: elastic energy less the work of the loads, with friction plus
    /// limits times slips.
    pub energy: [f64; 2],
    /// The part of the squared bound that is the distance of the two stresses; energy.
    pub apart2: f64,
    /// What tractions and openings miss of each other, and shears and slips; energies, parts of the squared bound.
    pub contact2: [f64; 2],
    /// The first part as it would be without sharpening; energy.
    pub unsharpened2: f64,
    /// Mean of the mean stress over each cell.
    pub mean_stress: Vec<Voigt>,
    /// The admissible displacements, those found but for rounding and overlap, and the stress in equilibrium.
    pub fields: BoundFields,
}

impl Bound {
    /// What [`judge_bound`](crate::certificate::judge_bound) holds against the fields.
    pub fn claim(&self) -> BoundClaim {
        let Bound { error, mean_error, mean_norm, energy, .. } = *self;
        BoundClaim { error, mean_error, mean_norm, energy }
    }

    /// The bound over the least energy norm the exact stress can have; 1 or more where nothing is known of it.
    pub fn relative(&self) -> f64 {
        self.over_norm(self.error)
    }

    /// The same for the mean stress.
    pub fn mean_relative(&self) -> f64 {
        self.over_norm(self.mean_error)
    }

    fn over_norm(&self, error: f64) -> f64 {
        let least = self.mean_norm - self.mean_error;
        match error {
            0.0 => 0.0,
            _ if least > 0.0 => error / least,
            _ => f64::INFINITY,
        }
    }
}

/// Why there is no bound.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum NoBound {
    /// Cells that are no tetrahedra.
    Hexahedra,
    /// Linear and quadratic cells in one mesh.
    MixedOrders,
    /// Tetrahedra with curved edges.
    CurvedCells,
    /// Faces of a contact surface with some displacements prescribed.
    HeldContact,
    /// A contact surface between bodies, or against an obstacle that is not flat.
    Counterpart {
        /// Its name.
        name: String,
        /// What it is.
        what: &'static str,
    },
    /// Something that acts on the body and has no place in the proof.
    Load {
        /// What it is.
        what: String,
    },
    /// A support that has a reaction but no area.
    Reaction {
        /// The node.
        node: u32,
        /// The reaction, newton.
        force: f64,
    },
    /// A node in its obstacle that cannot be moved out.
    Overlap {
        /// The node.
        node: u32,
        /// How deep, length.
        depth: f64,
    },
    /// Several contact surfaces hold a node where not all can have it.
    Contradiction,
    /// A body that contact alone holds, by tractions that could not be balanced within the law.
    Floating,
    /// Hundreds of cells around one node, or cells without volume.
    Degenerate,
    /// The linear system of the elastic bodies was not solved.
    Unsolved(Error),
}

impl fmt::Display for NoBound {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            NoBound::Hexahedra => write!(f, "the mesh has hexahedra or wedges; the proof needs tetrahedra"),
            NoBound::MixedOrders => write!(f, "the mesh has linear and quadratic cells"),
            NoBound::CurvedCells => write!(f, "cells are curved; the proof needs straight ones"),
            NoBound::HeldContact => write!(f, "faces of a contact surface have prescribed displacements"),
            NoBound::Counterpart { name, what } => {
                write!(f, "contact \"{name}\" is {what}; the proof needs flat obstacles")
            }
            NoBound::Load { what } => write!(f, "{what} has no place in the proof"),
            NoBound::Reaction { node, force } => {
                write!(f, "node {} is held without an area, with a reaction of {force:.3e}", node + 1)
            }
            NoBound::Overlap { node, depth } => {
                write!(f, "node {} is {depth:.3e} in its obstacle and cannot be moved out", node + 1)
            }
            NoBound::Contradiction => write!(f, "several contact surfaces hold one node where not all can have it"),
            NoBound::Floating => write!(
                f,
                "a body is held by contact alone, and its tractions were not balanced within the law of friction"
            ),
            NoBound::Degenerate => write!(f, "cells are flat, or hundreds of them meet at one node"),
            NoBound::Unsolved(error) => write!(f, "the elastic problem was not solved: {}", error.what),
        }
    }
}

/// What is given on a boundary face.
#[derive(Debug, Clone, PartialEq)]
struct Side {
    /// Orthonormal directions along which the displacement is prescribed and the traction is not known.
    directions: Vec<V3>,
    /// Traction times area at the corners, across those directions.
    forces: OnFace,
}

impl Side {
    /// The part of a vector along the directions.
    fn along(&self, v: V3) -> V3 {
        self.directions.iter().fold([0.0; 3], |sum, &d| add(sum, scale(dot(d, v), d)))
    }
}

/// Steps of sharpening at most.
const STEPS: usize = 40;
/// Forces that may be left of the linear solve, as part of the largest.
const RESIDUAL: f64 = 1e-12;
/// Forces that neither loads nor contact nor supports explain, as part of the largest: more is no error of a solver.
const UNKNOWN: f64 = 1e-5;
/// Solves with the elastic matrix at most; each takes the residual of those before.
const SOLVES: usize = 4;

/// Answers forces on the unknowns of a system, newton, by displacements, length. The system is the same each time.
pub type Solver<'a> = dyn FnMut(&LinearSystem, &[f64]) -> Result<Vec<f64>, Error> + 'a;

/// A bound of the discretisation error of a solution of elastic contact.
///
/// `solve` answers forces on corners by displacements of the elastic bodies without
/// contact. Where `acting.motions` names some these forces balance, and any displacements will do that they determine but for these. It is asked up to four times, for ever smaller forces, and a few digits each time are enough. The result does not
/// depend on the number of threads.
///
/// # Errors
/// [`NoBound`] where the proof does not hold.
///
/// # Panics
/// If the lengths of `acting` do not fit the mesh.
pub fn bound(solid: &Solid, acting: &Acting, solve: &mut Solver) -> Result<Bound, NoBound> {
    assert_eq!(acting.displacement.len(), 3 * solid.mesh.nodes.len());
    assert!(acting.initial.is_empty() || acting.initial.len() == solid.mesh.cell_count());
    assert!(acting.body_force.is_empty() || acting.body_force.len() == solid.mesh.cell_count());
    let tets = Tets::new(solid)?;
    let mut v = acting.displacement.to_vec();
    let held = held_directions(&tets, acting);
    let mut surfaces = surfaces(&tets, acting, &held, &mut v)?;
    let outer = tets.outer_forces(acting);
    contact::balance(&tets, &mut surfaces, acting.motions, &outer)?;
    let given = given(&tets, acting, &held, &surfaces);
    let shapes: Vec<Shape> = collect(&tets, |cell| tets.shape(cell));
    if shapes.iter().any(|shape| !(shape.volume > 0.0 && shape.volume.is_finite())) {
        return Err(NoBound::Degenerate);
    }
    let balanced = balanced(&tets, acting, &given, &surfaces, &outer, &shapes, solve)?;
    let compliances: Vec<[Voigt; 6]> =
        solid.materials.iter().map(|material| compliance(&crate::fem::elements::Law::new(material))).collect();
    let stress = collect(&tets, |cell| tets.stress(cell, &shapes[cell], &balanced, acting.initial));
    let mut tractions = equilibrate(&tets, &given, &shapes, &stress, acting.body_force)?;
    let found = collect(&tets, |cell| tets.stress(cell, &shapes[cell], &v, acting.initial));
    let judge = Judge { tets: &tets, shapes: &shapes, compliances: &compliances, found: &found };
    let unsharpened2: f64 = collect(&tets, |cell| judge.apart2(cell, &tractions)).iter().sum();
    let apart = |cell: usize, tractions: &[OnFace]| apart(&tets, cell, &shapes[cell], &stress[cell], tractions);
    let unsharpened = tractions.clone();
    let bearings = bearings(&tets, acting, &surfaces);
    let all = bearings.iter().flatten().cloned().collect();
    sharpen(&tets, &given, all, &shapes, &compliances, &apart, &mut tractions, unsharpened2, STEPS);
    let mut cells = judge.cells(&tractions);
    let total = |cells: &[OfCell]| cells.iter().map(|cell| cell.apart2).sum::<f64>();
    // Rounding may leave more than there was where there is nothing to gain.
    if total(&cells).is_nan() || total(&cells) > unsharpened2 {
        tractions = unsharpened;
        cells = judge.cells(&tractions);
    }
    for (surface, own) in surfaces.iter_mut().zip(&bearings) {
        own.iter().for_each(|bearing| surface.take(&tets, bearing, &tractions[bearing.face as usize]));
    }
    let gaps = surfaces.iter().map(|surface| surface.gaps(&tets));
    let gaps = gaps.fold([0.0; 3], add);
    let apart2 = total(&cells);
    let contact2 = [2.0 * gaps[0], 2.0 * gaps[1]];
    let contact = contact2[0] + contact2[1];
    let of = |part: &dyn Fn(&OfCell) -> f64| cells.iter().map(part).sum::<f64>();
    let (found2, balanced2) = (of(&|cell| cell.found2), of(&|cell| cell.balanced2));
    let work: f64 = outer.iter().zip(&v).map(|(f, v)| f * v).sum();
    let largest = 0.5 * found2 - work + gaps[2];
    let follows =
        |node: &ContactNode| matches!(node.limit, Limit::Coulomb(f) | Limit::Limited { coefficient: f, .. } if f > 0.0);
    let at_limits = acting.contacts.iter().any(|contact| contact.nodes.iter().any(follows));
    Ok(Bound {
        standing: if at_limits { Standing::ProvenAtLimits } else { Standing::Proven },
        error: (apart2 + contact).sqrt(),
        mean_error: (0.25 * apart2 + 0.5 * contact).sqrt(),
        mean_norm: (0.5 * found2 + 0.5 * balanced2 - 0.25 * apart2).max(0.0).sqrt(),
        energy: [largest - 0.5 * (apart2 + contact), largest],
        apart2,
        contact2,
        unsharpened2,
        mean_stress: cells.iter().map(|cell| cell.mean).collect(),
        fields: fields(&tets, acting, &surfaces, &held, &shapes, &tractions, v),
    })
}

/// What `of` says of each cell.
fn collect<T: Send>(tets: &Tets, of: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    (0..tets.corners.len()).into_par_iter().with_min_len(CELLS_PER_TASK).map(of).collect()
}

/// Orthonormal directions along which faces are held.
fn held_directions(tets: &Tets, acting: &Acting) -> Vec<Vec<V3>> {
    let mut named: Vec<Vec<V3>> = vec![Vec::new(); tets.faces.len()];
    acting.held.iter().for_each(|&(face, d)| named[tets.of_boundary[face as usize] as usize].push(d));
    let span = |directions: Vec<V3>| match directions.is_empty() {
        true => directions,
        // Across what is across them.
        false => complement(&complement(&directions)),
    };
    named.into_iter().map(span).collect()
}

fn surfaces<'a>(
    tets: &Tets,
    acting: &Acting<'a>,
    held: &[Vec<V3>],
    v: &mut [f64],
) -> Result<Vec<Surface<'a>>, NoBound> {
    let mut surfaces = Vec::new();
    for contact in acting.contacts {
        let mut faces = Vec::with_capacity(contact.faces.len());
        for &face in &contact.faces {
            let face = tets.of_boundary[face as usize];
            match held[face as usize].len() {
                0 => faces.push(face),
                // Held altogether: contact asks nothing of it.
                3 => {}
                _ => return Err(NoBound::HeldContact),
            }
        }
        surfaces.push(Surface::new(tets, acting.dofs, contact, faces, v)?);
    }
    if !surfaces.iter().all(|surface| surface.still_open(tets, v)) {
        return Err(NoBound::Contradiction);
    }
    surfaces.iter_mut().for_each(|surface| surface.find_tractions(tets));
    Ok(surfaces)
}

/// Of each surface the faces on which contact tractions may change: where no load acts, and no other surface touches.
fn bearings(tets: &Tets, acting: &Acting, surfaces: &[Surface]) -> Vec<Vec<Bearing>> {
    let mut named: HashMap<u32, u32> = HashMap::new();
    let loaded = acting.loads.iter().map(|&(face, _)| tets.of_boundary[face as usize]);
    let touching = surfaces.iter().flat_map(|surface| surface.faces.iter().copied());
    loaded.chain(touching).for_each(|face| *named.entry(face).or_default() += 1);
    let own =
        |surface: &Surface| surface.bearings(tets).into_iter().filter(|bearing| named[&bearing.face] == 1).collect();
    surfaces.iter().map(own).collect()
}

/// What is known on each face.
fn given(tets: &Tets, acting: &Acting, held: &[Vec<V3>], surfaces: &[Surface]) -> Given {
    let boundary = |face: usize| tets.cells_of[face][1] == NONE;
    let side = |face: usize| Side { directions: held[face].clone(), forces: [[0.0; 3]; 3] };
    let mut sides: Vec<Option<Side>> = (0..tets.faces.len()).map(|face| boundary(face).then(|| side(face))).collect();
    let mut add_to = |face: u32, tractions: [V3; 3]| {
        let area = tets.area(face);
        if let Some(side) = &mut sides[face as usize] {
            for (sum, traction) in side.forces.iter_mut().zip(tractions) {
                *sum = add(*sum, scale(area, traction));
            }
        }
    };
    for &(face, at_corners) in acting.loads {
        let own = tets.of_boundary[face as usize];
        add_to(own, tets.in_order(face, at_corners));
    }
    for surface in surfaces {
        for &face in &surface.faces {
            add_to(face, tets.faces[face as usize].map(|node| scale(-1.0, surface.on_obstacle(node))));
        }
    }
    for side in sides.iter_mut().flatten().filter(|side| !side.directions.is_empty()) {
        side.forces = side.forces.map(|force| sub(force, side.along(force)));
    }
    Given { side: sides }
}

/// The displacements found, changed by some that are linear in the cells so that their stress is in equilibrium with loads and contact
/// tractions for all test functions of that kind; forces of ties and supports stay as they are. Which change it is does not matter much: the tractions
/// of cells that are made of the stress are as near as can be to that of the displacements found in the end.
fn balanced(
    tets: &Tets,
    acting: &Acting,
    given: &Given,
    surfaces: &[Surface],
    outer: &[f64],
    shapes: &[Shape],
    solve: &mut Solver,
) -> Result<Vec<f64>, NoBound> {
    let mut forces = outer.to_vec();
    surfaces.iter().for_each(|surface| surface.add_forces(tets, &mut forces));
    let in_contact: HashSet<u32> = surfaces.iter().flat_map(|surface| surface.nodes(tets)).collect();
    let dofs = acting.dofs;
    // Nodes held in part have reactions that no face need carry.
    let free = |node: u32| (0..3).all(|c| dofs.unknown[(3 * node + c) as usize] != u32::MAX);
    let mut u = acting.displacement.to_vec();
    let mut system = None;
    for round in 0..SOLVES {
        let inner = tets.inner_forces(&u, acting.initial);
        let size = max_abs(&inner).max(max_abs(&forces));
        let mut rest: Vec<f64> = forces.iter().zip(&inner).map(|(f, i)| f - i).collect();
        leave_to_supports(tets, given, &mut rest);
        let unknown = |(i, rest): &(usize, &f64)| !in_contact.contains(&(*i as u32 / 3)) && rest.abs() > UNKNOWN * size;
        if round == 0 && rest.iter().enumerate().any(|at| unknown(&at) && free(at.0 as u32 / 3)) {
            return Err(NoBound::Load { what: "something that acts on the bodies".into() });
        }
        linear::to_corners(tets, &mut rest);
        dofs.to_components(&mut rest);
        let system = match &mut system {
            Some(system) => system,
            none => none.insert(LinearSystem::new(tets, shapes, dofs)?),
        };
        let dof = |i: &u32| dofs.free[*i as usize] as usize;
        let rest: Vec<f64> = system.unknowns.iter().map(|i| rest[dof(i)]).collect();
        if max_abs(&rest) <= RESIDUAL * size {
            break;
        }
        let change = solve(system, &rest).map_err(NoBound::Unsolved)?;
        let mut all = vec![0.0; u.len()];
        system.unknowns.iter().zip(change).for_each(|(i, value)| all[dof(i)] = value);
        dofs.to_vectors(&mut all);
        linear::to_middles(tets, &mut all);
        u.iter_mut().zip(all).for_each(|(u, change)| *u += change);
    }
    Ok(u)
}

/// Takes out the forces along directions in which the faces at a node are held.
fn leave_to_supports(tets: &Tets, given: &Given, forces: &mut [f64]) {
    for (face, side) in given.side.iter().enumerate() {
        let Some(side) = side.as_ref().filter(|side| !side.directions.is_empty()) else { continue };
        let middles = if tets.quadratic() { tets.middles_of(face as u32).to_vec() } else { Vec::new() };
        for node in tets.faces[face].into_iter().chain(middles) {
            let own = &mut forces[3 * node as usize..][..3];
            let along = side.along([own[0], own[1], own[2]]);
            own.iter_mut().zip(along).for_each(|(force, along)| *force -= along);
        }
    }
}

/// Tractions times area out of a cell.
fn out_of(tets: &Tets, cell: usize, tractions: &[OnFace]) -> Sides {
    tets.faces_of[cell].map(|face| {
        let sign = tets.sign(cell, face);
        tractions[face as usize].map(|t| scale(sign, t))
    })
}

/// The same of a stress that is linear between the corners.
fn of_stress(cell: &[Voigt; 4], shape: &Shape) -> Sides {
    std::array::from_fn(|j| {
        // The gradient of a corner's function points into the cell from the face across.
        let area = scale(-3.0 * shape.volume, shape.gradient[j]);
        without(&[0, 1, 2, 3], j).map(|node| traction(&cell[node as usize], area))
    })
}

/// The difference of both.
fn apart(tets: &Tets, cell: usize, shape: &Shape, stress: &[Voigt; 4], tractions: &[OnFace]) -> Sides {
    let (mut sides, found) = (out_of(tets, cell, tractions), of_stress(stress, shape));
    for (side, found) in sides.iter_mut().zip(found) {
        side.iter_mut().zip(found).for_each(|(t, found)| *t = sub(*t, found));
    }
    sides
}

/// Energies of the stresses of a cell.
struct OfCell {
    apart2: f64,
    found2: f64,
    balanced2: f64,
    mean: Voigt,
}

/// Squared energy norm of a stress that is linear between its values at the corners of a cell.
fn linear_energy(shape: &Shape, stress: &[Voigt; 4], compliance: &[Voigt; 6]) -> f64 {
    let form = |s: &Voigt| -> f64 { (0..6).map(|k| s[k] * (0..6).map(|l| compliance[k][l] * s[l]).sum::<f64>()).sum() };
    let total: Voigt = std::array::from_fn(|k| stress.iter().map(|s| s[k]).sum());
    shape.volume / 20.0 * (stress.iter().map(form).sum::<f64>() + form(&total))
}

struct Judge<'a> {
    tets: &'a Tets<'a>,
    shapes: &'a [Shape],
    compliances: &'a [[Voigt; 6]],
    /// Stress of the admissible displacements.
    found: &'a [[Voigt; 4]],
}

impl Judge<'_> {
    fn compliance(&self, cell: usize) -> &[Voigt; 6] {
        &self.compliances[self.tets.solid.material_of_cell[cell] as usize]
    }

    fn apart2(&self, cell: usize, tractions: &[OnFace]) -> f64 {
        let (shape, found) = (&self.shapes[cell], &self.found[cell]);
        Map::new(shape).energy(&apart(self.tets, cell, shape, found, tractions), self.compliance(cell))
    }

    fn cells(&self, tractions: &[OnFace]) -> Vec<OfCell> {
        collect(self.tets, |cell| {
            let (shape, found) = (&self.shapes[cell], &self.found[cell]);
            let compliance = self.compliance(cell);
            let balanced = out_of(self.tets, cell, tractions);
            let of_balanced = mean_stress(shape, &balanced);
            let mean = |k: usize| 0.5 * (0.25 * found.iter().map(|s| s[k]).sum::<f64>() + of_balanced[k]);
            OfCell {
                apart2: self.apart2(cell, tractions),
                found2: linear_energy(shape, found, compliance),
                balanced2: Map::new(shape).energy(&balanced, compliance),
                mean: std::array::from_fn(mean),
            }
        })
    }
}
