//! Tetrahedra, hexahedra and wedges, linear and quadratic: shape functions, quadrature and stiffness.

use super::elastic::{Stiffness, Voigt, contract};
use super::{Material, Solid};
use crate::Error;
use crate::mesh::geometry::{GAUSS, HEX_CORNERS, HexEdges, corners, tet_jacobian};
use crate::mesh::shape::{HEX20, Reference, TET10, WEDGE6, WEDGE15};
use crate::mesh::v3::{V3, add, cross, dot, scale, sub};
use crate::mesh::{CellKind, Mesh};

/// Gradients of the `N` shape functions of a cell at its `Q` integration points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element<const N: usize, const Q: usize> {
    /// Volume each point stands for, > 0.
    pub weight: [f64; Q],
    /// `gradient[q][i]`: gradient of the shape function of node `i` at point `q`, 1/length.
    pub gradient: [[V3; N]; Q],
}

/// Linear tetrahedron: constant gradients, one point.
pub type Tet4 = Element<4, 1>;
/// Trilinear hexahedron: 2 x 2 x 2 Gauss points.
pub type Hex8 = Element<8, 8>;
/// Quadratic tetrahedron, curved or straight: 14 points, exact to degree 5. Four would do for straight edges; with
/// these uniform stress is kept in curved cells as well.
pub type Tet10 = Element<10, 14>;
/// Serendipity hexahedron, curved or straight: 3 x 3 x 3 Gauss points.
pub type Hex20 = Element<20, 27>;

/// Linear wedge: three points of the triangle at each of two Gauss points.
pub type Wedge6 = Element<6, 6>;
/// Quadratic wedge, curved or straight: seven points of the triangle at each of three Gauss points.
pub type Wedge15 = Element<15, 21>;

/// Most nodes a cell has.
pub const MOST_NODES: usize = 20;

/// The constants of elasticity as the elements use them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law<'a> {
    /// Lamé's first parameter, stress.
    pub lambda: f64,
    /// Shear modulus, stress, > 0.
    pub mu: f64,
    /// Whether linear hexahedra and wedges average the dilatation over the cell (B-bar).
    pub mean_dilatation: bool,
    /// Takes the place of the two constants where elasticity depends on the direction.
    pub stiffness: Option<&'a Stiffness>,
}

impl<'a> Law<'a> {
    /// The constants of `material`.
    pub fn new(material: &'a Material) -> Self {
        let (lambda, mu) = material.lame();
        let stiffness = material.orthotropic.as_ref().map(|it| &it.stiffness);
        Law { lambda, mu, mean_dilatation: material.averages_dilatation(), stiffness }
    }

    /// Stress of the elastic strain `strain`.
    pub fn stress(&self, strain: &Voigt) -> Voigt {
        if let Some(stiffness) = self.stiffness {
            return stiffness.map(|row| row.iter().zip(strain).map(|(c, e)| c * e).sum());
        }
        let pressure = self.lambda * (strain[0] + strain[1] + strain[2]);
        let factor = |p: usize| if p < 3 { pressure + 2.0 * self.mu * strain[p] } else { self.mu * strain[p] };
        std::array::from_fn(factor)
    }
}

/// Derivatives of the trilinear shape functions at each Gauss point.
const HEX_DERIVATIVES: [[V3; 8]; 8] = hex_derivatives();

const fn hex_derivatives() -> [[V3; 8]; 8] {
    let mut table = [[[0.0; 3]; 8]; 8];
    let mut q = 0;
    while q < 8 {
        let mut i = 0;
        while i < 8 {
            let [a, b, c] = HEX_CORNERS[i];
            let x = 1.0 + a * GAUSS * HEX_CORNERS[q][0];
            let y = 1.0 + b * GAUSS * HEX_CORNERS[q][1];
            let z = 1.0 + c * GAUSS * HEX_CORNERS[q][2];
            table[q][i] = [0.125 * a * y * z, 0.125 * b * x * z, 0.125 * c * x * y];
            i += 1;
        }
        q += 1;
    }
    table
}

