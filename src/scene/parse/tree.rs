//! TOML or JSON as one small tree that remembers where each value stood.

use crate::scene::fault::Fault;
use indexmap::IndexMap;
use jsonc_parser::common::Ranged;
use jsonc_parser::errors::ParseErrorKind;
use jsonc_parser::{CollectOptions, ParseOptions, ast, parse_to_ast};
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

/// Most tables and lists inside each other; the code that walks the tree calls itself.
pub(in crate::scene) const DEEPEST: usize = 64;

/// Faults whose places are not yet lines and columns.
pub(in crate::scene) type Faults = Vec<(Place, Fault)>;

/// A value and where it stood.
#[derive(Debug, Clone)]
pub(in crate::scene) struct Node {
    pub(in crate::scene) value: Value,
    /// Where the value starts.
    pub(in crate::scene) start: Place,
    /// Where the key stands that names the value; as `start` for list items and the whole file.
    pub(in crate::scene) key: Place,
}

/// What the two formats have in common.
#[derive(Debug, Clone)]
pub(in crate::scene) enum Value {
    Null,
    Bool(bool),
    Integer(i128),
    Float(f64),
    String(String),
    /// A TOML date or time, which no field of a scene is.
    Date(String),
    Array(Vec<Node>),
    Table(IndexMap<String, Node>),
}

/// Where something stood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::scene) enum Place {
    /// Byte offset in the text.
    Text(usize),
    /// Number of the `--set` that brought it in.
    Setting(usize),
}

impl Node {
    /// A value that stands nowhere else but at `place`.
    pub(in crate::scene) fn new(value: Value, place: Place) -> Self {
        Self { value, start: place, key: place }
    }

    /// Where a fault of this value is shown: at its key for a table, which may be long or have no start of its own.
    pub(in crate::scene) fn place(&self) -> Place {
        if matches!(self.value, Value::Table(_)) { self.key } else { self.start }
    }

    /// The node at a path such as `body.beam.shape.box.min[1]`, or its nearest ancestor.
    pub(in crate::scene) fn nearest(&self, path: &str) -> &Self {
        let child = match &self.value {
            Value::Table(entries) => entries.iter().find_map(|(key, node)| {
                let rest = path.strip_prefix(key.as_str())?;
                (rest.is_empty() || rest.starts_with(['.', '['])).then_some((node, rest))
            }),
            Value::Array(items) => path.strip_prefix('[').and_then(|path| path.split_once(']')).and_then(|(index, rest)| {
                let node = items.get(index.parse::<usize>().ok()?)?;
                Some((node, rest))
            }),
            _ => None,
        };
        child.map_or(self, |(node, rest)| node.nearest(rest.strip_prefix('.').unwrap_or(rest)))
    }

    /// The same for serde. Places are lost, numbers are kept as they are.
    pub(in crate::scene) fn to_json(&self) -> serde_json::Value {
        use serde_json::Value as Json;
        match &self.value {
            Value::Null => Json::Null,
            Value::Bool(value) => Json::Bool(*value),
            // JSON holds whole numbers of 64 bits; where larger ones are allowed, a float is wanted anyway.
            Value::Integer(value) => serde_json::Number::from_i128(*value).map_or_else(|| Json::from(*value as f64), Json::Number),
            Value::Float(value) => Json::from(*value),
            Value::String(value) | Value::Date(value) => Json::String(value.clone()),
            Value::Array(items) => Json::Array(items.iter().map(Self::to_json).collect()),
            Value::Table(entries) => Json::Object(entries.iter().map(|(key, node)| (key.clone(), node.to_json())).collect()),
        }
    }
}

/// Reads TOML.
///
/// # Errors
/// The first syntax error, or all that is nested too deep.
pub(in crate::scene) fn from_toml(text: &str) -> Result<Node, Faults> {
    let table = DeTable::parse(text).map_err(|error| toml_error(&error, None))?;
    let mut reader = Reader::default();
    let value = reader.toml_table(table.get_ref(), 0);
    reader.finish(Node::new(value, Place::Text(0)))
}

/// Reads one TOML value, that of `--set` number `setting`.
///
/// # Errors
/// Where it is no TOML value, or one that is nested too deep.
pub(in crate::scene) fn from_setting(text: &str, setting: usize) -> Result<Node, Faults> {
    let place = Place::Setting(setting);
    let value = DeValue::parse(text).map_err(|error| toml_error(&error, Some(place)))?;
    let mut reader = Reader { setting: Some(place), ..Reader::default() };
    let value = reader.toml(value.get_ref(), 0);
    reader.finish(Node::new(value, place))
}

/// Reads JSON: no comments, no trailing commas, no key twice.
///
/// # Errors
/// The first syntax error, or every key that is given twice and all that is nested too deep.
pub(in crate::scene) fn from_json(text: &str) -> Result<Node, Faults> {
    let strict = ParseOptions {
        allow_comments: false,
        allow_loose_object_property_names: false,
        allow_trailing_commas: false,
        allow_missing_commas: false,
        allow_single_quoted_strings: false,
        allow_hexadecimal_numbers: false,
        allow_unary_plus_numbers: false,
        allow_bare_decimal_point_numbers: false,
        allow_non_finite_numbers: false,
        allow_extended_string_escapes: false,
    };
    let fault = |offset, message: String| vec![(Place::Text(offset), Fault::new("", message))];
    let value = parse_to_ast(text, &CollectOptions::default(), &strict)
        .map_err(|error| {
            let message = match error.kind() {
                ParseErrorKind::NestingDepthExceeded => too_deep(),
                kind => format!("is not JSON: {kind}"),
            };
            fault(error.range().start, message)
        })?
        .value
        .ok_or_else(|| fault(0, "is not JSON: there is no value".into()))?;
    let mut reader = Reader::default();
    let start = Place::Text(value.start());
    let value = reader.json(&value, 0);
    reader.finish(Node::new(value, start))
}

