use super::V3;

/// State of a point by its augmented impulse `A = r - u`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum State {
    /// `A_n <= 0`.
    Open,
    /// `|A_t| <= mu A_n`.
    Stick,
    /// Otherwise; the direction and length of `A_t`, and the bound `mu A_n`.
    Slip { direction: [f64; 2], length: f64, bound: f64 },
}

/// The state of a point with scaled impulse `r` and velocity `u`.
pub fn state(mu: f64, r: &V3, u: &V3) -> State {
    let a = [r[0] - u[0], r[1] - u[1], r[2] - u[2]];
    if a[0] <= 0.0 {
        return State::Open;
    }
    let (length, bound) = (a[1].hypot(a[2]), mu * a[0]);
    if length <= bound {
        State::Stick
    } else {
        State::Slip { direction: [a[1] / length, a[2] / length], length, bound }
    }
}

/// The residual of Alart and Curnier (1991): `r_n - (A_n)+` and `r_t - P(A_t)`, `P` the projection on the disc of
/// radius `mu (A_n)+`, in scaled quantities.
pub fn residual(mu: f64, r: &V3, u: &V3) -> V3 {
    match state(mu, r, u) {
        State::Open => *r,
        State::Stick => *u,
        State::Slip { direction, bound, .. } => [u[0], r[1] - bound * direction[0], r[2] - bound * direction[1]],
    }
}

/// Norm of the residual of all points.
pub fn residual_norm(mu: &[f64], r: &[V3], u: &[V3]) -> f64 {
    let square = |g: V3| g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
    mu.iter().zip(r.iter().zip(u)).map(|(&mu, (r, u))| square(residual(mu, r, u))).sum::<f64>().sqrt()
}
