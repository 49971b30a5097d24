use super::given::{Adaptive, Record, adaptive_uzawa, relative, uzawa};
use super::lagrangian::Copies;
use super::method::{Given, MethodSettings};
use super::minimize::{Minimizer, norm_of_difference};
use super::squares::boxes;
use crate::contact::Friction;
use crate::friction::End;
use crate::linalg::norm;

/// The bounds of friction, newton: given where friction is given, `F lambda_n` where it is Coulomb's.
#[derive(Debug, Clone)]
pub(super) struct SlipBounds<'a> {
    pub friction: &'a [Friction],
    pub value: Vec<f64>,
    /// Those before the last change: what the multipliers were found with.
    pub last: Vec<f64>,
}

impl<'a> SlipBounds<'a> {
    /// `coulomb` are the bounds at points with Coulomb friction, the rest of it is not read; zero if `None`.
    pub(super) fn new(friction: &'a [Friction], coulomb: Option<&[f64]>) -> Self {
        let value = |(j, law): (usize, &Friction)| match *law {
            Friction::Given { slip_bound } => slip_bound,
            Friction::Coulomb { .. } | Friction::Limited { .. } | Friction::Cohesive { .. } => {
                coulomb.map_or(0.0, |g| if g[j] > 0.0 { g[j] } else { 0.0 })
            }
            Friction::None | Friction::Bonded => 0.0,
        };
        let value: Vec<f64> = friction.iter().enumerate().map(value).collect();
        SlipBounds { friction, last: value.clone(), value }
    }

    /// `g = F lambda_n` from multipliers `lambda`; how much it changed and how large it is, where it can change.
    pub(super) fn follow(&mut self, lambda: &[f64]) -> (f64, f64) {
        self.last.clone_from(&self.value);
        let mut moving = Vec::new();
        for (j, law) in self.friction.iter().enumerate() {
            if law.coefficient().is_some() {
                self.value[j] = law.bound(lambda[j]);
                moving.push(self.value[j]);
            }
        }
        (norm_of_difference(&self.value, &self.last), norm(&moving))
    }

    /// Whether some friction is Coulomb's.
    pub(super) fn can_change(&self) -> bool {
        self.friction.iter().any(|law| law.coefficient().is_some())
    }
}

/// Returns the multipliers for given bounds.
pub(super) type SolveGiven<'a> = dyn FnMut(&SlipBounds<'_>, &mut Record<'_, '_>) -> Result<Vec<f64>, End> + 'a;

/// MSA1: every problem with given friction solved (Haslinger, Kucera & Dostal 2004, section 5), with their rule (6.3).
///
/// # Errors
/// That of `solve_given`.
pub(super) fn fixed_point(
    slip_bounds: &mut SlipBounds<'_>,
    settings: &MethodSettings,
    record: &mut Record<'_, '_>,
    solve_given: &mut SolveGiven<'_>,
) -> Result<(), End> {
    loop {
        let lambda = solve_given(slip_bounds, record)?;
        let (change, size) = slip_bounds.follow(&lambda); // g = F lambda_n
        record.counts.fixed_point_steps += 1;
        if change <= settings.tolerance * size {
            return Ok(());
        }
    }
}

/// A problem with given friction by either kind of Uzawa's method, from the present copies and `w`.
///
/// # Errors
/// How the method ended if not by its rule; the copies are where it came to.
pub(super) fn uzawa_on(
    given: Given,
    step1: &Minimizer<'_>,
    copies: &mut Copies,
    slip_bounds: &SlipBounds<'_>,
    settings: &MethodSettings,
    record: &mut Record<'_, '_>,
) -> Result<(), End> {
    let bounds = boxes(slip_bounds.friction, &step1.lagrangian.q.has_row, &slip_bounds.value);
    match given {
        Given::AdaptiveUzawa => adaptive_uzawa(step1, copies, &bounds, settings, record),
        Given::Uzawa(_) | Given::Discs => uzawa(step1, copies, &bounds, settings, record),
    }
}

/// MSA2: one Uzawa step for each change of the bounds, `w` carried on; CFS1 where Step 1 is one sweep of ALG1, CFS2
/// where it is ALG2's. Rule (6.3) of the paper; where all bounds are given they do not change and rule (6.1) holds.
///
/// # Errors
/// How the method ended if not by its rule; the copies are where it came to.
pub(super) fn inexact_fixed_point(
    given: Given,
    step1: &Minimizer<'_>,
    copies: &mut Copies,
    slip_bounds: &mut SlipBounds<'_>,
    settings: &MethodSettings,
    record: &mut Record<'_, '_>,
) -> Result<(), End> {
    let lagrangian = step1.lagrangian;
    if !slip_bounds.can_change() {
        return uzawa_on(given, step1, copies, slip_bounds, settings, record);
    }
    let mut adaptive = Adaptive::new(lagrangian);
    loop {
        if record.counts.iterations >= settings.max_iterations {
            return Err(End::Limit);
        }
        let bounds = boxes(slip_bounds.friction, &lagrangian.q.has_row, &slip_bounds.value);
        let settled = if given == Given::AdaptiveUzawa {
            // What a program leaves undone moves the bounds: it must be less than what the rule for them sees.
            let target = settings.inner_tolerance.min(settings.tolerance);
            let gradient = adaptive.step(step1, copies, &bounds, target, &mut record.counts)?;
            // A rough step may leave the bounds where they are and yet be far from the solution.
            gradient.max(lagrangian.disagreement(&copies.x)) <= settings.tolerance
        } else {
            step1.minimize(copies, &bounds, &mut record.counts)?; // Step 1
            lagrangian.ascend(copies); // Step 2: w += rho C lambda
            true
        };
        let lambda = lagrangian.squares.mean(&copies.x);
        let (change, size) = slip_bounds.follow(&lambda); // g = F lambda_n
        record.counts.iterations += 1;
        record.counts.fixed_point_steps += 1;
        record.note(lagrangian, copies, &bounds, relative(change, size))?;
        if settled && change <= settings.tolerance * size {
            return Ok(());
        }
    }
}
