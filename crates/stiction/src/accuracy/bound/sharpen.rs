//! Less energy from the same equilibrium.
//!
//! Changes of the tractions that leave every cell balanced: on a face forces along its edges, equal and opposite at both ends;
//! around an edge a moment that each cell passes on to the next. The energy of `τ - σ` is minimised over them by conjugate
//! gradients, preconditioned by the blocks of faces and edges. Any number of steps gives a valid bound, so that
//! matrices are in single precision; the tractions stay balanced to double precision.

use rayon::prelude::*;

use super::equilibrate::{Given, OnFace};
use super::fill::{BLOCKS, Block, Map, Matrix, Sides};
use super::tets::{CELLS_PER_TASK, EDGES, NONE, Shape, Tets};
use crate::fem::Voigt;
use crate::linalg::vectorised;
use crate::mesh::v3::{V3, dot, norm, scale, sub};

/// Blocks of unknowns for each task of a thread at least.
const BLOCKS_PER_TASK: usize = 128;
/// What is added to the diagonal of a block, as part of it: its own rounding in single precision.
const ROUNDING: f64 = 1e-6;
/// Part of the first residual at which steps end.
const SMALL: f64 = 1e-9;

/// Tractions with the energy of their distance from `stress` reduced by so many steps.
pub(super) fn sharpen(
    tets: &Tets,
    given: &Given,
    shapes: &[Shape],
    compliances: &[[Voigt; 6]],
    apart: &(dyn Fn(usize, &[OnFace]) -> Sides + Sync),
    tractions: &mut [OnFace],
    steps: usize,
) {
    let of_cell = |cell: usize| &compliances[tets.solid.material_of_cell[cell] as usize];
    let cells = tets.corners.len();
    let size = (0..cells)
        .into_par_iter()
        .with_min_len(CELLS_PER_TASK)
        .map(|cell| Map::new(&shapes[cell]).size(of_cell(cell)))
        .reduce(|| 0.0, f64::max);
    let mut matrices: Vec<Matrix> = vec![[[[0.0; 9]; 9]; 10]; cells];
    matrices.par_chunks_mut(CELLS_PER_TASK).enumerate().for_each(|(task, chunk)| {
        vectorised(
            #[inline(always)]
            || {
                for (cell, matrix) in (CELLS_PER_TASK * task..).zip(chunk.iter_mut()) {
                    Map::new(&shapes[cell]).write_matrix(of_cell(cell), 1.0 / size, matrix);
                }
            },
        );
    });
    let system = System::new(tets, given, matrices);
    let start: Vec<Sides> =
        (0..cells).into_par_iter().with_min_len(CELLS_PER_TASK).map(|cell| apart(cell, tractions)).collect();
    let scale_of = start.par_iter().flatten().flatten().flatten().map(|v| v.abs()).reduce(|| 0.0, f64::max);
    if !(scale_of > 0.0 && scale_of.is_finite()) {
        return;
    }
    let single = |sides: &Sides| std::array::from_fn(|j| flat(&sides[j]).map(|v| (v / scale_of) as f32));
    let mut residual = system.gather(|cell| single(&start[cell]));
    drop(start);
    residual.par_iter_mut().for_each(|r| r.iter_mut().for_each(|v| *v = -*v));
    let mut direction: Vec<[f64; 9]> = Vec::new();
    let (mut before, mut first) = (0.0, 0.0);
    for step in 0..steps {
        let corrected = system.precondition(&residual);
        let product = inner(&corrected, &residual);
        if step == 0 {
            (direction, first) = (corrected, product);
        } else {
            let factor = product / before;
            direction.par_iter_mut().zip(&corrected).for_each(|(d, z)| {
                (0..9).for_each(|k| d[k] = z[k] + factor * d[k]);
            });
        }
        if product.is_nan() || product <= SMALL * SMALL * first {
            break;
        }
        before = product;
        let image = system.times(&direction);
        let curvature = inner(&direction, &image);
        if curvature.is_nan() || curvature <= 0.0 {
            break;
        }
        let length = product / curvature;
        residual.par_iter_mut().zip(&image).for_each(|(r, y)| (0..9).for_each(|k| r[k] -= length * y[k]));
        tractions.par_iter_mut().zip(&direction).for_each(|(t, d)| {
            (0..9).for_each(|k| t[k / 3][k % 3] += length * scale_of * d[k]);
        });
    }
}

