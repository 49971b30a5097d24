//! The stress of cells at their integration points and at their sampling points, and its distance from the recovered one.

use std::array::from_fn;
use std::sync::LazyLock;

use rayon::prelude::*;

use super::patches::Patches;
use crate::fem::elements::{Element, Hex8, Hex20, Law, Tet4, Tet10, Wedge6, Wedge15};
use crate::fem::{self, Cut, Solid, Voigt, quadratic_points};
use crate::linalg::SmallLu;
use crate::mesh::geometry::{GAUSS, HEX_CORNERS, corners};
use crate::mesh::shape::{GAUSS3, HEX20, TET10, WEDGE6, WEDGE15};
use crate::mesh::v3::{V3, add, dot, mean, scale, sub};
use crate::mesh::{CellKind, Cells};

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
    /// Number of the region of each cell, all of one material. Between regions stress may jump.
    pub region: &'a [u32],
}

/// The part of displacements over the size of their cell that counts as strain that is suppressed. Of the stress of that 1e-7 is rounding, so
/// that a strain is none below 1e-11 of displacements over size. A rigid motion leaves 1e-16 of it, a strain of micrometres beside a motion of
/// millimetres is 1e-3.
const MOTION: f64 = 1e-4;

/// Cells for each task of a thread at least.
const CELLS_PER_TASK: usize = 512;

/// Stress of a cell where it is most accurate, as far as that is known: at the middle of linear cells, at the 2 x 2 x 2 Gauss points of
/// hexahedra with 20 nodes (Barlow 1976). No such points of tetrahedra with 10 nodes and wedges with 15 are known.
#[derive(Clone, Copy, Default)]
pub(super) struct Sample {
    pub(super) place: V3,
    pub(super) stress: Voigt,
}

/// Of each block of cells how many samples a cell has, and the samples.
pub(super) struct Samples(Vec<(usize, Vec<Sample>)>);

impl Samples {
    /// Those of cell number `local` of a block.
    #[inline]
    pub(super) fn at(&self, (block, local): (usize, usize)) -> &[Sample] {
        let (count, samples) = &self.0[block];
        &samples[count * local..count * (local + 1)]
    }
}

