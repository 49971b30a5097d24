//! What can be said about other solutions of a problem with Coulomb friction: what the direct path and multigrid share.

use crate::contact::{ContactProblem, Friction};
use crate::linalg::{Ritz, norm};

/// What can be said about other solutions of a problem with Coulomb friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoulombFacts {
    /// Estimated spectral radius of the fixed-point map `g -> F lambda_n(g)` at the solution: below one the solution
    /// is isolated and the fixed point would converge to it.
    pub contraction: f64,
    /// The solution is unique if every friction coefficient is below this; `None` if it is not known for this `B`.
    pub uniqueness_bound: Option<f64>,
    /// The largest friction coefficient of the problem.
    pub largest_coefficient: f64,
    /// Products with `Q`, or multigrid cycles, spent.
    pub products: usize,
}

impl CoulombFacts {
    /// Whether uniqueness is proved.
    pub fn proved_unique(&self) -> bool {
        self.uniqueness_bound.is_some_and(|b| self.largest_coefficient < b)
    }
}

/// Thresholds of the two figures: a bound and an estimate, not results, which deserve no more
/// products.
pub(super) struct Threshold;

impl Threshold {
    /// Relative accuracy.
    pub(super) const ROUGH: f64 = 0.02;
    /// Residual of each linear problem over its load. With ten times as much a contraction of 0.0063 was taken for 0.0045.
    pub(super) const ACCURACY: f64 = 2e-3;
    /// Most power steps, and most products of a linear system in each.
    const POWER_STEPS: usize = 12;
    pub(super) const INNER_LIMIT: usize = 40;
    /// Most products for the largest eigenvalues of `Q_tt` and of the bound of `(Q⁻¹)_nn`.
    pub(super) const TANGENTIAL_LIMIT: usize = 60;
    pub(super) const NORMAL_LIMIT: usize = 200;
}

/// The largest coefficient of Coulomb friction, limited or not. `None` with cohesion as well, which a point loses where it
/// opens: the bounds then are no continuous map of the normal forces, and nothing is known of a fixed point.
pub(super) fn largest_coefficient(problem: &ContactProblem) -> Option<f64> {
    if problem.contact.friction.iter().any(|law| matches!(law, Friction::Cohesive { .. })) {
        return None;
    }
    problem.contact.friction.iter().filter_map(Friction::coefficient).reduce(f64::max)
}

/// The spectral radius of the linear map `change` by power steps from `g`.
pub(super) fn growth(mut g: Vec<f64>, mut change: impl FnMut(&[f64]) -> Vec<f64>) -> f64 {
    let (mut radius, mut quiet) = (0.0, 0);
    for step in 0..Threshold::POWER_STEPS {
        let size = norm(&g);
        if size == 0.0 {
            break;
        }
        g.iter_mut().for_each(|x| *x /= size);
        g = change(&g);
        let growth = norm(&g);
        // One quiet step may be the turning point of a growth that first rises and then falls.
        quiet = if step > 0 && (growth - radius).abs() <= 2.0 * Threshold::ROUGH * growth { quiet + 1 } else { 0 };
        radius = growth;
        if quiet == 2 {
            break;
        }
    }
    radius
}

/// The bound of the coefficient from the largest eigenvalues of `Q_tt` and of a bound of `(Q⁻¹)_nn`.
pub(super) fn bound(tangential: &Ritz, normal: &Ritz) -> Option<f64> {
    let product = (tangential.value + tangential.residual) * (normal.value + normal.residual);
    (product > 0.0 && product.is_finite()).then(|| 1.0 / product.sqrt())
}