fn flat(side: &[V3; 3]) -> [f64; 9] {
    std::array::from_fn(|k| side[k / 3][k % 3])
}

/// A scalar product in a fixed order.
fn inner(a: &[[f64; 9]], b: &[[f64; 9]]) -> f64 {
    const CHUNK: usize = 4096;
    let chunk = |(a, b): (&[[f64; 9]], &[[f64; 9]])| -> f64 {
        a.iter().zip(b).map(|(a, b)| (0..9).map(|k| a[k] * b[k]).sum::<f64>()).sum()
    };
    let parts: Vec<f64> = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK)).map(chunk).collect();
    parts.iter().sum()
}

/// A face whose tractions may change, with the inverse of its block.
struct FaceBlock {
    face: u32,
    modes: [[f64; 9]; 3],
    inverse: [[f64; 3]; 3],
}

/// An edge around which moments may be passed on.
struct EdgeBlock {
    /// Where its cells are in [`System::fans`].
    fan: [u32; 2],
    /// The directions of the moments; none if all are free.
    along: Option<V3>,
    inverse: [[f32; 6]; 6],
}

struct System<'a> {
    tets: &'a Tets<'a>,
    matrices: Vec<Matrix>,
    faces: Vec<FaceBlock>,
    edges: Vec<EdgeBlock>,
    /// Cells around edges with the local number of the edge: `8 cell + edge`.
    fans: Vec<u64>,
    /// Whether the corners of a cell turn the positive way.
    positive: Vec<bool>,
}

/// Of each edge of a cell its other corners `m < n`, and one if `(i, k, m, n)` is an even order.
const OTHERS: [([usize; 2], f64); 6] =
    [([2, 3], 1.0), ([1, 3], -1.0), ([1, 2], 1.0), ([0, 3], 1.0), ([0, 2], -1.0), ([0, 1], 1.0)];

/// Moments around an edge: of a face on its border those at this corner get nine, the others minus three.
fn weights(corner: usize) -> [f64; 3] {
    std::array::from_fn(|a| if a == corner { 9.0 } else { -3.0 })
}

impl<'a> System<'a> {
    fn new(tets: &'a Tets<'a>, given: &Given, matrices: Vec<Matrix>) -> Self {
        let cells = tets.corners.len();
        let positive = (0..cells).into_par_iter().with_min_len(1024).map(|cell| tets.shape(cell).positive).collect();
        let mut system = System { tets, matrices, faces: Vec::new(), edges: Vec::new(), fans: Vec::new(), positive };
        system.faces = system.face_blocks(given);
        let mut sides: Vec<([u32; 2], u64)> = (0..cells)
            .into_par_iter()
            .flat_map_iter(|cell| {
                let corners = tets.corners[cell];
                let edge = move |(k, [a, b]): (usize, [usize; 2])| ([corners[a], corners[b]], (8 * cell + k) as u64);
                EDGES.into_iter().enumerate().map(edge)
            })
            .collect();
        sides.par_sort_unstable();
        system.fans = sides.iter().map(|side| side.1).collect();
        let mut ranges = Vec::new();
        let mut first = 0;
        for edge in sides.chunk_by(|a, b| a.0 == b.0) {
            ranges.push([first, first + edge.len() as u32]);
            first += edge.len() as u32;
        }
        drop(sides);
        system.edges = system.edge_blocks(given, ranges);
        system
    }

    fn face_blocks(&self, given: &Given) -> Vec<FaceBlock> {
        let free = |side: &Option<super::Side>| side.as_ref().is_none_or(|side| side.directions.len() == 3);
        let list: Vec<u32> = (0..self.tets.faces.len() as u32).filter(|&f| free(&given.side[f as usize])).collect();
        let block = |face: u32| {
            let modes = self.face_modes(face);
            let mut own = [[0.0; 3]; 3];
            for &cell in self.tets.cells_of[face as usize].iter().filter(|&&cell| cell != NONE) {
                let j = self.local(cell, face);
                let block = &self.matrices[cell as usize][diagonal(j)];
                for a in 0..3 {
                    for b in 0..3 {
                        own[a][b] += form(block, &modes[a], &modes[b]);
                    }
                }
            }
            FaceBlock { face, modes, inverse: inverse(own) }
        };
        list.into_par_iter().with_min_len(BLOCKS_PER_TASK).map(block).collect()
    }

