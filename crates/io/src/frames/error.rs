//! What can go wrong with output.

use std::io;
use std::path::{Path, PathBuf};

/// Why a frame, or another output, could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The system refused: no space, no permission, no such directory, ...
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// What was tried: `"write"`, `"rename"`, ...
        action: &'static str,
        /// What it was tried on.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The output would replace the very file that was read.
    #[error(
        "{} is the input, and a frame would have its name: choose another output directory or body name",
        .path.display()
    )]
    OverwritesInput {
        /// The input.
        path: PathBuf,
    },
    /// A position that no file can hold.
    #[error("frame {frame} is not written: vertex {vertex} (counted from 0) is not finite")]
    NotFinite {
        /// The number of the frame.
        frame: u64,
        /// The vertex, from 0.
        vertex: usize,
    },
    /// A point cache that cannot be continued.
    #[error("cannot continue {}: {reason}", .path.display())]
    Cache {
        /// The cache.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
}

impl OutputError {
    /// For `map_err`: names what was tried on which path.
    pub(crate) fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { action, path: path.to_owned(), source }
    }
}
