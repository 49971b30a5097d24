//! The JSON schema of the case file, for editors and for programs that write cases.

use serde_json::{Map, Value, json};

use super::kind::{Key, Kind, Limits, Rules};
use super::source::At;
use super::spec::CASE;
use super::tree::{self, Node};

/// The schema, JSON Schema draft 2020-12. It holds the rules of one table at a time; relations between tables and the
/// names of groups are checked by [`parse`](super::parse) and against the mesh only.
pub fn schema() -> Value {
    let mut schema = Map::new();
    schema.insert("$schema".into(), json!("https://json-schema.org/draft/2020-12/schema"));
    schema.insert("title".into(), json!("Stiction case file"));
    schema.extend(table(&CASE));
    Value::Object(schema)
}

fn table(rules: &Rules) -> Map<String, Value> {
    let keys = || rules.keys.iter();
    let properties: Map<_, _> = keys().map(|key| (key.name.to_string(), property(key))).collect();
    let required: Vec<_> = keys().filter(|key| key.required).map(|key| key.name).collect();
    let mut schema = Map::new();
    schema.insert("description".into(), json!(rules.doc));
    schema.insert("type".into(), json!("object"));
    schema.insert("properties".into(), Value::Object(properties));
    schema.insert("additionalProperties".into(), json!(false));
    if !required.is_empty() {
        schema.insert("required".into(), json!(required));
    }
    if !rules.one_of.is_empty() {
        let choice = |name: &&str| match rules.key(name).map_or("", |key| key.beside) {
            "" => json!({ "required": [name] }),
            other => json!({ "required": [name], "not": { "required": [other] } }),
        };
        let choices: Vec<_> = rules.one_of.iter().map(choice).collect();
        schema.insert("oneOf".into(), json!(choices));
    }
    schema
}

fn property(key: &Key) -> Value {
    let mut schema = kind(&key.kind);
    let unit = if key.unit.is_empty() { String::new() } else { format!(" Unit: {}.", key.unit) };
    schema.insert("description".into(), json!(format!("{}{unit}", key.doc)));
    if let Some(default) = tree::parse_value(key.default, &At::Override(0)) {
        schema.insert("default".into(), plain(&default));
    }
    Value::Object(schema)
}

fn kind(kind: &Kind) -> Map<String, Value> {
    let schema = match kind {
        Kind::Text => json!({ "type": "string", "minLength": 1 }),
        Kind::Number(limits) => return number(limits),
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
        Kind::Table(rules) => return table(rules),
        Kind::Tables(rules) => json!({ "type": "array", "items": table(rules) }),
        Kind::Named(rules) => json!({ "type": "object", "additionalProperties": table(rules), "minProperties": 1 }),
        Kind::Either(kinds) => {
            json!({ "anyOf": kinds.iter().map(self::kind).collect::<Vec<_>>() })
        }
    };
    match schema {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

fn number(limits: &Limits) -> Map<String, Value> {
    let mut schema = Map::from_iter([("type".to_string(), json!("number"))]);
    if limits.low.is_finite() {
        let name = if limits.low_included { "minimum" } else { "exclusiveMinimum" };
        schema.insert(name.into(), json!(limits.low));
    }
    if limits.high.is_finite() {
        let name = if limits.high_included { "maximum" } else { "exclusiveMaximum" };
        schema.insert(name.into(), json!(limits.high));
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
