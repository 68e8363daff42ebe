//! Reading the keys of one table: types, ranges and unknown names, each with its place.

use super::document::{Data, Table, Value};
use super::error::{Place, SceneError};
use super::range::Range;

/// A table of the scene whose keys are known.
pub(super) struct Fields<'a> {
    table: &'a Table,
    place: &'a Place,
    /// The whole name of the table, `body.bust`; empty for the scene itself.
    name: String,
}

/// One value of a table, with its whole name.
#[derive(Clone)]
pub(super) struct Field<'a> {
    value: &'a Value,
    name: String,
}

impl<'a> Fields<'a> {
    /// The keys of `field`, all of which must be among `known`.
    pub(super) fn new(field: &Field<'a>, known: &[&str]) -> Result<Self, SceneError> {
        let Data::Table(table) = &field.value.data else {
            return Err(field.wrong_type("a table"));
        };
        let fields = Self { table, place: &field.value.place, name: field.name.clone() };
        for (key, value) in table {
            if !known.contains(&key.as_str()) {
                let nearest = nearest(key, known).unwrap_or_default();
                return Err(SceneError::UnknownKey {
                    place: value.place.clone(),
                    key: fields.full(key),
                    nearest: nearest.to_owned(),
                });
            }
        }
        Ok(fields)
    }

    /// The value of a key, if it is given.
    pub(super) fn get(&self, key: &str) -> Option<Field<'a>> {
        self.table.get(key).map(|value| Field { value, name: self.full(key) })
    }

    /// The value of a key that must be given; `hint` says what to write.
    pub(super) fn require(&self, key: &str, hint: &str) -> Result<Field<'a>, SceneError> {
        self.get(key).ok_or_else(|| self.missing(key, hint))
    }

    /// Reads a key if it is given, else takes the default.
    pub(super) fn read_or<T>(
        &self,
        key: &str,
        default: T,
        read: impl FnOnce(&Field<'a>) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        self.get(key).map_or(Ok(default), |field| read(&field))
    }

    /// The one of several keys that is given: its index in `keys` and its value. Two are an error.
    pub(super) fn one_of(&self, keys: &[&str]) -> Result<Option<(usize, Field<'a>)>, SceneError> {
        let mut found: Option<(usize, Field<'a>)> = None;
        for (index, key) in keys.iter().enumerate() {
            let Some(field) = self.get(key) else { continue };
            if let Some((first, _)) = found {
                let place = field.value.place.clone();
                return Err(SceneError::Exclusive { place, key: field.name, other: keys[first].to_owned() });
            }
            found = Some((index, field));
        }
        Ok(found)
    }

    /// The tables of an array of tables; none if the key is not given.
    pub(super) fn tables(&self, key: &str) -> Result<Vec<Field<'a>>, SceneError> {
        let Some(field) = self.get(key) else { return Ok(Vec::new()) };
        match &field.value.data {
            Data::Array(values) => Ok(field.items(values)),
            Data::Table(_) => Err(SceneError::WrongType {
                place: field.value.place.clone(),
                // Only bodies hold tables of their own.
                expected: format!(
                    "a list of tables; write [[{}{key}]] in double brackets",
                    if self.name.is_empty() { "" } else { "body." }
                ),
                found: "one table".to_owned(),
                key: field.name,
            }),
            _ => Err(field.wrong_type("a list of tables")),
        }
    }

    /// The error of a key that is not given.
    pub(super) fn missing(&self, key: &str, hint: &str) -> SceneError {
        SceneError::Missing { place: self.place.clone(), key: self.full(key), hint: hint.to_owned() }
    }

    fn full(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) }
    }
}

impl<'a> Field<'a> {
    /// The whole document.
    pub(super) fn root(value: &'a Value) -> Self {
        Self { value, name: String::new() }
    }

    /// The same value under another name: a body goes by its own, not by its number.
    pub(super) fn renamed(&self, name: String) -> Self {
        Self { value: self.value, name }
    }

    /// A key of the value, if it is a table that has it; whatever else the table holds.
    pub(super) fn entry(&self, key: &str) -> Option<Self> {
        let Data::Table(table) = &self.value.data else { return None };
        table.get(key).map(|value| Self { value, name: format!("{}.{key}", self.name) })
    }

    pub(super) fn place(&self) -> &Place {
        &self.value.place
    }

