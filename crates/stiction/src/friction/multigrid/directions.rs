use rayon::prelude::*;

use super::iteration::Iterate;
use super::points::Point;
use super::tightening::{Tightening, share};
use crate::linalg::multigrid::NodeConstraint;
use crate::ranks::Halo;

/// A vector of nodes with three components.
pub(super) type Vector = Vec<[f64; 3]>;

/// A search direction with its image under `K`, from which the forces of its shortenings are taken off.
#[derive(Debug, Clone)]
pub(super) struct Direction {
    pub p: Vector,
    pub kp: Vector,
    /// Of the bolts whose force is given; length, one for each bolt, none without them.
    pub shortening: Vec<f64>,
}

/// Nodes of a partial sum; sums do not depend on the number of threads.
const CHUNK: usize = 4096;

/// Of what this rank has.
pub(super) fn dot(x: &Vector, y: &Vector) -> f64 {
    let part = |(x, y): (&[[f64; 3]], &[[f64; 3]])| {
        x.iter().flatten().zip(y.iter().flatten()).map(|(x, y)| x * y).sum::<f64>()
    };
    let parts: Vec<f64> = x.par_chunks(CHUNK).zip(y.par_chunks(CHUNK)).map(part).collect();
    parts.iter().sum()
}

/// Of what all ranks have.
pub(super) fn norm(halo: &Halo, x: &Vector) -> f64 {
    let mut square = [dot(x, x)];
    halo.sum(&mut square);
    square[0].sqrt()
}

/// Moves the iterate along the combination of the directions whose residual is orthogonal to all of them,
/// `(Sᵀ M S) y = Sᵀ r`, with `M` the sum of `K`, the springs of slipping points and their Coulomb coupling, and makes that
/// combination the first direction. With bolts whose force is given, `S` contains their shortenings and `r` what is missing of
/// their forces. Without the coupling it minimises the energy. Minimising the residual instead stalls:
/// steps shrink whenever the active sets change.
///
/// The nodes are divided by `halo`: its products are added in one message.
pub(super) fn minimise(
    halo: &Halo,
    directions: &mut [Direction],
    r: &Vector,
    points: &[Point],
    tightening: Option<&Tightening>,
    at: &mut Iterate,
) {
    let (mut a, mut b) = gram(directions, r);
    if let Some(tightening) = tightening {
        let missing = tightening.missing(halo, at);
        for (i, x) in directions.iter().enumerate() {
            b[i] += share(halo) * x.shortening.iter().zip(&missing).map(|(s, m)| s * m).sum::<f64>();
            directions.iter().enumerate().for_each(|(j, y)| a[i][j] += tightening.coupled(halo, x, y));
        }
    }
    let Iterate { u, ku, shortening, conditions, .. } = at;
    let mut coupling = [[0.0; MOST_DIRECTIONS]; MOST_DIRECTIONS];
    for (p, condition) in points.iter().zip(conditions) {
        let NodeConstraint { spring, coulomb, .. } = &condition.constraint;
        if *spring == [[0.0; 3]; 3] && *coulomb == [0.0; 2] {
            continue;
        }
        for (i, x) in directions.iter().map(|d| d.p[p.node]).enumerate() {
            for (j, d) in directions.iter().enumerate() {
                let y = d.p[p.node];
                a[i][j] += x[0] * spring[0][0] * y[0];
                a[i][j] += (1..3).map(|r| x[r] * (spring[r][1] * y[1] + spring[r][2] * y[2])).sum::<f64>();
                // The normal contact force changes by minus the elastic force of the direction.
                coupling[i][j] -= (x[1] * coulomb[0] + x[2] * coulomb[1]) * d.kp[p.node][0];
            }
        }
    }
    sum_products(halo, &mut a, &mut b, &mut coupling);
    // With high coefficients of friction the coupled matrix may be indefinite on the directions: then it is left out.
    if (0..directions.len()).all(|i| coupling[i][i] > -Threshold::MOST_COUPLED * a[i][i]) {
        a.iter_mut().flatten().zip(coupling.iter().flatten()).for_each(|(a, c)| *a += c);
    }
    let y = solve_small(&a, &b, directions.len());
    let Some((first, rest)) = directions.split_first_mut() else { return };
    combine(&mut first.p, y[0], rest.iter().zip(&y[1..]).map(|(d, &y)| (y, &d.p)).collect(), u);
    combine(&mut first.kp, y[0], rest.iter().zip(&y[1..]).map(|(d, &y)| (y, &d.kp)).collect(), ku);
    for (bolt, (s, sum)) in first.shortening.iter_mut().zip(shortening).enumerate() {
        *s = y[0] * *s + rest.iter().zip(&y[1..]).map(|(d, y)| y * d.shortening[bolt]).sum::<f64>();
        *sum += *s;
    }
}

