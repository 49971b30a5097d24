use super::blocks::Blocks;
use super::problem::LocalProblem;

/// Largest order of which the rank is computed: its square is held in memory.
const LARGEST: usize = 6000;
/// A pivot below this part of the first counts as zero.
const ZERO: f64 = 1e-10;

/// The numerical rank of the symmetric part of `W`, scaled point by point, by Cholesky with diagonal pivots; `None`
/// beyond an order of 6000.
pub fn rank(problem: &LocalProblem) -> Option<usize> {
    let n = problem.q.len();
    if n > LARGEST {
        return None;
    }
    let (blocks, d) = (Blocks::new(problem), problem.dimension);
    let mut w = vec![0.0; n * n];
    for a in 0..problem.mu.len() {
        for k in blocks.start[a]..blocks.start[a + 1] {
            let b = blocks.column[k] as usize;
            for (i, j) in (0..d).flat_map(|i| (0..d).map(move |j| (i, j))) {
                w[(d * a + i) * n + d * b + j] += 0.5 * blocks.block[k][i][j];
                w[(d * b + j) * n + d * a + i] += 0.5 * blocks.block[k][i][j];
            }
        }
    }
    let mut pivots: Vec<f64> = (0..n).map(|i| w[i * n + i]).collect();
    let largest = pivots.iter().copied().fold(0.0, f64::max);
    let mut rows: Vec<Vec<f64>> = Vec::new();
    loop {
        let at = (0..n).fold(0, |best, i| if pivots[i] > pivots[best] { i } else { best });
        if rows.len() == n || n == 0 || pivots[at] <= ZERO * largest {
            return Some(rows.len());
        }
        let mut row = w[at * n..(at + 1) * n].to_vec();
        rows.iter().for_each(|other| crate::linalg::axpy(-other[at], other, &mut row));
        let root = pivots[at].sqrt();
        row.iter_mut().for_each(|x| *x /= root);
        pivots.iter_mut().zip(&row).for_each(|(p, x)| *p -= x * x);
        pivots[at] = 0.0;
        rows.push(row);
    }
}
