//! Bolts: where they are cut, how far they are drawn together, and what force that takes.

use std::collections::HashMap;

use super::cut_sides::{holds_along, pressed_at, refuse_loose, whole_sides};
use super::facts::BoltFacts;
use super::load_state::{LoadState, Loading};
use super::{Prepared, place, regions};
use crate::Error;
use crate::fem::{Cut, DofMap, Field, Load, Solid, cut, initial_strain};
use crate::io::case::{BoltSpec, Case, Region, Spot, Tightening};
use crate::io::text::number;
use crate::mesh::v3::{V3, add, cross, dot, mean, norm, scale, sub};
use crate::mesh::{Mesh, ascending};

/// A bolt on the mesh.
#[derive(Debug, Clone)]
pub struct Bolt {
    /// Its name.
    pub name: String,
    /// The cut through its shank.
    pub cut: Cut,
    /// Force or shortening.
    pub by: Tightening,
    /// The step after which the shortening stays, counted from 0.
    pub lock: Option<usize>,
    /// Where the case file asks for it.
    pub spot: Spot,
}

/// What is known of a bolt at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Target {
    Force(f64),
    Shortening(f64),
    /// The shortening of the step before.
    Locked,
}

impl Bolt {
    pub(crate) fn is_by_force(&self) -> bool {
        matches!(self.by, Tightening::Force(_))
    }

    /// What is prescribed of it at time `t` in step number `step` (from 0).
    pub(crate) fn target(&self, step: usize, t: f64) -> Result<Target, Error> {
        match self.lock {
            Some(lock) if step > lock => Ok(Target::Locked),
            _ if self.is_by_force() => {
                let force = self.value(t)?;
                if force < 0.0 {
                    let what = format!("bolt \"{}\" is to push with {:.4e} at t = {t}", self.name, -force);
                    let remedy = "give the force with which it draws its parts together, zero or more";
                    return Err(self.spot.error(what, remedy));
                }
                Ok(Target::Force(force))
            }
            _ => self.value(t).map(Target::Shortening),
        }
    }

    fn value(&self, t: f64) -> Result<f64, Error> {
        let (Tightening::Force(field) | Tightening::Shortening(field)) = &self.by;
        // It has no place: an expression that reads one gives NaN and is refused.
        Field::finite_at(field, [f64::NAN; 3], t).map_err(|error| place::instead(&self.spot, error))
    }
}

impl Loading {
    /// What is prescribed of each bolt at time `t` in step number `step` (from 0).
    pub(crate) fn targets(&self, step: usize, t: f64) -> Result<Vec<Target>, Error> {
        self.bolts.iter().map(|bolt| bolt.target(step, t)).collect()
    }

    /// The shortening of each bolt at time `t`, zero where it is to be found or is locked.
    pub(crate) fn given_shortening(&self, t: f64) -> Result<Vec<f64>, Error> {
        let given = |bolt: &Bolt| if bolt.is_by_force() || bolt.lock.is_some() { Ok(0.0) } else { bolt.value(t) };
        self.bolts.iter().map(given).collect()
    }
}

/// The bolts of a case with their cuts; facts for time `t`.
pub(crate) fn bolts(solid: &Solid, dofs: &DofMap, case: &Case, t: f64) -> Result<(Vec<Bolt>, Vec<BoltFacts>), Error> {
    let (mut bolts, mut facts) = (Vec::new(), Vec::new());
    let mut taken: HashMap<u32, String> = HashMap::new();
    for spec in &case.bolts {
        let (cells, nodes, axis) = find(solid.mesh, spec)?;
        let pressed = pressed_at(solid.mesh, case, &nodes, axis);
        let (cells, along) = whole_sides(solid.mesh, spec, (cells, &nodes, axis), &pressed)?;
        refuse_held(solid.mesh, dofs, spec, &nodes, axis)?;
        for &cell in &cells {
            if let Some(other) = taken.insert(cell, spec.name.clone()) {
                let what = format!("bolt \"{}\" is cut through a cell of bolt \"{other}\"", spec.name);
                return Err(spec.spot.error(what, "let each bolt have cells of its own, and name it once"));
            }
        }
        let cut = cut(solid, cells, nodes, along).map_err(|error| place::at(&spec.spot, error))?;
        let (name, by, lock, spot) = (spec.name.clone(), spec.by.clone(), spec.lock, spec.spot.clone());
        let bolt = Bolt { name, cut, by, lock, spot };
        refuse_loose(solid.mesh, case, dofs, &bolt)?;
        let by = if bolt.is_by_force() { "force" } else { "shortening" };
        let (name, nodes, cells) = (bolt.name.clone(), bolt.cut.nodes.len(), bolt.cut.cells.len());
        facts.push(BoltFacts { name, axis, nodes, cells, by, value: bolt.value(t)? });
        // A later step is not to end a run that has begun.
        for (step, spec) in case.steps.iter().enumerate() {
            bolt.target(step, spec.until)?;
        }
        bolts.push(bolt);
    }
    Ok((bolts, facts))
}

