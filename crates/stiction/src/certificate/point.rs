use super::scales::ROUNDING;
use super::stiffness::LocalStiffness;
use crate::contact::{ContactProblem, Friction};

/// Orthotropy ratios below this count as this much where a force is divided by them: across a direction without
/// friction the rounding of a frame is no force.
const LEAST_RATIO: f64 = 1e-8;

/// One contact point: forces and kinematics, with slip as in the law (`lambda_t` points along it).
pub(super) struct Point {
    pub tied: bool,
    /// The coefficient where friction follows the normal force.
    coulomb: Option<f64>,
    /// `lambda_n`, counted from the largest pull: what is zero where the point is open.
    pub normal: f64,
    friction: [f64; 2],
    /// `gap` and `N u`.
    gap: f64,
    approach: f64,
    slip: [f64; 2],
    /// Along the first tangent.
    pub bound: f64,
    /// Friction across the first tangent over that along it.
    across: f64,
    /// Turns a displacement of the point into a force.
    stiffness: f64,
    /// The force that rounding of the jump amounts to. Where points but graze, contact forces may be smaller.
    pub rounding: f64,
    /// The largest multiplier of an empty row of `B`: a force that nothing carries.
    idle: f64,
}

impl Point {
    /// Point `j` of an answer; `jump` is `B u`.
    pub(super) fn new(
        problem: &ContactProblem,
        stiffness: &LocalStiffness,
        u: &[f64],
        jump: &[f64],
        lambda: &[f64],
        j: usize,
    ) -> Point {
        let m = problem.points();
        let idle = problem.rows(j).into_iter().filter(|&i| stiffness.of_row[i].is_none());
        let opening = problem.contact.gap[j] - jump[j];
        let (normal, strength) = match problem.contact.friction[j] {
            Friction::Cohesive { tension, .. } => (lambda[j] + tension, tension),
            _ => (lambda[j], 0.0),
        };
        let (coulomb, bound) = match problem.contact.friction[j] {
            Friction::None | Friction::Bonded => (None, 0.0),
            Friction::Given { slip_bound } => (None, slip_bound),
            Friction::Coulomb { coefficient } => (Some(coefficient), coefficient * normal.max(0.0)),
            // Beyond its limit friction does not follow the normal force: the bound is as good as given.
            Friction::Limited { coefficient, limit } if coefficient * normal > limit => (None, limit),
            Friction::Limited { coefficient, .. } => (Some(coefficient), coefficient * normal.max(0.0)),
            // Across a gap there is no shear. At the edge force and opening both vanish: the larger of them decides, as
            // lengths turned into forces. With its jump at the edge the cone is no cone, and the bound as good as given.
            Friction::Cohesive { coefficient, cohesion, .. } if normal > stiffness.of_point[j] * opening => {
                (None, (cohesion + coefficient * lambda[j]).max(0.0))
            }
            Friction::Cohesive { .. } => (None, 0.0),
        };
        Point {
            tied: problem.contact.friction[j] == Friction::Bonded,
            coulomb,
            normal,
            friction: [lambda[m + j], lambda[2 * m + j]],
            gap: problem.contact.gap[j],
            approach: jump[j],
            slip: [
                jump[m + j] - problem.contact.slip_reference[j],
                jump[2 * m + j] - problem.contact.slip_reference[m + j],
            ],
            bound,
            across: problem.contact.orthotropy.as_ref().map_or(1.0, |across| across[j]),
            stiffness: stiffness.of_point[j],
            rounding: ROUNDING * stiffness.of_point[j] * jump_size(problem, u, j) + ROUNDING * strength,
            idle: idle.map(|i| lambda[i].abs()).fold(0.0, f64::max),
        }
    }

    fn opening(&self) -> f64 {
        self.gap - self.approach
    }

    /// The slip in coordinates in which the ellipse of friction is a disc; of a tied point the slip itself.
    fn round_slip(&self) -> [f64; 2] {
        if self.tied { self.slip } else { [self.slip[0], self.across * self.slip[1]] }
    }

    /// The force there.
    fn round_friction(&self) -> [f64; 2] {
        [self.friction[0], self.friction[1] / self.across.max(LEAST_RATIO)]
    }

    /// Dissipation over bound.
    fn slip_length(&self) -> f64 {
        let [along, across] = self.round_slip();
        along.hypot(across)
    }

    /// How far friction is beyond its bound; force.
    pub(super) fn excess(&self) -> f64 {
        let [along, across] = self.round_friction();
        if self.tied { 0.0 } else { along.hypot(across) - self.bound }
    }

    /// How far the surfaces overlap, or are apart where they are tied, before anything moves; length.
    pub(super) fn overlap(&self) -> f64 {
        if self.tied { self.gap.abs() } else { -self.gap }
    }

