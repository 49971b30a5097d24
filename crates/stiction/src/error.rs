use std::fmt;

/// Why a problem cannot be posed: what is wrong, where, and the remedy.
///
/// How an iteration ended is not an error but a status of its result; work that was stopped before there is a result ends with
/// [`Error::interrupted`].
#[derive(Debug, Clone, PartialEq)]
pub struct Error {
    /// Where: `case.toml:12:5`, `part.msh, element 412`, `contact "sole"`; empty if there is no place to name.
    pub place: String,
    /// What is wrong, as a sentence without a full stop.
    pub what: String,
    /// What the user can do about it; may be empty.
    pub remedy: String,
    /// Lines of the source with the place marked, ready to print; may be empty.
    pub excerpt: String,
    /// Nothing is wrong: the work was stopped on request before it had a result.
    pub interrupted: bool,
}

impl Error {
    /// An error at `place`; see the fields for the wording of each part.
    pub fn new(place: impl Into<String>, what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Error {
            place: place.into(),
            what: what.into(),
            remedy: remedy.into(),
            excerpt: String::new(),
            interrupted: false,
        }
    }

    /// What ends with nothing because it was stopped on request.
    pub fn interrupted() -> Self {
        Error { interrupted: true, ..Error::new("", "interrupted", "") }
    }

    /// A number as messages have it: five significant digits.
    pub fn number(x: f64) -> String {
        let rounded: f64 = format!("{x:.4e}").parse().unwrap_or(x);
        let rounded = rounded + 0.0; // -0 reads as 0
        let size = rounded.abs();
        if size == 0.0 || (1e-3..1e5).contains(&size) { format!("{rounded}") } else { format!("{rounded:e}") }
    }

    /// The same error, placed at `place` if it had no place yet and inside it otherwise.
    #[must_use]
    pub fn at(mut self, place: &str) -> Self {
        self.place = if self.place.is_empty() { place.to_string() } else { format!("{place}, {}", self.place) };
        self
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.place.is_empty() {
            write!(f, "{}: ", self.place)?;
        }
        f.write_str(&self.what)?;
        if !self.remedy.is_empty() {
            write!(f, "; {}", self.remedy)?;
        }
        if !self.excerpt.is_empty() {
            write!(f, "\n{}", self.excerpt)?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}
