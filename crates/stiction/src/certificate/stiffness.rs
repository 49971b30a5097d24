//! How stiff a body is at its contact points, from `K` and `B` alone.

use crate::contact::ContactProblem;
use crate::contact::rigid::components;

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
    pub(super) fn new(problem: &ContactProblem) -> LocalStiffness {
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
            let rows = (0..3).flat_map(|k| pair.points.clone().map(move |j| k * m + j));
            let forces: Vec<f64> = rows.filter_map(|i| of_row[i]).collect();
            let mean = if forces.is_empty() { 0.0 } else { forces.iter().sum::<f64>() / forces.len() as f64 };
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
        let part = || entries().filter(|(j, _)| body[*j] == own);
        let square: f64 = part().map(|(_, b)| b * b).sum();
        let energy: f64 = part()
            .flat_map(|p| part().map(move |q| (p, q)))
            .map(|((j, a), (k, b))| a * b * problem.elastic.K.entry(j, k))
            .sum();
        (square * square, energy)
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
