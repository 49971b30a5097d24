//! Strain that causes no stress: thermal expansion.

use rayon::prelude::*;

use super::elastic::{PLACE, Voigt};
use super::elements::{Element, Hex8, Hex20, Law, Tet4, Tet10, Wedge6, Wedge15, folded, volume_points};
use super::solid::all_exist;
use super::{Load, Solid, Temperature};
use crate::Error;
use crate::mesh::geometry::corners;
use crate::mesh::shape::{HEX20, TET10, WEDGE15};
use crate::mesh::v3::{V3, add, scale};
use crate::mesh::{CellKind, Cells, Mesh};

/// What the strain `e0` of cells amounts to: the body stores `1/2 u'Ku - force'u + energy`, the energy of `e(u) - e0`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InitialStrain {
    /// Mean of `e0` over each cell; empty if there is none.
    pub strain: Vec<Voigt>,
    /// Rise of temperature at the integration points of all quadratic cells, cell by cell; empty if none is heated.
    pub rise: Vec<f64>,
    /// `∫ Bᵀ C e0`, newton, one entry per degree of freedom; without resultant and moment in each cell.
    pub force: Vec<f64>,
    /// `1/2 ∫ e0 C e0`, energy.
    pub energy: f64,
}

/// The thermal strain of `load` at time `t`; `None` if it is no temperature. Its energy is that of the cells whose first node `counts`
/// says: where ranks share the mesh each cell is counted by one of them.
///
/// Linear cells take their mean temperature, whose strain their displacements can follow: one that varies within the
/// cell would stress it although it may expand freely. Quadratic cells take it at each of their integration points.
///
/// # Errors
/// A material without expansion in the heated region, a temperature that is not finite.
pub(crate) fn initial_strain(
    solid: &Solid,
    load: &Load,
    counts: &dyn Fn(u32) -> bool,
    t: f64,
) -> Result<Option<InitialStrain>, Error> {
    let Load::Temperature { cells, value } = load else { return Ok(None) };
    let ramp = match value {
        Temperature::Field(_) => 1.0,
        Temperature::Nodal { values, ramp } | Temperature::OfCells { values, ramp } => {
            let (places, name) = match value {
                Temperature::OfCells { .. } => (solid.mesh.cell_count(), "cells"),
                _ => (solid.mesh.nodes.len(), "nodes"),
            };
            if values.len() != places {
                let what = format!("there are {} temperatures for {places} {name}", values.len());
                return Err(Error::new("", what, "give one for each of them"));
            }
            // It has no place: an expression that reads one gives NaN and is refused.
            ramp.finite_at([f64::NAN; 3], t)?
        }
    };
    let list = solid.cells();
    let laws: Vec<Law> = solid.materials.iter().map(Law::new).collect();
    let of_cell = |&cell: &u32| -> Result<_, Error> {
        let number = solid.material_of_cell[cell as usize] as usize;
        let material = &solid.materials[number];
        let expansion = material.expansion.ok_or_else(|| {
            let what = format!("the temperature acts on material \"{}\", which has no expansion", material.name);
            Error::new("", what, "add expansion = 12e-6 (or 0) to the material, or name the heated cells in `on`")
        })?;
        let (kind, nodes) = list.get(cell as usize);
        let refused = || folded(solid, cell as usize, kind, nodes);
        let mut rise = rises(solid.mesh, cell, (kind, nodes), value, t)?.ok_or_else(refused)?;
        rise.iter_mut().for_each(|point| point.1 = ramp * (point.1 - material.reference_temperature));
        let (law, x) = (laws[number], &solid.mesh.nodes);
        let heated = match kind {
            CellKind::Tet4 => Tet4::new(&corners(x, nodes)).map(|e| heated(&e, law, &expansion, &rise)),
            CellKind::Hex8 => Hex8::new(&corners(x, nodes)).map(|e| heated(&e, law, &expansion, &rise)),
            CellKind::Tet10 => Tet10::new(&corners(x, nodes)).map(|e| heated(&e, law, &expansion, &rise)),
            CellKind::Hex20 => Hex20::new(&corners(x, nodes)).map(|e| heated(&e, law, &expansion, &rise)),
            CellKind::Wedge6 => Wedge6::new(&corners(x, nodes)).map(|e| heated(&e, law, &expansion, &rise)),
            CellKind::Wedge15 => Wedge15::new(&corners(x, nodes)).map(|e| heated(&e, law, &expansion, &rise)),
        };
        let of_points = if kind.edges().is_empty() { Vec::new() } else { rise.iter().map(|point| point.1).collect() };
        Ok((heated.ok_or_else(refused)?, of_points))
    };
    all_exist("cell", cells, solid.material_of_cell.len())?;
    // Cells are integrated in parallel and added in their order: the sum does not depend on the threads.
    let parts: Vec<Result<_, Error>> = cells.par_iter().with_min_len(1024).map(of_cell).collect();
    let points = quadratic_points(solid.mesh);
    let all_points = solid.mesh.cells.iter().zip(&points).map(|(block, [_, count])| count * block.len()).sum();
    let mut initial = InitialStrain {
        strain: vec![[0.0; 6]; solid.material_of_cell.len()],
        rise: Vec::new(),
        force: vec![0.0; 3 * solid.mesh.nodes.len()],
        energy: 0.0,
    };
    for (&cell, part) in cells.iter().zip(parts) {
        let ((strain, forces, energy), rise) = part?;
        if !rise.is_empty() {
            let (block, local) = list.place(cell as usize);
            let [first, count] = points[block];
            initial.rise.resize(all_points, 0.0);
            initial.rise[first + count * local..][..count].copy_from_slice(&rise);
        }
        initial.strain[cell as usize] = strain;
        let nodes = list.get(cell as usize).1;
        if counts(nodes[0]) {
            initial.energy += energy;
        }
        for (&node, force) in nodes.iter().zip(forces) {
            (0..3).for_each(|c| initial.force[3 * node as usize + c] += force[c]);
        }
    }
    Ok(Some(initial))
}