fn samples_of(kind: CellKind) -> usize {
    match kind {
        CellKind::Tet4 | CellKind::Hex8 | CellKind::Wedge6 => 1,
        CellKind::Tet10 | CellKind::Wedge15 => 0,
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

/// Linear functions of the four corners at the integration points of a tetrahedron with ten nodes.
static LINEAR_AT_TET10: LazyLock<[[f64; 4]; 14]> = LazyLock::new(|| {
    from_fn(|q| {
        let shape = &TET10[q].shape;
        let halves = |i: usize| (4..10).filter(move |k| CellKind::Tet10.edges()[k - 4].contains(&i)).map(|k| shape[k]);
        from_fn(|i| shape[i] + 0.5 * halves(i).sum::<f64>())
    })
});

/// Part of its edge by which a middle of a straight one is off it at most.
const STRAIGHT: f64 = 1e-12;

/// Whether the edges of a tetrahedron with ten nodes are straight and its middles in their middles.
fn is_straight(x: &[V3], nodes: &[u32]) -> bool {
    CellKind::Tet10.edges().iter().zip(&nodes[4..]).all(|(ends, &middle)| {
        let [a, b] = ends.map(|end| x[nodes[end] as usize]);
        let (edge, off) = (sub(b, a), sub(scale(2.0, x[middle as usize]), add(a, b)));
        dot(off, off) <= STRAIGHT * STRAIGHT * dot(edge, edge)
    })
}

/// A body under strain.
pub(super) struct Body<'a> {
    pub(super) solid: Solid<'a>,
    pub(super) straining: Straining<'a>,
    /// Number of the region of each cell; cells whose stress is recovered in different ways are regions of their own.
    pub(super) region: Vec<u32>,
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
        let way = |kind: CellKind| match kind {
            CellKind::Tet4 | CellKind::Hex8 | CellKind::Wedge6 => 0,
            CellKind::Tet10 | CellKind::Wedge15 => 1,
            CellKind::Hex20 => 2,
        };
        let ways = solid.mesh.cells.iter().flat_map(|block| std::iter::repeat_n(way(block.kind), block.len()));
        let region = straining.region.iter().zip(ways).map(|(region, way)| 3 * region + way).collect();
        Body { solid: *solid, straining: *straining, region, laws, points: quadratic_points(solid.mesh) }
    }

    fn constants(&self, cell: usize) -> &(Law<'a>, Compliance) {
        &self.laws[self.solid.material_of_cell[cell] as usize]
    }

    pub(super) fn law(&self, cell: usize) -> &Law<'a> {
        &self.constants(cell).0
    }

    /// How far `node` is drawn back as `cell` sees it: across a cut.
    pub(super) fn jump(&self, cell: u32, node: u32) -> V3 {
        let at_cut =
            |(cut, _): &&(&Cut, f64)| cut.cells.binary_search(&cell).is_ok() && cut.nodes.binary_search(&node).is_ok();
        let cuts = self.straining.cuts.iter().filter(at_cut);
        cuts.fold([0.0; 3], |jump, (cut, shortening)| add(jump, scale(*shortening, cut.axis)))
    }

    /// The samples of all cells.
    pub(super) fn samples(&self) -> Samples {
        let x = &self.solid.mesh.nodes;
        let mut cell = 0;
        let of_block = |(number, block): (usize, &Cells)| {
            let count = samples_of(block.kind);
            let mut samples = vec![Sample::default(); count * block.len()];
            let nodes = block.nodes.par_chunks_exact(block.kind.nodes());
            let tasks = samples.par_chunks_exact_mut(count.max(1)).zip(nodes);
            tasks.enumerate().with_min_len(CELLS_PER_TASK).for_each(|(i, (own, nodes))| {
                let at = At { block: number, cell: cell + i, local: i, nodes };
                own[0].place = mean(nodes.iter().map(|&node| x[node as usize]));
                let known = match block.kind {
                    CellKind::Tet4 => Tet4::new(&corners(x, nodes)).map(|e| own[0].stress = self.stress(&e, &at)[0]),
                    CellKind::Hex8 => {
                        Hex8::averaged(&corners(x, nodes)).map(|e| own[0].stress = self.stress(&e, &at)[0])
                    }
                    CellKind::Wedge6 => {
                        Wedge6::new(&corners(x, nodes)).map(|e| own[0].stress = self.mean_stress(&e, &at))
                    }
                    CellKind::Tet10 | CellKind::Wedge15 => None,
                    CellKind::Hex20 => Hex20::new(&corners(x, nodes)).map(|e| {
                        let stress = self.stress(&e, &at);
                        for ((sample, weights), shape) in own.iter_mut().zip(&*HEX20_SAMPLES).zip(&*HEX20_AT_SAMPLES) {
                            let weighted = shape.iter().zip(nodes).map(|(s, &node)| scale(*s, x[node as usize]));
                            sample.place = weighted.fold([0.0; 3], add);
                            sample.stress = combined(weights, &stress);
                        }
                    }),
                };
                if known.is_none() {
                    own.iter_mut().for_each(|sample| sample.stress = [f64::NAN; 6]);
                }
            });
            cell += block.len();
            (count, samples)
        };
        Samples(self.solid.mesh.cells.iter().enumerate().map(of_block).collect())
    }

    /// Of each cell the squared energy norms of the error, of the stress and of the stress that would suppress its strain
    /// without stress or could be rounding of its motion, with its volume between: error, stress, volume, suppressing stress.
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
                own[3] += own[2] * self.moved(&at, own[2].cbrt());
            });
            (rest, cell) = (others, cell + block.len());
        }
        errors
    }

    fn error(&self, kind: CellKind, at: &At, samples: &Samples, patches: &Patches) -> Option<[f64; 4]> {
        let x = &self.solid.mesh.nodes;
        let region = self.region[at.cell];
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
                let compliance = &self.constants(at.cell).1;
                let found = samples.at((at.block, at.local))[0].stress;
                let (mut sum, mut squares) = ([0.0; 6], 0.0);
                for &node in at.nodes {
                    let smooth = patches.at_corner(node, region);
                    let error = from_fn(|k| smooth[k] - found[k]);
                    (0..6).for_each(|k| sum[k] += error[k]);
                    squares += compliance.energy(&error);
                }
                // ∫ b_i b_j = (1 + δ_ij) V / 20
                squares += compliance.energy(&sum);
                let suppressed = volume * self.suppressed(at, 0);
                [volume / 20.0 * squares, volume * compliance.energy(&found), volume, suppressed]
            }
            CellKind::Hex8 => {
                let e = Hex8::new(&corners(x, at.nodes))?;
                self.integrated(&e.weight, &self.stress(&e, at), at, &from_fn(smooth), |q| &HEX8_SHAPES[q])
            }
            CellKind::Tet10 => {
                let rule = &*TET10;
                let (weight, stress) = match is_straight(x, at.nodes) {
                    true => self.straight(at)?,
                    false => {
                        let e = Tet10::new(&corners(x, at.nodes))?;
                        (e.weight, self.stress(&e, at))
                    }
                };
                self.integrated(&weight, &stress, at, &from_fn(smooth), |q| &rule[q].shape)
            }
            CellKind::Hex20 => {
                let e = Hex20::new(&corners(x, at.nodes))?;
                let rule = &*HEX20;
                self.integrated(&e.weight, &self.stress(&e, at), at, &from_fn(smooth), |q| &rule[q].shape)
            }
            CellKind::Wedge6 => {
                let e = Wedge6::new(&corners(x, at.nodes))?;
                let rule = &*WEDGE6;
                self.integrated(&e.weight, &self.stress(&e, at), at, &from_fn(smooth), |q| &rule[q].shape)
            }
            CellKind::Wedge15 => {
                let e = Wedge15::new(&corners(x, at.nodes))?;
                let rule = &*WEDGE15;
                self.integrated(&e.weight, &self.stress(&e, at), at, &from_fn(smooth), |q| &rule[q].shape)
            }
        })
    }

    /// Integrals over a cell, `smooth` the recovered stress at its nodes.
    fn integrated<'s, const N: usize, const Q: usize>(
        &self,
        weight: &[f64; Q],
        stress: &[Voigt; Q],
        at: &At,
        smooth: &[Voigt; N],
        shape: impl Fn(usize) -> &'s [f64; N],
    ) -> [f64; 4] {
        let compliance = &self.constants(at.cell).1;
        // The recovered stress is that of the whole strain.
        let whole = (N == 10 || N == 15) && !self.straining.initial.is_empty();
        let mut sums = [0.0; 4];
        for (q, (found, weight)) in stress.iter().zip(weight).enumerate() {
            let smooth = combined(shape(q), smooth);
            let mut error = from_fn(|k| smooth[k] - found[k]);
            if whole {
                let free = self.law(at.cell).stress(&self.free_strain(at, q));
                (0..6).for_each(|k| error[k] -= free[k]);
            }
            let parts = [compliance.energy(&error), compliance.energy(found), 1.0, self.suppressed(at, q)];
            sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += weight * part);
        }
        sums
    }

    /// Volumes of the integration points of a straight tetrahedron with ten nodes and the stress there, which is linear. `None` if it is
    /// folded.
    fn straight(&self, at: &At) -> Option<([f64; 14], [Voigt; 14])> {
        let e = Tet4::new(&corners(&self.solid.mesh.nodes, &at.nodes[..4]))?;
        let u: [V3; 10] = self.seen(at);
        let g = &e.gradient[0];
        let edges = CellKind::Tet10.edges();
        let law = self.law(at.cell);
        let at_corners: [Voigt; 4] = from_fn(|corner| {
            let own = (0..4).map(|i| (u[i], scale(if i == corner { 3.0 } else { -1.0 }, g[i])));
            let middle = |(k, ends): (usize, &[usize; 2])| {
                let other = ends[usize::from(ends[0] == corner)];
                ends.contains(&corner).then(|| (u[4 + k], scale(4.0, g[other])))
            };
            law.stress(&fem::strain(own.chain(edges.iter().enumerate().filter_map(middle))))
        });
        let stress = from_fn(|q| {
            let free = if self.straining.initial.is_empty() { [0.0; 6] } else { law.stress(&self.free_strain(at, q)) };
            let whole = combined(&LINEAR_AT_TET10[q], &at_corners);
            from_fn(|k| whole[k] - free[k])
        });
        Some((from_fn(|q| 6.0 * e.weight[0] * TET10[q].weight), stress))
    }

    /// Displacements of the nodes of a cell as it sees them: at a cut where the other side is.
    #[inline]
    fn seen<const N: usize>(&self, at: &At) -> [V3; N] {
        let displacement = self.straining.displacement.as_chunks().0;
        from_fn(|i| sub(displacement[at.nodes[i] as usize], self.jump(at.cell as u32, at.nodes[i])))
    }

    fn mean_stress<const N: usize, const Q: usize>(&self, element: &Element<N, Q>, at: &At) -> Voigt {
        let volume = element.volume();
        combined(&element.weight.map(|weight| weight / volume), &self.stress(element, at))
    }

    /// Strain of a cell at its integration points, what causes no stress included.
    #[inline]
    pub(super) fn strain<const N: usize, const Q: usize>(&self, element: &Element<N, Q>, at: &At) -> [Voigt; Q] {
        let u: [V3; N] = self.seen(at);
        element.gradient.map(|gradient| fem::strain(u.into_iter().zip(gradient)))
    }

    /// Stress of a cell at its integration points.
    #[inline]
    pub(super) fn stress<const N: usize, const Q: usize>(&self, element: &Element<N, Q>, at: &At) -> [Voigt; Q] {
        let law = self.law(at.cell);
        let mut strain = self.strain(element, at);
        if Element::<N, Q>::AVERAGES && law.mean_dilatation {
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

    /// Squared energy norm, per volume, of the stress of a strain that is [`MOTION`] times the largest displacement of a cell over its size.
    fn moved(&self, at: &At, size: f64) -> f64 {
        let components = at.nodes.iter().flat_map(|&node| &self.straining.displacement[3 * node as usize..][..3]);
        let strain = MOTION * components.fold(0.0, |a: f64, u| a.max(u.abs())) / size;
        self.law(at.cell).stress(&[strain, strain, strain, 0.0, 0.0, 0.0])[..3].iter().map(|s| s * strain).sum()
    }

    /// Squared energy norm, per volume, of the stress that would suppress the thermal strain.
    fn suppressed(&self, at: &At, q: usize) -> f64 {
        if self.straining.initial.is_empty() {
            return 0.0;
        }
        let free = self.free_strain(at, q);
        self.law(at.cell).stress(&free).iter().zip(free).map(|(s, e)| s * e).sum()
    }
}

/// Which cell it is: its block, its number in the mesh and in the block, its nodes.
pub(super) struct At<'m> {
    pub(super) block: usize,
    pub(super) cell: usize,
    pub(super) local: usize,
    pub(super) nodes: &'m [u32],
}

#[inline]
pub(super) fn combined<const K: usize>(weights: &[f64; K], values: &[Voigt; K]) -> Voigt {
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
