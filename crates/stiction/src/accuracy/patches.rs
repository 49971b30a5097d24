//! Polynomials of stress around the corners of a mesh.

use std::array::from_fn;

use rayon::prelude::*;

use super::cells::{Body, Samples, places, samples_of};
use crate::fem::Voigt;
use crate::mesh::v3::{V3, dot, scale, sub};
use crate::mesh::{Buckets, CellKind, Mesh, ascending};

/// Terms of a linear polynomial, and of a quadratic one.
const LINEAR: usize = 4;
const QUADRATIC: usize = 10;

/// Linear polynomials are fitted to so many samples at least, quadratic ones to so many: tetrahedra with one sample each take
/// their neighbours as well. A closer fit follows the scatter of the stress where it is not smooth and calls it right.
const LEAST_SAMPLES: [usize; 2] = [8, 40];

/// How fast the weight of samples falls with their squared distance, in wider patches of cells with several samples:
/// without, what lies farther along the surface decides on the stress at it.
const FADING: f64 = 0.25;

/// A term of which the terms before it leave less than this part is not known from the samples: a slope across a surface
/// from one layer of cells; a curvature from two points, in the cells around a corner and in wider patches.
const LEAST_SLOPE: f64 = 0.05;
const LEAST_CURVATURE: [f64; 2] = [0.02, 1e-3];

/// Patches for each task of a thread at least.
const PATCHES_PER_TASK: usize = 128;

/// The recovered stress: one polynomial for each corner and each region of the cells around it.
pub(super) struct Patches {
    corners: Corners,
    /// Stress at the corner.
    value: Vec<Voigt>,
    /// How it changes around the corner; empty where all cells are linear.
    change: Vec<Change>,
}

/// The terms of a polynomial beyond the first.
struct Change {
    corner: V3,
    /// Rows that give the local coordinates of a place relative to the corner.
    frame: [V3; 3],
    terms: [Voigt; QUADRATIC - 1],
}

/// Which patches there are.
struct Corners {
    /// Node `i` has the patches `start[i]..start[i + 1]`, one for each region.
    start: Vec<u32>,
    /// Region and corner of each patch.
    patch: Vec<[u32; 2]>,
}

impl Corners {
    #[inline]
    fn patch(&self, node: u32, region: u32) -> usize {
        let range = self.start[node as usize] as usize..self.start[node as usize + 1] as usize;
        let place = self.patch[range.clone()].iter().position(|patch| patch[0] == region).unwrap_or(0);
        range.start + place
    }
}

impl Patches {
    pub(super) fn new(body: &Body, samples: &Samples) -> Self {
        let mesh = body.solid.mesh;
        let region = body.straining.region;
        let around = Buckets::new(mesh.nodes.len(), mesh.cell_count(), |range| {
            mesh.cells_in(range)
                .flat_map(|(cell, nodes)| corners_of(nodes).iter().map(move |&node| [node, cell as u32]))
        });
        let mut corners = Corners { start: vec![0], patch: Vec::with_capacity(mesh.nodes.len()) };
        for node in 0..mesh.nodes.len() {
            let first = corners.patch.len();
            for &cell in around.at(node) {
                let own = [region[cell as usize], node as u32];
                if !corners.patch[first..].contains(&own) {
                    corners.patch.push(own);
                }
            }
            corners.start.push(corners.patch.len() as u32);
        }
        let finder = Finder { mesh, samples, region, around: &around, ends: ends(mesh) };
        let quadratic = mesh.cells.iter().any(|block| !block.kind.edges().is_empty());
        let found = corners.patch.par_iter().with_min_len(PATCHES_PER_TASK);
        if !quadratic {
            let value = found.map(|&[region, node]| finder.polynomial::<LINEAR>(node, region).0[0]).collect();
            return Patches { corners, value, change: Vec::new() };
        }
        let polynomial = |&[region, node]: &[u32; 2]| {
            let ([value, terms @ ..], frame) = finder.polynomial::<QUADRATIC>(node, region);
            (value, Change { corner: mesh.nodes[node as usize], frame, terms })
        };
        let (value, change) = found.map(polynomial).unzip();
        Patches { corners, value, change }
    }

