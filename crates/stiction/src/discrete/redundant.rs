use std::borrow::Cow;
use std::collections::BTreeSet;

use super::problem::{Bilateral, DiscreteProblem, Equalities, GlobalProblem, LocalProblem};
use crate::Error;
use crate::linalg::{Csr, norm};

/// A constraint whose coefficients, after elimination of the others, are this part of its own follows from them.
const ZERO: f64 = 1e-10;
/// What remains of its right-hand side may then be this part of the terms it is the difference of.
const CONTRADICTS: f64 = 1e-8;

/// A problem without the bilateral constraints that follow from others.
#[derive(Debug)]
pub(super) struct Independent<'a> {
    pub problem: Cow<'a, DiscreteProblem>,
    /// The constraints that were kept, of how many.
    pub kept: Vec<u32>,
    pub of: usize,
}

impl Independent<'_> {
    /// Number of constraints that were left out.
    pub(super) fn dropped(&self) -> usize {
        self.of - self.kept.len()
    }

    /// Impulses of all constraints, zero at those left out.
    pub(super) fn all(&self, l: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.of];
        self.kept.iter().zip(l).for_each(|(&k, &l)| all[k as usize] = l);
        all
    }
}

/// Leaves out bilateral constraints that are combinations of others.
///
/// # Errors
/// If one contradicts the others.
pub(super) fn independent(problem: &DiscreteProblem) -> Result<Independent<'_>, Error> {
    let (rows, rhs) = match problem {
        DiscreteProblem::Local(LocalProblem { bilateral: Some(Bilateral { V, R, s }), .. }) => {
            let mut columns = V.clone();
            columns.append(&R.transpose());
            (columns.transpose(), s)
        }
        DiscreteProblem::Global(GlobalProblem { equalities: Some(Equalities { G, b }), .. }) => (G.transpose(), b),
        _ => return Ok(Independent { problem: Cow::Borrowed(problem), kept: Vec::new(), of: 0 }),
    };
    let kept = kept(&rows, rhs)?;
    let of = rhs.len();
    if kept.len() == of {
        return Ok(Independent { problem: Cow::Borrowed(problem), kept, of });
    }
    let mut fewer = problem.clone();
    let chosen = |x: &[f64]| kept.iter().map(|&k| x[k as usize]).collect::<Vec<f64>>();
    match &mut fewer {
        DiscreteProblem::Local(LocalProblem { bilateral: Some(Bilateral { V, R, s }), .. }) => {
            (*V, *R) = (V.select_columns(&kept), R.select_rows(&kept).select_columns(&kept));
            *s = chosen(s);
        }
        DiscreteProblem::Global(GlobalProblem { equalities: Some(Equalities { G, b }), .. }) => {
            *G = G.select_columns(&kept);
            *b = chosen(b);
        }
        _ => {}
    }
    Ok(Independent { problem: Cow::Owned(fewer), kept, of })
}

/// A row after elimination of those before it, over its pivot.
struct Eliminated {
    pivot: u32,
    row: Vec<(u32, f64)>,
    rhs: f64,
}

/// Gaussian elimination of the constraints `rows x + rhs = 0` one after the other, each with its largest remaining
/// coefficient as pivot: those that do not vanish.
fn kept(rows: &Csr, rhs: &[f64]) -> Result<Vec<u32>, Error> {
    let none = usize::MAX;
    let mut pivot_of = vec![none; rows.cols];
    let mut eliminated: Vec<Eliminated> = Vec::new();
    let (mut dense, mut kept) = (vec![0.0; rows.cols], Vec::new());
    for (i, &given) in rhs.iter().enumerate() {
        let (columns, values) = rows.row(i);
        let mut touched: BTreeSet<u32> = columns.iter().copied().collect();
        columns.iter().zip(values).for_each(|(&j, &v)| dense[j as usize] = v);
        let mut b = given;
        let (size, mut terms) = (norm(values), b.abs());
        let mut next: BTreeSet<usize> = columns.iter().map(|&j| pivot_of[j as usize]).filter(|&k| k != none).collect();
        while let Some(k) = next.pop_first() {
            let Eliminated { pivot, row, rhs } = &eliminated[k];
            let factor = dense[*pivot as usize];
            for &(j, v) in row {
                dense[j as usize] -= factor * v;
                if touched.insert(j) {
                    next.extend(Some(pivot_of[j as usize]).filter(|&l| l != none && l > k));
                }
            }
            b -= factor * rhs;
            terms = terms.max((factor * rhs).abs());
        }
        let largest = touched
            .iter()
            .copied()
            .reduce(|a, j| if dense[j as usize].abs() > dense[a as usize].abs() { j } else { a });
        match largest.filter(|&j| dense[j as usize].abs() > ZERO * size) {
            Some(pivot) => {
                let scale = dense[pivot as usize];
                let row = touched.iter().map(|&j| (j, dense[j as usize] / scale)).filter(|e| e.1 != 0.0).collect();
                pivot_of[pivot as usize] = eliminated.len();
                eliminated.push(Eliminated { pivot, row, rhs: b / scale });
                kept.push(i as u32);
            }
            None if b.abs() > CONTRADICTS * terms => {
                let what = format!("bilateral constraint {i} contradicts the ones before it (by {b:.1e})");
                return Err(Error::new("b", what, "leave it out, or correct its right-hand side"));
            }
            None => {}
        }
        touched.iter().for_each(|&j| dense[j as usize] = 0.0);
    }
    Ok(kept)
}
