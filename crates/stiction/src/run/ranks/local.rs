//! The problem of one rank, posed on its piece of the mesh by the code that poses a whole one.

use std::collections::HashSet;
use std::sync::Arc;

use super::bolts::RankBolt;
use super::outside::Outside;
use super::scope;
use super::share::{NO_AXIS, OBSTACLE, REVERSED, Share, name};
use super::ties::{self, has_ties};
use super::timed::{Posed, Timed};
use crate::Error;
use crate::contact::{ContactProblem, Division, TributaryArea, pose_points, tributary_areas};
use crate::fem::{FaceMoments, FeModel, Field, Fix, Load, Material, Solid, Spring, add_springs, assemble};
use crate::friction::equations;
use crate::io::case::{Case, FixSpec, LoadKind, LoadSpec, Region, Spot, SpringSpec};
use crate::io::text::number;
use crate::mesh::v3::{V3, add, cross, sub};
use crate::mesh::{Group, Mesh, MeshPiece};
use crate::ranks::{Ranks, agree};
use crate::run::pose::Coupling;
use crate::run::pose::activity::ALWAYS;
use crate::run::pose::load_state::{Initial, acting};
use crate::run::pose::loads::{end, load, timed_fix};
use crate::run::pose::place;
use crate::run::pose::ties::TimedFix;

/// A case on the piece of one rank.
pub(super) struct Local {
    pub piece: MeshPiece,
    pub materials: Vec<Material>,
    pub material_of_cell: Vec<u32>,
    /// Its stiffness has moved to `problem`.
    pub model: FeModel,
    /// With the unknowns and points of other ranks at the border.
    pub problem: ContactProblem,
    pub division: Division,
    /// For each surface with contact points, whose faces here are the group "contact k", the sign of friction as a force on the
    /// body of `on`, whether its counterpart is another surface, and the nodes here of that with
    /// what they stand for; their areas are those of the faces here.
    pub signs: Vec<f64>,
    pub between_bodies: Vec<bool>,
    pub masters: Vec<Vec<TributaryArea>>,
    /// The gap of each point here before anything is prescribed, length.
    pub undeformed: Vec<f64>,
    /// How far obstacles have moved along the rows of `B` at each point here, length, `3m`.
    pub motion: Vec<f64>,
    /// The contact of the case that each surface is of.
    pub contact_of: Vec<u32>,
    /// As in the share of this rank.
    pub symmetry: Vec<u32>,
    pub moments: Vec<FaceMoments>,
    /// Strain by temperature now, of each cell here, and of the forces that it causes through the cuts of bolts the part at own
    /// nodes.
    pub initial: Initial,
    /// Nodes and cells of the whole.
    pub sizes: [u64; 2],
    pub bolts: Vec<RankBolt>,
    pub timed: Timed,
    pub couplings: Vec<Coupling>,
    /// Of rank 0.
    pub outside: Option<Outside>,
}

/// Poses what a rank has of the case.
pub(super) fn local(case: &Case, share: Share, ranks: &Arc<dyn Ranks>) -> Result<Local, Error> {
    let local = agree(&**ranks, assembled(case, share, ranks))?;
    let equations = equations(&local.problem, Some(&local.division));
    agree(&**ranks, local.refuse_shared_nodes(&equations))?;
    Ok(local)
}

