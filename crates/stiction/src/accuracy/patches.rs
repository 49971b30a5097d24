//! Polynomials of stress around the corners of a mesh.

use std::array::from_fn;
use std::borrow::Cow;
use std::sync::LazyLock;

use rayon::prelude::*;

use super::cells::{Body, Sample, Samples};
use crate::fem::{CellList, Voigt, strain_of};
use crate::mesh::v3::{V3, add, cross, dot, scale, sub};
use crate::mesh::{Buckets, CellKind, ascending};

/// Numbers of a polynomial: stress, the frame of its local coordinates, its further terms.
pub(crate) const PATCH: usize = 6 + 9 + 6 * (QUADRATIC - 1);

/// Terms of a linear, a quadratic and a cubic polynomial.
const LINEAR: usize = 4;
const QUADRATIC: usize = 10;
const CUBIC: usize = 20;

/// Powers of the local coordinates in each term.
const POWERS: [[u8; 3]; CUBIC] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [2, 0, 0],
    [0, 2, 0],
    [0, 0, 2],
    [1, 1, 0],
    [0, 1, 1],
    [1, 0, 1],
    [3, 0, 0],
    [0, 3, 0],
    [0, 0, 3],
    [2, 1, 0],
    [2, 0, 1],
    [1, 2, 0],
    [0, 2, 1],
    [1, 0, 2],
    [0, 1, 2],
    [1, 1, 1],
];

/// The derivative of a term along a local coordinate: which term it is, up to the power that comes down.
static DERIVATIVE: LazyLock<[[Option<usize>; 3]; CUBIC]> = LazyLock::new(|| {
    POWERS.map(|powers| {
        from_fn(|c| {
            let mut lower = powers;
            lower[c] = lower[c].checked_sub(1)?;
            POWERS.iter().position(|powers| *powers == lower)
        })
    })
});

/// Linear cells whose stress a polynomial is fitted to at least. A closer fit follows the scatter of the stress where it is not
/// smooth and calls it right.
const LEAST_CELLS: usize = 8;

/// A term, by its degree, of which the terms before it leave less than this part is not known from the places: a slope across a
/// surface from one layer of cells; a curvature from two points; a third power from three layers of nodes, which leave nothing of
/// it where enough of them leave 0.001 and more.
const LEAST_PART: [f64; 4] = [0.0, 0.05, 0.02, 1e-3];

/// The same for a curvature in wider patches of hexahedra.
const LEAST_CURVATURE: f64 = 1e-3;

/// How fast the weight of samples falls with their squared distance in wider patches of hexahedra: without, what lies
/// farther along the surface decides on the stress at it.
const FADING: f64 = 0.25;

/// Patches for each task of a thread at least.
const PATCHES_PER_TASK: usize = 128;

/// The recovered stress: one polynomial for each corner and each region of the cells around it.
///
/// Tetrahedra with ten nodes and wedges with fifteen, which have no points where their stress is better than elsewhere: the polynomial of third degree
/// through the displacements of the nodes, differentiated; its stress is that of the whole strain, the one without stress
/// included. Other cells: a polynomial through stresses at their samples.
pub(crate) struct Patches {
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
        if range.len() == 1 {
            return range.start;
        }
        let place = self.patch[range.clone()].iter().position(|patch| patch[0] == region).unwrap_or(0);
        range.start + place
    }
}

impl Patches {
    pub(super) fn new(body: &Body, samples: &Samples) -> Self {
        let mesh = body.solid.mesh;
        let region = &body.region;
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
        let finder = Finder { body, samples, around: &around, cells: body.solid.cells() };
        let found = corners.patch.par_iter().with_min_len(PATCHES_PER_TASK);
        if mesh.cells.iter().all(|block| block.kind.edges().is_empty()) {
            let value = found.map(|&[region, node]| finder.linear(node, region)).collect();
            return Patches { corners, value, change: Vec::new() };
        }
        let polynomial = |&[region, node]: &[u32; 2]| {
            let ([value, terms @ ..], frame) = finder.polynomial(node, region);
            (value, Change { corner: mesh.nodes[node as usize], frame, terms })
        };
        let (value, change) = found.map(polynomial).unzip();
        Patches { corners, value, change }
    }

