//! Tractions on all faces with which each cell is in equilibrium (Ladevèze and Leguillon 1983).
//!
//! Unknown are the moments `b_F^i = ∫_F t φ_i` of the traction on face `F` with the function of its corner `i`, nine for each
//! face. Every cell `T` around corner `i` asks for
//!
//! ```text
//! sum over its faces F at i   ± b_F^i  =  Q_T^i  =  ∫_T σ ∇φ_i - ∫_T f φ_i
//! ```
//! which has solutions since `σ` is in equilibrium for all `φ_i` times a constant; force
//! and moment of each cell balance then. Corner by corner the solution nearest to the mean of the stresses on both sides is
//! taken: with `b = b⁰ + V/A² (μ₁ - μ₂)` a graph Laplacian of the cells around the corner.

use rayon::prelude::*;

use super::tets::{CELLS_PER_TASK, NONE, Shape, Tets, traction, without};
use super::{NoBound, Side};
use crate::fem::Voigt;
use crate::linalg::max_abs;
use crate::mesh::Buckets;
use crate::mesh::v3::{V3, add, dot, norm, scale, sub};

/// Cells around one corner at most: the work grows with the third power.
const MOST_AROUND: usize = 600;

/// Of a corner whose cells have no free face the sum of what they ask for has to vanish; more than this part of the largest
/// force between cells is the reaction of a support at a point or along a line.
const REACTION: f64 = 1e-8;
/// The same of the largest force between cells anywhere: what is less is rounding, at corners where nothing acts.
const REACTION_ANYWHERE: f64 = 1e-13;

/// Pivots of the system of a corner below this part of its diagonal are zero.
const ZERO: f64 = 1e-13;

/// A traction times the area of its face at its corners, out of its first cell.
pub(super) type OnFace = [V3; 3];

/// What is known of all faces.
pub(super) struct Given {
    /// For each face: interior ones none.
    pub side: Vec<Option<Side>>,
}

/// Tractions times area that balance every cell; `stress`, at the corners of the cells, is in equilibrium for all functions that are linear in these.
pub(super) fn equilibrate(
    tets: &Tets,
    given: &Given,
    shapes: &[Shape],
    stress: &[[Voigt; 4]],
    body_force: &[V3],
) -> Result<Vec<OnFace>, NoBound> {
    let nodes = tets.mesh().nodes.len();
    let around = Buckets::new(nodes, tets.corners.len(), |range| {
        range.flat_map(|cell| tets.corners[cell].into_iter().map(move |node| [node, cell as u32]))
    });
    let first = first_guess(tets, given, stress);
    let largest =
        first.par_iter().map(|of| of.iter().fold(0.0, |most: f64, &b| most.max(norm(b)))).reduce(|| 0.0, f64::max);
    let of_corner = |node: usize| {
        let cells = around.at(node);
        if cells.is_empty() {
            return Ok(Vec::new());
        }
        Star::new(tets, given, shapes, node as u32, cells)?.solve(tets, stress, shapes, body_force, &first, largest)
    };
    let corrections: Vec<Vec<(u32, V3)>> =
        (0..nodes).into_par_iter().with_min_len(64).map(of_corner).collect::<Result<_, NoBound>>()?;
    // Of each face and corner the correction of the moment, which one star finds.
    let mut moments = first.clone();
    for (node, corrections) in corrections.iter().enumerate() {
        for &(face, correction) in corrections {
            let corner = place(tets, face, node as u32);
            moments[face as usize][corner] = add(moments[face as usize][corner], correction);
        }
    }
    moments.par_iter_mut().with_min_len(1024).for_each(|b| {
        let total = scale(3.0, add(add(b[0], b[1]), b[2]));
        *b = b.map(|b| sub(scale(12.0, b), total));
    });
    Ok(moments)
}

/// Which corner of a face a node is.
fn place(tets: &Tets, face: u32, node: u32) -> usize {
    tets.faces[face as usize].iter().position(|&corner| corner == node).unwrap_or(0)
}

/// Moments of the mean of the stresses on both sides of each face, and of what is given.
fn first_guess(tets: &Tets, given: &Given, stress: &[[Voigt; 4]]) -> Vec<OnFace> {
    let of_face = |face: usize| -> OnFace {
        let cells = tets.cells_of[face];
        let area = tets.vector_area(face as u32);
        let at = |cell: u32, node: u32| {
            let corner = tets.corners[cell as usize].iter().position(|&c| c == node).unwrap_or(0);
            traction(&stress[cell as usize][corner], area)
        };
        let nodes = tets.faces[face];
        let t: OnFace = match &given.side[face] {
            None => nodes.map(|node| scale(0.5, add(at(cells[0], node), at(cells[1], node)))),
            Some(side) => std::array::from_fn(|i| add(side.along(at(cells[0], nodes[i])), side.forces[i])),
        };
        let total = add(add(t[0], t[1]), t[2]);
        t.map(|t| scale(1.0 / 12.0, add(t, total)))
    };
    (0..tets.faces.len()).into_par_iter().with_min_len(CELLS_PER_TASK).map(of_face).collect()
}

