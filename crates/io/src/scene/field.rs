//! Deserializes a scene. [`Field`], the deserializer, is a value of the TOML document with its full key, so
//! that errors can name the key.
//!
//! It differs from the deserializer of the `toml` crate in two ways:
//!
//! * A struct field named `@...` is read from keys of the table that contains it, like serde's `flatten`.
//!   Unlike with `flatten`, errors keep their key and line.
//! * An enum that is read from a table is the variant whose name is a key of the table. Two such keys are an
//!   error.

use std::iter::Enumerate;
use std::slice::Iter;
use std::sync::LazyLock;
use std::vec::IntoIter;

use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, Error, IntoDeserializer, MapAccess, SeqAccess, Visitor,
};
use serde::forward_to_deserialize_any;

use super::error::{Place, SceneError};
use super::fault::Fault;
use super::keys::{ELASTICITY, expand, hint_for, keys_of_soft_bodies};
use super::name::is_name;
use super::value::{Data, Table, Value};
use super::way_out::{nearest, resembles};
use supple::BodyBuilder;

/// Deserializes the keys of a table. Checks neither values that depend on each other nor names of files.
///
/// # Errors
///
/// If a key is unknown, or its value is not of its type or not in its range.
pub fn read_table<'a, T: Deserialize<'a>>(table: &'a Value) -> Result<T, SceneError> {
    Field::root(table).read()
}

/// A value and its full key, such as `body.bust.half_width`. The full key of the whole document is empty.
#[derive(Clone, Debug)]
pub(super) struct Field<'a> {
    value: &'a Value,
    /// Full key.
    name: String,
    /// Whether this is a field `@...`: `value` is the table, of which the field reads some keys and ignores
    /// the others.
    is_part: bool,
}

impl<'a> Field<'a> {
    /// Returns the field of the whole document.
    pub(super) fn root(value: &'a Value) -> Self {
        Self { value, name: String::new(), is_part: false }
    }

