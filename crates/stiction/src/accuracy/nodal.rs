//! Stress and strain at the nodes, as viewers of finite elements show them: each cell extrapolates from its integration points to
//! its nodes, and a node has the mean of its cells.

use std::array::from_fn;
use std::sync::LazyLock;

use rayon::prelude::*;

use super::Straining;
use super::cells::{At, Body, combined};
use crate::fem::elements::{Element, Hex8, Hex20, MOST_NODES, Tet4, Tet10, Wedge6, Wedge15};
use crate::fem::{Solid, Voigt};
use crate::mesh::CellKind;
use crate::mesh::geometry::{GAUSS, HEX_CORNERS, corners};
use crate::mesh::shape::{GAUSS3, TET10, WEDGE_CORNERS, WEDGE6, WEDGE15, face_rule};

/// Stress and strain at each node of a mesh, in the order xx, yy, zz, xy, yz, xz.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NodalStress {
    /// Stress; tension is positive.
    pub stress: Vec<Voigt>,
    /// Strain, shear as the component of the tensor (half the angle), what causes no stress included.
    pub strain: Vec<Voigt>,
}

/// Cells whose values are found together before they are added in the order of the cells.
const CHUNK: usize = 8192;

/// Trilinear functions with the value 1 at one Gauss point and 0 at the others, at the corners: `[corner][point]`.
static FROM_GAUSS: LazyLock<[[f64; 8]; 8]> = LazyLock::new(|| {
    let along = |i: usize, q: usize| (0..3).map(move |a| 0.5 * (1.0 + HEX_CORNERS[i][a] * HEX_CORNERS[q][a] / GAUSS));
    from_fn(|i| from_fn(|q| along(i, q).product()))
});

/// The linear function nearest in the mean to values at the integration points of a tetrahedron with ten nodes, at the corners.
static FROM_TET10: LazyLock<[[f64; 14]; 4]> = LazyLock::new(|| {
    // The inverse of the mass matrix V/20 (1 + δ_ij) is 20/V (δ_ij - 1/5), and the weights add up to the volume of the reference, V.
    let volume: f64 = TET10.iter().map(|at| at.weight).sum();
    from_fn(|i| {
        from_fn(|q| {
            let shape = &TET10[q].shape;
            let halves = (4..10).filter(|k| CellKind::Tet10.edges()[k - 4].contains(&i)).map(|k| 0.5 * shape[k]);
            TET10[q].weight / volume * (20.0 * (shape[i] + halves.sum::<f64>()) - 4.0)
        })
    })
});

/// Stress and strain at the nodes: by the polynomials through the integration points of linear cells and of hexahedra with 20 nodes, and by
/// the linear function nearest to those of tetrahedra with ten nodes and of triangles of wedges; the middles of the edges of these
/// have the mean of their ends.
/// All cells of a node count alike. A node of no cell, or of a folded one, has NaN.
///
/// # Panics
/// If the lengths of `straining` do not fit the mesh.
pub fn nodal_stress(solid: &Solid, straining: &Straining) -> NodalStress {
    nodal_stress_at(solid, straining, None)
}

/// The same at the nodes for which `wanted` is true, NaN at the others; at all of them without `wanted`.
pub(crate) fn nodal_stress_at<'m>(solid: &Solid<'m>, straining: &Straining, wanted: Option<&[bool]>) -> NodalStress {
    let is_wanted = |node: u32| wanted.is_none_or(|wanted| wanted[node as usize]);
    let body = Body::new(solid, straining);
    let nodes = solid.mesh.nodes.len();
    let (mut stress, mut strain) = (vec![[0.0; 6]; nodes], vec![[0.0; 6]; nodes]);
    let mut count = vec![0u32; nodes];
    let mut first = 0;
    for (number, block) in solid.mesh.cells.iter().enumerate() {
        let width = block.kind.nodes();
        for (chunk, of_chunk) in block.nodes.chunks(CHUNK * width).enumerate() {
            let of_cell = |(i, nodes): (usize, &'m [u32])| {
                let local = chunk * CHUNK + i;
                let at = At { block: number, cell: first + local, local, nodes };
                nodes.iter().any(|&node| is_wanted(node)).then(|| (nodes, at_nodes(&body, block.kind, &at)))
            };
            let values: Vec<_> = of_chunk.par_chunks_exact(width).enumerate().filter_map(of_cell).collect();
            for (nodes, values) in values {
                for (&node, [of_stress, of_strain]) in nodes.iter().zip(values) {
                    let node = node as usize;
                    count[node] += 1;
                    (0..6).for_each(|k| stress[node][k] += of_stress[k]);
                    (0..6).for_each(|k| strain[node][k] += of_strain[k]);
                }
            }
        }
        first += block.len();
    }
    for (values, half) in [(&mut stress, 1.0), (&mut strain, 0.5)] {
        for (value, &count) in values.iter_mut().zip(&count) {
            *value = from_fn(|k| value[k] / f64::from(count) * if k < 3 { 1.0 } else { half });
        }
        let others = values.iter_mut().zip(0..).filter(|(_, node)| !is_wanted(*node));
        others.for_each(|(value, _)| *value = [f64::NAN; 6]);
    }
    NodalStress { stress, strain }
}