    pub(super) fn text(&self) -> Result<&'a str, SceneError> {
        match &self.value.data {
            Data::Text(text) => Ok(text),
            _ => Err(self.wrong_type("a text in quotes")),
        }
    }

    pub(super) fn boolean(&self) -> Result<bool, SceneError> {
        match self.value.data {
            Data::Boolean(value) => Ok(value),
            _ => Err(self.wrong_type("true or false")),
        }
    }

    /// A finite number within a range.
    pub(super) fn number(&self, range: Range) -> Result<f64, SceneError> {
        let value = match self.value.data {
            Data::Float(value) => value,
            Data::Integer(value) => value as f64,
            _ => return Err(self.wrong_type("a number")),
        };
        if range.holds(value) { Ok(value) } else { Err(self.out_of_range(&range.to_string())) }
    }

    /// A whole number within closed bounds.
    pub(super) fn count(&self, low: u32, high: u32) -> Result<u32, SceneError> {
        let range = || format!("a whole number from {low} to {high}");
        match self.value.data {
            Data::Integer(value) => u32::try_from(value)
                .ok()
                .filter(|value| (low..=high).contains(value))
                .ok_or_else(|| self.out_of_range(&range())),
            Data::Float(_) => Err(self.out_of_range(&range())),
            _ => Err(self.wrong_type("a whole number")),
        }
    }

    /// A list of three finite numbers.
    pub(super) fn vector(&self) -> Result<[f64; 3], SceneError> {
        let Data::Array(values) = &self.value.data else {
            return Err(self.wrong_type("a list of three numbers"));
        };
        let [x, y, z] = values.as_slice() else {
            return Err(self.wrong_type("a list of three numbers"));
        };
        let mut vector = [0.0; 3];
        for (axis, (out, value)) in vector.iter_mut().zip([x, y, z]).enumerate() {
            *out = Field { value, name: format!("{}.{axis}", self.name) }.number(Range::Finite)?;
        }
        Ok(vector)
    }

    /// A list of three numbers that are not all zero.
    pub(super) fn direction(&self) -> Result<[f64; 3], SceneError> {
        let vector = self.vector()?;
        if vector == [0.0; 3] {
            return Err(SceneError::OutOfRange {
                place: self.value.place.clone(),
                key: self.name.clone(),
                value: "[0, 0, 0]".to_owned(),
                range: "a direction of any length but zero".to_owned(),
            });
        }
        Ok(vector)
    }

    /// One of some words: its index.
    pub(super) fn choice(&self, words: &[&str]) -> Result<usize, SceneError> {
        let text = self.text()?;
        words.iter().position(|&word| word == text).ok_or_else(|| {
            let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
            self.out_of_range(&format!("one of {}", quoted.join(", ")))
        })
    }

    /// The values of a list.
    pub(super) fn list(&self, expected: &str) -> Result<Vec<Field<'a>>, SceneError> {
        match &self.value.data {
            Data::Array(values) => Ok(self.items(values)),
            _ => Err(self.wrong_type(expected)),
        }
    }

    /// Whether the value is a text.
    pub(super) fn is_text(&self) -> bool {
        matches!(self.value.data, Data::Text(_))
    }

    /// Whether the value is a table.
    pub(super) fn is_table(&self) -> bool {
        matches!(self.value.data, Data::Table(_))
    }

    pub(super) fn wrong_type(&self, expected: &str) -> SceneError {
        SceneError::WrongType {
            place: self.value.place.clone(),
            key: self.name.clone(),
            expected: expected.to_owned(),
            found: self.value.describe(),
        }
    }

    pub(super) fn out_of_range(&self, range: &str) -> SceneError {
        SceneError::OutOfRange {
            place: self.value.place.clone(),
            key: self.name.clone(),
            value: self.value.describe(),
            range: range.to_owned(),
        }
    }

    fn items(&self, values: &'a [Value]) -> Vec<Field<'a>> {
        let named = |(index, value)| Field { value, name: format!("{}.{index}", self.name) };
        values.iter().enumerate().map(named).collect()
    }
}

/// The candidate that is spelled most like `word`; ties go to the first.
pub fn nearest<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    candidates.iter().copied().min_by_key(|candidate| strsim::damerau_levenshtein(word, candidate))
}
