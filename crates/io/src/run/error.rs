//! Errors of jobs: invalid input, which is found before a job starts, and failures while a job runs.

use std::io;
use std::path::{Path, PathBuf};

use crate::escape::Escaped;
use crate::frames::OutputError;
use crate::model::ModelError;
use crate::obj::ObjError;
use crate::scene::SceneError;
use supple::{AnimationError, ColliderFault};

/// Error of a job.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A file of a body or a collider cannot be read.
    #[error(
        "`{}`: cannot read {}: {source}; the path is relative to the scene file",
        Escaped(key),
        Escaped(path.display())
    )]
    MeshFile {
        /// Key of the file in the scene, such as `body.bust.mesh`.
        key: String,
        /// Model or PC2 file.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// A mesh file is invalid.
    #[error(transparent)]
    Mesh(#[from] ModelError),
    /// A body or a link cannot be built, or one of its selections takes no vertices.
    #[error("{}: {source}", Escaped(key))]
    Body {
        /// Key of the body, pin, handle or link in the scene: `body.bust`, `body.bust.pin.0`, `link.0`.
        key: String,
        /// Cause.
        source: supple::Error,
    },
    /// The mesh of a collider cannot be read, or is invalid.
    #[error("`{}`: {source}", Escaped(key))]
    ColliderFile {
        /// Key of the file in the scene: `collider.0.mesh`.
        key: String,
        /// Cause.
        source: Box<ModelError>,
    },
    /// The mesh of a collider has no surface.
    #[error("`{}`, {}: {source}", Escaped(key), Escaped(path.display()))]
    ColliderMesh {
        /// Key of the file in the scene: `collider.0.mesh`.
        key: String,
        /// Model file.
        path: PathBuf,
        /// Cause.
        source: ColliderFault,
    },
    /// The animation of a handle does not fit its body, or has invalid positions.
    #[error("`{}`, {}: the animation is invalid: {source}", Escaped(key), Escaped(path.display()))]
    HandleAnimation {
        /// Key of the file in the scene: `body.bust.handle.0.follow`.
        key: String,
        /// PC2 file.
        path: PathBuf,
        /// Cause.
        source: AnimationError,
    },
    /// The animation of a collider or a handle cannot be read.
    #[error("`{}`: cannot read {}: {source}", Escaped(key), Escaped(path.display()))]
    Animation {
        /// Key of the file in the scene: `collider.0.animation`.
        key: String,
        /// PC2 file.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// The simulation cannot be built.
    #[error(transparent)]
    Simulation(supple::Error),
    /// An option of the job is out of range.
    #[error("`{option}` is {value}; it must be {range}")]
    Option {
        /// Name of the option, a field of [`Job`](super::Job).
        option: &'static str,
        /// Value found.
        value: String,
        /// Valid range.
        range: &'static str,
    },
    /// A frame cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The extension of the statistics file is neither `.csv` nor `.json`.
    #[error("the name of the statistics file {} must end in .csv or .json", Escaped(path.display()))]
    StatsName {
        /// Statistics file.
        path: PathBuf,
    },
    /// The statistics file is an input, which it would replace.
    #[error(
        "the statistics file {} is the input {}, which would be lost; choose another name",
        Escaped(path.display()),
        Escaped(input.display())
    )]
    StatsIsInput {
        /// Statistics file.
        path: PathBuf,
        /// Input file.
        input: PathBuf,
    },
    /// The statistics file has the name of the manifest.
    #[error(
        "the statistics file {} would be the manifest of the run, which lists its files; choose another name",
        Escaped(path.display())
    )]
    StatsIsManifest {
        /// Statistics file.
        path: PathBuf,
    },
    /// A file with the name of the manifest was not written by a run.
    #[error(
        "{} is not the manifest of a run, which would replace it; move the file, or choose another output directory",
        Escaped(path.display())
    )]
    ForeignManifest {
        /// The file.
        path: PathBuf,
    },
    /// The statistics file of an earlier run cannot be continued.
    #[error(
        "cannot continue the statistics in {}: {problem}, so that the rows of frames {first} to {last} would be \
         missing; restore the file, or run without resuming to start again",
        Escaped(path.display())
    )]
    StatsLost {
        /// Statistics file.
        path: PathBuf,
        /// Problem, part of the message.
        problem: String,
        /// Number of the first frame in the lost rows.
        first: u64,
        /// Number of the last frame in the lost rows.
        last: u64,
    },
    /// The output directory is a file.
    #[error("the output directory {} is a file; choose a directory", Escaped(path.display()))]
    OutputIsAFile {
        /// The file.
        path: PathBuf,
    },
    /// No file can be created in the output directory.
    #[error(
        "cannot write to the output directory {}: {source}; choose another directory, or make it writable",
        Escaped(path.display())
    )]
    NotWritable {
        /// The directory.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// Another run writes to the output directory.
    #[error(
        "another run has locked {}; wait until it ends, or choose another output directory (a killed run \
         releases its lock)",
        Escaped(path.display())
    )]
    Locked {
        /// Lock file.
        path: PathBuf,
    },
    /// The observer stopped the job while the simulation was built.
    #[error("the run was stopped before its first frame")]
    Stopped,
    /// The checkpoint cannot be used.
    #[error(
        "cannot resume from {}: {}; run without resuming to start again",
        Escaped(path.display()),
        Escaped(what)
    )]
    Checkpoint {
        /// Checkpoint file.
        path: PathBuf,
        /// Problem, part of the message.
        what: String,
    },
    /// The checkpoint belongs to a run with another motion, other files or another version of the program.
    #[error(
        "cannot resume from {}: {}; undo the change, or run without resuming to start again",
        Escaped(path.display()),
        Escaped(difference)
    )]
    Differs {
        /// Checkpoint file.
        path: PathBuf,
        /// First difference between the run of the checkpoint and this run.
        difference: String,
    },
    /// A run cannot continue from a kept state.
    #[error(
        "cannot continue from {}: {}; {}run from frame 0 to start again",
        Escaped(path.display()),
        Escaped(what),
        if *is_change { "undo the change, or " } else { "" }
    )]
    From {
        /// Kept state or checkpoint.
        path: PathBuf,
        /// Problem, part of the message.
        what: String,
        /// Whether the problem is a change since the state was kept.
        is_change: bool,
    },
    /// There is no kept state from which a run can continue.
    #[error(
        "there is no state at or before frame {from}: {}; run from frame 0, with `output.states = 30` to keep a state every \
         30 frames",
        first_state(directory, *first)
    )]
    NoState {
        /// Directory of the frames.
        directory: PathBuf,
        /// Frame to continue from.
        from: u64,
        /// Frame of the first state in the directory.
        first: Option<u64>,
    },
    /// A file operation failed while the job ran.
    #[error("cannot {action} {}: {source}", Escaped(path.display()))]
    Io {
        /// Attempted operation, for example `"write"` or `"create"`.
        action: &'static str,
        /// File or directory of the operation.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
}