    /// The pull of surfaces that can only push; force.
    pub(super) fn tension(&self) -> f64 {
        if self.tied { 0.0 } else { -self.normal }
    }

    fn friction_work(&self) -> f64 {
        self.friction[0] * self.slip[0] + self.friction[1] * self.slip[1]
    }

    /// Penetration, or the whole jump of a tied point; length.
    pub(super) fn violation(&self) -> f64 {
        if self.tied { self.opening().abs().max(self.slip_length()) } else { -self.opening() }
    }

    /// By how much the work of friction on the slip falls short of its bound; work.
    pub(super) fn misdirection(&self) -> f64 {
        if self.tied { 0.0 } else { self.bound * self.slip_length() - self.friction_work() }
    }

    /// What rounding makes of it; work.
    pub(super) fn misdirection_rounding(&self) -> f64 {
        self.rounding * self.slip_length()
    }

    /// The part of the bipotential and what rounding makes of it; work.
    pub(super) fn bipotential(&self) -> (f64, f64) {
        if self.tied {
            return (0.0, 0.0);
        }
        let gap = self.normal * self.opening() + self.misdirection();
        (gap, self.rounding * self.opening().abs() + self.misdirection_rounding())
    }

    /// The square of `|lambda - P(lambda - r w)|`; of a tied point that of the force which closes its jump.
    pub(super) fn residual_squared(&self) -> f64 {
        let (r, idle) = (self.stiffness, self.idle * self.idle);
        if self.tied {
            return (r * self.opening()).powi(2) + (r * self.slip_length()).powi(2) + idle;
        }
        let (friction, slip) = (self.round_friction(), self.round_slip());
        let w = [self.opening() + self.coulomb.map_or(0.0, |c| c * self.slip_length()), -slip[0], -slip[1]];
        let y = [self.normal - r * w[0], friction[0] - r * w[1], friction[1] - r * w[2]];
        let projected = match self.coulomb {
            Some(coefficient) => onto_cone(coefficient, y),
            None => {
                let shrink = self.bound / y[1].hypot(y[2]).max(self.bound).max(f64::MIN_POSITIVE);
                [y[0].max(0.0), y[1] * shrink, y[2] * shrink]
            }
        };
        (self.normal - projected[0]).powi(2)
            + (friction[0] - projected[1]).powi(2)
            + (friction[1] - projected[2]).powi(2)
            + idle
    }
}

/// What the jump of point `j` adds up from: magnitudes of the gap, of the slip reference and of all entries; length.
fn jump_size(problem: &ContactProblem, u: &[f64], j: usize) -> f64 {
    let of_row = |i: usize| {
        let (columns, values) = problem.contact.B.row(i);
        columns.iter().zip(values).map(|(&k, b)| (b * u[k as usize]).abs()).sum::<f64>()
    };
    let reference = &problem.contact.slip_reference;
    let offsets = problem.contact.gap[j].abs() + reference[j].abs() + reference[problem.points() + j].abs();
    offsets + problem.rows(j).into_iter().map(of_row).sum::<f64>()
}

/// Euclidean projection on `|y_t| <= F y_n`.
fn onto_cone(coefficient: f64, y: [f64; 3]) -> [f64; 3] {
    let tangential = y[1].hypot(y[2]);
    // The sign is asked for itself: without friction `coefficient * y[0]` is -0 for tension, which is not below 0.
    if y[0] >= 0.0 && tangential <= coefficient * y[0] {
        return y;
    }
    if coefficient * tangential <= -y[0] {
        return [0.0; 3];
    }
    let normal = (y[0] + coefficient * tangential) / (1.0 + coefficient * coefficient);
    let shrink = coefficient * normal / tangential;
    [normal, y[1] * shrink, y[2] * shrink]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cone_without_friction_is_the_half_line() {
        for coefficient in [0.0, 1e-300] {
            assert_eq!(onto_cone(coefficient, [-1.0, 0.0, 0.0]), [0.0; 3]);
            assert_eq!(onto_cone(coefficient, [-1.0, -0.0, 0.0]), [0.0; 3]);
            assert_eq!(onto_cone(coefficient, [-1.0, 2.0, 3.0]), [0.0; 3]);
            assert_eq!(onto_cone(coefficient, [1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
            let [normal, along, across] = onto_cone(coefficient, [1.0, 3.0, 4.0]);
            assert!(normal == 1.0 && along <= coefficient && across <= coefficient);
        }
        assert_eq!(onto_cone(0.5, [0.0; 3]), [0.0; 3]);
        assert_eq!(onto_cone(0.5, [2.0, 0.6, 0.8]), [2.0, 0.6, 0.8]);
        assert_eq!(onto_cone(0.5, [-0.5, 0.6, 0.8]), [0.0; 3]);
    }
}
