//! Prescribed displacements and loads of a case, on the mesh.

use super::facts::{FixFacts, LoadFacts};
use super::{place, regions};
use crate::Error;
use crate::contact::ContactProblem;
use crate::contact::equilibrium::{in_words, unresisted};
use crate::contact::rigid::{RigidMotions, rigid_motions};
use crate::fem::{DofMap, Fix, Load, Solid, dof_map, external_forces, unheld_motions};
use crate::io::case::{Case, FixSpec, LoadKind, LoadSpec, Region, Spot};
use crate::mesh::{Mesh, bodies};

/// The time at which expressions are read without load steps: everything acts in full.
const TIME: f64 = 1.0;

/// The time a case is posed at: the end of its last step.
pub(super) fn end(case: &Case) -> f64 {
    case.steps.last().map_or(TIME, |step| step.until)
}

/// Prescribed displacements; refused where two of them contradict each other.
pub(super) fn fixes(mesh: &Mesh, case: &Case) -> Result<(Vec<Fix>, Vec<FixFacts>), Error> {
    let t = end(case);
    let (mut fixes, mut facts) = (Vec::new(), Vec::new());
    for spec in &case.fixes {
        let fix = Fix { nodes: regions::nodes(mesh, &spec.on, &spec.spot)?, value: spec.value.clone() };
        facts.push(fact(mesh, spec, &fix));
        fixes.push(fix);
    }
    let dofs = dof_map(mesh, &fixes, t).map_err(|error| {
        // A contradiction is shown at the entry that makes it.
        let culprit = (0..fixes.len()).find(|&i| dof_map(mesh, &fixes[..=i], t).is_err());
        culprit.map_or(error.clone(), |i| place::at(&case.fixes[i].spot, error))
    })?;
    if dofs.free.is_empty() {
        let what = "every displacement is prescribed: there is nothing to solve";
        return Err(support_spot(case).error(what, "leave a part of the body free"));
    }
    Ok((fixes, facts))
}

/// Where the case says how the body is held: its last support, or the body itself where it has none.
fn support_spot(case: &Case) -> &Spot {
    case.fixes.last().map_or(&case.mesh.spot, |fix| &fix.spot)
}

fn fact(mesh: &Mesh, spec: &FixSpec, fix: &Fix) -> FixFacts {
    let components = (0..3).filter(|&c| fix.value[c].is_some()).map(|c| ["x", "y", "z"][c]).collect();
    let at = match (&spec.on, fix.nodes.first()) {
        (Region::Point(_), Some(&node)) => Some(mesh.nodes[node as usize]),
        _ => None,
    };
    FixFacts { on: regions::name(&spec.on), nodes: fix.nodes.len(), components, at }
}

/// The motions of bodies that contact alone holds. Refused are bodies that can move rigidly where neither a support nor any
/// contact point resists: nothing determines their displacement. Whether contact can also balance the loads shows in the
/// solve.
pub(super) fn held_by_contact(
    mesh: &Mesh,
    dofs: &DofMap,
    problem: &ContactProblem,
    case: &Case,
) -> Result<RigidMotions, Error> {
    let Some(unsupported) = unsupported(mesh, dofs) else { return Ok(RigidMotions::default()) };
    let motions = rigid_motions(problem);
    let free = if problem.points() == 0 { Some(unsupported) } else { unresisted_by_contact(problem, &motions) };
    free.map_or(Ok(motions), |error| Err(place::at(support_spot(case), error)))
}

fn unresisted_by_contact(problem: &ContactProblem, motions: &RigidMotions) -> Option<Error> {
    let free = unresisted(problem, motions)?;
    let why = if free.work > 0.0 { "the loads push it there" } else { "its displacement is not determined" };
    let motion = in_words(problem, motions, &free.alpha);
    let what = format!("no support and no contact resists a motion of {motion}; {why}");
    Some(Error::new("", what, "add a [[fix]] that stops the motion, or friction to the contact"))
}