fn toml_error(error: &toml::de::Error, setting: Option<Place>) -> Faults {
    let place = setting.unwrap_or(Place::Text(error.span().map_or(0, |span| span.start)));
    let format = if setting.is_some() { "a TOML value" } else { "TOML" };
    let message = match error.message() {
        // The parser has a limit of its own, above ours, with two wordings and no kind to tell it by.
        message if message.contains("recurs") => too_deep(),
        message => format!("is not {format}: {}", message.replace('\n', "; ")),
    };
    vec![(place, Fault::new("", message))]
}

/// Said without a path, which would have a part for every level.
pub(in crate::scene) fn too_deep() -> String {
    format!("is nested deeper than {DEEPEST} tables and lists")
}

/// Turns what the two parsers return into the tree.
#[derive(Default)]
struct Reader {
    /// The place of everything, where all of it comes from a `--set`.
    setting: Option<Place>,
    faults: Faults,
}

impl Reader {
    fn toml(&mut self, value: &DeValue<'_>, depth: usize) -> Value {
        match value {
            DeValue::String(text) => Value::String(text.to_string()),
            DeValue::Integer(integer) => i128::from_str_radix(integer.as_str(), integer.radix())
                .map_or_else(|_| Value::Float(integer.as_str().parse().unwrap_or(f64::INFINITY)), Value::Integer),
            DeValue::Float(float) => Value::Float(float.as_str().parse().unwrap_or(f64::NAN)),
            DeValue::Boolean(value) => Value::Bool(*value),
            DeValue::Datetime(date) => Value::Date(date.to_string()),
            DeValue::Table(table) => self.toml_table(table, depth),
            DeValue::Array(items) => {
                let item = |item: &Spanned<DeValue<'_>>| {
                    let start = self.place(item.span().start);
                    self.child(start, start, depth, |reader, depth| reader.toml(item.get_ref(), depth))
                };
                Value::Array(items.iter().map(item).collect())
            }
        }
    }

    fn toml_table(&mut self, table: &DeTable<'_>, depth: usize) -> Value {
        let entry = |(key, value): (&Spanned<DeString<'_>>, &Spanned<DeValue<'_>>)| {
            let (name, start) = (key.get_ref().to_string(), self.place(value.span().start));
            let key = self.place(key.span().start);
            let node = self.child(start, key, depth, |reader, depth| reader.toml(value.get_ref(), depth));
            (name, node)
        };
        Value::Table(table.iter().map(entry).collect())
    }

    fn json(&mut self, value: &ast::Value<'_>, depth: usize) -> Value {
        match value {
            ast::Value::NullKeyword(_) => Value::Null,
            ast::Value::BooleanLit(literal) => Value::Bool(literal.value),
            ast::Value::StringLit(literal) => Value::String(literal.value.to_string()),
            ast::Value::NumberLit(literal) => {
                literal.value.parse().map_or_else(|_| Value::Float(literal.value.parse().unwrap_or(f64::NAN)), Value::Integer)
            }
            ast::Value::Array(array) => {
                let item = |item: &ast::Value<'_>| {
                    let start = self.place(item.start());
                    self.child(start, start, depth, |reader, depth| reader.json(item, depth))
                };
                Value::Array(array.elements.iter().map(item).collect())
            }
            ast::Value::Object(object) => {
                let mut entries = IndexMap::with_capacity(object.properties.len());
                for property in &object.properties {
                    let (name, start) = (property.name.as_str(), self.place(property.value.start()));
                    let key = self.place(property.start());
                    let node = self.child(start, key, depth, |reader, depth| reader.json(&property.value, depth));
                    // jsonc-parser lets a key be given twice.
                    if entries.insert(name.to_string(), node).is_some() {
                        self.faults.push((key, Fault::new("", format!("key `{name}` is given twice"))));
                    }
                }
                Value::Table(entries)
            }
        }
    }

    fn child(&mut self, start: Place, key: Place, depth: usize, read: impl FnOnce(&mut Self, usize) -> Value) -> Node {
        let value = if depth < DEEPEST {
            read(self, depth + 1)
        } else {
            self.faults.push((key, Fault::new("", too_deep())));
            Value::Null
        };
        Node { value, start, key }
    }

    fn place(&self, offset: usize) -> Place {
        self.setting.unwrap_or(Place::Text(offset))
    }

    fn finish(self, root: Node) -> Result<Node, Faults> {
        if self.faults.is_empty() { Ok(root) } else { Err(self.faults) }
    }
}

/// `path.key`, or `key` where `path` is the whole file.
pub(in crate::scene) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_string() } else { format!("{path}.{key}") }
}
