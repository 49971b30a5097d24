//! The problem of one rank, posed on its piece of the mesh by the code that poses a whole one.

use std::sync::Arc;

use super::share::{NO_AXIS, Share, name};
use crate::Error;
use crate::contact::{Bodies, Body, ContactProblem, ContactSurface, Division, Pair, SurfaceFacts, pose_about};
use crate::fem::{FeModel, Field, Fix, Load, Material, Solid, assemble};
use crate::io::case::{Case, ContactSpec, LoadKind, LoadSpec, Region, Spot};
use crate::mesh::{Group, Mesh, MeshPiece};
use crate::ranks::Ranks;
use crate::run::pose::loads::{TIME, load};
use crate::run::pose::{place, surfaces};

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
    /// The surfaces that this piece has a part of, with the number of their contact in the case.
    pub surfaces: Vec<(usize, ContactSurface, SurfaceFacts)>,
    /// Nodes and cells of the whole.
    pub sizes: [u64; 2],
}

/// Poses what a rank has of the case.
pub(super) fn local(case: &Case, share: Share, ranks: &Arc<dyn Ranks>) -> Result<Local, Error> {
    let Share { piece, material_of_cell, symmetry, area, center, radius, sizes } = share;
    let mesh = &piece.mesh;
    let materials: Vec<Material> = case.materials.iter().map(|spec| spec.material.clone()).collect();
    let solid = Solid { mesh, materials: &materials, material_of_cell: &material_of_cell };
    let (fixes, loads) = (fixes(mesh, case, &symmetry)?, loads(mesh, case, &area)?);
    let mut model = assemble(&solid, &loads, &fixes, TIME).map_err(|error| place::at(&case.mesh.spot, error))?;
    let (numbers, specs) = contacts(mesh, case);
    let surfaces = surfaces::surfaces(mesh, &specs)?;
    let (mut problem, facts) = pose_about(mesh, &mut model, &surfaces, center).map_err(|error| {
        let named = specs.iter().find(|spec| error.place == format!("contact \"{}\"", spec.name));
        named.map_or(error.clone(), |spec| place::at(&spec.spot, error))
    })?;
    // Every rank names every pair, in the order of the case.
    let mut found = numbers.iter().zip(&problem.labels.pairs).peekable();
    let mut pairs: Vec<Pair> = Vec::new();
    for (k, contact) in case.contacts.iter().enumerate() {
        let end = pairs.last().map_or(0, |pair| pair.points.end);
        let points = found.next_if(|(number, _)| **number == k).map_or(end..end, |(_, pair)| pair.points.clone());
        pairs.push(Pair { name: contact.name.clone(), points });
    }
    problem.labels.pairs = pairs;
    let bodies = problem.labels.bodies.as_ref();
    let [of, of_support] = bodies.map_or([0, 0], |b| [b.of.len(), b.of_support.len()]).map(|count| vec![0; count]);
    let body = Body { name: "body".into(), centre: center, radius };
    problem.labels.bodies = Some(Bodies { list: vec![body], of, of_support, origin: center });
    problem.validate()?;
    let division = Division {
        ranks: Arc::clone(ranks),
        owner: piece.owner.clone(),
        global: piece.nodes.clone(),
        supports: model.dofs.prescribed.iter().map(|&dof| dof / 3).collect(),
    };
    let surfaces = numbers.into_iter().zip(surfaces).zip(facts).map(|((k, surface), facts)| (k, surface, facts));
    let surfaces = surfaces.collect();
    Ok(Local { piece, materials, material_of_cell, model, problem, division, surfaces, sizes })
}

/// The group of an entry of the case; none where nothing of it is here.
fn group<'m>(mesh: &'m Mesh, kind: &str, number: usize) -> Option<&'m Group> {
    let group = mesh.group(&name(kind, number))?;
    let lists = [&group.nodes, &group.faces, &group.cells];
    lists.iter().any(|list| !list.is_empty()).then_some(group)
}

fn region(kind: &str, number: usize, spot: &Spot) -> Region {
    Region::Groups(vec![(name(kind, number), spot.clone())])
}

fn fixes(mesh: &Mesh, case: &Case, symmetry: &[u32]) -> Result<Vec<Fix>, Error> {
    let mut fixes = Vec::new();
    for (k, (spec, &axis)) in case.fixes.iter().zip(symmetry).enumerate() {
        let Some(group) = group(mesh, "fix", k) else { continue };
        let mut fix = Fix { nodes: group.nodes.clone(), value: spec.value.clone(), axes: spec.axes, ..Fix::default() };
        if axis != NO_AXIS {
            fix.value[axis as usize] = Some(Field::Constant(0.0));
        }
        fixes.push(fix);
    }
    Ok(fixes)
}

fn loads(mesh: &Mesh, case: &Case, area: &[f64]) -> Result<Vec<Load>, Error> {
    let mut loads = Vec::new();
    for (k, (spec, &area)) in case.loads.iter().zip(area).enumerate() {
        if group(mesh, "load", k).is_none() {
            continue;
        }
        let kind = match &spec.kind {
            // The area of all faces, of which there is a part here.
            LoadKind::Force(total) => {
                LoadKind::Traction(spread(total, area).map_err(|e| place::instead(&spec.spot, e))?)
            }
            other => other.clone(),
        };
        let spec = LoadSpec { on: Some(region("load", k, &spec.spot)), kind, spot: spec.spot.clone() };
        loads.push(load(mesh, &spec)?);
    }
    Ok(loads)
}

/// A total force as a force per area.
fn spread(total: &[Field; 3], area: f64) -> Result<[Field; 3], Error> {
    // A total force has no place: an expression that reads one gives NaN and is refused.
    let at = |field: &Field| Ok(Field::Constant(field.finite_at([f64::NAN; 3], TIME)? / area));
    let [x, y, z] = total;
    Ok([at(x)?, at(y)?, at(z)?])
}

/// The contacts that are here, with their numbers in the case.
fn contacts(mesh: &Mesh, case: &Case) -> (Vec<usize>, Vec<ContactSpec>) {
    let here = case.contacts.iter().enumerate().filter(|(k, _)| group(mesh, "contact", *k).is_some());
    here.map(|(k, spec)| (k, ContactSpec { on: region("contact", k, &spec.spot), ..spec.clone() })).unzip()
}