/// Describes the first state of a directory.
fn first_state(directory: &Path, first: Option<u64>) -> String {
    let directory = Escaped(directory.display());
    match first {
        Some(first) => format!("the first one in {directory} is of frame {first}"),
        None => format!("{directory} has none"),
    }
}

impl From<ObjError> for RunError {
    fn from(error: ObjError) -> Self {
        Self::Mesh(error.into())
    }
}

impl RunError {
    /// Returns whether the cause is an invalid argument, scene, mesh or checkpoint. In this case no frame was
    /// written.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Output(error) => error.is_input(),
            other => !matches!(
                other,
                Self::Io { .. } | Self::Locked { .. } | Self::NotWritable { .. } | Self::Stopped
            ),
        }
    }

    /// Returns why an earlier run cannot be continued, if this is the error and a new run can start.
    pub(super) fn restart_reason(&self) -> Option<String> {
        match self {
            Self::Checkpoint { path, what: problem } | Self::Differs { path, difference: problem } => {
                Some(format!("cannot resume from {}: {problem}", path.display()))
            }
            Self::StatsLost { path, problem, .. } => {
                Some(format!("cannot continue the statistics in {}: {problem}", path.display()))
            }
            Self::Output(OutputError::Cache { path, reason }) => {
                Some(format!("cannot continue {}: {reason}", path.display()))
            }
            _ => None,
        }
    }

    /// Returns the error of a failed file operation.
    pub(super) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), source }
    }
}
