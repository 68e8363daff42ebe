//! Writes a scene as TOML that [`Scene::parse`] reads back as the same scene.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::collider::ColliderData;
use super::data::{BodyData, Scene};
use super::error::SceneError;
use super::table::{Fields, fields, flattened, leave_out_soft_keys};
use crate::path::{relative, resolve, resolve_directory};

impl Scene {
    /// Returns the scene as TOML. It contains every key that has a value, including defaults, but not
    /// [`Scene::base`].
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        let mut table = fields(self);
        let bodies = table.get_mut("body").and_then(Value::as_array_mut).into_iter().flatten();
        for body in bodies.filter_map(Value::as_object_mut) {
            leave_out_soft_keys(body);
            *body = flattened(std::mem::take(body));
        }
        write_table(&mut text, "", &table);
        text
    }

    /// Returns the scene with paths that resolve when its text is saved elsewhere. If `directory` is given, relative
    /// paths are relative to it; otherwise all paths are absolute. Links in the paths are resolved.
    ///
    /// # Errors
    ///
    /// If a path is not UTF-8, which TOML cannot represent.
    pub fn relocated(&self, directory: Option<&Path>) -> Result<Self, SceneError> {
        let moved = |path: &Path| {
            let target = resolve(&self.resolve(path));
            let moved = match directory.filter(|_| path.is_relative()) {
                Some(directory) => PathBuf::from(relative(&target, &resolve_directory(directory))),
                None => target,
            };
            // The relative path of a directory to itself is empty.
            let moved = if moved.as_os_str().is_empty() { PathBuf::from(".") } else { moved };
            check_utf8(&moved).map(|()| moved)
        };
        let mut scene = self.clone();
        scene.base = directory.unwrap_or(Path::new("")).to_owned();
        scene.output.directory = moved(&self.output.directory)?;
        for (_, path) in scene.bodies.iter_mut().flat_map(BodyData::files_mut) {
            *path = moved(path)?;
        }
        for (_, path) in scene.colliders.iter_mut().flat_map(ColliderData::files_mut) {
            *path = moved(path)?;
        }
        Ok(scene)
    }
}

/// Returns an error if a path is not UTF-8, which TOML cannot represent.
pub(super) fn check_utf8(path: &Path) -> Result<(), SceneError> {
    path.to_str().map(drop).ok_or_else(|| SceneError::PathNotUtf8 { path: path.to_owned() })
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
            ("body" | "collider" | "field" | "link" | "zone" | "pin" | "handle", Value::Array(list)) => {
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

/// Formats the keys of a table that have values. The keys of an entry `@...` are keys of the table.
fn entries(table: &Fields) -> Vec<String> {
    let entry = |(key, value): (&String, &Value)| match value {
        Value::Null => Vec::new(),
        Value::Object(table) if key.starts_with('@') => entries(table),
        value => vec![format!("{key} = {}", inline(value))],
    };
    table.iter().flat_map(entry).collect()
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
        Value::Object(table) => format!("{{ {} }}", entries(table).join(", ")),
        // The texts of TOML and JSON are quoted differently.
        Value::String(text) => toml::Value::from(text.as_str()).to_string(),
        other => other.to_string(),
    }
}
