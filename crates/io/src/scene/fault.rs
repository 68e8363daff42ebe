//! Problems found while a scene is deserialized, before their places are known. Finds the known key that an
//! unknown key resembles.

use serde::de::{Error, Expected, Unexpected};

use super::error::SceneError;

/// A problem with a value, whose place and full key may be unknown.
#[derive(Debug)]
pub(super) enum Fault {
    /// The value has the wrong type; contains the expected type.
    Type(String),
    /// The value is out of range; contains the valid range.
    Range(String),
    /// The field with this name is missing.
    Missing(&'static str),
    /// A key is unknown; contains the key, and the known key with the most similar spelling.
    Unknown(String, String),
    /// An unknown key is in the place of a shape; contains the key and the keys of the known shapes.
    UnknownShape(String, Vec<&'static str>),
    /// The complete error, with place and full key.
    Known(SceneError),
}

impl Fault {
    pub(super) fn unknown_key(key: &str, known: &[&str]) -> Self {
        Self::Unknown(key.to_owned(), nearest(key, known).unwrap_or_default().to_owned())
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

/// Returns the candidate with the smallest edit distance (Damerau-Levenshtein) to `word`. If several
/// candidates have this distance, returns the first one. Only the first 64 characters count.
pub fn nearest<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let word = start_of(word);
    let distance = |candidate: &&str| strsim::damerau_levenshtein(word, start_of(candidate));
    candidates.iter().copied().min_by_key(distance)
}

/// Returns whether the edit distance of `word` to a candidate is at most a third of its length.
pub(super) fn resembles(word: &str, candidates: &[&str]) -> bool {
    let word = start_of(word);
    candidates
        .iter()
        .any(|candidate| 3 * strsim::damerau_levenshtein(word, candidate) <= word.chars().count())
}

/// Returns the first 64 characters of a word, which no name of a key exceeds. The time of an edit distance is
/// the product of the lengths.
fn start_of(word: &str) -> &str {
    word.char_indices().nth(64).map_or(word, |(end, _)| &word[..end])
}
