//! The law at one contact point: its state, the projection on what it admits, the residual and the linearisation.
//!
//! All take the multiplier `lambda` and `v = [gap - N u; -slip]` of the point, three components each, the normal one
//! first, and a parameter `r > 0` (force per length) that makes forces of displacements. With the augmented multiplier
//! `a = lambda - r v` the law holds exactly where `lambda` is the projection of `a` (Alart & Curnier 1991).

use crate::contact::{ContactProblem, Friction};

/// A vector at one point: the normal component, then the two tangential ones.
pub(crate) type V3 = [f64; 3];

/// Where a point stands with the law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointState {
    /// No contact.
    Open,
    /// In contact, friction below its bound.
    Stick,
    /// In contact, friction at its bound; so is every point in contact that has no friction.
    Slip,
}

impl PointState {
    /// All states in the order of their codes.
    pub const ALL: [PointState; 3] = [PointState::Open, PointState::Stick, PointState::Slip];

    /// The number that stands for the state in files: 0 open, 1 stick, 2 slip.
    pub fn code(self) -> u8 {
        self as u8
    }

    /// The state of a code.
    pub fn of_code(code: usize) -> Option<PointState> {
        PointState::ALL.get(code).copied()
    }

    /// How many points are open, stick and slip.
    pub fn count(states: &[PointState]) -> [usize; 3] {
        PointState::ALL.map(|state| states.iter().filter(|&&s| s == state).count())
    }
}

/// Thresholds of the law as equations.
struct Threshold;

impl Threshold {
    /// The parameter `r` over the local stiffness. Near one, cases rich in sticking points cycle; far below, points leave and
    /// enter contact late (bricks of tests/counts.rs).
    const PARAMETER: f64 = 0.1;
    /// Equation across the direction of slip: where the bound is below this part of the augmented friction, the point does
    /// not feel its slip.
    const NO_BOUND: f64 = 1e-12;
}

/// The parameter `r` of each point, force per length: a tenth of the mean stiffness of its nonempty rows, and for a
/// point without any a tenth of the largest. `stiffness` is that of each row, `3m`, zero for an empty one.
pub(crate) fn parameters(problem: &ContactProblem, stiffness: &[f64]) -> Vec<f64> {
    let largest = stiffness.iter().fold(f64::MIN_POSITIVE, |a, &b| a.max(b));
    let local = |j: usize| {
        let rows = problem.rows(j).map(|i| stiffness[i]);
        let nonempty = rows.iter().filter(|&&k| k > 0.0).count();
        if nonempty > 0 { rows.iter().sum::<f64>() / nonempty as f64 } else { largest }
    };
    (0..problem.points()).map(|j| Threshold::PARAMETER * local(j)).collect()
}

/// The derivative of its [`bound`](Friction::bound) by the normal force; zero where a limit rules.
pub(crate) fn slope(friction: Friction, a_n: f64) -> f64 {
    match friction {
        Friction::Coulomb { coefficient } | Friction::Cohesive { coefficient, .. } => coefficient,
        Friction::Limited { coefficient, limit } if coefficient * a_n.max(0.0) < limit => coefficient,
        _ => 0.0,
    }
}

/// The law with the bound that friction has at the normal force `lambda_n`, newton; itself where its bound does not
/// depend on the normal force.
pub(crate) fn frozen(friction: Friction, lambda_n: f64) -> Friction {
    match friction {
        Friction::Coulomb { .. } | Friction::Limited { .. } | Friction::Cohesive { .. } => {
            Friction::Given { slip_bound: friction.bound(lambda_n) }
        }
        Friction::None | Friction::Given { .. } | Friction::Bonded => friction,
    }
}

/// `lambda - r v`.
pub(crate) fn augmented(lambda: V3, v: V3, r: f64) -> V3 {
    std::array::from_fn(|i| lambda[i] - r * v[i])
}

/// The state of a point with the augmented multiplier `a`.
pub(crate) fn state(friction: Friction, a: V3) -> PointState {
    match friction {
        Friction::Bonded => PointState::Stick,
        _ if a[0] <= 0.0 => PointState::Open,
        _ if a[1].hypot(a[2]) < friction.bound(a[0]) => PointState::Stick,
        _ => PointState::Slip,
    }
}