    /// Deserializes the value.
    pub(super) fn read<T: Deserialize<'a>>(&self) -> Result<T, SceneError> {
        T::deserialize(self.clone()).map_err(|fault| match self.locate(fault) {
            Fault::Known(error) => error,
            // Unreachable, because `locate` always returns `Known`.
            fault => SceneError::Syntax { place: self.value.place.clone(), message: format!("{fault:?}") },
        })
    }

    /// Returns the field at a path of keys and indices, separated by dots. Keys and indices that do not exist
    /// are skipped.
    pub(super) fn at(&self, path: &str) -> Self {
        path.split('.').fold(self.clone(), |field, part| {
            let next = match &field.value.data {
                Data::Table(table) => table.get(part).map(|value| field.child(part, value)),
                Data::Array(values) => {
                    let index = part.parse().unwrap_or(usize::MAX);
                    values.get(index).map(|value| field.item(index, value))
                }
                _ => None,
            };
            next.unwrap_or(field)
        })
    }

    /// Returns the field of `value`, which is the value of `key` in this table.
    fn child(&self, key: &str, value: &'a Value) -> Self {
        Self { value, name: self.key_of(key), is_part: false }
    }

    /// Returns the field of a list element. Its key is the `name` of the element if this is a valid name of a
    /// body, otherwise its index.
    fn item(&self, index: usize, value: &'a Value) -> Self {
        match value.text("name").filter(|name| is_name(name)) {
            Some(name) => self.child(name, value),
            None => self.child(&index.to_string(), value),
        }
    }

    /// Returns the full key of `key` in this table.
    fn key_of(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) }
    }

    /// Returns the place of a key of this table.
    fn place_of(&self, key: &str) -> Place {
        let value = match &self.value.data {
            Data::Table(table) => table.get(key).unwrap_or(self.value),
            _ => self.value,
        };
        value.place.clone()
    }

    /// Returns the error that `key` is missing in this table.
    pub(super) fn missing(&self, key: &str, hint: &str) -> SceneError {
        SceneError::Missing { place: self.value.place.clone(), key: self.key_of(key), hint: hint.to_owned() }
    }

    /// Returns the error that `key` and `other` of this table exclude each other.
    pub(super) fn exclusive(&self, key: &str, other: &str) -> SceneError {
        SceneError::Exclusive { place: self.place_of(key), key: self.key_of(key), other: other.to_owned() }
    }

    /// Returns the error that the value is out of range.
    pub(super) fn out_of_range(&self, range: &str) -> SceneError {
        SceneError::OutOfRange {
            place: self.value.place.clone(),
            key: self.name.clone(),
            value: self.value.describe(),
            range: range.to_owned(),
        }
    }

    /// Returns the error that an earlier body has the same name.
    pub(super) fn duplicate(&self, name: &str) -> SceneError {
        SceneError::DuplicateName { place: self.value.place.clone(), name: name.to_owned() }
    }

    /// Returns the error that the value, a name in `ignore` of the body `own`, is not the name of another body. `names`
    /// are those of all bodies.
    pub(super) fn no_other_body(&self, name: &str, own: &str, names: &[&str]) -> SceneError {
        let others: Vec<&str> = names.iter().copied().filter(|other| *other != own).collect();
        SceneError::NoOtherBody {
            place: self.value.place.clone(),
            key: self.name.clone(),
            name: name.to_owned(),
            is_itself: name == own,
            nearest: nearest(name, &others).map(str::to_owned),
        }
    }

    /// Converts a fault to `Known`, the complete error, with the place and the full key of this field.
    fn locate(&self, fault: Fault) -> Fault {
        Fault::Known(match fault {
            Fault::Known(error) => error,
            Fault::Range(range) => self.out_of_range(&range),
            Fault::Unknown(key, way_out) => {
                SceneError::UnknownKey { place: self.place_of(&key), key: self.key_of(&key), way_out }
            }
            Fault::UnknownShape(key, known) => {
                SceneError::UnknownShape { place: self.place_of(&key), key: self.key_of(&key), known }
            }
            Fault::Missing(field) => match expand(&[field])[..] {
                [key] => self.missing(key, hint_for(key)),
                ref keys => self.missing(keys[0], &format!("give one of `{}`", keys.join("`, `"))),
            },
            Fault::Type(expected) => {
                let mut found = match &self.value.place {
                    Place::Argument(kind) => kind.clone(),
                    _ => self.value.describe(),
                };
                let key = self.name.rsplit('.').next().unwrap_or_default();
                let expected = match (expected.as_str(), &self.value.data) {
                    ("f64", _) => "a number".to_owned(),
                    ("u32", Data::Integer(_) | Data::Float(_)) => {
                        return Fault::Known(
                            self.out_of_range(&format!("a whole number from 0 to {}", u32::MAX)),
                        );
                    }
                    ("u32", _) => "a whole number".to_owned(),
                    ("a boolean", _) => "true or false".to_owned(),
                    ("a string" | "path string", _) => "a string in quotes".to_owned(),
                    ("a sequence", Data::Table(_))
                        if !matches!(key, "keys" | "vertices" | "lattice" | "ignore" | "bodies") =>
                    {
                        "one table".clone_into(&mut found);
                        // Only bodies contain lists of tables (`[[body.pin]]`).
                        let parent = if self.name.contains('.') { "body." } else { "" };
                        format!("a list of tables; write [[{parent}{key}]] in double brackets")
                    }
                    ("a sequence", _) => hint_for(key).to_owned(),
                    (other, _) if other.starts_with("struct") => "a table".to_owned(),
                    (other, _) => other.to_owned(),
                };
                let (place, key) = (self.value.place.clone(), self.name.clone());
                SceneError::WrongType { place, key, expected, found }
            }
        })
    }

    /// Returns an error if the table sets the elasticity in more than one way.
    fn check_elasticity(&self, table: &Table) -> Result<(), Fault> {
        let mut given = ELASTICITY.iter().filter_map(|way| way.iter().find(|&&key| table.contains_key(key)));
        match (given.next(), given.next()) {
            (Some(other), Some(key)) => Err(Fault::Known(self.exclusive(key, other))),
            _ => Ok(()),
        }
    }

    /// Returns an error if the table of a rigid body has a key of a body that deforms.
    fn check_rigid(&self, table: &Table) -> Result<(), Fault> {
        match keys_of_soft_bodies().into_iter().find(|&key| is_rigid(table) && table.contains_key(key)) {
            Some(key) => Err(Fault::Known(self.exclusive(key, "rigid"))),
            None => Ok(()),
        }
    }

    /// Returns the entries of this table for a struct with these fields. An unknown key is an error before
    /// any value is read.
    fn entries(&self, fields: &[&'static str]) -> Result<Entries<'a>, Fault> {
        let Data::Table(table) = &self.value.data else { return Err(Fault::Type("struct".to_owned())) };
        let known = expand(fields);
        let unknown = table.keys().find(|key| !known.contains(&key.as_str()));
        if let Some(key) = unknown.filter(|_| !self.is_part) {
            let shapes = fields.iter().find(|&&field| matches!(field, "@shape" | "@selection"));
            let shapes = shapes.map(|&shapes| expand(&[shapes])).unwrap_or_default();
            // A table without a shape has the unknown key in its place, unless the key resembles another one.
            if !shapes.is_empty()
                && !shapes.iter().any(|&shape| table.contains_key(shape))
                && !resembles(key, &known)
            {
                return Err(Fault::UnknownShape(key.clone(), shapes));
            }
            return Err(Fault::unknown_key(key, &known));
        }
        if fields.contains(&"@elasticity") {
            self.check_elasticity(table)?;
        }
        if fields.contains(&"rigid") {
            self.check_rigid(table)?;
        }
        let entry = |&field: &&'static str| match table.get(field) {
            Some(value) => Some((field, self.child(field, value))),
            // The default resolution of a rigid body is another one.
            None if field == "@resolution"
                && is_rigid(table)
                && !expand(&[field]).into_iter().any(|key| table.contains_key(key)) =>
            {
                Some((field, Self { value: &RIGID_RESOLUTION, is_part: true, ..self.clone() }))
            }
            None if field.starts_with('@') => {
                let given = expand(&[field]).into_iter().any(|key| table.contains_key(key));
                given.then(|| (field, Self { is_part: true, ..self.clone() }))
            }
            None => None,
        };
        Ok(Entries::new(fields.iter().filter_map(entry).collect()))
    }

    /// Returns the entry of the only key in `keys` that the table has. Two keys, or no key, are an error.
    fn one_of(&self, table: &'a Table, keys: &'static [&'static str]) -> Result<Entries<'a>, Fault> {
        let mut given = keys.iter().filter_map(|&key| Some((key, self.child(key, table.get(key)?))));
        let first = given.next().ok_or(Fault::Missing(keys[0]))?;
        if let Some((key, _)) = given.next() {
            return Err(Fault::Known(self.exclusive(key, first.0)));
        }
        Ok(Entries::new(vec![first]))
    }
}

impl<'de> Deserializer<'de> for Field<'de> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match &self.value.data {
            Data::Boolean(value) => visitor.visit_bool(*value),
            Data::Integer(value) => visitor.visit_i64(*value),
            Data::Float(value) => visitor.visit_f64(*value),
            Data::Text(value) => visitor.visit_borrowed_str(value),
            Data::Other(_) => visitor.visit_unit(),
            Data::Array(values) => visitor.visit_seq(Items { rest: values.iter().enumerate(), list: &self }),
            Data::Table(table) => {
                let entries = table.iter().map(|(key, value)| (&**key, self.child(key, value)));
                visitor.visit_map(Entries::new(entries.collect()))
            }
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        visitor.visit_newtype_struct(self)
    }

    /// Deserializes a vector of `length` finite numbers.
    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Fault> {
        let list = match &self.value.data {
            Data::Array(values) if values.len() == length => values,
            _ => return Err(Fault::Type("a list of three numbers".to_owned())),
        };
        let is_bad = |value: &Value| matches!(value.data, Data::Float(value) if !value.is_finite());
        if let Some(index) = list.iter().position(is_bad) {
            return Err(Fault::Known(self.item(index, &list[index]).out_of_range("a finite number")));
        }
        self.deserialize_any(visitor)
    }

    /// Deserializes a struct. Volume options can be a string, which sets their first field, `measure`.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        if name == "VolumeOptions" && !matches!(self.value.data, Data::Table(_)) {
            if !matches!(self.value.data, Data::Text(_)) {
                let expected = "a string (\"off\" for no correction) or a table with keys like `measure`";
                return Err(Fault::Type(expected.to_owned()));
            }
            return visitor.visit_map(Entries::new(vec![(fields[0], self)]));
        }
        visitor.visit_map(self.entries(fields)?)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match &self.value.data {
            Data::Text(text) => visitor.visit_enum(StrDeserializer::new(text)),
            Data::Table(table) => {
                visitor.visit_enum(MapAccessDeserializer::new(self.one_of(table, variants)?))
            }
            _ => Err(Fault::Type("a string".to_owned())),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq
        tuple_struct map identifier ignored_any
    }
}

