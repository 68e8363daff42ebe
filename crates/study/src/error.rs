//! Defines the errors of a study.

use std::io;
use std::path::{Path, PathBuf};

use supple::Error;
use supple_io::Escaped;
use supple_io::run::RunError;

/// A reason why a study cannot be run or written.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The scene cannot be read, built or run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The scene has no frames after frame 0.
    #[error("simulation.frames is 0; a study needs at least 1 frame")]
    NoFrames,
    /// A body has zones of another stiffness, which a study does not refine.
    #[error("body {body:?} has zones, which a study does not support; remove [[body.zone]]")]
    Zones {
        /// Name of the body.
        body: String,
    },
    /// Bodies of the scene can touch each other or themselves, which the reference of a study does not compute.
    #[error(
        "bodies of the scene can touch each other or themselves, which a study does not support; set \
         simulation.contact = false and simulation.self_contact = false"
    )]
    BodyContact,
    /// No case has the text of the filter in its name.
    #[error(
        "--filter {filter:?}: no {}case has this text in its name or family; the families are: {}",
        if *quick { "quick " } else { "" },
        families.join(", ")
    )]
    NoCase {
        /// The filter.
        filter: String,
        /// Whether only quick cases were requested.
        quick: bool,
        /// The families of all cases.
        families: Vec<String>,
    },
    /// A point of the study cannot be run.
    #[error(transparent)]
    Point(#[from] Error),
    /// The scene can be built, but not with the parameters of a point of the study.
    #[error(
        "a point of the study cannot be built: {source}; the points before it are in {}",
        Escaped(path.display())
    )]
    AfterStart {
        /// The file of the unfinished study.
        path: PathBuf,
        /// The cause.
        source: Box<RunError>,
    },
    /// The earlier study differs from this one in its scene, options or machine.
    #[error(
        "{} cannot be continued: {}; run it without --resume, or write to another directory",
        Escaped(path.display()),
        Escaped(what)
    )]
    Resume {
        /// The file of the earlier study.
        path: PathBuf,
        /// Description of the difference.
        what: String,
    },
    /// A file or directory cannot be read or written.
    #[error("cannot {action} {}: {source}", Escaped(path.display()))]
    File {
        /// The verb of the failed operation, e.g. `write`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A plot cannot be drawn.
    #[error("cannot draw {}: {what}", Escaped(path.display()))]
    Plot {
        /// The file.
        path: PathBuf,
        /// The cause.
        what: String,
    },
}

impl StudyError {
    /// Returns whether the cause is an invalid input. Nothing was written then.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Run(error) => error.is_input(),
            Self::NoFrames
            | Self::Zones { .. }
            | Self::BodyContact
            | Self::NoCase { .. }
            | Self::Resume { .. } => true,
            Self::Point(_) | Self::AfterStart { .. } | Self::File { .. } | Self::Plot { .. } => false,
        }
    }

    /// Converts a [`Self::Run`] error that occurs after the study at `path` was written to
    /// [`Self::AfterStart`].
    pub(crate) fn after_writing(self, path: PathBuf) -> Self {
        match self {
            Self::Run(source) => Self::AfterStart { path, source: Box::new(source) },
            other => other,
        }
    }

    /// Creates a [`Self::File`] error.
    pub(crate) fn file(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::File { action, path: path.to_owned(), source }
    }
}

/// Reason why a study ends before its last point.
#[derive(Debug)]
pub(crate) enum Halt {
    /// The observer requested a stop.
    Stopped,
    /// An error occurred.
    Failed(StudyError),
}

impl<E: Into<StudyError>> From<E> for Halt {
    fn from(error: E) -> Self {
        Self::Failed(error.into())
    }
}
