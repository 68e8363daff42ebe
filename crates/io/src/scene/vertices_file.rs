//! Reads the files of the key `vertices_file` of selections: puts the key `vertices` in its place, with a list whose
//! numbers have their places in the file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::error::{Place, SceneError};
use super::value::{Data, PATHS, Table, Value};
use crate::escape::Excerpt;
use crate::file;

const KEY: &str = "vertices_file";

/// Largest size of a file in bytes, as that of a scene.
const MAX_SIZE: u64 = 32 << 20;

/// A file of mesh vertices that a selection of a scene has read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct VertexFile {
    /// Full key of the table of the selection, with the index of the body and of the table.
    table: String,
    /// Path, resolved.
    pub(crate) path: PathBuf,
    /// The vertices of the file and their lines, from 1.
    lines: Vec<(i64, usize)>,
}

impl VertexFile {
    /// Returns the place of a vertex in the file of a table, as messages show it.
    pub(crate) fn place(files: &[Self], table: &str, vertex: u32) -> Option<Place> {
        let file = files.iter().find(|file| file.table == table)?;
        let (_, line) = file.lines.iter().find(|(found, _)| *found == i64::from(vertex))?;
        Some(Place::Line { file: file.path.to_string_lossy().as_ref().into(), line: *line })
    }
}

/// Reads the vertex files of the pins, handles, zones and links of a scene. Paths are relative to `base`.
///
/// # Errors
///
/// A path that is no string, a file that cannot be read, or a line that is no index of a vertex.
pub(super) fn read_all(root: &mut Value, base: &Path) -> Result<Vec<VertexFile>, SceneError> {
    let mut files = Vec::new();
    let Data::Table(scene) = &mut root.data else { return Ok(files) };
    for (index, body) in tables(scene, "body").enumerate() {
        for list in ["pin", "handle", "zone"] {
            for (part, table) in tables(body, list).enumerate() {
                read_table(table, format!("body.{index}.{list}.{part}"), base, &mut files)?;
            }
        }
    }
    for (index, table) in tables(scene, "link").enumerate() {
        read_table(table, format!("link.{index}"), base, &mut files)?;
    }
    Ok(files)
}

/// Returns the tables of a list.
fn tables<'a>(table: &'a mut Table, key: &str) -> impl Iterator<Item = &'a mut Table> {
    let list = table.get_mut(key).and_then(|value| match &mut value.data {
        Data::Array(list) => Some(list),
        _ => None,
    });
    list.into_iter().flatten().filter_map(|value| match &mut value.data {
        Data::Table(table) => Some(table),
        _ => None,
    })
}

/// Replaces the key `vertices_file` of a table, if it has one.
fn read_table(
    table: &mut Table,
    name: String,
    base: &Path,
    files: &mut Vec<VertexFile>,
) -> Result<(), SceneError> {
    let Some(given) = table.remove(KEY) else { return Ok(()) };
    let key = format!("{name}.{KEY}");
    if table.contains_key("vertices") {
        return Err(SceneError::Exclusive { place: given.place, key, other: "vertices".to_owned() });
    }
    let Data::Text(path) = &given.data else {
        let (expected, found) = ("the path of a text file, in quotes".to_owned(), given.describe());
        return Err(SceneError::WrongType { place: given.place, key, expected, found });
    };
    if path.chars().any(char::is_control) {
        let (value, range) = (given.describe(), format!("a path without control characters; {PATHS}"));
        return Err(SceneError::OutOfRange { place: given.place, key, value, range });
    }
    let path = base.join(path);
    let bytes = match file::read(&path, MAX_SIZE) {
        Ok(bytes) => bytes,
        Err(source) => return Err(SceneError::VertexFile { place: given.place, key, path, source }),
    };
    let list = vertices(&String::from_utf8_lossy(&bytes), &path)?;
    let line_of = |value: &Value| match (&value.data, &value.place) {
        (Data::Integer(vertex), Place::Line { line, .. }) => Some((*vertex, *line)),
        _ => None,
    };
    files.push(VertexFile { table: name, path, lines: list.iter().filter_map(line_of).collect() });
    table.insert("vertices".to_owned(), Value { data: Data::Array(list), place: given.place });
    Ok(())
}

/// Returns the vertices of a file, with their places.
fn vertices(text: &str, path: &Path) -> Result<Vec<Value>, SceneError> {
    let file: Arc<str> = path.to_string_lossy().as_ref().into();
    let mut list = Vec::new();
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let place = Place::Line { file: file.clone(), line: index + 1 };
        let content = line.split('#').next().unwrap_or_default().trim();
        if content.is_empty() {
            continue;
        }
        let vertex: i64 = content.parse().map_err(|_| SceneError::Syntax {
            place: place.clone(),
            message: format!(
                "\"{}\" is no index of a mesh vertex; write one whole number from 0 in each line",
                Excerpt(content)
            ),
        })?;
        list.push(Value { data: Data::Integer(vertex), place });
    }
    if list.is_empty() {
        let (place, message) =
            (Place::Line { file, line: 1 }, "the file has no vertices; write one index in each line");
        return Err(SceneError::Syntax { place, message: message.to_owned() });
    }
    Ok(list)
}
