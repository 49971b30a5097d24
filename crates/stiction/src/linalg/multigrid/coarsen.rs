use super::aggregate::{aggregates, strong};
use super::blocks::{Block, Blocks};
use super::dense::{add_product, add_transpose_product, inverse};

/// The near-kernel at one node: a row of six values for each of its components.
pub type Kernel<const R: usize> = [[f64; 6]; R];

/// A coarser level: its matrix, the prolongation to it and what it needs of its own.
#[derive(Debug, Clone)]
pub struct Coarser<const R: usize> {
    pub prolongation: Blocks<R, 6>,
    /// `A P`, of use for local changes of the coarse matrix.
    pub a_times_p: Blocks<R, 6>,
    pub matrix: Blocks<6, 6>,
    pub kernel: Vec<Kernel<6>>,
}

/// Smoothed aggregation (Vanek, Mandel & Brezina 1996): six unknowns an aggregate, which represent the near-kernel
/// there exactly; the prolongation smoothed by one damped block Jacobi step. `None` if that makes nothing coarser.
pub fn coarsen<const R: usize>(a: &Blocks<R, R>, kernel: &[Kernel<R>], threshold: f64) -> Option<Coarser<R>> {
    let (start, neighbour) = strong(a, threshold);
    let (of, count) = aggregates(&start, &neighbour);
    // Six unknowns an aggregate against R a node.
    if 6 * count > R * a.rows * 4 / 5 {
        return None;
    }
    let (tentative, kernel) = tentative(&of, count, kernel);
    let inverses: Vec<Block<R, R>> = (0..a.rows).map(|i| inverse(&a.diagonal(i))).collect();
    let omega = 4.0 / (3.0 * largest_eigenvalue(a, &inverses));
    let prolongation = smoothed(a, &inverses, omega, &of, &tentative, count);
    let a_times_p = product(a, &prolongation);
    let matrix = galerkin(&prolongation, &a_times_p);
    if 36 * matrix.value.len() > MOST_FILL * R * R * a.value.len() {
        return None;
    }
    Some(Coarser { prolongation, a_times_p, matrix, kernel })
}

/// A coarse matrix with so many times the numbers of its finer one costs more than it saves: cells are stretched, and
/// the prolongation reaches far across the weak couplings.
const MOST_FILL: usize = 3;

/// An orthonormal basis of the near-kernel on each aggregate, as one block a node, and the near-kernel in it.
/// Columns that depend on the earlier ones there are zero.
fn tentative<const R: usize>(of: &[u32], count: usize, kernel: &[Kernel<R>]) -> (Vec<Block<R, 6>>, Vec<Kernel<6>>) {
    let mut start = vec![0usize; count + 1];
    of.iter().for_each(|&g| start[g as usize + 1] += 1);
    (0..count).for_each(|g| start[g + 1] += start[g]);
    let (mut next, mut member) = (start.clone(), vec![0u32; of.len()]);
    for (i, &g) in of.iter().enumerate() {
        member[next[g as usize]] = i as u32;
        next[g as usize] += 1;
    }
    let mut basis = kernel.to_vec();
    let mut coarse = vec![[[0.0; 6]; 6]; count];
    for g in 0..count {
        let nodes = &member[start[g]..start[g + 1]];
        let product = |basis: &[Block<R, 6>], p: usize, q: usize| -> f64 {
            nodes.iter().map(|&i| basis[i as usize].iter().map(|row| row[p] * row[q]).sum::<f64>()).sum()
        };
        for q in 0..6 {
            let before = product(&basis, q, q).sqrt();
            // Twice is enough (Giraud, Langou & Rozloznik 2005).
            for _ in 0..2 {
                for p in 0..q {
                    let share = product(&basis, p, q);
                    coarse[g][p][q] += share;
                    nodes.iter().for_each(|&i| basis[i as usize].iter_mut().for_each(|row| row[q] -= share * row[p]));
                }
            }
            let length = product(&basis, q, q).sqrt();
            let scale = if length > DEPENDENT * before { 1.0 / length } else { 0.0 };
            coarse[g][q][q] = if scale > 0.0 { length } else { 0.0 };
            nodes.iter().for_each(|&i| basis[i as usize].iter_mut().for_each(|row| row[q] *= scale));
        }
    }
    (basis, coarse)
}

