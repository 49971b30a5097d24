//! Strain that causes no stress: thermal expansion.

use rayon::prelude::*;

use super::elastic::{PLACE, Voigt};
use super::elements::{Element, Hex8, Law, Tet4, folded, volume_points};
use super::{Load, Solid, Temperature};
use crate::Error;
use crate::mesh::geometry::corners;
use crate::mesh::v3::V3;
use crate::mesh::{CellKind, Mesh};

/// What the strain `e0` of cells amounts to: the body stores `1/2 u'Ku - force'u + energy`, the energy of `e(u) - e0`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InitialStrain {
    /// Mean of `e0` over each cell; empty if there is none.
    pub strain: Vec<Voigt>,
    /// `∫ Bᵀ C e0`, newton, one entry per degree of freedom; without resultant and moment in each cell.
    pub force: Vec<f64>,
    /// `1/2 ∫ e0 C e0`, energy.
    pub energy: f64,
}

/// The thermal strain of `load` at time `t`; `None` if it is no temperature.
///
/// Elements take the mean temperature of a cell, whose strain their displacements can follow: a temperature that
/// varies within a linear cell would stress it although it may expand freely.
///
/// # Errors
/// A material without expansion in the heated region, a temperature that is not finite.
pub fn initial_strain(solid: &Solid, load: &Load, t: f64) -> Result<Option<InitialStrain>, Error> {
    let Load::Temperature { cells, value } = load else { return Ok(None) };
    let ramp = match value {
        Temperature::Field(_) => 1.0,
        Temperature::Nodal { values, ramp } if values.len() == solid.mesh.nodes.len() => {
            // It has no place: an expression that reads one gives NaN and is refused.
            ramp.finite_at([f64::NAN; 3], t)?
        }
        Temperature::Nodal { values, .. } => {
            let what = format!("there are {} temperatures for {} nodes", values.len(), solid.mesh.nodes.len());
            return Err(Error::new("", what, "give one for each node"));
        }
    };
    let list = solid.cells();
    let laws: Vec<Law> = solid.materials.iter().map(Law::new).collect();
    let of_cell = |&cell: &u32| -> Result<(Voigt, Vec<V3>, f64), Error> {
        let number = solid.material_of_cell[cell as usize] as usize;
        let material = &solid.materials[number];
        let expansion = material.expansion.ok_or_else(|| {
            let what = format!("the temperature acts on material \"{}\", which has no expansion", material.name);
            Error::new("", what, "add expansion = 12e-6 (or 0) to the material, or name the heated cells in `on`")
        })?;
        let (kind, nodes) = list.get(cell as usize);
        let refused = || folded(solid, cell as usize, kind, nodes);
        let temperature = mean_temperature(solid.mesh, kind, nodes, value, t)?.ok_or_else(refused)?;
        if !temperature.is_finite() {
            let what = format!(
                "the temperature at {} is {temperature}",
                super::field::point(solid.mesh.nodes[nodes[0] as usize])
            );
            return Err(Error::new("", what, "give a finite temperature at every node of the heated cells"));
        }
        let rise = ramp * (temperature - material.reference_temperature);
        let strain = expansion.map(|a| a * rise);
        let (gradients, volume) = match kind {
            CellKind::Tet4 => Tet4::new(&corners(&solid.mesh.nodes, nodes)).map(|e| integrated(&e)),
            CellKind::Hex8 => Hex8::new(&corners(&solid.mesh.nodes, nodes)).map(|e| integrated(&e)),
        }
        .ok_or_else(refused)?;
        let stress = laws[number].stress(&strain);
        let force = |g: &V3| [0, 1, 2].map(|a| (0..3).map(|b| stress[PLACE[a][b]] * g[b]).sum());
        let energy = 0.5 * volume * stress.iter().zip(&strain).map(|(s, e)| s * e).sum::<f64>();
        Ok((strain, gradients.iter().map(force).collect(), energy))
    };
    if let Some(cell) = cells.iter().find(|&&cell| cell as usize >= solid.material_of_cell.len()) {
        let what = format!("cell {cell} does not exist, the mesh has {}", solid.material_of_cell.len());
        return Err(Error::new("", what, "name cells of the mesh"));
    }
    // Cells are integrated in parallel and added in their order: the sum does not depend on the threads.
    let parts: Vec<Result<_, Error>> = cells.par_iter().with_min_len(1024).map(of_cell).collect();
    let mut initial = InitialStrain {
        strain: vec![[0.0; 6]; solid.material_of_cell.len()],
        force: vec![0.0; 3 * solid.mesh.nodes.len()],
        energy: 0.0,
    };
    for (&cell, part) in cells.iter().zip(parts) {
        let (strain, forces, energy) = part?;
        initial.strain[cell as usize] = strain;
        initial.energy += energy;
        for (&node, force) in list.get(cell as usize).1.iter().zip(forces) {
            (0..3).for_each(|c| initial.force[3 * node as usize + c] += force[c]);
        }
    }
    Ok(Some(initial))
}

fn integrated<const N: usize, const Q: usize>(element: &Element<N, Q>) -> (Vec<V3>, f64) {
    (element.integrated_gradient().to_vec(), element.volume())
}

/// The mean over a cell; `None` if it is folded.
fn mean_temperature(
    mesh: &Mesh,
    kind: CellKind,
    nodes: &[u32],
    value: &Temperature,
    t: f64,
) -> Result<Option<f64>, Error> {
    let Some(points) = volume_points(kind, mesh, nodes) else { return Ok(None) };
    let (mut sum, mut volume) = (0.0, 0.0);
    for point in points {
        let at = match value {
            Temperature::Field(field) => field.finite_at(point.position, t)?,
            Temperature::Nodal { values, .. } => {
                nodes.iter().zip(point.shape).map(|(&node, shape)| shape * values[node as usize]).sum()
            }
        };
        sum += point.weight * at;
        volume += point.weight;
    }
    Ok(Some(sum / volume))
}
