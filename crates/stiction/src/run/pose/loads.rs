//! Prescribed displacements and loads of a case, on the mesh.

use super::activity::ALWAYS;
use super::arrays::{Found, find};
use super::facts::{ContactFacts, FixFacts, LoadFacts, SpringFacts};
use super::notes::SEVERAL_CONTACTS;
use super::ties::{Start, TimedFix};
use super::{place, regions};
use crate::Error;
use crate::contact::ContactProblem;
use crate::contact::equilibrium::{in_words, unresisted};
use crate::contact::rigid::{RigidMotions, rigid_motions};
use crate::fem::{
    Axes, DofMap, Field, Fix, Load, Nodal, Solid, Spring, Temperature, dof_map, external_forces, unconstrained_motions,
};
use crate::io::case::{
    AgainstSpec, Beginning, CYLINDRICAL, Case, FixSpec, LoadKind, LoadSpec, NodalSpec, Region, Spot, SpringSpec,
    StepSpec,
};
use crate::io::text::triple;
use crate::mesh::v3::{V3, add, cross, dot, norm, scale};
use crate::mesh::{Bounds, Mesh, v3};

/// The time at which expressions are read without load steps: everything acts in full.
pub(crate) const TIME: f64 = 1.0;

/// The time a case is posed at: the end of its last step.
pub(crate) fn end(case: &Case) -> f64 {
    case.steps.last().map_or(TIME, |step| step.until)
}

/// Supports on the mesh.
#[derive(Default)]
pub(crate) struct Fixes {
    /// Those of all steps, and where the case asks for them.
    pub held: Vec<Fix>,
    pub spots: Vec<Spot>,
    /// Those that begin or end with a step.
    pub timed: Vec<TimedFix>,
    /// What was understood of all.
    pub facts: Vec<FixFacts>,
}

/// Prescribed displacements; refused where two of them contradict each other.
pub(crate) fn fixes(mesh: &Mesh, case: &Case) -> Result<Fixes, Error> {
    let t = end(case);
    let Fixes { mut held, mut timed, mut facts, mut spots } = Fixes::default();
    for spec in &case.fixes {
        let nodes = regions::nodes(mesh, &spec.on, &spec.spot)?;
        let fix = match spec.symmetry {
            true => symmetry(mesh, spec, nodes)?,
            false => Fix { nodes, value: spec.value.clone(), axes: spec.axes, ..Fix::default() },
        };
        let fix = Fix { faces: regions::boundary_faces(mesh, &spec.on, &spec.spot), ..fix };
        facts.push(fact(mesh, spec, &fix));
        match spec.during.period(&case.steps) {
            ALWAYS => {
                held.push(fix);
                spots.push(spec.spot.clone());
            }
            _ => timed.push(timed_fix(spec, fix, &case.steps)),
        }
    }
    let dofs = dof_map(mesh, &held, t).map_err(|error| {
        // A contradiction is shown at the entry that makes it.
        let culprit = (0..held.len()).find(|&i| dof_map(mesh, &held[..=i], t).is_err());
        culprit.map_or(error.clone(), |i| place::at(&spots[i], error))
    })?;
    if dofs.free.is_empty() {
        let what = "every displacement is prescribed: there is nothing to solve";
        return Err(support_spot(case).error(what, "leave a part of the body free"));
    }
    Ok(Fixes { held, timed, facts, spots })
}

/// A support that begins or ends with a step.
pub(crate) fn timed_fix(spec: &FixSpec, fix: Fix, steps: &[StepSpec]) -> TimedFix {
    let period = spec.during.period(steps);
    let start = match spec.during.from.filter(|_| period[0].is_finite()) {
        None => Start::AtOnce,
        Some(step) => match spec.beginning {
            Beginning::Led => Start::Until(steps[step].until),
            Beginning::AtOnce => Start::AtOnce,
            Beginning::Stays => Start::Stays,
        },
    };
    TimedFix { fix, period, start, spot: spec.spot.clone() }
}

/// How far the normal of a plane of symmetry may lean (sine) from the axis it is across.
const LEAN: f64 = 1e-6;
/// Degrees by which the normals of the faces of a plane may differ from their mean: coordinates of six digits turn small
/// faces by that much.
const FLAT: f64 = 0.1;

