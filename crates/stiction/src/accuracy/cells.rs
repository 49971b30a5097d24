//! The stress of cells at their integration points and at their sampling points, and its distance from the recovered one.

use std::array::from_fn;
use std::sync::LazyLock;

use rayon::prelude::*;

use super::patches::Patches;
use crate::fem::elements::{Element, Hex8, Hex20, Law, Tet4, Tet10};
use crate::fem::{Cut, Solid, Voigt, quadratic_points};
use crate::linalg::SmallLu;
use crate::mesh::CellKind;
use crate::mesh::geometry::{GAUSS, HEX_CORNERS, corners};
use crate::mesh::shape::{GAUSS3, HEX20, TET10};
use crate::mesh::v3::{V3, add, mean, scale, sub};

/// What strains a body.
#[derive(Debug, Clone, Copy)]
pub struct Straining<'a> {
    /// Displacements along x, y, z, `3 i + c` for node `i`, length.
    pub displacement: &'a [f64],
    /// Mean of the strain of each cell that causes no stress, that of `cuts` included; empty if there is none.
    pub initial: &'a [Voigt],
    /// Rise of temperature at the integration points of quadratic cells, see [`InitialStrain`](crate::fem::InitialStrain);
    /// empty if there is none.
    pub rise: &'a [f64],
    /// Bolts: the cut and how far its sides are drawn together, length.
    pub cuts: &'a [(&'a Cut, f64)],
    /// Number of the region of each cell. Between regions stress may jump.
    pub region: &'a [u32],
}

/// Cells for each task of a thread at least.
const CELLS_PER_TASK: usize = 512;

/// Stress of the cells of a mesh at its sampling points: where it is most accurate, as far as that is known.
///
/// Hexahedra with 20 nodes have the 2 x 2 x 2 Gauss points (Barlow 1976). The others have one, their middle, for the mean:
/// no points of tetrahedra with 10 nodes are known at which all components are better than elsewhere.
pub(super) struct Samples {
    stress: Vec<Voigt>,
    /// For each block of cells the number after its last cell, and its first sample.
    blocks: Vec<[usize; 2]>,
}

/// Most sampling points of a cell.
pub(super) const MOST_SAMPLES: usize = 8;

pub(super) fn samples_of(kind: CellKind) -> usize {
    match kind {
        CellKind::Tet4 | CellKind::Hex8 | CellKind::Tet10 => 1,
        CellKind::Hex20 => 8,
    }
}

/// The linear polynomial next to values at the integration points of a hexahedron, at the 2 x 2 x 2 Gauss points, where the
/// one of degree 2 in each direction has the same values.
static HEX20_SAMPLES: LazyLock<[[f64; 27]; 8]> = LazyLock::new(|| {
    let along = |sign: f64, (place, weight): (f64, f64)| 0.5 * weight * (1.0 + 3.0 * GAUSS * sign * place);
    HEX_CORNERS
        .map(|[x, y, z]| from_fn(|q| along(x, GAUSS3[q % 3]) * along(y, GAUSS3[q / 3 % 3]) * along(z, GAUSS3[q / 9])))
});

/// Shape functions of a hexahedron with 20 nodes at its samples.
static HEX20_AT_SAMPLES: LazyLock<[[f64; 20]; 8]> = LazyLock::new(|| {
    HEX20_SAMPLES.map(|weights| from_fn(|i| weights.iter().zip(&*HEX20).map(|(w, at)| w * at.shape[i]).sum()))
});

/// Shape functions of a hexahedron with 8 nodes at its Gauss points.
static HEX8_SHAPES: LazyLock<[[f64; 8]; 8]> = LazyLock::new(|| {
    let at = |i: usize, q: usize| (0..3).map(move |a| 0.5 * (1.0 + GAUSS * HEX_CORNERS[i][a] * HEX_CORNERS[q][a]));
    from_fn(|q| from_fn(|i| at(i, q).product()))
});

impl Samples {
    /// Stress at the samples of cell number `cell`.
    #[inline]
    pub(super) fn at(&self, cell: u32, count: usize) -> &[Voigt] {
        let block = self.blocks.partition_point(|[end, _]| *end <= cell as usize);
        let before = if block == 0 { 0 } else { self.blocks[block - 1][0] };
        let first = self.blocks[block][1] + count * (cell as usize - before);
        &self.stress[first..first + count]
    }
}

