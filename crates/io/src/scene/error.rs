//! What can be wrong with a scene: where, which key, what came, and the way out.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use crate::obj::ObjError;

/// Where a value was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// In a file, or a text that goes by such a name.
    Line {
        /// The name of the file.
        file: Arc<str>,
        /// Counted from 1.
        line: usize,
    },
    /// In an override, `KEY=VALUE` as it was given.
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

/// What is wrong with a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file cannot be read.
    #[error("{}: cannot read the scene: {source}", path.display())]
    Read {
        /// The scene file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// Neither a scene nor a model.
    #[error("{}: is neither a scene (.toml) nor a model (.obj)", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
    },
    /// A model alone cannot be read.
    #[error(transparent)]
    Mesh(#[from] ObjError),
    /// The text is not TOML.
    #[error("{place}: {message}")]
    Syntax {
        /// Where.
        place: Place,
        /// What the parser expected.
        message: String,
    },
    /// A key that nothing reads.
    #[error("{place}: unknown key `{key}`; the nearest known one is `{nearest}`")]
    UnknownKey {
        /// Where.
        place: Place,
        /// The whole key, `body.bust.half_widht`.
        key: String,
        /// The known key that is spelled most like it.
        nearest: String,
    },
    /// A key that must be there.
    #[error("{place}: `{key}` is missing: {hint}")]
    Missing {
        /// Where its table begins.
        place: Place,
        /// The whole key.
        key: String,
        /// What to write.
        hint: String,
    },
    /// A value of another type.
    #[error("{place}: `{key}` must be {expected}, not {found}")]
    WrongType {
        /// Where.
        place: Place,
        /// The whole key.
        key: String,
        /// What it must be.
        expected: String,
        /// What it is.
        found: String,
    },
    /// A number outside its range, or a word that is not a choice.
    #[error("{place}: `{key}` is {value}; it must be {range}")]
    OutOfRange {
        /// Where.
        place: Place,
        /// The whole key.
        key: String,
        /// What it is.
        value: String,
        /// What it must be.
        range: String,
    },
    /// Two ways to say one thing.
    #[error("{place}: `{key}` and `{other}` say the same thing in two ways; leave one of them out")]
    Exclusive {
        /// Where the second is.
        place: Place,
        /// The whole key of the second.
        key: String,
        /// The first.
        other: String,
    },
    /// Two bodies with one name.
    #[error(
        "{place}: a second body is called `{name}`; names must differ, because files are named after them"
    )]
    DuplicateName {
        /// Where the second is.
        place: Place,
        /// The name.
        name: String,
    },
    /// An override that is no `KEY=VALUE`, or whose key leads nowhere.
    #[error("--set {text}: {message}")]
    Override {
        /// The override as it was given.
        text: String,
        /// What is wrong, and the way out.
        message: String,
    },
}