/// Holds the component along the normal of the faces, which have to be flat.
fn symmetry(mesh: &Mesh, spec: &FixSpec, nodes: Vec<u32>) -> Result<Fix, Error> {
    let faces = regions::faces(mesh, &spec.on, &spec.spot, "a plane of symmetry")?;
    let normals: Vec<V3> = faces.iter().map(|&face| mesh.face_normal(face as usize)).collect();
    // Faces may look either way: a sector has two sides.
    let same_way = |n: V3| if dot(n, normals[0]) < 0.0 { scale(-1.0, n) } else { n };
    let areas = faces.iter().map(|&face| mesh.face_area(face as usize));
    let sum = normals.iter().zip(areas).fold([0.0; 3], |sum, (&n, area)| add(sum, scale(area, same_way(n))));
    let mean = scale(1.0 / norm(sum), sum);
    let angle = |n: V3| norm(cross(mean, n)).atan2(dot(mean, n).abs()).to_degrees();
    let angles = faces.iter().zip(&normals).map(|(&face, &n)| (angle(n), face, n));
    if let Some((angle, face, n)) = angles.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|worst| worst.0 > FLAT) {
        let name = regions::name(&spec.on);
        let corners = mesh.faces[face as usize].corners();
        let place = v3::mean(corners.iter().map(|&c| mesh.nodes[c as usize]));
        let what = format!(
            "{name} is not flat: its face at {} with the normal {} leans by {angle:.1} degrees from the mean normal {}",
            triple(place),
            triple(n),
            triple(mean)
        );
        return Err(spec.spot.error(what, "name the faces of one plane of symmetry in each [[fix]]"));
    }
    let axis = (0..3).fold(0, |best, c| if mean[c].abs() > mean[best].abs() { c } else { best });
    let lean = (0..3).filter(|&c| c != axis).map(|c| mean[c] * mean[c]).sum::<f64>().sqrt();
    let mut fix = Fix { nodes, ..Fix::default() };
    let held = Some(Field::Constant(0.0));
    if lean <= LEAN {
        fix.value[axis] = held;
    } else {
        let [second, third] = v3::across(mean);
        (fix.value[0], fix.axes) = (held, Axes::Turned([mean, second, third]));
    }
    Ok(fix)
}

/// Elastic foundations.
pub(crate) fn springs(mesh: &Mesh, specs: &[SpringSpec]) -> Result<(Vec<Spring>, Vec<SpringFacts>), Error> {
    let (mut springs, mut facts) = (Vec::new(), Vec::new());
    for spec in specs {
        let faces = regions::faces(mesh, &spec.on, &spec.spot, "the spring")?;
        let area = faces.iter().map(|&face| mesh.face_area(face as usize)).sum();
        let (normal, tangential) = (spec.normal, spec.tangential);
        facts.push(SpringFacts { on: regions::name(&spec.on), area, normal, tangential });
        springs.push(Spring { faces, normal, tangential });
    }
    Ok((springs, facts))
}

/// Where the case says how the body is held: its last support, or the body itself where it has none.
fn support_spot(case: &Case) -> &Spot {
    case.fixes.last().map_or(&case.mesh.spot, |fix| &fix.spot)
}

fn fact(mesh: &Mesh, spec: &FixSpec, fix: &Fix) -> FixFacts {
    let held = || (0..3).filter(|&c| fix.value[c].is_some());
    let components = match fix.axes {
        Axes::Global => held().map(|c| ["x", "y", "z"][c]).collect(),
        Axes::Turned(axes) => format!("along {}", held().map(|c| triple(axes[c])).collect::<Vec<_>>().join(" and ")),
        Axes::Cylinder { point, axis } => {
            let names: String = held().map(|c| CYLINDRICAL[c]).collect();
            format!("{names} about the line through {} along {}", triple(point), triple(axis))
        }
    };
    let at = match (&spec.on, fix.nodes.first()) {
        (Region::Point(_), Some(&node)) => Some(mesh.nodes[node as usize]),
        _ => None,
    };
    FixFacts { on: regions::name(&spec.on), nodes: fix.nodes.len(), components, at }
}

