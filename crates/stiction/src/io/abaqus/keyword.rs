//! Keyword lines and the data between them.

use crate::Error;
use crate::io::newlines;

/// The remedy for whatever a writer would not have written.
pub(super) const DAMAGED: &str = "correct the line, or write the file again if it is damaged";

/// `*NAME, PARAMETER=VALUE, FLAG`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::io) struct Keyword {
    /// Capitals without blanks and without the star.
    pub name: String,
    /// The same with its blanks, for messages.
    pub title: String,
    /// Names in capitals without blanks; values as written, without quotes.
    parameters: Vec<(String, String)>,
    /// Counted from 1.
    pub line: usize,
    /// As it is written, on one line.
    pub text: String,
}

impl Keyword {
    /// The value of a parameter, empty for a flag.
    pub(in crate::io) fn get(&self, name: &str) -> Option<&str> {
        self.parameters.iter().find(|p| p.0 == name).map(|p| p.1.as_str())
    }

    /// Names of all parameters.
    pub(in crate::io) fn names(&self) -> impl Iterator<Item = &str> {
        self.parameters.iter().map(|p| p.0.as_str())
    }

    /// The value of a parameter that has to be there.
    pub(super) fn needed(&self, name: &str) -> Result<&str, Error> {
        self.get(name).filter(|value| !value.is_empty()).ok_or_else(|| {
            let what = format!("*{} has no {name}=", self.name);
            Error::new(self.place(), what, format!("write *{}, {name}=...", self.name))
        })
    }

    /// `line 12`.
    pub(super) fn place(&self) -> String {
        format!("line {}", self.line)
    }

    fn parse(text: &str, line: usize) -> Keyword {
        let mut fields = split(text).into_iter();
        let squeeze = |s: &str| s.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_uppercase();
        let title = fields.next().unwrap_or("").trim_start_matches('*').trim().to_uppercase();
        let name = squeeze(&title);
        let parameter = |field: &str| match field.split_once('=') {
            Some((name, value)) => (squeeze(name), unquoted(value)),
            None => (squeeze(field), String::new()),
        };
        let parameters = fields.map(parameter).filter(|p| !p.0.is_empty()).collect();
        Keyword { name, parameters, title, line, text: text.to_string() }
    }
}

/// The text without surrounding blanks and quotes.
pub(super) fn unquoted(text: &str) -> String {
    text.trim().trim_matches('"').trim().to_string()
}

/// Splits at commas outside quotes.
fn split(text: &str) -> Vec<&str> {
    let mut quoted = false;
    text.split(|c| {
        quoted ^= c == '"';
        c == ',' && !quoted
    })
    .collect()
}

/// A keyword line, or the lines up to the next one.
pub(super) enum Piece<'a> {
    Keyword(Keyword),
    Data(Data<'a>),
}

/// Lines of data with comments among them.
#[derive(Clone, Copy)]
pub(in crate::io) struct Data<'a> {
    pub bytes: &'a [u8],
    /// Number of the first line, from 1.
    pub line: usize,
}

/// Walks over the pieces of a file.
pub(super) struct Pieces<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Pieces<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Pieces { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), line: 1 }
    }

    /// From the beginning of a line of that number on.
    pub(super) fn from(bytes: &'a [u8], line: usize) -> Self {
        Pieces { rest: bytes, line }
    }

    /// Bytes that are left, and the number of the line they begin.
    pub(super) fn left(&self) -> (usize, usize) {
        (self.rest.len(), self.line)
    }

    fn take_line(&mut self) -> &'a [u8] {
        let (line, rest) = first_line(self.rest);
        self.rest = rest;
        self.line += 1;
        line
    }

    /// A keyword and the lines it goes on over: those behind a comma at the end.
    fn keyword(&mut self) -> Keyword {
        let number = self.line;
        let mut text = String::from_utf8_lossy(self.take_line()).trim().to_string();
        while text.ends_with(',') && !self.rest.is_empty() && Line::of(self.rest) != Line::Keyword {
            let comment = Line::of(self.rest) == Line::Empty;
            let next = self.take_line();
            if !comment {
                text.push_str(String::from_utf8_lossy(next).trim());
            }
        }
        Keyword::parse(&text, number)
    }
}

