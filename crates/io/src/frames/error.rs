//! Errors of frame output.

use std::io;
use std::path::{Path, PathBuf};

use super::Format;
use super::format::names;
use crate::count::alternatives;
use crate::escape::Escaped;

/// Error of writing the frames of a body.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// A file operation failed, for example because of missing space, permission or directories.
    #[error("cannot {action} {}: {source}", Escaped(.path.display()))]
    Io {
        /// Attempted operation, for example `"write"` or `"rename to"`.
        action: &'static str,
        /// File or directory of the operation.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A frame, checkpoint or lock would replace an input file.
    #[error(
        "{} is an input, and the output would replace it: choose another output directory or body name",
        Escaped(.path.display())
    )]
    OverwritesInput {
        /// Input file.
        path: PathBuf,
    },
    /// The names of the files of a body would be too long.
    #[error(
        "body `{}`: the names of its files would have up to {length} bytes, and at most {max} are \
         possible; give the body a shorter name",
        Escaped(.name)
    )]
    NameTooLong {
        /// Name of the body.
        name: String,
        /// Length of the longest name, in bytes, with the suffix of an incomplete file.
        length: usize,
        /// Largest possible length, in bytes.
        max: usize,
    },
    /// A file that must be opened for writing is a symbolic link.
    #[error(
        "{} is a symbolic link, and links are not followed for writing: remove it, or replace it by the file \
         that it leads to",
        Escaped(.path.display())
    )]
    Link {
        /// The link.
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
    /// A [`FrameWriter`](super::FrameWriter) does not write the format, whose files need more than the surface of a body.
    #[error("a frame writer writes obj, ply or pc2; for {format} run a job instead")]
    NotPerBody {
        /// The format.
        format: Format,
    },
    /// The texels of the frames of a body do not fit into an image.
    #[error(
        "body `{}`: {vertices} vertices in {frames} frames are more texels than an image of {max} x {max} has; write \
         fewer frames with --every or --frames, or take a mesh with fewer vertices",
        Escaped(.body)
    )]
    Texels {
        /// Name of the body.
        body: String,
        /// Number of vertices, with those that are split.
        vertices: usize,
        /// Number of frames.
        frames: usize,
        /// Largest width and height of an image.
        max: usize,
    },
    /// Files of two bodies would have the same name.
    #[error("two bodies would write {}; give one of them another name", Escaped(.path.display()))]
    SamePath {
        /// The file.
        path: PathBuf,
    },
    /// A file that needs frames has none.
    #[error("{} is not written: it has no frames; record at least one", Escaped(.path.display()))]
    NoFrames {
        /// The file.
        path: PathBuf,
    },
    /// A body can break, and the format has the same faces in all frames.
    #[error(
        "body `{0}` can break (`body.{0}.fracture`), and {format} has the same faces in all frames: write \
         {others}, or remove the key",
        Escaped(.body),
        others = with_topology()
    )]
    CanBreak {
        /// Name of the body.
        body: String,
        /// The format.
        format: Format,
    },
    /// A body is broken, and the format has the same faces in all frames.
    #[error(
        "frame {frame} is not written: body `{}` is broken, and {format} has the same faces in all frames; write \
         {others}",
        Escaped(.body),
        others = with_topology()
    )]
    Broken {
        /// Number of the frame.
        frame: u64,
        /// Name of the body.
        body: String,
        /// The format.
        format: Format,
    },
    /// The name of a recording has another extension than the formats that contain all bodies.
    #[error("{}: the name of a recording ends in {}", Escaped(.path.display()), recorded())]
    NoRecording {
        /// The name.
        path: PathBuf,
    },
    /// A body without a mesh cannot be recorded.
    #[error("body `{}` is a bare lattice, and recordings show meshes: build the body from a mesh", Escaped(.body))]
    NoMesh {
        /// Name of the body.
        body: String,
    },
    /// A point cache, a stage or a page cannot be continued.
    #[error(
        "cannot continue {}: {}; write the sequence again from its first frame",
        Escaped(.path.display()),
        Escaped(.reason)
    )]
    Cache {
        /// Point cache, stage, page or its data.
        path: PathBuf,
        /// Reason, a clause of the message.
        reason: String,
    },
}

impl OutputError {
    /// Returns whether the cause is the input of the writer. In this case nothing was written.
    pub fn is_input(&self) -> bool {
        matches!(
            self,
            Self::OverwritesInput { .. }
                | Self::NameTooLong { .. }
                | Self::Link { .. }
                | Self::NotPerBody { .. }
                | Self::Texels { .. }
                | Self::SamePath { .. }
                | Self::NoFrames { .. }
                | Self::CanBreak { .. }
                | Self::NoRecording { .. }
                | Self::NoMesh { .. }
        )
    }

    /// Returns a function for `map_err` that adds the attempted `action` and its `path` to an I/O error.
    pub(crate) fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { action, path: path.to_owned(), source }
    }
}

/// Returns the names of the formats that show broken bodies, for messages.
fn with_topology() -> String {
    names(Format::ALL.into_iter().filter(|format| format.has_topology_per_frame()))
}

/// Returns the extensions of recordings, for messages.
fn recorded() -> String {
    let formats = Format::ALL.into_iter().filter(|format| format.is_per_run());
    let extensions: Vec<String> = formats.map(|format| format!(".{}", format.extension())).collect();
    alternatives(&extensions.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Returns an error if a position of frame `frame` is not finite.
pub(super) fn check_finite(frame: u64, positions: &[[f32; 3]]) -> Result<(), OutputError> {
    let is_finite = |point: &[f32; 3]| point.iter().all(|number| number.is_finite());
    match positions.iter().position(|point| !is_finite(point)) {
        Some(vertex) => Err(OutputError::NotFinite { frame, vertex }),
        None => Ok(()),
    }
}
