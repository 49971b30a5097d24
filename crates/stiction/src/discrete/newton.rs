use super::V3;
use super::blocks::moved;
use super::law::{Linearised, residual_norm};
use super::system::System;

/// The problem with a proximal term: `u = W r + alpha (r - centre) + q`.
pub struct Regular<'a> {
    pub system: &'a dyn System,
    pub alpha: f64,
    pub centre: &'a [V3],
}

/// Where Newton's method ended.
pub struct End {
    pub r: Vec<V3>,
    pub converged: bool,
    pub steps: usize,
}

const MAX_STEPS: usize = 30;
/// The residual is to fall below the largest of so many last ones.
const MEMORY: usize = 4;
const DECREASE: f64 = 1e-4;
const SHORTEST: f64 = 1e-2;
/// Full steps taken although the line search found none: they leave cycles that no short step leaves.
const LEAPS: usize = 3;

impl Regular<'_> {
    fn velocity(&self, r: &[V3]) -> Vec<V3> {
        let mut u = self.system.velocity(r);
        for (u, (r, c)) in u.iter_mut().zip(r.iter().zip(self.centre)) {
            (0..3).for_each(|i| u[i] += self.alpha * (r[i] - c[i]));
        }
        u
    }

    /// Semismooth Newton method on the residual of Alart and Curnier (1991) with a non-monotone line search (Grippo,
    /// Lampariello & Lucidi 1986), from `start` until the residual is at most `target`; the best point is returned.
    pub fn newton(&self, start: Vec<V3>, target: f64) -> End {
        let mu = self.system.mu();
        let mut r = start;
        let mut u = self.velocity(&r);
        let mut residual = residual_norm(mu, &r, &u);
        let mut best = (residual, r.clone());
        let (mut last, mut leaps, mut steps) = (vec![residual], 0, 0);
        while steps < MAX_STEPS {
            if residual <= target {
                return End { r, converged: true, steps };
            }
            let laws: Vec<Linearised> = (0..r.len()).map(|a| Linearised::new(mu[a], &r[a], &u[a])).collect();
            let Some(d) = self.system.step(self.alpha, &laws) else { break };
            steps += 1;
            let reference = last.iter().rev().take(MEMORY).copied().fold(0.0, f64::max);
            let falls = |residual: f64, length: f64| residual <= (1.0 - DECREASE * length) * reference;
            let mut length = 1.0;
            let (mut next, mut next_u, mut next_residual) = self.at(&r, length, &d);
            while !falls(next_residual, length) && length > SHORTEST {
                length *= 0.5;
                (next, next_u, next_residual) = self.at(&r, length, &d);
            }
            if !falls(next_residual, length) {
                leaps += 1;
                if leaps > LEAPS {
                    break;
                }
                (next, next_u, next_residual) = self.at(&r, 1.0, &d);
                last.clear();
            }
            (r, u, residual) = (next, next_u, next_residual);
            if !residual.is_finite() {
                break;
            }
            last.push(residual);
            if residual < best.0 {
                best = (residual, r.clone());
            }
        }
        End { converged: best.0 <= target, r: best.1, steps }
    }

    fn at(&self, r: &[V3], length: f64, d: &[V3]) -> (Vec<V3>, Vec<V3>, f64) {
        let next = moved(r, length, d);
        let u = self.velocity(&next);
        let residual = residual_norm(self.system.mu(), &next, &u);
        (next, u, residual)
    }
}
