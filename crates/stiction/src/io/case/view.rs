//! Typed access to a table that `check` has accepted: absent keys take the defaults of `spec`.
//!
//! A panic here means that the reader and the spec disagree, never that the file is wrong.

use std::borrow::Cow;

use super::kind::{Kind, Rules};
use super::source::{At, Source, Spot};
use super::tree::{Node, Value, parse_value};
use crate::Error;

#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub source: &'a Source<'a>,
    pub rules: &'static Rules,
    pub node: &'a Node,
}

impl<'a> View<'a> {
    /// The value of `key` if the file gives it.
    pub(super) fn given(&self, key: &str) -> Option<&'a Node> {
        self.node.get(key)
    }

    /// The value of `key` or its default.
    fn get(&self, key: &str) -> Cow<'a, Node> {
        let default = || {
            let text = self.rules.key(key).map_or("", |k| k.default);
            parse_value(text, &self.node.at).map(Cow::Owned)
        };
        match self.given(key).map(Cow::Borrowed).or_else(default) {
            Some(node) => node,
            None => panic!("the spec makes {key} neither required nor gives it a default"),
        }
    }

    pub(super) fn number(&self, key: &str) -> f64 {
        self.get(key).number().unwrap_or(f64::NAN)
    }

    pub(super) fn text(&self, key: &str) -> String {
        self.get(key).text().unwrap_or_default().to_string()
    }

    pub(super) fn flag(&self, key: &str) -> bool {
        matches!(self.get(key).value, Value::Flag(true))
    }

    pub(super) fn vector(&self, key: &str) -> [f64; 3] {
        vector(&self.get(key))
    }

    /// A list of two vectors.
    pub(super) fn vectors(&self, key: &str) -> [[f64; 3]; 2] {
        let node = self.get(key);
        std::array::from_fn(|i| node.items().get(i).map_or([f64::NAN; 3], vector))
    }

    /// A whole number, known to be >= 0.
    pub(super) fn count(&self, key: &str) -> usize {
        count(&self.get(key))
    }

    pub(super) fn counts(&self, key: &str) -> [usize; 3] {
        let node = self.get(key);
        std::array::from_fn(|i| node.items().get(i).map_or(0, count))
    }

    /// The table under `key`, if the file gives it.
    pub(super) fn table(&self, key: &str) -> Option<View<'a>> {
        let node = self.given(key)?;
        Some(View { source: self.source, rules: rules_of(&self.rules.key(key)?.kind)?, node })
    }

    /// The tables of `[[key]]` or `[key.name]`, with their names in the second case.
    pub(super) fn tables(&self, key: &str) -> Vec<(&'a str, View<'a>)> {
        let (Some(node), Some(rules)) = (self.given(key), self.rules.key(key).and_then(|k| rules_of(&k.kind))) else {
            return Vec::new();
        };
        let view = |node| View { source: self.source, rules, node };
        let named = node.entries().iter().map(|e| (e.key.as_str(), view(&e.node)));
        node.items().iter().map(|item| ("", view(item))).chain(named).collect()
    }

    /// Where the table is, after the overrides that have changed it: what is wrong may be theirs.
    pub(super) fn spot(&self) -> Spot {
        let spot = self.source.spot(&self.node.at);
        let mut changes = Vec::new();
        overrides_in(self.node, &mut changes);
        changes.sort_unstable();
        changes.dedup();
        if changes.is_empty() || matches!(self.node.at, At::Override(_)) {
            return spot;
        }
        let named: Vec<String> = changes.iter().map(|&i| self.source.spot(&At::Override(i)).place).collect();
        Spot { place: format!("{} ({})", named.join(" and "), spot.place), ..spot }
    }

    /// An error at the first of `keys` that the file gives: "`key` " and why it must not be there. The remedy is to take it
    /// out, or else what `or` says.
    pub(super) fn refuse(&self, keys: &[&str], why: &str, or: &str) -> Result<(), Error> {
        match keys.iter().find(|key| self.given(key).is_some()) {
            Some(key) => Err(self.error(key, format!("`{key}` {why}"), format!("take `{key}` out{or}"))),
            None => Ok(()),
        }
    }

    /// An error at the value of `key` if the file gives it, else at the table.
    pub(super) fn error(&self, key: &str, what: impl Into<String>, remedy: impl Into<String>) -> Error {
        self.source.spot(self.at(key)).error(what, remedy)
    }

    fn at(&self, key: &str) -> &'a At {
        self.given(key).map_or(&self.node.at, |node| &node.at)
    }
}

/// The overrides that anything in `node` comes from.
fn overrides_in(node: &Node, found: &mut Vec<usize>) {
    if let At::Override(i) = node.at {
        found.push(i);
    }
    let entries = node.entries().iter().map(|entry| &entry.node);
    node.items().iter().chain(entries).for_each(|inner| overrides_in(inner, found));
}

pub(super) fn vector(node: &Node) -> [f64; 3] {
    std::array::from_fn(|i| node.items().get(i).and_then(Node::number).unwrap_or(f64::NAN))
}

fn count(node: &Node) -> usize {
    match node.value {
        Value::Integer(i) => usize::try_from(i).unwrap_or(0),
        _ => 0,
    }
}

fn rules_of(kind: &Kind) -> Option<&'static Rules> {
    match kind {
        Kind::Table(rules) | Kind::Tables(rules) | Kind::Named(rules) => Some(rules),
        Kind::Either(kinds) => kinds.iter().find_map(rules_of),
        _ => None,
    }
}
