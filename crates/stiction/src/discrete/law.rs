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

/// What a Newton step leaves open at one point: its change of impulse is `known + columns' y`, and `y` obeys
/// `rows du + softness y = rhs` with `du` its change of velocity.
#[derive(Debug, Clone)]
pub struct Linearised {
    pub known: V3,
    /// How many of the following are in use.
    pub unknowns: usize,
    pub columns: [V3; 3],
    pub rows: [V3; 3],
    pub softness: V3,
    pub rhs: V3,
}

/// A slipping point whose bound is below this part of its augmented friction does not feel its velocity.
const NO_BOUND: f64 = 1e-12;
impl Linearised {
    /// All of the impulse is open and no velocity is asked for: `W + alpha` alone.
    pub fn free() -> Self {
        let (zero, unit) = ([0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        Linearised { known: zero, unknowns: 3, columns: unit, rows: unit, softness: zero, rhs: zero }
    }

    /// The change of impulse for `y`.
    pub fn change(&self, y: &[f64]) -> V3 {
        let mut d = self.known;
        y.iter().zip(&self.columns).for_each(|(y, c)| (0..3).for_each(|i| d[i] += y * c[i]));
        d
    }

    /// Linearises the law at impulse `r` and velocity `u`: an open point loses its impulse, a sticking one its
    /// velocity; of a slipping one the normal velocity vanishes, friction follows the normal impulse along the
    /// direction of slip, and across it friction and velocity turn together.
    pub fn new(mu: f64, r: &V3, u: &V3) -> Self {
        let (zero, unit) = ([0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let none =
            Linearised { known: zero, unknowns: 0, columns: [zero; 3], rows: [zero; 3], softness: zero, rhs: zero };
        match state(mu, r, u) {
            State::Open => Linearised { known: r.map(|x| -x), ..none },
            State::Stick => Linearised { unknowns: 3, columns: unit, rows: unit, rhs: u.map(|x| -x), ..none },
            State::Slip { direction: [e1, e2], length, bound } => {
                let (along, across) = (r[1] * e1 + r[2] * e2, r[2] * e1 - r[1] * e2);
                let (follow, share) = (mu * r[0] - along, bound / length);
                let normal = Linearised {
                    known: [0.0, follow * e1, follow * e2],
                    unknowns: 1,
                    columns: [[1.0, mu * e1, mu * e2], zero, zero],
                    rows: [unit[0], zero, zero],
                    softness: zero,
                    rhs: [-u[0], 0.0, 0.0],
                };
                let turn = [0.0, -e2, e1];
                if share <= NO_BOUND {
                    let known = std::array::from_fn(|i| normal.known[i] - across * turn[i]);
                    return Linearised { known, ..normal };
                }
                Linearised {
                    unknowns: 2,
                    columns: [normal.columns[0], turn, zero],
                    rows: [unit[0], turn, zero],
                    softness: [0.0, (1.0 - share) / share, 0.0],
                    rhs: [-u[0], -across / share, 0.0],
                    ..normal
                }
            }
        }
    }
}