/// Places of the samples of a cell.
pub(super) fn places(kind: CellKind, x: &[V3], nodes: &[u32]) -> [V3; MOST_SAMPLES] {
    let mut places = [[0.0; 3]; MOST_SAMPLES];
    let node = |i: usize| x[nodes[i] as usize];
    match kind {
        CellKind::Tet4 | CellKind::Hex8 => places[0] = mean((0..nodes.len()).map(node)),
        CellKind::Tet10 => places[0] = mean((4..10).map(node)),
        CellKind::Hex20 => {
            for (place, shape) in places.iter_mut().zip(&*HEX20_AT_SAMPLES) {
                *place = (0..20).fold([0.0; 3], |sum, i| add(sum, scale(shape[i], node(i))));
            }
        }
    }
    places
}

/// A body under strain.
pub(super) struct Body<'a> {
    pub(super) solid: Solid<'a>,
    pub(super) straining: Straining<'a>,
    laws: Vec<(Law<'a>, Compliance)>,
    /// Of each block of cells the first integration point among those of quadratic cells, and how many a cell has.
    points: Vec<[usize; 2]>,
}

impl<'a> Body<'a> {
    pub(super) fn new(solid: &Solid<'a>, straining: &Straining<'a>) -> Self {
        let (cells, nodes) = (solid.mesh.cell_count(), solid.mesh.nodes.len());
        assert_eq!(straining.displacement.len(), 3 * nodes);
        assert_eq!(straining.region.len(), cells);
        assert!(straining.initial.is_empty() || straining.initial.len() == cells);
        let law = |material| {
            let law = Law::new(material);
            (law, Compliance::new(&law))
        };
        let laws = solid.materials.iter().map(law).collect();
        Body { solid: *solid, straining: *straining, laws, points: quadratic_points(solid.mesh) }
    }

    fn law(&self, cell: usize) -> &(Law<'a>, Compliance) {
        &self.laws[self.solid.material_of_cell[cell] as usize]
    }

    /// Stress at the samples of all cells.
    pub(super) fn samples(&self) -> Samples {
        let mesh = self.solid.mesh;
        let total = mesh.cells.iter().map(|block| block.len() * samples_of(block.kind)).sum();
        let (mut stress, mut blocks) = (vec![[0.0; 6]; total], Vec::new());
        let (mut cell, mut sample) = (0, 0);
        for (number, block) in mesh.cells.iter().enumerate() {
            let (kind, count) = (block.kind, samples_of(block.kind));
            let own = &mut stress[sample..sample + count * block.len()];
            let tasks = own.par_chunks_exact_mut(count).zip(block.nodes.par_chunks_exact(kind.nodes()));
            tasks.enumerate().with_min_len(CELLS_PER_TASK).for_each(|(i, (own, nodes))| {
                let at = At { block: number, cell: cell + i, local: i, nodes };
                if !self.sample(kind, &at, own) {
                    own.fill([f64::NAN; 6]);
                }
            });
            (cell, sample) = (cell + block.len(), sample + count * block.len());
            blocks.push([cell, sample - count * block.len()]);
        }
        Samples { stress, blocks }
    }

    /// False for a cell that is folded.
    fn sample(&self, kind: CellKind, at: &At, samples: &mut [Voigt]) -> bool {
        let x = &self.solid.mesh.nodes;
        match kind {
            CellKind::Tet4 => Tet4::new(&corners(x, at.nodes)).map(|e| samples[0] = self.stress(&e, at)[0]),
            CellKind::Hex8 => Hex8::new(&corners(x, at.nodes)).map(|e| samples[0] = self.mean_stress(&e, at)),
            CellKind::Tet10 => Tet10::new(&corners(x, at.nodes)).map(|e| samples[0] = self.mean_stress(&e, at)),
            CellKind::Hex20 => Hex20::new(&corners(x, at.nodes)).map(|e| {
                let stress = self.stress(&e, at);
                samples.iter_mut().zip(&*HEX20_SAMPLES).for_each(|(s, weights)| *s = combined(weights, &stress));
            }),
        }
        .is_some()
    }

    /// Of each cell the squared energy norms of the error, of the stress and of the stress that would suppress its strain
    /// without stress, with its volume between: error, stress, volume, suppressing stress.
    pub(super) fn errors(&self, samples: &Samples, patches: &Patches) -> Vec<[f64; 4]> {
        let mesh = self.solid.mesh;
        let mut errors = vec![[0.0; 4]; mesh.cell_count()];
        let mut rest = &mut errors[..];
        let mut cell = 0;
        for (number, block) in mesh.cells.iter().enumerate() {
            let (own, others) = rest.split_at_mut(block.len());
            let tasks = own.par_iter_mut().zip(block.nodes.par_chunks_exact(block.kind.nodes()));
            tasks.enumerate().with_min_len(CELLS_PER_TASK).for_each(|(i, (own, nodes))| {
                let at = At { block: number, cell: cell + i, local: i, nodes };
                *own = self.error(block.kind, &at, samples, patches).unwrap_or([f64::NAN; 4]);
            });
            (rest, cell) = (others, cell + block.len());
        }
        errors
    }

