//! The text of a case file, and places in it for error messages.

use std::fmt;
use std::ops::Range;

use crate::Error;

/// Widest excerpt of a line, in characters; longer lines are cut around the marked place.
const WIDTH: usize = 110;

/// A place in the case file with the line it stands on, kept with each item so that any later stage can point at it.
#[derive(Clone, Default, PartialEq)]
pub struct Spot {
    /// `case.toml:12:5`, or the `--set` option the item comes from.
    pub place: String,
    /// The line with its number and a mark below it; empty for an option.
    pub excerpt: String,
}

/// What an item is does not depend on where it stands: the words by which a case is known again leave that out.
impl fmt::Debug for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Spot")
    }
}

impl Spot {
    /// An error at this place: what is wrong, and the remedy.
    pub fn error(&self, what: impl Into<String>, remedy: impl Into<String>) -> Error {
        Error { excerpt: self.excerpt.clone(), ..Error::new(self.place.clone(), what, remedy) }
    }
}

/// Where a value was written.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum At {
    /// Bytes of the file.
    File(Range<usize>),
    /// The override of this number.
    Override(usize),
}

/// A case file and the overrides that go with it.
pub(super) struct Source<'a> {
    /// Name of the file, as it was given.
    pub name: &'a str,
    pub text: &'a str,
    pub overrides: &'a [(String, String)],
    /// Places elsewhere of the tables that begin at these bytes, ascending; empty for a file that someone wrote.
    pub marks: &'a [(usize, Spot)],
}

impl Source<'_> {
    pub(super) fn spot(&self, at: &At) -> Spot {
        match at {
            At::File(span) => match self.marks.partition_point(|mark| mark.0 <= span.start).checked_sub(1) {
                Some(table) => self.marks[table].1.clone(),
                None => self.mark(span),
            },
            At::Override(i) => {
                let place = self.overrides.get(*i).map(|(k, v)| format!("--set {}={}", brief(k), brief(v)));
                Spot { place: place.unwrap_or_default(), excerpt: String::new() }
            }
        }
    }

    /// The place of a range of bytes; any range will do, it is clipped to the text.
    fn mark(&self, span: &Range<usize>) -> Spot {
        let start = boundary(self.text, span.start);
        let line_start = self.text[..start].rfind('\n').map_or(0, |i| i + 1);
        let number = 1 + self.text[..line_start].matches('\n').count();
        let line = self.text[line_start..].split('\n').next().unwrap_or("");
        let column = self.text[line_start..start].chars().count();
        let end = boundary(self.text, span.end.min(line_start + line.trim_end().len())).max(start);
        let marked = self.text[start..end].chars().count().max(1);
        Spot {
            place: format!("{}:{number}:{}", self.name, column + 1),
            excerpt: excerpt(number, line.trim_end(), column, marked),
        }
    }
}

fn excerpt(number: usize, line: &str, column: usize, marked: usize) -> String {
    // Tabs and control characters would shift the mark or upset the terminal.
    let printable = |c: char| if c.is_control() { ' ' } else { c };
    let skipped = if column + marked.min(WIDTH / 2) > WIDTH { column - WIDTH / 3 } else { 0 };
    let shown: String = line.chars().skip(skipped).take(WIDTH).map(printable).collect();
    let mark = "^".repeat(marked.min(WIDTH.saturating_sub(column - skipped)).max(1));
    let gutter = " ".repeat(number.to_string().len());
    format!("{number} | {shown}\n{gutter} | {}{mark}", " ".repeat(column - skipped))
}

/// The last character boundary of `text` not after byte `i`.
fn boundary(text: &str, i: usize) -> usize {
    let i = i.min(text.len());
    (0..=i).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
}

fn brief(text: &str) -> String {
    let printable = |c: char| if c.is_control() { ' ' } else { c };
    let mut short: String = text.chars().take(60).map(printable).collect();
    if text.chars().nth(60).is_some() {
        short.push_str("...");
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(text: &str, span: Range<usize>) -> Spot {
        Source { name: "a.toml", text, overrides: &[], marks: &[] }.spot(&At::File(span))
    }

    #[test]
    fn columns_count_characters_and_the_mark_stands_below() {
        let spot = mark("a = 1\nµ = \"é\" # c\r\n", 12..15);
        assert_eq!(spot.place, "a.toml:2:6");
        assert_eq!(spot.excerpt, "2 | µ = \"é\" # c\n  |      ^^");
    }

    #[test]
    fn spans_beyond_the_text_inside_a_character_or_over_many_lines_are_clipped() {
        assert_eq!(mark("", 5..9).place, "a.toml:1:1");
        assert_eq!(mark("é", 1..1).place, "a.toml:1:1");
        assert_eq!(mark("ab\ncd", 1..5).excerpt, "1 | ab\n  |  ^");
        assert_eq!(mark("ab\n", 3..3).place, "a.toml:2:1");
    }

    #[test]
    fn long_lines_are_cut_around_the_mark() {
        let spot = mark(&"x".repeat(10_000), 5000..5001);
        assert!(spot.place.ends_with(":5001") && spot.excerpt.len() < 300);
        assert!(spot.excerpt.ends_with(" ^"));
    }
}
