//! Less energy from the same equilibrium.
//!
//! Changes of the tractions that leave every cell balanced: on a face forces along its edges, equal and opposite at both ends;
//! around an edge two forces at its ends and a couple about it, which each cell passes on to the next. Together they are all
//! there are: faces around an edge pass on a force and a couple, and forces at the ends are no couple about the edge itself.
//! The energy of `τ - σ` is minimised over them by conjugate
//! gradients, preconditioned by the blocks of faces and edges. Any number of steps gives a valid bound, so that
//! matrices are in single precision; the tractions stay balanced to double precision.
//!
//! On closed faces the contact tractions change with the others, as far as the law of contact lets them ([`Bearing`]).

use std::collections::{HashMap, HashSet};

use rayon::prelude::*;

use super::contact::Bearing;
use super::equilibrate::{Given, OnFace};
use super::fill::{BLOCKS, Block, Map, Matrix, Sides};
use super::tets::{CELLS_PER_TASK, EDGES, NONE, Shape, Tets, without};
use crate::fem::Voigt;
use crate::linalg::vectorised;
use crate::mesh::v3::{V3, cross, dot, norm, scale, sub};

/// Blocks of unknowns for each task of a thread at least.
const BLOCKS_PER_TASK: usize = 128;
/// What is added to the diagonal of a block, as part of it: its own rounding in single precision.
const ROUNDING: f64 = 1e-6;
/// Directions that differ by less are the same.
const SAME: f64 = 1e-12;
/// Part of the first residual at which steps end.
const SMALL: f64 = 1e-9;
/// Steps end where one gains less than this part of the energy: what is left to gain is some ten times as much, and half of that in
/// the bound. On refined bricks 18 to 24 steps.
const GAIN: f64 = 1e-3;

