//! Errors of reading model files.

use std::path::{Path, PathBuf};

use super::names::{names, not_read};
use crate::escape::Escaped;
use crate::obj::ObjError;

/// A problem in a file: the element, the value and the way out.
#[derive(Debug)]
pub(super) struct Fault(pub(super) String);

/// Error of reading a model file. The message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The file, or a buffer of a glTF file, cannot be read.
    #[error("{}: cannot be read: {source}", Escaped(path.display()))]
    Read {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// Neither the content nor the extension is that of a model file.
    #[error("{}: {}; give a model: {}", Escaped(path.display()), not_read(path), names())]
    Unknown {
        /// The file.
        path: PathBuf,
    },
    /// An OBJ file is invalid, or a file of any format has no object or group with the requested name.
    #[error(transparent)]
    Obj(#[from] ObjError),
    /// A GLB, glTF, STL or PLY file is invalid.
    #[error("{}: {problem}", Escaped(path.display()))]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The element, the value and the way out.
        problem: String,
    },
}

impl ModelError {
    /// Returns the error of a fault in a file.
    pub(super) fn of(path: &Path, fault: Fault) -> Self {
        Self::Invalid { path: path.to_owned(), problem: fault.0 }
    }
}
