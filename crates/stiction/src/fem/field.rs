use std::fmt;
use std::sync::Arc;

use crate::Error;

/// A number, or a function of position and time given as an expression.
#[derive(Clone)]
pub enum Field {
    /// The same number everywhere and at all times.
    Constant(f64),
    /// `f(x, t)`, with the text it was read from for messages.
    Function {
        /// The text it was read from.
        text: String,
        /// Its value at a point (length) and a time.
        value: Arc<dyn Fn([f64; 3], f64) -> f64 + Send + Sync>,
    },
}

impl Field {
    /// The value at `x` and time `t`.
    pub fn at(&self, x: [f64; 3], t: f64) -> f64 {
        match self {
            Field::Constant(c) => *c,
            Field::Function { value, .. } => value(x, t),
        }
    }

    /// The value at `x` and time `t`; an error naming expression and place if it is not a finite number.
    ///
    /// # Errors
    /// If the value is not a finite number, with the expression and the place.
    pub fn finite_at(&self, x: [f64; 3], t: f64) -> Result<f64, Error> {
        let value = self.at(x, t);
        if value.is_finite() {
            return Ok(value);
        }
        let what = match self {
            Field::Constant(_) => format!("{value} is given where a finite number is needed"),
            Field::Function { text, .. } => {
                let place = if x[0].is_nan() { String::new() } else { format!("at {} and ", point(x)) };
                format!("the expression \"{text}\" is {value} {place}at time t = {t}")
            }
        };
        Err(Error::new("", what, "give an expression that is finite wherever it acts"))
    }
}

/// `x` as a person writes a point, to six digits.
pub(super) fn point(x: [f64; 3]) -> String {
    format!("({}, {}, {})", short(x[0]), short(x[1]), short(x[2]))
}

/// `v` to six significant digits.
pub(super) fn short(v: f64) -> f64 {
    // Adding zero turns -0 into 0.
    format!("{v:.5e}").parse().unwrap_or(v) + 0.0
}

/// Functions are the same if they were read from the same text.
impl PartialEq for Field {
    fn eq(&self, other: &Field) -> bool {
        match (self, other) {
            (Field::Constant(a), Field::Constant(b)) => a == b,
            (Field::Function { text: a, .. }, Field::Function { text: b, .. }) => a == b,
            _ => false,
        }
    }
}

impl fmt::Debug for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Field::Constant(c) => write!(f, "{c}"),
            Field::Function { text, .. } => write!(f, "{text:?}"),
        }
    }
}
