use super::share::Share;
use crate::contact::{ContactProblem, Friction};

/// Sweeps that move a displacement out of the obstacles; one suffices where the rows of `B` are orthogonal.
const SWEEPS: usize = 50;

/// Primal energy of a displacement near `u` that keeps the constraints, less the dual energy of `lambda`; `None`
/// where some friction is Coulomb's.
///
/// For admissible `lambda` in equilibrium with `u` it bounds `1/2 |u - u*|²_K`: the dual objective is quadratic with
/// the curvature of that norm, and no primal energy is below its maximum. `u` itself may penetrate, and then its own
/// energy bounds nothing, hence the displacement `w` nearby; with `f = K u + Bᵀ lambda` the difference is
/// `1/2 |w - u|²_K + sum of lambda_n (gap - N w) + bound |s(w)| - lambda_t . s(w)`, where no term is negative.
/// Infinite where no such `w` was found. `length` is the scale of lengths.
pub(super) fn duality_gap(
    problem: &ContactProblem,
    share: &Share,
    u: &[f64],
    lambda: &[f64],
    length: f64,
) -> Option<f64> {
    let laws = &problem.contact.friction;
    let mut coulomb = [f64::from(u8::from(laws.iter().any(|law| law.coefficient().is_some())))];
    share.max(&mut coulomb);
    if coulomb[0] > 0.0 {
        return None;
    }
    let Some(w) = feasible_near(problem, share, u, length) else { return Some(f64::INFINITY) };
    let m = laws.len();
    let w = share.filled(problem, w);
    let moved: Vec<f64> = w.iter().zip(u).map(|(w, u)| w - u).collect();
    let elastic = problem.elastic.K.times(&moved);
    let own = moved.iter().zip(elastic).enumerate().filter(|(i, _)| share.has_unknown(*i));
    let mut gap = 0.5 * own.map(|(_, (x, f))| x * f).sum::<f64>();
    let opening = problem.gap_and_slip(&w);
    let across = |j: usize| problem.contact.orthotropy.as_ref().map_or(1.0, |ratios| ratios[j]);
    for (j, law) in laws.iter().enumerate().filter(|(j, _)| share.has_point(*j)) {
        gap += [j, m + j, 2 * m + j].iter().map(|&i| lambda[i] * opening[i]).sum::<f64>();
        if let Friction::Given { slip_bound } = law {
            gap += slip_bound * opening[m + j].hypot(across(j) * opening[2 * m + j]);
        }
    }
    let mut sums = [gap];
    share.sum(&mut sums);
    Some(sums[0].max(0.0))
}

/// `u` projected on one violated constraint after the other (Kaczmarz) until it keeps all of them. Ranks project on their own ones at the same
/// time, and what they do to an unknown is added.
fn feasible_near(problem: &ContactProblem, share: &Share, u: &[f64], length: f64) -> Option<Vec<f64>> {
    let m = problem.contact.friction.len();
    let mut w = u.to_vec();
    let offset: Vec<f64> = problem.contact.gap.iter().chain(&problem.contact.slip_reference).copied().collect();
    let mut largest = [offset.iter().fold(0.0, |a: f64, x| a.max(x.abs()))];
    share.max(&mut largest);
    let rounding = 1e-13 * length.max(largest[0]);
    let border = share.border(problem);
    for _ in 0..SWEEPS {
        let (mut worst, before) = ([0.0f64], w.clone());
        for (j, law) in problem.contact.friction.iter().enumerate().filter(|(j, _)| share.has_point(*j)) {
            let tied = *law == Friction::Bonded;
            for i in [j, m + j, 2 * m + j].into_iter().take(if tied { 3 } else { 1 }) {
                let (columns, values) = problem.contact.B.row(i);
                let square: f64 = values.iter().map(|b| b * b).sum();
                let jump: f64 = columns.iter().zip(values).map(|(&c, b)| b * w[c as usize]).sum();
                let excess = jump - offset[i];
                if !(excess > 0.0 || tied) || square == 0.0 && (i > j || excess <= 0.0) {
                    continue;
                }
                worst[0] = worst[0].max(excess.abs());
                columns.iter().zip(values).for_each(|(&c, b)| w[c as usize] -= b * excess / square);
            }
        }
        border.add(&before, &mut w);
        share.max(&mut worst);
        if worst[0] <= rounding {
            return Some(w);
        }
    }
    None
}