impl<'a> Iterator for Pieces<'a> {
    type Item = Piece<'a>;

    fn next(&mut self) -> Option<Piece<'a>> {
        while !self.rest.is_empty() && Line::of(self.rest) == Line::Empty {
            self.take_line();
        }
        if self.rest.is_empty() {
            return None;
        }
        if Line::of(self.rest) == Line::Keyword {
            return Some(Piece::Keyword(self.keyword()));
        }
        let (whole, line) = (self.rest, self.line);
        while !self.rest.is_empty() && Line::of(self.rest) != Line::Keyword {
            self.take_line();
        }
        Some(Piece::Data(Data { bytes: &whole[..whole.len() - self.rest.len()], line }))
    }
}

/// What a line is, recognised by its first letters.
#[derive(PartialEq, Eq)]
enum Line {
    Keyword,
    /// Blank or a comment.
    Empty,
    Data,
}

impl Line {
    /// What the line is that `bytes` begin with.
    fn of(bytes: &[u8]) -> Line {
        match bytes.iter().position(|&b| !matches!(b, b' ' | b'\t' | b'\r')).map(|n| &bytes[n..]) {
            None | Some([b'*', b'*', ..] | [b'\n', ..]) => Line::Empty,
            Some([b'*', ..]) => Line::Keyword,
            Some(_) => Line::Data,
        }
    }
}

/// The first line without its end, and what follows it.
fn first_line(bytes: &[u8]) -> (&[u8], &[u8]) {
    match bytes.iter().position(|&b| b == b'\n') {
        Some(end) => (&bytes[..end], &bytes[end + 1..]),
        None => (bytes, &[]),
    }
}

/// Walks over the fields of data lines.
pub(in crate::io) struct Fields<'a> {
    data: Data<'a>,
    pos: usize,
}

impl<'a> Fields<'a> {
    pub(in crate::io) fn new(data: Data<'a>) -> Self {
        let mut fields = Fields { data, pos: 0 };
        fields.skip_empty();
        fields
    }

    /// Whether lines are left.
    pub(in crate::io) fn more(&self) -> bool {
        self.pos < self.data.bytes.len()
    }

    /// The next field of this line without surrounding blanks.
    #[inline]
    pub(in crate::io) fn field(&mut self) -> Option<&'a [u8]> {
        let bytes = self.data.bytes;
        let mut from = self.pos;
        while matches!(bytes.get(from), Some(b' ' | b'\t' | b'\r')) {
            from += 1;
        }
        let mut end = from;
        while !matches!(bytes.get(end), None | Some(b',' | b'\n')) {
            end += 1;
        }
        let comma = bytes.get(end) == Some(&b',');
        self.pos = end + usize::from(comma);
        let mut word = &bytes[from..end];
        while let [head @ .., b' ' | b'\t' | b'\r'] = word {
            word = head;
        }
        (comma || !word.is_empty()).then_some(word)
    }

    /// Moves to the next line of data, whatever is left of this one.
    pub(in crate::io) fn next_line(&mut self) {
        let rest = &self.data.bytes[self.pos..];
        self.pos += rest.len() - first_line(rest).1.len();
        self.skip_empty();
    }

    fn skip_empty(&mut self) {
        loop {
            let rest = &self.data.bytes[self.pos..];
            if rest.is_empty() || Line::of(rest) != Line::Empty {
                return;
            }
            self.pos += rest.len() - first_line(rest).1.len();
        }
    }

    /// A field as text, without quotes.
    pub(in crate::io) fn text(word: &[u8]) -> String {
        unquoted(&String::from_utf8_lossy(word))
    }

    /// The number of this line.
    pub(in crate::io) fn line(&self) -> usize {
        self.data.line + newlines(&self.data.bytes[..self.pos.min(self.data.bytes.len())])
    }

    /// An error on this line.
    pub(super) fn fail(&self, what: impl Into<String>) -> Error {
        Error::new(format!("line {}", self.line()), what, DAMAGED)
    }

    /// An error on this line about a word that is no `what`.
    pub(super) fn not_a(&self, word: &[u8], what: &str) -> Error {
        let shown = String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned();
        self.fail(format!("\"{shown}\" stands where {what} was expected"))
    }
}
