//! Numbers or expressions in `x`, `y`, `z` and `t`, read as an engineer writes them.
//!
//! `-x^2` is `-(x^2)`, `2^-x` works, `2/3*x` is `(2/3)*x`. `a^b^c` is refused: half of the programs an engineer
//! uses read it from the left, the other half from the right.
//!
//! No crate is used: of those looked at, the maintained one reads `-x^2` as `(-x)^2` and `1e6` not at all, and another is
//! under the AGPL.
//!
//! The grammar, loosest first; each line is one function of the parser:
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = signed (("*" | "/") signed)*
//! signed  = ("+" | "-") signed | power
//! power   = atom (("^" | "**") signed)?
//! atom    = number | variable | "pi" | function "(" sum ("," sum)* ")" | "(" sum ")"
//! ```

use std::sync::Arc;

use super::case::nearest;
use crate::fem::Field;

/// Longest expression, in characters; nobody writes a longer one by hand.
const MAX_CHARS: usize = 4096;
/// Deepest nesting of parentheses, signs and functions: it bounds the stack of the parser.
const MAX_DEPTH: usize = 64;

/// The names of the variables, in the order of `Term::Variable`.
pub const VARIABLES: [&str; 4] = ["x", "y", "z", "t"];

type Unary = fn(f64) -> f64;
type Binary = fn(f64, f64) -> f64;

const UNARY: &[(&str, Unary)] = &[
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("sqrt", f64::sqrt),
    ("exp", f64::exp),
    ("ln", f64::ln),
    ("log10", f64::log10),
    ("abs", f64::abs),
    ("floor", f64::floor),
];

// f64::min drops a NaN; here it must survive, or a mistake under a min would go unseen.
const BINARY: &[(&str, Binary)] = &[
    ("min", |a, b| if a.is_nan() || a < b { a } else { b }),
    ("max", |a, b| if a.is_nan() || a > b { a } else { b }),
    ("atan2", f64::atan2),
];

/// What is wrong with an expression, and where.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    /// Bytes of the expression the fault lies on.
    pub span: std::ops::Range<usize>,
    pub what: String,
    pub remedy: String,
}

/// The field of an expression in the variables `allowed`, a subset of [`VARIABLES`]; [`Field::Constant`] if none occurs
/// in it.
pub(crate) fn compile(text: &str, allowed: &[&str]) -> Result<Field, Fault> {
    if text.chars().count() > MAX_CHARS {
        let what = format!("the expression is longer than {MAX_CHARS} characters");
        return Err(Fault { span: 0..text.len(), what, remedy: "shorten it".into() });
    }
    let mut parser = Parser { text, at: 0, depth: 0, in_exponent: false, allowed };
    let term = parser.sum()?;
    if let Some(found) = parser.peek() {
        return Err(parser.unexpected(found));
    }
    match term {
        Term::Constant(c) if c.is_finite() => Ok(Field::Constant(c)),
        Term::Constant(c) => Err(Fault {
            span: 0..text.len(),
            what: format!("the expression {text:?} has the value {c}"),
            remedy: "its value must be a finite number".into(),
        }),
        term => Ok(Field::Function { text: text.into(), value: Arc::new(move |x, t| term.at(x, t)) }),
    }
}

/// An expression as a tree; constant parts are folded when it is built.
enum Term {
    Constant(f64),
    Variable(usize),
    Unary(Unary, Box<Term>),
    Binary(Binary, Box<(Term, Term)>),
}

impl Term {
    fn at(&self, x: [f64; 3], t: f64) -> f64 {
        match self {
            Term::Constant(c) => *c,
            Term::Variable(i) => x.get(*i).copied().unwrap_or(t),
            Term::Unary(f, a) => f(a.at(x, t)),
            Term::Binary(f, ab) => f(ab.0.at(x, t), ab.1.at(x, t)),
        }
    }

    fn unary(f: Unary, a: Term) -> Term {
        match a {
            Term::Constant(a) => Term::Constant(f(a)),
            a => Term::Unary(f, Box::new(a)),
        }
    }