/// A column of the near-kernel that keeps less than this share of its length beside the others depends on them.
const DEPENDENT: f64 = 1e-8;

/// Estimate of the largest eigenvalue of `D⁻¹ A`, `D` the block diagonal: power steps from a rough start.
fn largest_eigenvalue<const R: usize>(a: &Blocks<R, R>, inverses: &[Block<R, R>]) -> f64 {
    let mut x: Vec<[f64; R]> =
        (0..a.rows).map(|i| std::array::from_fn(|c| ((i * R + c) as f64 * 1.618).fract() - 0.5)).collect();
    let mut value = 1.0;
    for _ in 0..POWER_STEPS {
        let y = a.times(&x);
        for ((x, y), d) in x.iter_mut().zip(&y).zip(inverses) {
            *x = std::array::from_fn(|r| (0..R).map(|c| d[r][c] * y[c]).sum());
        }
        value = x.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
        if !(value > 0.0 && value.is_finite()) {
            return 1.0;
        }
        x.iter_mut().flatten().for_each(|v| *v /= value);
    }
    value
}

/// The damping is not sensitive to the estimate.
const POWER_STEPS: usize = 8;

/// `P = (I - omega D⁻¹ A) T`.
fn smoothed<const R: usize>(
    a: &Blocks<R, R>,
    inverses: &[Block<R, R>],
    omega: f64,
    of: &[u32],
    tentative: &[Block<R, 6>],
    count: usize,
) -> Blocks<R, 6> {
    let aggregates = |i: usize, name: &mut dyn FnMut(u32)| a.row(i).0.iter().for_each(|&j| name(of[j as usize]));
    Blocks::from_rows(a.rows, count, aggregates, |i, row| {
        let mut scaled = inverses[i];
        scaled.iter_mut().flatten().for_each(|v| *v *= -omega);
        let (columns, blocks) = a.row(i);
        // A T first, by aggregates; D⁻¹ once for each of them.
        for (&j, block) in columns.iter().zip(blocks) {
            add_product(block, &tentative[j as usize], row.at(of[j as usize]));
        }
        for block in row.values.iter_mut() {
            let mut result = [[0.0; 6]; R];
            add_product(&scaled, block, &mut result);
            *block = result;
        }
        let own = row.at(of[i]);
        own.iter_mut().flatten().zip(tentative[i].iter().flatten()).for_each(|(p, t)| *p += t);
    })
}

/// `A P`.
fn product<const R: usize>(a: &Blocks<R, R>, p: &Blocks<R, 6>) -> Blocks<R, 6> {
    let reached = |i: usize, name: &mut dyn FnMut(u32)| {
        a.row(i).0.iter().for_each(|&j| p.row(j as usize).0.iter().for_each(|&k| name(k)));
    };
    Blocks::from_rows(a.rows, p.cols, reached, |i, row| {
        let (columns, blocks) = a.row(i);
        for (&j, block) in columns.iter().zip(blocks) {
            let (coarse, values) = p.row(j as usize);
            for (&k, value) in coarse.iter().zip(values) {
                add_product(block, value, row.at(k));
            }
        }
    })
}

/// `Pᵀ (A P)`; a coarse unknown that nothing depends on gets a one on the diagonal.
fn galerkin<const R: usize>(p: &Blocks<R, 6>, a_times_p: &Blocks<R, 6>) -> Blocks<6, 6> {
    let (start, entry) = p.by_columns();
    let reached = |k: usize, name: &mut dyn FnMut(u32)| {
        name(k as u32);
        entry[start[k]..start[k + 1]]
            .iter()
            .for_each(|&(i, _)| a_times_p.row(i as usize).0.iter().for_each(|&j| name(j)));
    };
    Blocks::from_rows(p.cols, p.cols, reached, |k, row| {
        for &(i, place) in &entry[start[k]..start[k + 1]] {
            let (columns, blocks) = a_times_p.row(i as usize);
            for (&j, block) in columns.iter().zip(blocks) {
                add_transpose_product(&p.value[place as usize], block, row.at(j));
            }
        }
        let own = row.at(k as u32);
        let scale = (0..6).map(|c| own[c][c]).fold(0.0, f64::max);
        for c in 0..6 {
            if own[c][c] <= 1e-14 * scale {
                own[c][c] = scale.max(f64::MIN_POSITIVE);
            }
        }
    })
}
