//! Parses TOML into values that each have their place: the line of the file, or the override. The arguments of a
//! program are such values too.

use std::collections::BTreeMap;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{Place, SceneError};
use crate::escape::Excerpt;

/// A value of a scene and its place.
#[derive(Clone, Debug)]
pub struct Value {
    /// The data.
    pub data: Data,
    /// Where it was given.
    pub place: Place,
}

/// The data of a value.
#[derive(Clone, Debug)]
pub enum Data {
    /// `true` or `false`.
    Boolean(bool),
    /// A whole number.
    Integer(i64),
    /// Another number.
    Float(f64),
    /// A string.
    Text(String),
    /// A value that no key can have, as messages show it: a date, or an object of a program.
    Other(String),
    /// A list.
    Array(Vec<Value>),
    /// A table.
    Table(Table),
}

/// The values of a table, by key.
pub type Table = BTreeMap<String, Value>;

impl Value {
    /// Formats the value for a message, such as `12`, `the string "fast"`, `[0, 1, 2]`, `a table`.
    pub(super) fn describe(&self) -> String {
        match &self.data {
            Data::Boolean(value) => value.to_string(),
            Data::Integer(value) => value.to_string(),
            Data::Float(value) => value.to_string(),
            Data::Text(value) => format!("the string \"{}\"", Excerpt(value)),
            Data::Other(value) => value.clone(),
            Data::Array(values) if values.len() <= 3 && !values.iter().any(Self::is_compound) => {
                format!("[{}]", values.iter().map(Self::describe).collect::<Vec<_>>().join(", "))
            }
            Data::Array(values) if values.len() == 1 => "a list of 1 value".to_owned(),
            Data::Array(values) => format!("a list of {} values", values.len()),
            Data::Table(_) => "a table".to_owned(),
        }
    }

    fn is_compound(&self) -> bool {
        matches!(self.data, Data::Array(_) | Data::Table(_))
    }

    /// Returns the string at `key` if the value is a table in which `key` is a string.
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        let Data::Table(table) = &self.data else { return None };
        match &table.get(key)?.data {
            Data::Text(text) => Some(text),
            _ => None,
        }
    }
}

/// What to do about paths of Windows.
pub(super) const PATHS: &str = r#"in double quotes TOML reads \ as the start of an escape: write / in a path, or quote it with ' in place of ""#;

/// Parses a TOML document; `file` is its name in messages.
pub(super) fn parse(text: &str, file: &Arc<str>) -> Result<Value, SceneError> {
    let lines = Lines::new(text.as_bytes());
    let place = |offset: usize| Place::Line { file: file.clone(), line: lines.line_of(offset) };
    let table = DeTable::parse(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        let start = text.get(..at).unwrap_or(text).rfind('\n').map_or(0, |end| end + 1);
        let line = text[start..].lines().next().unwrap_or_default();
        let way_out = if line.contains('\\') { format!("; {PATHS}") } else { String::new() };
        SceneError::Syntax {
            place: place(at),
            message: format!("not valid TOML: {}{way_out}", error.message()),
        }
    })?;
    let at = place(table.span().start);
    Ok(Value { data: Data::Table(convert_table(table.into_inner(), &place)?), place: at })
}

/// Parses the text after the `=` of an override. Returns `None` if it is not a TOML value.
pub(super) fn parse_value(text: &str, place: &Place) -> Option<Value> {
    let value = DeValue::parse(text.trim()).ok()?;
    convert(value, &|_| place.clone()).ok()
}

fn convert_table(table: DeTable<'_>, place: &dyn Fn(usize) -> Place) -> Result<Table, SceneError> {
    let entry = |(key, value): (Spanned<_>, _)| {
        // Uses the line of the key: the span of a table may begin at its header or at its first key.
        let at = place(key.span().start);
        Ok((String::from(key.into_inner()), Value { place: at, ..convert(value, place)? }))
    };
    table.into_iter().map(entry).collect()
}

fn convert(value: Spanned<DeValue<'_>>, place: &dyn Fn(usize) -> Place) -> Result<Value, SceneError> {
    let at = place(value.span().start);
    let too_large = |text: &str| SceneError::Syntax {
        place: at.clone(),
        message: format!("the number {text} does not fit in 64 bits"),
    };
    let data = match value.into_inner() {
        DeValue::Boolean(value) => Data::Boolean(value),
        DeValue::Integer(value) => {
            let parsed = i64::from_str_radix(value.as_str(), value.radix());
            Data::Integer(parsed.map_err(|_| too_large(value.as_str()))?)
        }
        DeValue::Float(value) => Data::Float(value.as_str().parse().map_err(|_| too_large(value.as_str()))?),
        DeValue::String(value) => Data::Text(value.into_owned()),
        DeValue::Datetime(value) => Data::Other(format!("the date {value}")),
        DeValue::Array(values) => {
            Data::Array(values.into_iter().map(|value| convert(value, place)).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => Data::Table(convert_table(table, place)?),
    };
    Ok(Value { data, place: at })
}

/// Finds the lines of a text, each in constant time.
pub(super) struct Lines<'a> {
    text: &'a [u8],
    /// For each block of the text, the number of line ends before it.
    before: Vec<usize>,
}

impl<'a> Lines<'a> {
    /// Number of bytes in a block.
    const BLOCK: usize = 256;

    pub(super) fn new(text: &'a [u8]) -> Self {
        let before = text.chunks(Self::BLOCK).scan(0, |count, block| {
            let before = *count;
            *count += line_ends(block);
            Some(before)
        });
        Self { text, before: before.collect() }
    }

    /// Returns the line number, from 1, of the byte at `offset`.
    pub(super) fn line_of(&self, offset: usize) -> usize {
        let offset = offset.min(self.text.len());
        let block = (offset / Self::BLOCK).min(self.before.len().saturating_sub(1));
        let before = self.before.get(block).copied().unwrap_or(0);
        1 + before + line_ends(&self.text[block * Self::BLOCK..offset])
    }
}

/// Returns the number of line ends in a text.
fn line_ends(text: &[u8]) -> usize {
    text.iter().filter(|&&byte| byte == b'\n').count()
}
