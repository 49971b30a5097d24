//! The language in which `spec` describes the keys of a case file.

/// What a value must be.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    /// A text that is not empty.
    Text,
    Number(Limits),
    Whole {
        from: i64,
        to: i64,
    },
    Flag,
    /// One of some texts, each with its meaning.
    Choice {
        names: &'static [(&'static str, &'static str)],
        /// Names that are known but refused, each with the remedy.
        absent: &'static [(&'static str, &'static str)],
    },
    /// A number, or an expression in x, y, z, t.
    Field,
    List {
        of: &'static Kind,
        from: usize,
        to: usize,
    },
    Table(&'static Rules),
    /// `[[name]]`, any number of times.
    Tables(&'static Rules),
    /// `[name.ANY]`: a table for each name the user chooses.
    Named(&'static Rules),
    /// The first of these whose TOML type fits.
    Either(&'static [Kind]),
}

/// The keys of a table.
#[derive(Debug)]
pub(super) struct Rules {
    pub doc: &'static str,
    pub keys: &'static [Key],
    /// Exactly one of these keys must be there; empty if there is no such rule.
    pub one_of: &'static [&'static str],
}

impl Rules {
    pub(super) fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Key {
    pub name: &'static str,
    pub kind: Kind,
    pub doc: &'static str,
    /// A line of a case file that uses the key.
    pub example: &'static str,
    pub required: bool,
    /// As TOML; empty if there is none.
    pub default: &'static str,
    /// Empty for pure numbers and texts.
    pub unit: &'static str,
    /// A key of `Rules::one_of` beside which this one of them may stand; empty if there is none.
    pub beside: &'static str,
}

pub(super) const fn key(name: &'static str, kind: Kind, example: &'static str, doc: &'static str) -> Key {
    Key { name, kind, doc, example, required: false, default: "", unit: "", beside: "" }
}

/// One of some texts, none of which is refused.
pub(super) const fn choice(names: &'static [(&'static str, &'static str)]) -> Kind {
    Kind::Choice { names, absent: &[] }
}

impl Key {
    pub(super) const fn required(self) -> Self {
        Key { required: true, ..self }
    }

    pub(super) const fn default(self, default: &'static str) -> Self {
        Key { default, ..self }
    }

    pub(super) const fn beside(self, beside: &'static str) -> Self {
        Key { beside, ..self }
    }

    pub(super) const fn unit(self, unit: &'static str) -> Self {
        Key { unit, ..self }
    }
}

/// Which numbers are meant; infinite limits are none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub low: f64,
    pub low_included: bool,
    pub high: f64,
    pub high_included: bool,
    /// What to do about a number beyond them; may be empty.
    pub remedy: &'static str,
    /// Whether it is a part of something, which people also count in percent.
    pub part: bool,
    /// A number that deserves words of its own.
    pub special: Option<(f64, &'static str, &'static str)>,
}

pub(super) const ANY: Limits = Limits {
    low: f64::NEG_INFINITY,
    low_included: false,
    high: f64::INFINITY,
    high_included: false,
    remedy: "",
    part: false,
    special: None,
};
pub(super) const POSITIVE: Limits = Limits { low: 0.0, ..ANY };
pub(super) const NOT_NEGATIVE: Limits = Limits { low: 0.0, low_included: true, ..ANY };

impl Limits {
    pub(super) fn contain(&self, x: f64) -> bool {
        let above = x > self.low || (self.low_included && x == self.low);
        let below = x < self.high || (self.high_included && x == self.high);
        above && below && x.is_finite()
    }

    /// ` greater than 0`, ` of at least 1e-14 and at most 0.1`; empty without limits.
    pub(super) fn describe(&self) -> String {
        let low = if self.low_included { "of at least" } else { "greater than" };
        let high = if self.high_included { "at most" } else { "less than" };
        match (self.low.is_finite(), self.high.is_finite()) {
            (true, true) => format!(" {low} {} and {high} {}", show(self.low), show(self.high)),
            (true, false) => format!(" {low} {}", show(self.low)),
            (false, true) => format!(" {high} {}", show(self.high)),
            (false, false) => String::new(),
        }
    }
}

/// A number as one writes it: 0 instead of 0.0, but 1e-14.
fn show(x: f64) -> String {
    if x == x.trunc() && x.abs() < 1e6 { format!("{x:.0}") } else { format!("{x:?}") }
}

impl Kind {
    /// What is wanted, for messages: `a number greater than 0`.
    pub(super) fn describe(&self) -> String {
        match self {
            Kind::Text => "a text in double quotes".into(),
            Kind::Number(limits) => format!("a number{}", limits.describe()),
            Kind::Whole { from, to } => format!("a whole number from {from} to {to}"),
            Kind::Flag => "true or false".into(),
            Kind::Choice { names, .. } => names.iter().map(|n| format!("{:?}", n.0)).collect::<Vec<_>>().join(" or "),
            Kind::Field => "a number or an expression in double quotes".into(),
            Kind::List { of, from, to } => {
                let count = match (from, to) {
                    (a, b) if a == b => format!("{a} entries"),
                    (a, b) if *b == usize::MAX => format!("at least {a} entries"),
                    (a, b) => format!("{a} to {b} entries"),
                };
                format!("a list of {count}, each {},", of.describe().trim_end_matches(','))
            }
            Kind::Table(rules) => {
                format!("a table {{ {} }}", rules.keys.iter().map(|k| k.name).collect::<Vec<_>>().join(", "))
            }
            Kind::Tables(_) => "a list of tables".into(),
            Kind::Named(_) => "a table of tables".into(),
            Kind::Either(kinds) => {
                let all: Vec<String> = kinds.iter().map(Kind::describe).collect();
                all.join(", or ").replace(",,", ",")
            }
        }
    }
}