/// Of each block of cells the first of its integration points among those of all quadratic cells, and how many a cell has;
/// none of linear cells.
pub(crate) fn quadratic_points(mesh: &Mesh) -> Vec<[usize; 2]> {
    let mut first = 0;
    let of_block = |block: &Cells| {
        let count = match block.kind {
            CellKind::Tet4 | CellKind::Hex8 | CellKind::Wedge6 => 0,
            CellKind::Tet10 => TET10.len(),
            CellKind::Hex20 => HEX20.len(),
            CellKind::Wedge15 => WEDGE15.len(),
        };
        first += count * block.len();
        [first - count * block.len(), count]
    };
    mesh.cells.iter().map(of_block).collect()
}

/// Mean strain, nodal forces and energy of a cell from weights and rises of temperature at its points.
fn heated<const N: usize, const Q: usize>(
    element: &Element<N, Q>,
    law: Law,
    expansion: &Voigt,
    rise: &[(f64, f64)],
) -> (Voigt, Vec<V3>, f64) {
    let volume: f64 = rise.iter().map(|(weight, _)| weight).sum();
    let mean = rise.iter().map(|(weight, rise)| weight * rise).sum::<f64>() / volume;
    let unit = law.stress(expansion);
    let stress = |g: &V3| [0, 1, 2].map(|a| (0..3).map(|b| unit[PLACE[a][b]] * g[b]).sum::<f64>());
    let unit_energy = 0.5 * unit.iter().zip(expansion).map(|(s, e)| s * e).sum::<f64>();
    let strain = expansion.map(|a| a * mean);
    let linear = N == 4 || N == 6 || N == 8;
    if linear {
        let force = element.integrated_gradient().iter().map(|g| scale(mean, stress(g))).collect();
        return (strain, force, unit_energy * mean * mean * element.volume());
    }
    let mut force = vec![[0.0; 3]; N];
    for ((weight, rise), gradient) in rise.iter().zip(&element.gradient) {
        force.iter_mut().zip(gradient).for_each(|(f, g)| *f = add(*f, scale(weight * rise, stress(g))));
    }
    let square: f64 = rise.iter().map(|(weight, rise)| weight * rise * rise).sum();
    (strain, force, unit_energy * square)
}

/// Weights and temperatures at the points of a cell (of a quadratic one those of its stiffness); `None` if it is folded.
fn rises(
    mesh: &Mesh,
    cell: u32,
    (kind, nodes): (CellKind, &[u32]),
    value: &Temperature,
    t: f64,
) -> Result<Option<Vec<(f64, f64)>>, Error> {
    let Some(points) = volume_points(kind, mesh, nodes) else { return Ok(None) };
    let mut rises = Vec::with_capacity(points.len());
    for point in points {
        let at = match value {
            Temperature::Field(field) => field.finite_at(point.position, t)?,
            Temperature::Nodal { values, .. } => {
                nodes.iter().zip(point.shape).map(|(&node, shape)| shape * values[node as usize]).sum()
            }
            Temperature::OfCells { values, .. } => values[cell as usize],
        };
        if !at.is_finite() {
            let what = format!("the temperature at {} is {at}", super::field::point(point.position));
            return Err(Error::new(
                "",
                what,
                "give a finite temperature at every node of the heated cells, the middles of their edges included",
            ));
        }
        rises.push((point.weight, at));
    }
    Ok(Some(rises))
}
