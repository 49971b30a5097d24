use super::V3;
use super::gradient::ROUND;
use super::monitor::Monitor;
use super::settings::Status;
use super::system::{Discrete, Shifted};
use crate::friction::law::nearest_in_cone;
use crate::friction::system::length;

/// Penalty over the local compliance.
const PENALTY: f64 = 1.0;
/// Thresholds of [`alternating_directions`]: relaxation and imbalance of Boyd et al. (2011), held against the profile of the methods
/// (docs/algebraic-profile.md).
struct Threshold;

impl Threshold {
    const RELAXATION: f64 = 1.6;
    /// The penalty changes when one residual is this many times the other, by this factor, and at most every so many rounds:
    /// each change costs a factor.
    const IMBALANCE: f64 = 10.0;
    const CHANGE: f64 = 5.0;
    const ROUNDS: usize = 2;
}

/// Alternating directions on `min 1/2 r' W r + (q + s)' r, z = r in the cones` (Boyd et al. 2011) with the term of De
/// Saxcé `s = mu |u_t|` taken anew at each step (Carpentier, Le Lidec & Montaut 2024). `W + rho` is factorised once a
/// penalty `rho`.
struct Alternating<'a> {
    system: &'a Discrete<'a>,
    solve: Shifted<'a>,
    rho: f64,
    z: Vec<V3>,
    /// Multiplier of `r = z`: minus the velocity of De Saxcé.
    y: Vec<V3>,
    /// `|r - z|` and `rho |z - z before|`.
    residuals: [f64; 2],
}

impl<'a> Alternating<'a> {
    /// From impulses `r`; `None` if `W + rho` is singular.
    fn new(system: &'a Discrete<'a>, r: &[V3], rho: f64) -> Option<Self> {
        let solve = system.shifted(rho)?;
        let y = system.velocity(r).iter().zip(system.mu).map(|(u, mu)| de_saxce(*mu, u).map(|u| -u)).collect();
        Some(Alternating { system, solve, rho, z: r.to_vec(), y, residuals: [0.0; 2] })
    }

    fn step(&mut self) {
        let (mu, q, rho) = (self.system.mu, &self.system.q, self.rho);
        let rhs: Vec<V3> = (0..mu.len())
            .map(|a| {
                let s = mu[a] * self.y[a][1].hypot(self.y[a][2]);
                let of = |i: usize| rho * self.z[a][i] - self.y[a][i] - q[a][i];
                [of(0) - s, of(1), of(2)]
            })
            .collect();
        let r = (self.solve)(&rhs);
        let (mut apart, mut moved) = (0.0, 0.0);
        for (a, r) in r.iter().enumerate() {
            let (z, y) = (self.z[a], &mut self.y[a]);
            let relaxed: V3 =
                std::array::from_fn(|i| Threshold::RELAXATION * r[i] + (1.0 - Threshold::RELAXATION) * z[i]);
            let next = nearest_in_cone(mu[a], std::array::from_fn(|i| relaxed[i] + y[i] / rho));
            for i in 0..3 {
                y[i] += rho * (relaxed[i] - next[i]);
                apart += (r[i] - next[i]).powi(2);
                moved += (next[i] - z[i]).powi(2);
            }
            self.z[a] = next;
        }
        self.residuals = [apart.sqrt(), rho * moved.sqrt()];
    }

    /// The penalty at which both residuals would be of like size, relative to impulses and velocities.
    fn better_penalty(&self) -> f64 {
        let [apart, moved] = self.residuals;
        let (apart, moved) =
            (apart / length(&self.z).max(f64::MIN_POSITIVE), moved / length(&self.y).max(f64::MIN_POSITIVE));
        if apart > Threshold::IMBALANCE * moved {
            self.rho * Threshold::CHANGE
        } else if moved > Threshold::IMBALANCE * apart {
            self.rho / Threshold::CHANGE
        } else {
            self.rho
        }
    }
}

fn de_saxce(mu: f64, u: &V3) -> V3 {
    [u[0] + mu * u[1].hypot(u[2]), u[1], u[2]]
}

/// Alternating directions until the monitor ends it.
pub(super) fn alternating_directions(system: &Discrete<'_>, r: Vec<V3>, monitor: &mut Monitor) -> Status {
    let Some(mut directions) = Alternating::new(system, &r, PENALTY) else { return Status::Stalled };
    loop {
        if let Some(status) = monitor.ends(&directions.z, directions.rho) {
            return status;
        }
        (0..ROUND).for_each(|_| directions.step());
        monitor.counts.alternations += ROUND;
        monitor.counts.iterations += 1;
        let rho = directions.better_penalty();
        if rho != directions.rho && monitor.counts.iterations.is_multiple_of(Threshold::ROUNDS) {
            let Some(solve) = system.shifted(rho) else { return Status::Stalled };
            (directions.solve, directions.rho) = (solve, rho);
        }
    }
}