fn assembled(case: &Case, share: Share, ranks: &Arc<dyn Ranks>) -> Result<Local, Error> {
    let Share {
        piece,
        material_of_cell,
        symmetry,
        moments,
        center,
        diagonal,
        sizes,
        points,
        kinds,
        contact_of,
        bodies,
        body_of_node,
        bolts,
        ties: ties::Here { tied, couplings },
        outside,
    } = share;
    let mesh = &piece.mesh;
    let materials: Vec<Material> = case.materials.iter().map(|spec| spec.material.clone()).collect();
    let solid = Solid { mesh, materials: &materials, material_of_cell: &material_of_cell };
    let t = end(case);
    let (fixes, (loads, spots)) = (fixes(mesh, case, &symmetry), loads(mesh, case, &moments, t)?);
    let mut model = assemble(&solid, &loads, &fixes, t).map_err(|error| {
        // That of a load is shown where the case asks for it.
        let of_load = acting(&solid, loads.iter().zip(spots.iter().copied()), (&[], &|_| true), t).err();
        of_load.unwrap_or_else(|| place::at(&case.mesh.spot, error))
    })?;
    add_springs(mesh, &springs(mesh, case), &mut model)?;
    let mut division = Division {
        ranks: Arc::clone(ranks),
        owner: piece.owner.clone(),
        global: piece.nodes.clone(),
        supports: model.dofs.prescribed.iter().map(|&dof| dof / 3).collect(),
        points: points.labels(mesh.nodes.len()),
    };
    let (mut undeformed, layers) = (points.gaps(), points.layers());
    let mut problem = pose_points(mesh, &mut model, points, center, &body_of_node, bodies);
    // A layer belongs to the rank of the node that it lies in front of; its numbers follow on those of the mesh.
    division.owner.extend(model.dofs.layer.iter().map(|&v| piece.owner[v as usize]));
    division.global.extend(layers.iter().map(|number| sizes[0] + number));
    let posed = match tied {
        Some(tied) => Posed::Points(tied),
        None => Posed::Supports(timed_fixes(mesh, case, &symmetry)),
    };
    let timed = Timed::new(case, (mesh, &model), &mut problem, (&contact_of, diagonal), posed)?;
    undeformed.resize(problem.points(), 0.0);
    division.points.extend(timed.nodes());
    problem.validate()?;
    let motion = vec![0.0; 3 * problem.points()];
    let signs = kinds.iter().map(|&kind| if kind == REVERSED { -1.0 } else { 1.0 }).collect();
    let between_bodies = kinds.iter().map(|&kind| kind != OBSTACLE).collect();
    let of_master =
        |k: usize| mesh.group(&name("master", k)).map_or(Vec::new(), |group| tributary_areas(mesh, &group.faces));
    let masters = (0..kinds.len()).map(of_master).collect();
    Ok(Local {
        piece,
        materials,
        material_of_cell,
        model,
        problem,
        division,
        signs,
        between_bodies,
        masters,
        undeformed,
        motion,
        contact_of,
        symmetry,
        moments,
        initial: Initial::default(),
        sizes,
        bolts,
        timed,
        couplings,
        outside,
    })
}

/// Whether what acts at the end is not what was posed, or more is to be known of it: load steps, obstacles that move, temperatures.
pub(super) fn changes(case: &Case) -> bool {
    let heats = |load: &LoadSpec| matches!(load.kind, LoadKind::Temperature(_) | LoadKind::TemperatureArray { .. });
    !case.steps.is_empty()
        || has_ties(case)
        || is_stressed(case)
        || case.contacts.iter().any(|contact| contact.motion.is_some())
        || case.loads.iter().any(heats)
}

/// Whether an interface carries a stress before anything is loaded.
pub(super) fn is_stressed(case: &Case) -> bool {
    case.contacts.iter().any(|contact| contact.initial_stress.is_some())
}

impl Local {
    /// The node of the mesh that a point is at.
    pub(super) fn node_of(&self, j: usize) -> u32 {
        self.model.dofs.mesh_node(self.division.points[j])
    }

    /// Multigrid wants a node for each point but for the `equations` over many nodes: those of other ties are neither of contacts nor of
    /// one another.
    fn refuse_shared_nodes(&self, equations: &[u32]) -> Result<(), Error> {
        let nodes = &self.division.points;
        let of_contacts = self.timed.contact_points();
        let mut taken: HashSet<u32> = nodes[..of_contacts].iter().copied().collect();
        let mut others = (of_contacts..nodes.len()).filter(|j| equations.binary_search(&(*j as u32)).is_err());
        let Some(j) = others.find(|&j| !taken.insert(nodes[j])) else { return Ok(()) };
        let [x, y, z] = self.piece.mesh.nodes[self.node_of(j) as usize].map(number);
        let what = format!(
            "an equation, a coupling or a support that begins or ends with a step on a node, at ({x}, {y}, {z}), that a contact has, or \
             another of them with other steps,"
        );
        Err(scope::refused(&self.timed.spot(j), &what))
    }

