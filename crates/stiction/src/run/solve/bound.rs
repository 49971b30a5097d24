//! A proven bound of the discretisation error of an answer.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::accuracy::bound::{Acting, Bound, ContactNode, FlatContact, Limit, LinearSystem, NoBound, Standing, bound};
use crate::contact::rigid::RigidMotions;
use crate::contact::{Contact, ContactProblem, Counterpart, Obstacle, SurfaceFriction};
use crate::fem::{Field, Fix, Load, Solid, Temperature, constant_body_force, full_displacement, linear_tractions};
use crate::friction::{Multigrid, Status};
use crate::linalg::{Cholesky, Csr, NodeGraph, Stop, SymmetricCsr, nested_dissection_until, plan};
use crate::mesh::v3::{V3, add, dot, scale, sub, unit};
use crate::mesh::{CellKind, Mesh};
use crate::run::pose::frames::frames;
use crate::run::pose::load_state::translations;
use crate::run::pose::loads::TIME;
use crate::run::pose::{Prepared, frames::PointFrame, stopwatch};
use crate::run::solve::Outcome;

/// Below so many unknowns a factor is as fast as multigrid.
const SMALL: usize = 10_000;
/// Digits of one elastic solve: what is left is solved for again.
const TOLERANCE: f64 = 1e-6;
/// Prescribed displacements that differ from linear ones by less than this part of the largest are linear.
const LINEAR: f64 = 1e-9;

/// Bounds the discretisation error of an answer: proven for straight tetrahedra against flat obstacles, without friction or
/// with given friction; with Coulomb friction for the limits found.
///
/// The answer has to be that of the loads that `prepared` holds, those of the last step that was solved. The elastic system
/// is solved once more for the displacements of corners, by a Cholesky factor below 10,000 of these and otherwise by conjugate gradients with multigrid.
///
/// # Errors
/// [`NoBound`] says why there is none.
pub fn error_bound(prepared: &Prepared, outcome: &Outcome) -> Result<Bound, NoBound> {
    error_bound_until(prepared, &outcome.solution.u, &outcome.solution.lambda, &Stop::never())
}

/// The same for displacements of the unknowns and contact forces, until `stop` asks to end.
pub(crate) fn error_bound_until(prepared: &Prepared, u: &[f64], lambda: &[f64], stop: &Stop) -> Result<Bound, NoBound> {
    let Prepared { mesh, materials, material_of_cell, model, loading, problem, .. } = prepared;
    let solid = Solid { mesh, materials, material_of_cell };
    if mesh.cells.iter().any(|block| !matches!(block.kind, CellKind::Tet4 | CellKind::Tet10)) {
        return Err(NoBound::Hexahedra);
    }
    if model.springs.is_some() {
        return Err(NoBound::Load { what: "an elastic foundation".into() });
    }
    if prepared.surfaces.iter().any(|surface| surface.stiffness.is_some()) {
        return Err(NoBound::Load { what: "an interface that yields".into() });
    }
    if loading.is_stressed() {
        return Err(NoBound::Load { what: "an initial stress of an interface".into() });
    }
    if !loading.bolts.is_empty() {
        return Err(NoBound::Load { what: "a bolt".into() });
    }
    let t = loading.steps.last().map_or(TIME, |step| step.until);
    let Loads { tractions, body_force } = loads(prepared, &solid, t)?;
    let mut displacement = full_displacement(model, u);
    let mut held = Vec::new();
    for fix in &loading.fixes {
        held.extend(held_faces(mesh, fix, t)?);
    }
    let motions: Vec<Vec<f64>> = (0..prepared.motions.len())
        .map(|k| {
            let (mut of_unknowns, mut alpha) = (vec![0.0; problem.unknowns()], vec![0.0; prepared.motions.len()]);
            alpha[k] = 1.0;
            prepared.motions.add(&alpha, &mut of_unknowns);
            let mut all = vec![0.0; displacement.len()];
            model.dofs.free.iter().zip(of_unknowns).for_each(|(&dof, value)| all[dof as usize] = value);
            model.dofs.to_vectors(&mut all);
            all
        })
        .collect();
    let contacts = contacts(prepared, &mut displacement, lambda, t, &mut held)?;
    let acting = Acting {
        displacement: &displacement,
        dofs: &model.dofs,
        initial: &loading.initial.strain,
        body_force: &body_force,
        loads: &tractions,
        held: &held,
        contacts: &contacts,
        motions: &motions,
    };
    let mut elastic = Elastic { problem, motions: &prepared.motions, stop, operator: None };
    bound(&solid, &acting, &mut |system, forces| elastic.solve(system, forces))
}

