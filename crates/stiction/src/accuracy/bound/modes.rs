//! Changes of tractions that leave every cell balanced: all there are, with the matrix of their energies and its blocks.
//!
//! On a face forces along its edges, equal and opposite at both ends; around an edge two forces at its ends and a couple about it, which
//! each cell passes on to the next. Faces around an edge pass on a force and a couple, and forces at the ends are no couple about the edge
//! itself.

use std::collections::{HashMap, HashSet};

use rayon::prelude::*;

use super::contact::Bearing;
use super::equilibrate::Given;
use super::fill::{BLOCKS, Block, Matrix};
use super::tets::{CELLS_PER_TASK, EDGES, NONE, Tets, without};
use crate::linalg::vectorised;
use crate::mesh::v3::{V3, cross, dot, norm, scale, sub};

/// Blocks of unknowns for each task of a thread at least.
const BLOCKS_PER_TASK: usize = 128;
/// What is added to the diagonal of a block, as part of it: its own rounding in single precision.
const ROUNDING: f64 = 1e-6;
/// Directions that differ by less are the same.
const SAME: f64 = 1e-12;

/// A face whose tractions may change, with the inverse of its block.
struct FaceBlock {
    face: u32,
    modes: [[f64; 9]; 3],
    inverse: [[f64; 3]; 3],
}

/// An edge around which forces and a couple may be passed on.
struct EdgeBlock {
    /// Where its faces are in [`System::passages`].
    passages: [u32; 2],
    free: Passed,
    inverse: [[f32; EDGE]; EDGE],
}

/// A face at an edge.
struct Passage {
    face: u32,
    /// Which of its corners are the ends of the edge.
    ends: [u8; 2],
    /// The sign of what goes round the edge, out of the first cell of the face.
    turn: f64,
    couple: Couple,
}

/// Tractions times area that are a couple about an edge of the face, times the length of the edge: forces along the normal.
#[derive(Clone, Copy)]
struct Couple {
    /// At the corner across.
    force: V3,
    /// What the second end takes of it; the first takes the rest.
    part: f64,
}

impl Couple {
    fn of_corners(&self, [a, b]: [usize; 2]) -> [f64; 9] {
        let mut all = [0.0; 9];
        for (corner, weight) in [(a, self.part - 1.0), (b, -self.part), (3 - a - b, 1.0)] {
            (0..3).for_each(|k| all[3 * corner + k] = weight * self.force[k]);
        }
        all
    }
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

/// The energies of changes of tractions, and the blocks of faces and edges that the changes are made of.
pub(super) struct System<'a> {
    tets: &'a Tets<'a>,
    matrices: Vec<Matrix>,
    faces: Vec<FaceBlock>,
    edges: Vec<EdgeBlock>,
    /// Cells around edges with the local number of the edge: `8 cell + edge`.
    fans: Vec<u64>,
    /// The faces around each of `edges`.
    passages: Vec<Passage>,
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
    pub(super) fn new(tets: &'a Tets<'a>, given: &Given, bearings: &[Bearing], matrices: Vec<Matrix>) -> Self {
        let bearing: HashMap<u32, &[V3]> = bearings.iter().map(|at| (at.face, &*at.directions)).collect();
        // Directions in which tractions are free; all on interior faces.
        let free = |face: u32| -> Option<&[V3]> {
            let side = given.side[face as usize].as_ref()?;
            Some(bearing.get(&face).copied().unwrap_or(&side.directions))
        };
        let cells = tets.corners.len();
        let positive = (0..cells).into_par_iter().with_min_len(1024).map(|cell| tets.shape(cell).positive).collect();
        let (faces, edges, fans, passages) = Default::default();
        let mut system = System { tets, matrices, faces, edges, fans, passages, positive };
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
        system.add_edges(&free, ranges);
        system
    }

