use super::frames::Point;
use crate::contact::Friction;
use crate::linalg::multigrid::Condition;

/// What the law asks of a contact point at the present iterate: which components are held, and the friction of a
/// slipping one, linearised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Set {
    pub state: State,
    pub condition: Condition,
    /// Values of the held components: the gap, and the tangential displacement slip is measured from.
    pub value: [f64; 3],
    /// Friction on a slipping point without what the spring adds, newton.
    pub friction: [f64; 2],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    Open,
    Stick,
    Slip,
}

/// The law at one point, in its frame.
pub(super) struct Law {
    pub friction: Friction,
    pub gap: f64,
    pub reference: [f64; 2],
    /// Force per length that turns displacements into forces in the tests of the law.
    pub parameter: f64,
}

/// The most of the force that its direction may carry: where friction is near the augmented force the spring that
/// turns it would grow beyond bounds.
const TURN: f64 = 0.999;

/// The set of a point from its multipliers `[n, t1, t2]` and displacements, both in its frame.
///
/// The radius of the friction disc takes penetration into account, but not the opening of a point that still bears.
/// At a slipping point the law is linearised in the direction of slip: with `a = lambda_t + c (u_t - reference)` and
/// `q = bound / |a|` the new friction is `bound a/|a|` plus `c q / (1 - q)` times the displacement across it.
pub(super) fn set(law: &Law, point: &Point, lambda: [f64; 3], u: [f64; 3]) -> Set {
    let c = law.parameter;
    let slip = [u[1] - law.reference[0], u[2] - law.reference[1]];
    let a = [1, 2].map(|r| if point.live[r] { lambda[r] + c * slip[r - 1] } else { 0.0 });
    let bonded = law.friction == Friction::Bonded;
    let active = bonded || (point.live[0] && lambda[0] + c * (u[0] - law.gap) > 0.0);
    let normal = lambda[0] + c * (u[0] - law.gap).max(0.0);
    let bound = match law.friction {
        Friction::None => 0.0,
        Friction::Given { slip_bound } => slip_bound,
        Friction::Coulomb { coefficient } if active => coefficient * normal.max(0.0),
        Friction::Coulomb { .. } => 0.0,
        Friction::Bonded => f64::INFINITY,
    };
    let length = a[0].hypot(a[1]);
    let sticks = bound > 0.0 && length <= bound;
    let held = [active && point.live[0], sticks && point.live[1], sticks && point.live[2]];
    let value = [law.gap, law.reference[0], law.reference[1]];
    let mut spring = [[0.0; 3]; 3];
    let mut friction = [0.0; 2];
    if !sticks && bound > 0.0 {
        let d = a.map(|a| a / length);
        friction = d.map(|d| bound * d);
        if point.live[1] && point.live[2] {
            let q = bound / length;
            let stiffness = c * q / (1.0 - q.min(TURN));
            let across = [-d[1], d[0]];
            for r in 0..2 {
                for s in 0..2 {
                    spring[r + 1][s + 1] = stiffness * across[r] * across[s];
                }
            }
        }
    }
    let state = match (active, sticks) {
        (_, true) => State::Stick,
        (true, false) => State::Slip,
        (false, false) if bound > 0.0 => State::Slip,
        (false, false) => State::Open,
    };
    Set { state, condition: Condition { held, spring }, value, friction }
}