/// The motions of bodies that contact alone holds. Refused are bodies that can move rigidly where neither a support nor any
/// contact point resists: nothing determines their displacement. Whether contact can also balance the loads shows in the
/// solve.
pub(crate) fn held_by_contact(
    mesh: &Mesh,
    dofs: &DofMap,
    problem: &ContactProblem,
    case: &Case,
    contacts: &[ContactFacts],
) -> Result<RigidMotions, Error> {
    let Some(unsupported) = unsupported(mesh, dofs, problem) else { return Ok(RigidMotions::default()) };
    let motions = rigid_motions(problem);
    let bare = problem.points() == 0 && case.springs.is_empty();
    let free = if bare { Some(unsupported) } else { unresisted_by_contact(problem, &motions) };
    let Some(error) = free else { return Ok(motions) };
    if let Some((spot, what)) = on_one_body(mesh, problem, dofs, case) {
        return Err(place::at(spot, Error { what: format!("{}; {what}", error.what), ..error }));
    }
    let without =
        contacts.iter().zip(&case.contacts).find_map(|(facts, spec)| Some((facts.why_no_point()?, facts, &spec.spot)));
    if let Some((why, facts, spot)) = without {
        let remedy = match facts.surface.near[1] {
            0 => "bring the surfaces of the contact together, or add a [[fix]] that stops these motions",
            _ => SEVERAL_CONTACTS,
        };
        let remedy = remedy.into();
        return Err(place::at(spot, Error { what: format!("{}; {why}", error.what), remedy, ..error }));
    }
    let much_taken = contacts.iter().zip(&case.contacts).find_map(|(facts, spec)| Some((facts.warning()?, &spec.spot)));
    if let Some((why, spot)) = much_taken {
        return Err(place::at(spot, Error { what: format!("{}; {why}", error.what), ..error }));
    }
    Err(place::at(support_spot(case), error))
}

/// The first contact both surfaces of which belong to one of several bodies: hardly what was meant where another body is not
/// held.
fn on_one_body<'a>(mesh: &Mesh, problem: &ContactProblem, dofs: &DofMap, case: &'a Case) -> Option<(&'a Spot, String)> {
    let bodies = problem.labels.bodies.as_ref().filter(|bodies| bodies.list.len() > 1)?;
    let of_node = body_of_node(mesh, problem, dofs);
    let own = |region: &Region, spot: &Spot| -> Option<u32> {
        let nodes = mesh.face_nodes(&regions::boundary_faces(mesh, region, spot));
        let first = of_node[*nodes.first()? as usize];
        nodes.iter().all(|&node| of_node[node as usize] == first).then_some(first)
    };
    case.contacts.iter().find_map(|contact| {
        let AgainstSpec::Surface { region, .. } = &contact.against else { return None };
        let body = own(&contact.on, &contact.spot)?;
        (own(region, &contact.spot)? == body).then(|| {
            let (name, of) = (&contact.name, &bodies.list[body as usize].name);
            (
                &contact.spot,
                format!("contact \"{name}\" names two surfaces of one body, \"{of}\": is one of another body meant?"),
            )
        })
    })
}

/// The number of the body of each node.
fn body_of_node(mesh: &Mesh, problem: &ContactProblem, dofs: &DofMap) -> Vec<u32> {
    let mut body_of_node = vec![0; mesh.nodes.len()];
    if let Some(bodies) = &problem.labels.bodies {
        let (free, prescribed) = (dofs.free.iter().zip(&bodies.of), dofs.prescribed.iter().zip(&bodies.of_support));
        free.chain(prescribed).for_each(|(&dof, &body)| body_of_node[dofs.mesh_node(dof / 3) as usize] = body);
    }
    body_of_node
}

fn unresisted_by_contact(problem: &ContactProblem, motions: &RigidMotions) -> Option<Error> {
    let free = unresisted(problem, motions)?;
    let why = if free.work > 0.0 { "the loads push it there" } else { "its displacement is not determined" };
    let motion = in_words(problem, motions, &free.alpha);
    let what = format!("no support, no spring and no contact resists a motion of {motion}; {why}");
    Some(Error::new("", what, "add a [[fix]] or a [[spring]] that stops the motion, or friction to the contact"))
}

