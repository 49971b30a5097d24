use super::dual_system::DualSystem;
use crate::contact::ContactProblem;
use crate::dual::{Dual, Inverse};
use crate::friction::law::{Linearisation, frozen, parameters, slope};
use crate::friction::solution::Solution;
use crate::friction::system::{System, by_component, by_point};
use crate::friction::uniqueness::{CoulombFacts, Threshold, bound, growth, largest_coefficient};
use crate::linalg::largest_eigenvalue;

/// Estimates the contraction of `g -> F lambda_n(g)` by power steps, each a linearised problem with given friction,
/// and the uniqueness bound `1 / sqrt(lmax(Q_tt) lmax((Q⁻¹)_nn))`.
///
/// The bound follows from the monotonicity of the normal law and of friction in the slip: two solutions `i` with
/// bounds `g_i` obey `|u_1 - u_2|_K <= |g_1 - g_2| sqrt(lmax(Q_tt))` and
/// `|lambda_n| <= sqrt(lmax((Q⁻¹)_nn)) |u|_K`, so below it the map contracts. Both eigenvalues enter as upper
/// estimates (Ritz value plus residual), and `Q⁻¹` by an upper bound of it. `None` where no friction is Coulomb's.
pub fn coulomb_facts(problem: &ContactProblem, dual: &Dual, solution: &Solution) -> Option<CoulombFacts> {
    let largest_coefficient = largest_coefficient(problem)?;
    let mut lambda = solution.lambda.clone();
    problem.to_isotropic(&mut lambda);
    let problem = &*problem.isotropic();
    let before = dual.products();
    let contraction = contraction(problem, dual, &lambda, &solution.u);
    let uniqueness_bound = uniqueness_bound(problem, dual);
    Some(CoulombFacts { contraction, uniqueness_bound, largest_coefficient, products: dual.products() - before })
}

fn contraction(problem: &ContactProblem, dual: &Dual, lambda: &[f64], u: &[f64]) -> f64 {
    let system = DualSystem::new(problem, dual, Vec::new(), dual.stop());
    let r = parameters(problem, &by_component(&system.stiffness));
    let (lambda, v) = (by_point(lambda), by_point(&problem.gap_and_slip(u)));
    let given = |j: usize| frozen(problem.contact.friction[j], lambda[j][0]);
    let law = |j: usize| Linearisation::new(given(j), r[j], system.has_row(j), 0.0, lambda[j], v[j]);
    let mut points: Vec<Linearisation> = (0..problem.points()).map(law).collect();
    let slips: Vec<(usize, [f64; 2])> =
        points.iter().enumerate().filter_map(|(j, p)| p.slip.map(|(e, _)| (j, e))).collect();
    points.iter_mut().for_each(|point| (point.known, point.rhs) = ([0.0; 3], [0.0; 3]));
    let slope = |j: usize| slope(problem.contact.friction[j], lambda[j][0]);
    let bounds = slips.iter().map(|&(j, _)| slope(j) * lambda[j][0]).collect();
    let balanced = vec![0.0; dual.floating.len()];
    growth(bounds, |g| {
        slips.iter().zip(g).for_each(|(&(j, e), g)| points[j].known = [0.0, g * e[0], g * e[1]]);
        let answer = system.solve(&lambda, &points, &balanced, Threshold::ACCURACY, Threshold::INNER_LIMIT);
        slips.iter().map(|&(j, _)| slope(j) * answer.lambda[j][0]).collect()
    })
}

fn uniqueness_bound(problem: &ContactProblem, dual: &Dual) -> Option<f64> {
    let m = problem.points();
    // The bound is over all forces; where bodies float only those in balance have an energy.
    if !rows_are_orthogonal(problem) || !dual.floating.is_empty() {
        return None;
    }
    let tangential = |x: &[f64]| {
        let full: Vec<f64> = std::iter::repeat_n(0.0, m).chain(x.iter().copied()).collect();
        dual.times(&full)[m..].to_vec()
    };
    let normal = |x: &[f64]| {
        let full: Vec<f64> = x.iter().copied().chain(std::iter::repeat_n(0.0, 2 * m)).collect();
        dual.approximate_inverse(&full, Inverse::Dirichlet)[..m].to_vec()
    };
    let q = largest_eigenvalue(2 * m, tangential, Threshold::ROUGH, Threshold::TANGENTIAL_LIMIT);
    let s = largest_eigenvalue(m, normal, Threshold::ROUGH, Threshold::NORMAL_LIMIT);
    bound(&q, &s)
}

/// Whether `B Bᵀ` is diagonal; only then is `Dual::approximate_inverse` an upper bound of `Q⁻¹`.
fn rows_are_orthogonal(problem: &ContactProblem) -> bool {
    let by_column = problem.contact.B.transpose();
    let mut products = std::collections::BTreeMap::new();
    for j in 0..by_column.rows {
        let (rows, values) = by_column.row(j);
        for (a, &i) in rows.iter().enumerate() {
            for (b, &k) in rows.iter().enumerate().skip(a + 1) {
                *products.entry((i, k)).or_insert(0.0) += values[a] * values[b];
            }
        }
    }
    let largest = problem.contact.B.max_abs().powi(2);
    products.values().all(|p: &f64| p.abs() <= 1e-10 * largest)
}
