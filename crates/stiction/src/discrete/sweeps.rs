use super::V3;
use super::linear::{dot, row_times};
use super::system::Discrete;
use crate::contact::Friction;
use crate::friction::law::{Linearisation, nearest_in_cone, residual};

/// Thresholds of the law at one point, held against the profile of the methods (docs/algebraic-profile.md).
struct Threshold;

impl Threshold {
    /// Newton steps at one point.
    const LOCAL_STEPS: usize = 20;
    /// A local residual of this part of its impulse and velocity is rounding.
    const LOCAL: f64 = 1e-14;
    /// Projections where Newton's method does not converge at a point.
    const PROJECTIONS: usize = 20;
    const HALVINGS: usize = 6;
}

/// Sweeps of nonlinear block Gauss-Seidel (Jourdan, Alart & Jean 1998): one point after the other solves its own law
/// at fixed impulses of the others.
///
/// `false` where `W` is not stored; `r` stays then.
pub(super) fn sweep(system: &Discrete<'_>, r: &mut [V3], sweeps: usize) -> bool {
    let Some(blocks) = system.operator.blocks() else { return false };
    for _ in 0..sweeps {
        for a in 0..r.len() {
            let w = blocks.diagonal(a);
            let all = blocks.row_times(a, r);
            let own = times(w, &r[a]);
            let others: V3 = std::array::from_fn(|i| all[i] - own[i] + system.q[a][i]);
            r[a] = point(system.mu[a], w, &others, r[a]);
        }
    }
    true
}

/// The impulse of one point at the velocity `w x + others`: Newton's method on the law of Alart and Curnier, and
/// projections where it does not converge.
fn point(mu: f64, w: &[V3; 3], others: &V3, start: V3) -> V3 {
    let velocity = |x: &V3| -> V3 {
        let own = times(w, x);
        std::array::from_fn(|i| own[i] + others[i])
    };
    let law = Friction::Coulomb { coefficient: mu };
    let size = |g: &V3| dot(g, g).sqrt();
    let (mut x, mut u) = (start, velocity(&start));
    let mut merit = size(&residual(law, x, u, 1.0));
    for _ in 0..Threshold::LOCAL_STEPS {
        if merit <= Threshold::LOCAL * (size(&x) + size(others)) {
            return x;
        }
        let Some(d) = local_step(w, &Linearisation::new(law, 1.0, [true; 3], f64::INFINITY, x, u)) else { break };
        let mut length = 1.0;
        let at = |length: f64| -> (V3, V3, f64) {
            let next = std::array::from_fn(|i| x[i] + length * d[i]);
            let u = velocity(&next);
            (next, u, size(&residual(law, next, u, 1.0)))
        };
        let mut next = at(length);
        for _ in 0..Threshold::HALVINGS {
            if next.2 < merit {
                break;
            }
            length *= 0.5;
            next = at(length);
        }
        if next.2.is_nan() || next.2 >= merit {
            break;
        }
        (x, u, merit) = next;
    }
    projected(mu, w, others, x)
}

/// Projections on the cone of De Saxcé's form (Acary & Brogliato 2008, 13.7.4) with the parameter `1 / trace W_aa`.
fn projected(mu: f64, w: &[V3; 3], others: &V3, start: V3) -> V3 {
    let parameter = 1.0 / (w[0][0] + w[1][1] + w[2][2]).max(1.0);
    let mut x = start;
    for _ in 0..Threshold::PROJECTIONS {
        let own = times(w, &x);
        let u: V3 = std::array::from_fn(|i| own[i] + others[i]);
        let slip = u[1].hypot(u[2]);
        x = nearest_in_cone(
            mu,
            [x[0] - parameter * (u[0] + mu * slip), x[1] - parameter * u[1], x[2] - parameter * u[2]],
        );
    }
    x
}

/// The Newton step of one point alone: Gaussian elimination with column pivots on at most three unknowns.
fn local_step(w: &[V3; 3], law: &Linearisation) -> Option<V3> {
    let n = law.unknowns;
    let moved = times(w, &law.known);
    let mut a = [[0.0f64; 4]; 3];
    for (k, row) in a.iter_mut().enumerate().take(n) {
        let of_w = row_times(&law.rows[k], w);
        (0..n).for_each(|l| row[l] = dot(&of_w, &law.columns[l]));
        row[k] += law.compliance[k];
        row[3] = law.rhs[k] - dot(&law.rows[k], &moved);
    }
    for k in 0..n {
        let pivot = (k..n).fold(k, |best, i| if a[i][k].abs() > a[best][k].abs() { i } else { best });
        a.swap(k, pivot);
        if a[k][k].abs() <= f64::EPSILON {
            return None;
        }
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            (0..4).for_each(|j| a[i][j] -= factor * a[k][j]);
        }
    }
    let mut y = [0.0; 3];
    for k in (0..n).rev() {
        y[k] = (a[k][3] - (k + 1..n).map(|j| a[k][j] * y[j]).sum::<f64>()) / a[k][k];
    }
    let d = law.change(&y[..n]);
    d.iter().all(|x| x.is_finite()).then_some(d)
}

fn times(w: &[V3; 3], x: &V3) -> V3 {
    std::array::from_fn(|i| dot(&w[i], x))
}
