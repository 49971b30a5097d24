use std::array::from_fn;
use std::sync::LazyLock;

use rayon::prelude::*;

use super::elastic::Voigt;
use super::elements::{Element, Hex8, Hex20, Law, Tet4, Tet10, Wedge6, Wedge15, inverse};
use super::{FeModel, Solid};
use crate::mesh::geometry::{HEX_CORNERS, corners};
use crate::mesh::shape::{HEX20, WEDGE6, WEDGE15};
use crate::mesh::v3::{V3, add, scale, sub};
use crate::mesh::{CellKind, Mesh};

/// Displacements of all nodes along x, y, z, `3 i + c`, from those of the unknowns (length `n`).
///
/// # Panics
/// If `u_free` has not one entry per unknown.
pub fn full_displacement(model: &FeModel, u_free: &[f64]) -> Vec<f64> {
    let dofs = &model.dofs;
    assert_eq!(u_free.len(), dofs.free.len());
    let mut u = vec![0.0; 3 * dofs.nodes()];
    let in_mesh = dofs.free.partition_point(|&dof| (dof as usize) < u.len());
    dofs.free[..in_mesh].iter().zip(u_free).for_each(|(&dof, &value)| u[dof as usize] = value);
    dofs.prescribed.iter().zip(&dofs.value).for_each(|(&dof, &value)| u[dof as usize] = value);
    dofs.to_vectors(&mut u);
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
/// A cell that [`assemble`](super::assemble) would refuse gets NaN. `initial` is the mean strain of each cell that causes no
/// stress (temperature, see [`InitialStrain`](super::InitialStrain)); empty if there is none.
///
/// # Panics
/// If `u_full` has not three entries per node.
pub fn cell_stress(solid: &Solid, u_full: &[f64], initial: &[Voigt]) -> Vec<Voigt> {
    cell_stress_as(solid, u_full, initial, |stress| stress).collect()
}

/// What `report` makes of the [`cell_stress`] of each cell, cell by cell and by all threads.
pub(crate) fn cell_stress_as<'a, T: Send>(
    solid: &Solid<'a>,
    u_full: &'a [f64],
    initial: &'a [Voigt],
    report: impl Fn(Voigt) -> T + Send + Sync + 'a,
) -> impl IndexedParallelIterator<Item = T> + 'a {
    let Solid { mesh, materials, material_of_cell } = *solid;
    assert_eq!(u_full.len(), 3 * mesh.nodes.len());
    let cells = solid.cells();
    let laws: Vec<Law> = materials.iter().map(Law::new).collect();
    let of_cell = move |(cell, &material): (usize, &u32)| {
        let (kind, nodes) = cells.get(cell);
        let law = laws[material as usize];
        let (x, displacement): (_, &[V3]) = (&mesh.nodes, u_full.as_chunks().0);
        let u = |node: u32| displacement[node as usize];
        let gradient = match kind {
            CellKind::Tet4 => Tet4::new(&corners(x, nodes)).map(|e| mean_gradient(&e, nodes, u)),
            CellKind::Hex8 => Hex8::averaged(&corners(x, nodes)).map(|e| mean_gradient(&e, nodes, u)),
            CellKind::Tet10 => Tet10::new(&corners(x, nodes)).map(|e| mean_gradient(&e, nodes, u)),
            CellKind::Hex20 => Hex20::new(&corners(x, nodes)).map(|e| mean_gradient(&e, nodes, u)),
            CellKind::Wedge6 => Wedge6::new(&corners(x, nodes)).map(|e| mean_gradient(&e, nodes, u)),
            CellKind::Wedge15 => Wedge15::new(&corners(x, nodes)).map(|e| mean_gradient(&e, nodes, u)),
        };
        let Some(h) = gradient else { return report([f64::NAN; 6]) };
        let mut strain = strain_of(&h);
        if let Some(free) = initial.get(cell) {
            strain.iter_mut().zip(free).for_each(|(e, free)| *e -= free);
        }
        report(law.stress(&strain))
    };
    material_of_cell.par_iter().enumerate().with_min_len(1024).map(of_cell)
}

