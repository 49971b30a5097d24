use super::frames::Point;
use crate::contact::Friction;
use crate::friction::PointState;
use crate::friction::law::{bound, slope};
use crate::linalg::multigrid::Condition;

/// What the law asks of a contact point at the present iterate: which components are held, and the friction of a
/// slipping one, linearised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Set {
    pub state: PointState,
    pub condition: Condition,
    /// Friction on a slipping point without what the spring adds, newton.
    pub friction: [f64; 2],
}

/// The law at one point, in its frame.
pub(super) struct Law {
    pub friction: Friction,
    /// What held components are held at: the gap, and the tangential displacement slip is measured from; length.
    pub rest: [f64; 3],
    /// Force per length that turns displacements into forces in the tests of the law.
    pub parameter: f64,
}

/// Friction turns at least so much of itself: where it is close to the augmented force the spring that turns it would
/// grow beyond bounds.
const TURN: f64 = 0.999;

/// The set of a point from its multipliers and displacements `[n, t1, t2]` in its frame.
///
/// The radius of the friction disc takes penetration into account, but not the opening of a point that still bears.
/// At a slipping point the law is linearised in the direction of slip: with `a = lambda_t + c s`, `s` the slip, and
/// `q = bound / |a|` the new friction is `bound a / |a|` plus `c q / (1 - q)` times the slip across it.
pub(super) fn set(law: &Law, point: &Point, lambda: [f64; 3], u: [f64; 3]) -> Set {
    let c = law.parameter;
    let beyond: [f64; 3] = std::array::from_fn(|r| u[r] - law.rest[r]);
    let a = [1, 2].map(|r| if point.live[r] { lambda[r] + c * beyond[r] } else { 0.0 });
    let bonded = law.friction == Friction::Bonded;
    let active = bonded || (point.live[0] && lambda[0] + c * beyond[0] > 0.0);
    let normal = if active { lambda[0] + c * beyond[0].max(0.0) } else { 0.0 };
    let limit = bound(law.friction, normal);
    let length = a[0].hypot(a[1]);
    let sticks = limit > 0.0 && length <= limit;
    let mut set = Set {
        state: match (active || limit > 0.0, sticks) {
            (_, true) => PointState::Stick,
            (true, false) => PointState::Slip,
            (false, false) => PointState::Open,
        },
        condition: Condition {
            held: [active && point.live[0], sticks && point.live[1], sticks && point.live[2]],
            spring: [[0.0; 3]; 3],
            follows: [0.0; 2],
        },
        friction: [0.0; 2],
    };
    if !sticks && limit > 0.0 {
        let d = a.map(|a| a / length);
        set.friction = d.map(|d| limit * d);
        // With the coefficient along the slip friction grows with the force that holds the normal component.
        set.condition.follows = d.map(|d| slope(law.friction, normal) * d);
        if point.live[1] && point.live[2] {
            let q = (limit / length).min(TURN);
            let across = [-d[1], d[0]];
            for r in 0..2 {
                for s in 0..2 {
                    set.condition.spring[r + 1][s + 1] = c * q / (1.0 - q) * across[r] * across[s];
                }
            }
        }
    }
    set
}

/// Whether a point slips against where it slipped before: on the way its slip was zero. Friction that turns round every cycle
/// is resisted by nothing, and where the body gives way more than its point alone the test of the law overshoots each time.
pub(super) fn reverses(before: &Set, now: &Set) -> bool {
    let slip = before.state == PointState::Slip && now.state == PointState::Slip;
    slip && before.friction[0] * now.friction[0] + before.friction[1] * now.friction[1] < 0.0
}

/// The same point while it sticks; the law decides again after the next cycle.
pub(super) fn halted(now: &Set, live: [bool; 3]) -> Set {
    let held = [now.condition.held[0], live[1], live[2]];
    Set { state: PointState::Stick, condition: Condition { held, ..Condition::default() }, friction: [0.0; 2] }
}

/// The set of a point that touches and, if there is friction at all, sticks.
pub(super) fn stuck(law: &Law, point: &Point) -> Set {
    let rough = bound(law.friction, f64::MAX) > 0.0;
    let held = [point.live[0], rough && point.live[1], rough && point.live[2]];
    let state = if rough { PointState::Stick } else { PointState::Slip };
    Set { state, condition: Condition { held, ..Condition::default() }, friction: [0.0; 2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slips(friction: [f64; 2]) -> Set {
        let condition = Condition { held: [true, false, false], follows: [0.1, 0.2], ..Condition::default() };
        Set { state: PointState::Slip, condition, friction }
    }

    #[test]
    fn a_slip_turns_round_by_more_than_a_right_angle_and_is_halted_at_the_rest() {
        let before = slips([3.0, 1.0]);
        assert!(reverses(&before, &slips([-2.0, 0.5])) && !reverses(&before, &slips([-0.5, 2.0])));
        let halted = halted(&slips([-2.0, 0.5]), [true, true, false]);
        assert!(!reverses(&before, &halted) && halted.state == PointState::Stick);
        // A component that cannot move is not held, and nothing else acts on those that are.
        let held = Condition { held: [true, true, false], ..Condition::default() };
        assert_eq!((halted.condition, halted.friction), (held, [0.0; 2]));
    }
}
