use super::points::Point;
use crate::contact::Friction;
use crate::friction::PointState;
use crate::friction::law::slope;
use crate::linalg::multigrid::NodeConstraint;

/// The contact condition at a point: the law linearised at the present iterate. Those of all points are the active sets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ContactCondition {
    pub state: PointState,
    pub constraint: NodeConstraint,
    /// Friction force at a slipping point without the part of the spring, newton.
    pub friction: [f64; 2],
}

/// The law at one point, in its frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointLaw {
    pub friction: Friction,
    /// Values of constrained components: the gap, and the tangential displacement from which slip is measured; length.
    pub target: [f64; 3],
    /// The parameter `r` of the augmented multipliers, force per length.
    pub parameter: f64,
}

/// Largest ratio of the slip bound to the augmented tangential force in the spring of a slipping point; at one its
/// stiffness is infinite.
const LARGEST_RATIO: f64 = 0.999;

/// The contact condition from the multipliers `lambda` and displacements `u`, both `[n, t1, t2]` in the frame of the point.
///
/// The rule differs from that of `friction::law` in two places. The radius of the friction disc is that of the normal force
/// and the penetration, without the opening of a point that still bears; at the solution both vanish. And a point with given
/// friction may stick while it is open, because its tangential components are constrained without the normal one.
///
/// At a slipping point the law is linearised in the direction of slip: with `a = lambda_t + r s`, `s` the slip, and
/// `q = bound / |a|` the friction force is `bound a / |a|` plus `r q / (1 - q)` times the slip across it.
pub(super) fn contact_condition(law: &PointLaw, point: &Point, lambda: [f64; 3], u: [f64; 3]) -> ContactCondition {
    let r = law.parameter;
    let excess: [f64; 3] = std::array::from_fn(|c| u[c] - law.target[c]);
    let a = [1, 2].map(|c| if point.has_row[c] { lambda[c] + r * excess[c] } else { 0.0 });
    let bonded = law.friction == Friction::Bonded;
    let active = bonded || (point.has_row[0] && lambda[0] + r * excess[0] > 0.0);
    let normal = if active { lambda[0] + r * excess[0].max(0.0) } else { 0.0 };
    let limit = law.friction.bound(normal);
    let length = a[0].hypot(a[1]);
    let sticks = limit > 0.0 && length <= limit;
    let mut condition = ContactCondition {
        state: match (active || limit > 0.0, sticks) {
            (_, true) => PointState::Stick,
            (true, false) => PointState::Slip,
            (false, false) => PointState::Open,
        },
        constraint: NodeConstraint {
            constrained: [active && point.has_row[0], sticks && point.has_row[1], sticks && point.has_row[2]],
            spring: [[0.0; 3]; 3],
            coulomb: [0.0; 2],
        },
        friction: [0.0; 2],
    };
    if !sticks && limit > 0.0 {
        let d = a.map(|a| a / length);
        condition.friction = d.map(|d| limit * d);
        condition.constraint.coulomb = d.map(|d| slope(law.friction, normal) * d);
        if point.has_row[1] && point.has_row[2] {
            let q = (limit / length).min(LARGEST_RATIO);
            condition.constraint.spring = across(d, r * q / (1.0 - q));
        }
    }
    condition
}

/// A tangential spring of this stiffness across the unit vector `d`.
pub(super) fn across(d: [f64; 2], stiffness: f64) -> [[f64; 3]; 3] {
    let across = [-d[1], d[0]];
    let mut spring = [[0.0; 3]; 3];
    for r in 0..2 {
        for s in 0..2 {
            spring[r + 1][s + 1] = stiffness * across[r] * across[s];
        }
    }
    spring
}

/// Whether a slipping point slips against its last slip direction, by more than a right angle: in between its slip was zero.
/// Where the body is more compliant than the point alone the law overshoots, and the slip of a point that sticks in the end
/// alternates, a few per cent smaller each cycle.
pub(super) fn slip_reverses(before: &ContactCondition, now: &ContactCondition) -> bool {
    let slip = before.state == PointState::Slip && now.state == PointState::Slip;
    slip && before.friction[0] * now.friction[0] + before.friction[1] * now.friction[1] < 0.0
}

/// Forced stick after slip reversals: the condition with its tangential components constrained for one cycle, after which
/// the law decides again.
pub(super) fn forced_stick(now: &ContactCondition, has_row: [bool; 3]) -> ContactCondition {
    let constrained = [now.constraint.constrained[0], has_row[1], has_row[2]];
    let constraint = NodeConstraint { constrained, ..NodeConstraint::default() };
    ContactCondition { state: PointState::Stick, constraint, friction: [0.0; 2] }
}

/// The condition of a point that is in contact and, if it has friction, sticks.
pub(super) fn closed_condition(law: &PointLaw, point: &Point) -> ContactCondition {
    let rough = law.friction.bound(f64::MAX) > 0.0;
    let constrained = [point.has_row[0], rough && point.has_row[1], rough && point.has_row[2]];
    let state = if rough { PointState::Stick } else { PointState::Slip };
    let constraint = NodeConstraint { constrained, ..NodeConstraint::default() };
    ContactCondition { state, constraint, friction: [0.0; 2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slips(friction: [f64; 2]) -> ContactCondition {
        let constraint =
            NodeConstraint { constrained: [true, false, false], coulomb: [0.1, 0.2], ..NodeConstraint::default() };
        ContactCondition { state: PointState::Slip, constraint, friction }
    }

    #[test]
    fn a_slip_reverses_by_more_than_a_right_angle_and_is_then_forced_to_stick() {
        let before = slips([3.0, 1.0]);
        assert!(slip_reverses(&before, &slips([-2.0, 0.5])) && !slip_reverses(&before, &slips([-0.5, 2.0])));
        let forced = forced_stick(&slips([-2.0, 0.5]), [true, true, false]);
        assert!(!slip_reverses(&before, &forced) && forced.state == PointState::Stick);
        // A component without a row stays free, and friction and coupling are gone.
        let constraint = NodeConstraint { constrained: [true, true, false], ..NodeConstraint::default() };
        assert_eq!((forced.constraint, forced.friction), (constraint, [0.0; 2]));
    }
}