/// The cells around a corner.
struct Star<'a> {
    node: u32,
    cells: &'a [u32],
    /// Faces at the corner whose moment is unknown, with their cells as places in `cells` and their weight.
    faces: Vec<(u32, [usize; 2], f64)>,
    /// Boundary faces among them, whose traction is unknown along some directions only.
    held: Vec<(usize, Side)>,
}

impl<'a> Star<'a> {
    fn new(tets: &Tets, given: &Given, shapes: &[Shape], node: u32, cells: &'a [u32]) -> Result<Self, NoBound> {
        if cells.len() > MOST_AROUND {
            return Err(NoBound::Degenerate);
        }
        let mut star = Star { node, cells, faces: Vec::new(), held: Vec::new() };
        for (own, &cell) in cells.iter().enumerate() {
            for &face in &tets.faces_of[cell as usize] {
                let [one, two] = tets.cells_of[face as usize];
                if one != cell || !tets.faces[face as usize].contains(&node) {
                    continue;
                }
                let area = tets.area(face);
                let volume = |cell: u32| if cell == NONE { 0.0 } else { shapes[cell as usize].volume };
                let weight = (volume(one) + volume(two)) / (area * area);
                // `V/A²` is the inverse of the weight of the square; a cell twice as thick lets twice as much through.
                let flow = 1.0 / weight;
                match &given.side[face as usize] {
                    None => {
                        let other = cells.binary_search(&two).map_err(|_| NoBound::Degenerate)?;
                        star.faces.push((face, [own, other], flow));
                    }
                    Some(side) if !side.directions.is_empty() => {
                        star.held.push((star.faces.len(), side.clone()));
                        star.faces.push((face, [own, usize::MAX], flow));
                    }
                    Some(_) => {}
                }
            }
        }
        Ok(star)
    }

    /// Corrections of the moments of its faces.
    fn solve(
        &self,
        tets: &Tets,
        stress: &[[Voigt; 4]],
        shapes: &[Shape],
        body_force: &[V3],
        first: &[OnFace],
        largest: f64,
    ) -> Result<Vec<(u32, V3)>, NoBound> {
        let (asked, size) = self.asked(tets, stress, shapes, body_force, first);
        let components = self.components();
        let count = components.iter().max().map_or(0, |last| last + 1);
        let mean = self.faces.iter().map(|face| face.2).sum::<f64>() / self.faces.len().max(1) as f64;
        // Directions in which no face of the component is held: their sum is determined by nothing, and has to vanish.
        let mut loose = Vec::with_capacity(count);
        for component in 0..count {
            let held = self.held.iter().filter(|(face, _)| components[self.faces[*face].1[0]] == component);
            let directions: Vec<V3> = held.flat_map(|(_, side)| side.directions.iter().copied()).collect();
            let free = complement(&directions);
            let own = |(_, c): &(&V3, &usize)| **c == component;
            let sum = asked.iter().zip(&components).filter(own).fold([0.0; 3], |sum, (&b, _)| add(sum, b));
            let off = max_abs(&free.iter().map(|&d| dot(d, sum)).collect::<Vec<f64>>());
            if off > (REACTION * size).max(REACTION_ANYWHERE * largest) {
                return Err(NoBound::Reaction { node: self.node, force: off });
            }
            loose.push(free);
        }
        if self.faces.is_empty() {
            // All is given around a single cell, and its sum has just been found to vanish.
            return Ok(Vec::new());
        }
        let m = self.cells.len();
        let multipliers: Vec<V3> = if self.held.is_empty() {
            // The three components apart.
            let mut matrix = vec![vec![0.0; m]; m];
            self.faces.iter().for_each(|(_, [a, b], flow)| {
                matrix[*a][*a] += flow;
                matrix[*b][*b] += flow;
                matrix[*a.max(b)][*a.min(b)] -= flow;
            });
            for a in 0..m {
                (0..=a).filter(|&b| components[a] == components[b]).for_each(|b| matrix[a][b] += mean);
            }
            factorise(&mut matrix)?;
            let by_component = [0, 1, 2].map(|c| solve(&matrix, asked.iter().map(|v| v[c]).collect()));
            (0..m).map(|i| [0, 1, 2].map(|c| by_component[c][i])).collect()
        } else {
            let mut matrix = vec![vec![0.0; 3 * m]; 3 * m];
            for (at, (_, [a, b], flow)) in self.faces.iter().enumerate() {
                if *b != usize::MAX {
                    for c in 0..3 {
                        matrix[3 * a + c][3 * a + c] += flow;
                        matrix[3 * b + c][3 * b + c] += flow;
                        matrix[3 * a.max(b) + c][3 * a.min(b) + c] -= flow;
                    }
                    continue;
                }
                let side = self.held.iter().find(|(face, _)| *face == at).map(|(_, side)| side);
                for d in side.into_iter().flat_map(|side| &side.directions) {
                    for i in 0..3 {
                        (0..3).for_each(|j| matrix[3 * a + i][3 * a + j] += flow * d[i] * d[j]);
                    }
                }
            }
            for a in 0..m {
                for b in (0..=a).filter(|&b| components[a] == components[b]) {
                    for d in &loose[components[a]] {
                        for i in 0..3 {
                            (0..3).for_each(|j| matrix[3 * a + i][3 * b + j] += mean * d[i] * d[j]);
                        }
                    }
                }
            }
            factorise(&mut matrix)?;
            let solution = solve(&matrix, asked.iter().flatten().copied().collect());
            solution.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect()
        };
        let correction = |(at, (face, [a, b], flow)): (usize, &(u32, [usize; 2], f64))| {
            if *b != usize::MAX {
                return (*face, scale(*flow, sub(multipliers[*a], multipliers[*b])));
            }
            let side = self.held.iter().find(|(held, _)| *held == at).map(|(_, side)| side);
            (*face, side.map_or([0.0; 3], |side| side.along(scale(*flow, multipliers[*a]))))
        };
        Ok(self.faces.iter().enumerate().map(correction).collect())
    }