/// Stress and strain of a cell at its nodes; NaN if it is folded.
fn at_nodes(body: &Body, kind: CellKind, at: &At) -> [[Voigt; 2]; MOST_NODES] {
    let x = &body.solid.mesh.nodes;
    let known = match kind {
        CellKind::Tet4 => Tet4::new(&corners(x, at.nodes)).map(|e| extrapolated(body, &e, at, &[[1.0]; 4])),
        CellKind::Hex8 => Hex8::new(&corners(x, at.nodes)).map(|e| extrapolated(body, &e, at, &FROM_GAUSS)),
        CellKind::Tet10 => Tet10::new(&corners(x, at.nodes)).map(|e| extrapolated(body, &e, at, &FROM_TET10)),
        CellKind::Hex20 => Hex20::new(&corners(x, at.nodes)).map(|e| extrapolated(body, &e, at, &FROM_HEX20)),
        CellKind::Wedge6 => Wedge6::new(&corners(x, at.nodes)).map(|e| extrapolated(body, &e, at, &FROM_WEDGE6)),
        CellKind::Wedge15 => Wedge15::new(&corners(x, at.nodes)).map(|e| extrapolated(body, &e, at, &FROM_WEDGE15)),
    };
    let mut values = known.unwrap_or([[[f64::NAN; 6]; 2]; MOST_NODES]);
    let middles = if matches!(kind, CellKind::Tet10 | CellKind::Wedge15) { kind.edges() } else { &[] };
    let first = kind.linear().nodes();
    for (i, &[a, b]) in middles.iter().enumerate() {
        values[first + i] = from_fn(|s| from_fn(|k| 0.5 * (values[a][s][k] + values[b][s][k])));
    }
    values
}

/// The polynomials of degree 2 in each direction through the 3 x 3 x 3 Gauss points, at the nodes: as CalculiX extrapolates them.
static FROM_HEX20: LazyLock<[[f64; 27]; 20]> = LazyLock::new(|| {
    let along = |x: f64, q: usize| {
        let others = (0..3).filter(move |&other| other != q);
        others.map(|other| (x - GAUSS3[other].0) / (GAUSS3[q].0 - GAUSS3[other].0)).product::<f64>()
    };
    let node = |i: usize| match i.checked_sub(8) {
        None => HEX_CORNERS[i],
        Some(edge) => {
            let [a, b] = CellKind::Hex20.edges()[edge].map(|end| HEX_CORNERS[end]);
            from_fn(|c| 0.5 * (a[c] + b[c]))
        }
    };
    from_fn(|i| {
        let [x, y, z] = node(i);
        from_fn(|q| along(x, q % 3) * along(y, q / 3 % 3) * along(z, q / 9))
    })
});

/// Weights of the values at the points of a wedge at its corners: along each triangle the linear function nearest in the mean, along
/// the wedge the polynomial through the Gauss points `along`. `weights` are those of the points.
fn of_wedge<const Q: usize>(weights: [f64; Q], triangle: &[[f64; 3]], along: &[f64]) -> [[f64; Q]; 6] {
    let points = triangle.len();
    let whole: f64 = weights[..points].iter().sum();
    let polynomial = |z: f64, level: usize| {
        let others = (0..along.len()).filter(|&other| other != level);
        others.map(|other| (z - along[other]) / (along[level] - along[other])).product::<f64>()
    };
    // The inverse of the mass matrix A/12 (1 + δ_ij) of the triangle is 12/A (δ_ij - 1/4).
    from_fn(|i| {
        let nearest = |q: usize| weights[q] / whole * (12.0 * triangle[q][i % 3] - 3.0);
        from_fn(|q| nearest(q % points) * polynomial(WEDGE_CORNERS[i][2], q / points))
    })
}

