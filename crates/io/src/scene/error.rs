//! Errors of reading scenes. A message names the place (line or override), the key, the value and the valid
//! input.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use crate::obj::ObjError;

/// Place of a value or key: a line of a scene file, or an override.
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
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { file, line } => write!(f, "{file}:{line}"),
            Self::Override(text) => write!(f, "--set {text}"),
        }
    }
}

/// Error of reading a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file cannot be read.
    #[error("{}: cannot read the scene: {source}", path.display())]
    Read {
        /// Scene file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The extension of the file is that of neither a scene nor a model.
    #[error("{}: the extension must be .toml, for a scene, or .obj, for a model", path.display())]
    Kind {
        /// Input file.
        path: PathBuf,
    },
    /// An OBJ file that is used without a scene cannot be read.
    #[error(transparent)]
    Mesh(#[from] ObjError),
    /// The text is not valid TOML.
    #[error("{place}: {message}")]
    Syntax {
        /// Place of the error.
        place: Place,
        /// Message of the parser.
        message: String,
    },
    /// A key is unknown.
    #[error("{place}: unknown key `{key}`; the nearest known one is `{nearest}`")]
    UnknownKey {
        /// Place of the key.
        place: Place,
        /// Full key, such as `body.bust.half_widht`.
        key: String,
        /// Known key with the most similar spelling.
        nearest: String,
    },
    /// A required key is missing.
    #[error("{place}: `{key}` is missing: {hint}")]
    Missing {
        /// Place of the table that needs the key.
        place: Place,
        /// Full key.
        key: String,
        /// Description of a valid value.
        hint: String,
    },
    /// A value has the wrong type.
    #[error("{place}: `{key}` must be {expected}, not {found}")]
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
    #[error("{place}: `{key}` is {value}; it must be {range}")]
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
    #[error("{place}: `{key}` and `{other}` exclude each other; leave one of them out")]
    Exclusive {
        /// Place of the second key.
        place: Place,
        /// Full key that was found second.
        key: String,
        /// Key that was found first, without its table.
        other: String,
    },
    /// Two bodies have the same name.
    #[error("{place}: a second body is called `{name}`; names must differ, because they name the files")]
    DuplicateName {
        /// Place of the second body.
        place: Place,
        /// Name of the two bodies.
        name: String,
    },
    /// An override does not have the form `KEY=VALUE`, or its key does not exist.
    #[error("--set {text}: {message}")]
    Override {
        /// Text of the override, as given.
        text: String,
        /// Description of the problem and of a valid override.
        message: String,
    },
}
