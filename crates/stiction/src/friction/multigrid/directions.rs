use rayon::prelude::*;

use super::frames::Point;
use super::sets::Set;
use crate::linalg::multigrid::Condition;

/// A vector of nodes with three components.
pub(super) type Vector = Vec<[f64; 3]>;

/// A search direction with its image under `K`.
#[derive(Debug, Clone)]
pub(super) struct Direction {
    pub p: Vector,
    pub kp: Vector,
}

/// Nodes summed at a time: sums do not depend on the number of threads.
const CHUNK: usize = 4096;

pub(super) fn dot(x: &Vector, y: &Vector) -> f64 {
    let part = |(x, y): (&[[f64; 3]], &[[f64; 3]])| {
        x.iter().flatten().zip(y.iter().flatten()).map(|(x, y)| x * y).sum::<f64>()
    };
    let parts: Vec<f64> = x.par_chunks(CHUNK).zip(y.par_chunks(CHUNK)).map(part).collect();
    parts.iter().sum()
}

pub(super) fn norm(x: &Vector) -> f64 {
    dot(x, x).sqrt()
}

/// Moves `u` and `ku` along the combination of the directions that leaves no residual on any of them, `(Sᵀ M S) y = Sᵀ r`
/// with `M` the matrix `K`, the springs of the slipping points and what their friction grows by with the normal force, and
/// makes that combination the first of them. Without the last the energy is least there.
pub(super) fn advance(
    directions: &mut [Direction],
    r: &Vector,
    points: &[Point],
    sets: &[Set],
    u: &mut Vector,
    ku: &mut Vector,
) {
    let (mut a, b) = gram(directions, r);
    let mut following = [[0.0; MOST]; MOST];
    for (p, set) in points.iter().zip(sets) {
        let Condition { spring, follows, .. } = &set.condition;
        if *spring == [[0.0; 3]; 3] && *follows == [0.0; 2] {
            continue;
        }
        for (i, x) in directions.iter().map(|d| d.p[p.node]).enumerate() {
            for (j, d) in directions.iter().enumerate() {
                let y = d.p[p.node];
                a[i][j] += (1..3).map(|r| x[r] * (spring[r][1] * y[1] + spring[r][2] * y[2])).sum::<f64>();
                // The force that holds the point changes by minus that of the direction.
                following[i][j] -= (x[1] * follows[0] + x[2] * follows[1]) * d.kp[p.node][0];
            }
        }
    }
    // With high coefficients friction may grow by more than the body resists: then it follows a cycle later.
    if (0..directions.len()).all(|i| following[i][i] > -FOLLOWED * a[i][i]) {
        a.iter_mut().flatten().zip(following.iter().flatten()).for_each(|(a, f)| *a += f);
    }
    let y = solve_small(&a, &b, directions.len());
    let Some((first, rest)) = directions.split_first_mut() else { return };
    combine(&mut first.p, y[0], rest.iter().zip(&y[1..]).map(|(d, &y)| (y, &d.p)).collect(), u);
    combine(&mut first.kp, y[0], rest.iter().zip(&y[1..]).map(|(d, &y)| (y, &d.kp)).collect(), ku);
}

/// `x = a x + sum of the others`, and `sum += x`.
fn combine(x: &mut Vector, a: f64, others: Vec<(f64, &Vector)>, sum: &mut Vector) {
    let chunks = x.par_chunks_mut(CHUNK).zip(sum.par_chunks_mut(CHUNK)).enumerate();
    chunks.for_each(|(chunk, (x, sum))| {
        for (k, (x, sum)) in x.iter_mut().zip(sum).enumerate() {
            for c in 0..3 {
                let other: f64 = others.iter().map(|(y, v)| y * v[chunk * CHUNK + k][c]).sum();
                x[c] = a * x[c] + other;
                sum[c] += x[c];
            }
        }
    });
}

/// What friction that follows the normal force may take of the energy of a direction. From 0.7 to 0.9 counts are the same; with
/// a half it followed a cycle later now and then where it need not, for four cycles more.
const FOLLOWED: f64 = 0.8;

/// Directions at most: the new one and those kept.
pub(super) const MOST: usize = 4;

/// `Sᵀ K S` and `Sᵀ r` in one pass.
fn gram(directions: &[Direction], r: &Vector) -> ([[f64; MOST]; MOST], [f64; MOST]) {
    let n = directions.len();
    let tasks: Vec<usize> = (0..r.len()).step_by(CHUNK).collect();
    let part = |&first: &usize| {
        let range = first..r.len().min(first + CHUNK);
        let dot = |x: &Vector, y: &Vector| -> f64 {
            let pairs = x[range.clone()].iter().zip(&y[range.clone()]);
            pairs.map(|(x, y)| x[0] * y[0] + x[1] * y[1] + x[2] * y[2]).sum()
        };
        let (mut a, mut b) = ([[0.0; MOST]; MOST], [0.0; MOST]);
        for i in 0..n {
            b[i] = dot(&directions[i].p, r);
            (0..=i).for_each(|j| a[i][j] = dot(&directions[i].p, &directions[j].kp));
        }
        (a, b)
    };
    let parts: Vec<_> = tasks.par_iter().map(part).collect();
    let (mut a, mut b) = ([[0.0; MOST]; MOST], [0.0; MOST]);
    for (pa, pb) in parts {
        for i in 0..n {
            b[i] += pb[i];
            (0..=i).for_each(|j| a[i][j] += pa[i][j]);
        }
    }
    for i in 0..n {
        (0..i).for_each(|j| a[j][i] = a[i][j]);
    }
    (a, b)
}

/// A direction of which this share or less is left beside the others adds nothing.
const DEPENDENT: f64 = 1e-12;

/// `A y = b` by elimination on the unit diagonal; directions that depend on earlier ones get nothing.
fn solve_small(a: &[[f64; MOST]; MOST], b: &[f64; MOST], n: usize) -> [f64; MOST] {
    let scale: [f64; MOST] = std::array::from_fn(|i| if a[i][i] > 0.0 { 1.0 / a[i][i].sqrt() } else { 0.0 });
    let mut a: [[f64; MOST]; MOST] = std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] * scale[i] * scale[j]));
    let mut y: [f64; MOST] = std::array::from_fn(|i| b[i] * scale[i]);
    for k in 0..n {
        let reciprocal = if a[k][k] > DEPENDENT { 1.0 / a[k][k] } else { 0.0 };
        for i in k + 1..n {
            let factor = a[i][k] * reciprocal;
            (k + 1..n).for_each(|j| a[i][j] -= factor * a[k][j]);
            y[i] -= factor * y[k];
        }
        a[k][k] = reciprocal;
    }
    for k in (0..n).rev() {
        y[k] = a[k][k] * (y[k] - (k + 1..n).map(|j| a[k][j] * y[j]).sum::<f64>());
    }
    std::array::from_fn(|i| y[i] * scale[i])
}