/// A bound of the discretisation error, for scripts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoundRecord {
    /// `proven`, `proven at the friction limits found`, or `none`.
    pub standing: String,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Bound of the energy norm of the error of the stresses, over the least norm the exact stress can have.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// The same of the mean stress in `result.vtu`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_error: Option<f64>,
    /// The energies the exact answer can have, see [`Bound::energy`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<[f64; 2]>,
}

impl BoundRecord {
    /// The record of a bound or of its absence.
    pub(crate) fn of(bound: &Result<Bound, NoBound>) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        match bound {
            Ok(bound) => BoundRecord {
                standing: in_words(bound.standing).into(),
                reason: None,
                error: finite(bound.relative()),
                mean_error: finite(bound.mean_relative()),
                energy: Some(bound.energy),
            },
            Err(why) => {
                let (error, mean_error, energy) = Default::default();
                BoundRecord { standing: "none".into(), reason: Some(why.to_string()), error, mean_error, energy }
            }
        }
    }
}

/// What a bound is worth, in words.
pub(crate) fn in_words(standing: Standing) -> &'static str {
    match standing {
        Standing::Proven => "proven",
        Standing::ProvenAtLimits => "proven at the friction limits found",
    }
}

/// Adds a bound of the discretisation error to an answer, or why there is none; its time is part of the output.
pub fn add_bound(prepared: &Prepared, outcome: &mut Outcome, stop: &Stop) {
    let mut lap = stopwatch();
    let bound = match outcome.solution.status {
        Status::Solved => error_bound_until(prepared, &outcome.solution.u, &outcome.solution.lambda, stop),
        _ => Err(NoBound::Load { what: "an answer that is not certified".into() }),
    };
    outcome.bound = Some(bound);
    outcome.seconds.output = outcome.seconds.output + lap();
}

fn failed(error: Error) -> NoBound {
    NoBound::Unsolved(error)
}

struct Loads {
    tractions: Vec<(u32, [V3; 3])>,
    body_force: Vec<V3>,
}

/// All loads as tractions that are linear on faces and forces that are constant in cells.
fn loads(prepared: &Prepared, solid: &Solid, t: f64) -> Result<Loads, NoBound> {
    let mut all = Loads { tractions: Vec::new(), body_force: Vec::new() };
    if !prepared.loading.ties.is_empty() {
        let what = "an equation between displacements of nodes or a support that is released".into();
        return Err(NoBound::Load { what });
    }
    for load in &prepared.loading.loads {
        let what = match load {
            Load::Temperature {
                value: Temperature::Field(Field::Constant(_)) | Temperature::OfCells { .. }, ..
            } => {
                continue;
            }
            Load::Temperature { .. } => "a temperature that varies within cells",
            Load::Rotation { .. } => "the force of a rotation, which varies within cells",
            Load::Nodal { .. } => "a force at a node, which no stress of finite energy balances",
            Load::Gravity { .. } => {
                if let Some(force) = constant_body_force(solid, load) {
                    all.body_force.resize(force.len(), [0.0; 3]);
                    all.body_force.iter_mut().zip(force).for_each(|(sum, force)| *sum = add(*sum, force));
                    continue;
                }
                "an acceleration that varies within cells"
            }
            _ => {
                if let Some(found) = linear_tractions(solid.mesh, load, t).map_err(failed)? {
                    all.tractions.extend(found);
                    continue;
                }
                "a traction that is not linear on each face"
            }
        };
        return Err(NoBound::Load { what: what.into() });
    }
    Ok(all)
}

