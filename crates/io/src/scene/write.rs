//! Writes a scene as TOML that [`Scene::parse`] reads back as the same scene.

use std::fmt::Write;

use serde_json::Value;

use super::data::{Fields, Scene, fields};

impl Scene {
    /// Returns the scene as TOML. It contains every key that has a value, including defaults, but not
    /// [`Scene::base`].
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        write_table(&mut text, "", &fields(self));
        text
    }
}

/// Writes the keys of a table. `path` is its full key. The keys of an entry `@...` are written as keys of the
/// table.
fn write_table(text: &mut String, path: &str, table: &Fields) {
    let header = |text: &mut String, header: String| {
        text.push_str(if text.is_empty() { "" } else { "\n" });
        text.push_str(&header);
        text.push('\n');
    };
    for (key, value) in table {
        let full_key = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        match (key.as_str(), value) {
            (key, Value::Object(table)) if key.starts_with('@') => write_table(text, path, table),
            (_, Value::Null) => {}
            ("simulation" | "output", Value::Object(table)) => {
                header(text, format!("[{full_key}]"));
                write_table(text, &full_key, table);
            }
            ("body" | "collider" | "pin" | "handle", Value::Array(list)) => {
                for table in list.iter().filter_map(Value::as_object) {
                    header(text, format!("[[{full_key}]]"));
                    write_table(text, &full_key, table);
                }
            }
            ("keys", Value::Array(keyframes)) => {
                let line = |keyframe: &Value| format!("    {},\n", inline(keyframe));
                let lines: String = keyframes.iter().map(line).collect();
                let _ = writeln!(text, "keys = [\n{lines}]");
            }
            // Writing to a string does not fail.
            (_, value) => drop(writeln!(text, "{key} = {}", inline(value))),
        }
    }
}

/// Formats a value on one line. A float becomes the shortest text that reads back as the same number (Rust's
/// `{:?}`).
fn inline(value: &Value) -> String {
    match value {
        Value::Number(number) => match number.as_f64().filter(|_| number.is_f64()) {
            Some(float) => format!("{float:?}"),
            None => number.to_string(),
        },
        Value::Array(list) => format!("[{}]", list.iter().map(inline).collect::<Vec<_>>().join(", ")),
        Value::Object(table) => {
            let entries = table.iter().filter(|(_, value)| !value.is_null());
            let entries: Vec<_> = entries.map(|(key, value)| format!("{key} = {}", inline(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        // The texts of TOML and JSON are quoted differently.
        Value::String(text) => toml::Value::from(text.as_str()).to_string(),
        other => other.to_string(),
    }
}
