//! Cards of a deck that say nothing of the mesh, as they are written.

use super::keyword::{Data, Fields, Keyword};
use crate::Error;
use crate::io::number::{float, integer};

/// A keyword with its lines.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::io) struct Card {
    pub keyword: Keyword,
    /// The included files it stands in, each with a comma behind it.
    pub files: String,
    /// The part it stands in, 0 for none.
    pub part: usize,
    /// Lines between comments and includes, each with the number of its first.
    pub data: Vec<(usize, Vec<u8>)>,
}

/// A line of data.
#[derive(Debug, Clone)]
pub(in crate::io) struct Row<'a> {
    pub card: &'a Card,
    pub line: usize,
    /// Without surrounding blanks and quotes.
    pub fields: Vec<String>,
}

impl Card {
    /// Its place in the input.
    pub(in crate::io) fn place(&self) -> String {
        format!("{}line {}", self.files, self.keyword.line)
    }

    /// The line of the keyword as messages show it.
    pub(in crate::io) fn excerpt(&self) -> String {
        excerpt(self.keyword.line, &self.keyword.text)
    }

    /// An error at this card.
    pub(in crate::io) fn error(&self, what: impl Into<String>, remedy: impl Into<String>) -> Error {
        Error { excerpt: self.excerpt(), ..Error::new(self.place(), what, remedy) }
    }

    /// The line of the keyword, for what looks for names at a line of data.
    pub(in crate::io) fn head(&self) -> Row<'_> {
        Row { card: self, line: self.keyword.line, fields: vec![self.keyword.text.clone()] }
    }

    /// An error unless all its parameters are among `known`.
    pub(in crate::io) fn only(&self, known: &[&str]) -> Result<(), Error> {
        match self.keyword.names().find(|name| !known.contains(name)) {
            None => Ok(()),
            Some(name) => {
                let what = format!("the parameter {name} of *{} is not read", self.keyword.title);
                let known = if known.is_empty() { "none".to_string() } else { known.join(", ") };
                Err(self.error(what, format!("take it out if it changes nothing; those that are read: {known}")))
            }
        }
    }

    /// The value of a parameter that has to be there.
    pub(in crate::io) fn needed(&self, name: &str) -> Result<&str, Error> {
        self.keyword.get(name).filter(|value| !value.is_empty()).ok_or_else(|| {
            let title = &self.keyword.title;
            self.error(format!("*{title} has no {name}="), format!("write *{title}, {name}=..."))
        })
    }

    /// Whether the parameter is there, whatever its value.
    pub(in crate::io) fn has(&self, name: &str) -> bool {
        self.keyword.get(name).is_some()
    }

    /// Its lines of data.
    pub(in crate::io) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.data.iter().flat_map(move |(line, bytes)| {
            let mut fields = Fields::new(Data { bytes, line: *line });
            std::iter::from_fn(move || {
                if !fields.more() {
                    return None;
                }
                let (line, mut words) = (fields.line(), Vec::new());
                while let Some(word) = fields.field() {
                    words.push(Fields::text(word));
                }
                fields.next_line();
                Some(Row { card: self, line, fields: words })
            })
        })
    }

    /// Its only line of data, if it has one.
    pub(in crate::io) fn row(&self) -> Result<Option<Row<'_>>, Error> {
        let mut rows = self.rows();
        let first = rows.next();
        match rows.next() {
            Some(second) => {
                let what = format!("a second line under *{} is not read", self.keyword.title);
                Err(second.error(what, "keep one line, and one value whatever the temperature"))
            }
            None => Ok(first),
        }
    }
}

impl Row<'_> {
    /// An error on this line.
    pub(in crate::io) fn error(&self, what: impl Into<String>, remedy: impl Into<String>) -> Error {
        let place = format!("{}line {}", self.card.files, self.line);
        Error { excerpt: excerpt(self.line, &self.fields.join(", ")), ..Error::new(place, what, remedy) }
    }

    /// The field at `i`, `None` where it is empty.
    pub(in crate::io) fn word(&self, i: usize) -> Option<&str> {
        self.fields.get(i).map(String::as_str).filter(|word| !word.is_empty())
    }

    /// The word at `i`, which has to be there; `what` names it.
    pub(in crate::io) fn needed(&self, i: usize, what: &str) -> Result<&str, Error> {
        self.word(i).ok_or_else(|| {
            let remedy = format!("give it as field {} of the line", i + 1);
            self.error(format!("{what} is missing"), remedy)
        })
    }

    /// The number at `i`; `None` where the field is empty.
    pub(in crate::io) fn number(&self, i: usize) -> Result<Option<f64>, Error> {
        let Some(word) = self.word(i) else { return Ok(None) };
        match float(word.as_bytes()).filter(|x| x.is_finite()) {
            Some(number) => Ok(Some(number)),
            None => Err(self.error(format!("{:?} stands where a number was expected", short(word)), "correct it")),
        }
    }

    /// The number at `i`, which has to be there; `what` names it.
    pub(in crate::io) fn value(&self, i: usize, what: &str) -> Result<f64, Error> {
        self.needed(i, what)?;
        self.number(i).map(|x| x.unwrap_or(f64::NAN))
    }

    /// The whole number at `i`, or `None` where there is none.
    pub(in crate::io) fn whole(&self, i: usize) -> Option<i64> {
        self.word(i).and_then(|word| integer(word.as_bytes()))
    }

    /// An error if a field from `from` on is not empty.
    pub(in crate::io) fn ends(&self, from: usize) -> Result<(), Error> {
        match (from..self.fields.len()).find_map(|i| self.word(i)) {
            None => Ok(()),
            Some(word) => {
                let what = format!("{:?} is more than *{} is read with", short(word), self.card.keyword.title);
                Err(self.error(what, "take it out if it changes nothing"))
            }
        }
    }
}

/// A word as messages quote it.
fn short(word: &str) -> String {
    word.chars().take(40).map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn excerpt(line: usize, text: &str) -> String {
    let shown: String = text.chars().take(100).map(|c| if c.is_control() { ' ' } else { c }).collect();
    format!("{line} | {shown}")
}