/// Determinant and rows of the inverse of a Jacobian given by its columns; `None` unless its volume is positive.
#[inline(always)]
pub(super) fn inverse(column: [V3; 3]) -> Option<(f64, [V3; 3])> {
    let normal = [cross(column[1], column[2]), cross(column[2], column[0]), cross(column[0], column[1])];
    let det = dot(column[0], normal[0]);
    (det > 0.0 && det.is_finite()).then(|| (det, normal.map(|n| scale(1.0 / det, n))))
}

impl Tet4 {
    /// The tetrahedron on the corners `x`; `None` unless its volume is positive.
    #[inline]
    pub fn new(x: &[V3; 4]) -> Option<Self> {
        let (det, [g1, g2, g3]) = inverse(tet_jacobian(x))?;
        let g0 = scale(-1.0, add(add(g1, g2), g3));
        Some(Element { weight: [det / 6.0], gradient: [[g0, g1, g2, g3]] })
    }
}

impl Hex8 {
    /// The hexahedron on the corners `x`; `None` unless its mapping has positive volume at every Gauss point.
    pub fn new(x: &[V3; 8]) -> Option<Self> {
        let mut element = Element { weight: [0.0; 8], gradient: [[[0.0; 3]; 8]; 8] };
        let edges = HexEdges::new(x);
        for (q, derivatives) in HEX_DERIVATIVES.iter().enumerate() {
            let (det, inverse) = inverse(edges.jacobian(HEX_CORNERS[q].map(|c| c * GAUSS)))?;
            element.weight[q] = det;
            for (g, d) in element.gradient[q].iter_mut().zip(derivatives) {
                *g = add(add(scale(d[0], inverse[0]), scale(d[1], inverse[1])), scale(d[2], inverse[2]));
            }
        }
        Some(element)
    }

    /// The mean of its gradients as those of one point; `None` unless its volume is positive.
    ///
    /// By Gauss's theorem the integral of a gradient is that of the shape function over the faces, which are bilinear:
    /// `∫ N_i n = s × t + (a/3) s × h + (b/3) h × t`, where the face is at `s ξ + t η + h ξ η` but for its middle and node `i` at
    /// `ξ = a`, `η = b` (Flanagan and Belytschko 1981, "A uniform strain hexahedron and quadrilateral with orthogonal hourglass
    /// control", have the same in components).
    pub fn averaged(x: &[V3; 8]) -> Option<Element<8, 1>> {
        // Counted from one of the corners, so that places far from the origin lose no digits.
        let x = x.map(|corner| sub(corner, x[0]));
        let mut gradient = [[0.0; 3]; 8];
        for nodes in CellKind::Hex8.faces() {
            let [a, b, c, d] = std::array::from_fn(|k| x[nodes[k]]);
            let (ac, bd) = (sub(c, a), sub(d, b));
            let [s, t] = [sub(ac, bd), add(ac, bd)].map(|v| scale(0.25, v));
            let h = scale(0.25, sub(add(a, c), add(b, d)));
            let (mean, along, across) = (cross(s, t), scale(1.0 / 3.0, cross(s, h)), scale(1.0 / 3.0, cross(h, t)));
            let (more, less) = (add(mean, along), sub(mean, along));
            let of_nodes = [sub(less, across), sub(more, across), add(more, across), add(less, across)];
            nodes.iter().zip(of_nodes).for_each(|(&node, part)| gradient[node] = add(gradient[node], part));
        }
        let volume = gradient.iter().zip(&x).map(|(g, x)| dot(*g, *x)).sum::<f64>() / 3.0;
        (volume > 0.0 && volume.is_finite())
            .then(|| Element { weight: [volume], gradient: [gradient.map(|g| scale(1.0 / volume, g))] })
    }
}

impl Tet10 {
    /// The tetrahedron with nodes at `x`; `None` unless its mapping has positive volume at every integration point.
    pub fn new(x: &[V3; 10]) -> Option<Self> {
        Element::mapped(&TET10, x)
    }
}

impl Hex20 {
    /// The hexahedron with nodes at `x`; `None` unless its mapping has positive volume at every integration point.
    pub fn new(x: &[V3; 20]) -> Option<Self> {
        Element::mapped(&HEX20, x)
    }
}

impl Wedge6 {
    /// The wedge on the corners `x`; `None` unless its mapping has positive volume at every integration point.
    pub fn new(x: &[V3; 6]) -> Option<Self> {
        Element::mapped(&WEDGE6, x)
    }
}

