//! Deviations that the study has looked into, with what is known of them.

use super::compare::Quantity;
use super::experiment::Line;

/// Why a number lies outside its band, if that was looked into. Nothing here widens a band: the number stays marked.
pub fn known(table: usize, line: &Line, quantity: Quantity) -> Option<&'static str> {
    match (table, line.label.as_str(), quantity) {
        (4, "log rho = -6", Quantity::CgSteps) => Some(
            "rounding decides: 26 runs, each with loads changed in the last digit, give 368 to 470 steps, eight of them \
             406 or more, where the band begins; two builds of the same solvers, one before and one after a change of how \
             loads are summed, spread alike",
        ),
        (5, "log rho = -7" | "log rho = -6", Quantity::CgSteps) => Some(
            "our solver needs fewer steps than the paper's did; with the loads times 4.29, which fit as well, the number \
             beside it lies within the band",
        ),
        (6, "log rho = -8, N = 6", Quantity::Iterations) => Some(
            "neither coupling comes near 16, and the number does not depend on the solver of the quadratic programs; two \
             independent prototypes found the same; unexplained",
        ),
        (12, "partition 1, N = 6", Quantity::CgSteps) => Some(
            "without a preconditioner the star needs more than twice the paper's steps and the chain still more, with one \
             a small part of them; unexplained",
        ),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::compare::Band;
    use super::super::experiment::{band, plan};
    use super::super::published::published;
    use super::*;

    #[test]
    fn what_is_documented_is_judged_and_rare() {
        let mut documented = 0;
        for number in 1..=12 {
            for line in plan(&published(number).unwrap()).lines {
                for &(quantity, _) in &line.published {
                    if known(number, &line, quantity).is_some() {
                        assert_ne!(band(number, &line, quantity), Band::None, "{}", line.label);
                        documented += 1;
                    }
                }
            }
        }
        assert_eq!(documented, 5);
    }
}
