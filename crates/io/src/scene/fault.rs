//! Problems found while a scene is deserialized, before their places are known.

use serde::de::{Error, Expected, Unexpected};

use super::error::SceneError;
use super::way_out::way_out;

/// A problem with a value, whose place and full key may be unknown.
#[derive(Debug)]
pub(super) enum Fault {
    /// The value has the wrong type; contains the expected type.
    Type(String),
    /// The value is out of range; contains the valid range.
    Range(String),
    /// The field with this name is missing.
    Missing(&'static str),
    /// A key is unknown; contains the key, and what to write in its place.
    Unknown(String, String),
    /// An unknown key is in the place of a shape; contains the key and the keys of the known shapes.
    UnknownShape(String, Vec<&'static str>),
    /// The complete error, with place and full key.
    Known(SceneError),
}

impl Fault {
    pub(super) fn unknown_key(key: &str, known: &[&str]) -> Self {
        Self::Unknown(key.to_owned(), way_out(key, known, |name| format!("`{name}`")))
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self:?}")
    }
}

impl std::error::Error for Fault {}

impl Error for Fault {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        Self::Range(message.to_string())
    }

    fn invalid_type(_: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::Type(expected.to_string())
    }

    fn invalid_value(_: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::Type(expected.to_string())
    }

    fn unknown_variant(_: &str, expected: &'static [&'static str]) -> Self {
        Self::Range(format!("one of \"{}\"", expected.join("\", \"")))
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        Self::unknown_key(field, expected)
    }

    fn missing_field(field: &'static str) -> Self {
        Self::Missing(field)
    }
}
