//! What can stop a job: before it began, for which the user's input is to blame, or while it ran.

use std::io;
use std::path::{Path, PathBuf};

use crate::frames::OutputError;
use crate::obj::ObjError;
use crate::scene::SceneError;

/// What can stop a job.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The scene says what no scene can say.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A mesh cannot be read.
    #[error("`{key}`: cannot read {}: {source}; the path is relative to the scene file", path.display())]
    MeshFile {
        /// The key that names it, `body.bust.mesh`.
        key: String,
        /// The OBJ file.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// A mesh is not usable.
    #[error(transparent)]
    Mesh(#[from] ObjError),
    /// A body cannot be built, or one of its pins or handles takes nothing.
    #[error("{key}: {source}")]
    Body {
        /// Its key in the scene: `body.bust`, `body.bust.pin.0`.
        key: String,
        /// Why not.
        source: supple::Error,
    },
    /// The simulation cannot be built.
    #[error(transparent)]
    Simulation(supple::Error),
    /// An option of the job is out of range.
    #[error("`{option}` is {value}; it must be {range}")]
    Option {
        /// The option.
        option: &'static str,
        /// What it is.
        value: String,
        /// What it must be.
        range: &'static str,
    },
    /// A frame cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A stats file whose extension says nothing.
    #[error("the stats file {} must end in .csv or .json", path.display())]
    StatsName {
        /// The file.
        path: PathBuf,
    },
    /// A file that is to be continued holds something else.
    #[error("{} is not a stats file of supple, so it cannot be continued; name another", path.display())]
    NotStats {
        /// The file.
        path: PathBuf,
    },
    /// The output folder is something else.
    #[error("the output folder {} is a file; name a folder", path.display())]
    NotAFolder {
        /// Where it leads.
        path: PathBuf,
    },
    /// Another run writes to the folder.
    #[error(
        "another run holds {}; wait for it, or write to another folder (a run that was killed holds nothing)",
        path.display()
    )]
    Locked {
        /// The lock file.
        path: PathBuf,
    },
    /// The checkpoint cannot be used.
    #[error(
        "cannot resume from {}: {what}; run without resuming to start again",
        path.display()
    )]
    Checkpoint {
        /// The checkpoint.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The checkpoint is that of another motion.
    #[error(
        "cannot resume from {}: {difference}; undo the change, or run without resuming to start again",
        path.display()
    )]
    Differs {
        /// The checkpoint.
        path: PathBuf,
        /// The first thing that differs.
        difference: String,
    },
    /// Something could not be read or written while the job ran.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// On which file.
        path: PathBuf,
        /// Why it failed.
        source: io::Error,
    },
}

impl RunError {
    /// Whether arguments, scene or mesh are to blame, so that nothing was written.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Output(error) => matches!(error, OutputError::OverwritesInput { .. }),
            other => !matches!(other, Self::Io { .. } | Self::Locked { .. }),
        }
    }

    pub(super) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), source }
    }
}