    fn binary(f: Binary, a: Term, b: Term) -> Term {
        match (a, b) {
            (Term::Constant(a), Term::Constant(b)) => Term::Constant(f(a, b)),
            (a, b) => Term::Binary(f, Box::new((a, b))),
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    /// Bytes read so far; always on a character boundary.
    at: usize,
    depth: usize,
    /// Whether what is read now is the exponent of a power.
    in_exponent: bool,
    allowed: &'a [&'a str],
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    /// The next character that is not a blank.
    fn peek(&mut self) -> Option<char> {
        self.at = self.text.len() - self.rest().trim_start().len();
        self.rest().chars().next()
    }

    /// Reads `symbol` if it comes next.
    fn eat(&mut self, symbol: &str) -> bool {
        self.peek();
        let found = self.rest().starts_with(symbol);
        if found {
            self.at += symbol.len();
        }
        found
    }

    fn sum(&mut self) -> Result<Term, Fault> {
        let mut left = self.product()?;
        loop {
            if self.eat("+") {
                left = Term::binary(|a, b| a + b, left, self.product()?);
            } else if self.eat("-") {
                left = Term::binary(|a, b| a - b, left, self.product()?);
            } else {
                return Ok(left);
            }
        }
    }

    fn product(&mut self) -> Result<Term, Fault> {
        let mut left = self.signed()?;
        loop {
            if self.eat("*") {
                left = Term::binary(|a, b| a * b, left, self.signed()?);
            } else if self.eat("/") {
                left = Term::binary(|a, b| a / b, left, self.signed()?);
            } else {
                return Ok(left);
            }
        }
    }

    fn signed(&mut self) -> Result<Term, Fault> {
        // Every way down the grammar passes here, so this bounds the depth of the whole parser.
        if self.depth == MAX_DEPTH {
            let what = format!("the expression is nested more than {MAX_DEPTH} deep");
            return Err(self.fault(1, what, "take brackets away"));
        }
        self.depth += 1;
        let term = if self.eat("-") {
            Term::unary(|a| -a, self.signed()?)
        } else if self.eat("+") {
            self.signed()?
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(term)
    }

    fn power(&mut self) -> Result<Term, Fault> {
        let base = self.atom()?;
        if !(self.eat("^") || self.eat("**")) {
            return Ok(base);
        }
        if self.in_exponent {
            self.at -= 1;
            let what = "a^b^c is read differently by different programs";
            return Err(self.fault(1, what.into(), "write (a^b)^c or a^(b^c)"));
        }
        self.in_exponent = true;
        let exponent = self.signed()?;
        self.in_exponent = false;
        Ok(Term::binary(f64::powf, base, exponent))
    }

    fn atom(&mut self) -> Result<Term, Fault> {
        match self.peek() {
            Some('(') => {
                self.at += 1;
                let inner = self.bracketed()?;
                self.close()?;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.name(),
            Some(found) => Err(self.unexpected(found)),
            None => Err(self.ended()),
        }
    }

    /// A sum inside brackets: a power in it is not the exponent of a power outside.
    fn bracketed(&mut self) -> Result<Term, Fault> {
        let outside = std::mem::replace(&mut self.in_exponent, false);
        let inner = self.sum()?;
        self.in_exponent = outside;
        Ok(inner)
    }

    fn close(&mut self) -> Result<(), Fault> {
        if self.eat(")") {
            return Ok(());
        }
        match self.peek() {
            Some(found) => Err(self.unexpected(found)),
            None => Err(self.fault(0, "a bracket is not closed".into(), "add the missing )")),
        }
    }

    fn number(&mut self) -> Result<Term, Fault> {
        let bytes = self.rest().as_bytes();
        let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let mut length = digits(0);
        if bytes.get(length) == Some(&b'.') {
            length += 1 + digits(length + 1);
        }
        if matches!(bytes.get(length), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
            let exponent = digits((length + 1 + sign).min(bytes.len()));
            if exponent > 0 {
                length += 1 + sign + exponent;
            }
        }
        match self.rest()[..length].parse::<f64>() {
            Ok(value) if value.is_finite() => {
                self.at += length;
                Ok(Term::Constant(value))
            }
            _ => {
                let what = format!("{} is not a finite number", &self.rest()[..length]);
                Err(self.fault(length, what, "write it like 1.5 or 2e6"))
            }
        }
    }

    fn name(&mut self) -> Result<Term, Fault> {
        let rest = self.rest();
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let name = &rest[..end];
        if let Some(i) = VARIABLES.iter().position(|v| *v == name) {
            if !self.allowed.contains(&name) {
                let remedy = format!("only {} may occur here", self.allowed.join(", "));
                return Err(self.fault(end, format!("the variable {name} has no meaning here"), &remedy));
            }
            self.at += end;
            return Ok(Term::Variable(i));
        }
        if let Some((_, f)) = UNARY.iter().find(|(n, _)| *n == name) {
            let [a] = self.arguments(name)?;
            return Ok(Term::unary(*f, a));
        }
        if let Some((_, f)) = BINARY.iter().find(|(n, _)| *n == name) {
            let [a, b] = self.arguments(name)?;
            return Ok(Term::binary(*f, a, b));
        }
        if ["pi", "PI", "π"].contains(&name) {
            self.at += end;
            return Ok(Term::Constant(std::f64::consts::PI));
        }
        Err(self.unknown(name))
    }

    /// The arguments of the function `name`, which comes next.
    fn arguments<const N: usize>(&mut self, name: &str) -> Result<[Term; N], Fault> {
        let start = self.at;
        self.at += name.len();
        let counted = |found: &str| Fault {
            span: start..start + name.len(),
            what: format!("{name} takes {N} argument{}{found}", if N == 1 { "" } else { "s" }),
            remedy: format!("write {name}({})", ["x", "y"][..N.min(2)].join(", ")),
        };
        if !self.eat("(") {
            return Err(counted(" in brackets"));
        }
        let mut arguments = Vec::with_capacity(N);
        loop {
            arguments.push(self.bracketed()?);
            if !self.eat(",") {
                break;
            }
        }
        self.close()?;
        let found = arguments.len();
        arguments.try_into().map_err(|_| counted(&format!(", but {found} are given")))
    }

    fn fault(&self, length: usize, what: String, remedy: &str) -> Fault {
        Fault { span: self.at..self.at + length, what, remedy: remedy.into() }
    }

    fn ended(&self) -> Fault {
        if self.text.trim().is_empty() {
            return self.fault(0, "the expression is empty".into(), "write a number or an expression in x, y, z, t");
        }
        self.fault(0, "the expression ends where a value should follow".into(), "complete it, as in 2*x + 1")
    }

    fn unexpected(&self, found: char) -> Fault {
        let remedy = match found {
            ')' => "there is no ( to which it belongs, or nothing stands before it",
            ',' => "a comma only separates the two arguments of min, max and atan2; decimals take a point",
            c if c.is_alphanumeric() || c == '(' => "is an operator missing? A product is written 2*x",
            _ => "expressions use + - * / ^ ( ) and functions such as sin(x)",
        };
        self.fault(found.len_utf8(), format!("{found:?} is not expected here"), remedy)
    }

    fn unknown(&self, name: &str) -> Fault {
        let functions = || UNARY.iter().map(|f| f.0).chain(BINARY.iter().map(|f| f.0));
        let closest = match name {
            "log" => Some("ln or log10"),
            _ => nearest(name, functions().chain(["pi"])).filter(|_| name.len() > 1),
        };
        let guess = closest.map_or(String::new(), |c| format!("did you mean {c}? "));
        let list = functions().collect::<Vec<_>>().join(" ");
        let remedy =
            format!("{guess}The variables are {}; the functions are {list}; pi is known", self.allowed.join(", "));
        let shown: String = name.chars().take(40).collect();
        self.fault(name.len(), format!("{shown:?} is not known in expressions"), &remedy)
    }
}

#[cfg(test)]
mod tests;
