//! How stiff a body is at its contact points, from `K` and `B` alone.

use super::share::Share;
use crate::contact::ContactProblem;
use crate::contact::rigid::components;
use crate::linalg::SymmetricCsr;

/// Stiffness at the contact points as if all else were held.
pub(super) struct LocalStiffness {
    /// The force along each row of `B` that closes its jump by a unit length; `None` for an empty row, `3m`.
    pub of_row: Vec<Option<f64>>,
    /// The mean over the rows of the point's pair, `m`: turns a displacement into a force. Not a number for a point of no pair.
    pub of_point: Vec<f64>,
    /// The body of each unknown, `n`.
    pub body: Vec<u32>,
}

impl LocalStiffness {
    pub(super) fn new(problem: &ContactProblem, share: &Share) -> LocalStiffness {
        let body = match &problem.labels.bodies {
            Some(bodies) => bodies.of.clone(),
            None => {
                let mut body = vec![0; problem.elastic.K.rows];
                for (number, unknowns) in components(&problem.elastic.K).iter().enumerate() {
                    unknowns.iter().for_each(|&i| body[i as usize] = number as u32);
                }
                body
            }
        };
        let m = problem.points();
        let of_row: Vec<Option<f64>> = (0..3 * m).map(|i| of_row(problem, &body, i)).collect();
        let mut of_point = vec![f64::NAN; m];
        for pair in &problem.labels.pairs {
            let own = || pair.points.clone().filter(|&j| share.has_point(j));
            let rows = (0..3).flat_map(|k| own().map(move |j| k * m + j));
            let forces: Vec<f64> = rows.filter_map(|i| of_row[i]).collect();
            let mut sums = [forces.iter().sum::<f64>(), forces.len() as f64];
            share.sum(&mut sums);
            let mean = if sums[1] == 0.0 { 0.0 } else { sums[0] / sums[1] };
            of_point[pair.points.clone()].fill(mean);
        }
        LocalStiffness { of_row, of_point, body }
    }
}

/// On one body the force is `b K bᵀ / |b|⁴`. Between bodies the same force stretches both and compliances add: with
/// the sum of the stiffnesses a soft body on a stiff one would be judged by forces that a displacement of its own size
/// causes in the stiff one, beyond what rounding leaves of the solution. What one pair touches does not measure another.
fn of_row(problem: &ContactProblem, body: &[u32], i: usize) -> Option<f64> {
    let (columns, values) = problem.contact.B.row(i);
    let entries = || columns.iter().zip(values).filter(|(_, b)| **b != 0.0).map(|(&j, &b)| (j as usize, b));
    let mut touched: Vec<u32> = entries().map(|(j, _)| body[j]).collect();
    touched.sort_unstable();
    touched.dedup();
    let compliance = |own: u32| {
        let part: Vec<(usize, f64)> = entries().filter(|(j, _)| body[*j] == own).collect();
        let square: f64 = part.iter().map(|(_, b)| b * b).sum();
        (square * square, energy(&problem.elastic.K, &part))
    };
    match touched[..] {
        [] => None,
        [one] => {
            let (square, energy) = compliance(one);
            Some(energy / square)
        }
        _ => {
            Some(1.0 / touched.iter().map(|&own| compliance(own)).map(|(square, energy)| square / energy).sum::<f64>())
        }
    }
}

/// `b K bᵀ` of a row with these columns, ascending, and values.
fn energy(k: &SymmetricCsr, row: &[(usize, f64)]) -> f64 {
    let of_column = |(place, &(i, b)): (usize, &(usize, f64))| {
        let (columns, values) = k.row(i);
        let (mut at, mut force) = (0, 0.0);
        // The lower triangle holds the columns up to the diagonal, which comes last.
        for &(j, other) in &row[..=place] {
            at += columns[at..].iter().take_while(|&&column| (column as usize) < j).count();
            if columns.get(at) == Some(&(j as u32)) {
                force += if j == i { 0.5 } else { 1.0 } * other * values[at];
            }
        }
        2.0 * b * force
    };
    row.iter().enumerate().map(of_column).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Csr;

    #[test]
    fn the_energy_of_a_row_is_the_product_with_all_of_the_matrix() {
        let entries = [(0, 0, 4.0), (1, 0, -1.0), (1, 1, 5.0), (2, 2, 3.0), (3, 0, 2.0), (3, 2, -0.5), (3, 3, 6.0)];
        let all: Vec<(usize, usize, f64)> = entries
            .iter()
            .flat_map(|&(i, j, v)| if i == j { vec![(i, j, v)] } else { vec![(i, j, v), (j, i, v)] })
            .collect();
        let full = Csr::from_triplets(4, 4, &all);
        let k = SymmetricCsr::from_full(&full, "K").unwrap();
        for row in [vec![(0, 1.0), (1, 2.0), (3, -1.5)], vec![(2, 0.5), (3, 1.0)], vec![(1, 3.0)], vec![]] {
            let mut b = vec![0.0; 4];
            row.iter().for_each(|&(i, value)| b[i] = value);
            let expected: f64 = b.iter().zip(full.times(&b)).map(|(b, k)| b * k).sum();
            assert!((energy(&k, &row) - expected).abs() < 1e-14, "{row:?}: {}", energy(&k, &row));
        }
    }
}
