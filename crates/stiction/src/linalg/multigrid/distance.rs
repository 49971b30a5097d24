use rayon::prelude::*;

use super::aggregate::marks;
use super::blocks::Blocks;
use super::coarsen::Kernel;

/// A neighbour is far if its distance exceeds this multiple of the nearest neighbour's: it lies along the long side of
/// stretched cells. In a cube and in its tetrahedra the largest ratio is 1.74.
const FAR: f64 = 2.0;

/// The strong blocks whose nodes are not far apart, measured by the nearest strongly coupled neighbour of each.
///
/// The entries of the matrix do not show it: trilinear elements couple along the long side with a quarter of the
/// strength across the short one however long they are, although nothing smooths along it. Distances do (as in
/// the distance Laplacian of Gee et al., ML 5.0 Smoothed Aggregation User's Guide, 2006). They are computed from the
/// rigid motions; where these do not contain the coordinates, nothing is far.
pub(super) fn near<const R: usize>(a: &Blocks<R, R>, kernel: &[Kernel<R>], strong: &[bool]) -> Vec<bool> {
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
    marks(a, |i, place| {
        let j = a.column[place];
        let far = square(i, j) > FAR.powi(2) * nearest[i].max(nearest[j as usize]);
        strong[place] && !far
    })
}

/// The coordinates of a node or the centre of an aggregate from its rigid motions `B = [T, T x]`, with `T x` the rotations
/// at `x`: the first three rows of `Bᵀ B` hold the squared norm of each translation, and that times the coordinates. Not a
/// number where the motions do not contain them.
pub(super) fn place<const R: usize>(b: &Kernel<R>) -> [f64; 3] {
    let product = |p: usize, q: usize| -> f64 { b.iter().map(|row| row[p] * row[q]).sum() };
    // Rotations about x, y, z move a point by (0, -z, y), (z, 0, -x), (-y, x, 0).
    let pairs = [[(1, 5, 1.0), (2, 4, -1.0)], [(0, 5, -1.0), (2, 3, 1.0)], [(0, 4, 1.0), (1, 3, -1.0)]];
    pairs.map(|[first, second]| {
        let best = if product(first.0, first.0) >= product(second.0, second.0) { first } else { second };
        best.2 * product(best.0, best.1) / product(best.0, best.0)
    })
}
