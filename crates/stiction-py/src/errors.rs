//! What goes wrong, as exceptions of Python.

use pyo3::prelude::*;
use stiction::Error;

/// Names of the library and those a user of Python knows.
const NAMES: [(&str, &str); 17] = [
    ("`elastic.node_of` and, for a good rate of convergence, `elastic.near_kernel`", "`coordinates`"),
    ("rows of elastic.K", "rows of K"),
    ("elastic.K", "K"),
    ("elastic.f", "f"),
    ("`elastic.node_of`", "`coordinates`"),
    ("`elastic.near_kernel`", "`coordinates`"),
    ("elastic.near_kernel", "coordinates"),
    ("contact.B", "B"),
    ("contact.gap", "gap"),
    ("contact.slip_reference", "slip_reference"),
    ("contact.friction", "mu"),
    ("contact.orthotropy", "across"),
    ("labels.area", "area"),
    ("`settings.memory_limit`", "`memory_limit`"),
    ("`settings.path`", "`method`"),
    ("`path`", "`method`"),
    ("`start_displacement`", "`start`"),
];

/// The class `name` of `stiction._errors`.
pub(crate) fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("stiction._errors")?.getattr(name)
}

/// `InputError` with place, what and remedy; a stop of our own making is `NotCertified` without a result.
pub(crate) fn raised(py: Python<'_>, error: Error) -> PyErr {
    let made = if error.interrupted {
        class(py, "NotCertified").and_then(|class| class.call1(("stopped before the first iteration", py.None())))
    } else {
        let of_memory = error.remedy.contains("`settings.memory_limit`");
        let known = |text: String| NAMES.iter().fold(text, |text, (ours, theirs)| text.replace(ours, theirs));
        let class = class(py, if of_memory { "TooLarge" } else { "InputError" });
        let (place, what) = at_argument(known(error.place), known(error.what));
        class.and_then(|class| class.call1((place, what, known(error.remedy), error.excerpt)))
    };
    made.map_or_else(|error| error, PyErr::from_value)
}

/// The library names fields of its problem in the sentence; here the argument is the place: `f`, `entry 0 is NaN`.
fn at_argument(place: String, what: String) -> (String, String) {
    let names = || NAMES.iter().map(|(_, theirs)| *theirs).filter(|theirs| !theirs.contains(['`', ' ']));
    let named = names().find_map(|name| Some((name, what.strip_prefix(name)?)));
    let Some((name, rest)) = named.filter(|_| place == "contact problem") else { return (place, what) };
    let entry = rest.strip_prefix('[').and_then(|rest| rest.split_once(']'));
    let what = match entry {
        // That of a point says which point it is.
        Some((_, rest)) if rest.starts_with(": ") => rest[2..].to_string(),
        Some((i, rest)) => format!("entry {i}{rest}"),
        None => format!("it{rest}"),
    };
    (name.to_string(), what.replacen("it: ", "", 1))
}

/// An `InputError` of the binding itself.
pub(crate) fn wrong(py: Python<'_>, place: &str, what: impl Into<String>, remedy: &str) -> PyErr {
    raised(py, Error::new(place, what, remedy))
}