/// Derivatives of the shape functions at the middle of a kind of cell, along its own coordinates.
fn middle(kind: CellKind) -> &'static [V3] {
    static TET4: [V3; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // With all coordinates 1/4 corners have none, and the middle of an edge has the sum of its ends.
    static TET10: LazyLock<[V3; 10]> = LazyLock::new(|| {
        from_fn(|i| match i.checked_sub(4) {
            None => [0.0; 3],
            Some(edge) => {
                let [a, b] = CellKind::Tet10.edges()[edge];
                add(TET4[a], TET4[b])
            }
        })
    });
    static HEX8: LazyLock<[V3; 8]> = LazyLock::new(|| HEX_CORNERS.map(|corner| scale(0.125, corner)));
    // Of the 3 x 3 x 3 Gauss points the one in the middle.
    const CENTRE: usize = 13;
    // The functions of a linear wedge have the mean of their derivatives there.
    static WEDGE6_MIDDLE: LazyLock<[V3; 6]> = LazyLock::new(|| {
        from_fn(|i| WEDGE6.iter().fold([0.0; 3], |sum, at| add(sum, at.gradient[i])).map(|g| g / 6.0))
    });
    // Of the 7 x 3 points the one in the middle.
    const AXIS: usize = 7;
    match kind {
        CellKind::Tet4 => &TET4,
        CellKind::Hex8 => &*HEX8,
        CellKind::Tet10 => &*TET10,
        CellKind::Hex20 => &HEX20[CENTRE].gradient,
        CellKind::Wedge6 => &*WEDGE6_MIDDLE,
        CellKind::Wedge15 => &WEDGE15[AXIS].gradient,
    }
}

/// The gradient of the displacement at the middle of a cell, `h[a][b] = ∂u_a/∂x_b`, where its nodes are displaced by `displacement`;
/// `None` if it is folded there.
#[inline]
pub(crate) fn middle_gradient(
    mesh: &Mesh,
    kind: CellKind,
    nodes: &[u32],
    displacement: impl Fn(u32) -> V3,
) -> Option<[V3; 3]> {
    let (mut along, mut moved) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    if let (CellKind::Tet4, &[origin, ref others @ ..]) = (kind, nodes) {
        // The derivatives are the edges: most of the sums below are of zeros.
        let (x, u) = (mesh.nodes[origin as usize], displacement(origin));
        for (k, &node) in others.iter().enumerate() {
            along[k] = sub(mesh.nodes[node as usize], x);
            moved[k] = sub(displacement(node), u);
        }
    } else {
        for (&node, derivative) in nodes.iter().zip(middle(kind)) {
            let (x, u) = (mesh.nodes[node as usize], displacement(node));
            for (k, &d) in derivative.iter().enumerate() {
                along[k] = add(along[k], scale(d, x));
                moved[k] = add(moved[k], scale(d, u));
            }
        }
    }
    let (_, own) = inverse(along)?;
    Some(from_fn(|a| from_fn(|b| (0..3).map(|k| moved[k][a] * own[k][b]).sum())))
}

#[inline]
pub(super) fn mean_gradient<const N: usize, const Q: usize>(
    e: &Element<N, Q>,
    nodes: &[u32],
    displacement: impl Fn(u32) -> V3,
) -> [V3; 3] {
    let per_volume = 1.0 / e.volume();
    let gradients = e.integrated_gradient().map(|g| scale(per_volume, g));
    gradient(nodes.iter().map(|&node| displacement(node)).zip(gradients))
}

/// Strain from the displacements of the nodes and the gradients of their shape functions.
#[inline]
pub(crate) fn strain(of_nodes: impl Iterator<Item = (V3, V3)>) -> Voigt {
    strain_of(&gradient(of_nodes))
}

#[inline]
fn gradient(of_nodes: impl Iterator<Item = (V3, V3)>) -> [V3; 3] {
    let mut h = [[0.0; 3]; 3];
    for (u, g) in of_nodes {
        for a in 0..3 {
            for b in 0..3 {
                h[a][b] += u[a] * g[b];
            }
        }
    }
    h
}

/// Strain from the gradient of the displacement, `h[a][b] = ∂u_a/∂x_b`.
#[inline]
pub(crate) fn strain_of(h: &[V3; 3]) -> Voigt {
    [h[0][0], h[1][1], h[2][2], h[0][1] + h[1][0], h[1][2] + h[2][1], h[0][2] + h[2][0]]
}

/// Von Mises' equivalent stress of a stress in the order xx, yy, zz, xy, yz, xz.
pub fn von_mises(s: &[f64; 6]) -> f64 {
    let direct = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
    (0.5 * direct + 3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5])).sqrt()
}
