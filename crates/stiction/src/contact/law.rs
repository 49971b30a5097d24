//! The law of friction at a point, as data: what solvers make of it is in `friction`.

/// The law of friction at one contact point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Friction {
    /// No tangential force.
    None,
    /// Given friction (Tresca): `|lambda_t| <= slip_bound`, newton, whether or not the point is in contact.
    Given {
        /// The largest tangential force, newton.
        slip_bound: f64,
    },
    /// Coulomb friction: `|lambda_t| <= coefficient * lambda_n`.
    Coulomb {
        /// The coefficient of friction.
        coefficient: f64,
    },
    /// Coulomb friction up to a limit: `|lambda_t| <= min(coefficient * lambda_n, limit)`, newton.
    Limited {
        /// The coefficient of friction.
        coefficient: f64,
        /// The largest tangential force, newton.
        limit: f64,
    },
    /// Mohr-Coulomb with a tension cut-off: `lambda_n >= -tension`; where the surfaces touch `|lambda_t| <= cohesion +
    /// coefficient * lambda_n`. A point that opens carries `lambda_n = -tension` and no shear.
    Cohesive {
        /// The coefficient of friction.
        coefficient: f64,
        /// The largest tangential force without a normal force, newton.
        cohesion: f64,
        /// The largest pull, newton; at most `cohesion / coefficient`, the apex of the cone.
        tension: f64,
    },
    /// Tied: no relative displacement in any direction, tension included.
    Bonded,
}

impl Friction {
    /// The coefficient where friction follows the normal force, up to a limit or not.
    pub fn coefficient(&self) -> Option<f64> {
        match *self {
            Friction::Coulomb { coefficient }
            | Friction::Limited { coefficient, .. }
            | Friction::Cohesive { coefficient, .. } => Some(coefficient),
            Friction::None | Friction::Given { .. } | Friction::Bonded => None,
        }
    }

    /// The largest tangential force at the normal force `normal`, newton; infinite where the point is tied.
    pub fn bound(&self, normal: f64) -> f64 {
        match *self {
            Friction::None => 0.0,
            Friction::Given { slip_bound } => slip_bound,
            Friction::Coulomb { coefficient } => coefficient * normal.max(0.0),
            Friction::Limited { coefficient, limit } => (coefficient * normal.max(0.0)).min(limit),
            // No shear crosses a gap: cohesion is where the surfaces touch.
            Friction::Cohesive { coefficient, cohesion, tension } if normal > 0.0 - tension => {
                (cohesion + coefficient * normal).max(0.0)
            }
            Friction::Cohesive { .. } => 0.0,
            Friction::Bonded => f64::INFINITY,
        }
    }

    /// As numbers, for messages: which law it is, and what it holds.
    pub(crate) fn numbers(&self) -> [f64; 4] {
        match *self {
            Friction::None => [0.0; 4],
            Friction::Given { slip_bound } => [1.0, slip_bound, 0.0, 0.0],
            Friction::Coulomb { coefficient } => [2.0, coefficient, 0.0, 0.0],
            Friction::Limited { coefficient, limit } => [3.0, coefficient, limit, 0.0],
            Friction::Cohesive { coefficient, cohesion, tension } => [4.0, coefficient, cohesion, tension],
            Friction::Bonded => [5.0, 0.0, 0.0, 0.0],
        }
    }

    /// The inverse of [`Self::numbers`].
    pub(crate) fn of_numbers([law, a, b, c]: [f64; 4]) -> Friction {
        match law as u8 {
            1 => Friction::Given { slip_bound: a },
            2 => Friction::Coulomb { coefficient: a },
            3 => Friction::Limited { coefficient: a, limit: b },
            4 => Friction::Cohesive { coefficient: a, cohesion: b, tension: c },
            5 => Friction::Bonded,
            _ => Friction::None,
        }
    }

    /// Sets the coefficient where there is one.
    pub fn set_coefficient(&mut self, value: f64) {
        if let Friction::Coulomb { coefficient }
        | Friction::Limited { coefficient, .. }
        | Friction::Cohesive { coefficient, .. } = self
        {
            *coefficient = value;
        }
    }

    /// The cohesion and the largest pull, newton; none where the law has no strength.
    pub fn strength(&self) -> [f64; 2] {
        if let Friction::Cohesive { cohesion, tension, .. } = *self { [cohesion, tension] } else { [0.0; 2] }
    }

    /// Sets both where the law has a strength.
    pub fn set_strength(&mut self, new: [f64; 2]) {
        if let Friction::Cohesive { cohesion, tension, .. } = self {
            [*cohesion, *tension] = new;
        }
    }

    /// The largest pull the point carries, newton; that of a tied one has no bound and is no strength.
    pub fn tension(&self) -> f64 {
        if let Friction::Cohesive { tension, .. } = *self { tension } else { 0.0 }
    }
}
