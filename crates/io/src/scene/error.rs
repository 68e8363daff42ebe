//! Errors of reading scenes. Each names the place, the key, the value and the valid input.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use crate::obj::ObjError;

/// Place where a value was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a file, or of a text with the name of a file.
    Line {
        /// Name of the file.
        file: Arc<str>,
        /// Line, from 1.
        line: usize,
    },
    /// An override, `KEY=VALUE` as given.
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
    /// The file is neither a scene nor a model, by its extension.
    #[error("{}: is neither a scene nor a model; the extension must be .toml or .obj", path.display())]
    Kind {
        /// Input file.
        path: PathBuf,
    },
    /// A model without a scene cannot be read.
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
        /// Start of the table that needs the key.
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
    /// A number is out of range, or a string is none of the choices.
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
        /// Full key of the second.
        key: String,
        /// First key.
        other: String,
    },
    /// Two bodies have the same name.
    #[error("{place}: a second body is called `{name}`; names must differ, because they name the files")]
    DuplicateName {
        /// Place of the second body.
        place: Place,
        /// Name of both.
        name: String,
    },
    /// An override does not have the form `KEY=VALUE`, or its key does not exist.
    #[error("--set {text}: {message}")]
    Override {
        /// The override as given.
        text: String,
        /// The problem, and a valid form.
        message: String,
    },
}
