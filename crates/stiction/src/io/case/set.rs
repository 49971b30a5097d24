//! Overrides `--set contact.0.friction.coulomb=0.2`, applied to the tree before it is checked.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::source::{At, Source};
use super::tree::{Entry, Node, Value, parse_value};
use crate::Error;

/// Applies the overrides in their order; a later one wins.
pub(super) fn apply(source: &Source, root: &mut Node) -> Result<(), Error> {
    for (i, (path, value)) in source.overrides.iter().enumerate() {
        let at = At::Override(i);
        let fail = |what: String, remedy: String| source.spot(&at).error(what, remedy);
        let keys = split(path).ok_or_else(|| {
            fail(
                format!("{path:?} is no path of keys"),
                "write keys with points between, as in solver.tolerance".into(),
            )
        })?;
        // A text need not be quoted: --set contact.0.on=z-min.
        let value = parse_value(value.trim(), &at)
            .unwrap_or_else(|| Node { value: Value::Text(value.clone()), at: at.clone() });
        put(root, &keys, value, &at).map_err(|(what, remedy)| fail(what, remedy))?;
    }
    Ok(())
}

/// The keys of a dotted path, which may be quoted as in TOML.
fn split(path: &str) -> Option<Vec<String>> {
    if path.contains(['\n', '\r', '=']) {
        return None;
    }
    let line = format!("{path} = 0");
    let mut table = DeTable::parse(&line).ok()?.into_inner();
    let mut keys = Vec::new();
    loop {
        let (key, value) = table.into_iter().next()?;
        keys.push(key.into_inner().into_owned());
        match Spanned::into_inner(value) {
            DeValue::Table(inner) => table = inner,
            _ => return Some(keys),
        }
    }
}

/// Puts `value` under `keys`; `Err` is what is wrong and the remedy.
fn put(node: &mut Node, keys: &[String], value: Node, at: &At) -> Result<(), (String, String)> {
    let Some((key, rest)) = keys.split_first() else {
        *node = value;
        return Ok(());
    };
    let found = node.describe();
    match &mut node.value {
        Value::Table(entries) => {
            let old = entries.iter().any(|e| e.key == *key);
            let i = entries.iter().position(|e| e.key == *key).unwrap_or_else(|| {
                let empty = Node { value: Value::Table(Vec::new()), at: at.clone() };
                entries.push(Entry { key: key.clone(), key_at: at.clone(), node: empty });
                entries.len() - 1
            });
            if !old || rest.is_empty() {
                entries[i].key_at = at.clone();
            }
            put(&mut entries[i].node, rest, value, at)
        }
        Value::List(items) => {
            let count = items.len();
            match key.parse::<usize>().ok().and_then(|i| items.get_mut(i)) {
                Some(item) => put(item, rest, value, at),
                None => Err((
                    format!("{key:?} is no entry of {found}"),
                    match count {
                        0 => "set the whole list".into(),
                        _ => format!("entries are counted from 0, the last is {}", count - 1),
                    },
                )),
            }
        }
        _ => Err((
            format!("{key:?} cannot be set inside {found}"),
            format!("set the whole value, as in --set ...={{ {key} = ... }}"),
        )),
    }
}