/// A support at the cut would act on one of its sides only.
fn refuse_held(mesh: &Mesh, dofs: &DofMap, spec: &BoltSpec, nodes: &[u32], axis: V3) -> Result<(), Error> {
    let is_held = |dof: u32| holds_along(dofs, dof, axis) && dofs.prescribed.binary_search(&dof).is_ok();
    let held = |node: &&u32| (3 * **node..3 * **node + 3).any(is_held);
    let Some(&node) = nodes.iter().find(held) else { return Ok(()) };
    let at = mesh.nodes[node as usize];
    let what =
        format!("the cut of bolt \"{}\" runs through node {} at {at:?}, which is held along it", spec.name, node + 1);
    Err(spec.spot.error(what, "cut it further from its supports: give another `point`"))
}

/// Cells beyond the cut, its nodes, and its axis.
fn find(mesh: &Mesh, spec: &BoltSpec) -> Result<(Vec<u32>, Vec<u32>, V3), Error> {
    let between = match &spec.on {
        Region::Groups(names) => {
            names.iter().flat_map(|(name, _)| mesh.group(name)).any(|g| !g.interior_faces.is_empty())
        }
        _ => false,
    };
    if between { by_faces(mesh, spec) } else { by_plane(mesh, spec) }
}

/// The plane through a point across the axis cuts the cells of the bolt, along their faces.
fn by_plane(mesh: &Mesh, spec: &BoltSpec) -> Result<(Vec<u32>, Vec<u32>, V3), Error> {
    let cells = regions::cells(mesh, &spec.on, &spec.spot)?;
    let Some(axis) = spec.axis else {
        let what = format!("bolt \"{}\" is given by its cells and has no axis", spec.name);
        return Err(spec.spot.error(what, "add axis = [0, 0, 1] or its direction, and `point` where it is to be cut"));
    };
    let along = |cell: u32| dot(axis, centre(mesh, cell));
    let (low, high) = mesh
        .cell_nodes(&cells)
        .iter()
        .map(|&node| dot(axis, mesh.nodes[node as usize]))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let level = spec.point.map_or(0.5 * (low + high), |point| dot(axis, point));
    let (beyond, before): (Vec<u32>, Vec<u32>) = cells.iter().partition(|&&cell| along(cell) > level);
    let far = mesh.cell_nodes(&before);
    let nodes: Vec<u32> = mesh.cell_nodes(&beyond).into_iter().filter(|node| far.binary_search(node).is_ok()).collect();
    if nodes.is_empty() {
        let what = format!(
            "the plane at {level} along the axis leaves no cells of bolt \"{}\", which reaches from {low} to {high}, on both sides: \
             it is cut along faces of cells, and a cell is beyond the plane if its centre is",
            spec.name
        );
        let centres = cells.iter().map(|&cell| along(cell));
        let [first, last] = centres.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
        let remedy = match first < last {
            true => format!("give a `point` at {} or more, and below {}, along the axis", number(first), number(last)),
            false => "give the bolt more than one layer of cells along its axis".into(),
        };
        return Err(spec.spot.error(what, remedy));
    }
    let touching = |cell: &u32| mesh.cell(*cell as usize).1.iter().any(|node| nodes.binary_search(node).is_ok());
    Ok((beyond.into_iter().filter(touching).collect(), nodes, axis))
}

/// How far nodes of a cut may lie off its plane, as a part of its size: that plane tells the sides apart.
const FLAT: f64 = 1e-3;

