//! Lines of a report as data: text, JSON and HTML are made from these.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What is said under one label.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Row {
    /// What it is about.
    pub label: String,
    /// What is reported.
    pub value: String,
    /// Lines that go on with it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub more: Vec<String>,
}

impl Row {
    /// All of it in one line.
    pub fn line(&self) -> String {
        std::iter::once(&self.value).chain(&self.more).map(String::as_str).collect::<Vec<_>>().join("; ")
    }
}

/// Rows in the making.
#[derive(Debug, Default)]
pub(crate) struct Rows(pub Vec<Row>);

impl Rows {
    pub(in crate::run) fn add(&mut self, label: &str, value: String) {
        self.0.push(Row { label: label.into(), value, more: Vec::new() });
    }

    /// Goes on with the last row.
    pub(in crate::run) fn more(&mut self, value: String) {
        match self.0.last_mut() {
            Some(row) => row.more.push(value),
            None => self.add("", value),
        }
    }
}

/// Prints rows, the labels in a column of `width`.
pub(crate) fn print(f: &mut fmt::Formatter<'_>, rows: &[Row], width: usize) -> fmt::Result {
    for row in rows {
        writeln!(f, "  {:<width$} {}", row.label, row.value)?;
        row.more.iter().try_for_each(|value| writeln!(f, "  {:<width$} {value}", ""))?;
    }
    Ok(())
}
