//! Applies overrides (`--set KEY=VALUE`) to a TOML document before the document is checked.

use std::path::Path;
use std::sync::Arc;

use super::error::{Place, SceneError};
use super::keys::exclusive_keys;
use super::name::name_from;
use super::value::{Data, Table, Value, parse_value};
use super::way_out::nearest;
use crate::escape::Excerpt;

/// Applies overrides to the document `root`, in order.
pub(super) fn apply(root: &mut Value, overrides: &[String]) -> Result<(), SceneError> {
    for text in overrides {
        let invalid = |message: String| SceneError::Override { text: text.clone(), message };
        let Some((path, value)) = text.split_once('=') else {
            return Err(invalid("must be KEY=VALUE, such as body.bust.half_width=3".to_owned()));
        };
        let place = Place::Override(Arc::from(text.as_str()));
        let value = value.trim();
        let value = parse_value(value, &place)
            .unwrap_or_else(|| Value { data: Data::Text(value.to_owned()), place: place.clone() });
        set(root, path.trim(), value, &place).map_err(invalid)?;
    }
    Ok(())
}

/// Sets the value at `path`, keys and indices below `node` separated by dots. Creates missing tables on the
/// path. `place` is the override.
fn set(node: &mut Value, path: &str, value: Value, place: &Place) -> Result<(), String> {
    match &mut node.data {
        Data::Table(table) => {
            let (key, rest) = path.split_once('.').map_or((path, None), |(key, rest)| (key, Some(rest)));
            if key.is_empty() {
                return Err("the key has an empty part; write a key like body.bust.half_width".to_owned());
            }
            let Some(rest) = rest else {
                replace(table, key, value, place);
                return Ok(());
            };
            let empty = || Value { data: Data::Table(Table::new()), place: place.clone() };
            set(table.entry(key.to_owned()).or_insert_with(empty), rest, value, place)
        }
        Data::Array(values) => {
            let (index, rest) = find(values, path)?;
            let Some(rest) = rest else {
                values[index] = value;
                return Ok(());
            };
            set(&mut values[index], rest, value, place)
        }
        _ => {
            let (path, value) = (Excerpt(path), node.describe());
            Err(format!("`{path}` is below {value}, which has no keys; shorten the key"))
        }
    }
}

/// Sets a key, and removes the keys of the file that exclude it ([`exclusive_keys`]). A key that another
/// override set is not removed, so that two exclusive overrides are an error.
fn replace(table: &mut Table, key: &str, value: Value, place: &Place) {
    let excluded = exclusive_keys(key);
    table.retain(|other, value| {
        !excluded.contains(&other.as_str()) || matches!(value.place, Place::Override(_))
    });
    table.insert(key.to_owned(), Value { place: place.clone(), ..value });
}

/// Finds the list element at the start of `path`, by its name (which may contain dots) or by its index.
/// Returns the index of the element, and the remaining path if there is one.
fn find<'a>(values: &[Value], path: &'a str) -> Result<(usize, Option<&'a str>), String> {
    let names: Vec<Option<String>> = values.iter().map(name).collect();
    let matching = |(index, name): (usize, &Option<String>)| {
        let name = name.as_deref()?;
        strip(path, name).map(|rest| (name.len(), index, rest))
    };
    if let Some((_, index, rest)) = names.iter().enumerate().filter_map(matching).max_by_key(|found| found.0)
    {
        return Ok((index, rest));
    }
    let (part, rest) = path.split_once('.').map_or((path, None), |(part, rest)| (part, Some(rest)));
    if let Ok(index) = part.parse::<usize>() {
        return if index < values.len() {
            Ok((index, rest))
        } else {
            Err(format!("there is no element {index}: the list has {}, counted from 0", values.len()))
        };
    }
    let known: Vec<&str> = names.iter().flatten().map(String::as_str).collect();
    let called = Excerpt(part);
    Err(match nearest(part, &known) {
        Some(nearest) => {
            format!("no element is called `{called}`; the nearest known name is `{}`", Excerpt(nearest))
        }
        None => format!("`{called}` must be a number from 0 to {}", values.len().saturating_sub(1)),
    })
}

/// Returns the name of a list element: its `name`, or the default name of a body with its `mesh`. Returns
/// `None` if it has neither key.
fn name(value: &Value) -> Option<String> {
    let name = value.text("name").map(str::to_owned);
    name.or_else(|| value.text("mesh").map(|mesh| name_from(Path::new(mesh))))
}

/// Returns the remaining path after a name, or `Some(None)` if the path ends there. Returns `None` if the
/// path does not start with the name.
fn strip<'a>(path: &'a str, name: &str) -> Option<Option<&'a str>> {
    let rest = path.strip_prefix(name)?;
    if rest.is_empty() { Some(None) } else { rest.strip_prefix('.').map(Some) }
}
