//! A discrete problem with what comes along with it in a file.

use crate::discrete::DiscreteProblem;

/// What a file of a discrete problem holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Contents {
    /// The problem, checked.
    pub problem: DiscreteProblem,
    /// Impulses that the file calls a solution, `dm`. Files of the collection FCLib exist in which they are none.
    pub solution: Option<Vec<f64>>,
    /// Impulses offered as starting points, each `dm`.
    pub guesses: Vec<Vec<f64>>,
}