impl Wedge15 {
    /// The wedge with nodes at `x`; `None` unless its mapping has positive volume at every integration point.
    pub fn new(x: &[V3; 15]) -> Option<Self> {
        Element::mapped(&WEDGE15, x)
    }
}

impl<const N: usize, const Q: usize> Element<N, Q> {
    /// Whether the law can average the dilatation over the cell: one point is its own mean, and quadratic cells would
    /// lose an order by a constant one.
    pub const AVERAGES: bool = N == 8 || N == 6;

    /// The isoparametric cell with nodes at `x`, integrated at the points of `rule`.
    fn mapped(rule: &[Reference<N>; Q], x: &[V3; N]) -> Option<Self> {
        let mut element = Element { weight: [0.0; Q], gradient: [[[0.0; 3]; N]; Q] };
        for (q, at) in rule.iter().enumerate() {
            let (det, inverse) = inverse(at.jacobian(x))?;
            element.weight[q] = at.weight * det;
            for (g, d) in element.gradient[q].iter_mut().zip(&at.gradient) {
                *g = add(add(scale(d[0], inverse[0]), scale(d[1], inverse[1])), scale(d[2], inverse[2]));
            }
        }
        Some(element)
    }

    /// Volume of the cell.
    pub fn volume(&self) -> f64 {
        self.weight.iter().sum()
    }

    /// Integrals of the gradients over the cell, area.
    pub fn integrated_gradient(&self) -> [V3; N] {
        let mut sum = [[0.0; 3]; N];
        for (w, gradient) in self.weight.iter().zip(&self.gradient) {
            for (s, g) in sum.iter_mut().zip(gradient) {
                *s = add(*s, scale(*w, *g));
            }
        }
        sum
    }

    /// The 3 x 3 blocks `K_i0 .. K_i(N-1)` of the stiffness matrix, force per length.
    pub fn row(&self, i: usize, law: Law) -> [[V3; 3]; N] {
        let dilatation = self.dilatation(law);
        std::array::from_fn(|j| self.block(i, j, law, dilatation.as_ref()))
    }

    /// The block `K_ij` of the stiffness matrix with the mean dilatation of the same law, force per length.
    ///
    /// With `G = ∫ ∇N_i ⊗ ∇N_j` the block is `λ G + μ Gᵀ + μ tr(G) I`. B-bar (Hughes 1980, "Generalization of
    /// selective integration procedures") keeps the deviatoric part, `-2μ/3` in the place of `λ`, and adds the
    /// bulk modulus times the mean dilatation.
    #[inline(always)]
    pub fn block(&self, i: usize, j: usize, law: Law, dilatation: Option<&Dilatation<N>>) -> [V3; 3] {
        let mut gram = [[0.0; 3]; 3];
        for (w, gradient) in self.weight.iter().zip(&self.gradient) {
            // The weight multiplies the product, so that K_ij and K_jiᵀ are equal to the bit.
            for a in 0..3 {
                for b in 0..3 {
                    gram[a][b] += w * (gradient[i][a] * gradient[j][b]);
                }
            }
        }
        let mut block = [[0.0; 3]; 3];
        if let Some(stiffness) = law.stiffness {
            block = contract(stiffness, &gram);
        } else {
            let lambda = if dilatation.is_some() { -2.0 / 3.0 * law.mu } else { law.lambda };
            let trace = law.mu * (gram[0][0] + gram[1][1] + gram[2][2]);
            for a in 0..3 {
                for b in 0..3 {
                    block[a][b] = lambda * gram[a][b] + law.mu * gram[b][a];
                }
                block[a][a] += trace;
            }
        }
        if let Some(Dilatation { bulk, gradient }) = dilatation {
            for a in 0..3 {
                for b in 0..3 {
                    block[a][b] += bulk * (gradient[i][a] * gradient[j][b]);
                }
            }
        }
        block
    }

    /// The mean dilatation of the cell, where the law averages it.
    pub fn dilatation(&self, law: Law) -> Option<Dilatation<N>> {
        let bulk = || (law.lambda + 2.0 / 3.0 * law.mu) / self.volume();
        (law.mean_dilatation && Self::AVERAGES)
            .then(|| Dilatation { bulk: bulk(), gradient: self.integrated_gradient() })
    }
}