    /// What each cell asks for beyond the first guess, and the size of the forces there.
    fn asked(
        &self,
        tets: &Tets,
        stress: &[[Voigt; 4]],
        shapes: &[Shape],
        body_force: &[V3],
        first: &[OnFace],
    ) -> (Vec<V3>, f64) {
        let mut size: f64 = 0.0;
        let of_cell = |&cell: &u32| {
            let cell = cell as usize;
            let (corners, shape) = (tets.corners[cell], &shapes[cell]);
            let own = corners.iter().position(|&node| node == self.node).unwrap_or(0);
            let mean: Voigt = std::array::from_fn(|k| 0.25 * stress[cell].iter().map(|s| s[k]).sum::<f64>());
            let mut asked = scale(shape.volume, traction(&mean, shape.gradient[own]));
            size = size.max(norm(asked));
            if let Some(force) = body_force.get(cell) {
                asked = sub(asked, scale(0.25 * shape.volume, *force));
            }
            for j in (0..4).filter(|&j| j != own) {
                let face = tets.faces_of[cell][j];
                let corner = without(&corners, j).iter().position(|&node| node == self.node).unwrap_or(0);
                let moment = first[face as usize][corner];
                size = size.max(norm(moment));
                asked = sub(asked, scale(tets.sign(cell, face), moment));
            }
            asked
        };
        let asked = self.cells.iter().map(of_cell).collect();
        (asked, size)
    }

    /// Numbers of what hangs together by faces.
    fn components(&self) -> Vec<usize> {
        let mut of: Vec<usize> = (0..self.cells.len()).collect();
        let mut changed = true;
        while changed {
            changed = false;
            for (_, [a, b], _) in self.faces.iter().filter(|face| face.1[1] != usize::MAX) {
                let least = of[*a].min(of[*b]);
                changed |= of[*a] != least || of[*b] != least;
                (of[*a], of[*b]) = (least, least);
            }
        }
        let mut names: Vec<usize> = of.clone();
        names.sort_unstable();
        names.dedup();
        of.iter().map(|name| names.partition_point(|other| other < name)).collect()
    }
}

/// Orthonormal directions across all of these.
pub(super) fn complement(directions: &[V3]) -> Vec<V3> {
    let mut basis: Vec<V3> = Vec::new();
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut free = Vec::new();
    for (i, &d) in directions.iter().chain(&axes).enumerate() {
        let off = |d: V3, basis: &[V3]| basis.iter().fold(d, |d, b| sub(d, scale(dot(d, *b), *b)));
        let rest = off(off(d, &basis), &basis);
        let length = norm(rest);
        // Directions closer to those before are the same plane with other digits.
        if length > 1e-6 {
            basis.push(scale(1.0 / length, rest));
            if i >= directions.len() {
                free.push(scale(1.0 / length, rest));
            }
        }
    }
    free
}

/// The Cholesky factor in the lower triangle.
fn factorise(a: &mut [Vec<f64>]) -> Result<(), NoBound> {
    for i in 0..a.len() {
        let (above, row) = a.split_at_mut(i);
        let row = &mut row[0];
        for j in 0..=i {
            let other: &[f64] = if j < i { &above[j] } else { row };
            let sum: f64 = row[..j].iter().zip(&other[..j]).map(|(x, y)| x * y).sum();
            let rest = row[j] - sum;
            row[j] = match j < i {
                true => rest / above[j][j],
                false if rest > ZERO * row[i] => rest.sqrt(),
                false => return Err(NoBound::Degenerate),
            };
        }
    }
    Ok(())
}

fn solve(factor: &[Vec<f64>], mut x: Vec<f64>) -> Vec<f64> {
    for i in 0..x.len() {
        let sum: f64 = factor[i][..i].iter().zip(&x[..i]).map(|(a, x)| a * x).sum();
        x[i] = (x[i] - sum) / factor[i][i];
    }
    for i in (0..x.len()).rev() {
        x[i] /= factor[i][i];
        let value = x[i];
        (0..i).for_each(|j| x[j] -= factor[i][j] * value);
    }
    x
}
