//! Which path is tried first, and the keys of the case file that stand for arguments of the solver.

use crate::Error;
use crate::contact::ContactProblem;
use crate::friction::{Method, SolverPath};
use crate::io::case::SolverSpec;
use crate::solve::multigrid_is_faster;

/// Whether a problem is solved by multigrid before anything else: because the case says so, or because that is
/// predicted to be faster than the direct path.
pub(crate) fn multigrid_first(spec: &SolverSpec, problem: &ContactProblem) -> bool {
    let path = match spec.path {
        SolverPath::Multigrid => true,
        SolverPath::Auto => multigrid_is_faster(problem),
        SolverPath::Dense | SolverPath::Solves => false,
    };
    spec.method.method == Method::Newton && path
}

/// Arguments of the library and what the case file calls them.
const KEYS: [(&str, &str); 6] = [
    ("`settings.memory_limit`", "`memory` under [solver]"),
    ("`settings.path`", "`path` under [solver]"),
    ("`method.method`", "method = \"newton\" under [solver]"),
    ("hold the body in `elastic.K`", "add a [[fix]] that holds the body"),
    (
        "put the points (the rows of `contact.B`) on the softer body",
        "leave out `slave` under [[contact]], which puts the points on the softer body",
    ),
    (
        "put the points (the rows of `contact.B`) on the other body",
        "let `slave` under [[contact]] name the other surface",
    ),
];

/// The same mistake in terms of the case file.
pub(crate) fn in_terms_of_the_case(error: Error) -> Error {
    let remedy = KEYS.iter().fold(error.remedy, |text, (argument, key)| text.replace(argument, key));
    Error { remedy, ..error }
}