type Products = [[f64; MOST_DIRECTIONS]; MOST_DIRECTIONS];

/// Adds those of all ranks.
fn sum_products(halo: &Halo, a: &mut Products, b: &mut [f64; MOST_DIRECTIONS], coupling: &mut Products) {
    let all = [a.as_flattened(), b, coupling.as_flattened()];
    let mut sums = all.concat();
    halo.sum(&mut sums);
    let targets = a.as_flattened_mut().iter_mut().chain(b).chain(coupling.as_flattened_mut());
    targets.zip(sums).for_each(|(target, sum)| *target = sum);
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

/// Most directions, the new one and those kept. With a prototype on bricks of 42 000 unknowns five kept ones instead of two
/// save up to three cycles of thirty.
pub(super) const MOST_DIRECTIONS: usize = 4;

/// Thresholds of the directions; single values were varied only where their line says so.
struct Threshold;

impl Threshold {
    /// Largest part of a direction's energy that the Coulomb coupling may cancel. Cycles are the same from 0.7 to 0.9; with 0.5
    /// the coupling is left out needlessly now and then, for four cycles more.
    const MOST_COUPLED: f64 = 0.8;
    /// A direction is dependent if elimination leaves this part of its energy or less.
    const DEPENDENT: f64 = 1e-12;
}

/// `Sᵀ K S` and `Sᵀ r` in one pass.
fn gram(directions: &[Direction], r: &Vector) -> ([[f64; MOST_DIRECTIONS]; MOST_DIRECTIONS], [f64; MOST_DIRECTIONS]) {
    let n = directions.len();
    let tasks: Vec<usize> = (0..r.len()).step_by(CHUNK).collect();
    let part = |&first: &usize| {
        let range = first..r.len().min(first + CHUNK);
        let dot = |x: &Vector, y: &Vector| -> f64 {
            let pairs = x[range.clone()].iter().zip(&y[range.clone()]);
            pairs.map(|(x, y)| x[0] * y[0] + x[1] * y[1] + x[2] * y[2]).sum()
        };
        let (mut a, mut b) = ([[0.0; MOST_DIRECTIONS]; MOST_DIRECTIONS], [0.0; MOST_DIRECTIONS]);
        for i in 0..n {
            b[i] = dot(&directions[i].p, r);
            (0..=i).for_each(|j| a[i][j] = dot(&directions[i].p, &directions[j].kp));
        }
        (a, b)
    };
    let parts: Vec<_> = tasks.par_iter().map(part).collect();
    let (mut a, mut b) = ([[0.0; MOST_DIRECTIONS]; MOST_DIRECTIONS], [0.0; MOST_DIRECTIONS]);
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

/// `A y = b` by elimination after scaling to a unit diagonal; dependent directions get zero.
fn solve_small(
    a: &[[f64; MOST_DIRECTIONS]; MOST_DIRECTIONS],
    b: &[f64; MOST_DIRECTIONS],
    n: usize,
) -> [f64; MOST_DIRECTIONS] {
    let scale: [f64; MOST_DIRECTIONS] = std::array::from_fn(|i| if a[i][i] > 0.0 { 1.0 / a[i][i].sqrt() } else { 0.0 });
    let mut a: [[f64; MOST_DIRECTIONS]; MOST_DIRECTIONS] =
        std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] * scale[i] * scale[j]));
    let mut y: [f64; MOST_DIRECTIONS] = std::array::from_fn(|i| b[i] * scale[i]);
    for k in 0..n {
        let reciprocal = if a[k][k] > Threshold::DEPENDENT { 1.0 / a[k][k] } else { 0.0 };
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
