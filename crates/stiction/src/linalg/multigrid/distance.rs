use rayon::prelude::*;

use super::blocks::{Blocks, ROWS_PER_TASK};
use super::coarsen::Kernel;

/// A neighbour so many times as far as the nearest one is across the short side of stretched cells. Neighbours in a
/// cube are at most 1.7 times as far as the nearest, those in its tetrahedra too.
const FAR: f64 = 2.5;

/// For each stored block whether its two nodes are far apart, measured by the nearest strongly coupled
/// neighbours they have.
///
/// The entries of a stretched cell's matrix do not tell: trilinear elements couple along the long side with a quarter
/// of the strength across the short one however long the cell is, and nothing of that resists. Lengths do
/// (the distance Laplacian of MueLu), and the rigid motions know the places. What they do not tell is not far.
pub fn far<const R: usize>(a: &Blocks<R, R>, kernel: &[Kernel<R>], strong: &[bool]) -> Vec<bool> {
    let place: Vec<[f64; 3]> = kernel.par_iter().map(place).collect();
    let square = |i: usize, j: u32| -> f64 { (0..3).map(|c| (place[i][c] - place[j as usize][c]).powi(2)).sum() };
    let nearest: Vec<f64> = (0..a.rows)
        .into_par_iter()
        .map(|i| {
            let strong = (a.start[i]..a.start[i + 1]).filter(|&place| strong[place]);
            let distances = strong.map(|place| square(i, a.column[place])).filter(|&d| d > 0.0);
            distances.fold(f64::INFINITY, f64::min)
        })
        .collect();
    let mut far = vec![false; a.column.len()];
    let (mut slices, mut rest) = (Vec::new(), far.as_mut_slice());
    for first in (0..a.rows).step_by(ROWS_PER_TASK) {
        let end = a.rows.min(first + ROWS_PER_TASK);
        let (head, tail) = rest.split_at_mut(a.start[end] - a.start[first]);
        slices.push((first..end, head));
        rest = tail;
    }
    slices.into_par_iter().for_each(|(rows, far)| {
        let mut far = far.iter_mut();
        for i in rows {
            for (&j, far) in a.row(i).0.iter().zip(&mut far) {
                *far = square(i, j) > super::coarsen::farv().powi(2) * nearest[i].max(nearest[j as usize]);
            }
        }
    });
    far
}

/// The centre of a node or an aggregate from its rigid motions `B = [T, T x]`, with `T x` the turns at `x`: in the
/// first three columns of `Bᵀ B` stands how much of each translation there is, and that times the place. Not a number
/// where the motions do not tell.
fn place<const R: usize>(b: &Kernel<R>) -> [f64; 3] {
    let product = |p: usize, q: usize| -> f64 { b.iter().map(|row| row[p] * row[q]).sum() };
    // Turns about x, y, z move a point by (0, -z, y), (z, 0, -x), (-y, x, 0).
    let pairs = [[(1, 5, 1.0), (2, 4, -1.0)], [(0, 5, -1.0), (2, 3, 1.0)], [(0, 4, 1.0), (1, 3, -1.0)]];
    pairs.map(|[first, second]| {
        let best = if product(first.0, first.0) >= product(second.0, second.0) { first } else { second };
        best.2 * product(best.0, best.1) / product(best.0, best.0)
    })
}
