//! Does a tree obey the rules? The first value in the file that does not is the error.

use super::kind::{Key, Kind, Limits, Rules};
use super::nearest::nearest;
use super::source::{At, Source};
use super::tree::{Node, Value};
use crate::Error;

/// Checks the whole tree of `node` against `rules`.
pub(super) fn check(source: &Source, node: &Node, rules: &'static Rules) -> Result<(), Error> {
    Check { source }.table(node, rules, "the case file")
}

struct Check<'a> {
    source: &'a Source<'a>,
}

/// The key a value belongs to, and how to call the value: `size[1]`.
#[derive(Clone, Copy)]
struct Context<'a> {
    key: &'a Key,
    label: &'a str,
}

impl Check<'_> {
    fn error(&self, at: &At, what: String, remedy: impl Into<String>) -> Error {
        self.source.spot(at).error(what, remedy)
    }

    fn table(&self, node: &Node, rules: &'static Rules, label: &str) -> Result<(), Error> {
        let joins = |name: &str| rules.key(name).is_some_and(|key| node.get(key.beside).is_some());
        let choice = |name: &str| rules.one_of.contains(&name) && !joins(name);
        let choices = || node.entries().iter().filter(|e| choice(&e.key));
        if let (Some(first), Some(second)) = (choices().next(), choices().nth(1)) {
            let what = format!("{label} has both `{}` and `{}`", first.key, second.key);
            return Err(self.error(&second.key_at, what, format!("keep one of {}", rules.one_of.join(", "))));
        }
        for entry in node.entries() {
            let Some(key) = rules.key(&entry.key) else {
                return Err(self.unknown(&entry.key_at, &entry.key, rules, label));
            };
            self.value(&entry.node, &key.kind, Context { key, label: key.name })?;
        }
        if let Some(key) = rules.keys.iter().find(|key| key.required && node.get(key.name).is_none()) {
            let (name, remedy) = missing(key);
            return Err(self.error(&node.at, format!("{label} has no {name}"), remedy));
        }
        if !rules.one_of.is_empty() && choices().next().is_none() {
            let examples: Vec<_> = rules.one_of.iter().filter_map(|k| rules.key(k)).map(|k| k.example).collect();
            let what = format!("{label} has none of {}", rules.one_of.join(", "));
            return Err(self.error(&node.at, what, format!("give exactly one: {}", examples.join(", or "))));
        }
        Ok(())
    }

    fn unknown(&self, at: &At, name: &str, rules: &'static Rules, label: &str) -> Error {
        let valid: Vec<_> = rules.keys.iter().map(|k| k.name).collect();
        let shown: String = name.chars().take(40).collect();
        let is_of_obstacle = ["this [[contact]]", "`plane`", "`sphere`", "`cylinder`"].contains(&label);
        if name == "motion" && is_of_obstacle {
            let remedy =
                "put it into `against`, beside the obstacle: against = { plane = { .. }, motion = [0, 0, \"-0.1*t\"] }";
            return self.error(at, format!("{label} has no key \"motion\""), remedy);
        }
        let guess = nearest(name, valid.iter().copied()).map_or(String::new(), |g| format!("did you mean `{g}`? "));
        self.error(
            at,
            format!("{label} has no key {shown:?}"),
            format!("{guess}the valid keys are {}", valid.join(", ")),
        )
    }

    fn value(&self, node: &Node, kind: &Kind, context: Context) -> Result<(), Error> {
        match (kind, &node.value) {
            (Kind::Text, Value::Text(text)) if text.trim().is_empty() => {
                self.fail(node, format!("`{}` is an empty text", context.label), context)
            }
            (Kind::Text, Value::Text(_)) | (Kind::Flag, Value::Flag(_)) | (Kind::Field, Value::Text(_)) => Ok(()),
            (Kind::Field, Value::Integer(_)) => Ok(()),
            (Kind::Field, Value::Number(x)) if x.is_finite() => Ok(()),
            (Kind::Field, Value::Number(x)) => self.fail(node, not_finite(context, *x), context),
            (Kind::Number(limits), Value::Integer(_) | Value::Number(_)) => {
                self.number(node, node.number().unwrap_or(f64::NAN), limits, context)
            }
            (Kind::Whole { from, to }, Value::Integer(i)) if (from..=to).contains(&i) => Ok(()),
            (Kind::Choice { names, absent }, Value::Text(text)) => self.choice(node, text, names, absent, context),
            (Kind::List { of, from, to }, Value::List(items)) if (from..=to).contains(&&items.len()) => {
                for (i, item) in items.iter().enumerate() {
                    let label = format!("{}[{i}]", context.label);
                    self.value(item, of, Context { label: &label, ..context })?;
                }
                Ok(())
            }
            (Kind::Table(rules), Value::Table(_)) => self.table(node, rules, &format!("`{}`", context.label)),
            (Kind::Tables(rules), Value::List(items)) => items.iter().try_for_each(|item| match item.value {
                Value::Table(_) => self.table(item, rules, &format!("this [[{}]]", context.label)),
                _ => self.mismatch(item, kind, context),
            }),
            (Kind::Named(rules), Value::Table(entries)) => self.named(node, entries, rules, context),
            (Kind::Either(kinds), _) => match kinds.iter().find(|kind| fits(kind, node)) {
                Some(kind) => self.value(node, kind, context),
                None => self.mismatch(node, kind, context),
            },
            _ => self.mismatch(node, kind, context),
        }
    }

    fn named(
        &self,
        node: &Node,
        entries: &[super::tree::Entry],
        rules: &'static Rules,
        context: Context,
    ) -> Result<(), Error> {
        if entries.is_empty() {
            let what = format!("`{}` is empty", context.label);
            return Err(self.error(&node.at, what, missing(context.key).1));
        }
        for entry in entries {
            let name: String = entry.key.chars().take(40).collect();
            if name.trim().is_empty() {
                return self.fail(&entry.node, format!("a name in `{}` is empty", context.label), context);
            }
            match entry.node.value {
                Value::Table(_) => self.table(&entry.node, rules, &format!("[{}.{name}]", context.label))?,
                _ => {
                    let what =
                        format!("`{}.{name}` is {}, but a table is wanted", context.label, entry.node.describe());
                    return Err(self.error(&entry.key_at, what, format!("begin with {}", context.key.example)));
                }
            }
        }
        Ok(())
    }

    fn number(&self, node: &Node, x: f64, limits: &Limits, context: Context) -> Result<(), Error> {
        if limits.contain(x) {
            return Ok(());
        }
        if !x.is_finite() {
            return self.fail(node, not_finite(context, x), context);
        }
        if let Some((_, what, remedy)) = limits.special.filter(|special| special.0 == x) {
            return Err(self.error(&node.at, what.into(), remedy));
        }
        let what = format!("`{}` is {x:?}, but a number{} is wanted", context.label, limits.describe());
        if limits.part && limits.contain(x / 100.0) {
            let remedy = format!("did you mean {x}%? write that, or {}", Error::number(x / 100.0));
            return Err(self.error(&node.at, what, remedy));
        }
        if limits.remedy.is_empty() {
            return self.fail(node, what, context);
        }
        Err(self.error(&node.at, what, limits.remedy))
    }

    fn choice(
        &self,
        node: &Node,
        text: &str,
        names: &[(&'static str, &'static str)],
        absent: &[(&'static str, &'static str)],
        context: Context,
    ) -> Result<(), Error> {
        if names.iter().any(|n| n.0 == text) {
            return Ok(());
        }
        if let Some((_, remedy)) = absent.iter().find(|n| n.0 == text) {
            let what = format!("`{} = {text:?}` is not available in this version", context.label);
            return Err(self.error(&node.at, what, *remedy));
        }
        let guess = nearest(text, names.iter().map(|n| n.0)).map_or(String::new(), |g| format!("did you mean {g:?}? "));
        let list: Vec<_> = names.iter().map(|(name, doc)| format!("{name:?} ({doc})")).collect();
        let mut remedy = format!("{guess}the choices are {}", list.join(", "));
        if matches!(context.key.kind, Kind::Either(_)) {
            remedy += &format!("; or a table, as in {}", context.key.example);
        }
        self.error_at(node, format!("`{}` is {}", context.label, node.describe()), remedy)
    }

    fn mismatch(&self, node: &Node, kind: &Kind, context: Context) -> Result<(), Error> {
        let what = format!("`{}` is {}, but {} is wanted", context.label, node.describe(), kind.describe());
        self.fail(node, what, context)
    }

    /// An error whose remedy is the example of the key.
    fn fail(&self, node: &Node, what: String, context: Context) -> Result<(), Error> {
        self.error_at(node, what, format!("write for instance {}", context.key.example))
    }

    fn error_at(&self, node: &Node, what: String, remedy: String) -> Result<(), Error> {
        Err(self.error(&node.at, what, remedy))
    }
}

