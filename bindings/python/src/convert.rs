//! Python values as TOML, which the core reads and checks.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyMapping, PyString, PyTuple};
use std::fmt::Write;

/// Most dicts and lists inside each other; what contains itself never ends. The core allows fewer, and says so.
const DEEPEST: usize = 100;

/// A scene: the keys of a mapping, a line each.
pub(crate) fn scene(keys: &Bound<'_, PyMapping>) -> PyResult<String> {
    let mut text = String::new();
    for (name, value) in entries(keys, "")? {
        write_key(&mut text, &name);
        write_value(&mut text, &value, &name, 0)?;
        text.push('\n');
    }
    Ok(text)
}

/// One value.
pub(crate) fn value(value: &Bound<'_, PyAny>, path: &str) -> PyResult<String> {
    let mut text = String::new();
    write_value(&mut text, value, path, 0)?;
    Ok(text)
}

/// Names and values of a mapping; `None` is what was left out.
fn entries<'py>(mapping: &Bound<'py, PyMapping>, path: &str) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let mut entries = Vec::new();
    for item in mapping.items()?.iter() {
        let (name, value): (Bound<'py, PyAny>, Bound<'py, PyAny>) = item.extract()?;
        let name = name
            .cast::<PyString>()
            .map_err(|_| PyTypeError::new_err(format!("{path}: keys are text, not {}", kind(&name))))?
            .to_string_lossy()
            .into_owned();
        if !value.is_none() {
            entries.push((name, value));
        }
    }
    Ok(entries)
}

fn write_value(text: &mut String, value: &Bound<'_, PyAny>, path: &str, depth: usize) -> PyResult<()> {
    let refuse = |what: String| Err(PyTypeError::new_err(format!("{path}: {what}")));
    if depth > DEEPEST {
        return refuse(format!("is nested deeper than {DEEPEST} dicts and lists"));
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        text.push_str(if flag.is_true() { "true" } else { "false" });
    } else if let Ok(number) = value.cast::<PyInt>() {
        text.push_str(&number.str()?.to_string_lossy());
    } else if let Ok(number) = value.cast::<PyFloat>() {
        // `{:?}` reads back as the same number and has a point or an exponent; TOML writes nan and inf in lower case
        let _ = write!(text, "{}", format!("{:?}", number.value()).to_lowercase());
    } else if let Ok(word) = value.cast::<PyString>() {
        write_text(text, &word.to_string_lossy());
    } else if let Ok(table) = value.cast::<PyMapping>() {
        text.push('{');
        for (index, (name, value)) in entries(table, path)?.iter().enumerate() {
            text.push_str(if index > 0 { ", " } else { " " });
            write_key(text, name);
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            write_value(text, value, &path, depth + 1)?;
        }
        text.push_str(" }");
    } else if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        text.push('[');
        for (index, item) in value.try_iter()?.enumerate() {
            text.push_str(if index > 0 { ", " } else { "" });
            write_value(text, &item?, &format!("{path}[{index}]"), depth + 1)?;
        }
        text.push(']');
    } else if let Ok(plain) = value.call_method0("tolist") {
        // numpy arrays and numbers
        write_value(text, &plain, path, depth + 1)?;
    } else if let Ok(file) = value.call_method0("__fspath__") {
        write_value(text, &file, path, depth + 1)?;
    } else {
        return refuse(format!("cannot be {}; a scene is made of numbers, text, flags, lists and dicts", kind(value)));
    }
    Ok(())
}

fn write_key(text: &mut String, name: &str) {
    write_text(text, name);
    text.push_str(" = ");
}

/// TOML text in quotes.
fn write_text(text: &mut String, word: &str) {
    text.push('"');
    for letter in word.chars() {
        match letter {
            '"' | '\\' => text.extend(['\\', letter]),
            letter if letter.is_control() => {
                let _ = write!(text, "\\u{:04X}", letter as u32);
            }
            letter => text.push(letter),
        }
    }
    text.push('"');
}

/// The type of a value, for messages.
pub(crate) fn kind(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "that".into(), |name| format!("a {name}"))
}

/// Overrides of a scene file: dotted paths and TOML values.
pub(crate) fn overrides(set: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<(String, String)>> {
    let Some(set) = set else { return Ok(Vec::new()) };
    entries(set.as_mapping(), "set")?.into_iter().map(|(path, item)| Ok((path.clone(), value(&item, &path)?))).collect()
}
