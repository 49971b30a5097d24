//! The text of a case file as it grows, with the place in the deck that each table comes from.

use std::fmt::Write as _;

use super::history::number;
use crate::io::abaqus::{Card, Row};
use crate::io::case::Spot;

/// TOML under way.
#[derive(Default)]
pub(super) struct Text {
    pub text: String,
    /// Where a table begins in `text`, and its place in the deck.
    pub marks: Vec<(usize, Spot)>,
}

impl Text {
    /// Begins a table that comes from `spot`, under a comment that says so.
    pub(super) fn table(&mut self, header: &str, spot: Spot) {
        self.text.push('\n');
        self.marks.push((self.text.len(), spot.clone()));
        let _ = match spot.excerpt.split_once(" | ") {
            Some((_, line)) => writeln!(self.text, "{header:<34} # {}: {}", spot.place, line.trim()),
            None => writeln!(self.text, "{header}"),
        };
    }

    pub(super) fn line(&mut self, key: &str, value: &str) {
        let _ = writeln!(self.text, "{key} = {value}");
    }
}

/// A text as TOML.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out += "\\\"",
            '\\' => out += "\\\\",
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out + "\""
}

/// A list of texts as TOML; one of them alone is no list.
pub(super) fn list(names: &[String]) -> String {
    match names {
        [only] => quoted(only),
        _ => format!("[{}]", names.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(", ")),
    }
}

/// Three numbers as TOML.
pub(super) fn triple(x: [f64; 3]) -> String {
    format!("[{}]", x.map(number).join(", "))
}

pub(super) fn of_card(card: &Card) -> Spot {
    Spot { place: card.place(), excerpt: card.excerpt() }
}

pub(super) fn of_row(row: &Row) -> Spot {
    let error = row.error("", "");
    Spot { place: error.place, excerpt: error.excerpt }
}
