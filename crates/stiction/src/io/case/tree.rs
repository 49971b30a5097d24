//! The values of a case file with their places, before their meaning is known.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::source::{At, Source};
use crate::Error;

/// A value and where it was written.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub value: Value,
    pub at: At,
}

#[derive(Debug, Clone)]
pub(super) enum Value {
    Text(String),
    Integer(i64),
    Number(f64),
    Flag(bool),
    Date,
    List(Vec<Node>),
    /// In the order of the file.
    Table(Vec<Entry>),
}

#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub key: String,
    pub key_at: At,
    pub node: Node,
}

impl Node {
    pub(super) fn number(&self) -> Option<f64> {
        match self.value {
            Value::Integer(i) => Some(i as f64),
            Value::Number(x) => Some(x),
            _ => None,
        }
    }

    pub(super) fn text(&self) -> Option<&str> {
        match &self.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The entries of a list; empty for anything else.
    pub(super) fn items(&self) -> &[Node] {
        match &self.value {
            Value::List(items) => items,
            _ => &[],
        }
    }

    /// The entries of a table; empty for anything else.
    pub(super) fn entries(&self) -> &[Entry] {
        match &self.value {
            Value::Table(entries) => entries,
            _ => &[],
        }
    }

    pub(super) fn get(&self, key: &str) -> Option<&Node> {
        self.entries().iter().find(|e| e.key == key).map(|e| &e.node)
    }

    /// What the value is, for messages: `the text "abc"`.
    pub(super) fn describe(&self) -> String {
        match &self.value {
            Value::Text(text) => format!("the text {:?}", text.chars().take(40).collect::<String>()),
            Value::Integer(i) => format!("the number {i}"),
            Value::Number(x) => format!("the number {x:?}"),
            Value::Flag(flag) => format!("{flag}"),
            Value::Date => "a date".into(),
            Value::List(items) if items.len() == 1 => "a list of 1 entry".into(),
            Value::List(items) => format!("a list of {} entries", items.len()),
            Value::Table(_) => "a table".into(),
        }
    }
}

/// The tree of a whole file.
pub(super) fn parse(source: &Source) -> Result<Node, Error> {
    let table = DeTable::parse(source.text).map_err(|error| syntax(source, &error))?;
    let span = table.span();
    let entries = entries(table.into_inner(), &At::File).map_err(|at| out_of_range(source, &at))?;
    Ok(Node { value: Value::Table(entries), at: At::File(span.start..span.start) })
}

/// The tree of one value written on its own; `None` if the text is no TOML value.
pub(super) fn parse_value(text: &str, at: &At) -> Option<Node> {
    let value = DeValue::parse(text).ok()?;
    node(value, &|_| at.clone()).ok()
}

/// Converts with `place` from spans to places; `Err` is the place of an integer that does not fit.
fn node(value: Spanned<DeValue>, place: &dyn Fn(Range<usize>) -> At) -> Result<Node, At> {
    let at = place(value.span());
    let value = match value.into_inner() {
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
            Ok(i) => Value::Integer(i),
            Err(_) => return Err(at),
        },
        DeValue::Float(x) => Value::Number(x.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Value::Flag(flag),
        DeValue::Datetime(_) => Value::Date,
        DeValue::Array(items) => {
            Value::List(items.into_iter().map(|item| node(item, place)).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => Value::Table(entries(table, place)?),
    };
    Ok(Node { value, at })
}

fn entries(table: DeTable, place: &dyn Fn(Range<usize>) -> At) -> Result<Vec<Entry>, At> {
    let mut pairs: Vec<_> = table.into_iter().collect();
    // The parser sorts by name; the first error reported should be the first in the file.
    pairs.sort_by_key(|(key, _)| key.span().start);
    let entry = |(key, value): (Spanned<std::borrow::Cow<str>>, _)| {
        let key_at = place(key.span());
        Ok(Entry { key: key.into_inner().into_owned(), key_at, node: node(value, place)? })
    };
    pairs.into_iter().map(entry).collect()
}

fn out_of_range(source: &Source, at: &At) -> Error {
    source.spot(at).error("the integer is too large", "write it as a decimal number, like 1e20")
}

fn syntax(source: &Source, error: &toml::de::Error) -> Error {
    let span = error.span().unwrap_or(0..0);
    let remedy = if error.message().contains("duplicate key") {
        "keep one of the two; entries that may come several times have double brackets, like [[contact]]"
    } else {
        "lines read `key = value`; numbers have a decimal point, texts stand in double quotes, lists in [ ], tables in { }"
    };
    source.spot(&At::File(span)).error(format!("this is not TOML: {}", error.message()), remedy)
}