/// A body that supports do not hold.
fn unsupported(mesh: &Mesh, dofs: &DofMap, problem: &ContactProblem) -> Option<Error> {
    let body_of_node = body_of_node(mesh, problem, dofs);
    let unconstrained = unconstrained_motions(mesh, dofs, &body_of_node);
    let first = unconstrained.first()?;
    let count = body_of_node.iter().max().map_or(1, |&last| last + 1);
    let who = if count == 1 {
        "the body".to_string()
    } else {
        let own = mesh.nodes.iter().zip(&body_of_node).filter(|(_, body)| **body == first.body);
        let Bounds { low, high } = Bounds::around(own.map(|(x, _)| *x));
        let named = problem.labels.bodies.as_ref().and_then(|bodies| bodies.list.get(first.body as usize));
        let name = named.map_or(String::new(), |body| format!(" \"{}\"", body.name));
        format!("body{name} (one of {count}, from {} to {})", triple(low), triple(high))
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
pub(crate) fn loads(solid: &Solid, specs: &[LoadSpec], t: f64) -> Result<(Vec<Load>, Vec<LoadFacts>), Error> {
    let (mut loads, mut facts) = (Vec::new(), Vec::new());
    for spec in specs {
        let load = load(solid.mesh, spec)?;
        let forces = external_forces(solid, std::slice::from_ref(&load), t);
        let forces = forces.map_err(|error| place::instead(&spec.spot, error))?;
        let mut resultant = [0.0; 3];
        forces.iter().enumerate().for_each(|(dof, force)| resultant[dof % 3] += force);
        let range = temperatures(solid, &load, t);
        facts.push(LoadFacts { extent: extent(solid.mesh, &load), range, ..describe(spec, resultant) });
        loads.push(load);
    }
    Ok((loads, facts))
}

/// The load of a spec on a mesh.
pub(crate) fn load(mesh: &Mesh, spec: &LoadSpec) -> Result<Load, Error> {
    let faces = || match &spec.on {
        Some(region) => regions::faces(mesh, region, &spec.spot, "the load"),
        None => Err(spec.spot.error("this load does not say where it acts", "add on = \"z-max\" or another group")),
    };
    let cells = || match &spec.on {
        Some(region) => regions::cells(mesh, region, &spec.spot),
        None => Ok((0..mesh.cell_count() as u32).collect()),
    };
    Ok(match &spec.kind {
        LoadKind::Traction(value) => Load::Traction { faces: faces()?, value: value.clone() },
        LoadKind::Pressure(value) => Load::Pressure { faces: faces()?, value: value.clone() },
        LoadKind::Force(total) => Load::Force { faces: faces()?, total: total.clone() },
        LoadKind::Resultant { force, moment, about } => {
            Load::Resultant { faces: faces()?, force: force.clone(), moment: moment.clone(), about: *about }
        }
        LoadKind::Hydrostatic { weight, level, up } => {
            Load::Hydrostatic { faces: faces()?, weight: *weight, level: level.clone(), up: *up }
        }
        LoadKind::Nodal(value) => {
            let nodes = match &spec.on {
                Some(region) => regions::nodes(mesh, region, &spec.spot)?,
                None => (0..mesh.nodes.len() as u32).collect(),
            };
            let [x, y, z] = value;
            Load::Nodal { nodes, value: [nodal(mesh, x)?, nodal(mesh, y)?, nodal(mesh, z)?] }
        }
        LoadKind::Gravity(acceleration) => Load::Gravity { cells: cells()?, acceleration: acceleration.clone() },
        LoadKind::Rotation { axis, point, speed } => {
            Load::Rotation { cells: cells()?, axis: *axis, point: *point, speed: speed.clone() }
        }
        LoadKind::Temperature(field) => Load::Temperature { cells: cells()?, value: Temperature::Field(field.clone()) },
        LoadKind::TemperatureArray { name, ramp, spot } => {
            let ramp = ramp.clone();
            let value = match find(mesh, name, spot)? {
                Found::Nodes(array) => Temperature::Nodal { values: array.values.clone(), ramp },
                Found::Cells(array) => Temperature::OfCells { values: array.values.clone(), ramp },
            };
            Load::Temperature { cells: cells()?, value }
        }
    })
}

/// A component of the force at nodes.
fn nodal(mesh: &Mesh, spec: &NodalSpec) -> Result<Nodal, Error> {
    match spec {
        NodalSpec::Field(field) => Ok(Nodal::Field(field.clone())),
        NodalSpec::Array { name, ramp, spot } => match find(mesh, name, spot)? {
            Found::Nodes(array) => Ok(Nodal::Values { values: array.values.clone(), ramp: ramp.clone() }),
            Found::Cells(_) => {
                let what = format!("the array \"{name}\" has a number for each cell, not for each point");
                Err(spot.error(what, "name an array of points"))
            }
        },
    }
}

/// Each cell has one temperature at most.
pub(crate) fn one_temperature(mesh: &Mesh, loads: &[Load], specs: &[LoadSpec]) -> Result<(), Error> {
    let heated = loads.iter().zip(specs).filter_map(|(load, spec)| match load {
        Load::Temperature { cells, .. } => Some((&cells[..], &spec.spot)),
        _ => None,
    });
    one_temperature_each(mesh.cell_count(), heated)
}

/// The same of so many cells, by those that loads heat.
pub(crate) fn one_temperature_each<'a>(
    count: usize,
    loads: impl Iterator<Item = (&'a [u32], &'a Spot)>,
) -> Result<(), Error> {
    let mut heated = vec![false; count];
    for (cells, spot) in loads {
        let twice = cells.iter().filter(|&&cell| heated[cell as usize]).count();
        if twice > 0 {
            let what = format!("{twice} cells have a temperature already from a [[load]] above");
            return Err(spot.error(what, "give each cell one temperature: temperatures do not add up"));
        }
        cells.iter().for_each(|&cell| heated[cell as usize] = true);
    }
    Ok(())
}

/// The lowest and the highest temperature at the nodes of the heated cells.
pub(crate) fn temperatures(solid: &Solid, load: &Load, t: f64) -> Option<[f64; 2]> {
    let Load::Temperature { cells, value } = load else { return None };
    let mut heated = vec![false; solid.mesh.cell_count()];
    cells.iter().for_each(|&cell| heated[cell as usize] = true);
    let all = solid.mesh.cell_iter().zip(heated).filter(|(_, heated)| *heated).flat_map(|((_, nodes), _)| nodes);
    let range = |[low, high]: [f64; 2], value: f64| [low.min(value), high.max(value)];
    let at = |&node: &u32| match value {
        Temperature::OfCells { .. } => f64::NAN,
        Temperature::Field(field) => field.at(solid.mesh.nodes[node as usize], t),
        Temperature::Nodal { values, .. } => values[node as usize],
    };
    if let Temperature::OfCells { values, .. } = value {
        return Some(cells.iter().map(|&cell| values[cell as usize]).fold([f64::INFINITY, f64::NEG_INFINITY], range));
    }
    Some(all.map(at).fold([f64::INFINITY, f64::NEG_INFINITY], range))
}

pub(crate) fn describe(spec: &LoadSpec, resultant: [f64; 3]) -> LoadFacts {
    let kind = match spec.kind {
        LoadKind::Traction(_) => "traction",
        LoadKind::Pressure(_) => "pressure",
        LoadKind::Force(_) => "force",
        LoadKind::Resultant { .. } => "force and moment",
        LoadKind::Hydrostatic { .. } => "hydrostatic pressure",
        LoadKind::Nodal(_) => "force at nodes",
        LoadKind::Gravity(_) => "gravity",
        LoadKind::Rotation { .. } => "rotation",
        LoadKind::Temperature(_) | LoadKind::TemperatureArray { .. } => "temperature",
    };
    let everywhere = if spec.kind.at_nodes() { "all nodes" } else { "the whole body" };
    let on = spec.on.as_ref().map_or(everywhere.to_string(), regions::name);
    LoadFacts { on, kind, extent: 0.0, resultant, range: None }
}

/// Area of the faces, volume of the cells or number of the nodes a load acts on.
fn extent(mesh: &Mesh, load: &Load) -> f64 {
    match load {
        Load::Traction { faces, .. }
        | Load::Pressure { faces, .. }
        | Load::Force { faces, .. }
        | Load::Resultant { faces, .. }
        | Load::Hydrostatic { faces, .. } => faces.iter().map(|&face| mesh.face_area(face as usize)).sum(),
        Load::Nodal { nodes, .. } => nodes.len() as f64,
        Load::Gravity { cells, .. } | Load::Rotation { cells, .. } | Load::Temperature { cells, .. } => {
            cells.iter().map(|&cell| mesh.cell_volume(cell as usize)).sum()
        }
    }
}