    /// Leaves out the blocks at some faces.
    pub(super) fn leave_out(&mut self, without: &HashSet<u32>) {
        self.faces.retain(|block| !without.contains(&block.face));
        let passages = &self.passages;
        let at = |block: &EdgeBlock| passages_of(passages, block).iter().any(|passage| without.contains(&passage.face));
        self.edges.retain(|block| !at(block));
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

    /// The blocks of the edges that cells around them have in these ranges of `fans`.
    fn add_edges<'f>(&mut self, free: &(dyn Fn(u32) -> Option<&'f [V3]> + Sync), ranges: Vec<[u32; 2]>) {
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
        let inverse_of = |(fan, free): &([u32; 2], Passed)| {
            let mut own = [[0.0; EDGE]; EDGE];
            for &entry in &self.fans[fan[0] as usize..fan[1] as usize] {
                self.add_edge_block(entry, &mut own);
            }
            if free.along.is_some() || !free.couple {
                let mean = (0..EDGE).map(|k| own[k][k]).sum::<f64>() / EDGE as f64;
                own = restricted(&own, free, mean);
            }
            inverse(own).map(|row| row.map(|v| v as f32))
        };
        let inverses: Vec<_> = kept.par_iter().with_min_len(BLOCKS_PER_TASK).map(inverse_of).collect();
        let around = |(fan, _): &([u32; 2], Passed)| self.around(*fan);
        let around: Vec<Vec<Passage>> = kept.par_iter().with_min_len(BLOCKS_PER_TASK).map(around).collect();
        let mut first = 0;
        for ((passages, (_, free)), inverse) in around.iter().zip(kept).zip(inverses) {
            let begin = first;
            first += passages.len() as u32;
            self.edges.push(EdgeBlock { passages: [begin, first], free, inverse });
        }
        self.passages = around.into_iter().flatten().collect();
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

    /// The couple about an edge of a cell on its face `j`.
    fn couple(&self, cell: u32, edge: usize, j: usize) -> Couple {
        let corners = without(&self.tets.corners[cell as usize], j);
        let [a, b] = Self::ends(edge, j);
        let x = corners.map(|node| self.tets.mesh().nodes[node as usize]);
        let (along, out) = (sub(x[b], x[a]), sub(x[3 - a - b], x[a]));
        let part = dot(out, along) / dot(along, along);
        // From the edge to the corner across.
        let height = sub(out, scale(part, along));
        Couple { force: scale(12.0 / dot(height, height), cross(along, height)), part }
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
    pub(super) fn gather(&self, of: impl Fn(usize) -> [[f32; 9]; 4] + Sync) -> Vec<[f64; 9]> {
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

    pub(super) fn times(&self, change: &[[f64; 9]]) -> Vec<[f64; 9]> {
        self.gather(
            #[inline(always)]
            |cell| self.out_of(cell, change),
        )
    }

    /// Each block of unknowns for itself.
    pub(super) fn precondition(&self, residual: &[[f64; 9]]) -> Vec<[f64; 9]> {
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
            for passage in passages_of(&self.passages, block) {
                let (rest, turn) = (&residual[passage.face as usize], passage.turn);
                let [a, b] = passage.ends.map(usize::from);
                let across = 3 - a - b;
                let Couple { force, part } = passage.couple;
                for c in 0..3 {
                    let [of_a, of_b, of_across] = [a, b, across].map(|corner| rest[3 * corner + c]);
                    let total = of_a + of_b + of_across;
                    asked[c] += turn * (12.0 * of_a - 3.0 * total);
                    asked[3 + c] += turn * (12.0 * of_b - 3.0 * total);
                    asked[6] += turn * force[c] * (of_across - (1.0 - part) * of_a - part * of_b);
                }
            }
            let moments = multiplied(&block.inverse.map(|row| row.map(f64::from)), &block.free.part(asked));
            block.free.part(moments)
        };
        let moments: Vec<[f64; EDGE]> = self.edges.par_iter().with_min_len(BLOCKS_PER_TASK).map(of_edge).collect();
        for (block, moments) in self.edges.iter().zip(moments) {
            for passage in passages_of(&self.passages, block) {
                let (own, turn) = (&mut change[passage.face as usize], passage.turn);
                let [a, b] = passage.ends.map(usize::from);
                let across = 3 - a - b;
                let Couple { force, part } = passage.couple;
                for c in 0..3 {
                    let [first, second, couple] = [moments[c], moments[3 + c], force[c] * moments[6]].map(|m| turn * m);
                    let both = 3.0 * (first + second);
                    own[3 * a + c] += 12.0 * first - both - (1.0 - part) * couple;
                    own[3 * b + c] += 12.0 * second - both - part * couple;
                    own[3 * across + c] += couple - both;
                }
            }
        }
        change
    }

    /// The faces around the edge of a fan, each once and as its first cell has it.
    fn around(&self, fan: [u32; 2]) -> Vec<Passage> {
        let of_cell = |&entry: &u64| {
            let (cell, edge) = ((entry / 8) as u32, (entry % 8) as usize);
            let own = self.sides_of(entry).into_iter();
            let own = own.filter(move |(_, face, _)| self.tets.cells_of[*face as usize][0] == cell);
            own.map(move |(j, face, turn)| Passage {
                face,
                ends: Self::ends(edge, j).map(|corner| corner as u8),
                turn,
                couple: self.couple(cell, edge, j),
            })
        };
        self.fans[fan[0] as usize..fan[1] as usize].iter().flat_map(of_cell).collect()
    }

    /// Adds the part of a cell to the matrix of what goes round one of its edges.
    fn add_edge_block(&self, entry: u64, own: &mut [[f64; EDGE]; EDGE]) {
        let (cell, edge) = ((entry / 8) as usize, (entry % 8) as usize);
        let matrix = &self.matrices[cell];
        let sides = self.sides_of(entry);
        let [(first, _, one), (second, _, two)] = sides;
        let couples = sides.map(|(j, ..)| self.couple(cell as u32, edge, j).of_corners(Self::ends(edge, j)));
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

fn passages_of<'p>(all: &'p [Passage], block: &EdgeBlock) -> &'p [Passage] {
    &all[block.passages[0] as usize..block.passages[1] as usize]
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
mod tests;
