use super::V3;
use super::blocks::Blocks;

const LOCAL_STEPS: usize = 20;

/// Sweeps of nonlinear block Gauss-Seidel (Jourdan, Alart & Jean 1998): one point after the other solves its own law
/// at fixed impulses of the others, by projections on the cone of De Saxcé's form (Acary & Brogliato 2008, 13.7.4)
/// with the parameter `1 / trace W_aa`.
pub fn sweep(blocks: &Blocks, r: &mut [V3], sweeps: usize) {
    for _ in 0..sweeps {
        for a in 0..r.len() {
            let w = blocks.diagonal(a);
            let parameter = 1.0 / (w[0][0] + w[1][1] + w[2][2]).max(1.0);
            let all = blocks.row_times(a, r);
            let others: V3 = std::array::from_fn(|i| all[i] - times(w, &r[a])[i] + blocks.q[a][i]);
            let mut x = r[a];
            for _ in 0..LOCAL_STEPS {
                let own = times(w, &x);
                let u: V3 = std::array::from_fn(|i| own[i] + others[i]);
                let mu = blocks.mu[a];
                let slip = u[1].hypot(u[2]);
                x = project(
                    mu,
                    [x[0] - parameter * (u[0] + mu * slip), x[1] - parameter * u[1], x[2] - parameter * u[2]],
                );
            }
            r[a] = x;
        }
    }
}

fn times(w: &[V3; 3], x: &V3) -> V3 {
    std::array::from_fn(|i| w[i][0] * x[0] + w[i][1] * x[1] + w[i][2] * x[2])
}

/// The nearest point of the cone `|x_t| <= mu x_n`.
pub fn project(mu: f64, x: V3) -> V3 {
    let t = x[1].hypot(x[2]);
    if t <= mu * x[0] {
        x
    } else if mu * t <= -x[0] {
        [0.0; 3]
    } else {
        let n = (mu * t + x[0]) / (1.0 + mu * mu);
        [n, mu * n * x[1] / t, mu * n * x[2] / t]
    }
}