/// Reduces `energy`, the squared distance of the stress of the tractions, by at most so many steps; `apart` answers the
/// difference of a cell's tractions from those of the stress. On `bearings` tractions stay within the law.
#[allow(clippy::too_many_arguments)] // Two fields, their cells, and what may change.
pub(super) fn sharpen(
    tets: &Tets,
    given: &Given,
    mut bearings: Vec<Bearing>,
    shapes: &[Shape],
    compliances: &[[Voigt; 6]],
    apart: &(dyn Fn(usize, &[OnFace]) -> Sides + Sync),
    tractions: &mut [OnFace],
    mut energy: f64,
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
    let mut system = System::new(tets, given, &bearings, matrices);
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
    let (mut before, mut first) = (None, 0.0);
    for _ in 0..steps {
        let corrected = system.precondition(&residual);
        let product = inner(&corrected, &residual);
        if let Some(before) = before {
            let factor: f64 = product / before;
            direction.par_iter_mut().zip(&corrected).for_each(|(d, z)| {
                (0..9).for_each(|k| d[k] = z[k] + factor * d[k]);
            });
        } else {
            direction = corrected;
        }
        first = f64::max(first, product);
        if product.is_nan() || product <= SMALL * SMALL * first {
            break;
        }
        let image = system.times(&direction);
        let curvature = inner(&direction, &image);
        if curvature.is_nan() || curvature <= 0.0 {
            break;
        }
        let whole = product / curvature;
        let reach = |bearing: &Bearing| {
            let face = bearing.face as usize;
            bearing.reach(&tractions[face], &direction[face].map(|d| scale_of * d))
        };
        let length = bearings.iter().map(reach).fold(whole, f64::min);
        let stays: Vec<bool> = bearings.iter().map(|bearing| reach(bearing) >= whole).collect();
        residual.par_iter_mut().zip(&image).for_each(|(r, y)| (0..9).for_each(|k| r[k] -= length * y[k]));
        tractions.par_iter_mut().zip(&direction).for_each(|(t, d)| {
            (0..9).for_each(|k| t[k / 3][k % 3] += length * scale_of * d[k]);
        });
        if length < whole {
            // What is at its limit stays there, and the method begins anew.
            let ended = bearings.iter().zip(&stays).filter(|(_, stays)| !**stays).map(|(bearing, _)| bearing.face);
            system.keep(&ended.collect());
            let mut stays = stays.into_iter();
            bearings.retain(|_| stays.next() == Some(true));
            before = None;
        } else {
            before = Some(product);
            let gain = size * scale_of * scale_of * whole * product;
            energy -= gain;
            if gain < GAIN * energy {
                break;
            }
        }
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

/// An edge around which forces and a couple may be passed on.
struct EdgeBlock {
    /// Where its cells are in [`System::fans`].
    fan: [u32; 2],
    free: Passed,
    inverse: [[f32; EDGE]; EDGE],
}

/// Unknowns of an edge: forces at both ends and the couple about it.
const EDGE: usize = 7;

/// What the faces at an edge let pass.
#[derive(Clone, Copy)]
struct Passed {
    /// The direction of the forces; none if all are free, zero if none is.
    along: Option<V3>,
    /// The couple, whose tractions are normal to each face.
    couple: bool,
}

impl Passed {
    /// The part of unknowns that may be passed on.
    fn part(&self, v: [f64; EDGE]) -> [f64; EDGE] {
        let [a, b] = [0, 3].map(|k| {
            let force = [v[k], v[k + 1], v[k + 2]];
            self.along.map_or(force, |d| scale(dot(force, d), d))
        });
        [a[0], a[1], a[2], b[0], b[1], b[2], if self.couple { v[6] } else { 0.0 }]
    }
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
    fn new(tets: &'a Tets<'a>, given: &Given, bearings: &[Bearing], matrices: Vec<Matrix>) -> Self {
        let bearing: HashMap<u32, &[V3]> = bearings.iter().map(|at| (at.face, &*at.directions)).collect();
        // Directions in which tractions are free; all on interior faces.
        let free = |face: u32| -> Option<&[V3]> {
            let side = given.side[face as usize].as_ref()?;
            Some(bearing.get(&face).copied().unwrap_or(&side.directions))
        };
        let cells = tets.corners.len();
        let positive = (0..cells).into_par_iter().with_min_len(1024).map(|cell| tets.shape(cell).positive).collect();
        let mut system = System { tets, matrices, faces: Vec::new(), edges: Vec::new(), fans: Vec::new(), positive };
        system.faces = system.face_blocks(&free);
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
        system.edges = system.edge_blocks(&free, ranges);
        system
    }

    /// Leaves out the blocks at some faces.
    fn keep(&mut self, without: &HashSet<u32>) {
        self.faces.retain(|block| !without.contains(&block.face));
        let mut edges = std::mem::take(&mut self.edges);
        let at = |block: &EdgeBlock| {
            let fan = &self.fans[block.fan[0] as usize..block.fan[1] as usize];
            fan.iter().any(|&entry| self.sides_of(entry).iter().any(|side| without.contains(&side.1)))
        };
        edges.retain(|block| !at(block));
        self.edges = edges;
    }

    fn face_blocks<'f>(&self, free: &(dyn Fn(u32) -> Option<&'f [V3]> + Sync)) -> Vec<FaceBlock> {
        let all = |face: &u32| free(*face).is_none_or(|directions| directions.len() == 3);
        let list: Vec<u32> = (0..self.tets.faces.len() as u32).filter(all).collect();
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

    fn edge_blocks<'f>(
        &self,
        free: &(dyn Fn(u32) -> Option<&'f [V3]> + Sync),
        ranges: Vec<[u32; 2]>,
    ) -> Vec<EdgeBlock> {
        // Of an edge on the boundary the two faces there; directions that are free on both.
        let passed = |fan: &[u32; 2]| -> Option<Passed> {
            let mut passed = Passed { along: None, couple: true };
            for &entry in &self.fans[fan[0] as usize..fan[1] as usize] {
                for (_, face, _) in self.sides_of(entry) {
                    let Some(directions) = free(face) else { continue };
                    let d = match directions.len() {
                        3 => continue,
                        1 => directions[0],
                        _ => return None,
                    };
                    let area = self.tets.vector_area(face);
                    passed.couple &= dot(area, d).abs() > (1.0 - SAME) * norm(area);
                    passed.along = match passed.along {
                        None => Some(d),
                        Some(other) if norm(sub(other, d)) < SAME => Some(other),
                        Some(_) => Some([0.0; 3]),
                    };
                }
            }
            let any = passed.couple || passed.along.is_none_or(|d| norm(d) > 0.0);
            any.then_some(passed)
        };
        let kept: Vec<([u32; 2], Passed)> =
            ranges.into_par_iter().with_min_len(BLOCKS_PER_TASK).filter_map(|fan| Some((fan, passed(&fan)?))).collect();
        let block = |(fan, free): ([u32; 2], Passed)| {
            let mut own = [[0.0; EDGE]; EDGE];
            for &entry in &self.fans[fan[0] as usize..fan[1] as usize] {
                self.add_edge_block(entry, &mut own);
            }
            if free.along.is_some() || !free.couple {
                let mean = (0..EDGE).map(|k| own[k][k]).sum::<f64>() / EDGE as f64;
                own = restricted(&own, &free, mean);
            }
            EdgeBlock { fan, free, inverse: inverse(own).map(|row| row.map(|v| v as f32)) }
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

    /// Tractions times area at the corners of face `j` of a cell that are a couple about an edge of both: forces on the
    /// normal, equal and opposite on the edge and at the corner across, times the length of the edge.
    fn couple(&self, cell: u32, edge: usize, j: usize) -> [f64; 9] {
        let corners = without(&self.tets.corners[cell as usize], j);
        let [a, b] = Self::ends(edge, j);
        let c = 3 - a - b;
        let x = corners.map(|node| self.tets.mesh().nodes[node as usize]);
        let (along, out) = (sub(x[b], x[a]), sub(x[c], x[a]));
        let part = dot(out, along) / dot(along, along);
        // From the edge to the corner across.
        let height = sub(out, scale(part, along));
        let force = scale(12.0 / dot(height, height), cross(along, height));
        let mut couple = [0.0; 9];
        for (corner, weight) in [(a, part - 1.0), (b, -part), (c, 1.0)] {
            (0..3).for_each(|k| couple[3 * corner + k] = weight * force[k]);
        }
        couple
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
            let mut asked = [0.0; EDGE];
            self.around(block, |cell, edge, j, face, turn| {
                let rest = &residual[face];
                let ends = Self::ends(edge, j);
                for c in 0..3 {
                    let total = rest[c] + rest[3 + c] + rest[6 + c];
                    (0..2).for_each(|e| asked[3 * e + c] += turn * (12.0 * rest[3 * ends[e] + c] - 3.0 * total));
                }
                let couple = self.couple(cell, edge, j);
                asked[6] += turn * couple.iter().zip(rest).map(|(c, r)| c * r).sum::<f64>();
            });
            let moments = multiplied(&block.inverse.map(|row| row.map(f64::from)), &block.free.part(asked));
            block.free.part(moments)
        };
        let moments: Vec<[f64; EDGE]> = self.edges.par_iter().with_min_len(BLOCKS_PER_TASK).map(of_edge).collect();
        for (block, moments) in self.edges.iter().zip(moments) {
            self.around(block, |cell, edge, j, face, turn| {
                let ends = Self::ends(edge, j);
                let own = &mut change[face];
                for c in 0..3 {
                    let [first, second] = [moments[c], moments[3 + c]].map(|moment| turn * moment);
                    (0..3).for_each(|a| own[3 * a + c] -= 3.0 * (first + second));
                    own[3 * ends[0] + c] += 12.0 * first;
                    own[3 * ends[1] + c] += 12.0 * second;
                }
                let couple = self.couple(cell, edge, j);
                own.iter_mut().zip(couple).for_each(|(own, c)| *own += turn * moments[6] * c);
            });
        }
        change
    }

    /// Takes the faces around an edge, each once and from its first cell: that cell, local numbers of edge and face there,
    /// number of the face, sign of what goes round the edge.
    fn around(&self, block: &EdgeBlock, mut take: impl FnMut(u32, usize, usize, usize, f64)) {
        for &entry in &self.fans[block.fan[0] as usize..block.fan[1] as usize] {
            for (j, face, turn) in self.sides_of(entry) {
                let cell = self.tets.cells_of[face as usize][0];
                if u64::from(cell) == entry / 8 {
                    take(cell, (entry % 8) as usize, j, face as usize, turn);
                }
            }
        }
    }

    /// Adds the part of a cell to the matrix of what goes round one of its edges.
    fn add_edge_block(&self, entry: u64, own: &mut [[f64; EDGE]; EDGE]) {
        let (cell, edge) = ((entry / 8) as usize, (entry % 8) as usize);
        let matrix = &self.matrices[cell];
        let sides = self.sides_of(entry);
        let [(first, _, one), (second, _, two)] = sides;
        let couples = sides.map(|(j, ..)| self.couple(cell as u32, edge, j));
        for (p, q, sign) in [(0, 0, 1.0), (1, 1, 1.0), (0, 1, one * two)] {
            let faces = [first, second];
            let block = &matrix[number(faces[p], faces[q])];
            let [rows, columns] = [p, q].map(|at| Self::ends(edge, faces[at]).map(weights));
            // Of both faces, where they are not the same, each with the other.
            let mut add = |i: usize, j: usize, value: f64| {
                own[i][j] += sign * value;
                if p != q {
                    own[j][i] += sign * value;
                }
            };
            // Columns first.
            for e in 0..2 {
                let mut half = [[0.0; 3]; 9];
                for (row, half) in block.iter().zip(&mut half) {
                    for (b, weight) in columns[e].into_iter().enumerate() {
                        (0..3).for_each(|c| half[c] += weight * f64::from(row[3 * b + c]));
                    }
                }
                for c in 0..3 {
                    for (d, rows) in rows.iter().enumerate() {
                        for r in 0..3 {
                            add(3 * d + r, 3 * e + c, (0..3).map(|a| rows[a] * half[3 * a + r][c]).sum());
                        }
                    }
                    add(6, 3 * e + c, (0..9).map(|k| couples[p][k] * half[k][c]).sum());
                }
            }
            let half: [f64; 9] =
                std::array::from_fn(|k| block[k].iter().zip(&couples[q]).map(|(m, v)| f64::from(*m) * v).sum());
            for (d, rows) in rows.iter().enumerate() {
                (0..3).for_each(|r| add(3 * d + r, 6, (0..3).map(|a| rows[a] * half[3 * a + r]).sum()));
            }
            add(6, 6, (0..9).map(|k| couples[p][k] * half[k]).sum());
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

/// A matrix of what edges pass on restricted to what may be, with `rest` for the others.
fn restricted(own: &[[f64; EDGE]; EDGE], free: &Passed, rest: f64) -> [[f64; EDGE]; EDGE] {
    let left: [[f64; EDGE]; EDGE] = std::array::from_fn(|i| free.part(own[i]));
    let both: [[f64; EDGE]; EDGE] = std::array::from_fn(|j| free.part(std::array::from_fn(|i| left[i][j])));
    std::array::from_fn(|i| {
        let unit = free.part(std::array::from_fn(|j| f64::from(u8::from(i == j))));
        std::array::from_fn(|j| both[j][i] + rest * (f64::from(u8::from(i == j)) - unit[j]))
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
    use super::super::Side;
    use super::super::fill::compliance;
    use super::*;
    use crate::fem::elements::Law;
    use crate::fem::{Material, Solid};
    use crate::mesh::v3::add;
    use crate::mesh::{Block, BlockElement, block};

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

    /// By elimination of columns.
    fn rank(mut rows: Vec<Vec<f64>>) -> usize {
        let largest = rows.iter().flatten().fold(0.0, |most: f64, v| most.max(v.abs()));
        let mut rank = 0;
        while let Some((row, column)) = (rank..rows.len())
            .filter_map(|r| {
                Some((r, (0..rows[r].len()).max_by(|&a, &b| rows[r][a].abs().total_cmp(&rows[r][b].abs()))?))
            })
            .max_by(|&(r, c), &(s, d)| rows[r][c].abs().total_cmp(&rows[s][d].abs()))
            .filter(|&(r, c)| rows[r][c].abs() > 1e-7 * largest)
        {
            rows.swap(rank, row);
            let (done, rest) = rows.split_at_mut(rank + 1);
            let pivot = &done[rank];
            rest.par_iter_mut().for_each(|row| {
                let factor = row[column] / pivot[column];
                row.iter_mut().zip(pivot).for_each(|(v, p)| *v -= factor * p);
                row[column] = 0.0;
            });
            rank += 1;
        }
        rank
    }

    /// Tractions that leave every cell balanced are all those of which force and moment vanish; the modes are as many.
    #[test]
    fn modes_are_all_tractions_that_leave_cells_balanced() {
        let element = BlockElement::Tet4Six;
        let mesh = block(&Block {
            size: [1.0, 1.3, 0.7],
            cells: [2, 2, 1],
            origin: [0.0; 3],
            grading: [1.4, 1.0, 1.0],
            element,
        })
        .unwrap();
        let materials = [Material { name: "steel".into(), young: 2.0, poisson: 0.3, ..Material::default() }];
        let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &vec![0; mesh.cell_count()] };
        let tets = Tets::new(&solid).unwrap();
        let of_material = compliance(&Law::new(&materials[0]));
        let axes: [V3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let nothing: &[(&str, &[V3])] = &[];
        let held: &[(&str, &[V3])] = &[("x-min", &axes)];
        let planes: &[(&str, &[V3])] = &[("x-min", &axes), ("y-max", &axes[1..2])];
        for sides in [nothing, held, planes] {
            let mut given = Given { side: (0..tets.faces.len()).map(|_| None).collect() };
            for face in (0..tets.faces.len()).filter(|&face| tets.cells_of[face][1] == NONE) {
                given.side[face] = Some(Side { directions: Vec::new(), forces: [[0.0; 3]; 3] });
            }
            for (name, directions) in sides {
                for &face in &mesh.group(name).unwrap().faces {
                    let side = &mut given.side[tets.of_boundary[face as usize] as usize];
                    side.as_mut().unwrap().directions = directions.to_vec();
                }
            }
            let mut matrices: Vec<Matrix> = vec![[[[0.0; 9]; 9]; 10]; tets.corners.len()];
            for (cell, matrix) in matrices.iter_mut().enumerate() {
                Map::new(&tets.shape(cell)).write_matrix(&of_material, 1.0, matrix);
            }
            let system = System::new(&tets, &given, &[], matrices);
            let faces = tets.faces.len();
            let modes: Vec<Vec<f64>> = (0..9 * faces)
                .map(|at| {
                    let mut residual = vec![[0.0; 9]; faces];
                    residual[at / 9][at % 9] = 1.0;
                    system.precondition(&residual).into_iter().flatten().collect()
                })
                .collect();
            // Of each free traction the forces and moments on the cells.
            let mut columns: Vec<Vec<f64>> = Vec::new();
            for face in 0..faces {
                let all = given.side[face].as_ref().map_or(axes.to_vec(), |side| side.directions.clone());
                let x = tets.faces[face].map(|node| mesh.nodes[node as usize]);
                for a in 0..3 {
                    let arm = x.into_iter().fold(x[a], add);
                    for &d in &all {
                        let mut column = vec![0.0; 6 * tets.corners.len()];
                        for &cell in tets.cells_of[face].iter().filter(|&&cell| cell != NONE) {
                            let sign = tets.sign(cell as usize, face as u32);
                            let moment = cross(scale(1.0 / 12.0, arm), d);
                            (0..3).for_each(|c| column[6 * cell as usize + c] = sign * d[c] / 3.0);
                            (0..3).for_each(|c| column[6 * cell as usize + 3 + c] = sign * moment[c]);
                        }
                        columns.push(column);
                    }
                }
            }
            let free = columns.len();
            let names: Vec<&str> = sides.iter().map(|side| side.0).collect();
            for mode in &modes {
                // No mode leaves a cell out of balance.
                let mut sums = vec![0.0; 6 * tets.corners.len()];
                let values = (0..faces).flat_map(|face| {
                    let all = given.side[face].as_ref().map_or(axes.to_vec(), |side| side.directions.clone());
                    (0..3).flat_map(move |a| all.clone().into_iter().map(move |d| (9 * face + 3 * a, d)))
                });
                for ((at, d), column) in values.zip(&columns) {
                    let value = dot(d, [mode[at], mode[at + 1], mode[at + 2]]);
                    sums.iter_mut().zip(column).for_each(|(sum, c)| *sum += value * c);
                }
                let size = mode.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
                assert!(sums.iter().all(|sum| sum.abs() <= 1e-12 * size), "{names:?}");
            }
            assert_eq!(rank(modes), free - rank(columns), "{names:?}");
        }
    }
}