/// The projection of `a` on what the law admits, newton; the radius of the friction disc is that of the normal force
/// `a[0]`. Of a multiplier itself: without tension, and without the friction beyond its bound.
pub(crate) fn projection(friction: Friction, a: V3) -> V3 {
    if friction == Friction::Bonded {
        return a;
    }
    let (limit, length) = (friction.bound(a[0]), a[1].hypot(a[2]));
    let shrink = if length > limit { limit / length } else { 1.0 };
    [a[0].max(0.0), a[1] * shrink, a[2] * shrink]
}

/// The residual of Alart & Curnier (1991), newton: `lambda` less the [`projection`] of `lambda - r v`, without the
/// cancellation where the two agree but for `r v`.
pub(crate) fn residual(friction: Friction, lambda: V3, v: V3, r: f64) -> V3 {
    let a = augmented(lambda, v, r);
    if friction == Friction::Bonded {
        return v.map(|v| r * v);
    }
    let (limit, length) = (friction.bound(a[0]), a[1].hypot(a[2]));
    let normal = if a[0] > 0.0 { r * v[0] } else { lambda[0] };
    if length <= limit {
        return [normal, r * v[1], r * v[2]];
    }
    let shrink = limit / length;
    [normal, lambda[1] - shrink * a[1], lambda[2] - shrink * a[2]]
}

/// The point of the cone `|x_t| <= mu x_n` that is nearest to `x`.
pub(crate) fn nearest_in_cone(mu: f64, x: V3) -> V3 {
    let t = x[1].hypot(x[2]);
    // The sign is asked for itself: without friction `mu * x[0]` is -0 for tension, which is not below 0.
    if x[0] >= 0.0 && t <= mu * x[0] {
        x
    } else if mu * t <= -x[0] {
        [0.0; 3]
    } else {
        let n = (mu * t + x[0]) / (1.0 + mu * mu);
        [n, mu * n * x[1] / t, mu * n * x[2] / t]
    }
}

/// The law of one point linearised: the change of its multiplier is `known + columns' y`, and the first `unknowns`
/// numbers `y` obey `rows dv + compliance y = rhs`, with `dv` the change of its `v`.
///
/// An open point loses its multiplier. In contact `v_n + dv_n = 0`; where the point sticks the same holds for the
/// tangential components. Where it slips along `e = a_t / |a_t|` under the bound `g`, friction along `e` is `g`, which
/// follows the normal force; across `e`, with `q = g / |a_t|`, `q dv_x + (1 - q)/r dlambda_x = -v_x`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Linearisation {
    pub known: V3,
    pub unknowns: usize,
    pub columns: [V3; 3],
    pub rows: [V3; 3],
    pub compliance: V3,
    pub rhs: V3,
    /// The factor that makes equation `k` the residual over `r`; one but across a direction of slip.
    pub weight: V3,
    /// The direction of slip, and how fast friction along it grows with the normal force.
    pub slip: Option<([f64; 2], f64)>,
}

