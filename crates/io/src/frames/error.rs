//! Errors of frame output.

use std::io;
use std::path::{Path, PathBuf};

/// Error of writing the frames of a body.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// A file operation failed, for example because of missing space, permission or directories.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// Attempted operation, for example `"write"` or `"rename to"`.
        action: &'static str,
        /// File or directory of the operation.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A frame would replace the input file.
    #[error(
        "{} is the input, and the output would replace it: choose another output directory or body name",
        .path.display()
    )]
    OverwritesInput {
        /// Input file.
        path: PathBuf,
    },
    /// A vertex position is NaN or infinite.
    #[error(
        "frame {frame} is not written: the position of vertex {vertex} (counted from 0) is not finite; \
         reduce the speeds and forces, or the time step"
    )]
    NotFinite {
        /// Number of the frame.
        frame: u64,
        /// Index of the vertex, from 0.
        vertex: usize,
    },
    /// A point cache cannot be continued.
    #[error("cannot continue {}: {reason}; write the sequence again from its first frame", .path.display())]
    Cache {
        /// Point cache file.
        path: PathBuf,
        /// Reason, a clause of the message.
        reason: String,
    },
}

impl OutputError {
    /// Returns a function for `map_err` that adds the attempted `action` and its `path` to an I/O error.
    pub(crate) fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { action, path: path.to_owned(), source }
    }
}