/// The default resolution of a rigid body, as a part of its table.
static RIGID_RESOLUTION: LazyLock<Value> = LazyLock::new(|| {
    let value = |data| Value { data, place: Place::Argument("default".to_owned()) };
    let vertices = value(Data::Integer(BodyBuilder::RIGID_VERTICES as i64));
    value(Data::Table(Table::from([("lattice_vertices".to_owned(), vertices)])))
});

/// Returns whether the table of a body says that it is rigid.
fn is_rigid(table: &Table) -> bool {
    matches!(table.get("rigid").map(|value| &value.data), Some(Data::Boolean(true)))
}

/// Iterator over the entries of a table.
struct Entries<'a> {
    rest: IntoIter<(&'a str, Field<'a>)>,
    value: Option<Field<'a>>,
}

impl<'a> Entries<'a> {
    fn new(entries: Vec<(&'a str, Field<'a>)>) -> Self {
        Self { rest: entries.into_iter(), value: None }
    }
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        self.value = Some(value);
        seed.deserialize(key.into_deserializer()).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let field = self.value.take().ok_or_else(|| Fault::custom("a key and a value"))?;
        seed.deserialize(field.clone()).map_err(|fault| field.locate(fault))
    }
}

/// Iterator over the elements of a list.
struct Items<'a, 'de> {
    rest: Enumerate<Iter<'de, Value>>,
    list: &'a Field<'de>,
}

impl<'de> SeqAccess<'de> for Items<'_, 'de> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Fault> {
        let Some((index, value)) = self.rest.next() else { return Ok(None) };
        let field = self.list.item(index, value);
        seed.deserialize(field.clone()).map_err(|fault| field.locate(fault)).map(Some)
    }
}