    fn edge_blocks(&self, given: &Given, ranges: Vec<[u32; 2]>) -> Vec<EdgeBlock> {
        let free = |fan: &[u32; 2]| -> Option<Option<V3>> {
            // Of an edge on the boundary the two faces there; directions that are held on both.
            let mut along: Option<V3> = None;
            for &entry in &self.fans[fan[0] as usize..fan[1] as usize] {
                for (_, face, _) in self.sides_of(entry) {
                    let Some(side) = &given.side[face as usize] else { continue };
                    match (side.directions.len(), along) {
                        (3, _) => {}
                        (1, None) => along = Some(side.directions[0]),
                        (1, Some(other)) if norm(sub(other, side.directions[0])) < 1e-12 => {}
                        _ => return None,
                    }
                }
            }
            Some(along)
        };
        let kept: Vec<([u32; 2], Option<V3>)> =
            ranges.into_par_iter().with_min_len(BLOCKS_PER_TASK).filter_map(|fan| Some((fan, free(&fan)?))).collect();
        let block = |(fan, along): ([u32; 2], Option<V3>)| {
            let mut own = [[0.0; 6]; 6];
            for &entry in &self.fans[fan[0] as usize..fan[1] as usize] {
                self.add_edge_block(entry, &mut own);
            }
            if let Some(d) = along {
                let mean = (0..6).map(|k| own[k][k]).sum::<f64>() / 6.0;
                own = projected(&own, d, mean);
            }
            EdgeBlock { fan, along, inverse: inverse(own).map(|row| row.map(|v| v as f32)) }
        };
        kept.into_par_iter().with_min_len(BLOCKS_PER_TASK).map(block).collect()
    }

    fn local(&self, cell: u32, face: u32) -> usize {
        self.tets.faces_of[cell as usize].iter().position(|&f| f == face).unwrap_or(0)
    }

    /// The two faces of a cell at one of its edges: local number, number, and the sign of a moment that goes round the edge,
    /// out of the cell.
    fn sides_of(&self, entry: u64) -> [(usize, u32, f64); 2] {
        let (cell, edge) = ((entry / 8) as usize, (entry % 8) as usize);
        let ([m, n], even) = OTHERS[edge];
        let turn = if self.positive[cell] { even } else { -even };
        let faces = self.tets.faces_of[cell];
        [(m, faces[m], turn), (n, faces[n], -turn)]
    }

    /// Where the two ends of an edge are among the corners of face `j`.
    fn ends(edge: usize, j: usize) -> [usize; 2] {
        EDGES[edge].map(|corner| corner - usize::from(corner > j))
    }

    /// Forces along the three edges of a face.
    fn face_modes(&self, face: u32) -> [[f64; 9]; 3] {
        let x = self.tets.faces[face as usize].map(|node| self.tets.mesh().nodes[node as usize]);
        [[0, 1], [0, 2], [1, 2]].map(|[a, b]| {
            let along = sub(x[b], x[a]);
            let along = scale(1.0 / norm(along), along);
            let mut mode = [0.0; 9];
            (0..3).for_each(|c| (mode[3 * a + c], mode[3 * b + c]) = (along[c], -along[c]));
            mode
        })
    }

    /// Changes out of a cell.
    #[inline(always)]
    fn out_of(&self, cell: usize, change: &[[f64; 9]]) -> [[f32; 9]; 4] {
        let faces = self.tets.faces_of[cell];
        faces.map(|face| {
            let sign = self.tets.sign(cell, face);
            change[face as usize].map(|v| (sign * v) as f32)
        })
    }

    /// Adds what the faces of all cells get from `of`, which gives the tractions out of a cell.
    fn gather(&self, of: impl Fn(usize) -> [[f32; 9]; 4] + Sync) -> Vec<[f64; 9]> {
        let cells = self.tets.corners.len();
        let mut images = vec![[[0.0; 9]; 4]; cells];
        images.par_chunks_mut(CELLS_PER_TASK).enumerate().for_each(|(task, chunk)| {
            vectorised(
                #[inline(always)]
                || {
                    for (cell, image) in (CELLS_PER_TASK * task..).zip(chunk.iter_mut()) {
                        *image = times(&self.matrices[cell], &of(cell));
                    }
                },
            );
        });
        let of_face = |face: usize| {
            let mut sum = [0.0; 9];
            for &cell in self.tets.cells_of[face].iter().filter(|&&cell| cell != NONE) {
                let sign = self.tets.sign(cell as usize, face as u32);
                let image = &images[cell as usize][self.local(cell, face as u32)];
                (0..9).for_each(|k| sum[k] += sign * f64::from(image[k]));
            }
            sum
        };
        (0..self.tets.faces.len()).into_par_iter().with_min_len(CELLS_PER_TASK).map(of_face).collect()
    }