static FROM_WEDGE6: LazyLock<[[f64; 6]; 6]> = LazyLock::new(|| {
    let triangle: Vec<[f64; 3]> = WEDGE6[..3].iter().map(|at| from_fn(|k| at.shape[k] + at.shape[3 + k])).collect();
    of_wedge(from_fn(|q| WEDGE6[q].weight), &triangle, &[-GAUSS, GAUSS])
});

static FROM_WEDGE15: LazyLock<[[f64; 21]; 6]> = LazyLock::new(|| {
    let triangle: Vec<[f64; 3]> = face_rule(6).into_iter().map(|([x, y], _)| [1.0 - x - y, x, y]).collect();
    of_wedge(from_fn(|q| WEDGE15[q].weight), &triangle, &GAUSS3.map(|point| point.0))
});

fn extrapolated<const N: usize, const Q: usize, const C: usize>(
    body: &Body,
    element: &Element<N, Q>,
    at: &At,
    from: &[[f64; Q]; C],
) -> [[Voigt; 2]; MOST_NODES] {
    let (stress, strain) = (body.stress(element, at), body.strain(element, at));
    let mut values = [[[0.0; 6]; 2]; MOST_NODES];
    for (value, weights) in values.iter_mut().zip(from) {
        *value = [combined(weights, &stress), combined(weights, &strain)];
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Material;
    use crate::mesh::{BlockElement, Mesh, block};

    const ELEMENTS: [(BlockElement, u8); 6] = [
        (BlockElement::Tet4Six, 0),
        (BlockElement::Hex8, 0),
        (BlockElement::Wedge6, 0),
        (BlockElement::Tet10Six, 1),
        (BlockElement::Hex20, 1),
        (BlockElement::Wedge15, 1),
    ];

    fn block_of(element: BlockElement) -> Mesh {
        let cells = [3, 2, 2];
        let (size, origin, grading) = ([3.0, 2.0, 1.0], [0.0; 3], [1.0; 3]);
        block(&crate::mesh::Block { size, cells, origin, grading, element }).unwrap()
    }

    /// A displacement whose strain is a polynomial of the degree that the element can have: found at all nodes.
    #[test]
    fn stress_and_strain_of_polynomials_are_exact_at_the_nodes() {
        for (element, degree) in ELEMENTS {
            let mesh = block_of(element);
            let materials = [Material { young: 1000.0, poisson: 0.25, ..Material::default() }];
            let material_of_cell = vec![0; mesh.cell_count()];
            let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &material_of_cell };
            let b = f64::from(degree) * 2e-3;
            // u = (a x + b x y, c y + b z y, d x + e z)
            let (a, c, d, e) = (1e-3, -2e-3, 3e-3, 0.5e-3);
            let u = mesh.nodes.iter().flat_map(|&[x, y, z]| [a * x + b * x * y, c * y + b * z * y, d * x + e * z]);
            let displacement: Vec<f64> = u.collect();
            let region = vec![0; mesh.cell_count()];
            let straining =
                Straining { displacement: &displacement, initial: &[], rise: &[], cuts: &[], region: &region };
            let found = nodal_stress(&solid, &straining);
            let (lambda, mu) = (400.0, 400.0);
            for (&[x, y, z], (stress, strain)) in mesh.nodes.iter().zip(found.stress.iter().zip(&found.strain)) {
                let wanted = [a + b * y, c + b * z, e, 0.5 * b * x, 0.5 * b * y, 0.5 * d];
                let trace = wanted[0] + wanted[1] + wanted[2];
                for k in 0..6 {
                    let wanted_stress = 2.0 * mu * wanted[k] + if k < 3 { lambda * trace } else { 0.0 };
                    assert!((strain[k] - wanted[k]).abs() < 1e-15, "{element:?} {k} {strain:?} {wanted:?}");
                    assert!((stress[k] - wanted_stress).abs() < 1e-11, "{element:?} {k} {stress:?}");
                }
            }
        }
    }
}
