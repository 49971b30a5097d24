//! The JSON schema of the case file, for editors and for programs that write cases.

use serde_json::{Map, Value, json};

use super::kind::{Key, Kind, Limits, Rules};
use super::source::At;
use super::spec::CASE;
use super::tree::{self, Node};

/// The schema, JSON Schema draft 2020-12. It holds the rules of one table at a time; relations between tables and the
/// names of groups are checked by [`parse`](super::parse) and against the mesh only.
pub fn schema() -> Value {
    let mut schema =
        json!({ "$schema": "https://json-schema.org/draft/2020-12/schema", "title": "Stiction case file" });
    if let (Value::Object(schema), Value::Object(table)) = (&mut schema, table(&CASE)) {
        schema.extend(table);
    }
    schema
}

fn table(rules: &Rules) -> Value {
    let properties: Map<_, _> = rules.keys.iter().map(|key| (key.name.to_string(), property(key))).collect();
    let required: Vec<_> = rules.keys.iter().filter(|key| key.required).map(|key| key.name).collect();
    let mut schema = json!({
        "description": rules.doc,
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
    });
    if !required.is_empty() {
        schema["required"] = json!(required);
    }
    if !rules.one_of.is_empty() {
        let choice = |name: &&str| match rules.key(name).map_or("", |key| key.beside) {
            "" => json!({ "required": [name] }),
            other => json!({ "required": [name], "not": { "required": [other] } }),
        };
        schema["oneOf"] = rules.one_of.iter().map(choice).collect();
    }
    schema
}

fn property(key: &Key) -> Value {
    let mut schema = kind(&key.kind);
    let unit = if key.unit.is_empty() { String::new() } else { format!(" Unit: {}.", key.unit) };
    schema["description"] = json!(format!("{}{unit}", key.doc));
    if let Some(default) = tree::parse_value(key.default, &At::Override(0)) {
        schema["default"] = plain(&default);
    }
    schema
}

fn kind(kind: &Kind) -> Value {
    match kind {
        Kind::Text => json!({ "type": "string", "minLength": 1 }),
        Kind::Number(limits) => number(limits),
        Kind::Whole { from, to } => json!({ "type": "integer", "minimum": from, "maximum": to }),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Choice { names, .. } => {
            let choices: Vec<_> =
                names.iter().map(|(name, doc)| json!({ "const": name, "description": doc })).collect();
            json!({ "type": "string", "oneOf": choices })
        }
        Kind::Field => json!({ "type": ["number", "string"] }),
        Kind::List { of, from, to } => {
            let mut list = json!({ "type": "array", "items": self::kind(of), "minItems": from });
            if *to < usize::MAX {
                list["maxItems"] = json!(to);
            }
            list
        }
        Kind::Table(rules) => table(rules),
        Kind::Tables(rules) => json!({ "type": "array", "items": table(rules) }),
        Kind::Named(rules) => json!({ "type": "object", "additionalProperties": table(rules), "minProperties": 1 }),
        Kind::Either(kinds) => json!({ "anyOf": kinds.iter().map(self::kind).collect::<Vec<_>>() }),
    }
}

fn number(limits: &Limits) -> Value {
    let mut schema = json!({ "type": "number" });
    if limits.low.is_finite() {
        schema[if limits.low_included { "minimum" } else { "exclusiveMinimum" }] = json!(limits.low);
    }
    if limits.high.is_finite() {
        schema[if limits.high_included { "maximum" } else { "exclusiveMaximum" }] = json!(limits.high);
    }
    schema
}

/// A value as JSON.
fn plain(node: &Node) -> Value {
    match &node.value {
        tree::Value::Text(text) => json!(text),
        tree::Value::Integer(i) => json!(i),
        tree::Value::Number(x) => json!(x),
        tree::Value::Flag(flag) => json!(flag),
        tree::Value::Date => Value::Null,
        tree::Value::List(items) => items.iter().map(plain).collect(),
        tree::Value::Table(entries) => {
            entries.iter().map(|e| (e.key.clone(), plain(&e.node))).collect::<Map<_, _>>().into()
        }
    }
}