    /// Recovered stress at a corner of cells of `region`.
    #[inline]
    pub(super) fn at_corner(&self, node: u32, region: u32) -> &Voigt {
        &self.value[self.corners.patch(node, region)]
    }

    /// What the polynomial of a corner says at the place `x`.
    pub(super) fn near_corner(&self, node: u32, region: u32, x: V3) -> Voigt {
        let patch = self.corners.patch(node, region);
        let Change { corner, frame, terms } = &self.change[patch];
        let [_, powers @ ..]: [f64; QUADRATIC] = monomials(frame, sub(x, *corner));
        let mut stress = self.value[patch];
        for (power, term) in powers.iter().zip(terms) {
            (0..6).for_each(|k| stress[k] += power * term[k]);
        }
        stress
    }
}

/// The corners of a cell with these nodes.
fn corners_of(nodes: &[u32]) -> &[u32] {
    &nodes[..if nodes.len() == 4 || nodes.len() == 10 { 4 } else { 8 }]
}

fn ends(mesh: &Mesh) -> Vec<usize> {
    let mut end = 0;
    let after = |len: usize| {
        end += len;
        end
    };
    mesh.cells.iter().map(|block| block.len()).map(after).collect()
}

/// `1, x, y, z` and squares and products of the local coordinates of the place `away` from the corner.
#[inline]
fn monomials<const M: usize>(frame: &[V3; 3], away: V3) -> [f64; M] {
    let [x, y, z] = [dot(frame[0], away), dot(frame[1], away), dot(frame[2], away)];
    let all = [1.0, x, y, z, x * x, y * y, z * z, x * y, y * z, z * x];
    from_fn(|i| all[i])
}

/// Finds polynomials.
struct Finder<'a> {
    mesh: &'a Mesh,
    samples: &'a Samples,
    region: &'a [u32],
    /// Cells at each corner.
    around: &'a Buckets,
    /// The number after the last cell of each block.
    ends: Vec<usize>,
}

/// Coefficients, and the frame of the local coordinates.
type Polynomial<const M: usize> = ([Voigt; M], [V3; 3]);