    fn error(&self, kind: CellKind, at: &At, samples: &Samples, patches: &Patches) -> Option<[f64; 4]> {
        let x = &self.solid.mesh.nodes;
        let region = self.straining.region[at.cell];
        let smooth = |i: usize| match kind.edges().get(i.wrapping_sub(kind.linear().nodes())) {
            None => *patches.at_corner(at.nodes[i], region),
            Some(ends) => {
                let place = x[at.nodes[i] as usize];
                let [a, b] = ends.map(|end| patches.near_corner(at.nodes[end], region, place));
                from_fn(|k| 0.5 * (a[k] + b[k]))
            }
        };
        Some(match kind {
            CellKind::Tet4 => {
                let volume = crate::mesh::geometry::cell_volume(x, kind, at.nodes);
                let compliance = &self.law(at.cell).1;
                let found = samples.at(at.cell as u32, 1)[0];
                let error: [Voigt; 4] = from_fn(|i| {
                    let smooth = smooth(i);
                    from_fn(|k| smooth[k] - found[k])
                });
                let sum: Voigt = from_fn(|k| error.iter().map(|e| e[k]).sum());
                // ∫ b_i b_j = (1 + δ_ij) V / 20
                let squares = error.iter().map(|e| compliance.energy(e)).sum::<f64>() + compliance.energy(&sum);
                let suppressed = volume * self.suppressed(at, 0);
                [volume / 20.0 * squares, volume * compliance.energy(&found), volume, suppressed]
            }
            CellKind::Hex8 => {
                let e = Hex8::new(&corners(x, at.nodes))?;
                self.integrated(&e, at, &from_fn(smooth), |q| &HEX8_SHAPES[q])
            }
            CellKind::Tet10 => {
                let e = Tet10::new(&corners(x, at.nodes))?;
                let rule = &*TET10;
                self.integrated(&e, at, &from_fn(smooth), |q| &rule[q].shape)
            }
            CellKind::Hex20 => {
                let e = Hex20::new(&corners(x, at.nodes))?;
                let rule = &*HEX20;
                self.integrated(&e, at, &from_fn(smooth), |q| &rule[q].shape)
            }
        })
    }

    /// Integrals over a cell, `smooth` the recovered stress at its nodes.
    fn integrated<'s, const N: usize, const Q: usize>(
        &self,
        element: &Element<N, Q>,
        at: &At,
        smooth: &[Voigt; N],
        shape: impl Fn(usize) -> &'s [f64; N],
    ) -> [f64; 4] {
        let compliance = &self.law(at.cell).1;
        let mut sums = [0.0; 4];
        for (q, (found, weight)) in self.stress(element, at).iter().zip(element.weight).enumerate() {
            let smooth = combined(shape(q), smooth);
            let error = from_fn(|k| smooth[k] - found[k]);
            let parts = [compliance.energy(&error), compliance.energy(found), 1.0, self.suppressed(at, q)];
            sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += weight * part);
        }
        sums
    }

    fn mean_stress<const N: usize, const Q: usize>(&self, element: &Element<N, Q>, at: &At) -> Voigt {
        let volume = element.volume();
        combined(&element.weight.map(|weight| weight / volume), &self.stress(element, at))
    }

    /// Stress of a cell at its integration points.
    fn stress<const N: usize, const Q: usize>(&self, element: &Element<N, Q>, at: &At) -> [Voigt; Q] {
        let Straining { displacement, cuts, .. } = self.straining;
        let mut u: [V3; N] = from_fn(|i| displacement.as_chunks().0[at.nodes[i] as usize]);
        for (cut, shortening) in cuts.iter().filter(|(cut, _)| cut.cells.binary_search(&(at.cell as u32)).is_ok()) {
            // The cell sees its nodes at the cut where the other side is.
            for (u, node) in u.iter_mut().zip(at.nodes) {
                if cut.nodes.binary_search(node).is_ok() {
                    *u = sub(*u, scale(*shortening, cut.axis));
                }
            }
        }
        let law = &self.law(at.cell).0;
        let mut strain: [Voigt; Q] = from_fn(|q| strain(&element.gradient[q], &u));
        if N == 8 && law.mean_dilatation {
            let dilatation = |e: &Voigt| e[0] + e[1] + e[2];
            let sum: f64 = strain.iter().zip(element.weight).map(|(e, w)| w * dilatation(e)).sum();
            let mean = sum / element.volume();
            for e in &mut strain {
                let more = (mean - dilatation(e)) / 3.0;
                (0..3).for_each(|k| e[k] += more);
            }
        }
        from_fn(|q| {
            let free = self.free_strain(at, q);
            law.stress(&from_fn(|k| strain[q][k] - free[k]))
        })
    }

    /// Thermal strain of a cell at integration point `q`: the mean in linear cells, as their forces have it.
    fn free_strain(&self, at: &At, q: usize) -> Voigt {
        let Straining { initial, rise, cuts, .. } = self.straining;
        let [first, count] = self.points[at.block];
        if count > 0 {
            let rise = rise.get(first + count * at.local + q).copied().unwrap_or(0.0);
            let material = &self.solid.materials[self.solid.material_of_cell[at.cell] as usize];
            return material.expansion.map_or([0.0; 6], |expansion| expansion.map(|e| rise * e));
        }
        let mut free = initial.get(at.cell).copied().unwrap_or([0.0; 6]);
        for (cut, shortening) in cuts {
            if let Ok(place) = cut.cells.binary_search(&(at.cell as u32)) {
                (0..6).for_each(|k| free[k] -= shortening * cut.strain[place][k]);
            }
        }
        free
    }

    /// Squared energy norm, per volume, of the stress that would suppress the thermal strain.
    fn suppressed(&self, at: &At, q: usize) -> f64 {
        if self.straining.initial.is_empty() {
            return 0.0;
        }
        let free = self.free_strain(at, q);
        self.law(at.cell).0.stress(&free).iter().zip(free).map(|(s, e)| s * e).sum()
    }
}

