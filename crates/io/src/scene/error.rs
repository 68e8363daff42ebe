//! Errors of reading scenes. A message names the place (line or override), the key, the value and the valid
//! input.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use crate::escape::{Escaped, Excerpt};
use crate::model::{self, ModelError};

/// Place of a value or key: a line of a scene file, an override, or an argument of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a scene file, or of a text that stands for a file.
    Line {
        /// Path of the file, or name of the text.
        file: Arc<str>,
        /// Line number, from 1.
        line: usize,
    },
    /// An override: its text `KEY=VALUE`, as given.
    Override(Arc<str>),
    /// An argument of a program: the name of its type there.
    Argument(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { file, line } => write!(f, "{}:{line}", Escaped(file)),
            Self::Override(text) => write!(f, "--set {}", Excerpt(text)),
            Self::Argument(_) => write!(f, "argument"),
        }
    }
}

/// Error of reading a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file cannot be read.
    #[error("{}: cannot read the scene: {source}", Escaped(path.display()))]
    Read {
        /// Scene file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The file is neither a scene nor a model.
    #[error(
        "{}: {}; give a scene (.toml) or a model: {}",
        Escaped(path.display()),
        model::not_read(path),
        model::names()
    )]
    Kind {
        /// Input file.
        path: PathBuf,
    },
    /// A path is not UTF-8, so that the text of a scene cannot contain it.
    #[error("{}: a scene cannot contain this path, because it is not UTF-8; rename it", Escaped(path.display()))]
    PathNotUtf8 {
        /// The path.
        path: PathBuf,
    },
    /// A model that is used without a scene cannot be read.
    #[error(transparent)]
    Mesh(#[from] ModelError),
    /// The text is not valid TOML.
    #[error("{place}: {}", Escaped(message))]
    Syntax {
        /// Place of the error.
        place: Place,
        /// Message of the parser.
        message: String,
    },
    /// The file of a `vertices_file` cannot be read.
    #[error("{place}: `{}`: cannot read {}: {source}", Excerpt(key), Escaped(path.display()))]
    VertexFile {
        /// Place of the key.
        place: Place,
        /// Full key.
        key: String,
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// A key is unknown.
    #[error("{place}: unknown key `{}`; {way_out}", Excerpt(key))]
    UnknownKey {
        /// Place of the key.
        place: Place,
        /// Full key, such as `body.bust.half_widht`.
        key: String,
        /// What to write in its place, such as the known key with the most similar spelling.
        way_out: String,
    },
    /// A collider has an unknown key in place of its shape, or a constraint in place of its selection.
    #[error("{place}: unknown key `{}`; give one of `{}`", Excerpt(key), known.join("`, `"))]
    UnknownShape {
        /// Place of the key.
        place: Place,
        /// Full key, such as `collider.0.cylinder`.
        key: String,
        /// Keys of the known shapes.
        known: Vec<&'static str>,
    },
    /// A required key is missing.
    #[error("{place}: `{}` is missing: {hint}", Excerpt(key))]
    Missing {
        /// Place of the table that needs the key.
        place: Place,
        /// Full key.
        key: String,
        /// Description of a valid value.
        hint: String,
    },
    /// A value has the wrong type.
    #[error("{place}: `{}` must be {expected}, not {found}", Excerpt(key))]
    WrongType {
        /// Place of the value.
        place: Place,
        /// Full key.
        key: String,
        /// Expected type.
        expected: String,
        /// Value found.
        found: String,
    },
    /// A number is out of range, or a string is not one of the valid choices.
    #[error("{place}: `{}` is {value}; it must be {range}", Excerpt(key))]
    OutOfRange {
        /// Place of the value.
        place: Place,
        /// Full key.
        key: String,
        /// Value found.
        value: String,
        /// Valid range or choices.
        range: String,
    },
    /// Two mutually exclusive keys are given.
    #[error("{place}: `{}` and `{other}` exclude each other; leave one of them out", Excerpt(key))]
    Exclusive {
        /// Place of the second key.
        place: Place,
        /// Full key that was found second.
        key: String,
        /// Key that was found first, without its table.
        other: String,
    },
    /// Two bodies have the same name.
    #[error(
        "{place}: a second body is called `{}`; names must differ, because they name the files",
        Excerpt(name)
    )]
    DuplicateName {
        /// Place of the second body.
        place: Place,
        /// Name of the two bodies.
        name: String,
    },
    /// A body does not touch a body that does not exist, or itself.
    #[error("{place}: {}", other_body(key, name, *is_itself, nearest.as_deref()))]
    NoOtherBody {
        /// Place of the name.
        place: Place,
        /// Full key, such as `body.bust.ignore.0`.
        key: String,
        /// Name found.
        name: String,
        /// Whether it is the name of the body itself.
        is_itself: bool,
        /// Name of another body with the most similar spelling; `None` if there is no other body.
        nearest: Option<String>,
    },
    /// An override does not have the form `KEY=VALUE`, or its key does not exist.
    #[error("--set {}: {message}", Excerpt(text))]
    Override {
        /// Text of the override, as given.
        text: String,
        /// Description of the problem and of a valid override.
        message: String,
    },
}

/// Returns the message that a name in `ignore` is not the name of another body.
fn other_body(key: &str, name: &str, is_itself: bool, nearest: Option<&str>) -> String {
    let (key, name) = (Excerpt(key), Excerpt(name));
    let way_out = match nearest {
        Some(nearest) => format!("the nearest name of another body is `{}`", Excerpt(nearest)),
        None => "the scene has no other body; leave it out".to_owned(),
    };
    if is_itself {
        format!(
            "`{key}` is \"{name}\", the body itself, whose contact with itself is `self_contact`; {way_out}"
        )
    } else {
        format!("`{key}` is \"{name}\", and no body has this name; {way_out}")
    }
}