impl Finder<'_> {
    fn cell(&self, cell: u32) -> (CellKind, &[u32]) {
        let block = self.ends.partition_point(|&end| end <= cell as usize);
        let cells = &self.mesh.cells[block];
        (cells.kind, cells.cell(cell as usize + cells.len() - self.ends[block]))
    }

    /// The polynomial of a corner: from the cells around it, from these and all their neighbours where they do not suffice,
    /// and if that is too little as well from as many terms as can be told apart.
    fn polynomial<const M: usize>(&self, node: u32, region: u32) -> Polynomial<M> {
        let own =
            |node: u32| self.around.at(node as usize).iter().copied().filter(|&c| self.region[c as usize] == region);
        let corner = self.mesh.nodes[node as usize];
        let cells: Vec<u32> = own(node).collect();
        let frame = self.frame(corner, &cells);
        let whole =
            |cells: &[u32], strict: bool, wide: bool| Some((self.fit(corner, frame, cells, strict, wide)?, frame));
        whole(&cells, true, false).unwrap_or_else(|| {
            let corners = ascending(cells.iter().flat_map(|&cell| corners_of(self.cell(cell).1)).copied());
            let wider = ascending(corners.into_iter().flat_map(own));
            let found = whole(&wider, true, true).or_else(|| whole(&wider, false, true));
            found.unwrap_or(([[f64::NAN; 6]; M], frame))
        })
    }

    /// Coordinates around a corner in which its cells are about as wide along each axis: flat cells and thin layers are no
    /// reason for lack of digits, and what [`LEAST_SLOPE`] says holds for all of them.
    fn frame(&self, corner: V3, cells: &[u32]) -> [V3; 3] {
        let mut moment = [[0.0; 3]; 3];
        let mut count = 0.0;
        for &cell in cells {
            for &node in corners_of(self.cell(cell).1) {
                let away = sub(self.mesh.nodes[node as usize], corner);
                for a in 0..3 {
                    (0..=a).for_each(|b| moment[a][b] += away[a] * away[b]);
                }
                count += 1.0;
            }
        }
        // Rows of the inverse of the Cholesky factor of the mean moment.
        let mut rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut factor = [[0.0; 3]; 3];
        for a in 0..3 {
            for b in 0..=a {
                let rest = moment[a][b] / count - (0..b).map(|k| factor[a][k] * factor[b][k]).sum::<f64>();
                factor[a][b] = if a == b { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / factor[b][b] };
            }
            for b in 0..a {
                rows[a] = sub(rows[a], scale(factor[a][b], rows[b]));
            }
            rows[a] = scale(1.0 / factor[a][a], rows[a]);
        }
        rows
    }

    /// Least squares over the samples of `cells`. If `strict`, `None` where these are too few or lie such that they do not
    /// tell all terms; otherwise those they do not tell are left out. Of a `wide` patch of cells
    /// with several samples near ones have more weight.
    fn fit<const M: usize>(
        &self,
        corner: V3,
        frame: [V3; 3],
        cells: &[u32],
        strict: bool,
        wide: bool,
    ) -> Option<[Voigt; M]> {
        let (mut mean, mut count) = ([0.0; 6], 0);
        for &cell in cells {
            let stress = self.samples.at(cell, samples_of(self.cell(cell).0));
            stress.iter().for_each(|stress| (0..6).for_each(|k| mean[k] += stress[k]));
            count += stress.len();
        }
        if strict && count < LEAST_SAMPLES[usize::from(M > LINEAR)] {
            return None;
        }
        mean.iter_mut().for_each(|sum| *sum /= count as f64);
        let curvature = LEAST_CURVATURE[usize::from(wide)];
        let (mut gram, mut right) = ([[0.0; M]; M], [[0.0; 6]; M]);
        for &cell in cells {
            let (kind, nodes) = self.cell(cell);
            let stress = self.samples.at(cell, samples_of(kind));
            let fades = wide && stress.len() > 1;
            for (place, stress) in places(kind, &self.mesh.nodes, nodes).iter().zip(stress) {
                let terms: [f64; M] = monomials(&frame, sub(*place, corner));
                let weight =
                    if fades { 1.0 / (1.0 + FADING * (1..4).map(|i| terms[i] * terms[i]).sum::<f64>()) } else { 1.0 };
                // Uniform stress is kept to the last digit.
                let rest: Voigt = from_fn(|k| weight * (stress[k] - mean[k]));
                for i in 0..M {
                    let weighted = weight * terms[i];
                    (0..=i).for_each(|j| gram[i][j] += weighted * terms[j]);
                    (0..6).for_each(|k| right[i][k] += terms[i] * rest[k]);
                }
            }
        }
        solve(&mut gram, &mut right, curvature, strict).then(|| {
            (0..6).for_each(|k| right[0][k] += mean[k]);
            right
        })
    }
}

/// Solves with a Gram matrix (its lower triangle) by Cholesky's method; `right` becomes the solution. Where a term depends
/// on those before it, false if `strict`; otherwise it gets no part.
fn solve<const M: usize>(gram: &mut [[f64; M]; M], right: &mut [Voigt; M], curvature: f64, strict: bool) -> bool {
    let mut known = [true; M];
    for i in 0..M {
        for j in 0..=i {
            let rest = gram[i][j] - (0..j).map(|k| gram[i][k] * gram[j][k]).sum::<f64>();
            if i > j {
                gram[i][j] = if known[j] { rest / gram[j][j] } else { 0.0 };
                continue;
            }
            let least = if i < LINEAR { LEAST_SLOPE.min(i as f64) } else { curvature };
            known[i] = rest > least * gram[i][i];
            gram[i][i] = rest.max(0.0).sqrt();
        }
        if strict && !known[i] {
            return false;
        }
        for j in 0..i {
            (0..6).for_each(|k| right[i][k] -= gram[i][j] * right[j][k]);
        }
        (0..6).for_each(|k| right[i][k] = if known[i] { right[i][k] / gram[i][i] } else { 0.0 });
    }
    for i in (0..M).rev() {
        for j in i + 1..M {
            (0..6).for_each(|k| right[i][k] -= gram[j][i] * right[j][k]);
        }
        (0..6).for_each(|k| right[i][k] = if known[i] { right[i][k] / gram[i][i] } else { 0.0 });
    }
    true
}
