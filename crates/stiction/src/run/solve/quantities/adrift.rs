//! Motions of an answer that nothing resists.

use serde::{Deserialize, Serialize};

use super::unheld::unheld;
use crate::contact::ContactProblem;
use crate::contact::adrift::{Held, adrift};
use crate::contact::among::Among;
use crate::contact::equilibrium::in_words_among;
use crate::contact::rigid::RigidMotions;
use crate::friction::{PointState, Solution, Status};
use crate::run::pose::Prepared;

/// Rigid motions of bodies that nothing resists in an answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AdriftRecord {
    /// One of them, in words.
    pub motion: String,
    /// How many independent ones there are.
    pub motions: usize,
}

/// Those of an answer; none where nothing is solved.
pub(crate) fn adrift_of(prepared: &Prepared, solution: &Solution) -> Option<AdriftRecord> {
    if solution.status != Status::Solved {
        return None;
    }
    let unheld = unheld(prepared, solution);
    let is_closed = |j: usize| solution.states[j] != PointState::Open;
    let held = Held { lambda: &solution.lambda, is_closed: &is_closed };
    adrift_among((&prepared.problem, &prepared.motions), (held, &unheld), &Among::ALONE)
}

/// Those beside the motions of bodies that are `unheld`, where ranks share the problem the same on all.
pub(crate) fn adrift_among(
    (problem, motions): (&ContactProblem, &RigidMotions),
    (held, unheld): (Held, &[String]),
    among: &Among,
) -> Option<AdriftRecord> {
    let bodies = problem.labels.bodies.as_ref();
    let is_unheld = |number: usize| {
        let name = bodies.zip(motions.bodies[number].place).map(|(bodies, place)| &bodies.list[place].name);
        name.is_some_and(|name| unheld.contains(name))
    };
    let found = adrift((problem, motions), held, &is_unheld, among);
    let motion = in_words_among(problem, motions, found.first()?, among.max);
    Some(AdriftRecord { motion, motions: found.len() })
}