/// Which cell it is: its block, its number in the mesh and in the block, its nodes.
struct At<'m> {
    block: usize,
    cell: usize,
    local: usize,
    nodes: &'m [u32],
}

/// Strain from the gradients of the shape functions and the displacements of the nodes.
#[inline]
fn strain<const N: usize>(gradient: &[V3; N], u: &[V3; N]) -> Voigt {
    let mut h = [[0.0; 3]; 3]; // displacement gradient, h[a][b] = ∂u_a/∂x_b
    for (u, g) in u.iter().zip(gradient) {
        for a in 0..3 {
            for b in 0..3 {
                h[a][b] += u[a] * g[b];
            }
        }
    }
    [h[0][0], h[1][1], h[2][2], h[0][1] + h[1][0], h[1][2] + h[2][1], h[0][2] + h[2][0]]
}

#[inline]
fn combined<const K: usize>(weights: &[f64; K], values: &[Voigt; K]) -> Voigt {
    let mut sum = [0.0; 6];
    for (weight, value) in weights.iter().zip(values) {
        (0..6).for_each(|k| sum[k] += weight * value[k]);
    }
    sum
}

/// The inverse of a law.
enum Compliance {
    /// `1/(2 mu)`, and what the square of the trace is multiplied with.
    Isotropic(f64, f64),
    Full(Box<[Voigt; 6]>),
}

impl Compliance {
    fn new(law: &Law) -> Self {
        match law.stiffness {
            None => {
                let double = 1.0 / (2.0 * law.mu);
                Compliance::Isotropic(double, double * law.lambda / (3.0 * law.lambda + 2.0 * law.mu))
            }
            Some(stiffness) => {
                let lu = SmallLu::new(stiffness.iter().map(|row| row.to_vec()).collect());
                let column = |k: usize| lu.solve(&from_fn::<f64, 6, _>(|i| f64::from(u8::from(i == k))));
                Compliance::Full(Box::new(from_fn(|k| {
                    let column = column(k);
                    from_fn(|i| column[i])
                })))
            }
        }
    }

    /// `s : C⁻¹ : s`, energy per volume.
    #[inline]
    fn energy(&self, s: &Voigt) -> f64 {
        match self {
            Compliance::Isotropic(double, of_trace) => {
                let trace = s[0] + s[1] + s[2];
                let direct = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
                let shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
                double * (direct + 2.0 * shear) - of_trace * trace * trace
            }
            Compliance::Full(rows) => {
                rows.iter().zip(s).map(|(row, s_i)| s_i * row.iter().zip(s).map(|(c, s)| c * s).sum::<f64>()).sum()
            }
        }
    }
}
