//! The fallback strategy: the stages of a multigrid solve as a table.

use super::fixed_point::fixed_point;
use super::iteration::{Observe, State, Subproblem, run};
use super::springs::by_springs;
use crate::friction::End;
use crate::linalg::multigrid::Hierarchy;

/// What decides about the stages.
pub(super) struct Traits {
    /// Whether contact alone supports some body.
    pub floats: bool,
    /// Whether the solution minimises an energy: no slip bound depends on a normal force.
    pub convex: bool,
    /// Whether equations over many nodes hold beside contact.
    pub has_equations: bool,
    /// Whether multigrid is asked for, so that no other path follows.
    pub asked: bool,
    /// The user's bound on the cycles.
    pub max_iterations: usize,
}

/// A stage of the fallback strategy.
pub(super) struct Stage {
    pub run: fn(&Subproblem<'_>, &mut Hierarchy, &mut State, &mut Observe<'_>) -> End,
    /// Whether the stage is entered after an earlier one that ended so.
    pub entry: fn(End, &Traits) -> bool,
    /// The count of all cycles at which the stage ends, if it begins at the given one.
    pub budget: fn(usize, &Traits) -> usize,
    /// Resets of cycling active sets.
    pub max_resets: fn(&Traits) -> usize,
    /// Violation of balance and law, over the load, above which it has failed, if it began with less.
    pub max_violation: fn(&Traits) -> f64,
    /// Violation over the load up to which the best iterate of the earlier stages is where it begins.
    pub near: f64,
}

/// Violation over the load above which the sets of a body that is held are those of one that bends: a plate of 1:50 has 150 to 200 after
/// the first cycle. Its residual falls again, but the hundreds of points that were closed make the sets swing.
const BENDS: f64 = 30.0;

/// Cycles of the fixed point on the slip bounds where the factor can follow; nine in ten of the random cases that it solves
/// take fewer.
const FIXED_POINT_CYCLES: usize = 120;

/// Violation over the load up to which given friction begins at the best iterate so far. 1500 random cases take 29,162 cycles where it
/// always begins at the first one, 28,801 with 0.05 and 28,674 with 0.3.
const NEAR: f64 = 0.3;

/// The stages in their order. Each starts from the first iterate again, the last one near the solution from the best one; where all fail
/// that is returned, after some 200 cycles.
pub(super) const STAGES: [Stage; 3] = [
    // The active-set iteration takes little more cycles than a linear solve. What the sets of bodies that are held do not settle on the
    // next stage finds sooner than resets. Of 300 random cases two resets save 83 of 5,805 cycles where bodies float.
    Stage {
        run,
        entry: |_, _| true,
        budget: |_, traits| traits.max_iterations,
        max_resets: |traits| if traits.floats { 2 } else { 0 },
        max_violation: |traits| if traits.floats { f64::INFINITY } else { BENDS },
        near: 0.0,
    },
    // Bodies that bend: springs in place of contact find the sets. They resist no motion of a floating body that is open.
    Stage {
        run: by_springs,
        entry: |end, traits| end == End::Stalled && !traits.floats,
        budget: |_, traits| traits.max_iterations,
        max_resets: |_| 0,
        max_violation: |_| f64::INFINITY,
        near: 0.0,
    },
    // With given friction the solution minimises an energy, whose descent cannot cycle. It also serves convex problems whose
    // cycles are used up, with as many again; with Coulomb friction a limit of cycles is the user's.
    Stage {
        run: fixed_point,
        entry: |end, traits| {
            let failed = end == End::Stalled || end == End::Limit && traits.convex;
            // Its descent moves nodes one by one.
            failed && !traits.has_equations
        },
        budget: |cycles, traits| match (traits.convex, traits.asked) {
            (true, _) => cycles.saturating_add(traits.max_iterations),
            (false, true) => traits.max_iterations,
            (false, false) => traits.max_iterations.min(cycles + FIXED_POINT_CYCLES),
        },
        max_resets: |_| 0,
        max_violation: |_| f64::INFINITY,
        near: NEAR,
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The stage that follows the first one.
    fn next(end: End, floats: bool, convex: bool) -> Option<usize> {
        let traits = Traits { floats, convex, has_equations: false, asked: false, max_iterations: 400 };
        (1..STAGES.len()).find(|&stage| (STAGES[stage].entry)(end, &traits))
    }

    #[test]
    fn a_failure_enters_the_next_stage_and_a_limit_of_cycles_only_where_an_energy_is_minimised() {
        assert_eq!(next(End::Stalled, true, false), Some(2));
        assert_eq!(next(End::Stalled, false, false), Some(1));
        assert_eq!(next(End::Limit, true, true), Some(2));
        for end in [End::Converged, End::Interrupted] {
            assert_eq!(next(end, true, true), None);
        }
        assert_eq!(next(End::Limit, true, false), None);
    }

    #[test]
    fn the_fixed_point_keeps_to_the_cycles_of_the_user_and_a_descent_gets_as_many_again() {
        let budget = |convex, asked, cycles| {
            (STAGES[2].budget)(
                cycles,
                &Traits { floats: false, convex, has_equations: false, asked, max_iterations: 400 },
            )
        };
        assert_eq!([budget(false, false, 60), budget(false, false, 350), budget(true, false, 350)], [180, 400, 750]);
        assert_eq!([budget(false, true, 60), budget(true, true, 350)], [400, 750]);
    }
}
