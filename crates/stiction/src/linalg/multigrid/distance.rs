use rayon::prelude::*;

use super::aggregate::marks;
use super::blocks::Blocks;
use super::coarsen::Kernel;
use super::dense::square;
use crate::ranks::Halo;

/// A neighbour is far if its distance exceeds this multiple of the nearest neighbour's: it lies along the long side of
/// stretched cells. In a cube and in its tetrahedra the largest ratio is 1.74.
pub(super) const FAR: f64 = 2.0;

/// The strong blocks whose nodes are not far apart, measured by the nearest strongly coupled neighbour of each.
///
/// The entries of the matrix do not show it: trilinear elements couple along the long side with a quarter of the
/// strength across the short one however long they are, although nothing smooths along it. Distances do (as in
/// the distance Laplacian of Gee et al., ML 5.0 Smoothed Aggregation User's Guide, 2006). They are those of the
/// [`places`].
pub(super) fn near<const R: usize>(a: &Blocks<R, R>, halo: &Halo, place: &[[f64; 3]], strong: &[bool]) -> Vec<bool> {
    let distance = |i: usize, j: u32| square_distance(place, i, j);
    let mut nearest: Vec<f64> = (0..a.rows)
        .into_par_iter()
        .map(|i| {
            let strong = (a.start[i]..a.start[i + 1]).filter(|&place| strong[place]);
            let distances = strong.map(|place| distance(i, a.column[place])).filter(|&d| d > 0.0);
            distances.fold(f64::INFINITY, f64::min)
        })
        .collect();
    halo.update(&mut nearest);
    marks(a, |i, place| {
        let j = a.column[place];
        let far = distance(i, j) > FAR.powi(2) * nearest[i].max(nearest[j as usize]);
        strong[place] && !far
    })
}

pub(super) fn square_distance(place: &[[f64; 3]], i: usize, j: u32) -> f64 {
    (0..3).map(|c| (place[i][c] - place[j as usize][c]).powi(2)).sum()
}

/// The coordinates of the nodes from their rigid motions, and from neighbours where these do not contain them; `norms` are
/// those of the diagonal blocks, of ghosts as well.
pub(super) fn places<const R: usize>(
    a: &Blocks<R, R>,
    halo: &Halo,
    norms: &[f64],
    kernel: &[Kernel<R>],
) -> Vec<[f64; 3]> {
    let mut places = completed(a, norms, kernel.par_iter().map(place).collect());
    halo.update(&mut places);
    places
}

/// The places with each unknown coordinate taken from the most strongly coupled neighbour that knows it: nodes with
/// prescribed components, on planes of symmetry for instance, do not show all of theirs. Stretched cells couple most strongly
/// across their short sides, where the other coordinates are the same.
fn completed<const R: usize>(a: &Blocks<R, R>, norms: &[f64], place: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    let strength = |at: usize| square(&a.value[at]) / norms[a.column[at] as usize];
    let known = |i: usize, c: usize| -> f64 {
        let neighbours = (a.start[i]..a.start[i + 1]).filter(|&at| place[a.column[at] as usize][c].is_finite());
        let strongest = neighbours.max_by(|&p, &q| strength(p).total_cmp(&strength(q)));
        strongest.map_or(f64::NAN, |at| place[a.column[at] as usize][c])
    };
    let complete = |i: usize| std::array::from_fn(|c| if place[i][c].is_finite() { place[i][c] } else { known(i, c) });
    (0..a.rows).into_par_iter().map(complete).collect()
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