/// Faces of a support with the directions along which they are held.
fn held_faces(mesh: &Mesh, fix: &Fix, t: f64) -> Result<Vec<(u32, V3)>, NoBound> {
    let mut held: Vec<(u32, V3)> = Vec::new();
    for (c, field) in fix.value.iter().enumerate() {
        let Some(field) = field else { continue };
        for &face in &fix.faces {
            let &[i, j, k] = mesh.faces[face as usize].corners() else { return Err(NoBound::Hexahedra) };
            let x = [i, j, k].map(|node| mesh.nodes[node as usize]);
            let [direction, other, third] = x.map(|x| fix.axes.direction(c, x).unwrap_or([f64::NAN; 3]));
            if direction != other || direction != third {
                return Err(NoBound::Load { what: "a support whose direction turns on its faces".into() });
            }
            let at = |w: [f64; 3]| {
                let place = (0..3).fold([0.0; 3], |sum, i| add(sum, scale(w[i], x[i])));
                field.finite_at(place, t).map_err(failed)
            };
            let corners = [at([1.0, 0.0, 0.0])?, at([0.0, 1.0, 0.0])?, at([0.0, 0.0, 1.0])?];
            for w in [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.6, 0.3, 0.1], [0.1, 0.2, 0.7]] {
                let between: f64 = (0..3).map(|i| w[i] * corners[i]).sum();
                let largest = corners.iter().fold(between.abs(), |most, v| most.max(v.abs()));
                if (at(w)? - between).abs() > LINEAR * largest {
                    return Err(NoBound::Load { what: "a prescribed displacement that is not linear on faces".into() });
                }
            }
            held.push((face, direction));
        }
    }
    Ok(held)
}

/// The contact surfaces; what is bonded counts as held.
fn contacts(
    prepared: &Prepared,
    displacement: &mut [f64],
    lambda: &[f64],
    t: f64,
    held: &mut Vec<(u32, V3)>,
) -> Result<Vec<FlatContact>, NoBound> {
    let Prepared { mesh, problem, surfaces, loading, .. } = prepared;
    let frames = frames(prepared);
    let translations = translations(loading, t).map_err(failed)?;
    let mut contacts = Vec::new();
    for ((surface, pair), translation) in surfaces.iter().zip(&problem.labels.pairs).zip(translations) {
        let refused = |what: &'static str| NoBound::Counterpart { name: surface.name.clone(), what };
        let plane = match &surface.against {
            Counterpart::Surface(_) => return Err(refused("between bodies")),
            Counterpart::Obstacle(Obstacle::Plane { point, normal }) => {
                let normal = unit(*normal).ok_or(refused("against a plane without a normal"))?;
                (*point, scale(-1.0, normal))
            }
            Counterpart::Obstacle(_) => return Err(refused("against an obstacle that is not flat")),
        };
        // The displacements leave out what supports and obstacles travel together.
        let moved = sub(translation, loading.travel);
        if surface.friction == SurfaceFriction::Bonded {
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            held.extend(surface.faces.iter().flat_map(|&face| axes.map(|axis| (face, axis))));
            for &node in &mesh.face_nodes(&surface.faces) {
                displacement[3 * node as usize..][..3].copy_from_slice(&moved);
            }
            continue;
        }
        let limits = limits(&surface.friction, &problem.contact, pair.points.clone()).map_err(refused)?;
        if surface.friction != SurfaceFriction::None && loading.slid.iter().any(|&slid| slid != 0.0) {
            return Err(NoBound::Load { what: "slip of earlier load steps".into() });
        }
        let (point, normal) = plane;
        let mut nodes: Vec<ContactNode> = mesh
            .face_nodes(&surface.faces)
            .into_iter()
            .map(|node| ContactNode { node, force: None, limit: limits.1, reference: moved })
            .collect();
        let at = |node: u32, nodes: &[ContactNode]| nodes.binary_search_by_key(&node, |own| own.node).ok();
        for j in pair.points.clone() {
            if let Some(place) = at(frames[j].node, &nodes) {
                nodes[place].force = Some([0.0; 3]);
                nodes[place].limit = limits.0.get(j - pair.points.start).copied().unwrap_or(limits.1);
            }
        }
        for (node, force) in forces(prepared, &frames, pair.points.clone(), lambda, normal) {
            // What middles hand to ends that are held goes into the supports.
            if let Some(sum) = at(node, &nodes).and_then(|place| nodes[place].force.as_mut()) {
                *sum = add(*sum, force);
            }
        }
        let offset = dot(normal, add(point, moved));
        contacts.push(FlatContact { faces: surface.faces.clone(), normal, offset, nodes });
    }
    Ok(contacts)
}

