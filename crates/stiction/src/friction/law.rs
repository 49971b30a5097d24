use crate::contact::Friction;

/// Where a point stands with the law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointState {
    Open,
    Stick,
    Slip,
}

/// The largest friction at a point whose augmented normal force is `a_n`, newton.
pub(in crate::friction) fn bound(friction: Friction, a_n: f64) -> f64 {
    match friction {
        Friction::None => 0.0,
        Friction::Given { slip_bound } => slip_bound,
        Friction::Coulomb { coefficient } => coefficient * a_n.max(0.0),
        Friction::Limited { coefficient, limit } => (coefficient * a_n.max(0.0)).min(limit),
        Friction::Bonded => f64::INFINITY,
    }
}

/// The derivative of [`bound`] by the normal force where friction follows it, zero where a limit rules.
pub(in crate::friction) fn slope(friction: Friction, a_n: f64) -> f64 {
    match friction {
        Friction::Coulomb { coefficient } => coefficient,
        Friction::Limited { coefficient, limit } if coefficient * a_n.max(0.0) < limit => coefficient,
        _ => 0.0,
    }
}

/// The law with the bound that friction has at the normal force `lambda_n`, newton.
pub(in crate::friction) fn frozen(friction: Friction, lambda_n: f64) -> Friction {
    match friction {
        Friction::Coulomb { .. } | Friction::Limited { .. } => {
            Friction::Given { slip_bound: bound(friction, lambda_n) }
        }
        Friction::None | Friction::Given { .. } | Friction::Bonded => friction,
    }
}

/// The state of one point from its augmented multiplier `a = lambda - r v`, `v = [gap - N u; -slip]`.
pub(in crate::friction) fn state(friction: Friction, a: [f64; 3]) -> PointState {
    match friction {
        Friction::Bonded => PointState::Stick,
        _ if a[0] <= 0.0 => PointState::Open,
        _ if a[1].hypot(a[2]) < bound(friction, a[0]) => PointState::Stick,
        _ => PointState::Slip,
    }
}

/// States of all points; `v = [gap - N u; -slip]`, `r` one positive number a point, force per length. Points in
/// contact without friction count as slipping.
pub fn states(friction: &[Friction], lambda: &[f64], v: &[f64], r: &[f64]) -> Vec<PointState> {
    (0..friction.len()).map(|j| state(friction[j], augmented(lambda, v, r, j))).collect()
}

/// `lambda - r v` at point `j`.
pub(in crate::friction) fn augmented(lambda: &[f64], v: &[f64], r: &[f64], j: usize) -> [f64; 3] {
    let m = r.len();
    [j, m + j, 2 * m + j].map(|i| lambda[i] - r[j] * v[i])
}

/// The projection of `lambda - r v` on what the law admits, newton, length `3m`; the radius of a friction disc is that of
/// the augmented normal force.
pub(in crate::friction) fn projection(friction: &[Friction], lambda: &[f64], v: &[f64], r: &[f64]) -> Vec<f64> {
    let m = r.len();
    let mut p = vec![0.0; 3 * m];
    for (j, &law) in friction.iter().enumerate() {
        let a = augmented(lambda, v, r, j);
        let projected = if law == Friction::Bonded {
            a
        } else {
            let (limit, length) = (bound(law, a[0]), a[1].hypot(a[2]));
            let shrink = if length > limit { limit / length } else { 1.0 };
            [a[0].max(0.0), a[1] * shrink, a[2] * shrink]
        };
        [j, m + j, 2 * m + j].into_iter().zip(projected).for_each(|(i, x)| p[i] = x);
    }
    p
}

/// The residual of Alart & Curnier (1991), newton, length `3m`: `lambda` less its [`projection`]. Zero exactly at
/// solutions.
pub(in crate::friction) fn residual(friction: &[Friction], lambda: &[f64], v: &[f64], r: &[f64]) -> Vec<f64> {
    let projected = projection(friction, lambda, v, r);
    lambda.iter().zip(projected).map(|(x, p)| x - p).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_residual_vanishes_exactly_where_the_law_holds() {
        let coulomb = Friction::Coulomb { coefficient: 0.5 };
        let holds = |friction, lambda: [f64; 3], v: [f64; 3]| {
            residual(&[friction], &lambda, &v, &[3.0]).iter().all(|g| g.abs() < 1e-14)
        };
        // v = [opening, -slip]: friction points along the slip, against v.
        assert!(holds(coulomb, [4.0, 2.0, 0.0], [0.0, -7.0, 0.0]), "slip");
        assert!(!holds(coulomb, [4.0, 2.0, 0.0], [0.0, 7.0, 0.0]), "friction that pushes along");
        assert!(holds(coulomb, [4.0, 1.0, -1.0], [0.0, 0.0, 0.0]), "stick");
        assert!(!holds(coulomb, [4.0, 1.9, 1.9], [0.0, 0.0, 0.0]), "outside the cone");
        assert!(holds(coulomb, [0.0, 0.0, 0.0], [0.3, 5.0, -2.0]), "open");
        assert!(!holds(coulomb, [0.0, 0.0, 0.0], [-0.3, 0.0, 0.0]), "penetration");
        assert!(!holds(coulomb, [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]), "tension");
        assert!(holds(Friction::Given { slip_bound: 2.0 }, [0.0, 0.0, -2.0], [1.0, 0.0, 9.0]), "given, even if open");
        assert!(holds(Friction::Bonded, [-1.0, 80.0, 0.0], [0.0, 0.0, 0.0]), "tied");
    }
}
