use crate::linalg::norm;

/// How far impulses `r` and velocities `u` are from solving a discrete problem with friction; see [`measure`].
///
/// With `F(rho)` the vector of all `r_a - P(r_a - rho_a û_a)`, `û` the velocity of De Saxcé
/// `(u_n + mu |u_t|, u_t)` and `P` the projection on the cone of friction:
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// `|F(1)| / |q|` (Acary, Brémond, Huber 2018).
    pub by_velocity: f64,
    /// `|F(1)| / max(|q|, |r|, |u|)`, as Siconos judges.
    pub by_largest: f64,
    /// `|F(rho)| / max(|r|, |(rho_a q_a)_a|)` with `rho_a = 3 / trace(W_aa)`: does not change with the units.
    pub invariant: f64,
    /// `max(-u_n)+` over the largest of all `|u_a|` and `|q_a|`.
    pub penetration: f64,
    /// `max(-r_n)+` over the largest of all `|r_a|` and `rho_a |q_a|`.
    pub tension: f64,
    /// `max(|r_t| - mu r_n)+` over the same.
    pub cone: f64,
    /// Sum of `r_n u_n + mu r_n |u_t| + r_t . u_t` over `|r| max(|q|, |u|)`: complementarity and the direction
    /// of slip in one number (De Saxcé & Feng 1998). Not over its own terms, which are rounding where all points stick.
    pub bipotential_gap: f64,
}

impl Measures {
    /// The largest of all.
    pub fn worst(&self) -> f64 {
        let larger = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) };
        self.all().into_iter().fold(0.0, |worst, (_, value)| larger(worst, value))
    }

    /// Whether all are at most `tolerance`.
    pub fn passed(&self, tolerance: f64) -> bool {
        self.worst() <= tolerance
    }

    /// Names and values.
    pub fn all(&self) -> [(&'static str, f64); 7] {
        [
            ("by_velocity", self.by_velocity),
            ("by_largest", self.by_largest),
            ("invariant", self.invariant),
            ("penetration", self.penetration),
            ("tension", self.tension),
            ("cone", self.cone),
            ("bipotential_gap", self.bipotential_gap),
        ]
    }
}

/// Judges the impulses `r` at velocities `u = W r + q`, all of length `dm`, point by point with the normal first.
/// `trace` holds the trace of the diagonal block of `W` at each of the `m` points; where it is not positive, the
/// largest stands in for it.
pub fn measure(dimension: usize, mu: &[f64], trace: &[f64], q: &[f64], r: &[f64], u: &[f64]) -> Measures {
    let largest_trace = trace.iter().copied().fold(0.0, f64::max);
    let parameter = |j: usize| match (trace[j] > 0.0, largest_trace > 0.0) {
        (true, _) => 3.0 / trace[j],
        (false, true) => 3.0 / largest_trace,
        (false, false) => 1.0,
    };
    let d = dimension;
    let (mut plain, mut scaled, mut offset) = (0.0, 0.0, 0.0);
    let (mut penetration, mut tension, mut outside, mut gap) = (0.0f64, 0.0f64, 0.0f64, 0.0);
    let (mut size_u, mut size_r) = (0.0f64, 0.0f64);
    for (j, &mu) in mu.iter().enumerate() {
        let (ra, ua, rho) = (&r[d * j..d * (j + 1)], &u[d * j..d * (j + 1)], parameter(j));
        plain += residual(mu, ra, ua, 1.0);
        scaled += residual(mu, ra, ua, rho);
        let at_rest = norm(&q[d * j..d * (j + 1)]);
        offset += (rho * at_rest).powi(2);
        let (friction, slip) = (norm(&ra[1..]), norm(&ua[1..]));
        penetration = penetration.max(-ua[0]);
        tension = tension.max(-ra[0]);
        outside = outside.max(friction - mu * ra[0]);
        gap += ra[0] * ua[0] + mu * ra[0] * slip + ra[1..].iter().zip(&ua[1..]).map(|(r, u)| r * u).sum::<f64>();
        // Where all points stick velocities are rounding, and where none touches impulses are.
        size_u = size_u.max(norm(ua)).max(at_rest);
        size_r = size_r.max(norm(ra)).max(rho * at_rest);
    }
    let (plain, scaled) = (plain.sqrt(), scaled.sqrt());
    Measures {
        by_velocity: ratio(plain, norm(q)),
        by_largest: ratio(plain, norm(q).max(norm(r)).max(norm(u))),
        invariant: ratio(scaled, norm(r).max(offset.sqrt())),
        penetration: ratio(penetration, size_u),
        tension: ratio(tension, size_r),
        cone: ratio(outside, size_r),
        bipotential_gap: ratio(gap.abs(), norm(r) * norm(q).max(norm(u))),
    }
}