/// Limits of friction at the points of a surface, where they differ, and at nodes without a point.
fn limits(
    friction: &SurfaceFriction,
    contact: &Contact,
    points: std::ops::Range<usize>,
) -> Result<(Vec<Limit>, Limit), &'static str> {
    match friction {
        SurfaceFriction::None => Ok((Vec::new(), Limit::None)),
        SurfaceFriction::Coulomb(coefficient) => Ok((Vec::new(), Limit::Coulomb(*coefficient))),
        SurfaceFriction::GivenStress(stress) => Ok((Vec::new(), Limit::Given(*stress))),
        SurfaceFriction::Law(law) if law.cohesion.is_some() => Err("with cohesion"),
        SurfaceFriction::Law(law) if law.across.is_none() => {
            let limit = |j: usize| {
                let coefficient = contact.friction[j].coefficient().unwrap_or(0.0);
                law.limit.map_or(Limit::Coulomb(coefficient), |most| Limit::Limited { coefficient, most })
            };
            let all: Vec<Limit> = points.map(limit).collect();
            let first = all.first().copied().unwrap_or(Limit::None);
            Ok((all, first))
        }
        SurfaceFriction::Law(_) => Err("with friction that differs by direction"),
        SurfaceFriction::GivenForce(_) => Err("with friction given as forces of nodes"),
        SurfaceFriction::Bonded => Err("bonded"),
    }
}

/// Forces of the points on the obstacle at the nodes of the mesh: the rows of `B` transposed, in global axes, the
/// parts of middles at the ends of their edges included.
fn forces(
    prepared: &Prepared,
    frames: &[PointFrame],
    points: std::ops::Range<usize>,
    lambda: &[f64],
    normal: V3,
) -> Vec<(u32, V3)> {
    let mut forces = Vec::new();
    for j in points {
        let frame = &frames[j];
        let axes = [frame.normal, frame.tangents[0], frame.tangents[1]];
        for (axis, row) in prepared.problem.rows(j).into_iter().enumerate() {
            if lambda[row] == 0.0 {
                continue;
            }
            // Of a node held across the normal the rest of the force goes into its support.
            let whole = if axis == 0 { normal } else { axes[axis] };
            let square = dot(axes[axis], axes[axis]);
            let entries = crate::run::pose::frames::entries(prepared, row);
            let mut weights: Vec<(u32, f64)> = Vec::new();
            for (dof, value) in entries {
                let part = value * dot(prepared.model.dofs.direction(dof), axes[axis]) / square;
                match weights.iter_mut().find(|(node, _)| *node == dof / 3) {
                    Some((_, sum)) => *sum += part,
                    None => weights.push((dof / 3, part)),
                }
            }
            forces.extend(weights.into_iter().map(|(node, weight)| (node, scale(weight * lambda[row], whole))));
        }
    }
    forces
}

/// The elastic bodies without contact, factorised or set up once.
struct Elastic<'a> {
    problem: &'a ContactProblem,
    motions: &'a RigidMotions,
    stop: &'a Stop,
    operator: Option<Operator>,
}

enum Operator {
    Factor(Box<Cholesky>),
    Multigrid(Box<Multigrid>),
}