/// The part of a stiffness matrix that belongs to the mean dilatation: `bulk` times the square of `gradient`.
#[derive(Debug, Clone, Copy)]
pub struct Dilatation<const N: usize> {
    /// Bulk modulus over volume.
    bulk: f64,
    /// Integrals of the gradients of the shape functions, area.
    gradient: [V3; N],
}

/// A point of a volume quadrature.
#[derive(Debug, Clone, Copy)]
pub struct VolumePoint {
    /// Values of the shape functions; those beyond the nodes of the cell are zero.
    pub shape: [f64; MOST_NODES],
    /// Its place, length.
    pub position: V3,
    /// Volume the point stands for.
    pub weight: f64,
}

/// Quadrature over a cell, exact for polynomials of degree 2 (tetrahedron, 4 points) and of degree 3 in each
/// direction of the reference cell (hexahedron, 2 x 2 x 2 points; wedge, 3 x 2 points, of degree 2 in the triangle), of
/// degree 5 for quadratic cells. `None` if the cell is folded.
pub fn volume_points(kind: CellKind, mesh: &Mesh, nodes: &[u32]) -> Option<Vec<VolumePoint>> {
    let (shapes, weights): (Vec<[f64; MOST_NODES]>, Vec<f64>) = match kind {
        CellKind::Tet4 => {
            let near = (5.0 + 3.0 * 5f64.sqrt()) / 20.0;
            let far = (5.0 - 5f64.sqrt()) / 20.0;
            let volume = Tet4::new(&corners(&mesh.nodes, nodes))?.volume();
            let shape = |q: usize| std::array::from_fn(|i| if i > 3 { 0.0 } else { [far, near][(i == q) as usize] });
            ((0..4).map(shape).collect(), vec![volume / 4.0; 4])
        }
        CellKind::Hex8 => {
            let weight = Hex8::new(&corners(&mesh.nodes, nodes))?.weight;
            let shape = |q: usize| {
                let at = |i: usize| (0..3).map(move |a| 0.5 * (1.0 + GAUSS * HEX_CORNERS[i][a] * HEX_CORNERS[q][a]));
                std::array::from_fn(|i| if i < 8 { at(i).product() } else { 0.0 })
            };
            ((0..8).map(shape).collect(), weight.to_vec())
        }
        CellKind::Tet10 => (padded(&*TET10), Tet10::new(&corners(&mesh.nodes, nodes))?.weight.to_vec()),
        CellKind::Hex20 => (padded(&*HEX20), Hex20::new(&corners(&mesh.nodes, nodes))?.weight.to_vec()),
        CellKind::Wedge6 => (padded(&*WEDGE6), Wedge6::new(&corners(&mesh.nodes, nodes))?.weight.to_vec()),
        CellKind::Wedge15 => (padded(&*WEDGE15), Wedge15::new(&corners(&mesh.nodes, nodes))?.weight.to_vec()),
    };
    let position = |shape: &[f64; MOST_NODES]| {
        nodes.iter().zip(shape).fold([0.0; 3], |x, (&i, &s)| add(x, scale(s, mesh.nodes[i as usize])))
    };
    Some(
        shapes
            .into_iter()
            .zip(weights)
            .map(|(shape, weight)| VolumePoint { position: position(&shape), shape, weight })
            .collect(),
    )
}

/// Values of the shape functions at the points of a rule.
fn padded<const N: usize>(rule: &[Reference<N>]) -> Vec<[f64; MOST_NODES]> {
    let shape = |at: &Reference<N>| std::array::from_fn(|i| at.shape.get(i).copied().unwrap_or(0.0));
    rule.iter().map(shape).collect()
}

/// The error for a cell whose mapping has no positive volume at an integration point.
pub(super) fn folded(solid: &Solid, cell: usize, kind: CellKind, nodes: &[u32]) -> Error {
    let first = solid.mesh.nodes[nodes[0] as usize];
    Error::new(
        format!("cell {cell}, a {} with a corner at {}", kind.name(), super::field::point(first)),
        "the cell is folded or flat: its volume is not positive at an integration point",
        "repair the mesh there",
    )
}