    /// The surface of a point.
    pub(super) fn pair_of(&self, j: usize) -> usize {
        self.problem.labels.pairs.partition_point(|pair| pair.points.end <= j)
    }
}

/// The group of an entry of the case; none where nothing of it is here.
pub(super) fn group<'m>(mesh: &'m Mesh, kind: &str, number: usize) -> Option<&'m Group> {
    let group = mesh.group(&name(kind, number))?;
    let lists = [&group.nodes, &group.faces, &group.cells];
    lists.iter().any(|list| !list.is_empty()).then_some(group)
}

fn region(kind: &str, number: usize, spot: &Spot) -> Region {
    Region::Groups(vec![(name(kind, number), spot.clone())])
}

/// Prescribed displacements of the nodes here that always hold.
pub(super) fn fixes(mesh: &Mesh, case: &Case, symmetry: &[u32]) -> Vec<Fix> {
    let always = |k: usize| case.fixes[k].during.period(&case.steps) == ALWAYS;
    (0..case.fixes.len()).filter(|&k| always(k)).filter_map(|k| fix(mesh, case, k, symmetry[k])).collect()
}

/// Those that begin or end with a step.
fn timed_fixes(mesh: &Mesh, case: &Case, symmetry: &[u32]) -> Vec<TimedFix> {
    let timed = |(k, spec): (usize, &FixSpec)| {
        let in_time = spec.during.period(&case.steps) != ALWAYS;
        let fix = fix(mesh, case, k, symmetry[k]).filter(|_| in_time)?;
        Some(timed_fix(spec, fix, &case.steps))
    };
    case.fixes.iter().enumerate().filter_map(timed).collect()
}

/// An entry of the case at the nodes here; none where it holds none of them.
fn fix(mesh: &Mesh, case: &Case, number: usize, axis: u32) -> Option<Fix> {
    let (group, spec) = (group(mesh, "fix", number)?, &case.fixes[number]);
    let mut fix = Fix { nodes: group.nodes.clone(), value: spec.value.clone(), axes: spec.axes, ..Fix::default() };
    if axis != NO_AXIS {
        fix.value[axis as usize] = Some(Field::Constant(0.0));
    }
    Some(fix)
}

/// Loads on what is here with their places in the case; total forces and moments as they are at time `t`, where `moments` are
/// those of all faces, of which there is a part here.
pub(super) fn loads<'c>(
    mesh: &Mesh,
    case: &'c Case,
    moments: &[FaceMoments],
    t: f64,
) -> Result<(Vec<Load>, Vec<&'c Spot>), Error> {
    let (mut loads, mut spots) = (Vec::new(), Vec::new());
    for (k, (spec, moments)) in case.loads.iter().zip(moments).enumerate() {
        if group(mesh, "load", k).is_none() {
            continue;
        }
        let kind = match &spec.kind {
            LoadKind::Force(total) => moments.even(total, t).map(|even| LoadKind::Traction(even.map(Field::Constant))),
            LoadKind::Resultant { force, moment, about } => {
                moments.resultant([force, moment], *about, t).map(|turning| LoadKind::Traction(turned(turning)))
            }
            other => Ok(other.clone()),
        };
        let kind = kind.map_err(|error| place::instead(&spec.spot, error))?;
        let spec = LoadSpec { on: Some(region("load", k, &spec.spot)), kind, spot: spec.spot.clone() };
        loads.push(load(mesh, &spec)?);
        spots.push(&case.loads[k].spot);
    }
    Ok((loads, spots))
}

/// The traction `a + b x r`, `r` from the centroid.
fn turned([even, turn, centroid]: [V3; 3]) -> [Field; 3] {
    [0, 1, 2].map(|c| Field::Function {
        text: "the traction of a force with a moment".into(),
        value: Arc::new(move |x, _| add(even, cross(turn, sub(x, centroid)))[c]),
    })
}

/// The elastic foundations that have faces here.
fn springs(mesh: &Mesh, case: &Case) -> Vec<Spring> {
    let of = |(k, spec): (usize, &SpringSpec)| {
        let faces = group(mesh, "spring", k)?.faces.clone();
        Some(Spring { faces, normal: spec.normal, tangential: spec.tangential })
    };
    case.springs.iter().enumerate().filter_map(of).collect()
}