/// A body that supports do not hold.
fn unsupported(mesh: &Mesh, dofs: &DofMap) -> Option<Error> {
    let body_of_node = bodies(mesh);
    let unheld = unheld_motions(mesh, dofs, &body_of_node);
    let first = unheld.first()?;
    let count = body_of_node.iter().max().map_or(1, |&last| last + 1);
    let who = if count == 1 {
        "the body".to_string()
    } else {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (x, _) in mesh.nodes.iter().zip(&body_of_node).filter(|(_, body)| **body == first.body) {
            (0..3).for_each(|c| (low[c], high[c]) = (low[c].min(x[c]), high[c].max(x[c])));
        }
        format!("body {} of {count} (from {low:?} to {high:?})", first.body + 1)
    };
    let what = if first.motions.len() == 6 {
        format!("{who} is not held at all: it is free in all translations and rotations")
    } else {
        let motions: Vec<String> = first.motions.iter().map(ToString::to_string).collect();
        format!("{who} is not held: it is free in {}", motions.join("; "))
    };
    Some(Error::new("", what, "add a [[fix]] or a [[contact]] that stops these motions"))
}

/// Loads with the force each adds up to at time `t`.
pub(super) fn loads(solid: &Solid, specs: &[LoadSpec], t: f64) -> Result<(Vec<Load>, Vec<LoadFacts>), Error> {
    let (mut loads, mut facts) = (Vec::new(), Vec::new());
    for spec in specs {
        let load = load(solid.mesh, spec)?;
        let forces = external_forces(solid, std::slice::from_ref(&load), t);
        let forces = forces.map_err(|error| place::instead(&spec.spot, error))?;
        let mut resultant = [0.0; 3];
        forces.iter().enumerate().for_each(|(dof, force)| resultant[dof % 3] += force);
        facts.push(LoadFacts { extent: extent(solid.mesh, &load), ..describe(spec, resultant) });
        loads.push(load);
    }
    Ok((loads, facts))
}

fn load(mesh: &Mesh, spec: &LoadSpec) -> Result<Load, Error> {
    let faces = || match &spec.on {
        Some(region) => regions::faces(mesh, region, &spec.spot, "the load"),
        None => Err(spec.spot.error("this load does not say where it acts", "add on = \"z-max\" or another group")),
    };
    Ok(match &spec.kind {
        LoadKind::Traction(value) => Load::Traction { faces: faces()?, value: value.clone() },
        LoadKind::Pressure(value) => Load::Pressure { faces: faces()?, value: value.clone() },
        LoadKind::Force(total) => Load::Force { faces: faces()?, total: total.clone() },
        LoadKind::Gravity(acceleration) => {
            let cells = match &spec.on {
                Some(region) => regions::cells(mesh, region, &spec.spot)?,
                None => (0..mesh.cell_count() as u32).collect(),
            };
            Load::Gravity { cells, acceleration: acceleration.clone() }
        }
    })
}

fn describe(spec: &LoadSpec, resultant: [f64; 3]) -> LoadFacts {
    let kind = match spec.kind {
        LoadKind::Traction(_) => "traction",
        LoadKind::Pressure(_) => "pressure",
        LoadKind::Force(_) => "force",
        LoadKind::Gravity(_) => "gravity",
    };
    let on = spec.on.as_ref().map_or("the whole body".to_string(), regions::name);
    LoadFacts { on, kind, extent: 0.0, resultant }
}

/// Area of the faces or volume of the cells a load acts on.
fn extent(mesh: &Mesh, load: &Load) -> f64 {
    match load {
        Load::Traction { faces, .. } | Load::Pressure { faces, .. } | Load::Force { faces, .. } => {
            faces.iter().map(|&face| mesh.face_area(face as usize)).sum()
        }
        Load::Gravity { cells, .. } => cells.iter().map(|&cell| mesh.cell_volume(cell as usize)).sum(),
    }
}