    fn times(&self, change: &[[f64; 9]]) -> Vec<[f64; 9]> {
        self.gather(
            #[inline(always)]
            |cell| self.out_of(cell, change),
        )
    }

    /// Each block of unknowns for itself.
    fn precondition(&self, residual: &[[f64; 9]]) -> Vec<[f64; 9]> {
        let mut change = vec![[0.0; 9]; residual.len()];
        let of_face = |block: &FaceBlock| -> [f64; 9] {
            let (modes, rest) = (&block.modes, &residual[block.face as usize]);
            let asked: [f64; 3] = std::array::from_fn(|a| (0..9).map(|k| modes[a][k] * rest[k]).sum());
            let factors = multiplied(&block.inverse, &asked);
            std::array::from_fn(|k| (0..3).map(|a| factors[a] * modes[a][k]).sum())
        };
        let of_faces: Vec<[f64; 9]> = self.faces.par_iter().with_min_len(BLOCKS_PER_TASK).map(of_face).collect();
        self.faces.iter().zip(of_faces).for_each(|(block, more)| change[block.face as usize] = more);
        let of_edge = |block: &EdgeBlock| {
            let mut asked = [0.0; 6];
            self.around(block, |edge, j, face, turn| {
                let rest = &residual[face];
                let ends = Self::ends(edge, j);
                for c in 0..3 {
                    let total = rest[c] + rest[3 + c] + rest[6 + c];
                    (0..2).for_each(|e| asked[3 * e + c] += turn * (12.0 * rest[3 * ends[e] + c] - 3.0 * total));
                }
            });
            if let Some(d) = block.along {
                asked = onto(asked, d);
            }
            let moments = multiplied(&block.inverse.map(|row| row.map(f64::from)), &asked);
            block.along.map_or(moments, |d| onto(moments, d))
        };
        let moments: Vec<[f64; 6]> = self.edges.par_iter().with_min_len(BLOCKS_PER_TASK).map(of_edge).collect();
        for (block, moments) in self.edges.iter().zip(moments) {
            self.around(block, |edge, j, face, turn| {
                let ends = Self::ends(edge, j);
                for c in 0..3 {
                    let [first, second] = [moments[c], moments[3 + c]].map(|moment| turn * moment);
                    let own = &mut change[face];
                    (0..3).for_each(|a| own[3 * a + c] -= 3.0 * (first + second));
                    own[3 * ends[0] + c] += 12.0 * first;
                    own[3 * ends[1] + c] += 12.0 * second;
                }
            });
        }
        change
    }

    /// Takes the faces around an edge, each once and from its first cell: local numbers of edge and face there, number of the
    /// face, sign of a moment that goes round the edge.
    fn around(&self, block: &EdgeBlock, mut take: impl FnMut(usize, usize, usize, f64)) {
        for &entry in &self.fans[block.fan[0] as usize..block.fan[1] as usize] {
            for (j, face, turn) in self.sides_of(entry) {
                if u64::from(self.tets.cells_of[face as usize][0]) == entry / 8 {
                    take((entry % 8) as usize, j, face as usize, turn);
                }
            }
        }
    }