    /// Region and corner of each polynomial.
    pub(crate) fn list(&self) -> &[[u32; 2]] {
        &self.corners.patch
    }

    /// The polynomial of a corner and a region of cells there, as numbers that [`Self::put`] takes.
    pub(crate) fn get(&self, [region, node]: [u32; 2]) -> [f64; PATCH] {
        let patch = self.corners.patch(node, region);
        let change = self.change.get(patch);
        let frame = change.map_or([[0.0; 3]; 3], |change| change.frame);
        let terms = change.map_or([[0.0; 6]; QUADRATIC - 1], |change| change.terms);
        let numbers = self.value[patch].iter().chain(frame.as_flattened()).chain(terms.as_flattened());
        let mut all = [0.0; PATCH];
        all.iter_mut().zip(numbers).for_each(|(to, from)| *to = *from);
        all
    }

    /// Replaces a polynomial, by its place in [`Self::list`].
    pub(crate) fn put(&mut self, patch: usize, numbers: &[f64; PATCH]) {
        let (value, change) = numbers.split_at(6);
        self.value[patch].copy_from_slice(value);
        let (frame, terms) = change.split_at(9);
        if let Some(own) = self.change.get_mut(patch) {
            own.frame.as_flattened_mut().copy_from_slice(frame);
            own.terms.as_flattened_mut().copy_from_slice(terms);
        }
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
        let [_, powers @ ..]: [f64; QUADRATIC] = monomials(local(frame, sub(x, *corner)));
        let mut stress = self.value[patch];
        for (power, term) in powers.iter().zip(terms) {
            (0..6).for_each(|k| stress[k] += power * term[k]);
        }
        stress
    }
}

/// The corners of a cell with these nodes.
fn corners_of(nodes: &[u32]) -> &[u32] {
    &nodes[..match nodes.len() {
        4 | 10 => 4,
        6 | 15 => 6,
        _ => 8,
    }]
}

#[inline]
fn local(frame: &[V3; 3], away: V3) -> V3 {
    frame.map(|row| dot(row, away))
}

/// The terms of polynomials, as in [`POWERS`].
#[inline]
fn monomials<const M: usize>([x, y, z]: V3) -> [f64; M] {
    let [xx, yy, zz] = [x * x, y * y, z * z];
    let squares = [1.0, x, y, z, xx, yy, zz, x * y, y * z, z * x];
    let cubes = [x * xx, y * yy, z * zz, xx * y, xx * z, yy * x, yy * z, zz * x, zz * y, x * y * z];
    from_fn(|i| if i < QUADRATIC { squares[i] } else { cubes[i - QUADRATIC] })
}

/// Finds polynomials.
struct Finder<'a> {
    body: &'a Body<'a>,
    samples: &'a Samples,
    /// Cells at each corner.
    around: &'a Buckets,
    cells: CellList<'a>,
}

/// A polynomial of stress, and the frame of its local coordinates.
type Polynomial = ([Voigt; QUADRATIC], [V3; 3]);