fn not_finite(context: Context, x: f64) -> String {
    format!("`{}` is {x}, but a finite number is wanted", context.label)
}

/// How to call a missing key, and the remedy.
fn missing(key: &Key) -> (String, String) {
    let remedy = match key.kind {
        // There is more than one way to write it: the doc lists them.
        Kind::Either(_) => format!("add {} ({})", key.example, key.doc.trim_end_matches('.')),
        _ => format!("add {}", key.example),
    };
    match key.kind {
        Kind::Named(_) | Kind::Tables(_) => (format!("[{}]", key.name), remedy),
        _ => (format!("`{}`", key.name), remedy),
    }
}

/// Whether the TOML type of a value is that of `kind`.
fn fits(kind: &Kind, node: &Node) -> bool {
    match kind {
        Kind::Text | Kind::Choice { .. } => matches!(node.value, Value::Text(_)),
        Kind::Number(_) | Kind::Whole { .. } => node.number().is_some(),
        Kind::Field => node.number().is_some() || node.text().is_some(),
        Kind::Flag => matches!(node.value, Value::Flag(_)),
        Kind::List { .. } | Kind::Tables(_) => matches!(node.value, Value::List(_)),
        Kind::Table(_) | Kind::Named(_) => matches!(node.value, Value::Table(_)),
        Kind::Either(kinds) => kinds.iter().any(|kind| fits(kind, node)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::spec::CASE;
    use super::super::tree::{parse, parse_value};
    use super::*;

    /// Calls `visit` for every table of rules below `rules`, itself included.
    fn visit(rules: &'static Rules, f: &mut dyn FnMut(&'static Rules)) {
        fn kinds(kind: &'static Kind, f: &mut dyn FnMut(&'static Rules)) {
            match kind {
                Kind::Table(rules) | Kind::Tables(rules) | Kind::Named(rules) => visit(rules, f),
                Kind::Either(all) => all.iter().for_each(|kind| kinds(kind, f)),
                Kind::List { of, .. } => kinds(of, f),
                _ => {}
            }
        }
        f(rules);
        rules.keys.iter().for_each(|key| kinds(&key.kind, f));
    }

    #[test]
    fn every_example_and_every_default_obeys_its_own_key() {
        let mut count = 0;
        visit(&CASE, &mut |rules| {
            for key in rules.keys {
                let context = Context { key, label: key.name };
                let source = Source { name: "spec", text: key.example, overrides: &[], marks: &[] };
                let check = Check { source: &source };
                let example = parse(&source).unwrap_or_else(|e| panic!("{e}"));
                if !key.example.starts_with('[') {
                    let value = example.get(key.name).unwrap_or_else(|| panic!("{}", key.example));
                    check.value(value, &key.kind, context).unwrap_or_else(|e| panic!("{e}"));
                    count += 1;
                }
                if let Some(default) = parse_value(key.default, &At::Override(0)) {
                    check.value(&default, &key.kind, context).unwrap_or_else(|e| panic!("{e}"));
                    assert!(!key.required);
                }
            }
        });
        assert!(count > 40);
    }

    #[test]
    fn every_choice_between_keys_names_keys_that_exist() {
        visit(&CASE, &mut |rules| assert!(rules.one_of.iter().all(|name| rules.key(name).is_some())));
    }
}