    /// Adds the part of a cell to the matrix of moments around one of its edges.
    fn add_edge_block(&self, entry: u64, own: &mut [[f64; 6]; 6]) {
        let (cell, edge) = ((entry / 8) as usize, (entry % 8) as usize);
        let matrix = &self.matrices[cell];
        let sides = self.sides_of(entry);
        let [(first, _, one), (second, _, two)] = sides;
        for (p, q, sign) in [(first, first, 1.0), (second, second, 1.0), (first, second, one * two)] {
            let block = &matrix[number(p, q)];
            let (rows, columns) = (Self::ends(edge, p).map(weights), Self::ends(edge, q).map(weights));
            for e in 0..2 {
                // Columns first.
                let mut half = [[0.0; 3]; 9];
                for (row, half) in block.iter().zip(&mut half) {
                    for (b, weight) in columns[e].into_iter().enumerate() {
                        (0..3).for_each(|c| half[c] += weight * f64::from(row[3 * b + c]));
                    }
                }
                for (d, rows) in rows.iter().enumerate() {
                    for (a, weight) in rows.iter().enumerate() {
                        for r in 0..3 {
                            for c in 0..3 {
                                let value = sign * weight * half[3 * a + r][c];
                                own[3 * d + r][3 * e + c] += value;
                                if p != q {
                                    own[3 * e + c][3 * d + r] += value;
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Place of the block of two faces `j <= k`.
const fn number(j: usize, k: usize) -> usize {
    4 * j - j * (j + 1) / 2 + k
}

const fn diagonal(j: usize) -> usize {
    number(j, j)
}

fn form(block: &Block, a: &[f64; 9], b: &[f64; 9]) -> f64 {
    block.iter().zip(a).map(|(row, a)| a * row.iter().zip(b).map(|(m, b)| f64::from(*m) * b).sum::<f64>()).sum()
}

#[inline(always)]
fn times(matrix: &Matrix, tractions: &[[f32; 9]; 4]) -> [[f32; 9]; 4] {
    let mut image = [[0.0; 9]; 4];
    for (block, [j, k]) in matrix.iter().zip(BLOCKS) {
        add_times(block, &tractions[k], &mut image[j]);
        if j != k {
            add_transposed(block, &tractions[j], &mut image[k]);
        }
    }
    image
}

#[inline(always)]
fn add_times(block: &Block, x: &[f32; 9], y: &mut [f32; 9]) {
    for (row, y) in block.iter().zip(y) {
        // Four sums at a time, in an order that vector units can keep.
        let lanes: [f32; 4] = std::array::from_fn(|k| row[k] * x[k] + row[4 + k] * x[4 + k]);
        *y += (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + row[8] * x[8];
    }
}

#[inline(always)]
fn add_transposed(block: &Block, x: &[f32; 9], y: &mut [f32; 9]) {
    for (row, x) in block.iter().zip(x) {
        for (m, y) in row.iter().zip(&mut *y) {
            *y += m * x;
        }
    }
}

fn multiplied<const N: usize>(a: &[[f64; N]; N], x: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|i| (0..N).map(|j| a[i][j] * x[j]).sum())
}

/// The parts of two vectors along a direction.
fn onto(v: [f64; 6], d: V3) -> [f64; 6] {
    let along = [0, 3].map(|k| dot([v[k], v[k + 1], v[k + 2]], d));
    std::array::from_fn(|k| along[k / 3] * d[k % 3])
}

/// A matrix of moments restricted to those along a direction, with `rest` for the others.
fn projected(own: &[[f64; 6]; 6], d: V3, rest: f64) -> [[f64; 6]; 6] {
    let left: [[f64; 6]; 6] = std::array::from_fn(|i| onto(own[i], d));
    let both: [[f64; 6]; 6] = std::array::from_fn(|j| onto(std::array::from_fn(|i| left[i][j]), d));
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let same = i / 3 == j / 3;
            let across = f64::from(u8::from(i == j)) - if same { d[i % 3] * d[j % 3] } else { 0.0 };
            both[j][i] + rest * across
        })
    })
}

/// The inverse of a symmetric matrix that is definite but for rounding, symmetric itself.
fn inverse<const N: usize>(mut a: [[f64; N]; N]) -> [[f64; N]; N] {
    let largest = (0..N).map(|i| a[i][i]).fold(f64::MIN_POSITIVE, f64::max);
    (0..N).for_each(|i| a[i][i] += ROUNDING * largest);
    // The inverse of the Cholesky factor, then its square.
    let mut factor = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            let rest = a[i][j] - (0..j).map(|k| factor[i][k] * factor[j][k]).sum::<f64>();
            factor[i][j] = if i == j { rest.max(ROUNDING * largest).sqrt() } else { rest / factor[j][j] };
        }
    }
    let mut lower = [[0.0; N]; N];
    for j in 0..N {
        for i in j..N {
            let unit = f64::from(u8::from(i == j));
            let sum: f64 = (j..i).map(|k| factor[i][k] * lower[k][j]).sum();
            lower[i][j] = (unit - sum) / factor[i][i];
        }
    }
    std::array::from_fn(|i| std::array::from_fn(|j| (i.max(j)..N).map(|k| lower[k][i] * lower[k][j]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverses_of_definite_matrices_are_theirs() {
        let a = [[4.0, 1.0, -0.5], [1.0, 3.0, 0.2], [-0.5, 0.2, 5.0]];
        let b = inverse(a);
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| a[i][k] * b[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-5, "{i} {j}: {product}");
                assert_eq!(b[i][j], b[j][i]);
            }
        }
    }
}