fn ratio(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

/// `|r - P(r - rho û)|²` at one point.
fn residual(mu: f64, r: &[f64], u: &[f64], rho: f64) -> f64 {
    let slip = norm(&u[1..]);
    let step = rho * (u[0] + mu * slip);
    let n = r[0] - step;
    let t: Vec<f64> = r[1..].iter().zip(&u[1..]).map(|(r, u)| r - rho * u).collect();
    // As rho û + (y - P(y)) with y = r - rho û: where r is so large that r - rho û rounds to r, the difference of r and
    // its projection would hide û.
    let (p, factor) = excess(mu, n, norm(&t));
    let tangential = u[1..].iter().zip(&t).map(|(u, t)| (rho * u + factor * t).powi(2)).sum::<f64>();
    (step + p).powi(2) + tangential
}

/// What the projection on the cone `|t| <= mu n` takes from `(n, t)`: of its normal component, and as a factor of `t`.
fn excess(mu: f64, n: f64, t: f64) -> (f64, f64) {
    // For tension `mu * n` is -0 where there is no friction, and 0 is not above it.
    if n >= 0.0 && t <= mu * n {
        (0.0, 0.0)
    } else if mu * t <= -n {
        (n, 1.0)
    } else {
        let outside = (t - mu * n) / (1.0 + mu * mu);
        (-mu * outside, outside / t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_on_a_table_slides_sticks_or_lifts_as_the_law_says() {
        // W = 1: pressed with velocity -2, pushed sideways with 3: at mu 0.5 it slips, r = (2, -1), u = (0, 2).
        let judge = |r: [f64; 3], u: [f64; 3]| measure(3, &[0.5], &[3.0], &[-2.0, 3.0, 0.0], &r, &u);
        let right = judge([2.0, -1.0, 0.0], [0.0, 2.0, 0.0]);
        assert!(right.all().iter().all(|(_, value)| *value == 0.0), "{right:?}");
        // Friction along the slip instead of against it; too much friction; none at all; a pull.
        for wrong in [[2.0, 1.0, 0.0], [2.0, -3.0, 0.0], [2.0, 0.0, 0.0], [-1.0, 0.0, 0.0]] {
            let u = [wrong[0] - 2.0, wrong[1] + 3.0, 0.0];
            let seen = judge(wrong, u);
            assert!(seen.by_velocity > 0.1 && seen.by_largest > 0.1 && seen.invariant > 0.1, "{seen:?}");
        }
        assert!(judge([2.0, 1.0, 0.0], [0.0, 4.0, 0.0]).bipotential_gap > 0.1);
        assert!(judge([2.0, -3.0, 0.0], [0.0, 0.0, 0.0]).cone > 0.1);
    }

    #[test]
    fn a_pull_is_refused_however_small_friction_is() {
        for mu in [0.0, 1e-300, 1e-12] {
            for d in [2, 3] {
                let mut q = vec![0.0; d];
                q[0] = 1.0;
                let judge = |pull: f64| {
                    let r: Vec<f64> = q.iter().map(|q| -pull * q).collect();
                    let u: Vec<f64> = q.iter().zip(&r).map(|(q, r)| q + r).collect();
                    measure(d, &[mu], &[d as f64], &q, &r, &u)
                };
                assert_eq!(judge(0.0).worst(), 0.0);
                // The whole pull, at which nothing moves, and a small one.
                assert!(judge(1.0).by_velocity > 0.5 && judge(1.0).invariant > 0.5 && judge(1.0).tension > 0.3);
                assert!(judge(1e-6).worst() > 1e-7, "{:?}", judge(1e-6));
            }
        }
    }

    #[test]
    fn impulses_beyond_all_velocities_do_not_hide_a_penetration() {
        // At 1e20 an impulse less a velocity of one is the impulse itself.
        let seen = measure(3, &[0.5], &[3.0], &[-1.0, 0.0, 0.0], &[1e20, 0.0, 0.0], &[-1.0, 0.0, 0.0]);
        assert!(seen.by_velocity > 0.5 && seen.worst() > 0.5, "{seen:?}");
    }

    #[test]
    fn the_projection_is_the_nearest_point_of_the_cone() {
        for (n, t) in [(1.0, 3.0), (-0.2, 1.0), (-3.0, 1.0), (2.0, 0.5)] {
            let (taken, part) = excess(0.7, n, t);
            let (p, kept) = (n - taken, 1.0 - part);
            let square = |a: f64, b: f64| (a - n).powi(2) + (b - t).powi(2);
            let found = square(p, kept * t);
            for k in 0..=2000 {
                let a = f64::from(k) * 2e-3;
                for b in [0.0, 0.3, 0.7, 0.999, 1.0] {
                    assert!(found <= square(a, 0.7 * a * b) + 1e-12, "{n} {t} {a} {b}");
                }
            }
        }
    }
}
