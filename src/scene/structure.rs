//! Compares the tree of a file with the JSON schema of [`Scene`](super::Scene), which schemars derives from the types: every
//! unknown or missing key and every value of a wrong kind is found at once, each with its place. What passes here, serde reads.

use super::fault::{Fault, hint, nearest, plain};
use super::parse::tree::{Faults, Node, Value, join};
use indexmap::IndexMap;
use serde_json::{Map, Value as Json};

/// Every place where `root` does not fit `schema`.
pub(super) fn faults(root: &Node, schema: &Json) -> Faults {
    let mut walk = Walk { schema, faults: Vec::new() };
    walk.visit(root, schema, "");
    walk.faults
}

/// What a part of the schema asks for, in the few forms that schemars uses for serde types.
enum Form<'a> {
    Number,
    /// A whole number that is not negative, as all of a scene are.
    Integer,
    Text,
    Flag,
    List(&'a Json),
    /// A struct: its keys, and which of them are required.
    Record {
        keys: &'a Map<String, Json>,
        required: Vec<&'a str>,
    },
    /// A map: the schema of the names where they are limited, and of the values.
    Names {
        names: Option<&'a Json>,
        values: &'a Json,
    },
    /// An enum without data.
    Words(Vec<&'a str>),
    /// An enum with data: a table with exactly one of these keys.
    Choice(Vec<(&'a str, &'a Json)>),
    /// An untagged enum.
    AnyOf(Vec<&'a Json>),
}

struct Walk<'a> {
    schema: &'a Json,
    faults: Faults,
}

impl<'a> Walk<'a> {
    fn visit(&mut self, node: &Node, schema: &'a Json, path: &str) {
        let (form, may_be_null) = form(self.schema, schema);
        match (&form, &node.value) {
            (_, Value::Null) if may_be_null => {}
            (Form::Number, Value::Float(value)) if !value.is_finite() => {
                self.fault(node, path, format!("is {}; must be a finite number", plain(*value)));
            }
            (Form::Number, Value::Integer(_) | Value::Float(_)) | (Form::Text, Value::String(_)) | (Form::Flag, Value::Bool(_)) => {}
            (Form::Integer, Value::Integer(value)) => {
                if u64::try_from(*value).is_err() {
                    self.fault(node, path, format!("is {value}; must be a whole number, not negative and below 2^64"));
                }
            }
            (Form::List(items), Value::Array(nodes)) => {
                for (index, item) in nodes.iter().enumerate() {
                    self.visit(item, items, &format!("{path}[{index}]"));
                }
            }
            (Form::Record { keys, required }, Value::Table(entries)) => self.record(node, entries, keys, required, path),
            (Form::Names { names, values }, Value::Table(entries)) => {
                let allowed = names.map(|names| form_words(self.schema, names));
                for (name, child) in entries {
                    match &allowed {
                        Some(words) if !words.contains(&name.as_str()) => self.unknown(child, path, "key", name, words),
                        _ => self.visit(child, values, &join(path, name)),
                    }
                }
            }
            (Form::Words(words), Value::String(word)) => {
                if !words.contains(&word.as_str()) {
                    self.fault(node, path, format!("is \"{word}\"{}", hint(word, words)));
                }
            }
            (Form::Choice(choices), Value::Table(entries)) => self.choice(node, entries, choices, path),
            (Form::AnyOf(branches), value) => match branches.iter().find(|branch| self.takes(branch, value)) {
                Some(branch) => self.visit(node, branch, path),
                None => self.wrong_kind(node, schema, path),
            },
            _ => self.wrong_kind(node, schema, path),
        }
    }

    fn record(&mut self, node: &Node, entries: &IndexMap<String, Node>, keys: &'a Map<String, Json>, required: &[&str], path: &str) {
        let allowed: Vec<&str> = keys.keys().map(String::as_str).collect();
        for (name, child) in entries {
            match keys.get(name) {
                Some(schema) => self.visit(child, schema, &join(path, name)),
                None => self.unknown(child, path, "key", name, &allowed),
            }
        }
        // A missing key that was only mistyped is one fault, not two.
        let mistyped: Vec<&str> =
            entries.keys().filter(|name| !keys.contains_key(*name)).filter_map(|name| nearest(name, allowed.iter().copied())).collect();
        for name in required.iter().filter(|name| !entries.contains_key(**name) && !mistyped.contains(name)) {
            let wanted = describe(self.schema, &keys[*name], false);
            self.fault(node, &join(path, name), format!("is missing; must be {wanted}"));
        }
    }

    fn choice(&mut self, node: &Node, entries: &IndexMap<String, Node>, choices: &[(&str, &'a Json)], path: &str) {
        let allowed: Vec<&str> = choices.iter().map(|(key, _)| *key).collect();
        if entries.len() != 1 {
            let found = if entries.is_empty() { "none".into() } else { entries.keys().map(String::as_str).collect::<Vec<_>>().join(", ") };
            self.fault(node, path, format!("has the keys: {found}; must have exactly one of: {}", allowed.join(", ")));
        }
        for (name, child) in entries {
            match choices.iter().find(|(key, _)| key == name) {
                Some((_, schema)) => self.visit(child, schema, &join(path, name)),
                None => self.unknown(child, path, "kind", name, &allowed),
            }
        }
    }

    /// Whether a value is meant for a branch of an untagged enum: of its kind, or one of its words.
    fn takes(&self, branch: &'a Json, value: &Value) -> bool {
        match (form(self.schema, branch).0, value) {
            (Form::Words(words), Value::String(word)) => words.contains(&word.as_str()),
            (Form::Number | Form::Integer, Value::Integer(_) | Value::Float(_))
            | (Form::Text, Value::String(_))
            | (Form::Flag, Value::Bool(_))
            | (Form::List(_), Value::Array(_))
            | (Form::Record { .. } | Form::Names { .. } | Form::Choice(_), Value::Table(_)) => true,
            _ => false,
        }
    }

    fn wrong_kind(&mut self, node: &Node, schema: &Json, path: &str) {
        let message = format!("is {}; must be {}", found(&node.value), describe(self.schema, schema, false));
        self.fault(node, path, message);
    }

    fn unknown(&mut self, child: &Node, path: &str, what: &str, name: &str, allowed: &[&str]) {
        self.faults.push((child.key, Fault::new(path, format!("unknown {what} `{name}`{}", hint(name, allowed)))));
    }

    fn fault(&mut self, node: &Node, path: &str, message: String) {
        self.faults.push((node.place(), Fault::new(path, message)));
    }
}

/// The part of the schema that a `$ref` points at.
fn resolve<'a>(root: &'a Json, schema: &'a Json) -> &'a Json {
    let target = schema["$ref"].as_str().and_then(|reference| root.pointer(reference.strip_prefix('#')?));
    target.map_or(schema, |target| resolve(root, target))
}

/// The form of a part of the schema, and whether `null` stands for leaving it out.
fn form<'a>(root: &'a Json, schema: &'a Json) -> (Form<'a>, bool) {
    let schema = resolve(root, schema);
    if let Some(branches) = schema["anyOf"].as_array() {
        let is_null = |branch: &&Json| branch["type"] == "null";
        let may_be_null = branches.iter().any(|branch| is_null(&branch));
        let branches: Vec<&Json> = branches.iter().filter(|branch| !is_null(branch)).collect();
        return match branches[..] {
            [only] => (form(root, only).0, may_be_null),
            _ => (Form::AnyOf(branches), may_be_null),
        };
    }
    if let Some(branches) = schema["oneOf"].as_array() {
        let words: Vec<&str> = branches.iter().filter_map(|branch| branch["const"].as_str()).collect();
        let choice = |branch: &'a Json| branch["properties"].as_object().and_then(|keys| keys.iter().next());
        let choices = branches.iter().filter_map(choice).map(|(key, schema)| (key.as_str(), schema)).collect();
        return (if words.is_empty() { Form::Choice(choices) } else { Form::Words(words) }, false);
    }
    // `"type": ["number", "null"]` is an optional number.
    let kinds: Vec<&str> = match &schema["type"] {
        Json::Array(kinds) => kinds.iter().filter_map(Json::as_str).collect(),
        kind => kind.as_str().into_iter().collect(),
    };
    let form = match kinds.iter().find(|kind| **kind != "null") {
        Some(&"number") => Form::Number,
        Some(&"integer") => Form::Integer,
        Some(&"string") => Form::Text,
        Some(&"boolean") => Form::Flag,
        Some(&"array") => Form::List(&schema["items"]),
        _ => match schema["properties"].as_object() {
            Some(keys) => {
                let required = schema["required"].as_array().into_iter().flatten().filter_map(Json::as_str).collect();
                Form::Record { keys, required }
            }
            None => Form::Names { names: schema.get("propertyNames"), values: &schema["additionalProperties"] },
        },
    };
    (form, kinds.contains(&"null"))
}

fn form_words<'a>(root: &'a Json, schema: &'a Json) -> Vec<&'a str> {
    match form(root, schema).0 {
        Form::Words(words) => words,
        _ => Vec::new(),
    }
}

/// What a part of the schema asks for, in words: one of it, or many.
fn describe(root: &Json, schema: &Json, many: bool) -> String {
    let word = |one: &str, more: &str| if many { more.to_string() } else { one.to_string() };
    // The only untagged enum whose text has a meaning of its own.
    if schema["$ref"] == "#/$defs/Expr" {
        return word("a number or a formula in quotes", "numbers or formulas in quotes");
    }
    match form(root, schema).0 {
        Form::Number => word("a number", "numbers"),
        Form::Integer => word("a whole number", "whole numbers"),
        Form::Text => word("text in quotes", "texts in quotes"),
        Form::Flag => word("true or false", "true or false"),
        Form::List(items) => format!("{} of {}", word("a list", "lists"), describe(root, items, true)),
        Form::Record { keys, .. } => {
            let keys: Vec<&str> = keys.keys().map(String::as_str).collect();
            format!("{} with the keys {}", word("a table", "tables"), keys.join(", "))
        }
        Form::Names { .. } => word("a table of names", "tables of names"),
        Form::Words(words) => words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or "),
        Form::Choice(choices) => {
            let keys: Vec<&str> = choices.iter().map(|(key, _)| *key).collect();
            format!("{} with one of the keys {}", word("a table", "tables"), keys.join(", "))
        }
        Form::AnyOf(branches) => branches.iter().map(|branch| describe(root, branch, many)).collect::<Vec<_>>().join(", or "),
    }
}

/// A value that is of a wrong kind, in words.
fn found(value: &Value) -> String {
    // Enough to know it again.
    const SHOWN: usize = 40;
    match value {
        Value::Null => "null".into(),
        Value::Bool(value) => value.to_string(),
        Value::Integer(value) => value.to_string(),
        Value::Float(value) => format!("{value:?}"),
        Value::String(text) if text.chars().count() > SHOWN => format!("the text \"{}...\"", text.chars().take(SHOWN).collect::<String>()),
        Value::String(text) => format!("the text \"{text}\""),
        Value::Date(text) => format!("the date {text}"),
        Value::Array(items) if items.is_empty() => "an empty list".into(),
        Value::Array(items) => format!("a list of {}", items.len()),
        Value::Table(entries) if entries.is_empty() => "an empty table".into(),
        Value::Table(entries) => {
            let keys: Vec<&str> = entries.keys().take(5).map(String::as_str).collect();
            format!("a table with {}", keys.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse::tree;
    use super::*;

    /// Faults of TOML text against a schema that has each form once, as they print.
    fn said(text: &str) -> Vec<String> {
        let schema = serde_json::json!({
            "type": "object", "required": ["on", "size"], "additionalProperties": false,
            "properties": {
                "on": { "type": "boolean" },
                "size": { "anyOf": [{ "type": "integer" }, { "type": "array", "items": { "type": "integer" } }] },
                "colour": { "anyOf": [{ "oneOf": [{ "const": "red" }, { "const": "green" }] }, { "type": "null" }] },
                "note": { "type": ["string", "null"] },
            },
        });
        let root = tree::from_toml(text).unwrap();
        faults(&root, &schema).into_iter().map(|(place, fault)| format!("{place:?} {fault}")).collect()
    }

    #[test]
    fn every_form_is_compared() {
        assert!(said("on = true\nsize = 3\ncolour = \"red\"\nnote = \"n\"").is_empty());
        assert_eq!(
            said("on = 1\nsize = [1, 2.5]\ncolour = \"rd\"\nnote = []"),
            [
                "Text(5) on: is 1; must be true or false",
                "Text(18) size[1]: is 2.5; must be a whole number",
                "Text(32) colour: is \"rd\"; did you mean `red`?; allowed: red, green",
                "Text(44) note: is an empty list; must be text in quotes",
            ]
        );
    }

    #[test]
    fn a_mistyped_key_is_not_missing_as_well() {
        assert_eq!(said("on = true\nsiez = 3"), ["Text(10) unknown key `siez`; did you mean `size`?; allowed: on, size, colour, note"]);
        assert_eq!(said("on = true"), ["Text(0) size: is missing; must be a whole number, or a list of whole numbers"]);
    }
}
