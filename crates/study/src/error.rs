//! What can stop a study.

use std::io;
use std::path::{Path, PathBuf};

use supple::Error;
use supple_io::run::RunError;

/// What can stop a study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The scene cannot be read, built or run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A scene that does not move for any time.
    #[error("simulation.frames is 0: a study needs at least 1 frame")]
    NoFrames,
    /// A point of the study cannot be run.
    #[error(transparent)]
    Point(#[from] Error),
    /// The scene can be built as it is, but not as a point of the study has it.
    #[error("a point of the study cannot be built: {source}; those before it are in {}", path.display())]
    Later {
        /// The study as far as it went.
        path: PathBuf,
        /// Why not.
        source: Box<RunError>,
    },
    /// The earlier study is of something else.
    #[error("{} cannot be continued: {what}; run it without --resume, or write to another folder", path.display())]
    Resume {
        /// The earlier study.
        path: PathBuf,
        /// What is not the same.
        what: String,
    },
    /// A file or folder that cannot be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    File {
        /// What was tried.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// A plot that cannot be drawn.
    #[error("cannot draw {}: {what}", path.display())]
    Plot {
        /// The file.
        path: PathBuf,
        /// Why not.
        what: String,
    },
}

impl StudyError {
    /// Whether the user's input is to blame, and nothing was written.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Run(error) => error.is_input(),
            Self::NoFrames | Self::Resume { .. } => true,
            Self::Point(_) | Self::Later { .. } | Self::File { .. } | Self::Plot { .. } => false,
        }
    }

    /// The same error, once the study at `path` is written.
    pub(crate) fn later(self, path: PathBuf) -> Self {
        match self {
            Self::Run(source) => Self::Later { path, source: Box::new(source) },
            other => other,
        }
    }

    pub(crate) fn file(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::File { action, path: path.to_owned(), source }
    }
}

/// Why a study ends before its last point.
#[derive(Debug)]
pub(crate) enum Halt {
    /// The observer asked for it.
    Stopped,
    /// It failed.
    Failed(StudyError),
}

impl<E: Into<StudyError>> From<E> for Halt {
    fn from(error: E) -> Self {
        Self::Failed(error.into())
    }
}