const UNITS: [V3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl Linearisation {
    const NOTHING: Linearisation = Linearisation {
        known: [0.0; 3],
        unknowns: 0,
        columns: [[0.0; 3]; 3],
        rows: [[0.0; 3]; 3],
        compliance: [0.0; 3],
        rhs: [0.0; 3],
        weight: [1.0; 3],
        slip: None,
    };

    /// A point whose multipliers are unknown and whose `v` is to change by nothing but `-compliance dlambda`.
    pub(crate) fn free(compliance: f64) -> Self {
        Linearisation {
            unknowns: 3,
            columns: UNITS,
            rows: UNITS,
            compliance: [compliance; 3],
            ..Linearisation::NOTHING
        }
    }

    /// Linearises the law at `lambda` and `v`. `has_row` is false for a component that has no row of `B`. Where the friction
    /// of a slipping point grows faster than `largest_slope` with the normal force, it keeps its present bound.
    pub(crate) fn new(friction: Friction, r: f64, has_row: [bool; 3], largest_slope: f64, lambda: V3, v: V3) -> Self {
        let mut at = Linearisation::NOTHING;
        let component = |at: &mut Linearisation, i: usize| {
            if has_row[i] {
                at.push(UNITS[i], UNITS[i], -v[i]);
            }
        };
        if friction == Friction::Bonded {
            (0..3).for_each(|i| component(&mut at, i));
            return at;
        }
        let a = augmented(lambda, v, r);
        let touches = a[0] > 0.0 && has_row[0];
        let (limit, length) = (friction.bound(a[0]), a[1].hypot(a[2]));
        if touches {
            component(&mut at, 0);
        } else {
            at.known[0] = -lambda[0];
        }
        if limit <= 0.0 {
            (at.known[1], at.known[2]) = (-lambda[1], -lambda[2]);
        } else if length <= limit {
            (1..3).for_each(|i| component(&mut at, i));
        } else {
            let e = [a[1] / length, a[2] / length];
            let slope = Some(slope(friction, a[0])).filter(|&s| touches && s <= largest_slope).unwrap_or(0.0);
            if slope > 0.0 {
                at.columns[0] = [1.0, slope * e[0], slope * e[1]];
            }
            let (along, across) = (lambda[1] * e[0] + lambda[2] * e[1], lambda[2] * e[0] - lambda[1] * e[1]);
            let at_lambda = match friction {
                Friction::Cohesive { cohesion, .. } => cohesion + slope * lambda[0],
                _ => slope * lambda[0],
            };
            let change = if slope > 0.0 { at_lambda } else { limit } - along;
            (at.known[1], at.known[2]) = (change * e[0], change * e[1]);
            at.slip = Some((e, slope));
            let (turn, q) = ([0.0, -e[1], e[0]], limit / length);
            if q <= Threshold::NO_BOUND {
                (at.known[1], at.known[2]) = (at.known[1] - across * turn[1], at.known[2] - across * turn[2]);
            } else if has_row[1] && has_row[2] {
                at.compliance[at.unknowns] = (1.0 - q) / (q * r);
                at.weight[at.unknowns] = q;
                // `a` has no component across `e`: lambda_x = r v_x.
                at.push(turn, turn, -across / (q * r));
            }
        }
        at
    }

    fn push(&mut self, column: V3, row: V3, rhs: f64) {
        let k = self.unknowns;
        (self.columns[k], self.rows[k], self.rhs[k]) = (column, row, rhs);
        self.unknowns += 1;
    }

    /// The same where `v` also changes by `compliance` times the change of the multiplier.
    pub(crate) fn with_compliance(mut self, compliance: f64) -> Self {
        self.compliance[..self.unknowns].iter_mut().for_each(|c| *c += compliance);
        self
    }

    /// The change of the multiplier for `y`.
    pub(crate) fn change(&self, y: &[f64]) -> V3 {
        let mut d = self.known;
        y.iter().zip(&self.columns).for_each(|(y, c)| (0..3).for_each(|i| d[i] += y * c[i]));
        d
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [Friction; 6] = [
        Friction::None,
        Friction::Given { slip_bound: 2.0 },
        Friction::Coulomb { coefficient: 0.5 },
        Friction::Limited { coefficient: 0.5, limit: 1.5 },
        Friction::Cohesive { coefficient: 0.5, cohesion: 0.8, tension: 0.0 },
        Friction::Bonded,
    ];

    #[test]
    fn the_residual_vanishes_exactly_where_the_law_holds() {
        let coulomb = Friction::Coulomb { coefficient: 0.5 };
        let holds = |friction, lambda: V3, v: V3| residual(friction, lambda, v, 3.0).iter().all(|g| g.abs() < 1e-14);
        // v = [gap, -slip]: friction points along the slip, against v.
        assert!(holds(coulomb, [4.0, 2.0, 0.0], [0.0, -7.0, 0.0]), "slip");
        assert!(!holds(coulomb, [4.0, 2.0, 0.0], [0.0, 7.0, 0.0]), "friction that pushes along");
        assert!(holds(coulomb, [4.0, 1.0, -1.0], [0.0, 0.0, 0.0]), "stick");
        assert!(!holds(coulomb, [4.0, 1.9, 1.9], [0.0, 0.0, 0.0]), "outside the cone");
        assert!(holds(coulomb, [0.0, 0.0, 0.0], [0.3, 5.0, -2.0]), "open");
        assert!(!holds(coulomb, [0.0, 0.0, 0.0], [-0.3, 0.0, 0.0]), "penetration");
        assert!(!holds(coulomb, [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]), "tension");
        assert!(holds(Friction::Given { slip_bound: 2.0 }, [0.0, 0.0, -2.0], [1.0, 0.0, 9.0]), "given, even if open");
        let cohesive = Friction::Cohesive { coefficient: 0.5, cohesion: 1.0, tension: 0.0 };
        assert!(holds(cohesive, [4.0, 3.0, 0.0], [0.0, -7.0, 0.0]), "slip against friction and cohesion");
        assert!(holds(cohesive, [0.0, 0.0, 0.0], [0.3, 5.0, -2.0]), "no shear across a gap");
        assert!(!holds(cohesive, [0.0, 0.0, -1.0], [0.3, 0.0, 9.0]), "cohesion across a gap");
        assert!(holds(Friction::Bonded, [-1.0, 80.0, 0.0], [0.0, 0.0, 0.0]), "tied");
    }

    /// Points of every state, none on the border of two.
    fn points() -> impl Iterator<Item = (V3, V3)> {
        (0..60).map(|k| {
            let x = |i: usize| (1.3 * (6 * k + i) as f64).sin();
            ([2.0 + 2.0 * x(0), 2.0 * x(1), 2.0 * x(2)], [x(3), x(4), x(5)])
        })
    }

    #[test]
    fn the_residual_is_the_multiplier_less_its_projection() {
        for (friction, (lambda, v)) in LAWS.into_iter().flat_map(|law| points().map(move |p| (law, p))) {
            let image = projection(friction, augmented(lambda, v, 0.7));
            let found = residual(friction, lambda, v, 0.7);
            assert!((0..3).all(|i| (found[i] - (lambda[i] - image[i])).abs() < 1e-14), "{friction:?} {lambda:?} {v:?}");
        }
    }

    #[test]
    fn the_linearisation_is_the_derivative_of_the_residual() {
        // With dlambda = known + columns y and dv = rhs' - compliance y on the rows, residual + derivative vanishes.
        const STEP: f64 = 1e-6;
        let mut seen = [0; 4];
        for (friction, (lambda, v)) in LAWS.into_iter().flat_map(|law| points().map(move |p| (law, p))) {
            let r = 0.7;
            let at = Linearisation::new(friction, r, [true; 3], f64::INFINITY, lambda, v);
            seen[at.unknowns] += 1;
            let y = [0.3, -0.2, 0.5];
            let d = at.change(&y[..at.unknowns]);
            // A change of v that obeys the equations: the rows are orthonormal.
            let mut dv = [0.4, -0.6, 0.1];
            for (k, y) in y.iter().enumerate().take(at.unknowns) {
                let row = at.rows[k];
                let lacks = at.rhs[k] - at.compliance[k] * y - (0..3).map(|i| row[i] * dv[i]).sum::<f64>();
                (0..3).for_each(|i| dv[i] += lacks * row[i]);
            }
            let moved = |t: f64| {
                let along = |x: V3, d: V3| std::array::from_fn(|i| x[i] + t * d[i]);
                residual(friction, along(lambda, d), along(v, dv), r)
            };
            let (here, before, after) = (moved(0.0), moved(-STEP), moved(STEP));
            for i in 0..3 {
                let derivative = (after[i] - before[i]) / (2.0 * STEP);
                assert!((here[i] + derivative).abs() < 1e-7, "{friction:?} {lambda:?} {v:?}: {here:?} {derivative}");
            }
        }
        assert!(seen.iter().all(|&n| n > 3), "{seen:?}");
    }

    #[test]
    fn states_have_their_codes() {
        for (code, state) in PointState::ALL.into_iter().enumerate() {
            assert_eq!((state.code() as usize, PointState::of_code(code)), (code, Some(state)));
        }
        assert_eq!(PointState::of_code(3), None);
    }
}