impl Elastic<'_> {
    fn solve(&mut self, system: &LinearSystem, forces: &[f64]) -> Result<Vec<f64>, Error> {
        let operator = match self.operator.take() {
            Some(operator) => operator,
            None => self.set_up(system)?,
        };
        let solution = match &operator {
            Operator::Factor(factor) => factor.solve(forces),
            Operator::Multigrid(multigrid) => multigrid.solve_elastic(forces, TOLERANCE, self.stop)?,
        };
        self.operator = Some(operator);
        Ok(solution)
    }

    fn set_up(&self, system: &LinearSystem) -> Result<Operator, Error> {
        let n = system.unknowns.len();
        let elastic = &self.problem.elastic;
        let k = match self.motions.is_empty() {
            true => system.stiffness.clone(),
            false => pinned(&system.stiffness, &linear(self.motions, &system.unknowns))?,
        };
        let mut free = ContactProblem::from_matrices(k, vec![0.0; n], Csr::zero(0, n), Vec::new(), Vec::new());
        free.elastic.node_of = elastic.node_of.as_ref().map(|of| at(of, &system.unknowns));
        if n > SMALL {
            free.elastic.near_kernel = elastic.near_kernel.as_ref().map(|of| at(of, &system.unknowns));
            return Ok(Operator::Multigrid(Box::new(Multigrid::until(&free, self.stop)?)));
        }
        let k = &free.elastic.K;
        let graph = NodeGraph::of_symmetric(k, free.elastic.node_of.as_deref());
        let order = nested_dissection_until(&graph, self.stop)?;
        let plan = plan(&graph, &order, 0);
        Ok(Operator::Factor(Box::new(Cholesky::new(k, &graph, plan, self.stop)?)))
    }
}

/// The values at some of the unknowns.
fn at<T: Copy>(all: &[T], unknowns: &[u32]) -> Vec<T> {
    unknowns.iter().map(|&i| all[i as usize]).collect()
}

/// The motions at some of the unknowns, which are counted anew.
fn linear(motions: &RigidMotions, unknowns: &[u32]) -> RigidMotions {
    let mut some = motions.clone();
    for body in &mut some.bodies {
        let places: Vec<(usize, u32)> = body
            .unknowns
            .iter()
            .enumerate()
            .filter_map(|(place, i)| Some((place, unknowns.binary_search(i).ok()? as u32)))
            .collect();
        body.unknowns = places.iter().map(|place| place.1).collect();
        for motion in &mut body.motions {
            *motion = places.iter().map(|place| motion[place.0]).collect();
        }
    }
    some
}

/// The stiffness with one more spring for each rigid motion, at unknowns that together determine the motions: under forces
/// that balance no spring bears a load.
fn pinned(k: &SymmetricCsr, motions: &RigidMotions) -> Result<SymmetricCsr, Error> {
    let mut pinned = k.clone();
    for body in &motions.bodies {
        let mut rest = body.motions.clone();
        for step in 0..rest.len() {
            // The largest entry left, as elimination with full pivoting takes it.
            let places = (step..rest.len()).flat_map(|m| (0..body.unknowns.len()).map(move |i| (m, i)));
            let largest = places.max_by(|&(m, i), &(n, j)| rest[m][i].abs().total_cmp(&rest[n][j].abs()));
            let Some((motion, at)) = largest else { continue };
            rest.swap(step, motion);
            let (above, below) = rest.split_at_mut(step + 1);
            for motion in below {
                let factor = motion[at] / above[step][at];
                motion.iter_mut().zip(&above[step]).for_each(|(r, pivot)| *r -= factor * pivot);
            }
            let unknown = body.unknowns[at] as usize;
            let stiffness = k.diagonal(unknown);
            let missing = || Error::new("elastic.K", format!("unknown {unknown} has no diagonal entry"), "give one");
            *pinned.entry_mut(unknown, unknown).ok_or_else(missing)? += stiffness;
        }
    }
    Ok(pinned)
}