impl Finder<'_> {
    /// The cells of `region` at a node.
    fn at(&self, node: u32, region: u32) -> Cow<'_, [u32]> {
        let all = self.around.at(node as usize);
        let is_of_region = |&cell: &u32| self.body.region[cell as usize] == region;
        match all.iter().all(is_of_region) {
            true => Cow::Borrowed(all),
            false => Cow::Owned(all.iter().copied().filter(is_of_region).collect()),
        }
    }

    fn polynomial(&self, node: u32, region: u32) -> Polynomial {
        let cells = self.at(node, region);
        match self.cells.get(cells[0] as usize).0 {
            CellKind::Tet10 | CellKind::Wedge15 => self.differentiated(node, &cells, region),
            CellKind::Hex20 => self.quadratic(node, &cells, region),
            CellKind::Tet4 | CellKind::Hex8 | CellKind::Wedge6 => {
                let mut terms = [[0.0; 6]; QUADRATIC];
                terms[0] = self.linear(node, region);
                (terms, [[0.0; 3]; 3])
            }
        }
    }

    fn samples(&self, cells: &[u32]) -> impl Iterator<Item = &Sample> {
        cells.iter().flat_map(|&cell| self.samples.at(self.cells.place(cell as usize)))
    }

    /// Stress at a corner of linear cells: of the polynomial through the mean stresses of the cells around it; of these and all their
    /// neighbours where they do not suffice, and if that is too little as well from as many terms as can be told apart.
    fn linear(&self, node: u32, region: u32) -> Voigt {
        let corner = self.body.solid.mesh.nodes[node as usize];
        let cells = self.at(node, region);
        self.extrapolated(corner, &cells).unwrap_or_else(|| {
            let fitted = self.fitted(corner, &self.frame(corner, &cells), &self.around(&cells, region), 0.0);
            fitted.solved(false, LEAST_PART[2]).map_or([f64::NAN; 6], |terms: [Voigt; LINEAR]| terms[0])
        })
    }

    /// The same of hexahedra with 20 nodes, from their samples.
    fn quadratic(&self, node: u32, cells: &[u32], region: u32) -> Polynomial {
        let corner = self.body.solid.mesh.nodes[node as usize];
        let frame = self.frame(corner, cells);
        let own = self.fitted(corner, &frame, cells, 0.0).solved(true, LEAST_PART[2]);
        let found = own.or_else(|| {
            self.fitted(corner, &frame, &self.around(cells, region), FADING).solved(false, LEAST_CURVATURE)
        });
        (found.unwrap_or([[f64::NAN; 6]; QUADRATIC]), frame)
    }

    /// These cells and their neighbours of the region.
    fn around(&self, cells: &[u32], region: u32) -> Vec<u32> {
        let corners = ascending(cells.iter().flat_map(|&cell| corners_of(self.cells.get(cell as usize).1)).copied());
        let mut around: Vec<u32> = Vec::with_capacity(8 * corners.len());
        corners.into_iter().for_each(|corner| around.extend_from_slice(&self.at(corner, region)));
        ascending(around)
    }

    fn mean_stress(&self, cells: &[u32]) -> Voigt {
        let (mut sum, mut count) = ([0.0; 6], 0.0);
        for Sample { stress, .. } in self.samples(cells) {
            (0..6).for_each(|k| sum[k] += stress[k]);
            count += 1.0;
        }
        sum.map(|sum| sum / count)
    }

    /// Stress at the samples of `cells`.
    fn fitted<const M: usize>(&self, corner: V3, frame: &[V3; 3], cells: &[u32], fading: f64) -> Fit<M, 6> {
        // Uniform stress is kept to the last digit.
        let mut fit = Fit::about(self.mean_stress(cells));
        for Sample { place, stress } in self.samples(cells) {
            let place = local(frame, sub(*place, corner));
            fit.add(1.0 / (1.0 + fading * dot(place, place)), place, *stress);
        }
        fit
    }

    /// What the linear polynomial through the stresses of `cells` says at the corner, `None` if they do not suffice.
    ///
    /// With the mean place `d` relative to the corner, the mean products `M` of places and `G` of places with the stress less
    /// its mean `s`, and `w = M⁻¹ d`, it says `s - Gᵀ w / (1 - w·d)`; the divisor is the part that [`LEAST_PART`] limits.
    fn extrapolated(&self, corner: V3, cells: &[u32]) -> Option<Voigt> {
        if cells.len() < LEAST_CELLS {
            return None;
        }
        let sample = |&cell: &u32| &self.samples.at(self.cells.place(cell as usize))[0];
        // Stress is counted from that of the first cell: so uniform stress is kept to the last digit.
        let first = sample(&cells[0]).stress;
        let (mut d, mut m, mut s, mut g) = ([0.0; 3], [0.0; 6], [0.0; 6], [[0.0; 6]; 3]);
        for Sample { place, stress } in cells.iter().map(sample) {
            let away = sub(*place, corner);
            let [x, y, z] = away;
            let products = [x * x, y * y, z * z, x * y, y * z, z * x];
            (0..3).for_each(|a| d[a] += away[a]);
            for k in 0..6 {
                let rest = stress[k] - first[k];
                m[k] += products[k];
                s[k] += rest;
                (0..3).for_each(|a| g[a][k] += away[a] * rest);
            }
        }
        let count = cells.len() as f64;
        let [xx, yy, zz, xy, yz, zx] = m;
        let m = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
        let normals = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
        let w = scale(1.0 / dot(m[0], normals[0]), normals.map(|normal| dot(normal, d)));
        let left = 1.0 - dot(w, d) / count;
        // What is left of the sums of products once the mean stress is taken off.
        let rest = |a: usize, k: usize| g[a][k] - d[a] * s[k] / count;
        let slope = |k: usize| (0..3).map(|a| w[a] * rest(a, k)).sum::<f64>();
        (left > LEAST_PART[1]).then(|| from_fn(|k| first[k] + s[k] / count - slope(k) / (count * left)))
    }

    /// From the displacements of the nodes of the cells around a corner, differentiated (Zhang and Naga 2005); of these and all
    /// their neighbours where they do not suffice, and if that is too little as well from as many terms as can be told apart.
    fn differentiated(&self, node: u32, cells: &[u32], region: u32) -> Polynomial {
        let frame = self.frame(self.body.solid.mesh.nodes[node as usize], cells);
        let seen: Vec<Seen> = cells.iter().map(|&cell| (cell, self.body.jump(cell, node))).collect();
        let found = self.displacement(node, &frame, &seen, true);
        let found = found.or_else(|| self.displacement(node, &frame, &self.wider(&seen, region), false));
        let law = self.body.law(cells[0] as usize);
        let terms =
            found.map_or([[f64::NAN; 6]; QUADRATIC], |u| gradients(&frame, &u).map(|h| law.stress(&strain_of(&h))));
        (terms, frame)
    }

    /// These cells and their neighbours of the region.
    fn wider(&self, cells: &[Seen], region: u32) -> Vec<Seen> {
        let corners = cells.iter().flat_map(|&(cell, ahead)| {
            let corners = corners_of(self.cells.get(cell as usize).1).iter();
            corners.map(move |&corner| (corner, sub(ahead, self.body.jump(cell, corner))))
        });
        let around = |(corner, ahead): Seen| {
            let cells = self.at(corner, region).into_owned().into_iter();
            cells.map(move |cell| (cell, add(ahead, self.body.jump(cell, corner))))
        };
        first_of_each(first_of_each(corners.collect()).into_iter().flat_map(around).collect())
    }

    /// The polynomial of displacement of a patch. If `strict`, `None` where it does not tell all terms.
    fn displacement(&self, node: u32, frame: &[V3; 3], cells: &[Seen], strict: bool) -> Option<[V3; CUBIC]> {
        let mesh = self.body.solid.mesh;
        let u = self.body.straining.displacement.as_chunks().0;
        let mut nodes: Vec<[u32; 2]> = Vec::with_capacity(10 * cells.len());
        for (place, &(cell, _)) in cells.iter().enumerate() {
            nodes.extend(self.cells.get(cell as usize).1.iter().map(|&node| [node, place as u32]));
        }
        nodes.sort_unstable();
        nodes.dedup_by_key(|entry| entry[0]);
        if strict && nodes.len() < CUBIC {
            return None;
        }
        // Of displacements only what they differ by is told to the last digit.
        let (corner, own) = (mesh.nodes[node as usize], u[node as usize]);
        let mut fit = Fit::about([0.0; 3]);
        for [node, place] in nodes {
            let (cell, ahead) = cells[place as usize];
            let ahead = sub(ahead, self.body.jump(cell, node));
            let away = sub(mesh.nodes[node as usize], corner);
            fit.add(1.0, local(frame, away), add(sub(u[node as usize], own), ahead));
        }
        fit.solved(strict, LEAST_PART[2])
    }

    /// Coordinates around a corner in which its cells are about as wide along each axis: flat cells and thin layers are no
    /// reason for lack of digits, and what [`LEAST_PART`] says holds for all of them.
    fn frame(&self, corner: V3, cells: &[u32]) -> [V3; 3] {
        let nodes = &self.body.solid.mesh.nodes;
        let mut moment = [[0.0; 3]; 3];
        let mut count = 0.0;
        for &cell in cells {
            for &node in corners_of(self.cells.get(cell as usize).1) {
                let away = sub(nodes[node as usize], corner);
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
}

/// A cell or node of a patch, and what is added to the displacements it sees to have those of the patch: cells beyond a cut see it drawn
/// back.
type Seen = (u32, V3);

/// The first entry of each number, ascending. All entries of a number say the same but where a cut ends inside the patch.
fn first_of_each(mut list: Vec<Seen>) -> Vec<Seen> {
    list.sort_by_key(|seen| seen.0);
    list.dedup_by_key(|seen| seen.0);
    list
}

/// Gradient, as a polynomial of degree two, of a displacement of degree three: `h[a][b]` is `∂u_a/∂x_b`.
fn gradients(frame: &[V3; 3], u: &[V3; CUBIC]) -> [[V3; 3]; QUADRATIC] {
    let mut h = [[[0.0; 3]; 3]; QUADRATIC];
    for ((powers, lower), u) in POWERS.iter().zip(&*DERIVATIVE).zip(u) {
        for c in 0..3 {
            let Some(term) = lower[c] else { continue };
            for a in 0..3 {
                h[term][a] = add(h[term][a], scale(f64::from(powers[c]) * u[a], frame[c]));
            }
        }
    }
    h
}

/// Least squares for a polynomial of `M` terms with `V` values.
struct Fit<const M: usize, const V: usize> {
    /// What is taken off all values.
    mean: [f64; V],
    /// Products of the terms summed over the places, its lower triangle.
    gram: [[f64; M]; M],
    right: [[f64; V]; M],
}

impl<const M: usize, const V: usize> Fit<M, V> {
    fn about(mean: [f64; V]) -> Self {
        Fit { mean, gram: [[0.0; M]; M], right: [[0.0; V]; M] }
    }

    #[inline]
    fn add(&mut self, weight: f64, place: V3, value: [f64; V]) {
        let terms: [f64; M] = monomials(place);
        for i in 0..M {
            let weighted = weight * terms[i];
            (0..=i).for_each(|j| self.gram[i][j] += weighted * terms[j]);
            (0..V).for_each(|k| self.right[i][k] += weighted * (value[k] - self.mean[k]));
        }
    }

    /// The terms by Cholesky's method. Where the places do not tell one from those before it: `None` if `strict`, otherwise it
    /// gets no part. `curvature` is the least part of a term of degree two.
    fn solved(self, strict: bool, curvature: f64) -> Option<[[f64; V]; M]> {
        let Fit { mean, mut gram, mut right } = self;
        let least = [LEAST_PART[0], LEAST_PART[1], curvature, LEAST_PART[3]];
        let mut known = [true; M];
        for i in 0..M {
            for j in 0..=i {
                let rest = gram[i][j] - (0..j).map(|k| gram[i][k] * gram[j][k]).sum::<f64>();
                if i > j {
                    gram[i][j] = if known[j] { rest / gram[j][j] } else { 0.0 };
                    continue;
                }
                known[i] = rest > least[usize::from(POWERS[i].iter().sum::<u8>())] * gram[i][i];
                gram[i][i] = rest.max(0.0).sqrt();
            }
            if strict && !known[i] {
                return None;
            }
            for j in 0..i {
                (0..V).for_each(|k| right[i][k] -= gram[i][j] * right[j][k]);
            }
            (0..V).for_each(|k| right[i][k] = if known[i] { right[i][k] / gram[i][i] } else { 0.0 });
        }
        for i in (0..M).rev() {
            for j in i + 1..M {
                (0..V).for_each(|k| right[i][k] -= gram[j][i] * right[j][k]);
            }
            (0..V).for_each(|k| right[i][k] = if known[i] { right[i][k] / gram[i][i] } else { 0.0 });
        }
        (0..V).for_each(|k| right[0][k] += mean[k]);
        Some(right)
    }
}
