use rayon::prelude::*;

use super::elements::{Element, Hex8, Hex20, Law, Tet4, Tet10};
use super::{FeModel, Solid};
use crate::mesh::CellKind;
use crate::mesh::geometry::corners;

/// Displacements of all nodes, `3 i + c`, from those of the unknowns (length `n`).
///
/// # Panics
/// If `u_free` has not one entry per unknown.
pub fn full_displacement(model: &FeModel, u_free: &[f64]) -> Vec<f64> {
    let dofs = &model.dofs;
    assert_eq!(u_free.len(), dofs.free.len());
    let mut u = vec![0.0; dofs.unknown.len()];
    dofs.free.iter().zip(u_free).for_each(|(&dof, &value)| u[dof as usize] = value);
    dofs.prescribed.iter().zip(&dofs.value).for_each(|(&dof, &value)| u[dof as usize] = value);
    u
}

/// Forces the supports exert on the body at the prescribed degrees of freedom, newton, length `p`:
/// `K_pf u + K_pp u_p - f_p`. Forces of contact at prescribed degrees of freedom are not included.
///
/// # Panics
/// If `u_free` has not one entry per unknown.
pub fn reactions(model: &FeModel, u_free: &[f64]) -> Vec<f64> {
    let from_free = model.support_stiffness.times(u_free);
    let from_support = model.support_support.times(&model.dofs.value);
    let parts = from_free.into_iter().zip(from_support).zip(&model.support_load);
    parts.map(|((free, support), load)| free + support - load).collect()
}

/// Stress of each cell as xx, yy, zz, xy, yz, xz (the order of VTK), averaged over its volume; tension is positive.
///
/// The mean dilatation of B-bar and the dilatation have the same average, so both formulations read alike.
/// A cell that [`assemble`](super::assemble) would refuse gets NaN.
///
/// # Panics
/// If `u_full` has not three entries per node.
pub fn cell_stress(solid: &Solid, u_full: &[f64]) -> Vec<[f64; 6]> {
    assert_eq!(u_full.len(), 3 * solid.mesh.nodes.len());
    let cells = solid.cells();
    let laws: Vec<Law> = solid.materials.iter().map(Law::new).collect();
    let of_cell = |(cell, &material): (usize, &u32)| {
        let (kind, nodes) = cells.get(cell);
        let law = laws[material as usize];
        let stress = match kind {
            CellKind::Tet4 => {
                Tet4::new(&corners(&solid.mesh.nodes, nodes)).map(|e| mean_stress(&e, law, nodes, u_full))
            }
            CellKind::Hex8 => {
                Hex8::new(&corners(&solid.mesh.nodes, nodes)).map(|e| mean_stress(&e, law, nodes, u_full))
            }
            CellKind::Tet10 => {
                Tet10::new(&corners(&solid.mesh.nodes, nodes)).map(|e| mean_stress(&e, law, nodes, u_full))
            }
            CellKind::Hex20 => {
                Hex20::new(&corners(&solid.mesh.nodes, nodes)).map(|e| mean_stress(&e, law, nodes, u_full))
            }
        };
        stress.unwrap_or([f64::NAN; 6])
    };
    solid.material_of_cell.par_iter().enumerate().with_min_len(1024).map(of_cell).collect()
}

fn mean_stress<const N: usize, const Q: usize>(e: &Element<N, Q>, law: Law, nodes: &[u32], u: &[f64]) -> [f64; 6] {
    let mut h = [[0.0; 3]; 3]; // mean displacement gradient, h[a][b] = ∂u_a/∂x_b
    for (&node, g) in nodes.iter().zip(e.integrated_gradient()) {
        for a in 0..3 {
            for b in 0..3 {
                h[a][b] += u[3 * node as usize + a] * g[b] / e.volume();
            }
        }
    }
    let pressure = law.lambda * (h[0][0] + h[1][1] + h[2][2]);
    let direct = |a: usize| pressure + 2.0 * law.mu * h[a][a];
    let shear = |a: usize, b: usize| law.mu * (h[a][b] + h[b][a]);
    [direct(0), direct(1), direct(2), shear(0, 1), shear(1, 2), shear(0, 2)]
}

/// Von Mises' equivalent stress of a stress in the order xx, yy, zz, xy, yz, xz.
pub fn von_mises(s: &[f64; 6]) -> f64 {
    let direct = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
    (0.5 * direct + 3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5])).sqrt()
}
