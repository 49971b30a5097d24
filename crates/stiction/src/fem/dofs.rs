use std::collections::{BTreeMap, HashMap};

use super::field::point;
use super::rotated::Constrained;
use super::solid::all_exist;
use super::{Axes, DofMap, Fix, RotatedNode};
use crate::Error;
use crate::mesh::Mesh;

/// Two prescriptions of one component agree if they differ by no more than this part of the larger.
const SAME_VALUE: f64 = 1e-12;

/// In the place of a prescribed displacement, all of which are finite: there is none.
const FREE: f64 = f64::NAN;

/// Which displacement components `fixes` prescribe at time `t`, and their values.
///
/// An error where a node is prescribed two different values, where a value is not finite, or where a node is not
/// of the mesh.
///
/// # Errors
/// If a node is prescribed two different values, a value is not finite, or a node is not of the mesh.
pub fn dof_map(mesh: &Mesh, fixes: &[Fix], t: f64) -> Result<DofMap, Error> {
    let mut prescribed = vec![FREE; 3 * mesh.nodes.len()];
    for (number, fix) in fixes.iter().enumerate() {
        prescribe(mesh, fix, t, &mut prescribed).map_err(|e| e.at(&format!("fix {}", number + 1)))?;
    }
    let rotated = turn(mesh, fixes, t, &mut prescribed)?;
    let count = prescribed.iter().filter(|value| !value.is_nan()).count();
    let mut dofs = DofMap {
        unknown: Vec::with_capacity(prescribed.len()),
        free: Vec::with_capacity(prescribed.len() - count),
        prescribed: Vec::with_capacity(count),
        value: Vec::with_capacity(count),
        rotated,
        layer: Vec::new(),
        follows: HashMap::new(),
    };
    for (dof, value) in prescribed.into_iter().enumerate() {
        if value.is_nan() {
            dofs.unknown.push(dofs.free.len() as u32);
            dofs.free.push(dof as u32);
        } else {
            dofs.unknown.push(u32::MAX);
            dofs.prescribed.push(dof as u32);
            dofs.value.push(value);
        }
    }
    Ok(dofs)
}

/// The nodes constrained along a direction that is no axis, with axes of which the first are `prescribed` then.
fn turn(mesh: &Mesh, fixes: &[Fix], t: f64, prescribed: &mut [f64]) -> Result<Vec<RotatedNode>, Error> {
    let mut constrained: BTreeMap<u32, Constrained> = BTreeMap::new();
    for (number, fix) in fixes.iter().enumerate().filter(|(_, fix)| fix.axes != Axes::Global) {
        for &node in &fix.nodes {
            let x = mesh.nodes[node as usize];
            let place = || format!("fix {}, node {node} at {}", number + 1, point(x));
            let constrained =
                constrained.entry(node).or_insert_with(|| along_axes(&prescribed[3 * node as usize..][..3]));
            for (c, field) in fix.value.iter().enumerate() {
                let Some(field) = field else { continue };
                let value = field.finite_at(x, t).map_err(|e| e.at(&place()))?;
                let along = fix.axes.direction(c, x).ok_or_else(|| {
                    let what = "it lies on the axis of the cylinder, where no direction is radial or tangential";
                    Error::new(place(), what, "leave it out, and hold it by a [[fix]] of its own along x, y, z")
                })?;
                constrained.add(along, value).map_err(|other| {
                    let what =
                        format!("its displacement along {} is prescribed twice: {other} and {value}", point(along));
                    Error::new(place(), what, "keep one of the two, or let them agree where they meet")
                })?;
            }
        }
    }
    let rotated = |(node, constrained): (u32, Constrained)| {
        let (axes, values) = constrained.axes();
        prescribed[3 * node as usize..][..3].copy_from_slice(&values.map(|value| value.unwrap_or(FREE)));
        RotatedNode { node, axes }
    };
    Ok(constrained.into_iter().map(rotated).collect())
}

/// What is prescribed along x, y, z.
fn along_axes(components: &[f64]) -> Constrained {
    let mut constrained = Constrained::default();
    for (c, &value) in components.iter().enumerate().filter(|(_, value)| !value.is_nan()) {
        let axis = [0, 1, 2].map(|k| f64::from(u8::from(k == c)));
        // Axes are across one another: the second cannot contradict the first.
        let _ = constrained.add(axis, value);
    }
    constrained
}

/// What a fix along x, y, z prescribes.
fn prescribe(mesh: &Mesh, fix: &Fix, t: f64, prescribed: &mut [f64]) -> Result<(), Error> {
    all_exist("node", &fix.nodes, mesh.nodes.len())?;
    if fix.axes != Axes::Global {
        return Ok(());
    }
    for &node in &fix.nodes {
        let x = mesh.nodes[node as usize];
        for (c, field) in fix.value.iter().enumerate() {
            let Some(field) = field else { continue };
            let value = field.finite_at(x, t)?;
            let entry = &mut prescribed[3 * node as usize + c];
            if entry.is_nan() {
                *entry = value;
            }
            let first = *entry;
            if (first - value).abs() > SAME_VALUE * first.abs().max(value.abs()) {
                let axis = ["x", "y", "z"][c];
                return Err(Error::new(
                    format!("node {node} at {}", point(x)),
                    format!("its displacement along {axis} is prescribed twice: {first} and {value}"),
                    "keep one of the two, or let them agree where they meet",
                ));
            }
        }
    }
    Ok(())
}