/// The faces of a group between cells are the cut.
fn by_faces(mesh: &Mesh, spec: &BoltSpec) -> Result<(Vec<u32>, Vec<u32>, V3), Error> {
    let Region::Groups(names) = &spec.on else { return Ok(Default::default()) };
    let faces: Vec<Vec<u32>> = names
        .iter()
        .flat_map(|(name, _)| mesh.group(name))
        .flat_map(|group| &group.interior_faces)
        .map(|face| face.iter().copied().filter(|&node| node != u32::MAX).collect())
        .collect();
    let corners = ascending(faces.concat());
    let x = |node: u32| mesh.nodes[node as usize];
    let middle = mean(corners.iter().map(|&node| x(node)));
    let mut normal = [0.0; 3];
    for face in &faces {
        let n = cross(sub(x(face[1]), x(face[0])), sub(x(face[face.len() - 1]), x(face[0])));
        // Faces between cells turn either way.
        normal = add(normal, if dot(n, normal) < 0.0 { scale(-1.0, n) } else { n });
    }
    let normal = scale(1.0 / norm(normal), normal);
    let size = corners.iter().map(|&node| norm(sub(x(node), middle))).fold(0.0, f64::max);
    let off = corners.iter().map(|&node| dot(normal, sub(x(node), middle)).abs()).fold(0.0, f64::max);
    if off > FLAT * size {
        let what = format!("the faces of bolt \"{}\" are not flat: some lie {off:.3e} off their plane", spec.name);
        return Err(spec.spot.error(what, "name the cells of the bolt in `on` instead, with `axis` and `point`"));
    }
    let axis = spec.axis.unwrap_or(normal);
    let lean = dot(axis, normal);
    if lean.abs() < 0.5 {
        let what =
            format!("the axis {axis:?} of bolt \"{}\" does not cross its cut with the normal {normal:.4?}", spec.name);
        return Err(spec.spot.error(what, "take `axis` out, or name faces across it"));
    }
    let side = |cell: u32| lean.signum() * dot(normal, sub(centre(mesh, cell), middle));
    let at_corner = |nodes: &[u32]| nodes.iter().filter(|node| corners.binary_search(node).is_ok()).count();
    let touching: Vec<u32> =
        (0u32..).zip(mesh.cell_iter()).filter(|(_, (_, nodes))| at_corner(nodes) > 0).map(|(cell, _)| cell).collect();
    // Nodes between corners belong to the cut as well: those that cells with a whole face in it share across it.
    let facing = |beyond: bool| {
        let cells =
            touching.iter().copied().filter(|&c| at_corner(mesh.cell(c as usize).1) >= 3 && (side(c) > 0.0) == beyond);
        mesh.cell_nodes(&cells.collect::<Vec<u32>>())
    };
    let far = facing(false);
    let nodes: Vec<u32> = facing(true).into_iter().filter(|node| far.binary_search(node).is_ok()).collect();
    Ok((touching.into_iter().filter(|&cell| side(cell) > 0.0).collect(), nodes, axis))
}

fn centre(mesh: &Mesh, cell: u32) -> V3 {
    mean(mesh.cell(cell as usize).1.iter().map(|&node| mesh.nodes[node as usize]))
}

/// `axis . ∫ Bᵀ C e0` over the cells beyond each cut and at those of its nodes that `counts` says, `e0` the thermal strain of
/// `load` at time `t`.
pub(crate) fn thermal_forces(
    solid: &Solid,
    bolts: &[&Bolt],
    counts: &dyn Fn(u32) -> bool,
    load: &Load,
    t: f64,
) -> Result<Vec<f64>, Error> {
    let Load::Temperature { cells, value } = load else { return Ok(vec![0.0; bolts.len()]) };
    let of_bolt = |bolt: &&Bolt| {
        let heated: Vec<u32> = cells.iter().copied().filter(|c| bolt.cut.cells.binary_search(c).is_ok()).collect();
        let strain = initial_strain(solid, &Load::Temperature { cells: heated, value: value.clone() }, counts, t)?;
        let force = strain.unwrap_or_default().force;
        let at = |&node: &u32| (0..3).map(|c| bolt.cut.axis[c] * force[3 * node as usize + c]).sum::<f64>();
        Ok(bolt.cut.nodes.iter().filter(|node| counts(**node)).map(at).sum())
    };
    bolts.iter().map(of_bolt).collect()
}

/// What acts with the bolts drawn together by `shortening`.
pub(crate) fn tightened(prepared: &Prepared, mut loads: LoadState, shortening: &[f64]) -> LoadState {
    let bolts = &prepared.loading.bolts;
    if bolts.is_empty() {
        return loads;
    }
    let dofs = &prepared.model.dofs;
    let initial = &mut loads.initial;
    initial.load.resize(dofs.free.len(), 0.0);
    initial.support_load.resize(dofs.prescribed.len(), 0.0);
    initial.strain.resize(prepared.mesh.cell_count(), [0.0; 6]);
    initial.thermal_force.resize(bolts.len(), 0.0);
    initial.shortening = shortening.to_vec();
    for ((bolt, &s), &thermal) in bolts.iter().zip(shortening).zip(&initial.thermal_force) {
        initial.energy += 0.5 * s * s * bolt.cut.stiffness + s * thermal;
        for (dof, unit) in dofs.entries(&bolt.cut.force) {
            let number = dofs.unknown[dof as usize];
            if number != u32::MAX {
                initial.load[number as usize] += s * unit;
                loads.load[number as usize] += s * unit;
            } else if let Ok(p) = dofs.prescribed.binary_search(&dof) {
                initial.support_load[p] += s * unit;
                loads.support_load[p] += s * unit;
            }
        }
        for (&cell, unit) in bolt.cut.cells.iter().zip(&bolt.cut.strain) {
            (0..6).for_each(|k| initial.strain[cell as usize][k] += s * unit[k]);
        }
    }
    loads
}
